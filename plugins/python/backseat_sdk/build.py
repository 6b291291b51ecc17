"""Makes a component of a plugin: ``python -m backseat_sdk.build DIR -o NAME.wasm``.

It needs componentize-py 0.25 in the same Python environment, and nothing else. The component has all that the plugin
imports while it is built, and the state of its modules at that moment. Its imports are checked: it must need nothing
but the runtime's own interface.
"""

from __future__ import annotations

import argparse
import ast
import importlib.metadata
import importlib.util
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from .component_file import BadComponent, names

#: The version of componentize-py that this SDK was tested with.
COMPONENTIZE = "0.25.1"
#: The folder of `wit/`, and the interface in it; `_wit.py` depends on them.
VERSION, PACKAGE, WORLD = "v0.2.0", "backseat:plugin", "plugin"
EXPORTS = {"describe", "init", "step", "snapshot", "restore"}
#: The largest component that the runtime loads, bytes.
COMPONENT_BYTES = 32 << 20
#: The module that componentize-py runs. Its name must not be that of a world or of an author's module.
ENTRY = "backseat_entry"
ENTRY_TEXT = """\
import sys
sys.dont_write_bytecode = True
from backseat_sdk import _sandbox
_sandbox.before_import()
import {module}
from backseat_sdk import _component
WitWorld = _component.world(_component.find({module}, {name!r}))
_sandbox.after_import()
"""
#: Where componentize-py mounts the author's folder and the SDK's: by their order on its command line. Later ones have the
#: packages of the Python environment.
AUTHORS_FOLDER, SDK_FOLDER = 1, 2
NO_PACKAGES = (
    "a plugin has Python's standard library and the modules beside it; no other package runs in the sandbox, numpy neither"
)
#: How long componentize-py may take, seconds. On an idle computer it takes about ten.
WITHIN_S = 300.0
#: After this long the author is told that componentize-py still works, seconds.
TOLD_AFTER_S = 45.0
#: Runs componentize-py as its own script does.
SCRIPT = "from componentize_py import script; script()"


class BuildError(Exception):
    """Why a plugin could not be built, in one line."""


def build(
    folder: Path,
    output: Path,
    module: str = "plugin",
    name: str | None = None,
    wit: Path | None = None,
    within_s: float = WITHIN_S,
) -> None:
    """Builds the plugin of a folder. ``name`` is that of its class, where the module has more than one.

    Raises ``BuildError``. If an exception went through several of the author's lines, they go to standard error first.
    """
    _check_sources(folder, module)
    interface = wit or _interface()
    if not (interface / "plugin.wit").is_file():
        raise BuildError(f"{interface}: no plugin.wit there; give the folder of the interface with --wit")
    _check_componentize()
    package = Path(__file__).resolve().parent
    # Built beside its place, so that a failure leaves no half of a component.
    output.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="backseat-build-") as entry:
        Path(entry, f"{ENTRY}.py").write_text(ENTRY_TEXT.format(module=module, name=name), encoding="utf-8")
        draft = output.with_name(f".{output.name}.{os.getpid()}")
        paths = [path for each in (entry, str(folder.resolve()), str(package.parent)) for path in ("-p", each)]
        command = [sys.executable, "-c", SCRIPT, "-q", "-d", str(interface), "-w", WORLD]
        command += ["componentize", "--stub-wasi", *paths, "-o", str(draft), ENTRY]
        try:
            code, said = _ended(command, within_s)
            if code != 0:
                said = _printable(said)
                package = _foreign(said)
                if package is None and len(_own(said)) > 1:
                    sys.stderr.write(_traceback(said))
                raise BuildError(f"{folder}: {_why(said, package)}")
            check_component(draft)
            os.replace(draft, output)
        except subprocess.TimeoutExpired:
            raise BuildError(
                f"{folder}: not built within {within_s:g} s: is there a loop without end in {module}.py, outside its functions "
                "or in describe or snapshot? On a slow computer, python -m backseat_sdk.build has --within S"
            ) from None
        finally:
            draft.unlink(missing_ok=True)


