"""Small mistakes that are put into the program, and by which tests each has to be noticed.

Known ones (named.yaml) come first, then ones that a person makes, made by rule and spread over
files (table.yaml).
"""

from __future__ import annotations

import ast
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import NamedTuple

import yaml


class Row(NamedTuple):
    """Files of a folder, so many mutants of each, and the tests of that folder."""

    folder: str
    files: dict[str, int]
    tests: list[str]


class Named(NamedTuple):
    """A known mistake: what it is, its file, what stands there, and what is put in its place."""

    what: str
    path: str
    was: str
    now: str


def _text(name: str) -> str:
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


TABLE: tuple[Row, ...] = tuple(Row(**row) for row in yaml.safe_load(_text("table.yaml")))
NAMED: tuple[Named, ...] = tuple(Named(**row) for row in yaml.safe_load(_text("named.yaml")))
EQUIVALENT: dict[str, str] = json.loads(_text("equivalent.json"))
"""Survivors that are no mistakes, by name, each with the reason."""


COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
SUMS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.BitAnd: ast.BitOr,
}
QUIET = ("_log", "raise", "logging", "warnings")
"""What only says something is left alone: its words are not what is tested here."""


@dataclass(frozen=True, slots=True)
class Mutant:
    """One changed place: in which file, what stood there, what stands there now."""

    path: str
    start: int
    end: int
    was: str
    now: str
    line: str
    lines: range
    """Numbers of the lines that it stands on."""

    @property
    def name(self) -> str:
        """The same for the same mistake, wherever the lines have moved to."""
        return f"{self.path}: {self.line}: {self.was} -> {self.now}"

    def apply(self, text: str) -> str:
        """The text of the file with the mistake in it."""
        return text[: self.start] + self.now + text[self.end :]


def mutants_of(path: str, text: str, count: int, seed: int = 1) -> list[Mutant]:
    """`count` mutants spread evenly over a file; the same ones for the same text."""
    found = list({mutant.name: mutant for mutant in _all(path, text)}.values())
    chance = Random(f"{seed} {path}")
    if len(found) <= count:
        return found
    width = len(found) / count
    return [found[int(width * (place + chance.random()))] for place in range(count)]


def _all(path: str, text: str) -> Iterator[Mutant]:
    lines = text.splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line.encode()))
    raw = text.encode()
    tree = ast.parse(text)
    for node in _worth_it(tree):
        for changed in _changes(node):
            first = starts[node.lineno - 1] + node.col_offset
            last = starts[(node.end_lineno or node.lineno) - 1] + (node.end_col_offset or 0)
            # Offsets of bytes are those of characters in sources of plain ASCII.
            if len(raw) == len(text):
                yield Mutant(
                    path,
                    first,
                    last,
                    text[first:last],
                    changed,
                    lines[node.lineno - 1].strip(),
                    range(node.lineno, (node.end_lineno or node.lineno) + 1),
                )


def _worth_it(tree: ast.AST) -> Iterator[ast.expr | ast.stmt]:
    """Places in code that does something, in the order of the file."""
    waiting: list[ast.AST] = [tree]
    found: list[ast.expr | ast.stmt] = []
    while waiting:
        node = waiting.pop()
        if isinstance(
            node, ast.Raise | ast.JoinedStr | ast.Import | ast.ImportFrom | ast.AnnAssign
        ):
            continue
        if isinstance(node, ast.Expr) and ast.unparse(node).startswith(QUIET):
            continue
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant | ast.Tuple):
            continue  # settings, and what stands in a place before it is first used
        if isinstance(node, ast.expr | ast.stmt):
            found.append(node)
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            waiting.extend(node.body)
        else:
            waiting.extend(ast.iter_child_nodes(node))
    found.sort(key=lambda place: (place.lineno, place.col_offset, place.end_col_offset or 0))
    yield from found


def _changes(node: ast.expr | ast.stmt) -> Iterator[str]:
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in COMPARISONS:
        swapped = COMPARISONS[type(node.ops[0])]()
        yield ast.unparse(ast.Compare(node.left, [swapped], node.comparators))
    elif isinstance(node, ast.BinOp) and type(node.op) in SUMS:
        if not any(isinstance(side, ast.JoinedStr) for side in (node.left, node.right)):
            yield f"({ast.unparse(ast.BinOp(node.left, SUMS[type(node.op)](), node.right))})"
    elif isinstance(node, ast.BoolOp):
        other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield f"({ast.unparse(ast.BoolOp(other, node.values))})"
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        yield f"({ast.unparse(node.operand)})"
    elif isinstance(node, ast.Constant):
        yield from _other_constants(node.value)
    elif isinstance(node, ast.AugAssign) or _is_call(node):
        yield "pass"


def _is_call(node: ast.expr | ast.stmt) -> bool:
    """A statement that only calls something."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)


def _other_constants(value: object) -> Iterator[str]:
    if isinstance(value, bool):
        yield str(not value)
    elif isinstance(value, int):
        yield str(value + 1)
    elif isinstance(value, float):
        yield repr(value * 2.0 if value else 1.0)
