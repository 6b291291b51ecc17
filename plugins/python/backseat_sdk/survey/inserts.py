"""A queue of tracklines and trackcircles that are flown one after the other, with retries."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import Enum

from .. import fence, log
from ..events import Restored, Shutdown, StepInput
from ..frame import Local, LocalFrame
from ..navigation import Navigation
from ..outcomes import (
    Accepted,
    Cancelled,
    EndKind,
    Ended,
    Failed,
    Outcome,
    Refusal,
    Rejected,
    Rule,
    Started,
    TimedOut,
    Unknown,
)
from ..requests import Cancel, Trackcircle, Trackline
from ..values import SECOND_NS
from .shapes import Line


class Progress(Enum):
    """How far an insert has come."""

    WAITING = "waiting"
    ASKED = "asked"
    ACCEPTED = "accepted"
    FLYING = "flying"
    UNKNOWN = "unknown"
    FLOWN = "flown"
    GIVEN_UP = "given up"


#: Refusals after which the same request cannot succeed: they end the insert.
_LASTING = (Rule.LIMIT, Rule.GRANT, Rule.TEXT, Rule.LAYOUT)
#: Refusals of the fence for which a smaller request may fit.
_GEOMETRY = (Rule.KEEP_IN, Rule.KEEP_OUT, Rule.DEPTH, Rule.ALTITUDE)


@dataclass
class Insert:
    """A trackline or a trackcircle in the queue.

    - ``request``: as it was made smaller, if it was.
    - ``attempts``: how often the vehicle failed it or did not fly it. ``refusals``: how often the runtime refused it.
    - ``seen``: how far along its line the vehicle was seen, 0 to 1. ``began_ns``: when it began.
    - ``why``: the last reason for which it was not flown.
    """

    request: Trackline | Trackcircle
    progress: Progress = Progress.WAITING
    attempts: int = 0
    refusals: int = 0
    not_before_ns: int = 0
    seen: float = 0.0
    began_ns: int | None = None
    why: str = ""

    def flown(self, now_ns: int) -> float:
        """Which part was flown: of a line, as far as the vehicle was seen on it; of a circle, by the time. 0 to 1 and
        more."""
        circle = self.request
        if isinstance(circle, Trackline):
            return self.seen
        if self.began_ns is None:
            return 0.0
        length = math.tau * circle.radius * abs(circle.orbits)
        return (now_ns - self.began_ns) / SECOND_NS * circle.speed / max(length, 1e-6)


@dataclass
class InsertQueue:
    """Inserts that are flown in their order, with retries.

    The vehicle flies inserts by itself, one after the other, and returns to its own plan when none is left. So the queue
    keeps ``ahead`` of them at the vehicle. It asks again for what was refused, was not answered or ended too early, makes
    smaller what does not fit into the fence, and gives up what cannot be flown. It logs what becomes of each.

    Call ``step`` in each step of the plugin, and return what it returns. The queue sets the tags, from ``next_tag`` on;
    tags of other requests of the plugin must be below. After ``Shutdown`` it asks for nothing.

    - ``attempts_max``: how often an insert is asked for that the vehicle fails or does not fly, ``pause_s`` apart.
    - ``refusals_max``: how often one is asked for again that the runtime refuses for a reason which may pass.
    - ``shorten_m``: a line that does not fit into the fence is cut to the longest part that fits, in steps of about so many
      metres, and given up if that is shorter than ``line_min_m``; 0 gives it up at once. If only the way to it or back
      does not fit, it is shortened by ``shorten_m`` at both ends.
    - ``shrink``: a circle that does not fit gets a radius of this part of it, until it fits, and is given up below
      ``radius_min_m`` metres; 1 gives it up at once.
    - ``flown``: an insert that ends early after this part of it counts as flown, 0 to 1.
    - ``on_line_m``: farther from its line than this, metres, the vehicle is still on its way to it.
    """

    inserts: list[Insert] = field(default_factory=list)
    ahead: int = 2
    attempts_max: int = 5
    refusals_max: int = 60
    pause_s: float = 10.0
    shorten_m: float = 50.0
    line_min_m: float = 80.0
    shrink: float = 0.75
    radius_min_m: float = 15.0
    flown: float = 0.5
    on_line_m: float = 25.0
    next_tag: int = 1_000_000
    is_shut_down: bool = False

    def add(self, request: Trackline | Trackcircle) -> None:
        """Adds an insert to the end. Its tag does not matter."""
        self.inserts.append(Insert(request))

    def step(self, input: StepInput) -> list[Trackline | Trackcircle | Cancel]:
        """Takes in what has happened, and returns what to ask for now: nothing without control. After a restart it first
        cancels what this instance knows nothing of."""
        asked: list[Trackline | Trackcircle | Cancel] = []
        self.is_shut_down = self.is_shut_down or any(True for _ in input.of(Shutdown))
        for restored in input.of(Restored):
            asked.extend(Cancel(tag) for tag in self._restored(restored, input))
        if input.navigation is not None:
            self._follow(input.navigation)
        for outcome in input.of(Outcome):
            for number, insert in enumerate(self.inserts, 1):
                if insert.request.tag == outcome.tag and insert.progress in _OPEN:
                    self._took(number, insert, outcome, input)
        while input.control and not self.is_shut_down and self.open < self.ahead:
            insert = self._due(input.now_ns)
            if insert is None:
                break
            insert.request = replace(insert.request, tag=self.next_tag)
            insert.progress, insert.seen, insert.began_ns = Progress.ASKED, 0.0, None
            insert.attempts += 1
            self.next_tag += 1
            asked.append(insert.request)
        return asked

    def count(self, progress: Progress) -> int:
        """How many inserts have come so far."""
        return sum(insert.progress is progress for insert in self.inserts)

    @property
    def open(self) -> int:
        """How many inserts the vehicle may have."""
        return sum(insert.progress in _OPEN for insert in self.inserts)

    @property
    def is_done(self) -> bool:
        """Whether every insert was flown or given up."""
        return all(insert.progress in _OVER for insert in self.inserts)

    @property
    def last_progress(self) -> float:
        """How far along the last line the vehicle has been seen: 0 while there are others before it, 1 when all have
        ended. A plugin that makes up its next line from what it has measured does so before this is 1."""
        live = [insert for insert in self.inserts if insert.progress not in _OVER]
        if not live:
            return 1.0
        return live[0].seen if len(live) == 1 else 0.0

    def _due(self, now_ns: int) -> Insert | None:
        """In their order. Another one goes first if the first has to wait while hardly anything is open, because the
        vehicle would then leave; not before the first has begun, because what refuses that one refuses all."""
        waiting = [insert for insert in self.inserts if insert.progress is Progress.WAITING]
        begun = any(insert.progress in _BEGUN for insert in self.inserts)
        may_skip = begun and self.open <= 1
        due = [insert for insert in waiting if insert.not_before_ns <= now_ns]
        if not due or (due[0] is not waiting[0] and not may_skip):
            return None
        return due[0]

    def _follow(self, navigation: Navigation) -> None:
        """Notes how far along its line the vehicle is. On the way to the line's start it moves in another direction, or is
        away from the line."""
        for insert in self.inserts:
            line = insert.request
            if insert.progress is not Progress.FLYING or not isinstance(line, Trackline):
                continue
            frame = LocalFrame(line.start)
            track = Line(Local(0.0, 0.0), frame.to_local(line.end))
            at, bearing = frame.to_local(navigation.position), math.radians(track.bearing)
            forward = navigation.velocity_east * math.sin(bearing) + navigation.velocity_north * math.cos(bearing)
            if abs(track.across(at)) < self.on_line_m and forward > 0.3:
                insert.seen = max(insert.seen, min(1.0, track.along(at) / max(track.length, 1e-6)))

    def _restored(self, restored: Restored, input: StepInput) -> list[int]:
        """After a restart, what happened in the lost steps is known only by the tags that are still open. An insert whose tag is
        not open counts as flown if it had begun, and waits again otherwise. Open tags that the queue does not know are those of
        the next inserts. Returns those for which there is no insert: the plugin added it after the snapshot."""
        for insert in self.inserts:
            if insert.progress not in _OPEN:
                continue
            if insert.request.tag in restored.open:
                # Its begin may have been lost: then its end comes within its time.
                if insert.began_ns is None and restored.lost_steps > 0:
                    insert.began_ns = input.now_ns
                continue
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
            insert.began_ns = input.now_ns
            insert.attempts += 1
        # A tag of the lost steps is not used again.
        self.next_tag = max([self.next_tag, *(tag + 1 for tag in unknown)]) + self.ahead * restored.lost_steps
        return unknown[len(waiting) :]

    def _took(self, number: int, insert: Insert, outcome: Outcome, input: StepInput) -> None:
        name = f"insert {number} of {len(self.inserts)}"
        match outcome.state:
            case Accepted():
                insert.progress = Progress.ACCEPTED
            case Started():
                insert.progress, insert.began_ns = Progress.FLYING, input.now_ns
                log.info(f"{name} begun")
            case Unknown():
                insert.progress = Progress.UNKNOWN
            case Ended(kind=kind) if kind is EndKind.DONE or insert.flown(input.now_ns) >= self.flown:
                insert.progress = Progress.FLOWN
                log.info(f"{name} flown")
            case Cancelled():
                self._give_up(name, insert, "cancelled")
            case Rejected(refusal):
                # Refused requests do not count as attempts.
                insert.attempts -= 1
                self._refused(name, insert, refusal, input)
            case Failed() | TimedOut() | Ended():
                insert.why = outcome.reason or "not answered"
                if insert.attempts >= self.attempts_max:
                    self._give_up(name, insert, insert.why)
                else:
                    self._wait(insert, input)
                    log.warn(f"{name} will be asked for again: {insert.why}")
            case _:
                pass

    def _refused(self, name: str, insert: Insert, refusal: Refusal, input: StepInput) -> None:
        others = self.open - 1
        insert.why = refusal.text
        if not input.control:
            self._wait(insert, input)
        elif refusal.rule in _LASTING:
            self._give_up(name, insert, refusal.text)
        else:
            first = insert.refusals == 0
            # With others left to fly, the mission's limit on open inserts may be the reason, which passes.
            if first or others <= 1:
                insert.refusals += 1
            # The fence that a plugin can ask does not know the way there from the vehicle's plan and back, so a smaller request
            # is tried now and then.
            geometry = refusal.rule in _GEOMETRY
            stuck = geometry and others <= 1 and insert.refusals % max(1, self.refusals_max // 5) == 0
            misfits = geometry and not _fits(insert.request)
            if misfits or stuck:
                smaller = self._largest_that_fits(insert.request) if misfits else self._smaller(insert.request)
                if smaller is None:
                    self._give_up(name, insert, refusal.text)
                else:
                    sizes = f"{_size(insert.request)} to {_size(smaller)}"
                    insert.request, insert.progress, insert.not_before_ns = smaller, Progress.WAITING, input.now_ns
                    log.warn(f"{name} made smaller, {sizes}: {refusal.text}")
            elif insert.refusals >= self.refusals_max:
                self._give_up(name, insert, refusal.text)
            else:
                self._wait(insert, input)
                if first:
                    log.warn(f"{name} will be asked for again: {refusal.text}")

    def _largest_that_fits(self, request: Trackline | Trackcircle) -> Trackline | Trackcircle | None:
        if isinstance(request, Trackline):
            return self._longest_part(request)
        circle = self._smaller(request)
        while circle is not None and not _fits(circle):
            circle = self._smaller(circle)
        return circle

    def _longest_part(self, request: Trackline) -> Trackline | None:
        frame = LocalFrame(request.start)
        line = Line(Local(0.0, 0.0), frame.to_local(request.end))
        if self.shorten_m <= 0.0 or line.length < self.line_min_m:
            return None
        count = min(max(1, int(line.length / self.shorten_m)), _PARTS_MAX)

        def part(first: int, end: int) -> Trackline:
            ends = (frame.to_position(line.at(line.length * index / count)) for index in (first, end))
            return replace(request, **dict(zip(("start", "end"), ends)))

        longest, first = (0, 0), 0
        for index in range(count):
            if not _fits(part(index, index + 1)):
                first = index + 1
            elif index + 1 - first > longest[1] - longest[0]:
                longest = (first, index + 1)
        # Where each part fits, all together may not.
        while longest == (0, count) or (longest[0] < longest[1] and not _fits(part(*longest))):
            longest = (longest[0] + 1, longest[1] - 1)
        long_enough = (longest[1] - longest[0]) * line.length / count >= self.line_min_m
        return part(*longest) if longest[0] < longest[1] and long_enough else None

    def _smaller(self, request: Trackline | Trackcircle) -> Trackline | Trackcircle | None:
        if isinstance(request, Trackcircle):
            radius = request.radius * self.shrink
            return replace(request, radius=radius) if self.radius_min_m <= radius < request.radius else None
        frame = LocalFrame(request.start)
        line = Line(Local(0.0, 0.0), frame.to_local(request.end))
        if self.shorten_m <= 0.0 or line.length - 2.0 * self.shorten_m < self.line_min_m:
            return None
        start, end = line.at(self.shorten_m), line.at(line.length - self.shorten_m)
        return replace(request, start=frame.to_position(start), end=frame.to_position(end))

    def _wait(self, insert: Insert, input: StepInput) -> None:
        insert.progress = Progress.WAITING
        insert.not_before_ns = input.now_ns + round(self.pause_s * SECOND_NS)

    def _give_up(self, name: str, insert: Insert, why: str) -> None:
        insert.progress, insert.why = Progress.GIVEN_UP, why
        log.warn(f"{name} given up: {why}")


#: A line is tried in so many parts at most, because each question to the fence costs fuel.
_PARTS_MAX = 24


def _fits(request: Trackline | Trackcircle) -> bool:
    answer = fence.check(request)
    return not (isinstance(answer, Refusal) and answer.rule in _GEOMETRY)


def _size(request: Trackline | Trackcircle) -> str:
    """The length of a line, or the radius of a circle, for a person."""
    if isinstance(request, Trackcircle):
        return f"radius {request.radius:.0f} m"
    return f"{Local(0.0, 0.0).distance(LocalFrame(request.start).to_local(request.end)):.0f} m"


_OPEN = (Progress.ASKED, Progress.ACCEPTED, Progress.FLYING, Progress.UNKNOWN)
_OVER = (Progress.FLOWN, Progress.GIVEN_UP)
_BEGUN = (Progress.FLYING, Progress.FLOWN, Progress.GIVEN_UP)
