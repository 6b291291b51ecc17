"""Flights of a mission in simulation."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Union

from . import _native

_Path = Union[str, "os.PathLike[str]"]

_SEED_MAX = 2**64 - 1


@dataclass(frozen=True)
class Run:
    """A simulated run. Times are in seconds, and the other units are in the names."""

    report: dict[str, Any] = field(repr=False)
    """Everything that `backseat sim --json` prints; the page "The report" explains each key."""
    log: str | None = None
    """The path of the log, if one was asked for."""

    @property
    def mission(self) -> str:
        """The mission's name."""
        return self.report["mission"]

    @property
    def seed(self) -> int:
        """The seed."""
        return self.report["seed"]

    @property
    def outcome(self) -> str:
        """`completed`, `aborted`, or `overran` (the run's own end came before the mission's)."""
        return self.report["outcome"]

    @property
    def passed(self) -> bool:
        """Whether every expectation of `world.toml` held; `report["unmet"]` says which did not."""
        return not self.report["unmet"]

    @property
    def measures(self) -> dict[str, float]:
        """What the mission's expectations measured, by name with unit, such as `contour_rms_m`."""
        return self.report["measures"]

    @property
    def published(self) -> dict[str, dict[str, Any]]:
        """The last `value` of each measure that plugins published and its `unit`, by `PLUGIN.NAME`."""
        return self.report["published"]

    @property
    def violations(self) -> list[dict[str, Any]]:
        """Each broken safety rule that the oracle found; empty in a safe run."""
        return self.report["violations"]

    @property
    def requests(self) -> dict[str, int]:
        """How many requests reached which state."""
        return self.report["requests"]

    @property
    def digest(self) -> str:
        """The hash of every byte on the link. Equal digests are equal runs."""
        return self.report["digest"]

    def __str__(self) -> str:
        ended = f"{self.outcome} after {self.report['sim_seconds'] / 60:.1f} min"
        return f"{self.mission}, seed {self.seed}: {ended}, {len(self.violations)} violations"


def simulate(
    mission: _Path,
    seed: int = 1,
    set: Mapping[str, Any] | None = None,
    faults: _Path | None = None,
    plugins: _Path | None = None,
    log: _Path | None = None,
    draw_faults: str | None = None,
) -> Run:
    """Flies a mission to its end, on a virtual clock, and returns what became of it.

    The same mission, seed, settings and plugins give the same run on every machine, and the same as `backseat sim`.
    The interpreter is free meanwhile, so the threads of a `ThreadPoolExecutor` fly as many runs at once as there are
    processors. Ctrl-C ends a run in the main thread.

    Args:
        mission: The mission's folder, with `mission.toml`, a fence and `world.toml`.
        seed: 0 to 2**64 - 1. Draws the world, the noise, and what the specification leaves open.
        set: Keys of `mission.toml`, such as `{"limits.speed_max_mps": 1.8, "plugin.isobath.config.depth_m": 10}`, and
            of `world.toml`, such as `{"world.current.speed_mps": 0.3}`. They override the files and the environment, as
            `--set` does. `backseat explain KEY` has each key's unit.
        faults: A TOML file of faults in place of those of `world.toml`.
        plugins: The folder in which plugins are looked for first. Without it: the environment's `BACKSEAT_PLUGINS`,
            then `target/plugins` below the working directory.
        log: Writes the log to this file (`.mcap`), for `Log` and all other tools.
        draw_faults: Faults that the seed draws in place of those of `world.toml`, as the hunt draws them: `"3..9@30..800"`
            is 3 to 9 faults that begin 30 to 800 s after the start.

    Raises:
        MissionError: The mission, one of its files, plugins or settings is invalid. The message is one line.
        ValueError: The seed is out of range, or both `faults` and `draw_faults` are given.
        TypeError: A setting has a type that TOML does not have.
        OSError: The log cannot be written.
    """
    if not 0 <= seed <= _SEED_MAX:
        raise ValueError(f"invalid seed {seed}: expected 0 to {_SEED_MAX}")
    if faults is not None and draw_faults is not None:
        raise ValueError("faults and draw_faults: give one of them")
    settings = [f"{key}={_toml(value)}" for key, value in (set or {}).items()]
    report = json.loads(_native.simulate(mission, seed, settings, faults, draw_faults, plugins, log))
    return Run(report, None if log is None else os.fspath(log))


def _toml(value: Any) -> str:
    """A value as TOML writes it."""
    if hasattr(value, "item") and getattr(value, "shape", None) == ():
        value = value.item()  # a scalar of NumPy
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False)
    if isinstance(value, Mapping):
        members = (f"{json.dumps(key, ensure_ascii=False)} = {_toml(member)}" for key, member in value.items())
        return "{ " + ", ".join(members) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    raise TypeError(f"invalid setting {value!r}: expected a number, a boolean, a text, a list or a dict")
