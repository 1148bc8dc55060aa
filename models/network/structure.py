"""What a network may be made of, looked at before the runtime in C++ is given the file.

A checksum says that a file is whole, not who wrote it: a file of a few kB may ask for
gigabytes of tensors, or for operators that read files and keep state.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from foundation.errors import NetworkError
from models.network.flat import FlatError, Table

MODEL_OPERATOR_CODES, MODEL_SUBGRAPHS = 1, 2
CODE_DEPRECATED, CODE_CUSTOM, CODE_BUILTIN = 0, 1, 3
GRAPH_TENSORS, GRAPH_OPERATORS = 0, 3
TENSOR_SHAPE = 0
OPERATOR_CODE, OPERATOR_INPUTS, OPERATOR_OUTPUTS = 0, 1, 2

ALLOWED: dict[int, str] = {
    0: "ADD", 2: "CONCATENATION", 6: "DEQUANTIZE", 9: "FULLY_CONNECTED", 14: "LOGISTIC",
    18: "MUL", 19: "RELU", 21: "RELU6", 22: "RESHAPE", 28: "TANH", 41: "SUB", 42: "DIV",
    45: "STRIDED_SLICE", 47: "EXP", 53: "CAST", 65: "SLICE", 66: "SIN", 75: "SQRT",
    77: "SHAPE", 83: "PACK", 92: "SQUARE", 98: "LEAKY_RELU", 108: "COS", 111: "ELU",
    114: "QUANTIZE",
}  # fmt: skip
"""Builtin operators by their number in the TFLite schema; plain arithmetic, no others."""
MOST_OPERATORS, MOST_TENSORS, MOST_CODES = 1000, 2000, 100
MOST_ELEMENTS = 16 * 2**20
"""Of all tensors together; the shipped network has some thousand."""


def check_structure(content: bytes, where: str) -> None:
    """Raises NetworkError (one line) for anything but one small graph of plain arithmetic."""
    try:
        for problem in _problems(Table.root(content)):
            raise NetworkError(f"{where}: {problem}; it is not run")
    except FlatError as error:
        raise NetworkError(f"{where}: {error}; copy or train it again") from None


def _problems(model: Table) -> Iterator[str]:
    codes = [_code(one) for one in model.tables(MODEL_OPERATOR_CODES, MOST_CODES)]
    for code, custom in codes:
        if custom or code not in ALLOWED:
            yield f"has an operator that no network here needs ({custom or code})"
    graphs = list(model.tables(MODEL_SUBGRAPHS, MOST_CODES))
    if len(graphs) != 1:
        yield f"has {len(graphs)} graphs instead of one"
    for graph in graphs:
        yield from _graph_problems(graph, len(codes))


def _graph_problems(graph: Table, codes: int) -> Iterator[str]:
    elements = tensors = 0
    for tensor in graph.tables(GRAPH_TENSORS, MOST_TENSORS):
        shape = tensor.i32s(TENSOR_SHAPE)
        if len(shape) > 8 or any(size < 0 for size in shape):
            yield f"has a tensor of shape {shape[:8]}"
        elements += math.prod(shape)
        tensors += 1
        if elements > MOST_ELEMENTS:
            yield f"has tensors of more than {MOST_ELEMENTS} numbers"
    for operator in graph.tables(GRAPH_OPERATORS, MOST_OPERATORS):
        if operator.u32(OPERATOR_CODE) >= codes:
            yield "has an operator without a code"
        touched = [*operator.i32s(OPERATOR_INPUTS), *operator.i32s(OPERATOR_OUTPUTS)]
        if any(not -1 <= index < tensors for index in touched):
            yield "has an operator on a tensor that is not there"


def _code(table: Table) -> tuple[int, str]:
    custom = table.span(CODE_CUSTOM).of(table.content)[:40].decode("ascii", "replace")
    return max(table.u8(CODE_DEPRECATED), table.u32(CODE_BUILTIN)), custom
