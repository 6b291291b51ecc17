"""Timers with names."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..events import StepInput, TimerExpired
from ..requests import Timer
from ..values import SECOND_NS


@dataclass
class Timers:
    """Timers with names instead of numbers: a step starts them, and a later one asks which have expired.

    A restart of the plugin keeps them, if they are a part of its state: what expired in the lost steps expires at once.
    """

    #: When each one expires, on the clock of ``now_ns``, and its number.
    due: dict[str, tuple[int, int]] = field(default_factory=dict)
    next_id: int = 1

    def start(self, name: str, after_s: float, input: StepInput) -> Timer:
        """Starts a timer, or starts it anew. Return the request from the step.

        Raises ``ValueError`` if the time is not above 0.
        """
        if not after_s > 0.0:
            raise ValueError(f"timer {name}: {after_s} s is not above 0")
        after_ns = round(after_s * SECOND_NS)
        number, self.next_id = self.next_id, self.next_id + 1
        self.due[name] = (input.now_ns + after_ns, number)
        return Timer(number, after_ns)

    def stop(self, name: str) -> None:
        """Forgets a timer."""
        self.due.pop(name, None)

    def is_running(self, name: str) -> bool:
        """Whether it was started and has neither expired nor been stopped."""
        return name in self.due

    def expired(self, input: StepInput) -> list[str]:
        """The timers that have expired, and only once, in the order of their times."""
        numbers = {event.id for event in input.of(TimerExpired)}
        over = [(at, name) for name, (at, number) in self.due.items() if number in numbers or at <= input.now_ns]
        for _, name in over:
            del self.due[name]
        return [name for _, name in sorted(over)]
