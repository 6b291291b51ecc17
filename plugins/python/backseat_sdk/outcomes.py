"""What becomes of requests: refusals before they are sent, states, and ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum

from .values import I64, U32, U64, Position


class Rule(Enum):
    """The rule of the safety monitor that refuses a request.

    - ``KEEP_IN``: it would leave the fence's keep-in zones. ``KEEP_OUT``: it would enter a keep-out zone.
    - ``DEPTH``: it would be shallower or deeper than a keep-in zone allows. ``ALTITUDE``: closer to the bottom.
    - ``SURFACING``: the vehicle would surface where no zone allows it.
    - ``TIME``: a zone is not valid for all of the time that the request needs.
    - ``STATION``: it would leave the allowed box of a hovering vehicle, or enter a forbidden one.
    - ``LIMIT``: a value is out of range. ``GRANT``: the mission does not grant it.
    - ``CONTROL``: the backseat does not have control. ``RECOVERY``: the vehicle is outside the fence.
    - ``NAVIGATION``: navigation is stale, unsteady or missing. ``PLAN``: the vehicle's plan or behavior is unknown.
    - ``PRIORITY``: another plugin steers with higher priority, or already uses what is requested.
    - ``RATE``: requests come too often. ``CAP``: a limit of the mission, the plugin or the time is used up.
    - ``TAG``: the tag belongs to another request, or to none. ``INTERRUPT``: the behavior may not be interrupted.
    - ``IDENTIFIER``: no SPI identifier is reserved on disk.
    - ``DOUBT``: it is unknown whether the vehicle has an earlier insert.
    - ``GPS_HIT``: a GPS hit may be in progress. ``WINDOW``: no acoustic window is open. ``TEXT``: cannot be sent.
    - ``PAUSE``: the vehicle has just refused a modify, or left one unanswered.
    - ``HEARD``: the vehicle does not answer, and the request could not be taken back.
    - ``LAYOUT``: the mission does not say which form of a sentence the vehicle understands.
    - ``PLUGIN``: the plugin has failed. ``STATE``: the vehicle's or an earlier request's state does not allow it.
    """

    KEEP_IN = "keep-in"
    KEEP_OUT = "keep-out"
    DEPTH = "depth"
    ALTITUDE = "altitude"
    SURFACING = "surfacing"
    TIME = "time"
    STATION = "station"
    LIMIT = "limit"
    GRANT = "grant"
    CONTROL = "control"
    RECOVERY = "recovery"
    NAVIGATION = "navigation"
    PLAN = "plan"
    PRIORITY = "priority"
    RATE = "rate"
    CAP = "cap"
    TAG = "tag"
    INTERRUPT = "interrupt"
    IDENTIFIER = "identifier"
    DOUBT = "doubt"
    GPS_HIT = "gps-hit"
    WINDOW = "window"
    TEXT = "text"
    PAUSE = "pause"
    HEARD = "heard"
    LAYOUT = "layout"
    PLUGIN = "plugin"
    STATE = "state"


class EndKind(Enum):
    """The ways in which a request ends.

    - ``DONE``: completed. ``ASKED``: this plugin ended it. ``REPLACED``: another request replaced it.
    - ``TERM``: its duration is over. ``REFUSED``: the vehicle refused it or stopped it.
    - ``NOT_ANSWERED``: the vehicle did not answer. ``LATE``: the runtime or the plugin was too late.
    - ``LINK``: it could not be sent. ``CONTROL``: the backseat no longer has control.
    - ``REFUSAL``: it is no longer allowed by the fence, the limits, or the state of the vehicle or of the runtime.
    - ``FENCE``: the vehicle is outside the fence.
    - ``NAVIGATION``: navigation is stale, has jumped, or is implausible.
    - ``BEHAVIOR``: the vehicle has gone on to another behavior. ``MISSION``: the mission has ended or was replaced.
    - ``PLUGIN``: the plugin failed.
    """

    DONE = "done"
    ASKED = "asked"
    REPLACED = "replaced"
    TERM = "term"
    REFUSED = "refused"
    NOT_ANSWERED = "not-answered"
    LATE = "late"
    LINK = "link"
    CONTROL = "control"
    REFUSAL = "refusal"
    FENCE = "fence"
    NAVIGATION = "navigation"
    BEHAVIOR = "behavior"
    MISSION = "mission"
    PLUGIN = "plugin"


@dataclass(frozen=True)
class Edge:
    """An edge of a zone. Numbers are those of the fence's file, from 1.

    - ``hole``: the hole that it belongs to; ``None`` for the outer ring.
    - ``number``: of the vertex where it begins; it ends at the next one.
    - ``at``: the point on the edge nearest to the request.
    """

    polygon: U32
    hole: U32 | None
    number: U32
    at: Position


@dataclass(frozen=True)
class Refusal:
    """Why a request is refused before it is sent.

    - ``cause``: the exact cause: the name of a value ("speed") or of a state ("plan-unknown"), otherwise the rule's
      name.
    - ``zone``: the zone of the fence, or the box, that the request breaches. ``edge``: the edge of that zone.
    - ``missing_m``: how far the request is from being allowed, metres; ``None`` if this is not a distance.
    - ``value``: the value that is out of range, in the request's unit; for a cap or a rate, what it would reach.
    - ``least``, ``most``: what is allowed: for a value, or for a zone's depth or altitude.
    - ``text``: everything in one line, for people.
    """

    rule: Rule
    cause: str = ""
    zone: str | None = None
    edge: Edge | None = None
    missing_m: float | None = None
    value: float | None = None
    least: float | None = None
    most: float | None = None
    text: str = ""


@dataclass(frozen=True)
class VehicleFailure:
    """The vehicle refused the request, or reported that it failed. The text is the vehicle's own."""

    text: str


