"""What a plugin can ask for.

The grant that each request needs is in brackets; the mission lists the grants of each plugin. A ``tag`` is the plugin's
own number for a request: every outcome carries it. Use a new tag for each request that you want to follow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from .sonar import SonarSetting
from .values import I32, U32, U64, Position, Vertical

#: The longest text of a request, bytes. A longer one is a failure of the plugin.
TEXT_BYTES = 256
#: The most frames in a ``Packet`` (SPI 9.4).
FRAMES = 8
#: The longest frame in a ``Packet``, bytes. The modem's mode may allow less.
FRAME_BYTES = 1024


class Transport(Enum):
    """The link over which a message travels between vehicle and topside (SPI 5.5, 7.3), fastest first. The acoustic
    modem carries a few 26-byte packets a minute."""

    ETHERNET = "ethernet"
    WIFI = "wifi"
    RADIO_MODEM = "radio-modem"
    ACOUSTIC_MODEM = "acoustic-modem"


@dataclass(frozen=True)
class Modify:
    """Steer the vehicle for some time: BPRMB (SPI 7.12). (modify)

    The runtime refreshes the command until ``duration_ns`` is over, or until the modify is replaced or ended.

    - ``heading``: degrees, -360 to 360.
    - ``speed``: m/s.
    - ``duration_ns``: ns; the mission limits it.
    """

    tag: U64
    heading: float
    vertical: Vertical
    speed: float
    duration_ns: U64


@dataclass(frozen=True)
class EndModify:
    """End this plugin's modify now: BPEMB (SPI 7.13). (modify)"""


@dataclass(frozen=True)
class Trackline:
    """A straight survey line: BPRTK (SPI 7.5). Once the vehicle has accepted it, it flies the line by itself. (insert)

    - ``speed``: m/s.
    - ``interrupt``: interrupt the current behavior, which needs the grant ``interrupt`` too; if false, fly the line
      after it.
    """

    tag: U64
    start: Position
    end: Position
    vertical: Vertical
    speed: float
    interrupt: bool = False


@dataclass(frozen=True)
class Trackcircle:
    """A circle: BPRTC (SPI 7.6). Once the vehicle has accepted it, it flies the circle by itself. (insert)

    - ``radius``: metres.
    - ``orbits``: number of rounds, positive clockwise, negative counterclockwise.
    - ``speed``: m/s.
    - ``entry_angle``: where on the circle to begin, degrees: 0 is its northernmost point, 180 its southernmost. If
      ``None``, the vehicle chooses.
    - ``interrupt``: interrupt the current behavior, which needs the grant ``interrupt`` too.
    """

    tag: U64
    centre: Position
    radius: float
    orbits: float
    vertical: Vertical
    speed: float
    entry_angle: float | None = None
    interrupt: bool = False


@dataclass(frozen=True)
class Cancel:
    """Cancel the trackline or trackcircle with this tag, if it has not begun (BPRCN, SPI 7.8). (insert)"""

    tag: U64


@dataclass(frozen=True)
class Message:
    """Write a line of at most 256 bytes to the vehicle's own log (BPMSG, SPI 7.18). Has no outcome. (message)"""

    text: str


@dataclass(frozen=True)
class GpsHit:
    """Surface at a position and take a GPS fix: BPRGP (SPI 7.7). The vehicle climbs in a straight line. Allowed only
    where the fence permits surfacing, and cannot be cancelled. (surface)"""

    tag: U64
    position: Position


@dataclass(frozen=True)
class Topside:
    """A message to the topside: BPTOP (SPI 7.3). (topside)

    - ``slowest``: the slowest link over which the message is still worth sending. The vehicle may ignore this.
    - ``text``: 1 to 200 bytes of printable ASCII without comma, asterisk and dollar, and without the three-letter name
      of a command in upper case (RMB, TOP). An invalid text is rejected, never corrected.
    """

    tag: U64
    slowest: Transport
    text: str


@dataclass(frozen=True)
class DvlTrigger:
    """The payload's side of the handshake for triggering the DVL: BPDVR (SPI 7.4). (dvl)

    Begin with only ``external`` set. Later requests with the same tag are steps of the same handshake. While the
    payload triggers the DVL, repeat the request at least every 5 s. When ``DvlTriggerAllowed`` is false, answer within
    1 s: with both fields false to end the handshake, or with only ``external`` set to continue when the vehicle allows
    it again.

    - ``external``: the payload wants to trigger the DVL.
    - ``triggering``: it is triggering the DVL now; allowed only after ``DvlTriggerAllowed`` was true.
    """

    tag: U64
    external: bool
    triggering: bool


@dataclass(frozen=True)
class Silent:
    """Make the vehicle silent, or end its silence: BPSIL (SPI 7.22). (silent)

    The vehicle must not be under way. It ends the silence by itself after 5 min. ``Started`` reports that it is silent,
    ``Ended`` that it may no longer be silent.
    """

    tag: U64
    silent: bool


