"""The tools for surveys."""

import math
import random
from dataclasses import dataclass, field

import pytest
from backseat_sdk import (
    Accepted,
    Cancel,
    Depth,
    Description,
    EndKind,
    Ended,
    Grant,
    Plugin,
    Position,
    Refusal,
    Rejected,
    Restored,
    Rule,
    Shutdown,
    Started,
    StepInput,
    TimedOut,
    TimerExpired,
    Trackcircle,
    Trackline,
)
from backseat_sdk.survey import (
    Box,
    ContourFollower,
    CoverageGrid,
    InsertQueue,
    Line,
    Local,
    LocalFrame,
    PlaneFit,
    Progress,
    Timers,
    lawnmower,
)
from backseat_sdk.testing import ORIGIN, Harness, navigation, outcome


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
    queue = InsertQueue(attempts_max=2, refusals_max=3, pause_s=10.0)
    queue.add(trackline())
    queue.add(trackline())
    first, second = queue.step(StepInput(now_ns=0, control=True))
    refused = outcome(first, Rejected(Refusal(Rule.GRANT, text="the mission does not grant `insert`")))
    lost = outcome(second, TimedOut())
    assert queue.step(StepInput(now_ns=0, control=True, events=(refused, lost))) == []
    assert queue.inserts[0].progress is Progress.GIVEN_UP and queue.inserts[0].why.endswith("`insert`")
    assert queue.step(StepInput(now_ns=9_000_000_000, control=True)) == []
    [again] = queue.step(StepInput(now_ns=10_000_000_000, control=True))
    assert again.tag == 1_000_002
    # A refusal is no attempt: the vehicle never got this one.
    paused = outcome(again, Rejected(Refusal(Rule.PAUSE, text="just refused")))
    queue.step(StepInput(now_ns=11_000_000_000, control=True, events=(paused,)))
    [again] = queue.step(StepInput(now_ns=21_000_000_000, control=True))
    queue.step(StepInput(now_ns=22_000_000_000, control=True, events=(outcome(again, TimedOut()),)))
    assert queue.is_done and queue.inserts[1].why == "not answered"


def test_a_queue_asks_again_for_what_is_refused_until_it_has_had_enough():
    queue = InsertQueue(refusals_max=3, pause_s=10.0)
    queue.add(trackline())
    unknown = Rejected(Refusal(Rule.PLAN, text="plan unknown"))
    for attempt in range(4):
        [asked] = queue.step(StepInput(now_ns=attempt * 10_000_000_000, control=True))
        events = (outcome(asked, unknown),)
        queue.step(StepInput(now_ns=attempt * 10_000_000_000, control=True, events=events))
        if queue.is_done:
            break
    assert attempt == 2 and queue.inserts[0].progress is Progress.GIVEN_UP


def test_a_queue_without_control_waits_as_long_as_it_takes():
    queue = InsertQueue(refusals_max=1, attempts_max=1, pause_s=1.0)
    queue.add(trackline())
    for second in range(0, 50, 2):
        [asked] = queue.step(StepInput(now_ns=second * 1_000_000_000, control=True))
        lost = outcome(asked, Rejected(Refusal(Rule.CONTROL, text="no control")))
        queue.step(StepInput(now_ns=second * 1_000_000_000, control=False, events=(lost,)))
    assert queue.inserts[0].progress is Progress.WAITING


class Asks(Plugin):
    """Flies one line and one circle."""

    @dataclass
    class State:
        queue: InsertQueue = field(default_factory=InsertQueue)

    def describe(self):
        return Description("asks", "1", grants=(Grant.INSERT,))

    def step(self, input):
        return self.state.queue.step(input)


def test_a_queue_makes_smaller_what_does_not_fit_into_the_fence():
    harness = Harness(Asks)
    queue = harness.plugin.state.queue
    far = Refusal(Rule.KEEP_IN, text="outside of the bay")
    short = LocalFrame(ORIGIN).to_position(Local(0.0, 300.0))
    queue.add(Trackline(0, ORIGIN, short, Depth(10.0), 1.5))
    queue.add(Trackcircle(0, ORIGIN, 40.0, 1.0, Depth(10.0), 1.5))

    def fence(request):
        if isinstance(request, Trackline):
            return 5.0 if LocalFrame(ORIGIN).to_local(request.end).north < 210.0 else far
        return 5.0 if request.radius < 25.0 else far

    harness.recorder.fence = fence
    asked = harness.step()
    asked = harness.step([outcome(each, Rejected(far)) for each in asked])
    line, circle = queue.inserts
    frame = LocalFrame(ORIGIN)
    start, end = frame.to_local(line.request.start), frame.to_local(line.request.end)
    assert [each.tag for each in asked] == [line.request.tag, circle.request.tag]
    assert line.progress is Progress.ASKED and abs(start.north) < 0.01 and abs(end.north - 200.0) < 0.01
    assert circle.progress is Progress.ASKED and math.isclose(circle.request.radius, 40.0 * 0.75**2)
    assert ("warn", "insert 1 of 2 made smaller, 300 m to 200 m: outside of the bay") in harness.lines
    assert ("warn", "insert 2 of 2 made smaller, radius 40 m to radius 22 m: outside of the bay") in harness.lines


