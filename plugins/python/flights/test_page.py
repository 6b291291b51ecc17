"""The commands of the page for authors, run as they stand there in a copy of the tree."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from conftest import ROOT, commands

PAGE = "runtime/docs/write-a-plugin-in-python.md"
#: What `cargo xtask python` has done already: the environment and the program.
DONE = ("cargo xtask demo", "python3 -m venv", ". target/python/", "pip install")


def test_the_page_s_commands_run_and_show_what_it_says(tmp_path):
    for folder in ("plugins/python", "missions", "wit"):
        shutil.copytree(ROOT / folder, tmp_path / folder)
    program = Path(os.environ["BACKSEAT_TEST_PROGRAM"])
    (tmp_path / "target/release").mkdir(parents=True)
    (tmp_path / "target/plugins").mkdir()
    (tmp_path / "target/release/backseat").symlink_to(program)
    # Each command with its time, so that the page's own figures can be looked at.
    script = ["set -eu"]
    for line in commands(PAGE, DONE):
        script += [
            f"began=$(date +%s%N); {line}",
            f'echo "[$((($(date +%s%N) - began) / 1000000)) ms] {line.split(" ")[0]}"',
        ]
    done = subprocess.run(
        ["bash", "-c", "\n".join(script)],
        cwd=tmp_path,
        env={
            **os.environ,
            "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
            "BACKSEAT_CACHE": str(tmp_path / "cache"),
        },
        capture_output=True,
        text=True,
        check=False,
    )
    said = done.stdout + done.stderr
    print(said)
    assert done.returncode == 0, said
    for text in (
        "5 passed",
        "target/plugins/mine.wasm: 17",
        "mine, seed 1: completed",
        "request 1: depth: 4.0 m deeper than the 36 m of keep-in zone 'bay'",
        "config: unknown key `depht_m`, did you mean `depth_m`?",
        "thermocline, seed 1: completed",
        "thermocline.depth 2",
    ):
        assert text in said, f"no {text!r} in\n{said}"
    for picture in ("mine.svg", "thermocline.svg"):
        assert (tmp_path / picture).read_text(encoding="utf-8").startswith("<svg")
