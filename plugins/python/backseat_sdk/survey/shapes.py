"""Lines and boxes in a local frame, and the lines of a lawnmower."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..frame import Local, wrap_180, wrap_360


@dataclass(frozen=True)
class Line:
    """A straight line from one point to another."""

    start: Local
    end: Local

    @property
    def length(self) -> float:
        """Metres."""
        return self.start.distance(self.end)

    @property
    def bearing(self) -> float:
        """From start to end, degrees clockwise from the frame's north."""
        return self.start.bearing(self.end)

    def reversed(self) -> Line:
        """The same line, flown the other way."""
        return Line(self.end, self.start)

    def at(self, distance: float) -> Local:
        """The point so many metres from the start; negative is before it, and beyond the end is allowed."""
        return self.start.offset(self.bearing, distance)

    def along(self, point: Local) -> float:
        """How far along the line a point is, metres from the start."""
        angle, away = math.radians(self.bearing), point - self.start
        return away.east * math.sin(angle) + away.north * math.cos(angle)

    def across(self, point: Local) -> float:
        """How far to starboard of the line a point is, metres."""
        angle, away = math.radians(self.bearing), point - self.start
        return away.east * math.cos(angle) - away.north * math.sin(angle)

    def heading_to_follow(self, point: Local, lookahead: float = 50.0) -> float:
        """The heading that brings a vehicle at ``point`` onto the line and then along it: towards the point of the line
        that is ``lookahead`` metres ahead (line-of-sight guidance: Fossen, Handbook of Marine Craft Hydrodynamics and
        Motion Control, 2011, section 10.3.2). Degrees, 0 to 360."""
        return wrap_360(self.bearing - math.degrees(math.atan2(self.across(point), lookahead)))


@dataclass(frozen=True)
class Box:
    """A rectangle: its centre, its sides in metres, and the direction of its length, degrees clockwise from the frame's
    north."""

    centre: Local
    length: float
    width: float
    bearing: float = 0.0

    @property
    def axis(self) -> Line:
        """The line through the centre along the length."""
        half = self.length / 2.0
        return Line(self.centre.offset(self.bearing, -half), self.centre.offset(self.bearing, half))

    def contains(self, point: Local, margin: float = 0.0) -> bool:
        """Whether a point is inside, at least ``margin`` metres from every side."""
        axis = self.axis
        return (
            margin <= axis.along(point) <= self.length - margin and abs(axis.across(point)) <= self.width / 2.0 - margin
        )

    def corners(self) -> tuple[Local, Local, Local, Local]:
        """Clockwise, beginning at the left end of the side where the length begins."""
        start, end, half = self.axis.start, self.axis.end, self.width / 2.0
        return (
            start.offset(self.bearing - 90.0, half),
            end.offset(self.bearing - 90.0, half),
            end.offset(self.bearing + 90.0, half),
            start.offset(self.bearing + 90.0, half),
        )


def lawnmower(box: Box, spacing: float, begin_near: Local | None = None) -> list[Line]:
    """Lines along the length of a box, flown to and fro, no more than ``spacing`` metres apart and at most half of it
    from the sides. They begin at the corner of the box that is nearest to ``begin_near``.

    Raises ``ValueError`` if the spacing is not above 0, or if there would be more than 10,000 lines.
    """
    if not spacing > 0.0 or not box.width / spacing <= 10_000:
        raise ValueError(f"a spacing of {spacing} m does not fit a box of {box.width} m")
    count = max(1, math.ceil(box.width / spacing - 1e-9))
    apart = box.width / count
    offsets = [(number + 0.5) * apart - box.width / 2.0 for number in range(count)]
    axis = box.axis
    lines = [
        Line(axis.start.offset(box.bearing + 90.0, offset), axis.end.offset(box.bearing + 90.0, offset))
        for offset in offsets
    ]
    if begin_near is not None:
        if abs(axis.across(begin_near) - offsets[-1]) < abs(axis.across(begin_near) - offsets[0]):
            lines.reverse()
        if axis.along(begin_near) > box.length / 2.0:
            lines = [line.reversed() for line in lines]
    return [line if number % 2 == 0 else line.reversed() for number, line in enumerate(lines)]


def turn_between(heading: float, other: float) -> float:
    """The turn from one heading to another, degrees, starboard positive, -180 to 180."""
    return wrap_180(other - heading)
