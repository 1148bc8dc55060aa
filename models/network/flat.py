"""Reads the few parts of a TFLite file this program needs, with every offset checked.

The C++ runtime trusts a flatbuffer's offsets and a broken file can take the interpreter
down with it, so a file is read here first. Field numbers are those of the TFLite schema
(tensorflow/compiler/mlir/lite/schema/schema.fbs, version 3), counted from 0 per table.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

IDENTIFIER = b"TFL3"

MODEL_BUFFERS = 4
MODEL_METADATA = 6
METADATA_NAME = 0
METADATA_BUFFER = 1
BUFFER_DATA = 0


class FlatError(ValueError):
    """An offset or a length of the flatbuffer points outside the file."""


@dataclass(frozen=True)
class Span:
    """Some bytes of the file."""

    start: int
    length: int

    def of(self, content: bytes) -> bytes:
        """The bytes themselves."""
        return content[self.start : self.start + self.length]


@dataclass(frozen=True)
class Table:
    """A table at a position of a flatbuffer."""

    content: bytes
    at: int

    @classmethod
    def root(cls, content: bytes) -> Table:
        """The root table. Raises FlatError when the identifier is not that of TFLite."""
        if content[4:8] != IDENTIFIER:
            raise FlatError("is not a TFLite file (no TFL3 identifier)")
        return cls(content, _u32(content, 0))

    def field(self, number: int) -> int | None:
        """Position of a field's value, or None when the field is absent."""
        vtable = self.at - _i32(self.content, self.at)
        if 4 + 2 * number >= _u16(self.content, vtable):
            return None
        offset = _u16(self.content, vtable + 4 + 2 * number)
        return self.at + offset if offset else None

    def u32(self, number: int) -> int:
        """An unsigned field; absent ones are 0, as flatbuffers leave out defaults."""
        at = self.field(number)
        return 0 if at is None else _u32(self.content, at)

    def present(self) -> list[int]:
        """Numbers of the fields that are there."""
        vtable = self.at - _i32(self.content, self.at)
        fields = max(0, _u16(self.content, vtable) - 4) // 2
        return [number for number in range(fields) if self.field(number) is not None]

    def target(self, number: int) -> Table | None:
        """The table that a field points to; None when it is absent."""
        at = self.field(number)
        return None if at is None else Table(self.content, at + _u32(self.content, at))

    def u8(self, number: int) -> int:
        """A field of one byte; absent ones are 0."""
        at = self.field(number)
        return 0 if at is None else _unpack("<B", self.content, at)

    def i32s(self, number: int) -> tuple[int, ...]:
        """A vector of whole numbers of 32 bits."""
        span = self.span(number, item_size=4)
        return struct.unpack(f"<{span.length // 4}i", span.of(self.content))

    def span(self, number: int, item_size: int = 1) -> Span:
        """The payload of a vector or string field (empty when absent)."""
        at = self.field(number)
        if at is None:
            return Span(0, 0)
        start = at + _u32(self.content, at) + 4
        length = _u32(self.content, start - 4) * item_size
        if start + length > len(self.content):
            raise FlatError("is truncated: a vector runs past the end of the file")
        return Span(start, length)

    def tables(self, number: int, most: int = 100_000) -> Iterator[Table]:
        """The tables of a vector field. Raises FlatError when there are more than `most`."""
        span = self.span(number, item_size=4)
        if span.length > 4 * most:
            raise FlatError(f"is broken: it names more than {most} parts")
        for at in range(span.start, span.start + span.length, 4):
            yield Table(self.content, at + _u32(self.content, at))


def metadata_span(content: bytes, name: str) -> Span | None:
    """Where the metadata buffer of this name is, or None. Raises FlatError."""
    model = Table.root(content)
    wanted = name.encode()
    for entry in model.tables(MODEL_METADATA):
        if entry.span(METADATA_NAME).of(content) == wanted:
            index = entry.u32(METADATA_BUFFER)
            buffers = list(model.tables(MODEL_BUFFERS))
            if index >= len(buffers):
                raise FlatError("names a metadata buffer that does not exist")
            return buffers[index].span(BUFFER_DATA)
    return None


def _unpack(layout: str, content: bytes, at: int) -> int:
    # A negative offset would silently count from the end.
    if at < 0:
        raise FlatError("is broken: an offset points before its start")
    try:
        return int(struct.unpack_from(layout, content, at)[0])
    except struct.error:
        raise FlatError("is truncated: an offset points past its end") from None


def _u16(content: bytes, at: int) -> int:
    return _unpack("<H", content, at)


def _u32(content: bytes, at: int) -> int:
    return _unpack("<I", content, at)


def _i32(content: bytes, at: int) -> int:
    return _unpack("<i", content, at)
