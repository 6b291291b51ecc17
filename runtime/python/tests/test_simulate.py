import json
import os
import shutil
import subprocess
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import backseat
import numpy
import pytest


def without_clock(report):
    return {key: value for key, value in report.items() if key not in ("wall_seconds", "load_seconds")}


def test_a_run_is_that_of_the_program(missions, plugins):
    program = os.environ.get("BACKSEAT_TEST_PROGRAM")
    if program is None:
        pytest.skip("BACKSEAT_TEST_PROGRAM names no program")
    arguments = [program, "sim", missions / "isobath", "--seed", "7", "--plugins", plugins, "--json"]
    settings = ["--set", "plugin.isobath.config.depth_m=10.0"]
    printed = json.loads(subprocess.run(arguments + settings, capture_output=True, check=True).stdout)
    run = backseat.simulate(missions / "isobath", seed=7, set={"plugin.isobath.config.depth_m": 10.0}, plugins=plugins)
    assert without_clock(run.report) == without_clock(printed)


def test_a_run_has_outcome_measures_and_counts(missions, plugins):
    run = backseat.simulate(missions / "isobath", plugins=plugins)
    assert (run.mission, run.seed, run.outcome, run.passed, run.log) == ("isobath", 1, "completed", True, None)
    assert 0 < run.measures["contour_rms_m"] < 5
    assert run.published["isobath.slope"]["unit"] == "%"
    assert run.violations == []
    assert run.requests["sent"] == run.requests["accepted"] > 1000
    assert len(run.digest) == 64
    assert str(run).startswith("isobath, seed 1: completed after ")


def test_settings_of_every_type_reach_the_mission(missions, plugins):
    def fly(**settings):
        set = {key.replace("__", "."): value for key, value in settings.items()}
        return backseat.simulate(missions / "isobath", set=set, plugins=plugins).digest

    usual = backseat.simulate(missions / "isobath", plugins=plugins).digest
    assert fly(plugin__isobath__config__depth_m=8) == usual
    deeper = fly(plugin__isobath__config__depth_m=10.0)
    assert fly(plugin__isobath__config__depth_m=numpy.float64(10)) == deeper != usual
    assert fly(plugin__isobath__grants=["modify", "message"]) == usual
    assert fly(world__current__speed_mps=0.0) != fly(world__current__speed_mps=[0.25, 0.25])
    with pytest.raises(backseat.MissionError, match="speed_max_mps"):
        fly(limits__speed_max_mps="fast")
    with pytest.raises(TypeError, match="invalid setting None"):
        fly(limits__speed_max_mps=None)


def test_faults_are_drawn_as_the_program_draws_them(missions, plugins):
    program = os.environ.get("BACKSEAT_TEST_PROGRAM")
    if program is None:
        pytest.skip("BACKSEAT_TEST_PROGRAM names no program")
    arguments = [program, "sim", missions / "isobath", "--seed", "3", "--plugins", plugins, "--json"]
    printed = json.loads(
        subprocess.run(arguments + ["--draw-faults", "3..9@30..800"], capture_output=True).stdout
    )
    run = backseat.simulate(missions / "isobath", seed=3, draw_faults="3..9@30..800", plugins=plugins)
    assert without_clock(run.report) == without_clock(printed)
    assert run.digest != backseat.simulate(missions / "isobath", seed=3, plugins=plugins).digest
    with pytest.raises(backseat.MissionError, match="draw_faults: `3`: expected"):
        backseat.simulate(missions / "isobath", draw_faults="3", plugins=plugins)
    with pytest.raises(ValueError, match="give one of them"):
        backseat.simulate(missions / "isobath", faults="f.toml", draw_faults="3..9@30..800", plugins=plugins)


def test_a_wrong_mission_raises_one_line(missions, plugins, tmp_path):
    for arguments, part in [
        ({"mission": tmp_path / "nowhere"}, "nowhere"),
        ({"mission": missions / "isobath" / "mission.toml"}, "mission.toml"),
        ({"mission": missions / "isobath", "set": {"limits.speed_max": 2.0}}, "speed_max"),
        ({"mission": missions / "isobath", "faults": tmp_path / "faults.toml"}, "faults.toml"),
        ({"mission": missions / "isobath", "set": {"plugin.isobath.component": "no_such"}}, "no_such"),
    ]:
        with pytest.raises(backseat.MissionError) as raised:
            backseat.simulate(**arguments, plugins=plugins)
        assert part in str(raised.value) and "\n" not in str(raised.value)
    assert issubclass(backseat.MissionError, ValueError)
    for seed in (-1, 2**64):
        with pytest.raises(ValueError, match=f"invalid seed {seed}"):
            backseat.simulate(missions / "isobath", seed=seed, plugins=plugins)
    with pytest.raises(OSError, match="run.mcap"):
        backseat.simulate(missions / "isobath", plugins=plugins, log=tmp_path / "nowhere" / "run.mcap")


def test_faults_replace_those_of_the_world(missions, plugins, tmp_path):
    faults = tmp_path / "faults.toml"
    faults.write_text('[[fault]]\nat_s = 300\nfor_s = 30\nkind = "stall"\n')
    usual = backseat.simulate(missions / "isobath", plugins=plugins)
    run = backseat.simulate(str(missions / "isobath"), plugins=str(plugins), faults=str(faults))
    assert (usual.report["faults"], run.report["faults"]) == (0, 1)
    assert run.digest != usual.digest and run.violations == []


def test_the_interpreter_is_free_while_a_run_flies(missions, plugins):
    flying, counts = threading.Event(), []

    def count():
        flying.wait()
        while flying.is_set():
            counts.append(time.monotonic())
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    flying.set()
    backseat.simulate(missions / "isobath", plugins=plugins)
    flying.clear()
    counter.join()
    assert len(counts) > 20


def test_threads_fly_at_once_and_give_the_same_runs(missions, plugins):
    def fly(seed):
        return backseat.simulate(missions / "isobath", seed, plugins=plugins).digest

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(fly, [1, 2, 1, 2])) == [fly(1), fly(2)] * 2


def test_ctrl_c_ends_a_run(missions, plugins, tmp_path):
    # A mission of hours, in a process of its own.
    folder = tmp_path / "isobath"
    shutil.copytree(missions / "isobath", folder)
    text = (
        "import backseat, os, signal, threading\n"
        "threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        "try:\n"
        f"    for seed in range(1000): backseat.simulate({str(folder)!r}, seed, plugins={str(plugins)!r})\n"
        "except KeyboardInterrupt:\n"
        "    print('ended')\n"
    )
    started = time.monotonic()
    ended = subprocess.run([os.sys.executable, "-c", text], capture_output=True, text=True, timeout=120)
    assert ended.stdout == "ended\n", ended.stderr
    assert time.monotonic() - started < 60
