"""The harness for unit tests, the log, the fence and the measures without a runtime, and lines about exceptions."""

from dataclasses import dataclass

import pytest
from backseat_sdk import (
    SECOND_NS,
    Control,
    Depth,
    Description,
    Message,
    Modify,
    Packet,
    Plugin,
    Position,
    Refusal,
    Refused,
    Restored,
    Rule,
    Timer,
    TimerExpired,
    _faults,
    fence,
    is_plain,
    log,
    measures,
)
from backseat_sdk.testing import ORIGIN, Harness, navigation


@dataclass(frozen=True)
class Config:
    count: int = 1


@dataclass
class State:
    steps: int = 0
    note: str = ""


class Counter(Plugin):
    Config = Config
    State = State

    def describe(self):
        return Description("counter", "1", SECOND_NS // 2)

    def init(self, config):
        if config.count < 0:
            raise Refused("count: negative")
        self.config = config

    def step(self, input):
        self.state.steps += self.config.count
        if any(input.of(Restored)):
            self.state.note = "restored"
        if self.state.steps == 1:
            return [Timer(7, SECOND_NS)]
        if any(timer.id == 7 for timer in input.of(TimerExpired)):
            log.info("expired")
            measures.publish("steps", self.state.steps)
        if any(input.of(Control)):
            return [Modify(-1, 0.0, Depth(1.0), 1.0, 1)]
        asked = Modify(1, 0.0, Depth(1.0), 1.0, 1)
        return [Message(str(fence.check(asked)))] if fence.allows(asked) else None


def test_a_timer_expires_and_lines_and_values_are_collected():
    harness = Harness(Counter)
    assert harness.description.step_period_ns == SECOND_NS // 2
    harness.step()
    assert harness.step() == [Message("1000.0")]
    harness.step()
    assert harness.lines == [("info", "expired")]
    assert harness.measures == {"steps": [3.0]}
    assert len(harness.recorder.asked) == 4


def test_a_fence_of_the_test_answers():
    harness = Harness(Counter)
    harness.recorder.fence = lambda request: Refusal(Rule.DEPTH, text="too deep")
    harness.step()
    assert harness.step() == []


def test_a_restart_keeps_the_state_and_tells_the_plugin():
    harness = Harness(Counter)
    harness.step()
    harness.step()
    first = harness.plugin
    harness.restart(lost_steps=3)
    assert harness.plugin is not first and harness.plugin.state == State(2)
    harness.step()
    assert harness.plugin.state == State(3, "restored")


def test_what_a_component_could_not_send_fails_in_the_test_too():
    harness = Harness(Counter)
    harness.step()
    with pytest.raises(ValueError, match="Modify.tag: -1 is not within 0 to"):
        harness.step([Control(True)])


def test_a_refusal_to_start_is_the_line_of_the_runtime():
    with pytest.raises(Refused, match="config: unknown key `cuont`, did you mean `count`?"):
        Harness(Counter, {"cuont": 1})
    with pytest.raises(Refused, match="count: negative"):
        Harness(Counter, {"count": -1})


def test_a_state_that_is_no_dataclass_is_refused():
    class Wrong(Counter):
        State = dict

    with pytest.raises(TypeError, match="Wrong.State must be a dataclass"):
        Harness(Wrong)


def test_a_plugin_without_a_state_has_an_empty_snapshot():
    class Plain(Plugin):
        def describe(self):
            return Description("plain", "1")

        def step(self, input):
            return []

    harness = Harness(Plain)
    assert harness.plugin.snapshot() == b""
    harness.restart()
    assert harness.step() == []
    with pytest.raises(Refused, match="config: unknown key `x`: there are no settings"):
        Harness(Plain, {"x": 1})


def test_a_navigation_for_tests_has_the_position_of_its_east_and_north():
    assert navigation().position.latitude == pytest.approx(ORIGIN.latitude, abs=1e-9)
    moved = navigation(east=0.0, north=1000.0, depth=12.0, altitude=30.0)
    assert moved.position.latitude > ORIGIN.latitude + 0.008
    assert moved.water_depth == 42.0
    assert navigation(position=Position(1.0, 2.0)).position == Position(1.0, 2.0)


def test_without_a_runtime_lines_go_to_standard_error_and_the_fence_refuses(capsys):
    log.warn("careful")
    measures.publish("x", 1, "m")
    assert not fence.allows(Modify(1, 0.0, Depth(1.0), 1.0, 1))
    assert capsys.readouterr().err == "warn: careful\nx = 1.0 m\n"


def test_texts_and_packets_are_bounded():
    assert is_plain("depth 12.5 m: steady")
    for text in ("12,5", "a*4E", "$BPABT", "two\nlines", "caf\u00e9", "x" * 257):
        assert not is_plain(text), text
    assert [len(frame) for frame in Packet.of(1, 2, 0, bytes(70), 32).frames] == [32, 32, 6]
    assert Packet.of(1, 2, 0, bytes(257), 32) is None and Packet.of(1, 2, 0, b"", 32) is None
    assert Packet.of(1, 2, 0, b"x", 0) is None and Packet.of(1, 2, 0, b"x", 1025) is None


def caught(call):
    try:
        call()
    except BaseException as error:  # noqa: BLE001
        return error
    raise AssertionError("no exception")


def test_an_exception_becomes_lines_with_the_innermost_frame_first():
    def inner():
        return {}["depth"]

    def outer():
        try:
            inner()
        except KeyError as error:
            raise ValueError("no depth\nin two lines") from error

    error = caught(outer)
    lines = _faults.lines(error)
    assert lines[0] == "ValueError: no depth in two lines"
    assert lines[1].startswith("  at test_testing.py:") and " in outer" in lines[1]
    assert lines[-1].startswith("  because of KeyError: 'depth' (test_testing.py:") and "in inner" in lines[-1]
    assert _faults.one_line(error).startswith("ValueError: no depth in two lines (test_testing.py:")


def test_a_source_that_was_kept_is_shown():
    import sys

    _faults.keep_source(sys.modules[__name__])
    error = caught(lambda: 1 / 0)
    assert _faults.lines(error)[1].endswith("in <lambda>: error = caught(lambda: 1 / 0)")


def test_lines_are_cut_at_the_length_of_the_log():
    def recurse(depth):
        return recurse(depth + 1)

    for error in (caught(lambda: recurse(0)), ValueError("\u00e9" * 1000)):
        lines = _faults.lines(error)
        assert len(lines) <= 10
        assert all(len(line.encode()) <= 256 for line in [*lines, _faults.one_line(error)])
    assert _faults.one_line(caught(lambda: recurse(0))).endswith("in recurse)")


def test_an_exception_whose_text_fails_is_still_told():
    class Odd(Exception):
        def __str__(self):
            raise RuntimeError("no text")

    assert _faults.lines(Odd()) == ["Odd"]