def cut(fits, length=300.0, **settings):
    """What becomes of a line to the north that the runtime refuses: the metres north at which it begins and ends, or none;
    and how often the fence was asked."""
    harness = Harness(Asks)
    queue = harness.plugin.state.queue = InsertQueue(**settings)
    far, frame, asked = Refusal(Rule.KEEP_IN, text="outside of the bay"), LocalFrame(ORIGIN), []
    queue.add(Trackline(0, ORIGIN, frame.to_position(Local(0.0, length)), Depth(10.0), 1.5))

    def ends(request):
        return tuple(frame.to_local(end).north for end in (request.start, request.end))

    def fence(request):
        asked.append(request)
        return 5.0 if fits(*ends(request)) else far

    harness.recorder.fence = fence
    [first] = harness.step()
    again = harness.step([outcome(first, Rejected(far))])
    if not again:
        assert queue.is_done and ("warn", "insert 1 of 1 given up: outside of the bay") in harness.lines
        return None, len(asked)
    return tuple(round(end) for end in ends(again[0])), len(asked)


def test_a_queue_cuts_a_line_where_it_does_not_fit_and_nowhere_else():
    def within(least, most):
        return lambda start, end: start > least - 1e-3 and end < most + 1e-3

    assert cut(within(-10.0, 220.0)) == ((0, 200), 8)
    assert cut(within(90.0, 310.0)) == ((100, 300), 8)
    assert cut(lambda start, end: end < 100.001 or start > 149.999) == ((150, 300), 8)
    assert cut(lambda start, end: end - start < 150.0)[0] == (100, 200)
    # Long lines cost no more questions.
    assert cut(within(0.0, 9_500.0), length=24_000.0) == ((0, 9000), 26)


def test_a_queue_gives_up_at_once_what_no_cut_can_mend():
    assert cut(lambda start, end: False) == (None, 7)
    assert cut(lambda start, end: start > 99.999 and end < 170.0) == (None, 8)
    assert cut(lambda start, end: end < 210.0, shorten_m=0.0) == (None, 1)


def test_a_queue_counts_a_line_as_flown_by_where_the_vehicle_was():
    queue, frame = InsertQueue(pause_s=1.0), LocalFrame(ORIGIN)
    queue.add(Trackline(0, ORIGIN, frame.to_position(Local(0.0, 1000.0)), Depth(10.0), 1.5))

    def at(east, north, velocity_north, events=(), second=1):
        moving = navigation(east=east, north=north, velocity_north=velocity_north)
        return queue.step(
            StepInput(now_ns=second * 1_000_000_000, control=True, navigation=moving, events=tuple(events))
        )

    [line] = at(0.0, 0.0, 0.0)
    at(0.0, 900.0, 1.5)
    assert queue.last_progress == 0.0, "it has not begun"
    at(0.0, 0.0, 1.5, [outcome(line, Started())])
    at(0.0, 900.0, -1.5)
    at(60.0, 900.0, 1.5)
    assert queue.last_progress == 0.0, "on the way to it"
    at(3.0, 400.0, 1.5)
    assert math.isclose(queue.last_progress, 0.4, abs_tol=1e-3)
    at(0.0, 400.0, 1.5, [outcome(line, Ended(EndKind.BEHAVIOR))])
    assert queue.inserts[0].progress is Progress.WAITING, "ended too early"
    [line] = at(0.0, 0.0, 1.5, second=3)
    at(0.0, 0.0, 1.5, [outcome(line, Started())], second=3)
    at(3.0, 600.0, 1.5, second=4)
    at(3.0, 600.0, 1.5, [outcome(line, Ended(EndKind.BEHAVIOR))], second=5)
    assert queue.is_done and queue.last_progress == 1.0


def test_a_queue_goes_on_with_the_next_while_the_first_has_to_wait():
    queue = InsertQueue(ahead=1)
    for _ in range(3):
        queue.add(trackline())
    [first] = queue.step(StepInput(control=True))
    # Before anything has begun, what refuses the first refuses all.
    queue.step(StepInput(control=True, events=(outcome(first, TimedOut()),)))
    assert queue.step(StepInput(now_ns=1_000_000_000, control=True)) == []
    [first] = queue.step(StepInput(now_ns=10_000_000_000, control=True))
    ended = (outcome(first, Started()), outcome(first, Ended(EndKind.DONE)))
    [second] = queue.step(StepInput(now_ns=20_000_000_000, control=True, events=ended))
    [third] = queue.step(StepInput(now_ns=30_000_000_000, control=True, events=(outcome(second, TimedOut()),)))
    assert third.tag != second.tag and queue.inserts[1].progress is Progress.WAITING
    assert queue.inserts[2].progress is Progress.ASKED


def test_a_queue_asks_for_nothing_before_the_power_goes():
    queue = InsertQueue()
    queue.add(trackline())
    assert queue.step(StepInput(control=True, events=(Shutdown(),))) == []
    assert queue.step(StepInput(now_ns=1_000_000_000, control=True)) == [] and queue.is_shut_down


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
