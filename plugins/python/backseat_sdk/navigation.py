"""Where the vehicle is, by its own navigation."""

from __future__ import annotations

from dataclasses import dataclass

from .frame import Local, LocalFrame
from .values import U64, Position


@dataclass(frozen=True)
class Navigation:
    """Where the vehicle is and how it moves (BFNVG and BFNVR, SPI 6.1 and 6.2).

    - ``age_ns``: the age of the solution at this step, ns.
    - ``position``: WGS84.
    - ``east``, ``north``: the same position in the mission's local frame, metres from its origin
      (``Briefing.origin``).
    - ``depth``: metres below the surface, positive down.
    - ``altitude``: metres above the seabed; ``None`` without bottom lock.
    - ``heading``: degrees clockwise from true north. The runtime has removed the grid's convergence.
    - ``roll``, ``pitch``: degrees.
    - ``velocity_east``, ``velocity_north``, ``velocity_down``: over the ground, m/s.
    - ``yaw_rate``: degrees per second, clockwise positive.
    - ``gps``: the solution includes GPS, so the vehicle is at the surface.
    """

    age_ns: U64
    position: Position
    east: float
    north: float
    depth: float
    altitude: float | None
    heading: float
    roll: float
    pitch: float
    velocity_east: float
    velocity_north: float
    velocity_down: float
    yaw_rate: float
    gps: bool

    @property
    def local(self) -> Local:
        """The position in the mission's local frame."""
        return Local(self.east, self.north)

    @property
    def water_depth(self) -> float | None:
        """Depth and altitude together, metres; ``None`` without bottom lock."""
        return None if self.altitude is None else self.depth + self.altitude

    def position_of(self, point: Local) -> Position:
        """The latitude and longitude of a point of the mission's local frame.

        The conversion starts from the vehicle's own position, and is accurate to a few centimetres within a kilometre
        of it.
        """
        return LocalFrame(self.position).to_position(point - self.local)


@dataclass(frozen=True)
class Relative:
    """The position of a hovering vehicle relative to its target (BFRNV, SPI 6.17).

    - ``age_ns``: the age of the measurement at this step, ns.
    - ``horizontal``, ``vertical``: distance along and across the target, metres.
    - ``distance``: from the target, metres.
    - ``heading``: degrees relative to the target; 0 faces it.
    - ``depth``: metres below the surface, positive down.
    - ``absolute_heading``: degrees in the vehicle's inertial frame, relative to neither the target nor north.
    - ``roll``, ``pitch``: degrees.
    """

    age_ns: U64
    horizontal: float
    vertical: float
    distance: float
    heading: float
    depth: float
    absolute_heading: float
    roll: float
    pitch: float


@dataclass(frozen=True)
class Cartesian:
    """The position of a hovering vehicle in its own inertial frame, which is not the mission's local frame (BFCNV,
    SPI 6.19).

    - ``age_ns``: the age of the measurement at this step, ns.
    - ``x``, ``y``, ``z``: metres.
    - ``heading``: degrees relative to the target; 0 faces it.
    """

    age_ns: U64
    x: float
    y: float
    z: float
    heading: float
