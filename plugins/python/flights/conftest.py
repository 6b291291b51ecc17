"""Components and flights for the tests in this folder: they need the program, and componentize-py."""

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

PYTHON = Path(__file__).resolve().parents[1]
ROOT = PYTHON.parents[1]


def build(folder, output):
    """Runs the builder as an author does."""
    return subprocess.run(
        [sys.executable, "-m", "backseat_sdk.build", str(folder), "-o", str(output)],
        env={**os.environ, "PYTHONPATH": str(PYTHON)},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(scope="session")
def plugins(tmp_path_factory):
    """The folder with the components."""
    folder = tmp_path_factory.mktemp("plugins")
    for source, name in (("template", "template-python"), ("thermocline", "thermocline"), ("tests/faulty", "faulty")):
        built = build(PYTHON / source, folder / f"{name}.wasm")
        assert built.returncode == 0, built.stderr
        print(built.stdout, end="")
    return folder


@dataclass
class Flight:
    code: int
    stdout: str
    stderr: str
    log: Path

    @property
    def report(self):
        return json.loads(self.stdout)

    @property
    def lines(self):
        """What the plugin logged, from `backseat log show`."""
        return run(["log", "show", str(self.log)]).stdout


def commands(page, done=()):
    """The lines of a page's shell blocks, but for those that begin like something that is done already."""
    inside, found = False, []
    for line in (ROOT / page).read_text(encoding="utf-8").splitlines():
        if line.startswith("```"):
            inside = line == "```sh"
        elif inside and not (done and line.startswith(done)):
            found.append(line)
    return found


def run(arguments):
    program = os.environ.get("BACKSEAT_TEST_PROGRAM")
    assert program, "set BACKSEAT_TEST_PROGRAM to the program backseat, or run `cargo xtask python`"
    return subprocess.run([program, *arguments], capture_output=True, text=True, check=False)


@pytest.fixture(scope="session", autouse=True)
def cache(tmp_path_factory):
    """A cache of compiled components for these tests alone."""
    folder = tmp_path_factory.mktemp("cache")
    os.environ["BACKSEAT_CACHE"] = str(folder)
    return folder


@pytest.fixture(scope="session")
def fly(plugins, tmp_path_factory):
    """Flies a copy of a mission in simulation: `edits` are texts of its mission.toml to replace."""

    def fly(name, *arguments, edits=(), sets=()):
        folder = tmp_path_factory.mktemp("flight")
        mission = folder / name
        shutil.copytree(ROOT / "missions" / name, mission)
        text = (mission / "mission.toml").read_text(encoding="utf-8")
        for before, after in edits:
            assert before in text, before
            text = text.replace(before, after)
        (mission / "mission.toml").write_text(text, encoding="utf-8")
        log = folder / "run.mcap"
        given = ["sim", str(mission), "--plugins", str(plugins), "--json", "--log", str(log), *arguments]
        for each in sets:
            given += ["--set", each]
        done = run(given)
        return Flight(done.returncode, done.stdout, done.stderr, log)

    return fly