def _ended(command: list[str], within_s: float) -> tuple[int, str]:
    """Runs a command. Returns its exit code and what it said on standard error.

    Raises ``subprocess.TimeoutExpired`` if it does not end in time; then it is ended.
    """
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace"
    ) as process:
        try:
            try:
                _, said = process.communicate(timeout=min(TOLD_AFTER_S, within_s))
            except subprocess.TimeoutExpired:
                if within_s <= TOLD_AFTER_S:
                    raise
                print(
                    f"backseat_sdk.build: componentize-py still works after {TOLD_AFTER_S:g} s, and may for {within_s:g} s",
                    file=sys.stderr,
                )
                _, said = process.communicate(timeout=within_s - TOLD_AFTER_S)
        except BaseException:
            process.kill()
            raise
    return process.returncode, said


def check_component(path: Path) -> set[str]:
    """Checks that a component needs nothing but the runtime's interface, and returns what it imports.

    Raises ``BuildError`` with what is wrong.
    """
    data = path.read_bytes()
    if len(data) > COMPONENT_BYTES:
        raise BuildError(
            f"{path}: {len(data) / 2**20:.1f} MiB, and the runtime loads at most {COMPONENT_BYTES >> 20}: import less"
        )
    try:
        imports, exports = names(data)
    except BadComponent as error:
        raise BuildError(f"{path}: no component: {error}") from None
    foreign = sorted(each for each in imports if not each.startswith(f"{PACKAGE}/"))
    if foreign:
        raise BuildError(f"{path}: imports {', '.join(foreign)}, which the runtime does not have; was it stubbed?")
    missing = sorted(EXPORTS - exports)
    if missing:
        raise BuildError(f"{path}: exports no {', '.join(missing)}")
    return imports


def _interface() -> Path:
    """The folder with the interface: beside the SDK, or in the project that the SDK is a part of."""
    package = Path(__file__).resolve().parent
    for folder in (package / "wit" / VERSION, package.parents[2] / "wit" / VERSION):
        if folder.is_dir():
            return folder
    raise BuildError(f"no folder wit/{VERSION} beside {package}; give it with --wit")


def _check_sources(folder: Path, module: str) -> None:
    """Finds what would otherwise be a long traceback: no module, or a module that is no Python."""
    if not folder.is_dir():
        raise BuildError(f"{folder}: no such folder")
    found = [path for path in (folder / f"{module}.py", folder / module / "__init__.py") if path.is_file()]
    if not found:
        raise BuildError(f"{folder}: no {module}.py; name another module with --module")
    for path in _python_files(folder):
        _parsed(path)
    for path in sorted(folder.iterdir()):
        is_module = path.suffix == ".py" or (path / "__init__.py").is_file()
        if is_module and path.stem in sys.stdlib_module_names:
            raise BuildError(
                f"{path}: Python's standard library has a module of this name, which it would replace: rename it"
            )
    _check_imports(folder, found[0], {found[0]})


def _parsed(path: Path) -> ast.Module:
    try:
        return ast.parse(path.read_text(encoding="utf-8"), str(path))
    except SyntaxError as error:
        line = f":{error.lineno}" if error.lineno else ""
        raise BuildError(f"{path}{line}: {error.msg}") from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise BuildError(f"{path}:{line}: not UTF-8 (byte {error.object[error.start]:#04x})") from None
    except (ValueError, RecursionError) as error:
        raise BuildError(f"{path}: {error}") from None


def _check_imports(folder: Path, path: Path, seen: set[Path]) -> None:
    """Finds a package that this Python lacks among what a source, and each module beside it that it needs, always imports."""
    for statement in _parsed(path).body:
        if isinstance(statement, ast.Import):
            tops = {each.name.partition(".")[0] for each in statement.names}
        elif isinstance(statement, ast.ImportFrom) and statement.level == 0 and statement.module:
            tops = {statement.module.partition(".")[0]}
        else:
            continue
        for top in sorted(tops):
            beside = [path for path in (folder / f"{top}.py", folder / top) if path.exists()]
            if not beside and importlib.util.find_spec(top) is None:
                raise BuildError(f"{path}:{statement.lineno}: no module named {top!r} ({NO_PACKAGES})")
            if beside and beside[0].is_file() and beside[0] not in seen:
                seen.add(beside[0])
                _check_imports(folder, beside[0], seen)


def _python_files(folder: Path) -> Iterator[Path]:
    """The sources of a folder, without hidden folders and environments in it."""
    for path in sorted(folder.iterdir()):
        if path.name.startswith(".") or (path / "pyvenv.cfg").exists():
            continue
        if path.is_dir():
            yield from _python_files(path)
        elif path.suffix == ".py" and path.is_file():
            yield path


