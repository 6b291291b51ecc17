"""The interface: every record, variant and enum of `wit/` has its dataclass here, with the same fields, and every value
arrives on the other side as it was.

The other side is what componentize-py generates for a component, so these tests need componentize-py.
"""

import enum
import importlib
import sys
from dataclasses import fields, is_dataclass
from subprocess import run
from typing import Annotated, Union, get_args, get_origin, get_type_hints

import backseat_sdk
import pytest
from backseat_sdk import Depth, Description, Grant, Modify, Plan, StepInput, Topic, build


@pytest.fixture(scope="module")
def wit(tmp_path_factory):
    """The module of conversions, with the generated types beside it."""
    folder = tmp_path_factory.mktemp("bindings")
    interface = str(build._interface())
    run(
        [sys.executable, "-c", build.SCRIPT, "-q", "-d", interface, "-w", build.WORLD, "bindings", str(folder)],
        check=True,
    )
    sys.path.insert(0, str(folder))
    try:
        yield importlib.import_module("backseat_sdk._wit")
    finally:
        sys.path.remove(str(folder))


def generated(wit):
    """The classes that were generated for the interface's types."""
    return {
        name: value
        for module in wit.MODULES
        for name, value in vars(module).items()
        if isinstance(value, type) and value.__module__ == module.__name__
    }


def test_the_builder_and_the_conversions_have_one_version(wit):
    assert wit.VERSION == build.VERSION


def test_every_record_has_its_dataclass_with_the_same_fields(wit):
    records = [kind for name, kind in generated(wit).items() if is_dataclass(kind) and not is_case(name, kind)]
    assert len(records) > 50
    for record in records:
        own = next((own for own, name in wit.NAMES.items() if name == record.__name__), None)
        own = own or getattr(backseat_sdk, record.__name__)
        assert [field.name for field in fields(own)] == [field.name for field in fields(record)], record
        assert own.__doc__ and not own.__doc__.startswith(f"{record.__name__}("), f"{record} has no docs"


def is_case(name, kind):
    return "_" in name and name.split("_")[0] in CASES_OF


CASES_OF = {
    "Vertical", "Sample", "StationTarget", "SonarEvent", "SonarSetting", "Request", "Failure", "FrameOutcome", "State",
    "Event",
}  # fmt: skip


def test_every_enum_has_the_same_members(wit):
    enums = {name: kind for name, kind in generated(wit).items() if issubclass(kind, enum.Enum)}
    assert len(enums) == 9
    for name, kind in enums.items():
        assert [member.name for member in getattr(backseat_sdk, name)] == [member.name for member in kind], name


def test_every_case_of_every_variant_has_its_dataclass(wit):
    assert set(wit.CASES) == CASES_OF
    for name, cases in wit.CASES.items():
        of_interface = {each.split("_")[1] for each in generated(wit) if each.startswith(f"{name}_")}
        assert set(cases) == of_interface, name


def sample_of(hint, number=1):
    """A value of a type of the interface that differs from field to field."""
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return number
    if hint is int:
        return number
    if hint is float:
        return number + 0.5
    if hint is str:
        return f"text {number}"
    if hint is bool:
        return number % 2 == 1
    if hint is bytes:
        return bytes([number % 256, 0, 255])
    if type(None) in arguments:
        inner = [each for each in arguments if each is not type(None)]
        return sample_of(inner[0] if len(inner) == 1 else Union[tuple(inner)], number) if number % 3 else None
    if origin is Union:
        return sample_of(arguments[number % len(arguments)], number)
    if origin is list:
        return [sample_of(arguments[0], number + 1), sample_of(arguments[0], number + 2)]
    if origin is tuple:
        return tuple(sample_of(each, number + at) for at, each in enumerate(arguments))
    if issubclass(hint, enum.Enum):
        return list(hint)[number % len(hint)]
    hints = get_type_hints(hint)
    return hint(*[sample_of(hints[field.name], number + at + 1) for at, field in enumerate(fields(hint))])


def same(wit, theirs, ours):
    """Whether a value of the interface and one of the SDK are the same, whatever their classes."""
    if isinstance(theirs, enum.Enum):
        return theirs.name == ours.name
    variant, _, case = type(theirs).__name__.partition("_")
    if case:
        kind = wit.CASES[variant][case]
        if not hasattr(theirs, "value"):
            return ours == kind()
        if isinstance(kind, str):
            return same(wit, theirs.value, ours)
        if type(ours) is not kind:
            return False
        if type(theirs.value).__name__ == kind.__name__ or case in ("Hull", "Bottom", "Logging", "Alarm", "Packet"):
            return same(wit, theirs.value, ours)
        (field,) = fields(ours)
        return same(wit, theirs.value, getattr(ours, field.name))
    if is_dataclass(theirs):
        return all(same(wit, getattr(theirs, field.name), getattr(ours, field.name)) for field in fields(theirs))
    if isinstance(theirs, (list, tuple)):
        return len(theirs) == len(ours) and all(same(wit, *each) for each in zip(theirs, ours))
    return theirs == ours


