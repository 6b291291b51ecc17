"""Components that componentize-py made, in the runtime, in simulation."""

import pytest
from conftest import build, run

#: The template's mission with the plugin for tests.
FAULTY = (
    ('name = "template"', 'name = "faulty"'),
    ('component = "template-python"', 'component = "faulty"'),
    ("heading_deg = 80.0\ndepth_m = 10.0\nspeed_mps = 1.5", 'what = "nothing"'),
)


@pytest.fixture(scope="session")
def faulty(fly):
    def fly_with(what, *sets):
        return fly("template-python", edits=FAULTY, sets=(f"plugin.faulty.config.what={what}", *sets))

    return fly_with


def test_the_template_flies_twice_with_the_same_bytes_and_replays(fly, plugins):
    one, two = fly("template-python", "--seed", "3"), fly("template-python", "--seed", "3")
    assert one.code == two.code == 0, one.stderr
    assert one.report["digest"] == two.report["digest"]
    assert one.report["requests"]["rejected"] == 0 and one.report["requests"]["accepted"] > 100
    assert one.report["plugin_failures"] == {} and one.report["violations"] == []
    # The log has a component of this size by its hash alone.
    replayed = run(["replay", str(one.log), "--plugin", f"template={plugins / 'template-python.wasm'}"])
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr
    assert "steps, all identical" in replayed.stdout


def test_it_does_what_the_template_in_rust_does(fly):
    """Both make the same requests with the same tags. They do not have the same digest: a step takes as long as the
    fuel that it used."""
    sent = fly("template-python").report["requests"]
    assert sent["proposed"] == 480


def test_a_request_that_the_fence_forbids_is_refused_and_the_plugin_is_told(fly):
    flight = fly("template-python", edits=[("depth_m = 10.0", "depth_m = 39.0")])
    assert flight.code == 1, "the mission expects accepted requests"
    assert flight.report["requests"]["rejected"] == 480
    assert "depth: 4.0 m deeper than the 36 m of keep-in zone 'bay'" in flight.report["rejections"][0]
    assert "request 1: depth: 4.0 m deeper than the 36 m" in flight.lines


@pytest.mark.parametrize(
    "edit, told",
    [
        (("depth_m = 10.0", "depht_m = 10.0"), "config: unknown key `depht_m`, did you mean `depth_m`?"),
        (("depth_m = 10.0", "depth_m = -2.0"), "config: depth_m: -2.0, expected 0 to 300"),
        (("depth_m = 10.0", ""), "config: missing key `depth_m`, expected a number within 0 to 300"),
        (("depth_m = 10.0", 'depth_m = "10"'), 'config: depth_m: "10", expected a number'),
    ],
)
def test_a_wrong_setting_is_refused_in_one_line(fly, edit, told):
    flight = fly("template-python", edits=[edit])
    assert flight.code == 2 and flight.stderr.count("\n") == 1, flight.stderr
    assert told in flight.stderr


def test_an_exception_in_init_is_a_refusal_with_its_place(faulty):
    assert faulty("refuse").stderr.rstrip().endswith("cannot be started: what: this setting is refused")
    told = faulty("fail-in-init").stderr
    assert "cannot be started: KeyError: 'missing' (plugin.py:" in told and " in init)" in told


def test_the_mission_briefs_the_plugin(faulty, fly):
    told = faulty("fail-in-brief").stderr
    assert told.rstrip().endswith("cannot be started: speed_max_mps: 2.0 is too slow")
    lines = faulty("tell-briefing").lines
    for line in (
        "bay: 3.0 m, 36.0 m, 1 area",
        "holes: 0",
        "grants: modify",
        "fuel: 20000000, inserts: 4",
    ):
        assert line in lines, lines
    refused = fly("template-python", edits=[('grants = ["modify"]', 'grants = ["message"]')])
    assert refused.code == 2 and "modify" in refused.stderr, refused.stderr


def test_an_exception_in_a_step_is_told_with_its_lines_and_the_instance_goes_on(faulty):
    flight = faulty("raise")
    assert flight.code == 0, flight.stderr
    assert flight.report["plugin_failures"] == {"faulty": 1}
    assert "ZeroDivisionError: division by zero (plugin.py:" in flight.report["plugin_first_failures"]["faulty"]["text"]
    for line in (
        "ZeroDivisionError: division by zero",
        "in divide: return one / other",
        "in fault: self.divide(1.0, 0.0)",
        "in step: self.fault()",
    ):
        assert line in flight.lines
    # No restart: the tags go on, and one step made no request.
    assert "faulty.restarts" not in flight.report["published"]
    assert flight.report["requests"]["proposed"] == 479


