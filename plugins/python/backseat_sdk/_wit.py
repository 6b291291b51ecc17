"""The interface to the runtime, as componentize-py generates it: all that depends on its version.

The dataclasses of the SDK have the names and fields of the interface's records. The cases of its variants are
dataclasses of their own; the tables below say which. Only a component imports this module.
"""

from __future__ import annotations

import types as python_types
from collections.abc import Callable, Iterable
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

from componentize_py_types import Err
from wit_world import WitWorld as World
from wit_world.imports import fence as wit_fence
from wit_world.imports import log as wit_log
from wit_world.imports import measures as wit_measures
from wit_world.imports import mission as wit_mission
from wit_world.imports import types as wit

from . import events, outcomes, requests as asked, samples, sonar, values
from .briefing import Briefing
from .frame import Local
from .plugin import Description

__all__ = ["World", "Imports", "briefing", "description", "error", "requests", "step_input"]

#: The folder of `wit/` that this module fits.
VERSION = "v0.2.0"

#: The modules with the types of the interface.
MODULES = (wit, wit_mission)
#: The dataclasses that have another name in the interface.
NAMES: dict[type, str] = {Local: "Point"}

#: The variants of the interface, and the dataclass of each case. A case without one is a variant in the variant.
CASES: dict[str, dict[str, type | str]] = {
    "Vertical": {"Depth": values.Depth, "Altitude": values.Altitude},
    "Sample": {kind.__name__: kind for kind in get_args(samples.Sample)},
    "StationTarget": {
        "Here": asked.Here,
        "Hull": asked.HullPosition,
        "Bottom": asked.BottomPosition,
    },
    "SonarEvent": {
        "Ready": sonar.SonarReady,
        "Logging": sonar.SonarLogging,
        "Health": sonar.SonarHealth,
        "Alarm": sonar.SonarAlarm,
        "ActiveAlarms": sonar.ActiveAlarms,
        "Swath": sonar.Swath,
        "ControllerShutdown": sonar.ControllerShutdown,
    },
    "SonarSetting": {
        "Range": sonar.SetRange,
        "Pulse": sonar.SetPulse,
        "Ping": sonar.SetPinging,
        "Power": sonar.SetPower,
        "Gain": sonar.SetGain,
        "Period": sonar.SetPeriod,
        "DefaultState": sonar.SetDefault,
    },
    "Request": {
        **{kind.__name__: kind for kind in get_args(asked.Request)},
        "Trim": asked.AdjustTrim,
        "Buoyancy": asked.AdjustBuoyancy,
    },
    "Failure": {
        "Vehicle": outcomes.VehicleFailure,
        "NotInPlan": outcomes.NotInPlan,
        "Sonar": outcomes.SonarFailure,
    },
    "FrameOutcome": {
        "Unset": outcomes.FrameUnset,
        "Unacknowledged": outcomes.FrameUnacknowledged,
        "Acked": outcomes.FrameAcked,
        "FailedToSend": outcomes.FrameFailed,
        "Other": outcomes.FrameOther,
    },
    "State": {kind.__name__: kind for kind in get_args(outcomes.State)},
    "Event": {
        "Control": events.Control,
        "Outcome": outcomes.Outcome,
        "Ctd": samples.Ctd,
        "MissionCommand": events.MissionCommand,
        "BehaviorBegan": events.BehaviorBegan,
        "BehaviorEnded": events.BehaviorEnded,
        "Timer": events.TimerExpired,
        "Restored": events.Restored,
        "Shutdown": events.Shutdown,
        "LoggingBegan": events.LoggingBegan,
        "LoggingEnded": events.LoggingEnded,
        "TopsideMessage": events.TopsideMessage,
        "DvlTrigger": events.DvlTriggerAllowed,
        "Window": events.Window,
        "Packet": events.ReceivedPacket,
        "Plan": events.Plan,
        "Sample": "Sample",
        "Sidescan": events.Sidescan,
        "SubBottom": events.SubBottom,
        "Sonar": "SonarEvent",
    },
}
del CASES["Request"]["AdjustTrim"], CASES["Request"]["AdjustBuoyancy"]

Convert = Callable[[Any], Any]


def _named(name: str) -> Any:
    """The interface's type of this name; ``None`` if it has none."""
    return next((getattr(module, name) for module in MODULES if hasattr(module, name)), None)


def _counterpart(kind: type) -> Any:
    """The interface's type for one of the SDK; ``None`` if it has none."""
    return _named(NAMES.get(kind, kind.__name__))


