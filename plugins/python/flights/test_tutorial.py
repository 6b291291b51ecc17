"""The commands of the tutorial, run as they stand there in a folder outside of this project."""

import os
import subprocess
import sys

from conftest import ROOT, commands

PAGE = "runtime/docs/adaptive-lawnmower-in-python.md"


def numbers(said, name):
    return [float(line.split()[1]) for line in said.splitlines() if line.split()[:1] == [name]]


def test_the_adaptive_lawnmower_flies_as_its_tutorial_says(tmp_path):
    program = tmp_path / "bin/backseat"
    program.parent.mkdir()
    program.symlink_to(os.environ["BACKSEAT_TEST_PROGRAM"])
    done = subprocess.run(
        ["bash", "-eu", "-o", "pipefail", "-c", "\n".join(commands(PAGE))],
        cwd=tmp_path,
        env={
            **os.environ,
            "PATH": f"{program.parent}:{os.environ['PATH']}",
            "PYTHON": sys.executable,
            "BACKSEAT_KIT": str(tmp_path / "kit"),
            "BACKSEAT_CACHE": str(tmp_path / "cache"),
        },
        capture_output=True,
        text=True,
        check=False,
    )
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    assert "unit tests passed, 5 of 5 flights met what is expected" in said, said
    assert "degrees, so 30 m on" in said, said
    # The flight with the map, and then pairs: the adaptive lawnmower, and even lines over the same sea.
    shares = numbers(done.stdout, "lawnmower.warm_share")
    assert len(shares) == 11, said
    for adaptive, even in zip(shares[1::2], shares[2::2]):
        assert adaptive > 1.25 * even, shares
    *first, last = (f"{adaptive:.0f}" for adaptive in shares[1::2])
    told = f"{', '.join(first)} and {last} % of the adaptive survey is in warm water"
    assert told in (ROOT / PAGE).read_text(encoding="utf-8"), shares
    assert numbers(done.stdout, "lawnmower.lines") == [7.0, 4.0, 11.0], said
    assert (tmp_path / "lawnmower/adaptive.svg").read_text(encoding="utf-8").startswith("<svg")
