"""The builder's checks that need no build."""

import os

import pytest
from backseat_sdk import build
from backseat_sdk.component_file import BadComponent, names

PREAMBLE = b"\0asm\x0d\0\x01\0"


def text(name):
    return bytes([len(name)]) + name.encode()


def section(number, *entries):
    content = bytes([len(entries)]) + b"".join(entries)
    return bytes([number, len(content)]) + content


def an_import(name, kind=5):
    # An instance type's index; for a type, the bound `eq` with an index.
    return b"\0" + text(name) + (bytes([kind, 0]) if kind != 3 else bytes([3, 0, 7]))


def an_export(name):
    return b"\0" + text(name) + bytes([1, 0, 0])


EXPORTS = section(11, *(an_export(name) for name in sorted(build.EXPORTS)))
LOG = "backseat:plugin/log@0.2.0"


def component(tmp_path, *parts):
    path = tmp_path / "x.wasm"
    path.write_bytes(PREAMBLE + b"".join(parts))
    return path


def test_a_component_that_needs_only_the_runtime_passes(tmp_path):
    custom = bytes([0, 5]) + text("abcd")
    path = component(tmp_path, custom, section(10, an_import(LOG), an_import("request", 3)), EXPORTS)
    assert build.check_component(path) == {LOG}


@pytest.mark.parametrize(
    "parts, told",
    [
        ([section(10, an_import(LOG), an_import("wasi:cli/stdin@0.2.0")), EXPORTS], "imports wasi:cli/stdin@0.2.0, "),
        ([section(10, an_import(LOG)), section(11, an_export("step"))], "exports no describe, init, restore, snapshot"),
        ([bytes([10, 90, 1])], "no component: section 10 at byte 10 is longer than the file"),
        ([section(10, b"\x07" + text("x"))], "no component: a name of an unknown kind, 7"),
    ],
)
def test_any_other_is_refused(tmp_path, parts, told):
    with pytest.raises(build.BuildError, match="x.wasm: ") as refused:
        build.check_component(component(tmp_path, *parts))
    assert told in str(refused.value)


def test_a_module_is_no_component():
    with pytest.raises(BadComponent, match="does not begin as one"):
        names(b"\0asm\x01\0\0\0")


def test_a_component_that_is_too_large_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(build, "COMPONENT_BYTES", 10)
    with pytest.raises(build.BuildError, match="import less"):
        build.check_component(component(tmp_path, EXPORTS))


def run(capsys, *arguments):
    code = build.main([str(argument) for argument in arguments])
    said = capsys.readouterr().err
    assert code == 1 and said.count("\n") == 1, said
    return said


def test_a_folder_without_a_plugin_is_refused_in_one_line(tmp_path, capsys):
    output = tmp_path / "out" / "x.wasm"
    assert "nowhere: no such folder" in run(capsys, tmp_path / "nowhere", "-o", output)
    assert "no plugin.py; name another module with --module" in run(capsys, tmp_path, "-o", output)
    (tmp_path / "plugin.py").write_text("def step(:\n", encoding="utf-8")
    assert "plugin.py:1: invalid syntax" in run(capsys, tmp_path, "-o", output)
    (tmp_path / "plugin.py").write_text("x = 1\n", encoding="utf-8")
    assert "no plugin.wit there" in run(capsys, tmp_path, "-o", output, "--wit", tmp_path)
    assert not output.exists()


def test_a_source_that_is_no_text_is_refused_in_one_line(tmp_path, capsys):
    (tmp_path / "plugin.py").write_bytes(b"x = 1\ny = '\xff'\n")
    assert "plugin.py:2: not UTF-8 (byte 0xff)" in run(capsys, tmp_path, "--check")
    (tmp_path / "plugin.py").write_bytes(b"x = 1\0\n")
    assert "plugin.py: source code string cannot contain null bytes" in run(capsys, tmp_path, "--check")
    (tmp_path / "plugin.py").write_text("x = 1\n", encoding="utf-8")
    os.mkfifo(tmp_path / "pipe.py")
    assert build.main([str(tmp_path), "--check"]) == 0
    (tmp_path / "types.py").write_text("x = 1\n", encoding="utf-8")
    assert "types.py: Python's standard library has a module of this name" in run(capsys, tmp_path, "--check")


