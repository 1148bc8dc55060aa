"""A small graph, kept in float64 and written as a float32 TFLite file without TensorFlow.

Only what a network of arm angles needs: FullyConnected, Tanh, Logistic, Mul, Reshape.
Operator versions are the lowest that both runtimes take for float32.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import flatbuffers
import numpy as np
import tflite

from deltactl.models.network.metadata import METADATA_NAME
from deltactl.models.network.structure import IDENTIFIER
from deltactl.models.robot import FloatArray

Activation = Literal["tanh", "sigmoid"]

_SCHEMA_VERSION = 3
_ALIGNMENT = 16
"""The runtime reads weights in place, with vector instructions."""

_OPERATORS = {
    "fully_connected": tflite.BuiltinOperator.FULLY_CONNECTED,
    "tanh": tflite.BuiltinOperator.TANH,
    "sigmoid": tflite.BuiltinOperator.LOGISTIC,
    "mul": tflite.BuiltinOperator.MUL,
    "reshape": tflite.BuiltinOperator.RESHAPE,
}
_OPTIONS = {
    "fully_connected": "FullyConnectedOptions",
    "mul": "MulOptions",
    "reshape": "ReshapeOptions",
}


@dataclass(frozen=True)
class _Tensor:
    name: str
    shape: tuple[int, ...]
    data: np.ndarray[Any, Any] | None = None


@dataclass(frozen=True)
class _Operation:
    kind: str
    inputs: tuple[int, ...]
    output: int


@dataclass
class Graph:
    """Operations in order; every method returns the index of the tensor it made."""

    tensors: list[_Tensor] = field(default_factory=list)
    operations: list[_Operation] = field(default_factory=list)

    def input(self, name: str, shape: tuple[int, ...]) -> int:
        """A tensor the caller fills in."""
        return self._add(_Tensor(name, shape))

    def fully_connected(self, source: int, weights: Any, bias: Any) -> int:
        """`source @ weights.T + bias`; weights of shape (outputs, inputs)."""
        w = np.asarray(weights, dtype=np.float64)
        b = np.asarray(bias, dtype=np.float64)
        rows, columns = self.tensors[source].shape
        if w.ndim != 2 or w.shape[1] != columns or b.shape != (w.shape[0],):
            raise ValueError(f"weights {w.shape}, bias {b.shape} do not fit {columns} inputs")
        inputs = (source, self._constant("weights", w), self._constant("bias", b))
        return self._apply("fully_connected", inputs, (rows, w.shape[0]))

    def activation(self, source: int, kind: Activation) -> int:
        """Tanh or sigmoid of every element."""
        return self._apply(kind, (source,), self.tensors[source].shape)

    def multiply(self, first: int, second: int) -> int:
        """Element by element; shapes must be equal."""
        shape = self.tensors[first].shape
        if shape != self.tensors[second].shape:
            raise ValueError(f"cannot multiply {shape} by {self.tensors[second].shape}")
        return self._apply("mul", (first, second), shape)

    def reshape(self, source: int, shape: tuple[int, ...]) -> int:
        """The same numbers in another shape."""
        if np.prod(shape) != np.prod(self.tensors[source].shape):
            raise ValueError(f"cannot reshape {self.tensors[source].shape} to {shape}")
        new_shape = self._constant("shape", np.array(shape, dtype=np.int32))
        return self._apply("reshape", (source, new_shape), shape)

    def values(self, source: int, result: int, inputs: FloatArray) -> FloatArray:
        """The graph in float64, what the file is checked against: (n, columns) to (n, columns)."""
        known: dict[int, FloatArray] = {source: np.asarray(inputs, dtype=np.float64)[:, None, :]}
        for operation in self.operations:
            known[operation.output] = self._value(operation, known)
        return known[result].reshape(len(inputs), -1)

    def to_bytes(self, source: int, result: int, description: str, metadata: bytes) -> bytes:
        """The TFLite file with `metadata` under our name."""
        return _Writer(self, source, result).write(description, metadata)

    def _value(self, operation: _Operation, known: dict[int, FloatArray]) -> FloatArray:
        first, *others = operation.inputs
        value = known[first]
        if operation.kind == "fully_connected":
            weights, bias = (self.tensors[index].data for index in others)
            assert weights is not None
            assert bias is not None
            product: FloatArray = value @ weights.T + bias
            return product
        if operation.kind == "mul":
            return value * known[others[0]]
        if operation.kind == "reshape":
            return value.reshape(len(value), *self.tensors[operation.output].shape)
        bent: FloatArray = np.tanh(value)
        # A sigmoid written with tanh: exp would overflow for large negative values.
        return bent if operation.kind == "tanh" else 0.5 + 0.5 * np.tanh(0.5 * value)

    def _constant(self, role: str, data: np.ndarray[Any, Any]) -> int:
        return self._add(_Tensor(f"{role}_{len(self.tensors)}", data.shape, data))

    def _apply(self, kind: str, inputs: tuple[int, ...], shape: tuple[int, ...]) -> int:
        output = self._add(_Tensor(f"{kind}_{len(self.tensors)}", shape))
        self.operations.append(_Operation(kind, inputs, output))
        return output

    def _add(self, tensor: _Tensor) -> int:
        self.tensors.append(tensor)
        return len(self.tensors) - 1


def _stored(data: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """As in the file: shapes are whole numbers, all else is float32."""
    return data if data.dtype == np.int32 else data.astype(np.float32)


class _Writer:
    """Flatbuffers are written back to front: children before the tables that name them."""

    def __init__(self, graph: Graph, source: int, result: int):
        self.graph, self.source, self.result = graph, source, result
        self.builder = flatbuffers.Builder(16 * 1024)
        self.kinds = sorted({operation.kind for operation in graph.operations})

    def write(self, description: str, metadata: bytes) -> bytes:
        # Buffer 0 is empty by convention: tensors without data point at it.
        constants = [_stored(t.data).tobytes() for t in self.graph.tensors if t.data is not None]
        contents = [b"", *constants, metadata]
        buffers = self._tables([self._buffer(content) for content in contents])
        subgraphs = self._tables([self._subgraph()])
        codes = self._tables([self._operator_code(kind) for kind in self.kinds])
        name = self.builder.CreateString(METADATA_NAME)
        entries = self._tables([self._table("Metadata", Name=name, Buffer=len(contents) - 1)])
        text = self.builder.CreateString(description)
        model = self._table(
            "Model",
            Version=_SCHEMA_VERSION,
            OperatorCodes=codes,
            Subgraphs=subgraphs,
            Description=text,
            Buffers=buffers,
            Metadata=entries,
        )
        self.builder.Finish(model, file_identifier=IDENTIFIER)
        return bytes(self.builder.Output())

    def _table(self, kind: str, **fields: int | None) -> int:
        """A table of the schema with its fields in this order; those that are None are left out."""
        getattr(tflite, f"{kind}Start")(self.builder)
        for name, value in fields.items():
            if value is not None:
                getattr(tflite, f"{kind}Add{name}")(self.builder, value)
        return int(getattr(tflite, f"{kind}End")(self.builder))

    def _buffer(self, content: bytes) -> int:
        return self._table("Buffer", Data=self._bytes(content) if content else None)

    def _subgraph(self) -> int:
        numbers = iter(range(1, len(self.graph.tensors) + 1))
        tensors = self._tables(
            [
                self._tensor(tensor, next(numbers) if tensor.data is not None else 0)
                for tensor in self.graph.tensors
            ]
        )
        operators = self._tables([self._operator(operation) for operation in self.graph.operations])
        inputs, outputs = self._integers([self.source]), self._integers([self.result])
        return self._table(
            "SubGraph", Tensors=tensors, Inputs=inputs, Outputs=outputs, Operators=operators
        )

    def _tensor(self, tensor: _Tensor, buffer: int) -> int:
        name, shape = self.builder.CreateString(tensor.name), self._integers(tensor.shape)
        is_integer = tensor.data is not None and tensor.data.dtype == np.int32
        kind = tflite.TensorType.INT32 if is_integer else tflite.TensorType.FLOAT32
        return self._table("Tensor", Shape=shape, Type=kind, Buffer=buffer, Name=name)

    def _operator(self, operation: _Operation) -> int:
        kind, options = self._options(operation)
        inputs, outputs = self._integers(operation.inputs), self._integers([operation.output])
        return self._table(
            "Operator",
            OpcodeIndex=self.kinds.index(operation.kind),
            Inputs=inputs,
            Outputs=outputs,
            BuiltinOptionsType=kind,
            BuiltinOptions=options,
        )

    def _options(self, operation: _Operation) -> tuple[int | None, int | None]:
        name = _OPTIONS.get(operation.kind)
        if name is None:
            return None, None
        shape = None
        if operation.kind == "reshape":
            shape = self._integers(self.graph.tensors[operation.output].shape)
        return getattr(tflite.BuiltinOptions, name), self._table(name, NewShape=shape)

    def _operator_code(self, kind: str) -> int:
        code = _OPERATORS[kind]
        # Both fields, as the schema asks for codes below 127.
        return self._table("OperatorCode", DeprecatedBuiltinCode=code, BuiltinCode=code, Version=1)

    def _bytes(self, content: bytes) -> int:
        b = self.builder
        b.StartVector(1, len(content), _ALIGNMENT)
        b.head = b.head - len(content)
        b.Bytes[b.head : b.head + len(content)] = content
        return int(b.EndVector())

    def _integers(self, values: Any) -> int:
        return int(self.builder.CreateNumpyVector(np.array(values, dtype=np.int32)))

    def _tables(self, offsets: list[int]) -> int:
        b = self.builder
        b.StartVector(4, len(offsets), 4)
        for offset in reversed(offsets):
            b.PrependUOffsetTRelative(offset)
        return int(b.EndVector())
