"""`backseat plugin` for plugins in Python, in a folder outside of this project."""

import os
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("author")


def backseat(place, *arguments, within="."):
    return subprocess.run(
        [os.environ["BACKSEAT_TEST_PROGRAM"], *arguments],
        cwd=place / within,
        env={
            **os.environ,
            # This environment has componentize-py and pytest, so that nothing is installed.
            "PYTHON": sys.executable,
            "BACKSEAT_KIT": str(place / "kit"),
            "BACKSEAT_CACHE": str(place / "cache"),
        },
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_new_plugin_is_tested_built_and_flown(place):
    made = backseat(place, "plugin", "new", "drift", "--lang", "python")
    assert made.returncode == 0, made.stderr
    assert "drift/plugin.py" in made.stdout
    tested = backseat(place, "plugin", "test", "--seeds", "2", within="drift")
    said = tested.stdout + tested.stderr
    assert tested.returncode == 0, said
    assert "5 passed" in said
    assert "drift: unit tests passed, 2 of 2 flights met what is expected" in said
    inspected = backseat(place, "plugin", "inspect", "--json", within="drift")
    assert inspected.returncode == 0, inspected.stderr
    assert '"drift"' in inspected.stdout and "wasi" in inspected.stdout
    assert not list((place / "kit").rglob("__pycache__")), "the kit stays as it was unpacked"


def test_the_report_remarks_a_component_that_is_older_than_its_source(place):
    source = place / "drift/plugin.py"
    source.write_text(source.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    report = backseat(place, "plugin", "check", "--seeds", "1", within="drift")
    assert report.returncode == 0, report.stdout + report.stderr
    assert "remark: drift.wasm is older than" in report.stdout


def test_what_an_author_does_wrong_is_said_in_a_line(place):
    folder = place / "drift"
    source = folder / "plugin.py"
    good = source.read_text(encoding="utf-8")
    for bad, told in [
        (good.replace("def step(self, input):", "def step(self, input)"), "plugin.py:"),
        ("import numpy\n" + good, "numpy"),
    ]:
        source.write_text(bad, encoding="utf-8")
        built = backseat(place, "plugin", "build", within="drift")
        assert built.returncode == 2, built.stdout
        assert told in built.stderr, built.stderr
        assert built.stderr.strip().splitlines()[-1].endswith(".: not built: the line above says why")
    source.write_text(good.replace("heading_deg,", "depth_m,"), encoding="utf-8")
    tested = backseat(place, "plugin", "test", within="drift")
    assert tested.returncode == 1, tested.stderr
    assert "the unit tests failed" in tested.stdout
    source.write_text(good, encoding="utf-8")
    Path(folder, "pyproject.toml").rename(folder / "pyproject.old")
    lost = backseat(place, "plugin", "build", within="drift")
    assert lost.returncode == 2
    assert "no Cargo.toml or pyproject.toml here" in lost.stderr
