"""The component: what the runtime calls, on top of one plugin class."""

from __future__ import annotations

import sys
import types
from typing import Any

from . import _faults, _host, _sandbox, _wit, log, records
from .plugin import Plugin, Refused, check_class, check_description


class _Instance:
    """The single instance of a component."""

    plugin: Plugin | None = None
    #: The last exception of a step, so that one that comes at each step does not fill the log.
    last = ""


def find(module: types.ModuleType, name: str | None) -> type[Plugin]:
    """The plugin class of a module: the one of this name, or the only one that the module itself defines.

    Raises ``TypeError`` with what was found.
    """
    if name is not None:
        found = [vars(module)[name]] if name in vars(module) else []
    else:
        found = [
            value
            for value in vars(module).values()
            if isinstance(value, type) and issubclass(value, Plugin) and value.__module__ == module.__name__
        ]
    if len(found) != 1:
        names = ", ".join(each.__name__ for each in found) or "none"
        raise TypeError(f"{module.__name__}: expected one class derived from Plugin, found {names}")
    check_class(found[0])
    return found[0]


def world(plugin_class: type[Plugin]) -> type:
    """The class that componentize-py looks for."""
    _host.current = _wit.Imports()
    own = (module for module in list(sys.modules.values()) if (getattr(module, "__file__", "") or "").startswith("/"))
    for module in own:
        if not (module.__file__ or "").startswith(("/python/", "/bundled/", "/world/")):
            _faults.keep_source(module)
    _try(plugin_class)
    instance = _Instance()

    def refuse(error: BaseException) -> Any:
        text = str(error) if isinstance(error, Refused) else _faults.one_line(error)
        return _wit.error(" ".join(text.split()))

    class World(_wit.World):
        def describe(self) -> Any:
            try:
                instance.plugin = plugin_class()
                return _wit.description(instance.plugin.describe())
            except BaseException as error:
                # The interface has no error here either.
                _log(error)
                _sandbox.mute()
                raise

        def init(self, briefing: Any) -> None:
            try:
                instance.plugin = plugin_class()
                try:
                    settings: Any = records.from_json(plugin_class.Config, briefing.config, "config")
                except ValueError as error:
                    raise Refused(str(error)) from None
                instance.plugin.init(settings)
                instance.plugin.brief(_wit.briefing(briefing))
            except BaseException as error:
                raise refuse(error) from None

        def step(self, input: Any) -> list[Any]:
            try:
                return _wit.requests(_started(instance).step(_wit.step_input(input)))
            except BaseException as error:
                text = _faults.one_line(error)
                if text != instance.last:
                    _log(error)
                instance.last = text
            raise _wit.error(text)

        def snapshot(self) -> bytes:
            # The interface has no error here, so the exception is logged and ends the instance.
            try:
                return _started(instance).snapshot()
            except BaseException as error:
                _log(error)
                _sandbox.mute()
                raise

        def restore(self, state: bytes) -> None:
            try:
                _started(instance).restore(bytes(state))
            except BaseException as error:
                text = str(error) if isinstance(error, ValueError) else _faults.one_line(error)
                raise _wit.error(" ".join(text.split())) from None

    return World


def _try(plugin_class: type[Plugin]) -> None:
    """Asks for the description and for the first snapshot while the component is built, where an exception is told with its
    line: the interface has no error for either, so in a flight each would end the instance."""
    plugin = plugin_class()
    description = plugin.describe()
    check_description(description)
    _wit.description(description)
    if plugin_class.snapshot is Plugin.snapshot:
        plugin.snapshot()


def _log(error: BaseException) -> None:
    for line in _faults.lines(error):
        log.error(line)


def _started(instance: _Instance) -> Plugin:
    if instance.plugin is None:
        raise RuntimeError("called before init")
    return instance.plugin
