"""The tools for surveys."""

import math
import random

import pytest
from backseat_sdk import (
    Accepted,
    Cancel,
    Depth,
    EndKind,
    Ended,
    Position,
    Refusal,
    Rejected,
    Restored,
    Rule,
    Started,
    StepInput,
    TimedOut,
    TimerExpired,
    Trackline,
)
from backseat_sdk.survey import (
    Box,
    ContourFollower,
    CoverageGrid,
    InsertQueue,
    Line,
    Local,
    PlaneFit,
    Progress,
    Timers,
    lawnmower,
)
from backseat_sdk.testing import outcome


def test_along_and_across_a_line():
    line = Line(Local(0.0, 0.0), Local(100.0, 0.0))
    assert math.isclose(line.bearing, 90.0) and math.isclose(line.length, 100.0)
    assert math.isclose(line.along(Local(30.0, -7.0)), 30.0)
    assert math.isclose(line.across(Local(30.0, -7.0)), 7.0)
    assert math.isclose(line.heading_to_follow(Local(30.0, 0.0)), 90.0)
    # South of a line to the east is to starboard, so the way back is to port.
    assert math.isclose(line.heading_to_follow(Local(30.0, -50.0), lookahead=50.0), 45.0)


@pytest.mark.parametrize("bearing", [0.0, 37.0, 90.0, 200.0])
def test_a_lawnmower_covers_its_box_from_the_nearest_corner(bearing):
    box = Box(Local(50.0, -20.0), 400.0, 210.0, bearing)
    for corner in box.corners():
        lines = lawnmower(box, 50.0, corner)
        assert len(lines) == 5
        assert all(math.isclose(line.length, 400.0) for line in lines)
        nearest = min(end.distance(corner) for line in lines for end in (line.start, line.end))
        assert math.isclose(lines[0].start.distance(corner), nearest)
        for before, after in zip(lines, lines[1:]):
            assert math.isclose(before.end.distance(after.start), 42.0)
        grid = CoverageGrid(box, 10.0)
        for line in lines:
            grid.see(line, 26.0, 26.0)
        assert grid.percent == 100.0 and grid.unseen() == []


def test_a_box_knows_what_is_inside():
    box = Box(Local(0.0, 0.0), 100.0, 40.0, 90.0)
    assert box.contains(Local(49.0, 19.0)) and not box.contains(Local(49.0, 21.0))
    assert not box.contains(Local(49.0, 0.0), margin=5.0)
    with pytest.raises(ValueError, match="spacing"):
        lawnmower(box, 0.0)


def test_a_grid_counts_what_was_seen_on_each_side():
    grid = CoverageGrid(Box(Local(0.0, 0.0), 100.0, 100.0), 10.0)
    middle = Line(Local(0.0, -50.0), Local(0.0, 50.0))
    assert grid.see(middle, 0.0, 50.0) == 50
    assert grid.see(middle, 0.0, 50.0) == 0
    assert grid.percent == 50.0 and len(grid.unseen()) == 50
    assert all(point.east < 0.0 for point in grid.unseen())


def test_a_timer_expires_once_and_can_be_started_anew():
    timers = Timers()
    first = timers.start("turn", 5.0, StepInput(now_ns=0))
    second = timers.start("turn", 8.0, StepInput(now_ns=2_000_000_000))
    assert first.id != second.id and second.after_ns == 8_000_000_000
    # The number of the first start no longer counts.
    assert timers.expired(StepInput(now_ns=5_000_000_000, events=(TimerExpired(first.id),))) == []
    assert timers.is_running("turn")
    assert timers.expired(StepInput(now_ns=9_999_000_000, events=(TimerExpired(second.id),))) == ["turn"]
    assert timers.expired(StepInput(now_ns=20_000_000_000)) == []
    timers.start("lost", 1.0, StepInput(now_ns=0))
    assert timers.expired(StepInput(now_ns=1_000_000_000)) == ["lost"], "its event was lost in a restart"
    timers.start("stopped", 1.0, StepInput(now_ns=0))
    timers.stop("stopped")
    assert timers.expired(StepInput(now_ns=9_000_000_000)) == []
    with pytest.raises(ValueError, match="timer x"):
        timers.start("x", 0.0, StepInput())


def trackline():
    return Trackline(0, Position(42.0, -70.0), Position(42.01, -70.0), Depth(10.0), 1.5)


def test_a_queue_keeps_its_order_and_asks_ahead():
    queue = InsertQueue(ahead=2)
    for _ in range(3):
        queue.add(trackline())
    assert queue.step(StepInput(control=False)) == []
    first, second = queue.step(StepInput(control=True))
    assert (first.tag, second.tag) == (1_000_000, 1_000_001)
    events = (outcome(first, Accepted()), outcome(second, Accepted()), outcome(first, Started()))
    assert queue.step(StepInput(control=True, events=events)) == []
    assert queue.inserts[0].progress is Progress.FLYING
    [third] = queue.step(StepInput(control=True, events=(outcome(first, Ended(EndKind.DONE)),)))
    assert queue.count(Progress.FLOWN) == 1 and not queue.is_done
    ends = tuple(outcome(each, Ended(EndKind.DONE)) for each in (second, third))
    queue.step(StepInput(control=True, events=ends))
    assert queue.is_done


