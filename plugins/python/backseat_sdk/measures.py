"""Publishing named values: what a plugin estimates, how sure it is, how far it has come.

The log has a channel for each name, and the last value of each name is the run's measure ``PLUGIN.NAME``: the report of
``backseat sim`` has it, and ``[[expect.measure]]`` of ``world.toml`` judges a run by it. Publishing changes nothing
else.
"""

from __future__ import annotations

from . import _host


def publish(name: str, value: float, unit: str = "") -> None:
    """Publishes a value.

    - ``name``: 1 to 48 of a-z, 0-9 and _, beginning with a letter. A plugin may use 64 names.
    - ``value``: finite. 64 values are kept a second, with a burst of twice as many.
    - ``unit``: at most 16 bytes, as in ``m``, ``deg`` or ``degC``.

    What does not fit is dropped, and a line in the log counts it and says why.
    """
    _host.current.publish(name, float(value), unit)
