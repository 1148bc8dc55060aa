"""A whole proof: run what is not there yet, then score everything that is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from deltactl.foundation.errors import ConfigError
from deltactl.proof.cases import MORE
from deltactl.proof.prove.one_case import run_case, run_more
from deltactl.proof.prove.reliability import diagram
from deltactl.proof.prove.resumable import (
    USUAL,
    Means,
    Part,
    claim,
    put_text,
    run_missing,
)
from deltactl.proof.prove.score import Score, confusion, picture, score
from deltactl.proof.prove.table import Row, markdown, more_rows, table
from deltactl.proof.prove.ties import run_tie, score_tie, tie_rows


@dataclass(frozen=True)
class Proof:
    """What came out: scores by case, the table, and where it was written."""

    title: str
    scores: list[Score]
    rows: list[Row]
    table_file: Path
    matrix_file: Path


def prove(
    cases: int,
    seed: int,
    out: Path,
    ties: int = 0,
    more: int = 0,
    means: Means = USUAL,
) -> Proof:
    """Run the cases and ties of a seed that are not in `out` yet, and score them all.

    more: cases of the second set, with four and five causes and more kinds of unknowns. Where the
    time of `means` ends, the table is of the cases before the first that is missing.
    Raises ConfigError for a folder of another seed, or when the scheduler does not answer.
    """
    if cases < 1 or ties < 0 or more < 0:
        asked = f"--cases {cases} --ties {ties} --more {more}"
        raise ConfigError(f"{asked}: at least one case is needed, and no number below zero")
    claim(out, {"seed": seed})
    parts = (
        Part("case", range(cases), run_case, _line),
        Part("tie", range(ties), run_tie, _tie_line),
        Part(MORE, range(more), run_more, _line),
    )
    run_missing(parts, seed, out, means)
    return _conclude(parts, seed, out)


def _conclude(parts: tuple[Part, Part, Part], seed: int, out: Path) -> Proof:
    """Score what is in the folder, and write the table and the picture."""
    cases, ties, more = parts
    first = [score(result) for result in cases.results(out)]
    second = [score(result) for result in more.results(out)]
    scores = [*first, *second]
    tied = [score_tie(result) for result in ties.results(out)]
    rows = [*table(scores), *more_rows(second), *(tie_rows(tied) if tied else [])]
    title = f"{_of(len(first), len(cases.numbers))} cases"
    title += f", {_of(len(second), len(more.numbers))} more" if more.numbers else ""
    title += f" and {_of(len(tied), len(ties.numbers))} ties of seed {seed}"
    put_text(out / "table.md", f"{title}\n\n{markdown(rows)}")
    put_text(out / "matrix.svg", picture(confusion(scores), title))
    claims = [claim for marks in scores for claim in marks.claims]
    put_text(out / "reliability.svg", diagram(claims, f"Stated and true, {title}"))
    return Proof(title, scores, rows, out / "table.md", out / "matrix.svg")


def _of(there: int, wanted: int) -> str:
    return str(wanted) if there == wanted else f"the first {there} of {wanted}"


def _line(result: dict[str, Any]) -> str:
    marks = score(result)
    truth = ", ".join(f"{effect} {where}" for effect, where in marks.truth) or "nothing"
    said = ", ".join(f"{effect} {where}" for effect, where in marks.said) or "nothing"
    seconds = result["simulated_s"] + result["diagnosed_s"]
    return f"{marks.case} {marks.motion}: {truth} -> {marks.failure or said} ({seconds:.0f} s)"


def _tie_line(result: dict[str, Any]) -> str:
    marks = score_tie(result)
    truth = ", ".join(f"{a['effect']} {a['where']}" for a in result["truth"]["answers"])
    words = "settled" if marks.settled else "not settled"
    how = "after the proposed run" if marks.proposed else "without a proposed run"
    return f"tie {marks.pair}: {truth}: {words} {how}"