@pytest.mark.parametrize("number", [1, 2, 3, 10])
def test_every_event_arrives_as_it_was(wit, number):
    cases = [kind for name, kind in generated(wit).items() if name.startswith("Event_")]
    assert len(cases) == 20
    for case in cases:
        for inner in range(13):
            theirs = sample_of(case, number + inner)
            ours = wit.take_event(theirs)
            assert isinstance(ours, get_args(backseat_sdk.Event)), ours
            assert same(wit, theirs, ours), (theirs, ours)


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_every_input_arrives_as_it_was(wit, number):
    theirs = sample_of(wit.wit.StepInput, number)
    ours = wit.step_input(theirs)
    assert isinstance(ours, StepInput)
    assert same(wit, theirs, ours), (theirs, ours)


@pytest.mark.parametrize("number", [1, 2, 3])
def test_every_briefing_arrives_as_it_was(wit, number):
    theirs = sample_of(wit.wit_mission.Briefing, number)
    ours = wit.briefing(theirs)
    assert isinstance(ours, backseat_sdk.Briefing) and isinstance(
        ours.zones[0].areas[0].holes[0][0], backseat_sdk.Local
    )
    assert same(wit, theirs, ours), (theirs, ours)


def test_a_description_arrives_as_it_was(wit):
    ours = Description("name", "1", 5, (Topic.CTD, Topic.SONAR), (Grant.MODIFY,))
    assert same(wit, wit.description(ours), ours)


def ours_of(hint, number=1):
    """A value of a type of the SDK."""
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return min(number, arguments[1].most)
    if hint is float:
        return number + 0.5
    if hint is str:
        return f"text {number}"
    if hint is bool:
        return number % 2 == 1
    if hint is bytes:
        return bytes([number % 256])
    if type(None) in arguments:
        inner = [each for each in arguments if each is not type(None)]
        return ours_of(inner[0], number) if number % 3 else None
    if arguments and origin is not None and not hasattr(origin, "__iter__"):
        return ours_of(arguments[number % len(arguments)], number)
    if arguments:
        return [ours_of(arguments[0], number + 1), ours_of(arguments[0], number + 2)]
    if issubclass(hint, enum.Enum):
        return list(hint)[number % len(hint)]
    hints = get_type_hints(hint, include_extras=True)
    return hint(*[ours_of(hints[field.name], number + at + 1) for at, field in enumerate(fields(hint))])


@pytest.mark.parametrize("kind", get_args(backseat_sdk.Request), ids=lambda kind: kind.__name__)
def test_every_request_arrives_as_it_was(wit, kind):
    for number in range(1, 14):
        ours = ours_of(kind, number)
        (theirs,) = wit.requests([ours])
        assert type(theirs).__name__.startswith("Request_")
        assert same(wit, theirs, ours), (theirs, ours)


@pytest.mark.parametrize(
    "request_, told",
    [
        (Modify(-1, 0.0, Depth(1.0), 1.0, 1), "Modify.tag: -1 is not within 0 to 18446744073709551615"),
        (Modify(2**64, 0.0, Depth(1.0), 1.0, 1), f"Modify.tag: {2**64} is not within"),
        (Modify(1.0, 0.0, Depth(1.0), 1.0, 1), "Modify.tag: float 1.0, expected a whole number"),
        (Modify(True, 0.0, Depth(1.0), 1.0, 1), "Modify.tag: bool True, expected a whole number"),
        (Modify(1, "north", Depth(1.0), 1.0, 1), "Modify.heading: str 'north', expected a number"),
        (Modify(1, None, Depth(1.0), 1.0, 1), "Modify.heading: NoneType None, expected a number"),
        (Modify(1, 0.0, 10.0, 1.0, 1), "Modify.vertical: float 10.0, expected a Vertical"),
        (Modify(1, 0.0, Depth("x"), 1.0, 1), "Modify.vertical.Depth.depth: str 'x', expected a number"),
        (backseat_sdk.Topside(1, "wifi", "x"), "Topside.slowest: str 'wifi', expected a Transport"),
        (backseat_sdk.Message(5), "Message.text: int 5, expected text"),
        (backseat_sdk.Light(1, 2**31, True), "Light.light: 2147483648 is not within"),
        (backseat_sdk.Packet(1, 1, 1, False, ["text"]), "Packet.frames[]: str 'text', expected bytes"),
        (Plan(()), "step: Plan Plan(elements=()), expected a Request"),
        ("north", "step: str 'north', expected a Request"),
    ],
)
def test_a_value_that_does_not_fit_is_named(wit, request_, told):
    with pytest.raises((TypeError, ValueError)) as refused:
        wit.requests([request_])
    assert str(refused.value).startswith(told)


def test_a_step_may_return_nothing_or_a_generator_but_no_number(wit):
    assert wit.requests(None) == []
    assert len(wit.requests(Modify(tag, 0, Depth(1), 1, 1) for tag in range(3))) == 3
    with pytest.raises(TypeError, match="step returned int 5, expected a list of requests"):
        wit.requests(5)
