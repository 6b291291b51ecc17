"""What has happened since the last step, and the topics under which a plugin asks for it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TypeVar

from .navigation import Cartesian, Navigation, Relative
from .outcomes import Outcome
from .requests import Transport
from .samples import Ctd, Sample
from .sonar import SonarEvent, SonarPing
from .values import I32, SECOND_NS, U32, U64, Position

E = TypeVar("E")


class Topic(Enum):
    """The events and values that only a plugin that lists them in its description receives.

    Every plugin receives ``Outcome``, ``Control``, ``TimerExpired``, ``Restored`` and ``Shutdown``, and a plugin with
    the grant ``dvl`` receives ``DvlTriggerAllowed``. ``RELATIVE_NAVIGATION`` fills ``StepInput.relative`` and
    ``StepInput.cartesian``.
    """

    CTD = "ctd"
    MISSION_COMMAND = "mission-command"
    BEHAVIOR = "behavior"
    LOGGING = "logging"
    TOPSIDE = "topside"
    ACOUSTIC = "acoustic"
    PLAN = "plan"
    TELEMETRY = "telemetry"
    SOUND_VELOCITY = "sound-velocity"
    COMPASS = "compass"
    PRESSURE = "pressure"
    VEHICLE_SPEED = "vehicle-speed"
    BATTERY = "battery"
    SURFACES = "surfaces"
    DVL = "dvl"
    DVL_BEAMS = "dvl-beams"
    IMU = "imu"
    SERVO = "servo"
    TRIM = "trim"
    BUOYANCY = "buoyancy"
    RELATIVE_NAVIGATION = "relative-navigation"
    SIDESCAN = "sidescan"
    SUB_BOTTOM = "sub-bottom"
    SONAR = "sonar"


@dataclass(frozen=True)
class Control:
    """Whether the backseat has control of the vehicle. Without it, requests are rejected."""

    granted: bool


@dataclass(frozen=True)
class MissionCommand:
    """A mission command for the payload (BFMSC, SPI 5.1). Topic ``MISSION_COMMAND``."""

    text: str


@dataclass(frozen=True)
class Behavior:
    """A behavior of the vehicle.

    - ``kind``: the vehicle's name for it: "trackline", "waypoint", "setpoint" and others.
    - ``tag``: if the behavior is a request of this plugin.
    """

    kind: str
    tag: U64 | None


@dataclass(frozen=True)
class BehaviorBegan:
    """The vehicle has begun a behavior. Topic ``BEHAVIOR``."""

    behavior: Behavior


@dataclass(frozen=True)
class BehaviorEnded:
    """The vehicle has ended a behavior. Topic ``BEHAVIOR``."""

    behavior: Behavior


@dataclass(frozen=True)
class TimerExpired:
    """The time of a ``Timer`` is over."""

    id: U64


@dataclass(frozen=True)
class Restored:
    """The plugin had failed. This is a new instance; ``restore`` was called before if there was a snapshot.

    - ``lost_steps``: inputs since the last snapshot, which this instance has not seen.
    - ``open``: the tags of this plugin's requests that have no final state yet.
    """

    lost_steps: U64
    open: Sequence[int]


@dataclass(frozen=True)
class Shutdown:
    """The payload's power goes off in a minute (BFSHT, SPI 5.2)."""


@dataclass(frozen=True)
class LoggingBegan:
    """The vehicle has begun the lead-in of a survey line: start to log data (BFBDL, SPI 5.3). The text is the mission
    planner's. Topic ``LOGGING``."""

    text: str


@dataclass(frozen=True)
class LoggingEnded:
    """The lead-out is over: stop logging data (BFSDL, SPI 5.4). Topic ``LOGGING``."""

    text: str


@dataclass(frozen=True)
class TopsideMessage:
    """A message from the topside (BFTOP, SPI 5.5). Topic ``TOPSIDE``.

    - ``transport``: the link that it came over; ``None`` if the specification has no number for it.
    """

    transport: Transport | None
    text: str


