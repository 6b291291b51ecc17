from backseat_sdk import Depth, Outcome, Refusal, Refused, Rejected, Rule
from backseat_sdk.testing import Harness
from plugin import HoldHeading
import pytest

CONFIG = {"heading_deg": 90.0, "depth_m": 10.0, "speed_mps": 1.5}


def test_it_makes_requests_only_with_control():
    harness = Harness(HoldHeading, CONFIG)
    assert harness.step(control=False) == []
    [modify] = harness.step(control=True)
    assert modify.heading == 90.0
    assert modify.vertical == Depth(10.0)


def test_a_new_instance_continues_with_new_tags():
    harness = Harness(HoldHeading, CONFIG)
    harness.step()
    harness.restart()
    [modify] = harness.step()
    assert modify.tag == 2
    harness.restart(lost_steps=3)
    [modify] = harness.step()
    assert modify.tag == 6


def test_a_refusal_is_logged_and_the_plugin_goes_on():
    harness = Harness(HoldHeading, CONFIG)
    [modify] = harness.step()
    refused = Outcome(modify.tag, Rejected(Refusal(Rule.DEPTH, text="4.0 m too deep")))
    assert len(harness.step([refused])) == 1
    assert harness.lines == [("warn", "request 1: 4.0 m too deep")]


@pytest.mark.parametrize(
    "key, value, told",
    [
        ("heading_deg", 400.0, "config: heading_deg: 400.0, expected 0 to 360"),
        ("heading", 90.0, "config: unknown key `heading`, did you mean `heading_deg`?"),
    ],
)
def test_a_wrong_setting_is_refused(key, value, told):
    with pytest.raises(Refused, match=told.replace("?", r"\?")):
        Harness(HoldHeading, {**CONFIG, key: value})
