"""A harness for unit tests under plain Python: it stands in for the runtime.

::

    from backseat_sdk.testing import Harness
    from plugin import HoldHeading

    def test_it_asks_for_its_heading():
        harness = Harness(HoldHeading, {"heading_deg": 90.0, "depth_m": 10.0, "speed_mps": 1.5})
        [modify] = harness.step(control=True)
        assert modify.heading == 90.0
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from enum import Enum
from typing import Annotated, Any, Generic, TypeVar, get_args, get_origin, get_type_hints

from . import _host, records
from .briefing import Area, Briefing, Budget, Grant, KeepIn, Limits, Zone
from .events import Event, Restored, StepInput, TimerExpired
from .frame import Local, LocalFrame
from .navigation import Navigation
from .outcomes import Outcome, Refusal, State
from .plugin import Plugin, Refused, check_class, check_description
from .requests import Request, Timer
from .values import Position, Within

P = TypeVar("P", bound=Plugin)

#: Where the local frame of `navigation` has its origin.
ORIGIN = Position(42.35, -70.7)


def navigation(**changed: Any) -> Navigation:
    """A navigation solution for tests: at rest at the surface at the origin of the local frame, heading north, without
    bottom lock. ``navigation(depth=10.0, east=250.0)`` changes fields; a position that is not given is that of east and
    north."""
    whole = Navigation(
        age_ns=0,
        position=ORIGIN,
        east=0.0,
        north=0.0,
        depth=0.0,
        altitude=None,
        heading=0.0,
        roll=0.0,
        pitch=0.0,
        velocity_east=0.0,
        velocity_north=0.0,
        velocity_down=0.0,
        yaw_rate=0.0,
        gps=False,
    )
    whole = replace(whole, **changed)
    if "position" in changed:
        return whole
    return replace(whole, position=LocalFrame(ORIGIN).to_position(Local(whole.east, whole.north)))


def briefing(**changed: Any) -> Briefing:
    """A briefing for tests: all grants, a keep-in zone of 2 km by 2 km around the origin down to 36 m, and the limits
    of the template's mission. ``briefing(grants=())`` changes fields."""
    corners = (Local(-1000.0, -1000.0), Local(1000.0, -1000.0), Local(1000.0, 1000.0), Local(-1000.0, 1000.0))
    zone = Zone("bay", KeepIn(3.0), 20.0, 0.0, 36.0, None, None, (Area(corners),))
    limits = Limits(
        speed_min=1.0,
        speed_max=2.0,
        turn_rate=8.0,
        current_max=0.3,
        water_depth_min=30.0,
        water_depth_max=48.0,
        seabed_slope_max=0.02,
        navigation_error=5.0,
        tracking_error=5.0,
        vertical_error=1.0,
        lead_max=50.0,
        modify_duration_max_ns=60_000_000_000,
        inserts_open_max=4,
        inserts_total_max=100,
        inserts_duration_max_ns=3_600_000_000_000,
        requests_per_second=20,
        gps_hits_total_max=10,
        topside_per_minute=6,
        packets_per_minute=12,
    )
    budget = Budget(20_000_000, 1_000_000_000, 10_000_000, 64 << 20, 10)
    return replace(Briefing("{}", tuple(Grant), ORIGIN, (zone,), limits, budget), **changed)


_BRIEFING = briefing()


def outcome(request: Request | int, state: State) -> Outcome:
    """The outcome of a request, or of a tag."""
    return Outcome(request if isinstance(request, int) else request.tag, state)  # type: ignore[union-attr]


@dataclass
class Recorder:
    """What a plugin has logged and published. ``fence`` answers its questions; by default it allows everything with a
    clearance of 1000 m."""

    fence: Callable[[Request], float | Refusal] = lambda _: 1000.0
    #: Level and text of each line.
    lines: list[tuple[str, str]] = field(default_factory=list)
    #: All values of each name, oldest first.
    measures: dict[str, list[float]] = field(default_factory=dict)
    #: The requests about which the fence was asked.
    asked: list[Request] = field(default_factory=list)

    def write(self, level: str, text: str) -> None:
        self.lines.append((level, text))

    def check(self, request: Request) -> float | Refusal:
        check_value(request)
        self.asked.append(request)
        return self.fence(request)

    def publish(self, name: str, value: float, unit: str) -> None:
        self.measures.setdefault(name, []).append(value)


