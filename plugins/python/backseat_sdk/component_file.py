"""The imports and exports of a WebAssembly component, read from the file itself.

Source: the binary format of the component model (WebAssembly/component-model, design/mvp/Binary.md).
"""

from __future__ import annotations

#: The preamble of a component: magic, version 13, layer 1.
_PREAMBLE = b"\0asm\x0d\0\x01\0"
_IMPORTS, _EXPORTS = 10, 11
#: The kind of an import or export that is a type.
_TYPE = 3


class BadComponent(Exception):
    """Bytes that are no component, in one line."""


def names(data: bytes) -> tuple[set[str], set[str]]:
    """The names of what a component imports and exports, without types, which need nothing of the runtime.

    Raises ``BadComponent``.
    """
    if data[: len(_PREAMBLE)] != _PREAMBLE:
        raise BadComponent("the file does not begin as one")
    found: dict[int, set[str]] = {_IMPORTS: set(), _EXPORTS: set()}
    reader = _Reader(data, len(_PREAMBLE))
    while reader.at < len(data):
        section = reader.byte()
        size = reader.number()
        end = reader.at + size
        if end > len(data):
            raise BadComponent(f"section {section} at byte {reader.at} is longer than the file")
        if section in found:
            for _ in range(reader.number()):
                name = reader.name()
                if section == _EXPORTS:
                    kind = reader.sort_and_index()
                    if reader.byte() == 1:
                        reader.extern()
                else:
                    kind = reader.extern()
                if kind != _TYPE:
                    found[section].add(name)
            if reader.at != end:
                raise BadComponent(f"section {section} ends at byte {reader.at}, not at {end}")
        reader.at = end
    return found[_IMPORTS], found[_EXPORTS]


class _Reader:
    def __init__(self, data: bytes, at: int) -> None:
        self.data, self.at = data, at

    def byte(self) -> int:
        if self.at >= len(self.data):
            raise BadComponent("the file ends too early")
        self.at += 1
        return self.data[self.at - 1]

    def number(self) -> int:
        """A number of at most 32 bits in LEB128."""
        value = 0
        for shift in range(0, 35, 7):
            byte = self.byte()
            value |= (byte & 0x7F) << shift
            if byte < 0x80:
                return value
        raise BadComponent(f"a number at byte {self.at} is too long")

    def name(self) -> str:
        kind = self.byte()
        if kind > 2:
            raise BadComponent(f"a name of an unknown kind, {kind}, at byte {self.at}")
        length = self.number()
        text = self.data[self.at : self.at + length]
        self.at += length
        if kind == 2:
            raise BadComponent("a name with attributes, which this reader does not know")
        return text.decode("utf-8", "replace")

    def sort_and_index(self) -> int:
        """What an export refers to; returns its kind."""
        kind = self.byte()
        if kind == 0:
            self.byte()
        self.number()
        return kind

    def extern(self) -> int:
        """The type of an import or export, which is passed over; returns its kind."""
        kind = self.byte()
        if kind == 0:
            self.byte()
            self.number()
        elif kind in (2, 3):
            if self.byte() == 0 or kind == 2:
                self.number()
        elif kind in (1, 4, 5):
            self.number()
        else:
            raise BadComponent(f"a type of an unknown kind, {kind}, at byte {self.at}")
        return kind
