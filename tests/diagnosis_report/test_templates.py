"""The report renders: what decides stands in the answer, and every sentence in the templates."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path

from deltactl.diagnosis import report
from deltactl.diagnosis.report.pairs import RULES
from deltactl.diagnosis.report.templates import templates

FILES = sorted(Path(report.__path__[0]).glob("*.py"))
FEW = (0, 1, 2)
"""Numbers that a count may be compared with: none, one, several."""
MOST_COMPLEX = 15
MOST_PAIR_RULES = 12
FORKS = (ast.If, ast.IfExp, ast.For, ast.While, ast.ExceptHandler, ast.BoolOp, ast.comprehension)


def trees() -> Iterator[tuple[str, ast.Module]]:
    for file in FILES:
        yield file.name, ast.parse(file.read_text(encoding="utf-8"))


def test_nothing_is_decided_by_a_number_of_the_report() -> None:
    found = [
        f"{name}: {ast.unparse(node)}"
        for name, tree in trees()
        for node in ast.walk(tree)
        if isinstance(node, ast.Compare)
        for part in (node.left, *node.comparators)
        if isinstance(part, ast.Constant)
        and isinstance(part.value, int | float)
        and not isinstance(part.value, bool)
        and part.value not in FEW
    ]
    assert found == []


def test_no_sentence_is_cut_apart_again() -> None:
    found = [
        name
        for name, tree in trees()
        for node in ast.walk(tree)
        if isinstance(node, ast.Import) and any(one.name in ("re", "regex") for one in node.names)
    ]
    assert found == []


def test_rules_for_pairs_are_few_and_in_one_file() -> None:
    (pairs,) = (tree for name, tree in trees() if name == "pairs.py")
    others = ("uneven", "harmonic", "bearings", "late_drives")
    named = {node.name for node in pairs.body if isinstance(node, ast.FunctionDef)}
    assert set(others) <= named
    together = sum(isinstance(node, ast.Yield) for node in ast.walk(pairs))
    assert len(RULES) + len(others) + together <= MOST_PAIR_RULES


def test_functions_are_simple() -> None:
    found = [
        f"{name}: {node.name}"
        for name, tree in trees()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
        and 1 + sum(isinstance(one, FORKS) for one in ast.walk(node)) > MOST_COMPLEX
    ]
    assert found == []


def keys_asked_for() -> Iterator[str]:
    """Patterns of the keys that the report's files name, '*' for what is chosen by a case."""
    for _, tree in trees():
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield node.value
            if isinstance(node, ast.JoinedStr):
                yield "".join(
                    str(part.value) if isinstance(part, ast.Constant) else "*"
                    for part in node.values
                )


def test_every_template_is_used() -> None:
    topics = {key.partition(".")[0] for key in templates()}
    asked = {one for one in keys_asked_for() if one.partition(".")[0] in topics and "." in one}
    looked_up = {f"{topic}.*" for topic in ("part", "channel", "follows", "unit", "ways")}
    unused = [key for key in templates() if not any(fnmatch(key, one) for one in asked | looked_up)]
    assert unused == []


def test_every_template_that_is_asked_for_exists() -> None:
    """A plain key is one; a pattern has at least one that fits."""
    topics = {key.partition(".")[0] for key in templates()}
    calls = [
        node.args[0]
        for _, tree in trees()
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id == "say"
        and node.args
    ]
    plain = [
        one.value
        for call in calls
        for one in ast.walk(call)
        if isinstance(one, ast.Constant)
        and isinstance(one.value, str)
        and "." in one.value
        and one.value.partition(".")[0] in topics
        and not one.value.endswith((".", "_"))
    ]
    assert plain
    assert [key for key in plain if key not in templates()] == []
