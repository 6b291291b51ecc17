import math
import random

import pytest
from backseat_sdk import Ctd, Depth, Refusal, Refused, Rule
from backseat_sdk.frame import Local
from backseat_sdk.testing import Harness, briefing, navigation
from gradient_peak import Peak, Profile
from plugin import Phase, Thermocline

CONFIG = {"heading_deg": 90.0, "speed_mps": 1.5, "shallowest_m": 5.0, "deepest_m": 42.0}


class Sea:
    """A vehicle that follows the plugin's depth at 0.5 m/s, in water with a thermocline."""

    def __init__(self, harness, depth=22.0, thickness=5.0, drop=6.0, noise=0.01, seed=1):
        self.harness = harness
        self.middle, self.thickness, self.drop, self.noise = depth, thickness, drop, noise
        self.draw = random.Random(seed)
        self.place, self.depth, self.depths = Local(0.0, 0.0), 10.0, []

    def temperature(self):
        layer = 0.5 * self.drop * math.tanh(2.0 * (self.depth - self.middle) / self.thickness)
        return 17.0 - layer + self.draw.gauss(0.0, self.noise)

    def run(self, seconds):
        for _ in range(seconds):
            here = navigation(east=self.place.east, north=self.place.north, depth=self.depth)
            ctd = Ctd(age_ns=0, conductivity=40_000.0, temperature=self.temperature(), pressure=200.0)
            [modify] = self.harness.step([ctd], navigation=here)
            move = max(-0.5, min(0.5, modify.vertical.depth - self.depth))
            self.depth += move
            self.place = self.place.offset(modify.heading, modify.speed)
            self.depths.append(self.depth)


def test_it_sweeps_then_stays_around_the_thermocline():
    harness = Harness(Thermocline, CONFIG)
    sea = Sea(harness)
    sea.run(70)
    assert harness.plugin.state.phase is Phase.TRACK
    sea.run(600)
    assert abs(harness.plugin.state.depth - 22.0) < 0.5
    assert 15.0 < min(sea.depths[150:]) < 18.0 and 26.0 < max(sea.depths[150:]) < 29.0
    assert harness.measures["crossings"][-1] > 20
    assert harness.measures["spread"][-1] < 0.5
    assert abs(sea.place.north) < 1.0


def test_a_yo_yo_sweeps_the_whole_range():
    harness = Harness(Thermocline, {**CONFIG, "mode": "yoyo"})
    sea = Sea(harness)
    sea.run(600)
    assert min(sea.depths[200:]) < 6.5 and max(sea.depths[200:]) > 40.5
    assert abs(harness.plugin.state.depth - 22.0) < 0.5


def test_it_follows_a_thermocline_that_moves():
    harness = Harness(Thermocline, CONFIG)
    sea = Sea(harness)
    sea.run(200)
    for _ in range(600):
        sea.middle += 0.01
        sea.run(1)
    assert abs(harness.plugin.state.depth - sea.middle) < 1.0


def test_it_searches_again_when_the_gradient_is_lost():
    harness = Harness(Thermocline, CONFIG)
    sea = Sea(harness)
    sea.run(200)
    sea.drop = 0.0
    sea.run(100)
    assert harness.plugin.state.phase is Phase.SEARCH and harness.plugin.state.depth is None
    assert any("searching again" in text for _, text in harness.lines)
    sea.middle, sea.drop = 30.0, 6.0
    sea.run(300)
    assert abs(harness.plugin.state.depth - 30.0) < 0.5


def test_it_turns_where_the_fence_ends():
    harness = Harness(Thermocline, CONFIG)

    def fence(request):
        deeper = request.vertical.depth + 1.0 - 30.0
        return Refusal(Rule.DEPTH, missing_m=deeper, most=30.0) if deeper > 0.0 else 5.0

    harness.recorder.fence = fence
    sea = Sea(harness, depth=20.0)
    sea.run(400)
    assert max(sea.depths) < 29.0
    assert abs(harness.plugin.state.depth - 20.0) < 0.5


def test_a_restart_goes_on_with_the_same_leg_and_new_tags():
    harness, other = Harness(Thermocline, CONFIG), Harness(Thermocline, CONFIG)
    seas = [Sea(harness), Sea(other)]
    for sea in seas:
        sea.run(123)
    harness.restart()
    for sea in seas:
        sea.run(300)
    assert seas[0].depths == seas[1].depths
    assert harness.plugin.state == other.plugin.state
    assert len(harness.plugin.snapshot()) < 2_000


def test_samples_that_are_no_numbers_change_nothing():
    harness = Harness(Thermocline, CONFIG)
    sea = Sea(harness)
    sea.run(100)
    before = harness.plugin.state.profile.bins.copy()
    bad = [Ctd(0, math.nan, math.nan, math.nan), Ctd(0, 0.0, math.inf, 0.0)]
    harness.step(bad, navigation=navigation(depth=sea.depth), control=False)
    assert harness.plugin.state.profile.bins == before
    assert harness.step(bad, navigation=None) == []


def test_a_sample_has_the_depth_of_its_own_time():
    harness = Harness(Thermocline, CONFIG)
    down = navigation(depth=10.0, velocity_down=0.5, age_ns=100_000_000)
    harness.step([Ctd(4_100_000_000, 40_000.0, 12.0, 200.0)], navigation=down, control=False)
    assert harness.plugin.state.profile.bins == {8: (1.0, 8.0, 12.0)}


def test_a_range_without_room_is_refused():
    with pytest.raises(Refused, match="deepest_m: 10.0 leaves less than twice half_span_m"):
        Harness(Thermocline, {**CONFIG, "deepest_m": 10.0})


def test_a_speed_that_the_mission_forbids_is_refused_before_the_dive():
    with pytest.raises(Refused, match="speed_mps: 3.0 is not within limits.speed_min_mps"):
        Harness(Thermocline, {**CONFIG, "speed_mps": 3.0})


def test_a_mission_without_the_grant_is_refused():
    with pytest.raises(Refused, match="needs the grants modify"):
        Harness(Thermocline, CONFIG, briefing(grants=()))


@pytest.mark.parametrize("down", [True, False])
@pytest.mark.parametrize("middle, thickness, drop", [(15.3, 3.0, 3.0), (22.0, 8.0, 3.0), (30.7, 5.0, -4.0)])
def test_the_peak_is_where_the_gradient_is_strongest(down, middle, thickness, drop):
    draw, profile = random.Random(4), Profile(1.0)
    depths = [5.0 + 0.4 * step for step in range(90)]
    for depth in depths if down else reversed(depths):
        layer = 0.5 * drop * math.tanh(2.0 * (depth - middle) / thickness)
        profile.add(depth, 15.0 - layer + draw.gauss(0.0, 0.005))
    peak = profile.peak()
    assert abs(peak.depth - middle) < 0.5
    # The steepest slope of the curve, a little less because of the bins.
    assert 0.6 < peak.gradient / (abs(drop) / thickness) < 1.1


def test_few_bins_have_no_peak():
    profile = Profile(1.0)
    assert profile.peak() is None
    for depth in (1.5, 2.5, 3.5):
        profile.add(depth, depth)
    assert profile.peak() is None
    profile.add(4.5, 4.5)
    assert profile.peak() is None or isinstance(profile.peak(), Peak)


def test_a_setpoint_is_a_depth():
    harness = Harness(Thermocline, CONFIG)
    [modify] = harness.step(navigation=navigation(depth=10.0))
    assert modify.vertical == Depth(42.0) and modify.duration_ns == 4_000_000_000