@dataclass(frozen=True)
class NotInPlan:
    """The vehicle's plan does not contain the request."""


@dataclass(frozen=True)
class SonarFailure:
    """The sonar's payload controller refused the request, or did not do all of it."""

    text: str


#: Why a request failed after it was sent.
Failure = VehicleFailure | NotInPlan | SonarFailure


@dataclass(frozen=True)
class FrameUnset:
    """The vehicle does not report the frame."""


@dataclass(frozen=True)
class FrameUnacknowledged:
    """The frame was sent, and no acknowledgement was asked for or came."""


@dataclass(frozen=True)
class FrameAcked:
    """The receiving modem has acknowledged the frame."""


@dataclass(frozen=True)
class FrameFailed:
    """The frame could not be sent."""


@dataclass(frozen=True)
class FrameOther:
    """A status that the specification does not define."""

    status: I64


#: What happened to one frame of a packet (BFCPS, SPI 9.2).
FrameOutcome = FrameUnset | FrameUnacknowledged | FrameAcked | FrameFailed | FrameOther


class _Final:
    """States after which nothing more happens to a request."""

    final = True


class _Open:
    """States after which more can happen to a request."""

    final = False


@dataclass(frozen=True)
class Rejected(_Final):
    """Refused before it was sent."""

    refusal: Refusal


@dataclass(frozen=True)
class Sent(_Open):
    """It is on its way to the vehicle."""


@dataclass(frozen=True)
class Pending(_Open):
    """The vehicle is working on it."""


@dataclass(frozen=True)
class Accepted(_Open):
    """The vehicle has accepted it. The vehicle accepts every refresh of a modify separately."""


@dataclass(frozen=True)
class Failed(_Final):
    """The vehicle has refused it."""

    failure: Failure


@dataclass(frozen=True)
class TimedOut(_Final):
    """The vehicle has not answered."""


@dataclass(frozen=True)
class Unknown(_Open):
    """It is unknown whether the vehicle will carry it out: the link was lost before the answer, or the vehicle is on
    another dive, or the operator has cancelled all inserts. The vehicle's plan or its next report will show it."""


@dataclass(frozen=True)
class Started(_Open):
    """The vehicle has begun to carry it out."""


@dataclass(frozen=True)
class Ended(_Final):
    """It has ended.

    - ``cause``: the exact cause, for example "term-over", "flown" or "link-down".
    - ``frames``: for a packet: what happened to each frame.
    - ``text``: everything in one line, for people.
    """

    kind: EndKind
    cause: str = ""
    frames: Sequence[FrameOutcome] = field(default=())
    text: str = ""


@dataclass(frozen=True)
class Cancelled(_Final):
    """It was cancelled before it began."""


#: The state of a request. Each request reaches one state that is ``final``: rejected, failed, timed out, ended or
#: cancelled.
State = Rejected | Sent | Pending | Accepted | Failed | TimedOut | Unknown | Started | Ended | Cancelled


@dataclass(frozen=True)
class Outcome:
    """A new state of the request with this tag."""

    tag: U64
    state: State

    @property
    def reason(self) -> str | None:
        """Why the request was refused, has failed or has ended, in one line for people; otherwise ``None``."""
        match self.state:
            case Rejected(refusal):
                return refusal.text
            case Failed(VehicleFailure(text) | SonarFailure(text)):
                return text
            case Failed(NotInPlan()):
                return "the vehicle's plan does not name it"
            case Ended(text=text):
                return text
            case _:
                return None
