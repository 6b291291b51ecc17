"""What a plugin is told about the mission before its first step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from .frame import Local
from .values import U32, U64, Position


class Grant(Enum):
    """What a mission may allow a plugin to ask for.

    - ``MODIFY``: ``Modify``, ``EndModify``. ``INSERT``: ``Trackline``, ``Trackcircle``, ``Cancel``.
    - ``INTERRUPT``: inserts that interrupt what is being flown; needs ``INSERT`` too.
    - ``MESSAGE``: ``Message``. ``SURFACE``: ``GpsHit``. ``TOPSIDE``: ``Topside``. ``DVL``: ``DvlTrigger``.
    - ``SILENT``: ``Silent``. ``TRIM``: ``AdjustTrim``. ``BUOYANCY``: ``AdjustBuoyancy``. ``ACOUSTIC``: ``Packet``.
    - ``STATION``: ``Station``, ``EndStation``. ``DEVICES``: ``SonarAngle``, ``Camera``, ``Light``.
    - ``SONAR``: ``SonarSet``, ``SonarLog``.
    """

    MODIFY = "modify"
    INSERT = "insert"
    INTERRUPT = "interrupt"
    MESSAGE = "message"
    SURFACE = "surface"
    TOPSIDE = "topside"
    DVL = "dvl"
    SILENT = "silent"
    TRIM = "trim"
    BUOYANCY = "buoyancy"
    ACOUSTIC = "acoustic"
    STATION = "station"
    DEVICES = "devices"
    SONAR = "sonar"


@dataclass(frozen=True)
class Area:
    """An area with holes, in the mission's local frame. A ring's last point is not its first one again.

    - ``outer``: the outer ring, counterclockwise. ``holes``: the rings of its holes, clockwise.
    """

    outer: Sequence[Local]
    holes: Sequence[Sequence[Local]] = ()


@dataclass(frozen=True)
class KeepIn:
    """What only a keep-in zone has.

    - ``altitude_min``: the least altitude above the seabed, metres.
    - ``surfacing``: whether the vehicle may surface here for a GPS fix.
    """

    altitude_min: float
    surfacing: bool = False


@dataclass(frozen=True)
class Zone:
    """A zone of the fence. A request must keep ``margin`` from its edges, and what the vehicle may stray (see
    ``Limits``) on top. Ask ``fence.check`` whether a certain request passes.

    - ``name``: by which refusals call it. ``keep_in``: ``None`` for a keep-out zone.
    - ``margin``: the distance to keep from its edges, metres.
    - ``depth_min``, ``depth_max``: the depths that a keep-in zone allows, or a keep-out zone forbids, metres; ``None``
      for a keep-out zone that reaches to the surface or to the bottom.
    - ``valid_from_ns``, ``valid_until_ns``: since 1970-01-01, UTC; ``None`` if it has no such end.
    - ``areas``: an area of a keep-in zone is allowed by itself: areas that touch are not joined.
    """

    name: str
    keep_in: KeepIn | None
    margin: float
    depth_min: float | None
    depth_max: float | None
    valid_from_ns: U64 | None
    valid_until_ns: U64 | None
    areas: Sequence[Area]


@dataclass(frozen=True)
class Limits:
    """The mission's limits of requests (``[limits]``), and what the runtime assumes about vehicle and sea.

    - ``speed_min``, ``speed_max``: that may be asked for, m/s. ``turn_rate``: always reached, degrees per second.
    - ``current_max``: m/s. ``seabed_slope_max``: metres per metre.
    - ``water_depth_min``, ``water_depth_max``: inside the fence, metres; ``None`` if the mission does not say.
    - ``navigation_error``: how wrong navigation may be, metres. ``tracking_error``, ``vertical_error``: how far the
      vehicle strays from a line and from a depth, metres. ``lead_max``: the longest lead-in of a trackline, metres.
    - ``modify_duration_max_ns``: of one modify, ns.
    - ``inserts_open_max``, ``inserts_total_max``, ``inserts_duration_max_ns``: of all plugins together.
    - ``requests_per_second``: of one plugin. ``gps_hits_total_max``: in the whole mission.
    - ``topside_per_minute``, ``packets_per_minute``: messages to the topside, acoustic packets.
    """

    speed_min: float
    speed_max: float
    turn_rate: float
    current_max: float
    water_depth_min: float | None
    water_depth_max: float | None
    seabed_slope_max: float
    navigation_error: float
    tracking_error: float
    vertical_error: float
    lead_max: float
    modify_duration_max_ns: U64
    inserts_open_max: U32
    inserts_total_max: U32
    inserts_duration_max_ns: U64
    requests_per_second: U32
    gps_hits_total_max: U32
    topside_per_minute: U32
    packets_per_minute: U32


@dataclass(frozen=True)
class Budget:
    """What the plugin may use. A unit of fuel is about one WebAssembly instruction.

    - ``fuel_per_step``, ``fuel_init``, ``fuel_snapshot``: of one step, of a start, of one snapshot.
    - ``memory``: bytes. ``snapshot_every_steps``: 0 if none are taken.
    """

    fuel_per_step: U64
    fuel_init: U64
    fuel_snapshot: U64
    memory: U64
    snapshot_every_steps: U32


@dataclass(frozen=True)
class Briefing:
    """What a plugin is told before its first step. It stays the same for the whole run.

    - ``config``: ``[plugin.config]`` in the mission file, as JSON. The SDK has read it already.
    - ``grants``: what the mission allows the plugin to ask for.
    - ``origin``: of the mission's local frame: ``[origin]`` of the mission file, or without it the centroid of the
      fence's keep-in zones.
    - ``zones``: the whole fence, in the order of its file.
    """

    config: str
    grants: Sequence[Grant]
    origin: Position
    zones: Sequence[Zone]
    limits: Limits
    budget: Budget
