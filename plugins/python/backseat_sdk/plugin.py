"""The class from which a plugin is derived."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, is_dataclass
from typing import Any, ClassVar

from . import records
from .briefing import Briefing, Grant
from .events import StepInput, Topic
from .requests import Request
from .values import SECOND_NS, U64


#: The longest name and version, bytes.
NAME_BYTES = 64
#: The shortest and the longest step period.
PERIOD_MIN_NS, PERIOD_MAX_NS = SECOND_NS // 50, 60 * SECOND_NS


class Refused(Exception):
    """Raise it in ``init`` to refuse a configuration: one line with the key and what was expected. The mission does not
    start."""


@dataclass(frozen=True)
class Description:
    """What a plugin says about itself.

    - ``step_period_ns``: from one step to the next, 20 ms to 60 s. A step waits up to half a period for navigation. A
      timer or a burst of events brings a step early.
    - ``topics``: the events to receive, beside those that every plugin receives.
    - ``grants``: those without which it cannot do its work. A mission that does not give them is not flown.
    """

    name: str
    version: str
    step_period_ns: U64 = SECOND_NS
    topics: Sequence[Topic] = ()
    grants: Sequence[Grant] = ()


@dataclass(frozen=True)
class NoConfig:
    """The configuration of a plugin without settings. Every key is an error."""


class Plugin:
    """A plugin: a function of its inputs. It has no clock, no random numbers, no files and no network.

    Derive one class from it, with ``describe`` and ``step``. The runtime creates it without arguments, calls
    ``describe``, then ``init`` and ``brief``, then ``step`` at the period of the description. Set ``Config`` to a
    dataclass of the settings and ``State`` to a dataclass of what a new instance needs to continue; ``self.state`` is
    then one of it.
    """

    #: The dataclass of ``[plugin.config]``. Put units into the names of its fields (``depth_m``), and ranges into their
    #: types: ``Annotated[float, Within(0.0, 360.0)]``. A field with a default may be left out of the mission. A key
    #: that it does not have is refused.
    Config: ClassVar[type] = NoConfig
    #: The dataclass of the state, which can be created without arguments; ``None`` for a plugin without state.
    State: ClassVar[type | None] = None
    #: The state, for ``snapshot`` and ``restore``: an instance of ``State``.
    state: Any = None

    def __new__(cls, *arguments: Any, **named: Any) -> Plugin:
        plugin = super().__new__(cls)
        if cls.State is not None:
            plugin.state = cls.State()
        return plugin

    def describe(self) -> Description:
        """The plugin's name, version, step period, topics and grants. Called first, before ``init``."""
        raise NotImplementedError(f"{type(self).__name__} needs a method describe")

    def init(self, config: Any) -> None:
        """Called once before the first step with an instance of ``Config``. By default it keeps it as ``self.config``.

        Refuse invalid settings here by raising ``Refused``, so that the mission does not start, rather than in a step
        at sea. Any other exception is a refusal too, with the place where it was raised.
        """
        self.config = config

    def brief(self, briefing: Briefing) -> None:
        """Called once after ``init``, also in a new instance after a failure, with the mission's fence, limits, grants
        and budget. By default it does nothing.

        Raise ``Refused`` for what makes the mission impossible for this plugin, with what to change.
        """

    def step(self, input: StepInput) -> Iterable[Request] | None:
        """Runs one step: takes in what has happened since the last one, and returns the requests of now, at most 256.

        An exception is recorded as a failure of the plugin, with its traceback in the run's log. The instance goes on
        with the next step, and what this step has changed stays changed.
        """
        raise NotImplementedError(f"{type(self).__name__} needs a method step")

    def snapshot(self) -> bytes:
        """All that a new instance needs to continue from here, at most 1 MiB. The runtime calls this every ten steps.

        By default: ``self.state`` as JSON, or nothing without ``State``.
        """
        return b"" if self.state is None else records.to_json(self.state).encode()

    def restore(self, state: bytes) -> None:
        """Continues from a snapshot of an earlier instance. Called after ``init``, when a plugin is restarted.

        By default it reads ``self.state`` from JSON. Raise ``ValueError`` if the state cannot be used: the plugin is
        then not restarted.
        """
        if self.State is not None:
            self.state = records.from_json(self.State, state.decode(), "state")


def check_class(found: type[Plugin]) -> None:
    """Refuses a class without ``describe`` or ``step``, or whose ``Config`` or ``State`` is no dataclass.

    Raises ``TypeError`` with what to change.
    """
    for name in ("describe", "step"):
        if getattr(found, name) is getattr(Plugin, name):
            raise TypeError(f"{found.__name__} has no method {name}")
    for name in ("Config", "State"):
        kind = getattr(found, name)
        if kind is not None and not (isinstance(kind, type) and is_dataclass(kind)):
            raise TypeError(f"{found.__name__}.{name} must be a dataclass")


def check_description(described: Description) -> None:
    """Refuses what the runtime would refuse when the plugin is loaded.

    Raises ``ValueError`` with the value and what was expected.
    """
    for what, text in (("name", described.name), ("version", described.version)):
        size = len(text.encode(errors="replace"))
        if not 1 <= size <= NAME_BYTES:
            raise ValueError(f"describe: {what} has {size} bytes, expected 1 to {NAME_BYTES}")
        if any(unicodedata.category(each) == "Cc" for each in text):
            raise ValueError(f"describe: {what} is {ascii(text)}, expected text without control characters")
    period_ns = described.step_period_ns
    if not PERIOD_MIN_NS <= period_ns <= PERIOD_MAX_NS:
        raise ValueError(
            f"describe: step_period_ns is {period_ns}, expected {PERIOD_MIN_NS} to {PERIOD_MAX_NS} (20 ms to 60 s)"
        )
