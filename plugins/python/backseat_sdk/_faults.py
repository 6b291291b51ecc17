"""Exceptions of a plugin, as lines for the run's log.

A line is cut at 256 bytes and a step keeps 32, so the exception comes first, then the innermost frames of the author's
own code. A frame's source is what the module was when the component was built: a component has no files.
"""

from __future__ import annotations

import types

#: The most frames that are logged.
FRAMES = 8
#: Frames beyond these are not looked at.
MOST_LOOKED_AT = 20
#: The longest line, bytes.
LINE_BYTES = 256
#: The lines of each source file that was read when the component was built, by path.
sources: dict[str, list[str]] = {}


def one_line(error: BaseException) -> str:
    """The exception with the place in the author's code where it was raised, in one line."""
    frames = _frames(error)
    text = _said(error)
    if not frames:
        return _cut(text)
    file, line, function, _ = frames[0]
    where = f" ({file}:{line} in {function})"
    return _cut(text, LINE_BYTES - len(where.encode())) + where


def lines(error: BaseException) -> list[str]:
    """The exception and its innermost frames, for the log."""
    told = [_cut(_said(error))]
    for file, line, function, source in _frames(error):
        told.append(_cut(f"  at {file}:{line} in {function}" + (f": {source}" if source else "")))
    cause = error.__cause__ or (None if error.__suppress_context__ else error.__context__)
    if cause is not None:
        told.append(_cut(f"  because of {one_line(cause)}"))
    return told


def keep_source(module: types.ModuleType) -> None:
    """Reads a module's source, for the frames of later exceptions."""
    path = getattr(module, "__file__", None)
    if path is None or path in sources:
        return
    try:
        with open(path, encoding="utf-8") as file:
            sources[path] = file.read().splitlines()
    except (OSError, UnicodeDecodeError):
        pass


def _said(error: BaseException) -> str:
    try:
        text = " ".join(str(error).split())
    except Exception:  # noqa: BLE001 - an exception whose text fails is still reported
        text = ""
    name = type(error).__name__
    return f"{name}: {text}" if text else name


def _frames(error: BaseException) -> list[tuple[str, int, str, str]]:
    """File, line, function and source of the innermost frames, without those inside the SDK."""
    chain = []
    trace = error.__traceback__
    while trace is not None:
        chain.append(trace)
        trace = trace.tb_next
    found = []
    # A recursion has a thousand frames, and looking at each costs fuel.
    for trace in chain[: -MOST_LOOKED_AT - 1 : -1]:
        code = trace.tb_frame.f_code
        folder, _, file = code.co_filename.rpartition("/")
        if folder.endswith("/backseat_sdk") and file.startswith("_"):
            continue
        text, line = sources.get(code.co_filename, ()), trace.tb_lineno
        source = text[line - 1].strip() if 0 < line <= len(text) else ""
        found.append((file, line, code.co_name, source))
        if len(found) == FRAMES:
            break
    return found


def _cut(text: str, length: int = LINE_BYTES) -> str:
    """At most so many bytes of UTF-8; what is cut is marked."""
    if len(text.encode()) <= length:
        return text
    return text.encode()[: length - 3].decode(errors="ignore") + "..."