def _check_componentize() -> None:
    wanted = COMPONENTIZE.rpartition(".")[0]
    try:
        found = importlib.metadata.version("componentize-py")
    except importlib.metadata.PackageNotFoundError:
        found = "none"
    if found != wanted and not found.startswith(f"{wanted}."):
        raise BuildError(
            f"componentize-py {wanted} is needed and {found} is installed: "
            f"{sys.executable} -m pip install componentize-py=={COMPONENTIZE}"
        )


def _traceback(said: str) -> str:
    """The traceback of the plugin's own import in componentize-py's output; all of the output, if there is none."""
    _, found, inner = said.partition("AssertionError: Traceback")
    if not found:
        return said
    return "Traceback" + inner.partition("\n\n\n")[0].rstrip() + "\n"


def _printable(said: str) -> str:
    """What the plugin says may drive a terminal."""
    return "".join(each if each in "\n\t" or each.isprintable() else ascii(each)[1:-1] for each in said)


def _own(said: str) -> list[tuple[str, str]]:
    """The author's places among them: file and line."""
    return [(file, line) for folder, file, line in _places(said) if folder == AUTHORS_FOLDER]


def _places(said: str) -> list[tuple[int, str, str]]:
    """Where an import has failed, outermost first: the number of the folder as componentize-py mounts it, file and line."""
    places = re.findall(r'File "/(\d+)/([^"]+)", line (\d+)', _traceback(said))
    return [(int(folder), file, line) for folder, file, line in places]


def _foreign(said: str) -> str | None:
    """The package of somebody else in whose code the import has failed."""
    places = _places(said)
    return places[-1][1].partition("/")[0] if places and places[-1][0] > SDK_FOLDER else None


def _why(said: str, package: str | None) -> str:
    """The line that says why: the end of the traceback, with the innermost place in the author's files."""
    _, found, last = _traceback(said).rpartition("Traceback (most recent call last):")
    own = _own(said)
    where = f"{own[-1][0]}:{own[-1][1]}: " if own else ""
    if package is not None:
        return f"{where}{package} does not run in the sandbox: {NO_PACKAGES}"
    ends = [line for line in last.splitlines() if line and not line[0].isspace()]
    if not found or not ends:
        return said.strip().splitlines()[-1] if said.strip() else "componentize-py failed without a word"
    why = ends[0]
    if why.strip() in ("AssertionError", "AssertionError:"):
        return f"{where}the program was ended while the module was imported, as sys.exit and os._exit do"
    if why.startswith("ModuleNotFoundError"):
        why += f" ({NO_PACKAGES})"
    return where + why


def main(arguments: list[str] | None = None) -> int:
    """The command line; the exit code is 0, or 1 after one line that says what is wrong."""
    parser = argparse.ArgumentParser(prog="python -m backseat_sdk.build", description="Build a plugin's component")
    parser.add_argument("folder", metavar="DIR", type=Path, help="the folder with the plugin")
    task = parser.add_mutually_exclusive_group(required=True)
    task.add_argument("-o", "--output", metavar="NAME.wasm", type=Path, help="the component to write")
    task.add_argument("--check", action="store_true", help="only check the sources; build nothing")
    parser.add_argument("--module", default="plugin", help="the module with the plugin's class [default: plugin]")
    parser.add_argument("--class", dest="name", help="the plugin's class, if the module has several")
    parser.add_argument(
        "--within", metavar="S", type=float, default=WITHIN_S, help="how long it may take, seconds [default: 300]"
    )
    parser.add_argument("--wit", metavar="DIR", type=Path, help="the folder with plugin.wit [default: the SDK's own]")
    given = parser.parse_args(arguments)
    began = time.monotonic()
    try:
        if given.check:
            _check_sources(given.folder, given.module)
            return 0
        build(given.folder, given.output, given.module, given.name, given.wit, given.within)
    except (BuildError, OSError) as error:
        print(f"backseat_sdk.build: {error}", file=sys.stderr)
        return 1
    size = given.output.stat().st_size / 2**20
    print(f"{given.output}: {size:.1f} MiB, in {time.monotonic() - began:.1f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