def _is_record(kind: Any) -> bool:
    """Whether the interface has a record of this name; otherwise the dataclass only holds a variant's value."""
    return is_dataclass(kind) and is_dataclass(_counterpart(kind))


def _hints(kind: type) -> dict[str, Any]:
    hints = get_type_hints(kind, include_extras=True)
    return {field.name: hints[field.name] for field in fields(kind)}


def _parts(kind: Any) -> tuple[Any, tuple[Any, ...]]:
    """Origin and arguments of a type; a union without its `None`, and whether it had one, as `Union`."""
    if get_origin(kind) in (Union, python_types.UnionType):
        return Union, get_args(kind)
    return get_origin(kind), get_args(kind)


def _dataclasses(name: str) -> set[type]:
    """The dataclasses of a variant's cases, with those of variants in it."""
    return set().union(*(_dataclasses(kind) if isinstance(kind, str) else {kind} for kind in CASES[name].values()))


def _variant(kinds: list[Any]) -> str:
    """The name of the variant that has these dataclasses as its cases."""
    for name in CASES:
        if _dataclasses(name) == set(kinds):
            return name
    raise LookupError(f"no variant of the interface has the cases {[kind.__name__ for kind in kinds]}")


# From the runtime: converters are made once, when the component is built.

_takers: dict[Any, Convert | None] = {}


def _taker(kind: Any) -> Convert | None:
    """What converts the interface's value to one of this type; `None` if it is the same already."""
    key = kind
    if key not in _takers:
        _takers[key] = _make_taker(kind)
    return _takers[key]


def _make_taker(kind: Any) -> Convert | None:
    origin, arguments = _parts(kind)
    if origin is Annotated:
        return _taker(arguments[0])
    if origin is Union:
        inner = [argument for argument in arguments if argument is not type(None)]
        if all(is_dataclass(each) for each in inner) and len(inner) > 1:
            return _taker_of_variant(_variant(inner))
        take = _taker(inner[0]) if len(inner) == 1 else None
        return None if take is None else (lambda value: None if value is None else take(value))
    if isinstance(kind, type) and issubclass(kind, Enum):
        members = {_counterpart(kind)[member.name]: member for member in kind}
        return members.__getitem__
    if is_dataclass(kind):
        return _taker_of_record(kind)
    if origin is not None and origin is not tuple and arguments and issubclass(origin, Iterable):
        if arguments[0] is bytes:
            return lambda value: tuple(bytes(each) for each in value)
        take = _taker(arguments[0])
        return None if take is None else (lambda value: tuple(take(each) for each in value))
    return None


def _taker_of_record(kind: type) -> Convert:
    """The new object gets the fields of the old one, without the cost of a frozen dataclass' constructor."""
    inner = [(name, take) for name, hint in _hints(kind).items() if (take := _taker(hint)) is not None]
    new = kind.__new__

    def take_record(value: Any) -> Any:
        made = new(kind)
        made.__dict__.update(value.__dict__)
        for name, take in inner:
            made.__dict__[name] = take(made.__dict__[name])
        return made

    return take_record


def _taker_of_case(kind: type | str) -> Convert:
    if isinstance(kind, str):
        inner = _taker_of_variant(kind)
        return lambda case: inner(case.value)
    if _is_record(kind):
        take = _taker(kind)
        assert take is not None, "a record has a converter"
        return lambda case: take(case.value)
    hints = _hints(kind)
    if not hints:
        single = kind()
        return lambda _: single
    ((_, hint),) = hints.items()
    take = _taker(hint)
    return (lambda case: kind(case.value)) if take is None else (lambda case: kind(take(case.value)))


def _taker_of_variant(name: str) -> Convert:
    takers = {getattr(wit, f"{name}_{case}"): _taker_of_case(kind) for case, kind in CASES[name].items()}
    return lambda value: takers[type(value)](value)


# To the runtime: every value is checked, because one that does not fit would end the instance without a word.


def _giver(kind: Any, path: str) -> Convert:
    """What converts a value of this type to the interface's; `path` names the value in errors."""
    origin, arguments = _parts(kind)
    if origin is Annotated:
        bound = arguments[1]

        def give_bounded(value: Any) -> Any:
            if type(value) is not int:
                raise TypeError(f"{path}: {_told(value)}, expected a whole number")
            if not bound.least <= value <= bound.most:
                raise ValueError(f"{path}: {value} is not within {bound.least} to {bound.most}")
            return value

        return give_bounded
    if origin is Union:
        inner = [argument for argument in arguments if argument is not type(None)]
        if all(is_dataclass(each) for each in inner) and len(inner) > 1:
            return _giver_of_variant(inner, path)
        give = _giver(inner[0], path)
        return lambda value: None if value is None else give(value)
    if isinstance(kind, type) and issubclass(kind, Enum):
        members = {member: _counterpart(kind)[member.name] for member in kind}
        return lambda value: _found(members, value, path, kind.__name__)
    if is_dataclass(kind):
        return _giver_of_record(kind, path)
    if origin is not None and arguments:
        give = _giver(arguments[0], f"{path}[]")
        return lambda value: [give(each) for each in value]
    return _giver_of_plain(kind, path)


