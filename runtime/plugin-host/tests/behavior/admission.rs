use std::sync::{Arc, OnceLock};
use std::time::Duration;

use backseat_plugin_host::{Budget, Component, Host, HostError};

use crate::fixture::{Latitude, brief, components};

/// Compiles it, each time.
fn load(bytes: &[u8]) -> Result<Component, HostError> {
    static HOST: OnceLock<Host> = OnceLock::new();
    HOST.get_or_init(|| Host::new().unwrap()).load("odd", bytes)
}

/// The one-line error with which a file is refused.
fn refusal(bytes: &[u8]) -> String {
    let line = load(bytes).err().expect("refused").to_string();
    assert!(!line.contains('\n'), "{line}");
    line
}

fn wat(text: &str) -> Vec<u8> {
    wat::parse_str(text).unwrap()
}

/// A component with the five exports, of no parameters and no results.
const UNTYPED: &str = r#"
    (component
        (core module $m (func (export "f")))
        (core instance $i (instantiate $m))
        (func $f (canon lift (core func $i "f")))
        (export "describe" (func $f))
        (export "init" (func $f))
        (export "step" (func $f))
        (export "snapshot" (func $f))
        (export "restore" (func $f)))"#;

#[test]
fn a_file_that_is_no_component_is_refused_with_what_it_is() {
    assert_eq!(refusal(b""), "odd: the file is empty, expected a WebAssembly component");
    assert_eq!(
        refusal(b"(component)"),
        "odd: not WebAssembly (it does not begin with `\\0asm`), expected a component"
    );
    assert_eq!(
        refusal(&wat("(module)")),
        "odd: a core module, expected a component: `backseat plugin build` or `wasm-tools component new` makes one"
    );
    let huge = vec![0; backseat_plugin_host::COMPONENT_BYTES + 1];
    assert_eq!(refusal(&huge), "odd: 33554433 bytes, expected at most 33554432");
    let without_cache = Host::new().unwrap();
    let in_no_time = without_cache.load_within("odd", &components().template_bytes, 1 << 20, Duration::ZERO);
    let line = in_no_time.err().unwrap().to_string();
    assert!(
        line.starts_with("odd: took longer than 0 s to compile: try again"),
        "{line}"
    );
}

#[test]
fn a_truncated_component_is_refused() {
    let whole = &components().template_bytes;
    for part in 1..20 {
        let line = refusal(&whole[..whole.len() * part / 20]);
        assert!(line.starts_with("odd: not a valid component: "), "{line}");
    }
}

#[test]
fn a_damaged_component_never_panics() {
    let whole = &components().template_bytes;
    for place in (8..whole.len()).step_by(whole.len() / 10) {
        let mut damaged = whole.clone();
        damaged[place] ^= 0x55;
        // Some of the bytes are data, so that changing them gives another valid component.
        drop(load(&damaged));
    }
}

#[test]
fn other_imports_are_refused_by_name() {
    assert_eq!(
        refusal(&wat(r#"(component (import "wasi:cli/environment@0.2.0" (instance)))"#)),
        "odd: imports wasi:cli/environment@0.2.0, but a plugin may import only log, fence and measures of backseat:plugin@0.2.0 or @0.1.0"
    );
    assert_eq!(
        refusal(&wat(r#"(component (import "backseat:plugin/log@0.3.0" (instance)))"#)),
        "odd: imports backseat:plugin/log@0.3.0, but a plugin may import only log, fence and measures of backseat:plugin@0.2.0 or @0.1.0"
    );
}

#[test]
fn a_component_that_is_no_plugin_is_refused() {
    assert_eq!(
        refusal(&wat("(component)")),
        "odd: does not export describe, init, step, snapshot, restore: expected a plugin (in Rust, `backseat_sdk::export!(TYPE)` once)"
    );
    let without_step = UNTYPED.replace(r#"(export "step" (func $f))"#, "");
    assert_eq!(
        refusal(&wat(&without_step)),
        "odd: does not export step: expected a plugin (in Rust, `backseat_sdk::export!(TYPE)` once)"
    );
}

#[test]
fn exports_of_other_types_are_refused_at_the_latest_at_the_start() {
    let error = load(&wat(UNTYPED))
        .and_then(|component| component.start(Budget::default(), &brief("{}"), Arc::new(Latitude)))
        .err()
        .expect("refused");
    assert!(matches!(error, HostError::Interface { .. }), "{error}");
    assert!(
        error
            .to_string()
            .starts_with("odd: does not match the interface backseat:plugin@0.2.0: "),
        "{error}"
    );
}

#[test]
fn webassembly_features_that_differ_between_machines_are_off() {
    let relaxed = r#"(component (core module (func (param v128 v128 v128) (result v128)
        (f64x2.relaxed_madd (local.get 0) (local.get 1) (local.get 2)))))"#;
    let threads = r#"(component (core module (memory 1 1 shared)))"#;
    let wide = r#"(component (core module (memory i64 1)))"#;
    for (what, text) in [("relaxed SIMD", relaxed), ("threads", threads), ("64-bit memory", wide)] {
        let line = refusal(&wat(text));
        assert!(line.starts_with("odd: not a valid component: "), "{what}: {line}");
    }
}
