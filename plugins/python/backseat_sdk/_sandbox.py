"""What a component does not have, replaced by what says so.

A component has no WASI: a call that needs it ends the instance by a trap, which has no text. These replacements raise
``NotInSandbox`` instead, with what to use in its place. They cover what an author is likely to write; a call from C
code, such as ``datetime.now()``, still ends in a trap.
"""

from __future__ import annotations

import builtins
import gc
import importlib.machinery
import io
import os
import random
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

from . import log

CLOCK = "a plugin has no clock: use input.now_ns or input.utc_ns"
CHANCE = "a plugin has no randomness: use random.Random(seed) with a seed of the configuration"
FILES = "a plugin has no files: read the file while the module is imported, and it becomes a part of the component"


class NotInSandbox(RuntimeError):
    """A plugin has called something that a component does not have."""


def before_import() -> None:
    """Replaces clock, waiting, randomness and threads, before the author's modules take their names."""
    for name in ("time", "time_ns", "monotonic", "monotonic_ns", "perf_counter", "perf_counter_ns", "process_time"):
        setattr(time, name, _raising(f"time.{name}", CLOCK))
    time.sleep = _raising("time.sleep", "a plugin cannot wait: return, and use a Timer")
    os.urandom = _raising("os.urandom", CHANCE)
    # The functions of the module share a generator whose seed differs from build to build.
    for name in ("random", "uniform", "randint", "randrange", "choice", "shuffle", "gauss", "sample", "seed"):
        setattr(random, name, _raising(f"random.{name}", CHANCE))
    threading.Thread.start = _raising("Thread.start", "a plugin has no threads")


def after_import() -> None:
    """Replaces files, the terminal and the import of modules, once the author's modules are there."""
    builtins.open = io.open = _raising("open", FILES)
    builtins.input = _raising("input", "a plugin has no terminal")
    sys.stdout, sys.stderr = _Lines(log.info), _Lines(log.warn)
    kept = (importlib.machinery.BuiltinImporter, importlib.machinery.FrozenImporter)
    sys.meta_path[:] = [finder for finder in sys.meta_path if finder in kept] + [_Late]
    # What is there now stays: otherwise each full collection of garbage would look at all of it again, for 16 million
    # units of fuel.
    gc.collect()
    gc.freeze()


def mute() -> None:
    """Drops what Python itself would write about an exception that ends the instance: it is logged already."""
    sys.stderr = io.StringIO()


def _raising(name: str, instead: str) -> Callable[..., Any]:
    def refuse(*_: Any, **__: Any) -> Any:
        raise NotInSandbox(f"{name}: {instead}")

    return refuse


class _Late:
    """Finds no module: what is imported after the build is not in the component."""

    @staticmethod
    def find_spec(name: str, path: object = None, target: object = None) -> None:
        raise ModuleNotFoundError(
            f"{name} is not in the component: import what Python's standard library and your own modules have at the "
            "top of a module; no other package runs in the sandbox, numpy neither",
            name=name,
        )


class _Lines(io.TextIOBase):
    """Standard output and standard error go to the run's log, line by line."""

    def __init__(self, write: Callable[[str], None]) -> None:
        self._write = write
        self._rest = ""

    def write(self, text: str) -> int:
        *lines, self._rest = (self._rest + text).split("\n")
        for line in lines:
            self._write(line)
        return len(text)