def test_a_plugin_that_cannot_be_imported_is_told_in_one_line(tmp_path, capsys):
    output = tmp_path / "x.wasm"
    plugin = tmp_path / "plugin.py"
    plugin.write_text("import backseat_sdk\n", encoding="utf-8")
    assert "plugin: expected one class derived from Plugin, found none" in run(capsys, tmp_path, "-o", output)
    plugin.write_text("x = 1\nraise ValueError('a\\x1b[2Kb')\n", encoding="utf-8")
    said = run(capsys, tmp_path, "-o", output)
    assert "plugin.py:2: ValueError: a\\x1b[2Kb" in said
    described = (
        "from backseat_sdk import Description, Plugin\n\n\nclass Mine(Plugin):\n    def describe(self):\n"
        "        return Description({}, '1'{})\n\n    def step(self, input):\n        return []\n"
    )
    plugin.write_text(described.format("'a\\x07b'", ""), encoding="utf-8")
    assert "describe: name is 'a\\x07b', expected text without control characters" in run(capsys, tmp_path, "-o", output)
    plugin.write_text(described.format("'mine'", ", 1"), encoding="utf-8")
    assert "describe: step_period_ns is 1, expected 20000000 to 60000000000" in run(capsys, tmp_path, "-o", output)
    plugin.write_text(described.format("'mine'", "").replace("def step(", "def stepp("), encoding="utf-8")
    assert "TypeError: Mine has no method step" in run(capsys, tmp_path, "-o", output)
    plugin.write_text("import sys\n\nsys.exit(3)\n", encoding="utf-8")
    assert "the program was ended while the module was imported" in run(capsys, tmp_path, "-o", output)
    # Through several lines of the author's, they come first.
    plugin.write_text("def f():\n    raise ValueError('b')\n\n\nf()\n", encoding="utf-8")
    assert build.main([str(tmp_path), "-o", str(output)]) == 1
    said = capsys.readouterr().err
    assert said.startswith("Traceback") and said.endswith("plugin.py:2: ValueError: b\n"), said
    assert not output.exists()


def test_a_plugin_that_loops_while_it_is_imported_does_not_loop_for_ever(tmp_path, capsys):
    (tmp_path / "plugin.py").write_text("while True:\n    pass\n", encoding="utf-8")
    said = run(capsys, tmp_path, "-o", tmp_path / "x.wasm", "--within", "5")
    assert "not built within 5 s: is there a loop without end in plugin.py" in said
    assert [each.name for each in tmp_path.iterdir()] == ["plugin.py"]


def test_a_package_that_is_missing_is_told_before_anything_is_built_or_tested(tmp_path, capsys):
    (tmp_path / "plugin.py").write_text("import helper\nimport math\n", encoding="utf-8")
    (tmp_path / "helper.py").write_text("import json\nimport plugin\nimport no_such_package.part\n", encoding="utf-8")
    said = run(capsys, tmp_path, "--check")
    assert "helper.py:3: no module named 'no_such_package' (a plugin has Python's standard library" in said
    # What an author's own tests import runs here, and what is tried for may be missing.
    (tmp_path / "test_plugin.py").write_text("import no_such_package\n", encoding="utf-8")
    (tmp_path / "helper.py").write_text(
        "try:\n    import no_such_package\nexcept ImportError:\n    pass\n", encoding="utf-8"
    )
    assert build.main([str(tmp_path), "--check"]) == 0


def test_another_version_of_componentize_py_is_refused(tmp_path, capsys, monkeypatch):
    (tmp_path / "plugin.py").write_text("x = 1\n", encoding="utf-8")
    monkeypatch.setattr(build.importlib.metadata, "version", lambda _: "0.24.0")
    said = run(capsys, tmp_path, "-o", tmp_path / "x.wasm")
    assert f"pip install componentize-py=={build.COMPONENTIZE}" in said


def test_the_reason_is_the_end_of_the_traceback_and_its_place():
    said = (
        'Traceback (most recent call last):\n  File "<string>", line 1, in <module>\n'
        "AssertionError: Traceback (most recent call last):\n"
        '  File "/0/backseat_entry.py", line 3, in <module>\n    import plugin\n'
        '  File "/1/plugin.py", line 2, in <module>\n    import numpy\n'
        "ModuleNotFoundError: No module named 'numpy'\n\n\nCaused by:\n    x\n\nStack backtrace:\n   0: y\n"
    )
    assert build._foreign(said) is None
    why = build._why(said, None)
    assert why.startswith("plugin.py:2: ModuleNotFoundError: No module named 'numpy' (a plugin has ")
    assert why.endswith("no other package runs in the sandbox, numpy neither)")
    assert "backtrace" not in build._traceback(said)
    assert build._why("error: no such world\n", None) == "error: no such world"


def failed(*frames, why):
    lines = "".join(f'  File "{file}", line {line}, in <module>\n    x\n' for file, line in frames)
    return f"AssertionError: Traceback (most recent call last):\n{lines}{why}\n\n\nCaused by:\n    x\n"


def test_the_place_is_the_authors_even_if_the_sdk_or_a_package_raises():
    sdk = failed(
        ("/0/backseat_entry.py", 5), ("/1/plugin.py", 7), ("/2/backseat_sdk/_sandbox.py", 65), why="NotInSandbox: no clock"
    )
    assert build._foreign(sdk) is None and build._why(sdk, None) == "plugin.py:7: NotInSandbox: no clock"
    none = failed(("/0/backseat_entry.py", 7), ("/2/backseat_sdk/_component.py", 36), why="TypeError: plugin: expected one")
    assert build._why(none, None) == "TypeError: plugin: expected one"
    numpy = failed(("/1/plugin.py", 2), ("/3/numpy/_core/__init__.py", 85), why="ImportError: ")
    assert build._foreign(numpy) == "numpy"
    assert build._why(numpy, "numpy").startswith("plugin.py:2: numpy does not run in the sandbox: a plugin has ")