@dataclass(frozen=True)
class AdjustTrim:
    """Let the vehicle adjust its trim (BPTRM, SPI 7.23). (trim)"""

    tag: U64


@dataclass(frozen=True)
class AdjustBuoyancy:
    """Let the vehicle adjust its buoyancy (BPBOY, SPI 7.24). (buoyancy)"""

    tag: U64


@dataclass(frozen=True)
class Packet:
    """A packet for the acoustic modem: BPCPD (SPI 9.4). Only allowed during a ``Window``. (acoustic)

    - ``destination``: the address of the receiving modem.
    - ``mode``: telemetry mode, as the modem numbers them.
    - ``acknowledge``: whether the receiving modem is to acknowledge the packet.
    - ``frames``: one to eight of at most 1024 bytes each; the mode may allow less.
    """

    tag: U64
    destination: U32
    mode: I32
    acknowledge: bool
    frames: Sequence[bytes]

    @staticmethod
    def of(tag: int, destination: int, mode: int, data: bytes, frame_bytes: int) -> Packet | None:
        """Splits data into frames of ``frame_bytes`` bytes each; the last may be shorter. ``None`` if there is no data,
        if a frame is longer than ``FRAME_BYTES``, or if more than ``FRAMES`` would be needed."""
        if not data or not 1 <= frame_bytes <= FRAME_BYTES or len(data) > FRAMES * frame_bytes:
            return None
        frames = tuple(data[at : at + frame_bytes] for at in range(0, len(data), frame_bytes))
        return Packet(tag, destination, mode, False, frames)


@dataclass(frozen=True)
class Here:
    """Stay at the current position."""


@dataclass(frozen=True)
class HullPosition:
    """A position on a ship's hull (BPGHP, SPI 8.6): distance along, across and from the hull, metres."""

    horizontal: float
    vertical: float
    distance: float


@dataclass(frozen=True)
class BottomPosition:
    """A position over the bottom, metres in the vehicle's inertial frame, as in ``Cartesian`` (BPGBP, SPI 8.7)."""

    x: float
    y: float
    vertical: Vertical


#: Where a hovering vehicle is to stay.
StationTarget = Here | HullPosition | BottomPosition


@dataclass(frozen=True)
class Station:
    """Suspend a hovering vehicle's mission and let it keep its station, or move to another position: BPSUS, BPCON,
    BPGHP, BPGBP (SPI 8). The request lasts until ``duration_ns`` is over, or until it is replaced or ended. (station)

    - ``speed``: limit for moves, m/s (BPSPD, SPI 8.4); if ``None``, the vehicle's own limit.
    """

    tag: U64
    target: StationTarget
    speed: float | None
    duration_ns: U64


@dataclass(frozen=True)
class EndStation:
    """End this plugin's station keeping now: BPRES (SPI 8.3). (station)"""


@dataclass(frozen=True)
class SonarAngle:
    """Turn a hovering vehicle's sonar, degrees: BPSAN (SPI 8.5). (devices)"""

    tag: U64
    angle: float


@dataclass(frozen=True)
class Camera:
    """Move a hovering vehicle's camera: BPPTZ (SPI 8.10). Each value is within -9 to 9 and means tenths of a second of
    movement. (devices)"""

    tag: U64
    pan: I32
    tilt: I32
    zoom: I32


@dataclass(frozen=True)
class Light:
    """Switch a hovering vehicle's light, by its number: BPLIT (SPI 8.11). (devices)"""

    tag: U64
    light: I32
    on: bool


@dataclass(frozen=True)
class SonarSet:
    """Change a setting of a sonar. (sonar)

    - ``sensor``: the sensor's index in the payload controller; one of the mission's ``[[sonar.sensor]]``.
    """

    tag: U64
    sensor: I32
    setting: SonarSetting


@dataclass(frozen=True)
class SonarLog:
    """Switch the payload controller's logging. (sonar)

    - ``file``: the name of the log file, only with ``on``: 1 to 64 ASCII characters without path separators. If
      ``None``, the payload controller chooses one.
    """

    tag: U64
    on: bool
    file: str | None = None


@dataclass(frozen=True)
class Timer:
    """Receive ``TimerExpired`` with this ``id`` after a time, ns. Needs no grant. See also ``survey.Timers``."""

    id: U64
    after_ns: U64


#: A request of a plugin.
Request = (
    Modify
    | EndModify
    | Trackline
    | Trackcircle
    | Cancel
    | Message
    | GpsHit
    | Topside
    | DvlTrigger
    | Silent
    | AdjustTrim
    | AdjustBuoyancy
    | Packet
    | Station
    | EndStation
    | SonarAngle
    | Camera
    | Light
    | SonarSet
    | SonarLog
    | Timer
)


def is_plain(text: str) -> bool:
    """Whether a text can be sent in a sentence: printable ASCII without comma, asterisk and dollar (SPI 4.2), at most
    ``TEXT_BYTES`` bytes."""
    return len(text) <= TEXT_BYTES and all(" " <= character <= "~" and character not in ",*$" for character in text)
