"""Writing to the run's log.

A line is cut at 256 bytes. The log keeps 32 lines a step and a second, and only counts further ones. Each line costs
fuel. Without a runtime, lines go to standard error.
"""

from __future__ import annotations

from . import _host


def debug(text: str) -> None:
    """Logs details for the plugin's author."""
    _host.current.write("debug", str(text))


def info(text: str) -> None:
    """Logs information for every reader of the log."""
    _host.current.write("info", str(text))


def warn(text: str) -> None:
    """Logs that something is unexpected."""
    _host.current.write("warn", str(text))


def error(text: str) -> None:
    """Logs that something has failed."""
    _host.current.write("error", str(text))
