#!/bin/sh
# Builds a plugin in C to a component.
#
#   ./build.sh path/to/plugin.wit steady.wasm
#
# It needs these tools. The versions in brackets are those with which it was tried.
#
#   clang, wasm-ld   apt-get install clang lld                                     (Debian 12: 14.0.6)
#   a C library      apt-get install wasi-libc libclang-rt-14-dev-wasm32           (Debian 12: 0.0~git20220510, 14.0.6)
#   wit-bindgen      cargo install wit-bindgen-cli --version 0.63.0 --locked       (0.63.0)
#   wasm-tools       cargo install wasm-tools --version 1.263.0 --locked           (1.263.0)
#
# The same versions give the same component, byte for byte. CC names another clang, SOURCE another C file.

set -eu

if [ $# -ne 2 ]; then
    echo "usage: $0 plugin.wit OUTPUT.wasm" >&2
    exit 2
fi
wit=$1
output=$2
cc=${CC:-clang}
source=${SOURCE:-$(dirname "$0")/steady.c}

for tool in "$cc" wasm-ld wit-bindgen wasm-tools; do
    if ! command -v "$tool" >/dev/null; then
        echo "$0: $tool is not installed; the head of this file says how to get it" >&2
        exit 2
    fi
done

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# plugin.h, plugin.c, and an object file with the types of the interface, which `component new` reads.
wit-bindgen c --out-dir "$folder" "$wit"

# -mexec-model=reactor: without it the linker wraps every export with code that runs at the end of a program, and that
# imports WASI. -Os: the component is small. No debug information: it has the paths of this computer.
compile="$cc --target=wasm32-wasi -std=c11 -Os -I$folder"
$compile -Wall -Wextra -Wpedantic -Werror -c -o "$folder/own.o" "$source"
$compile -c -o "$folder/bindings.o" "$folder/plugin.c"
$cc --target=wasm32-wasi -mexec-model=reactor -Wl,--strip-debug -o "$folder/core.wasm" \
    "$folder/own.o" "$folder/bindings.o" "$folder/plugin_component_type.o"

# This fails if the module imports WASI: then the C code uses a function that the sandbox does not have.
wasm-tools component new -o "$folder/component.wasm" "$folder/core.wasm"
# Remove names and the versions of tools.
wasm-tools strip --all -o "$output" "$folder/component.wasm"
