"""Numbers with a range, positions, and the setpoints of depth and altitude.

Units unless stated otherwise: angles in degrees, headings clockwise from true north; distances in metres; speeds in
metres per second; times in nanoseconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated


@dataclass(frozen=True)
class Within:
    """A range of a number, with both ends: ``Annotated[float, Within(0.0, 360.0)]``."""

    least: float
    most: float


#: A whole number of 64 bits without sign: tags, identifiers of timers, nanoseconds.
U64 = Annotated[int, Within(0, 2**64 - 1)]
#: A whole number of 32 bits without sign.
U32 = Annotated[int, Within(0, 2**32 - 1)]
#: A whole number of 32 bits with sign.
I32 = Annotated[int, Within(-(2**31), 2**31 - 1)]
#: A whole number of 64 bits with sign.
I64 = Annotated[int, Within(-(2**63), 2**63 - 1)]

#: Nanoseconds in a second: ``duration_ns=round(2.5 * SECOND_NS)``.
SECOND_NS = 1_000_000_000


@dataclass(frozen=True)
class Position:
    """A WGS84 position.

    - ``latitude``: degrees, north positive, -90 to 90.
    - ``longitude``: degrees, east positive, -180 to 180.
    """

    latitude: float
    longitude: float


@dataclass(frozen=True)
class Depth:
    """Keep a depth.

    - ``depth``: metres below the surface.
    """

    depth: float


@dataclass(frozen=True)
class Altitude:
    """Keep an altitude.

    - ``altitude``: metres above the seabed. The runtime assumes the deepest water that is possible.
    """

    altitude: float


#: What a request keeps in the vertical.
Vertical = Depth | Altitude
