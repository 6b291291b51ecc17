"""What a plugin calls: the log, the fence and the measures. The component and the tests put theirs in its place."""

from __future__ import annotations

import sys
from typing import Protocol

from .outcomes import Refusal, Rule
from .requests import Request


class Host(Protocol):
    """The imports of a plugin."""

    def write(self, level: str, text: str) -> None:
        """Writes a line to the run's log; ``level`` is debug, info, warn or error."""

    def check(self, request: Request) -> float | Refusal:
        """The clearance of a request in metres, or why it would be refused."""

    def publish(self, name: str, value: float, unit: str) -> None:
        """Publishes a value under a name."""


class Standalone:
    """Without a runtime, lines and values go to standard error, and the fence refuses everything."""

    def write(self, level: str, text: str) -> None:
        print(f"{level}: {text}", file=sys.stderr)

    def check(self, request: Request) -> float | Refusal:
        return Refusal(Rule.STATE, text="no fence outside the runtime")

    def publish(self, name: str, value: float, unit: str) -> None:
        print(f"{name} = {value} {unit}", file=sys.stderr)


current: Host = Standalone()
