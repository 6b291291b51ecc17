"""The gradient of a field from measurements along a track: a plane by least squares."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from ..frame import Local, wrap_360


@dataclass(frozen=True)
class Slope:
    """A plane through measurements.

    - ``value``: at the point for which it was made.
    - ``east``, ``north``: how fast the value grows, per metre.
    - ``residual``: root mean square of what the plane does not explain, in the value's unit.
    """

    value: float
    east: float
    north: float
    residual: float

    @property
    def steepness(self) -> float:
        """How fast the value grows in the steepest direction, per metre."""
        return math.hypot(self.east, self.north)

    @property
    def bearing(self) -> float:
        """The direction in which the value grows, degrees clockwise from the frame's north."""
        return wrap_360(math.degrees(math.atan2(self.east, self.north)))


@dataclass
class PlaneFit:
    """A plane through the newest measurements.

    - ``keep``: how many measurements are kept.
    - ``reach_m``: a measurement weighs less the farther away it is: 61 % at this distance, 14 % at twice of it.
    """

    keep: int = 60
    reach_m: float = 200.0
    points: list[tuple[float, float, float]] = field(default_factory=list)

    def add(self, place: Local, value: float) -> None:
        """Adds a measurement. A value that is not finite is left out."""
        if math.isfinite(value):
            self.points.append((place.east, place.north, value))
            del self.points[: -self.keep]

    def at(self, place: Local) -> Slope | None:
        """The plane around a place; ``None`` if the measurements do not determine it, because there are fewer than
        three or they lie on a straight line."""
        weighted = []
        for east, north, value in self.points:
            x, y = east - place.east, north - place.north
            weighted.append((math.exp(-0.5 * (x * x + y * y) / (self.reach_m * self.reach_m)), x, y, value))
        return _plane(weighted)


def _plane(points: Sequence[tuple[float, float, float, float]]) -> Slope | None:
    """The plane through points (weight, x, y, value), by the normal equations around their mean."""
    total = sum(w for w, _, _, _ in points)
    if len(points) < 3 or total <= 0.0:
        return None
    mx, my, mv = (sum(p[0] * p[i] for p in points) / total for i in (1, 2, 3))
    xx = sum(w * (x - mx) ** 2 for w, x, _, _ in points)
    yy = sum(w * (y - my) ** 2 for w, _, y, _ in points)
    xy = sum(w * (x - mx) * (y - my) for w, x, y, _ in points)
    xv = sum(w * (x - mx) * (v - mv) for w, x, _, v in points)
    yv = sum(w * (y - my) * (v - mv) for w, _, y, v in points)
    determinant = xx * yy - xy * xy
    # On a line, one of the two spreads is nothing beside the other.
    if determinant <= 1e-4 * (0.5 * (xx + yy)) ** 2:
        return None
    east = (xv * yy - yv * xy) / determinant
    north = (yv * xx - xv * xy) / determinant
    value = mv - east * mx - north * my
    square = sum(w * (v - value - east * x - north * y) ** 2 for w, x, y, v in points) / total
    return Slope(value, east, north, math.sqrt(square))
