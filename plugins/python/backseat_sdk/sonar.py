"""Pings and reports of the sonars behind the payload controller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from .values import I32, U32, U64, Position


class SonarSide(Enum):
    """The side that a channel of a sonar looks to. ``OTHER`` is down, or not told: a sub-bottom profiler."""

    PORT = "port"
    STARBOARD = "starboard"
    OTHER = "other"


class Decimation(Enum):
    """How several samples of a sonar became one: by their maximum, which keeps small targets, or by their mean, which
    keeps backscatter comparable."""

    MAXIMUM = "maximum"
    MEAN = "mean"


class PingTime(Enum):
    """Where the time of a ping comes from.

    - ``MEASURED``: the payload controller's time, less the measured offset of its clock.
    - ``CONTROLLER``: the payload controller's time as it is: the offset of its clock is not known.
    - ``ARRIVAL``: the arrival of the record, because it has no time.
    """

    MEASURED = "measured"
    CONTROLLER = "controller"
    ARRIVAL = "arrival"


class AltitudeSource(Enum):
    """Where the altitude of a swath comes from: the vehicle's bottom lock, the first return in the imagery, or nowhere,
    because the sonar's samples are spaced along the ground."""

    BOTTOM_LOCK = "bottom-lock"
    FIRST_RETURN = "first-return"
    GROUND_RANGE = "ground-range"


@dataclass(frozen=True)
class SonarChannel:
    """One channel of a ping (records 3000 and 3001 of the 7k format, volume III).

    - ``ground_range``: the samples are spaced along the ground; if false, along the slant range.
    - ``range``: of the end of the last sample, metres.
    - ``start_ns``: from the ping to the begin of the first sample, ns.
    - ``sample_ns``: from one sample to the next, ns: a mean, because samples that were made of several differ in
      length.
    - ``recorded``: how many samples the record has.
    - ``volts_per_step``: one step of the samples; ``None`` if the record does not have it. It can differ from ping to
      ping.
    - ``samples``: the amplitudes, in steps of the sonar's converter; at most as many as ``[[plugin.ping]]`` allows.
    """

    side: SonarSide
    ground_range: bool
    range: float
    start_ns: U64
    sample_ns: float
    recorded: U32
    volts_per_step: float | None
    samples: Sequence[float]


@dataclass(frozen=True)
class PingNavigation:
    """The vehicle's own navigation at the time of a ping: the last solution that was not later.

    - ``before_ping_ns``: how much older than the ping the solution is, ns.
    - ``east``, ``north``: metres in the mission's local frame.
    - ``depth``: metres below the surface. ``altitude``: metres above the seabed; ``None`` without bottom lock.
    - ``heading``: degrees clockwise from true north. ``roll``, ``pitch``: degrees.
    - ``velocity_east``, ``velocity_north``: over the ground, m/s; ``None`` if the vehicle did not send it.
    """

    before_ping_ns: U64
    position: Position
    east: float
    north: float
    depth: float
    altitude: float | None
    heading: float
    roll: float
    pitch: float
    velocity_east: float | None
    velocity_north: float | None


@dataclass(frozen=True)
class SonarPing:
    """A ping of the sidescan or of the sub-bottom profiler, as fine as the mission's ``[[plugin.ping]]`` says.

    - ``age_ns``: the age of the ping at this step, ns.
    - ``sensor``: the sensor's index in the payload controller.
    - ``number``: the ping's number, by the sonar.
    - ``channels``: one to four.
    - ``navigation``: ``None`` if the vehicle has sent none in the last seconds.
    """

    age_ns: U64
    time_source: PingTime
    sensor: I32
    number: U32
    decimation: Decimation
    channels: Sequence[SonarChannel]
    navigation: PingNavigation | None


@dataclass(frozen=True)
class Swath:
    """How wide a strip of the seabed a sidescan ping shows on a level bottom: an upper bound. At most one a second.

    - ``port``, ``starboard``: over the ground, metres; 0 if the range does not reach the seabed.
    - ``altitude``: that it was computed from, metres.
    """

    sensor: I32
    number: U32
    port: float
    starboard: float
    altitude: float | None
    source: AltitudeSource


@dataclass(frozen=True)
class SonarAlarm:
    """An alarm of the payload controller has begun, ended or happened (table 18 of the 7k format, volume III).

    - ``id``: its number in that table.
    - ``active``: true if it is active, false if it has ended, ``None`` if it only happens.
    - ``sensor``: the sensor that it is about.
    - ``text``: the payload controller's words, cut to 200 bytes.
    """

    id: I32
    active: bool | None
    sensor: I32 | None
    text: str


@dataclass(frozen=True)
class SonarLogging:
    """The state of the payload controller's logging (status 3).

    - ``file``: the name of the log file. ``size_mb``: its size, megabytes.
    - ``missing``: it is off although it was ordered on.
    """

    on: bool
    file: str
    size_mb: float
    missing: bool


@dataclass(frozen=True)
class SensorHealth:
    """Whether a sensor is healthy, by its index in the payload controller."""

    sensor: I32
    healthy: bool


@dataclass(frozen=True)
class SonarReady:
    """Whether the connection to the payload controller is up and set up, so that pings come and requests are sent."""

    ready: bool


@dataclass(frozen=True)
class SonarHealth:
    """The health of the sensors."""

    sensors: Sequence[SensorHealth]


@dataclass(frozen=True)
class ActiveAlarms:
    """All alarms that are active now. Empty when all have ended."""

    alarms: Sequence[SonarAlarm]


@dataclass(frozen=True)
class ControllerShutdown:
    """The payload controller shuts down by itself."""


#: What the payload controller reports. Topic ``SONAR``.
SonarEvent = SonarReady | SonarLogging | SonarHealth | SonarAlarm | ActiveAlarms | Swath | ControllerShutdown


@dataclass(frozen=True)
class SetRange:
    """The range of a sonar: metres, over 0."""

    range: float


@dataclass(frozen=True)
class SetPulse:
    """The pulse, by the sonar's own name for it."""

    pulse: str


@dataclass(frozen=True)
class SetPinging:
    """Pinging on or off."""

    on: bool


@dataclass(frozen=True)
class SetPower:
    """Transmission power, percent."""

    power: float


@dataclass(frozen=True)
class SetGain:
    """The receiver's gain, in the sonar's own steps."""

    gain: I32


@dataclass(frozen=True)
class SetPeriod:
    """Time from ping to ping, milliseconds."""

    period: float


@dataclass(frozen=True)
class SetDefault:
    """All settings as the sonar has them by default. A sonar may ignore this."""


#: A setting of a sonar (table 19 of the 7k format, volume III). The sonar decides which values it takes.
SonarSetting = SetRange | SetPulse | SetPinging | SetPower | SetGain | SetPeriod | SetDefault
