"""Configurations and states: what is read, and what is refused with which line."""

from dataclasses import dataclass, field
from enum import Enum
from typing import Annotated, Literal

import pytest
from backseat_sdk import Within
from backseat_sdk.records import from_json, to_json
from backseat_sdk.survey import Box, CoverageGrid, InsertQueue, Local, PlaneFit, Timers


class Side(Enum):
    PORT = "port"
    STARBOARD = "starboard"


@dataclass(frozen=True)
class Inner:
    name: str
    weight: float = 1.0


@dataclass(frozen=True)
class Config:
    depth_m: Annotated[float, Within(0.0, 100.0)]
    count: int = 3
    on: bool = False
    side: Side = Side.PORT
    mode: Literal["a", "b"] = "a"
    near_m: float | None = None
    lines: list[float] = field(default_factory=list)
    pair: tuple[float, str] = (0.0, "")
    bounded: list[Annotated[float, Within(0.0, 1.0)]] = field(default_factory=list)
    inner: list[Inner] = field(default_factory=list)
    by_number: dict[int, float] = field(default_factory=dict)


def read(text):
    return from_json(Config, text, "config")


def test_values_of_every_kind_are_read():
    config = read(
        '{"depth_m": 5, "count": 4, "on": true, "side": "starboard", "mode": "b", "near_m": 2.5, "lines": [1, 2.5],'
        '"pair": [1, "x"], "bounded": [0.5], "inner": [{"name": "n"}], "by_number": {"3": 1}}'
    )
    assert config == Config(
        5.0, 4, True, Side.STARBOARD, "b", 2.5, [1.0, 2.5], (1.0, "x"), [0.5], [Inner("n")], {3: 1.0}
    )
    assert isinstance(config.depth_m, float) and isinstance(config.lines[0], float)
    assert read(to_json(config)) == config


@pytest.mark.parametrize(
    "text, told",
    [
        ('{"depht_m": 5}', "config: unknown key `depht_m`, did you mean `depth_m`?"),
        ('{"depth_m": 5, "zzz": 1}', "config: unknown key `zzz`, expected `depth_m`, `count`, `on`, "),
        ("{}", "config: missing key `depth_m`, expected a number within 0 to 100"),
        ("null", "config: missing key `depth_m`, expected a number within 0 to 100"),
        ('{"depth_m": "5"}', 'config: depth_m: "5", expected a number'),
        ('{"depth_m": true}', "config: depth_m: true, expected a number"),
        ('{"depth_m": NaN}', "config: depth_m: NaN, expected a number"),
        ('{"depth_m": 101}', "config: depth_m: 101, expected 0 to 100"),
        ('{"depth_m": 5, "count": 1.5}', "config: count: 1.5, expected a whole number"),
        ('{"depth_m": 5, "side": "up"}', 'config: side: "up", expected "port" or "starboard"'),
        ('{"depth_m": 5, "mode": "c"}', 'config: mode: "c", expected "a" or "b"'),
        ('{"depth_m": 5, "near_m": "x"}', 'config: near_m: "x", expected a number'),
        ('{"depth_m": 5, "lines": 4}', "config: lines: 4, expected a list"),
        ('{"depth_m": 5, "lines": [1, "x"]}', 'config: lines[1]: "x", expected a number'),
        ('{"depth_m": 5, "pair": [1]}', "config: pair: a list, expected a list of 2"),
        ('{"depth_m": 5, "bounded": [0, 2]}', "config: bounded[1]: 2, expected 0 to 1"),
        ('{"depth_m": 5, "inner": [{}]}', "config: inner[0]: missing key `name`, expected text"),
        ('{"depth_m": 5, "inner": [{"nane": "x"}]}', "config: inner[0]: unknown key `nane`, did you mean `name`?"),
        ('{"depth_m": 5, "by_number": {"x": 1}}', "config: by_number: the key `x` is no whole number"),
        ("[]", "config: a list, expected a table"),
    ],
)
def test_what_does_not_fit_is_refused_in_one_line(text, told):
    with pytest.raises(ValueError) as refused:
        read(text)
    assert str(refused.value).startswith(told)
    assert "\n" not in str(refused.value)


def test_the_tools_for_surveys_survive_a_snapshot():
    @dataclass
    class State:
        timers: Timers = field(default_factory=Timers)
        queue: InsertQueue = field(default_factory=InsertQueue)
        fit: PlaneFit = field(default_factory=PlaneFit)
        grid: CoverageGrid = field(default_factory=CoverageGrid)
        place: Local | None = None

    state = State()
    state.timers.due["a"] = (5, 1)
    state.fit.add(Local(1.0, 2.0), 3.0)
    state.grid = CoverageGrid(Box(Local(0.0, 0.0), 100.0, 50.0, 30.0), 10.0)
    state.place = Local(0.1, -7.0)
    back = from_json(State, to_json(state), "state")
    assert back.timers.due == {"a": (5, 1)}
    assert back.fit.points == [(1.0, 2.0, 3.0)]
    assert back.grid == state.grid
    assert back.place == state.place


def test_a_set_has_no_order_and_so_no_snapshot():
    @dataclass
    class State:
        seen: set = field(default_factory=set)

    with pytest.raises(TypeError, match="state.seen is a set, which is none"):
        to_json(State())