def test_a_queue_tries_again_after_a_pause_and_gives_up():
    queue = InsertQueue(attempts_max=2, pause_s=10.0)
    queue.add(trackline())
    queue.add(trackline())
    first, second = queue.step(StepInput(now_ns=0, control=True))
    refused = outcome(first, Rejected(Refusal(Rule.KEEP_OUT, text="in the lane")))
    lost = outcome(second, TimedOut())
    assert queue.step(StepInput(now_ns=0, control=True, events=(refused, lost))) == []
    assert queue.inserts[0].progress is Progress.GIVEN_UP and queue.inserts[0].why == "in the lane"
    assert queue.step(StepInput(now_ns=9_000_000_000, control=True)) == []
    [again] = queue.step(StepInput(now_ns=10_000_000_000, control=True))
    assert again.tag == 1_000_002
    paused = outcome(again, Rejected(Refusal(Rule.PAUSE, text="just refused")))
    queue.step(StepInput(now_ns=11_000_000_000, control=True, events=(paused,)))
    assert queue.is_done and queue.inserts[1].why == "just refused"


def test_a_queue_forgets_no_insert_in_a_restart():
    queue = InsertQueue(ahead=2)
    for _ in range(4):
        queue.add(trackline())
    first, second = queue.step(StepInput(control=True))
    # In the lost steps the first was flown, the second was accepted, and the third was asked for with the next tag.
    restored = Restored(lost_steps=3, open=(second.tag, 1_000_002))
    assert queue.step(StepInput(control=True, events=(restored,))) == []
    assert [insert.progress for insert in queue.inserts] == [
        Progress.UNKNOWN,
        Progress.ASKED,
        Progress.WAITING,
        Progress.WAITING,
    ]
    ends = tuple(outcome(tag, Ended(EndKind.DONE)) for tag in (second.tag, 1_000_002))
    asked = queue.step(StepInput(control=True, events=ends))
    assert [each.tag for each in asked] == [1_000_009, 1_000_010]
    assert queue.count(Progress.FLOWN) == 2


def test_a_queue_cancels_what_it_knows_nothing_of_after_a_restart():
    queue = InsertQueue()
    queue.add(trackline())
    [first] = queue.step(StepInput(control=True))
    queue.step(StepInput(control=True, events=(outcome(first, Started()),)))
    # In the lost steps the plugin added a second one, the queue asked for it, and the first was flown to its end.
    restored = Restored(lost_steps=3, open=(1_000_001,))
    assert queue.step(StepInput(control=True, events=(restored,))) == [Cancel(1_000_001)]
    assert queue.inserts[0].progress is Progress.FLOWN
    queue.add(trackline())
    [second] = queue.step(StepInput(control=True))
    assert second.tag > 1_000_001


def test_a_plane_is_found_in_noise():
    draw = random.Random(3)
    fit = PlaneFit(keep=200, reach_m=500.0)
    for _ in range(300):
        place = Local(draw.uniform(-100.0, 100.0), draw.uniform(-100.0, 100.0))
        fit.add(place, 30.0 + 0.02 * place.east - 0.01 * place.north + draw.gauss(0.0, 0.05))
    fit.add(Local(0.0, 0.0), math.nan)
    assert len(fit.points) == 200
    slope = fit.at(Local(50.0, 0.0))
    assert abs(slope.value - 31.0) < 0.03
    assert abs(slope.east - 0.02) < 2e-4 and abs(slope.north + 0.01) < 2e-4
    assert 0.03 < slope.residual < 0.07
    assert abs(slope.bearing - 116.57) < 1.0


def test_a_straight_track_determines_no_plane():
    fit = PlaneFit()
    for step in range(20):
        fit.add(Local(10.0 * step, 5.0 * step), 1.0 * step)
    assert fit.at(Local(0.0, 0.0)) is None
    assert PlaneFit().at(Local(0.0, 0.0)) is None


@pytest.mark.parametrize("to_starboard", [True, False])
def test_a_follower_comes_to_the_contour_and_stays(to_starboard):
    # A round hill: the contour of 30 is a circle with a radius of 200 m.
    follower = ContourFollower(30.0, higher_to_starboard=to_starboard)
    fit, place, heading, far = PlaneFit(keep=40, reach_m=60.0), Local(330.0, 0.0), 300.0, []
    for step in range(900):
        fit.add(place, 50.0 - 0.1 * place.distance(Local(0.0, 0.0)))
        # Without a plane yet, the vehicle weaves so that its track determines one.
        slope = fit.at(place)
        wanted = follower.heading(slope) if slope else 300.0 + 40.0 * math.sin(step / 5.0)
        turn = (wanted - heading + 180.0) % 360.0 - 180.0
        heading += max(-5.0, min(5.0, turn))
        place = place.offset(heading, 1.5)
        if step > 400:
            far.append(place.distance(Local(0.0, 0.0)) - 200.0)
    assert max(abs(each) for each in far) < 15.0
    centre_bearing = place.bearing(Local(0.0, 0.0))
    side = (centre_bearing - heading + 360.0) % 360.0
    assert (side < 180.0) is to_starboard


def test_a_flat_field_has_no_contour():
    fit = PlaneFit()
    for east in range(5):
        for north in range(5):
            fit.add(Local(10.0 * east, 10.0 * north), 30.0)
    assert ContourFollower(30.0).heading(fit.at(Local(0.0, 0.0))) is None
