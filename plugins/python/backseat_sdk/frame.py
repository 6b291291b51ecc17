"""A plane of metres east and north around an origin, on WGS84."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .values import Position

#: WGS84: semi-major axis, metres, and flattening (NIMA TR8350.2, table 3.1).
SEMI_MAJOR_AXIS_M = 6_378_137.0
FLATTENING = 1.0 / 298.257_223_563
#: First and second eccentricity, squared.
E2 = FLATTENING * (2.0 - FLATTENING)
EP2 = E2 / (1.0 - E2)


def wrap_360(degrees: float) -> float:
    """An angle, wrapped into 0 to 360 without 360."""
    wrapped = math.fmod(degrees, 360.0)
    if wrapped < 0.0:
        wrapped += 360.0
    return 0.0 if wrapped >= 360.0 else wrapped


def wrap_180(degrees: float) -> float:
    """An angle, wrapped into -180 to 180 without 180."""
    wrapped = wrap_360(degrees)
    return wrapped - 360.0 if wrapped >= 180.0 else wrapped


@dataclass(frozen=True)
class Local:
    """A point of a local frame, or the vector between two points: metres east and north."""

    east: float
    north: float

    def __add__(self, other: Local) -> Local:
        return Local(self.east + other.east, self.north + other.north)

    def __sub__(self, other: Local) -> Local:
        return Local(self.east - other.east, self.north - other.north)

    def __mul__(self, factor: float) -> Local:
        return Local(self.east * factor, self.north * factor)

    def distance(self, other: Local) -> float:
        """The distance to another point, metres."""
        return math.hypot(other.east - self.east, other.north - self.north)

    def bearing(self, other: Local) -> float:
        """The direction to another point, degrees clockwise from the frame's north, 0 to 360."""
        return wrap_360(math.degrees(math.atan2(other.east - self.east, other.north - self.north)))

    def offset(self, bearing: float, distance: float) -> Local:
        """The point ``distance`` metres away in the direction ``bearing``, degrees clockwise from the frame's north."""
        angle = math.radians(bearing)
        return Local(self.east + distance * math.sin(angle), self.north + distance * math.cos(angle))


class LocalFrame:
    """A plane east-north frame around an origin: the transverse Mercator projection of WGS84 with its central meridian
    through the origin and scale 1, as the runtime's own frame.

    Within 50 km of the origin, distances are true to 31 ppm, and a conversion there and back changes a position by less
    than a millimetre. The formulas fail at the poles: use it within 85 degrees of latitude.

    Source: Snyder, Map Projections: A Working Manual, USGS Professional Paper 1395 (1987), equations 3-21, 8-9 to 8-15
    and 8-17 to 8-25.
    """

    def __init__(self, origin: Position) -> None:
        self.origin = origin
        self._origin_arc = _meridian_arc(math.radians(origin.latitude))

    def to_local(self, position: Position) -> Local:
        """A position in this frame."""
        latitude = math.radians(position.latitude)
        sin, cos = math.sin(latitude), math.cos(latitude)
        tan = sin / cos
        n = SEMI_MAJOR_AXIS_M / math.sqrt(1.0 - E2 * sin * sin)
        t, c = tan * tan, EP2 * cos * cos
        a = math.radians(wrap_180(position.longitude - self.origin.longitude)) * cos
        a2 = a * a
        east = n * a * (1.0 + a2 / 6.0 * (1.0 - t + c + a2 / 20.0 * (5.0 - 18.0 * t + t * t + 72.0 * c - 58.0 * EP2)))
        sixth = a2 / 30.0 * (61.0 - 58.0 * t + t * t + 600.0 * c - 330.0 * EP2)
        fourth = a2 / 24.0 * (5.0 - t + 9.0 * c + 4.0 * c * c + sixth)
        north = _meridian_arc(latitude) - self._origin_arc + n * tan * a2 * (0.5 + fourth)
        return Local(east, north)

    def to_position(self, point: Local) -> Position:
        """The position of a point of this frame."""
        root = math.sqrt(1.0 - E2)
        e1 = (1.0 - root) / (1.0 + root)
        arc = self._origin_arc + point.north
        mu = arc / (SEMI_MAJOR_AXIS_M * (1.0 - E2 / 4.0 - 3.0 * E2 * E2 / 64.0 - 5.0 * E2 * E2 * E2 / 256.0))
        footpoint = (
            mu
            + (1.5 * e1 - 27.0 / 32.0 * e1**3) * math.sin(2.0 * mu)
            + (21.0 / 16.0 * e1**2 - 55.0 / 32.0 * e1**4) * math.sin(4.0 * mu)
            + 151.0 / 96.0 * e1**3 * math.sin(6.0 * mu)
            + 1097.0 / 512.0 * e1**4 * math.sin(8.0 * mu)
        )
        sin, cos = math.sin(footpoint), math.cos(footpoint)
        tan = sin / cos
        c, t, w = EP2 * cos * cos, tan * tan, 1.0 - E2 * sin * sin
        n = SEMI_MAJOR_AXIS_M / math.sqrt(w)
        r = n * (1.0 - E2) / w
        d = point.east / n
        d2 = d * d
        sixth = d2 / 30.0 * (61.0 + 90.0 * t + 298.0 * c + 45.0 * t * t - 252.0 * EP2 - 3.0 * c * c)
        fourth = d2 / 24.0 * (5.0 + 3.0 * t + 10.0 * c - 4.0 * c * c - 9.0 * EP2 - sixth)
        latitude = footpoint - n * tan / r * d2 * (0.5 - fourth)
        fifth = d2 / 20.0 * (5.0 - 2.0 * c + 28.0 * t - 3.0 * c * c + 8.0 * EP2 + 24.0 * t * t)
        longitude = d * (1.0 - d2 / 6.0 * (1.0 + 2.0 * t + c - fifth)) / cos
        return Position(
            max(-90.0, min(90.0, math.degrees(latitude))),
            wrap_180(self.origin.longitude + math.degrees(longitude)),
        )

    def convergence(self, position: Position) -> float:
        """The angle from true north to the frame's north at a position, degrees, positive clockwise. Subtract it from a
        true heading to get a bearing of the frame. Source: Snyder, page 51."""
        longitude = math.radians(wrap_180(position.longitude - self.origin.longitude))
        return math.degrees(math.atan(math.tan(longitude) * math.sin(math.radians(position.latitude))))


def _meridian_arc(latitude: float) -> float:
    """Distance along the meridian from the equator, metres. Snyder 3-21."""
    e4, e6 = E2 * E2, E2 * E2 * E2
    return SEMI_MAJOR_AXIS_M * (
        (1.0 - E2 / 4.0 - 3.0 * e4 / 64.0 - 5.0 * e6 / 256.0) * latitude
        - (3.0 * E2 / 8.0 + 3.0 * e4 / 32.0 + 45.0 * e6 / 1024.0) * math.sin(2.0 * latitude)
        + (15.0 * e4 / 256.0 + 45.0 * e6 / 1024.0) * math.sin(4.0 * latitude)
        - 35.0 * e6 / 3072.0 * math.sin(6.0 * latitude)
    )
