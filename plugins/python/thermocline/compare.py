"""Compares tracking with a plain yo-yo over the whole range of depths, on the same line, in the same seas.

``python compare.py BACKSEAT PLUGINS --seeds 24`` flies both in simulation, with a thermocline whose depth, thickness
and drop this script draws for each seed, and prints a table with the mean, the spread and the range over the seeds. It
needs the package ``mcap``, to read the true depths from the logs.

- ``in the layer``: the share of the CTD's samples that were truly taken within half a thickness of the thermocline's
  middle, percent.
- ``crossings``: how often the vehicle truly crossed the middle for each kilometre of its way.
- ``error of a leg``: root mean square of the error of the depth estimates that the plugin published, after the first.
- ``error at the end``: of the last estimate, by its amount.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import re
import shutil
import statistics
import subprocess
import tempfile
from pathlib import Path

from mcap.reader import make_reader

MISSION = Path(__file__).resolve().parents[3] / "missions" / "thermocline"
ROWS = {
    "in_layer": "in the layer, %",
    "crossings": "crossings, 1/km",
    "leg_error": "error of a leg, m",
    "end_error": "error at the end, m",
}


def fly(program: str, plugins: str, seed: int, mode: str, folder: Path) -> dict[str, float]:
    """One flight's figures."""
    draw = random.Random(seed)
    depth, thickness, drop = draw.uniform(13.0, 33.0), draw.uniform(3.0, 8.0), draw.uniform(3.0, 8.0)
    mission = folder / f"{mode}-{seed}" / "thermocline"
    shutil.copytree(MISSION, mission)
    world = (mission / "world.toml").read_text(encoding="utf-8")
    for key, value in (
        ("depth_m = 22.0", depth),
        ("thickness_m = [3.0, 8.0]", thickness),
        ("drop_c = [3.0, 8.0]", drop),
    ):
        assert key in world, key
        world = world.replace(key, f"{key.split(' ')[0]} = {value:.3f}")
    # What the mission expects is about its own thermocline, and about tracking.
    world = re.sub(r"\n\[\[expect\.measure\]\].*", "", world, flags=re.DOTALL)
    (mission / "world.toml").write_text(world, encoding="utf-8")
    log = mission.parent / "run.mcap"
    command = [program, "sim", str(mission), "--seed", str(seed), "--plugins", plugins, "--json", "--log", str(log)]
    finished = subprocess.run(
        [*command, "--set", f"plugin.thermocline.config.mode={mode}"], capture_output=True, text=True, check=False
    )
    if finished.returncode != 0:
        raise SystemExit(f"seed {seed}, {mode}: exit code {finished.returncode}\n{finished.stdout}{finished.stderr}")
    report = json.loads(finished.stdout)
    assert not report["plugin_failures"] and not report["violations"], finished.stdout
    figures = judge(log, depth, thickness)
    log.unlink()
    return figures


def judge(log: Path, depth: float, thickness: float) -> dict[str, float]:
    """The figures of a log, by the true depth of the vehicle while the plugin steered."""
    inside = samples = crossings = 0
    way, last, below, true_depth, steered = 0.0, None, None, 0.0, False
    errors: list[float] = []
    with log.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages(
            topics=["/truth", "/sensors/BFCTD", "/measures/thermocline/depth"]
        ):
            data = json.loads(message.data)
            if channel.topic == "/truth":
                true_depth, steered = data["depth_m"], data["steering"] == "modify"
                here = (data["local"]["east_m"], data["local"]["north_m"])
                if steered and last is not None:
                    way += math.dist(here, last)
                    crossings += below is not None and (true_depth > depth) is not below
                    below = true_depth > depth
                last = here
            elif channel.topic == "/sensors/BFCTD":
                samples += steered
                inside += steered and abs(true_depth - depth) <= thickness / 2.0
            else:
                errors.append(data["value"] - depth)
    return {
        "in_layer": 100.0 * inside / samples,
        "crossings": 1000.0 * crossings / way,
        "leg_error": math.sqrt(sum(error * error for error in errors[1:]) / max(1, len(errors) - 1)),
        "end_error": abs(errors[-1]),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description="Compare tracking with a plain yo-yo")
    parser.add_argument("program", help="the program backseat")
    parser.add_argument("plugins", help="the folder with thermocline.wasm")
    parser.add_argument("--seeds", type=int, default=24, help="how many seeds to fly [default: 24]")
    given = parser.parse_args()
    found: dict[str, list[dict[str, float]]] = {"yoyo": [], "track": []}
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(1, given.seeds + 1):
            for mode, figures in found.items():
                figures.append(fly(given.program, given.plugins, seed, mode, Path(folder)))
    print(f"| {given.seeds} seeds | plain yo-yo | tracking |\n|---|---|---|")
    for key, name in ROWS.items():
        cells = []
        for mode in ("yoyo", "track"):
            values = [figures[key] for figures in found[mode]]
            spread = statistics.stdev(values) if len(values) > 1 else 0.0
            cells.append(f"{statistics.mean(values):.2f} ± {spread:.2f} ({min(values):.2f} to {max(values):.2f})")
        print(f"| {name} | {' | '.join(cells)} |")
    better = sum(a["in_layer"] < b["in_layer"] for a, b in zip(found["yoyo"], found["track"], strict=True))
    print(f"\nMore samples in the layer by tracking: {better} of {given.seeds} seeds.")


if __name__ == "__main__":
    main()
