"""The local frame, against numbers that others computed and against the runtime's own frame."""

import math
import random

import pytest
from backseat_sdk import Position
from backseat_sdk.frame import Local, LocalFrame, wrap_180, wrap_360
from backseat_sdk.testing import navigation


def test_it_agrees_with_an_independent_projection():
    # 40 30 N, 73 30 W in UTM zone 18 (scale 0.9996, false easting 500 km), as PROJ 9 computes it: the same numbers as
    # in the tests of runtime/units/src/frame.rs.
    point = LocalFrame(Position(0.0, -75.0)).to_local(Position(40.5, -73.5))
    assert abs(point.east * 0.9996 + 500_000.0 - 627_103.0873) < 1e-3
    assert abs(point.north * 0.9996 - 4_484_335.4017) < 1e-3


def test_a_frame_works_across_the_date_line():
    frame = LocalFrame(Position(10.0, 179.999))
    point = frame.to_local(Position(10.0, -179.999))
    assert abs(point.east - 219.29) < 0.1
    assert abs(frame.to_position(point).longitude + 179.999) < 1e-9


def test_a_round_trip_moves_a_point_by_less_than_a_millimetre():
    draw = random.Random(1)
    for _ in range(500):
        frame = LocalFrame(Position(draw.uniform(-80.0, 80.0), draw.uniform(-180.0, 180.0)))
        point = Local(draw.uniform(-50e3, 50e3), draw.uniform(-50e3, 50e3))
        assert point.distance(frame.to_local(frame.to_position(point))) < 1e-3


def test_convergence_is_the_direction_of_true_north():
    draw = random.Random(2)
    for _ in range(200):
        frame = LocalFrame(Position(draw.uniform(-75.0, 75.0), 12.0))
        here = frame.to_position(Local(draw.uniform(-50e3, 50e3), draw.uniform(-50e3, 50e3)))
        north = Position(here.latitude + 1e-4, here.longitude)
        bearing = frame.to_local(here).bearing(frame.to_local(north))
        assert abs(wrap_180(bearing) + frame.convergence(here)) < 1e-4


@pytest.mark.parametrize(
    "degrees, full, half",
    [(0, 0, 0), (360, 0, 0), (-90, 270, -90), (180, 180, -180), (539, 179, 179), (-1e-18, 0, 0)],
)
def test_angles_wrap_into_their_half_open_ranges(degrees, full, half):
    assert wrap_360(degrees) == full
    assert wrap_180(degrees) == half


def test_a_navigation_gives_positions_of_the_mission_s_frame():
    frame = LocalFrame(Position(42.0, -70.0))
    here = Local(3000.0, -2000.0)
    nav = navigation(position=frame.to_position(here), east=here.east, north=here.north)
    there = Local(3100.0, -1200.0)
    assert frame.to_local(nav.position_of(there)).distance(there) < 0.5


def test_bearings_and_offsets_count_clockwise_from_north():
    here = Local(10.0, 20.0)
    there = here.offset(90.0, 5.0)
    assert math.isclose(there.east, 15.0) and math.isclose(there.north, 20.0)
    assert math.isclose(here.bearing(there), 90.0)
    assert math.isclose(here.distance(there), 5.0)