def _giver_of_plain(kind: Any, path: str) -> Convert:
    names = {float: "a number", bool: "True or False", str: "text", bytes: "bytes"}

    def give_plain(value: Any) -> Any:
        if type(value) is kind:
            return value
        if kind is float and isinstance(value, (int, float)) and not isinstance(value, bool):
            return float(value)
        if isinstance(value, kind):
            return kind(value)
        raise TypeError(f"{path}: {_told(value)}, expected {names[kind]}")

    return give_plain


def _giver_of_record(kind: type, path: str) -> Convert:
    made = _counterpart(kind)
    inner = [(name, _giver(hint, f"{path}.{name}")) for name, hint in _hints(kind).items()]

    def give_record(value: Any) -> Any:
        if not isinstance(value, kind):
            raise TypeError(f"{path}: {_told(value)}, expected {kind.__name__}")
        return made(*[give(getattr(value, name)) for name, give in inner])

    return give_record


def _giver_of_case(kind: type, case: type, path: str) -> Convert:
    if _is_record(kind):
        give = _giver_of_record(kind, path)
        return lambda value: case(give(value))
    hints = _hints(kind)
    if not hints:
        return lambda _: case()
    ((name, hint),) = hints.items()
    give = _giver(hint, f"{path}.{name}")
    return lambda value: case(give(getattr(value, name)))


def _giver_of_variant(kinds: list[Any], path: str) -> Convert:
    name = _variant(kinds)
    givers = {
        kind: _giver_of_case(kind, getattr(wit, f"{name}_{case}"), f"{path}.{kind.__name__}" if path else kind.__name__)
        for case, kind in CASES[name].items()
        if isinstance(kind, type)
    }

    def give_variant(value: Any) -> Any:
        return _found(givers, type(value), path or "step", name, value)(value)

    return give_variant


_ABSENT = object()


def _found(table: dict[Any, Any], key: Any, path: str, expected: str, value: Any = _ABSENT) -> Any:
    try:
        return table[key]
    except (KeyError, TypeError):
        told = _told(key if value is _ABSENT else value)
        raise TypeError(f"{path}: {told}, expected a {expected}") from None


def _told(value: Any) -> str:
    text = repr(value)
    return f"{type(value).__name__} {text if len(text) <= 60 else text[:57] + '...'}"


take_input = _taker(events.StepInput)
take_briefing = _taker(Briefing)
take_event = _taker_of_variant("Event")
take_refusal = _taker(outcomes.Refusal)
give_request = _giver(asked.Request, "")
give_description = _giver(Description, "describe")


def step_input(value: Any) -> events.StepInput:
    """The input of a step."""
    assert take_input is not None, "a record has a converter"
    return take_input(value)


def briefing(value: Any) -> Briefing:
    """What the plugin is told before its first step."""
    assert take_briefing is not None, "a record has a converter"
    return take_briefing(value)


def requests(returned: Iterable[Any] | None) -> list[Any]:
    """What a step has returned. Raises ``TypeError`` or ``ValueError`` for what is no request, with its field."""
    if returned is None:
        return []
    if not isinstance(returned, Iterable):
        raise TypeError(f"step returned {_told(returned)}, expected a list of requests")
    return [give_request(request) for request in returned]


def description(value: Any) -> Any:
    """What a plugin says about itself."""
    return give_description(value)


def error(text: str) -> Exception:
    """An error for the runtime."""
    return Err(text)


class Imports:
    """The runtime's log, fence and measures."""

    levels = {
        "debug": wit_log.Level.DEBUG,
        "info": wit_log.Level.INFO,
        "warn": wit_log.Level.WARN,
        "error": wit_log.Level.ERROR,
    }

    def write(self, level: str, text: str) -> None:
        wit_log.write(self.levels[level], text)

    def check(self, request: Any) -> Any:
        try:
            return wit_fence.check(give_request(request))
        except Err as refused:
            assert take_refusal is not None, "a record has a converter"
            return take_refusal(refused.value)

    def publish(self, name: str, value: float, unit: str) -> None:
        wit_measures.publish(name, value, unit)