class Harness(Generic[P]):
    """A plugin that runs as in the runtime: its configuration goes through JSON, its requests are checked, its timers
    expire, and a restart goes through a snapshot. An exception of a step goes on to the test.

    - ``plugin``: the instance, whose state a test can look at.
    - ``now_ns``: the time of the next step.
    - ``lines``, ``measures``, ``asked``, ``fence``: see ``Recorder``.
    """

    def __init__(
        self,
        kind: type[P],
        config: dict[str, Any] | None = None,
        briefing: Briefing | None = None,
        seconds_at_start: float = 10.0,
    ) -> None:
        """Starts a plugin. Raises ``Refused`` with the line that the runtime would print, if it refuses to start."""
        check_class(kind)
        self.recorder = Recorder()
        self._kind, self._config = kind, json.dumps(config or {})
        self._briefing = replace(briefing or _BRIEFING, config=self._config)
        self.now_ns = round(seconds_at_start * 1e9)
        self._timers: dict[int, int] = {}
        self._waiting: list[Event] = []
        self.description = self._hosted(lambda: kind().describe())
        check_value(self.description, type(self.description))
        check_description(self.description)
        missing = [grant.value for grant in self.description.grants if grant not in self._briefing.grants]
        if missing:
            raise Refused(f"needs the grants {', '.join(missing)}")
        self.plugin: P = self._started()

    @property
    def lines(self) -> list[tuple[str, str]]:
        """Level and text of each line that was logged."""
        return self.recorder.lines

    @property
    def measures(self) -> dict[str, list[float]]:
        """All values that were published under each name."""
        return self.recorder.measures

    def step(
        self,
        events: Iterable[Event] = (),
        navigation: Navigation | None = None,
        control: bool = True,
        after_s: float | None = None,
        **others: Any,
    ) -> list[Any]:
        """Runs one step and returns its requests. The time moves on by ``after_s``, or by the plugin's period."""
        due = [number for number, at in self._timers.items() if at <= self.now_ns]
        for number in due:
            del self._timers[number]
        happened = [*self._waiting, *(TimerExpired(number) for number in due), *events]
        self._waiting = []
        input = StepInput(
            now_ns=self.now_ns,
            utc_ns=1_780_000_000_000_000_000 + self.now_ns,
            navigation=navigation,
            control=control,
            events=tuple(happened),
            **others,
        )
        returned = self._hosted(lambda: self.plugin.step(input))
        requests = [] if returned is None else list(returned)
        for request in requests:
            check_value(request)
            if isinstance(request, Timer):
                self._timers[request.id] = self.now_ns + request.after_ns
        self.now_ns += self.description.step_period_ns if after_s is None else round(after_s * 1e9)
        return requests

    def restart(self, lost_steps: int = 0, open: Sequence[int] = ()) -> None:
        """Replaces the instance by a new one from its snapshot; the next step has the event ``Restored``."""
        state = self._hosted(self.plugin.snapshot)
        self.plugin = self._started()
        self._hosted(lambda: self.plugin.restore(state))
        self._waiting = [Restored(lost_steps, tuple(open))]

    def _started(self) -> P:
        def start() -> P:
            plugin = self._kind()
            try:
                config: Any = records.from_json(self._kind.Config, self._config, "config")
            except ValueError as error:
                raise Refused(str(error)) from None
            plugin.init(config)
            plugin.brief(self._briefing)
            return plugin

        return self._hosted(start)

    def _hosted(self, call: Callable[[], Any]) -> Any:
        before, _host.current = _host.current, self.recorder
        try:
            return call()
        finally:
            _host.current = before


def check_value(value: Any, kind: Any = Request) -> None:
    """Checks a request, or another value for the runtime, as a component would: its type, and the type and range of
    each field.

    Raises ``TypeError`` or ``ValueError`` with the field.
    """
    kinds = get_args(kind) or (kind,)
    if not isinstance(value, kinds):
        raise TypeError(f"{type(value).__name__} {value!r}, expected a {getattr(kind, '__name__', 'request')}")
    hints = get_type_hints(type(value), include_extras=True)
    for each in fields(value):
        _check(getattr(value, each.name), hints[each.name], f"{type(value).__name__}.{each.name}")


def _check(value: Any, kind: Any, path: str) -> None:
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Annotated:
        bound: Within = arguments[1]
        if type(value) is not int:
            raise TypeError(f"{path}: {value!r}, expected a whole number")
        if not bound.least <= value <= bound.most:
            raise ValueError(f"{path}: {value} is not within {bound.least} to {bound.most}")
    elif is_dataclass(value):
        check_value(value, kind)
    elif type(None) in arguments:
        if value is not None:
            _check(value, next(each for each in arguments if each is not type(None)), path)
    elif origin is not None and arguments and not isinstance(value, (str, bytes)):
        for number, item in enumerate(value):
            _check(item, arguments[0], f"{path}[{number}]")
    elif kind is float:
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            raise TypeError(f"{path}: {value!r}, expected a number")
    elif isinstance(kind, type) and issubclass(kind, (bool, str, bytes, Enum)):
        if not isinstance(value, kind):
            raise TypeError(f"{path}: {value!r}, expected a {kind.__name__}")
    else:
        raise TypeError(f"{path}: {value!r}, expected a {getattr(kind, '__name__', kind)}")
