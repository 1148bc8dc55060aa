"""A network is read through before the runtime in C++, which trusts what it is given, runs it.

A checksum says that a file is whole, not who wrote it. One random change to a file in a hundred
took the runtime down. So only what deltactl writes is let through: one graph of dense layers and
plain arithmetic in float32, every offset, shape and buffer of it checked here, and no field that is
not checked.

The few parts of a file that this program needs are read with every offset checked: the runtime
trusts a flatbuffer's offsets. Field numbers are those of the TFLite schema
(tensorflow/compiler/mlir/lite/schema/schema.fbs, version 3), counted from 0 per table.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass

from deltactl.foundation.errors import NetworkError

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


FULLY_CONNECTED, LOGISTIC, MUL, RESHAPE, TANH = 9, 14, 18, 22, 28
OPTIONS = {FULLY_CONNECTED: 8, LOGISTIC: 0, MUL: 21, RESHAPE: 17, TANH: 0}
"""Operators by builtin code, and the kind of options that each may have."""
FLOAT32, INT32 = 0, 2
MOST_OPERATORS, MOST_TENSORS = 1000, 2000
MOST_ELEMENTS = 16 * 2**20
"""Elements of all tensors together; the shipped networks have some hundred."""

# Numbers of the fields that may be there, by table.
_MODEL = {0: "version", 1: "codes", 2: "graphs", 3: "description", 4: "buffers", 6: "metadata"}
_CODE = {0: "deprecated", 2: "version", 3: "builtin"}
_GRAPH = {0: "tensors", 1: "inputs", 2: "outputs", 3: "operators", 4: "name"}
_TENSOR = {0: "shape", 1: "type", 2: "buffer", 3: "name"}
_OPERATOR = {0: "code", 1: "inputs", 2: "outputs", 3: "options_type", 4: "options"}
_BUFFER = {0: "data"}

Shape = tuple[int, ...]


@dataclass(frozen=True, slots=True)
class _Tensor:
    shape: Shape
    kind: int
    data: bytes

    @property
    def elements(self) -> int:
        return math.prod(self.shape)


def check_structure(content: bytes, where: str) -> None:
    """Raises NetworkError (one line) for anything but a small graph of dense layers."""
    try:
        _Network(content).check()
    except FlatError as error:
        raise NetworkError(f"{where}: {error}; it is not run, train it again") from None


class _Network:
    def __init__(self, content: bytes):
        model = _only(Table.root(content), _MODEL)
        _named(model, 3)
        self._codes = [_code(table) for table in model.tables(1, 100)]
        self._buffers = [_data(table) for table in model.tables(4, MOST_TENSORS)]
        graphs = list(model.tables(2, 100))
        if len(graphs) != 1:
            raise FlatError(f"has {len(graphs)} graphs instead of one")
        self._graph = _only(graphs[0], _GRAPH)
        _named(self._graph, 4)
        self._tensors = self._read_tensors()

    def check(self) -> None:
        """Every operator has what it needs, from tensors that are there by then."""
        ready = {index for index, tensor in enumerate(self._tensors) if tensor.data}
        for index in self._graph.i32s(1):
            if self._tensor(index).data:
                raise FlatError("has an input that is a constant")
            ready.add(index)
        for operator in self._graph.tables(3, MOST_OPERATORS):
            self._check_operator(_only(operator, _OPERATOR), ready)
        for index in self._graph.i32s(2):
            if index not in ready:
                raise FlatError("has an output that nothing makes")

    def _read_tensors(self) -> list[_Tensor]:
        found, elements = [], 0
        for table in self._graph.tables(0, MOST_TENSORS):
            tensor = self._read_tensor(_only(table, _TENSOR))
            elements += tensor.elements
            if elements > MOST_ELEMENTS:
                raise FlatError(f"has tensors of more than {MOST_ELEMENTS} numbers")
            found.append(tensor)
        return found

    def _read_tensor(self, table: Table) -> _Tensor:
        _named(table, 3)
        shape, kind, buffer = table.i32s(0), table.u8(1), table.u32(2)
        if not 1 <= len(shape) <= 4 or not all(1 <= size <= MOST_ELEMENTS for size in shape):
            raise FlatError(f"has a tensor of shape {shape[:8]}")
        if kind not in (FLOAT32, INT32):
            raise FlatError(f"has a tensor of type {kind}, neither float32 nor int32")
        if buffer >= len(self._buffers):
            raise FlatError("has a tensor without a buffer")
        tensor = _Tensor(shape, kind, self._buffers[buffer])
        if tensor.data and len(tensor.data) != 4 * tensor.elements:
            raise FlatError(f"has {len(tensor.data)} bytes for a tensor of shape {shape}")
        return tensor

    def _tensor(self, index: int) -> _Tensor:
        if not 0 <= index < len(self._tensors):
            raise FlatError("names a tensor that is not there")
        return self._tensors[index]

    def _check_operator(self, operator: Table, ready: set[int]) -> None:
        number, inputs, outputs = operator.u32(0), operator.i32s(1), operator.i32s(2)
        if number >= len(self._codes):
            raise FlatError("has an operator without a code")
        code = self._codes[number]
        if operator.u8(3) != OPTIONS[code]:
            raise FlatError(f"has options of kind {operator.u8(3)} for operator {code}")
        _check_options(operator, code)
        if len(outputs) != 1 or outputs[0] in ready or not set(inputs) <= ready:
            raise FlatError("has operators that do not follow from one another")
        given, made = [self._tensor(index) for index in inputs], self._tensor(outputs[0])
        if made.kind != FLOAT32 or not _FITS[code](given, made):
            shapes = ", ".join(str(tensor.shape) for tensor in given)
            raise FlatError(f"has an operator {code} from {shapes} to {made.shape}")
        ready.add(outputs[0])


def _dense_fits(given: list[_Tensor], made: _Tensor) -> bool:
    if not 2 <= len(given) <= 3 or any(tensor.kind != FLOAT32 for tensor in given):
        return False
    x, weights = given[:2]
    if len(x.shape) != 2 or len(weights.shape) != 2 or not weights.data:
        return False
    if len(given) == 3 and (given[2].shape != weights.shape[:1] or not given[2].data):
        return False
    return x.shape[1] == weights.shape[1] and made.shape == (x.shape[0], weights.shape[0])


def _same_fits(count: int, given: list[_Tensor], made: _Tensor) -> bool:
    alike = all(tensor.kind == FLOAT32 and tensor.shape == made.shape for tensor in given)
    return len(given) == count and alike


def _reshape_fits(given: list[_Tensor], made: _Tensor) -> bool:
    if len(given) != 2 or given[0].kind != FLOAT32 or given[0].elements != made.elements:
        return False
    shape = given[1]
    wanted = b"".join(size.to_bytes(4, "little") for size in made.shape)
    return shape.kind == INT32 and shape.data == wanted and shape.shape == (len(made.shape),)


_FITS = {
    FULLY_CONNECTED: _dense_fits,
    MUL: lambda given, made: _same_fits(2, given, made),
    LOGISTIC: lambda given, made: _same_fits(1, given, made),
    TANH: lambda given, made: _same_fits(1, given, made),
    RESHAPE: _reshape_fits,
}


def _check_options(operator: Table, code: int) -> None:
    """Options may be left out; those that are there must be zero, or the new shape's vector."""
    at = operator.target(4)
    if at is None:
        return
    for number in at.present():
        if code == RESHAPE and number == 0:
            at.i32s(0)
        elif code in (FULLY_CONNECTED, MUL) and number < 4 and at.u8(number) == 0:
            continue
        else:
            raise FlatError(f"has option {number} of operator {code} set")


def _only(table: Table, known: dict[int, str]) -> Table:
    """The table, if no other fields than these are in it."""
    for number in table.present():
        if number not in known:
            raise FlatError(f"has a part that no network of deltactl has (field {number})")
    return table


def _named(table: Table, number: int) -> None:
    """A text must end with a zero byte: the runtime reads up to that."""
    span = table.span(number)
    if (
        span.length
        and table.content[span.start + span.length : span.start + span.length + 1] != b"\0"
    ):
        raise FlatError("has a text without an end")


def _code(table: Table) -> int:
    _only(table, _CODE)
    code = max(table.u8(0), table.u32(3))
    if code not in OPTIONS:
        raise FlatError(f"has an operator that no network here needs ({code})")
    return code


def _data(table: Table) -> bytes:
    span = _only(table, _BUFFER).span(0)
    if span.start % 4:
        raise FlatError("has numbers at odd places")
    return span.of(table.content)
