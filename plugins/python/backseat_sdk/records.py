"""Dataclasses from JSON and to JSON: the configuration and the state of a plugin.

Fields can be of these types: ``bool``, ``int``, ``float``, ``str``, an ``Enum`` with plain values, ``Literal``, a
dataclass, ``X | None``, ``list``, ``tuple`` and ``dict`` of them with ``str`` or ``int`` as keys. ``Annotated`` with
``Within`` limits a number, or each number of a list.
"""

from __future__ import annotations

import json
import math
import types
from dataclasses import MISSING, fields, is_dataclass
from difflib import get_close_matches
from enum import Enum
from functools import cache
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from .values import Within

T = TypeVar("T")


def to_json(value: Any) -> str:
    """A dataclass as compact JSON.

    Raises ``TypeError`` for a value that ``from_json`` could not read back.
    """
    try:
        return json.dumps(value, default=_plain, separators=(",", ":"))
    except TypeError as error:
        place = _misfit(value, "state")
        raise (TypeError(place) if place else error) from None


def from_json(kind: type[T], text: str, whole: str) -> T:
    """A dataclass from JSON; ``whole`` names it in errors: "config" or "state".

    Raises ``ValueError`` with one line: the key, what it is, and what was expected.
    """
    try:
        data = json.loads(text)
    except ValueError as error:
        raise ValueError(f"{whole}: no JSON: {error}") from None
    if data is None:
        data = {}
    return _record(kind, data, "", whole)


def _plain(value: Any) -> Any:
    if isinstance(value, Enum):
        return value.value
    if is_dataclass(value) and not isinstance(value, type):
        return vars(value)
    raise TypeError(type(value).__name__)


def _misfit(value: Any, place: str) -> str | None:
    """Where a value has something that a snapshot cannot hold, in one line."""
    if value is None or isinstance(value, str | int | float | Enum):
        return None
    if is_dataclass(value) and not isinstance(value, type):
        parts = [(f"{place}.{name}", each) for name, each in vars(value).items()]
    elif isinstance(value, dict):
        parts = [(f"{place}[{key!r}]", each) for key, each in value.items()]
    elif isinstance(value, list | tuple):
        parts = [(f"{place}[{index}]", each) for index, each in enumerate(value)]
    else:
        return f"{place} is a {type(value).__name__}, which is none of the types that a snapshot can hold"
    return next((found for at, each in parts if (found := _misfit(each, at))), None)


@cache
def _hints(kind: Any) -> dict[str, Any]:
    return get_type_hints(kind, include_extras=True)


def _record(kind: Any, data: Any, path: str, whole: str) -> Any:
    where = f"{whole}: {path}" if path else whole
    if not isinstance(data, dict):
        raise ValueError(f"{where}: {_told(data)}, expected a table")
    hints, known = _hints(kind), {field.name: field for field in fields(kind) if field.init}
    for key in data:
        if key not in known:
            near = get_close_matches(str(key), known, n=1, cutoff=0.5)
            hint = f", did you mean `{near[0]}`?" if near else _keys(known)
            raise ValueError(f"{where}: unknown key `{key}`{hint}")
    values = {}
    for name, field in known.items():
        inner = f"{path}.{name}" if path else name
        if name in data:
            values[name] = _value(hints[name], data[name], inner, whole)
        elif field.default is MISSING and field.default_factory is MISSING:
            raise ValueError(f"{where}: missing key `{name}`, expected {_expected(hints[name])}")
    return kind(**values)


def _keys(known: dict[str, Any]) -> str:
    return f", expected {', '.join(f'`{name}`' for name in known)}" if known else ": there are no settings"


def _value(kind: Any, data: Any, path: str, whole: str, bound: Within | None = None) -> Any:
    origin, arguments = get_origin(kind), get_args(kind)

    def wrong(expected: str) -> ValueError:
        return ValueError(f"{whole}: {path}: {_told(data)}, expected {expected}")

    if origin is Annotated:
        limits = [extra for extra in arguments[1:] if isinstance(extra, Within)]
        return _value(arguments[0], data, path, whole, limits[0] if limits else bound)
    if origin is Union or origin is types.UnionType:
        if data is None and type(None) in arguments:
            return None
        others = [argument for argument in arguments if argument is not type(None)]
        for other in others[:-1]:
            try:
                return _value(other, data, path, whole, bound)
            except ValueError:
                continue
        return _value(others[-1], data, path, whole, bound)
    if origin is Literal:
        if data not in arguments:
            raise wrong(_expected(kind))
        return data
    if origin in (list, tuple):
        if not isinstance(data, list):
            raise wrong(_expected(kind))
        if origin is list or arguments[1:] == (...,):
            kinds = [arguments[0]] * len(data)
        elif len(arguments) == len(data):
            kinds = list(arguments)
        else:
            raise wrong(f"a list of {len(arguments)}")
        if bound is None and origin is list and arguments[0] in (float, int) and _all_of(arguments[0], data):
            return data
        return origin(
            _value(each, item, f"{path}[{at}]", whole, bound)
            for at, (each, item) in enumerate(zip(kinds, data, strict=True))
        )
    if origin is dict:
        if not isinstance(data, dict):
            raise wrong("a table")
        return {
            _key(arguments[0], key, path, whole): _value(arguments[1], item, f"{path}.{key}", whole, bound)
            for key, item in data.items()
        }
    if isinstance(kind, type) and issubclass(kind, Enum):
        try:
            return kind(data)
        except ValueError:
            raise wrong(_expected(kind)) from None
    if is_dataclass(kind):
        return _record(kind, data, path, whole)
    return _number_or_text(kind, data, wrong, bound, whole == "state")


def _all_of(kind: type, data: list[Any]) -> bool:
    return all(type(item) is kind for item in data)


def _number_or_text(kind: Any, data: Any, wrong: Any, bound: Within | None, any_number: bool) -> Any:
    is_number = isinstance(data, (int, float)) and not isinstance(data, bool)
    if kind is float and is_number and (any_number or math.isfinite(data)):
        value: Any = float(data)
    elif kind is int and is_number and isinstance(data, int):
        value = data
    elif kind in (bool, str) and isinstance(data, kind):
        return data
    elif kind is Any:
        return data
    else:
        raise wrong(_expected(kind))
    if bound is not None and not bound.least <= value <= bound.most:
        raise wrong(f"{bound.least:g} to {bound.most:g}")
    return value


def _key(kind: type, key: str, path: str, whole: str) -> str | int:
    if kind is str:
        return key
    try:
        return int(key)
    except ValueError:
        raise ValueError(f"{whole}: {path}: the key `{key}` is no whole number") from None


def _told(data: Any) -> str:
    return json.dumps(data) if isinstance(data, (str, int, float, bool)) else f"a {type(data).__name__}"


def _expected(kind: Any) -> str:
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Annotated:
        limits = [extra for extra in arguments[1:] if isinstance(extra, Within)]
        inner = _expected(arguments[0])
        return f"{inner} within {limits[0].least:g} to {limits[0].most:g}" if limits else inner
    if origin is Union or origin is types.UnionType:
        return " or ".join(_expected(each) for each in arguments if each is not type(None))
    if origin is Literal:
        return " or ".join(_told(each) for each in arguments)
    if origin in (list, tuple):
        return "a list"
    if isinstance(kind, type) and issubclass(kind, Enum):
        return " or ".join(_told(each.value) for each in kind)
    names = {float: "a number", int: "a whole number", bool: "true or false", str: "text"}
    return names.get(kind, "a table")
