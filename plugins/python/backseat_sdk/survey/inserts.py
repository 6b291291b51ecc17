"""A queue of tracklines and trackcircles that are flown one after the other, with retries."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum

from ..events import Restored, StepInput
from ..outcomes import Accepted, Cancelled, EndKind, Ended, Failed, Outcome, Rejected, Rule, Started, TimedOut, Unknown
from ..requests import Cancel, Trackcircle, Trackline
from ..values import SECOND_NS


class Progress(Enum):
    """How far an insert has come."""

    WAITING = "waiting"
    ASKED = "asked"
    ACCEPTED = "accepted"
    FLYING = "flying"
    UNKNOWN = "unknown"
    FLOWN = "flown"
    GIVEN_UP = "given up"


#: Refusals that pass by themselves. Another refusal would come again, so it ends the insert.
_PASSING = (
    Rule.CONTROL,
    Rule.RECOVERY,
    Rule.NAVIGATION,
    Rule.PLAN,
    Rule.PRIORITY,
    Rule.RATE,
    Rule.INTERRUPT,
    Rule.DOUBT,
    Rule.GPS_HIT,
    Rule.PAUSE,
    Rule.HEARD,
    Rule.STATE,
)


@dataclass
class Insert:
    """A trackline or a trackcircle in the queue. ``why`` is the last reason for which it was not flown."""

    request: Trackline | Trackcircle
    progress: Progress = Progress.WAITING
    attempts: int = 0
    not_before_ns: int = 0
    why: str = ""


@dataclass
class InsertQueue:
    """Inserts that are asked for in their order, at most ``ahead`` at a time, so that the vehicle always has the next
    one.

    Call ``step`` in each step of the plugin, and return what it returns. The queue sets the tags, from ``next_tag`` on;
    tags of other requests of the plugin must be below. An insert that was refused for a reason that passes, was not
    answered, or was ended before its end is asked for again, up to ``attempts_max`` times with ``pause_s`` between.
    """

    inserts: list[Insert] = field(default_factory=list)
    ahead: int = 2
    attempts_max: int = 5
    pause_s: float = 10.0
    next_tag: int = 1_000_000

    def add(self, request: Trackline | Trackcircle) -> None:
        """Adds an insert to the end. Its tag does not matter."""
        self.inserts.append(Insert(request))

    def step(self, input: StepInput) -> list[Trackline | Trackcircle | Cancel]:
        """Takes in the outcomes, and returns what to ask for now: nothing without control. After a restart it first cancels what
        this instance knows nothing of."""
        asked: list[Trackline | Trackcircle | Cancel] = []
        for restored in input.of(Restored):
            asked.extend(Cancel(tag) for tag in self._restored(restored))
        for outcome in input.of(Outcome):
            for insert in self.inserts:
                if insert.request.tag == outcome.tag and insert.progress is not Progress.WAITING:
                    self._took(insert, outcome, input)
        open_now = sum(insert.progress in _OPEN for insert in self.inserts)
        if not input.control:
            return asked
        for insert in self.inserts:
            if open_now >= self.ahead:
                break
            if insert.progress is Progress.WAITING:
                if insert.not_before_ns > input.now_ns:
                    # The order is kept: nothing overtakes an insert that waits for its next attempt.
                    break
                insert.request = replace(insert.request, tag=self.next_tag)
                insert.progress = Progress.ASKED
                insert.attempts += 1
                self.next_tag += 1
                open_now += 1
                asked.append(insert.request)
        return asked

    def count(self, progress: Progress) -> int:
        """How many inserts have come so far."""
        return sum(insert.progress is progress for insert in self.inserts)

    @property
    def is_done(self) -> bool:
        """Whether every insert was flown or given up."""
        return all(insert.progress in (Progress.FLOWN, Progress.GIVEN_UP) for insert in self.inserts)

    def _restored(self, restored: Restored) -> list[int]:
        """After a restart, what happened in the lost steps is known only by the tags that are still open. An insert whose tag is
        not open counts as flown if it had begun, and waits again otherwise. Open tags that the queue does not know are those of
        the next inserts. Returns those for which there is no insert: the plugin added it after the snapshot."""
        for insert in self.inserts:
            if insert.progress in _OPEN and insert.request.tag not in restored.open:
                begun = insert.progress is Progress.FLYING
                insert.progress, insert.why = (
                    Progress.FLOWN if begun else Progress.WAITING,
                    "its end was lost in a restart",
                )
        known = {insert.request.tag for insert in self.inserts if insert.progress in _OPEN}
        waiting = [insert for insert in self.inserts if insert.progress is Progress.WAITING]
        unknown = sorted(tag for tag in restored.open if tag >= self.next_tag and tag not in known)
        for insert, tag in zip(waiting, unknown):
            insert.request, insert.progress = replace(insert.request, tag=tag), Progress.UNKNOWN
            insert.attempts += 1
        # A tag of the lost steps is not used again.
        self.next_tag = max([self.next_tag, *(tag + 1 for tag in unknown)]) + self.ahead * restored.lost_steps
        return unknown[len(waiting) :]

    def _took(self, insert: Insert, outcome: Outcome, input: StepInput) -> None:
        match outcome.state:
            case Accepted():
                insert.progress = Progress.ACCEPTED
            case Started():
                insert.progress = Progress.FLYING
            case Unknown():
                insert.progress = Progress.UNKNOWN
            case Ended(kind=EndKind.DONE):
                insert.progress = Progress.FLOWN
            case Rejected(refusal) if refusal.rule not in _PASSING:
                insert.progress, insert.why = Progress.GIVEN_UP, refusal.text
            case Cancelled():
                insert.progress, insert.why = Progress.GIVEN_UP, "cancelled"
            case Rejected() | Failed() | TimedOut() | Ended():
                insert.why = outcome.reason or "not answered"
                if insert.attempts >= self.attempts_max:
                    insert.progress = Progress.GIVEN_UP
                else:
                    insert.progress = Progress.WAITING
                    insert.not_before_ns = input.now_ns + round(self.pause_s * SECOND_NS)
            case _:
                pass


_OPEN = (Progress.ASKED, Progress.ACCEPTED, Progress.FLYING, Progress.UNKNOWN)