@dataclass(frozen=True)
class DvlTriggerAllowed:
    """Whether the vehicle allows the payload to trigger the DVL (BFDVT, SPI 5.6)."""

    allowed: bool


@dataclass(frozen=True)
class Window:
    """A period in which the payload may send through the acoustic modem (BFCMA, SPI 9.1). Topic ``ACOUSTIC``.

    - ``until_ns``: when it ends, on the clock of ``StepInput.now_ns``.
    - ``address``: the modem's address. ``device``: its kind: "Sonardyne6G", "WHOI", "WHOIPSK".
    """

    until_ns: U64
    address: U32
    device: str


@dataclass(frozen=True)
class ReceivedFrame:
    """A frame, and whether it was received without errors. Damaged frames are passed on too."""

    good: bool
    data: bytes


@dataclass(frozen=True)
class ReceivedPacket:
    """A packet that the acoustic modem received (BFCPR, SPI 9.3). Topic ``ACOUSTIC``.

    - ``age_ns``: how long before this step it was received, ns.
    - ``source``: the address of the sending modem. ``destination``: of the modem that it was sent to.
    - ``mode``: telemetry mode; ``None`` if unknown.
    """

    age_ns: U64
    source: U32
    destination: U32
    mode: I32 | None
    frames: Sequence[ReceivedFrame]


@dataclass(frozen=True)
class PlannedPoint:
    """A point of the vehicle's plan; ``east`` and ``north`` are metres in the mission's local frame."""

    position: Position
    east: float
    north: float


@dataclass(frozen=True)
class PlannedElement:
    """An element of the vehicle's plan (BFPLN, SPI 6.20).

    - ``number``: its number in the dive file; ``None`` for an insert.
    - ``identifier``: of an insert, which its payload has chosen.
    - ``points``: in the order in which the vehicle passes them.
    """

    number: U32 | None
    identifier: U32 | None
    points: Sequence[PlannedPoint]


@dataclass(frozen=True)
class Plan:
    """The vehicle has sent its whole plan, for the first time or again; elements in the order of flight. Topic
    ``PLAN``."""

    elements: Sequence[PlannedElement]


@dataclass(frozen=True)
class Sidescan:
    """A ping of the sidescan (record 3000). A plugin that is slower than its pings gets the newest 16. Topic
    ``SIDESCAN``."""

    ping: SonarPing


@dataclass(frozen=True)
class SubBottom:
    """A ping of the sub-bottom profiler (record 3001). Topic ``SUB_BOTTOM``."""

    ping: SonarPing


#: What has happened since the last step.
Event = (
    Control
    | Outcome
    | Ctd
    | MissionCommand
    | BehaviorBegan
    | BehaviorEnded
    | TimerExpired
    | Restored
    | Shutdown
    | LoggingBegan
    | LoggingEnded
    | TopsideMessage
    | DvlTriggerAllowed
    | Window
    | ReceivedPacket
    | Plan
    | Sample
    | Sidescan
    | SubBottom
    | SonarEvent
)


@dataclass(frozen=True)
class StepInput:
    """What a step is given.

    - ``now_ns``: time since the start of the run, ns.
    - ``utc_ns``: time since 1970-01-01, UTC, ns.
    - ``navigation``: ``None`` until the vehicle has sent its position, and while that is stale.
    - ``relative``, ``cartesian``: present while fresh, with the topic ``RELATIVE_NAVIGATION``.
    - ``control``: whether the backseat has control of the vehicle.
    - ``events``: oldest first.
    """

    now_ns: U64 = 0
    utc_ns: U64 = 0
    navigation: Navigation | None = None
    relative: Relative | None = None
    cartesian: Cartesian | None = None
    control: bool = False
    events: Sequence[Event] = ()

    @property
    def now_s(self) -> float:
        """Time since the start of the run, seconds."""
        return self.now_ns / SECOND_NS

    def of(self, kind: type[E]) -> Iterator[E]:
        """The events of one kind: ``for ctd in input.of(Ctd)``."""
        return (event for event in self.events if isinstance(event, kind))