def test_an_exception_of_every_step_fills_no_log_and_ends_in_quarantine(faulty):
    flight = faulty("raise-always")
    assert flight.code == 1
    assert flight.report["plugin_failures"] == {"faulty": 6} and "faulty" in flight.report["plugin_quarantines"]
    assert flight.lines.count("in divide: return one / other") == 1


@pytest.mark.parametrize(
    "what, told",
    [
        ("wrong-tag", "ValueError: Modify.tag: -1 is not within 0 to 18446744073709551615"),
        ("no-request", "TypeError: step: str 'north', expected a Request"),
        ("recurse", "RecursionError: maximum recursion depth exceeded (plugin.py:"),
        ("memory", "MemoryError (plugin.py:"),
        ("exit", "SystemExit: 3 (plugin.py:"),
        ("clock", "NotInSandbox: time.monotonic: a plugin has no clock: use input.now_ns or input.utc_ns (plugin.py:"),
        ("sleep", "NotInSandbox: time.sleep: a plugin cannot wait: return, and use a Timer (plugin.py:"),
        ("chance", "NotInSandbox: random.random: a plugin has no randomness"),
        ("late-import", "ModuleNotFoundError: fractions is not in the component: import what Python's standard library and your own modules have"),
        ("numpy", "ModuleNotFoundError: numpy is not in the component"),
        ("file", "NotInSandbox: open: a plugin has no files"),
        ("thread", "NotInSandbox: Thread.start: a plugin has no threads"),
    ],
)
def test_what_a_plugin_must_not_do_is_told_in_words(faulty, what, told):
    flight = faulty(what)
    assert flight.report["plugin_failures"] == {"faulty": 1}
    assert flight.report["plugin_first_failures"]["faulty"]["text"].startswith(told)
    assert "faulty.restarts" not in flight.report["published"], "the instance goes on"


@pytest.mark.parametrize(
    "what, told",
    [
        ("loop", "used all its fuel: 20000000 units"),
        ("trap", "wasm trap"),
        ("big-state", "snapshot: used all its fuel"),
    ],
)
def test_a_plugin_that_is_restarted_goes_on_from_its_snapshot(faulty, what, told):
    flight = faulty(what)
    assert flight.code == 0, flight.stderr
    assert flight.report["plugin_first_failures"]["faulty"]["text"].startswith(told)
    published = {name: value["value"] for name, value in flight.report["published"].items()}
    assert published["faulty.restarts"] == 1
    # Of the ten steps since the last snapshot, those with control had raised the tag.
    assert 1 <= published["faulty.lost_steps"] <= 10
    assert published["faulty.tag_after_restart"] >= 1
    assert flight.report["requests"]["accepted"] > 200


def test_a_state_that_cannot_be_restored_ends_the_plugin_with_its_reason(faulty):
    flight = faulty("fail-in-restore")
    assert flight.report["plugin_failures"]["faulty"] > 1
    assert "state: not today" in flight.lines


def test_a_snapshot_that_fails_is_told_and_ends_in_quarantine(faulty):
    flight = faulty("fail-in-snapshot", "plugin.faulty.config.at_step=1")
    assert flight.report["plugin_failures"]["faulty"] > 1
    assert "OSError: no snapshot today" in flight.lines and "Traceback" not in flight.lines


def test_print_the_fence_and_timers_work(faulty):
    flight = faulty("print")
    assert "a line of print" in flight.lines
    assert flight.report["published"]["faulty.timers"]["value"] == 4
    flight = faulty("ask-fence")
    assert "shallow: " in flight.lines
    assert "deep: DEPTH, 36.0 m, depth: 4.0 m deeper than the 36 m of keep-in zone 'bay'" in flight.lines


@pytest.mark.parametrize("seed", ["1", "2", "3"])
def test_the_thermocline_is_found_and_tracked(fly, seed):
    flight = fly("thermocline", "--seed", seed)
    assert flight.code == 0, flight.stdout + flight.stderr
    assert flight.report["plugin_failures"] == {} and flight.report["unmet"] == []
    assert flight.report["requests"]["rejected"] == 0


def test_a_plugin_that_needs_a_package_is_refused_in_one_line(tmp_path):
    (tmp_path / "plugin.py").write_text("import backseat_sdk\nimport numpy\n", encoding="utf-8")
    built = build(tmp_path, tmp_path / "x.wasm")
    assert built.returncode == 1
    assert "plugin.py:2: no module named 'numpy' (a plugin has " in built.stderr and built.stderr.count("\n") == 1
    assert not (tmp_path / "x.wasm").exists()
