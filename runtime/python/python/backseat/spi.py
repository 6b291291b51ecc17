"""Sentences of the Standard Payload Interface (SPI), the lines of text that the vehicle and its payload exchange.

    >>> from backseat import spi
    >>> spi.decode("$BFCTL,081025.987,1*78")["message"]
    {'created': '08:10:25.987', 'granted': True}
    >>> spi.encode("BPLOG", message="NVG", on=True)
    '$BPLOG,NVG,ON*08\\r\\n'
"""

from __future__ import annotations

import json
from typing import Any, Union

from . import _native
from ._native import SpiError

_Line = Union[str, bytes]


def decode(line: _Line, *, ignore_checksum: bool = False) -> dict[str, Any]:
    """Decodes one sentence.

    Returns:
        A dict with `name`, `checksum` (`valid`, `absent`; `invalid` only with `ignore_checksum`) and `message`: its
        fields by their names, in the units of `catalogue`. A field that the sentence leaves empty is None or absent.

    Raises:
        SpiError: The line has no sentence or several, or the sentence is invalid. The message is one line.
    """
    # With its end, because a line without one counts as cut off if it is invalid.
    sentences = decode_all(_bytes(line).rstrip() + b"\r\n", ignore_checksum=ignore_checksum)
    if len(sentences) != 1:
        found = f"{len(sentences)} sentences" if sentences else "no sentence"
        raise SpiError(f"expected one sentence that begins with $ and a name, found {found}")
    if "error" in sentences[0]:
        raise SpiError(sentences[0]["error"])
    return sentences[0]


def decode_all(text: _Line, *, ignore_checksum: bool = False) -> list[dict[str, Any]]:
    """Decodes every sentence in a text, in any number of lines. An invalid one has `error` in place of `message`."""
    return json.loads(_native.decode(_bytes(text), ignore_checksum))


def _bytes(text: _Line) -> bytes:
    return text.encode("latin-1", "replace") if isinstance(text, str) else bytes(text)


def encode(name: str, /, **fields: Any) -> str:
    """Encodes a message as a sentence with checksum and line end, from its name and its fields as `decode` gives them.

    Raises:
        SpiError: A field is missing, unknown or out of range. The message is one line and names the field.
    """
    return _native.encode(name, json.dumps(fields))


def catalogue(*names: str) -> list[dict[str, Any]]:
    """The 71 messages of the interface, or those with these names: section, direction, title, and fields with unit and
    range.

    Raises:
        SpiError: A name is unknown.
    """
    return json.loads(_native.catalogue(list(names)))
