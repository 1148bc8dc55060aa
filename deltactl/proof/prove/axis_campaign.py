"""A proof of single axes: draw, diagnose and score a range of seeds, and a practice folder."""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal

from deltactl.foundation.errors import ConfigError, MissingFile
from deltactl.proof.axis.cases import draw, write_blind
from deltactl.proof.prove.axis_score import (
    AxisScore,
    axis_markdown,
    axis_rows,
    right,
    score_axis,
    wrong_answers,
)
from deltactl.proof.prove.one_case import diagnose_blind
from deltactl.proof.prove.reliability import diagram
from deltactl.proof.prove.resumable import Means, Part, claim, put_text, run_missing
from deltactl.proof.prove.score import Matrix, picture
from deltactl.proof.prove.table import Row

Half = Literal["all", "even", "odd"]
ANSWERS = "answers.json"
BOUNDED = ("single", "gross", "faint", "pair", "three")
ONE_ANSWER = ("none", "single", "faint", "gross", "tolerance", "unknown")


def run_axis(seed: int, number: int) -> dict[str, Any]:
    """Draw the case of seed `number`, diagnose it blind; the truth, the answer and the bound."""
    begun = time.monotonic()
    case = draw(number)
    with tempfile.TemporaryDirectory(prefix="prove-") as folder:
        write_blind(case, Path(folder))
        simulated = time.monotonic()
        answer, failure = diagnose_blind(Path(folder))
        diagnosed = time.monotonic()
    return {
        "seed": number,
        "truth": case.truth(),
        "diagnosis": answer,
        "failure": failure,
        "bound": case.bound() if case.tier in BOUNDED else None,
        "simulated_s": simulated - begun,
        "diagnosed_s": diagnosed - simulated,
    }


def run_practice(folder: str, seed: int, number: int) -> dict[str, Any]:
    """Diagnose case `number` of a folder that has answers of another generator beside it."""
    truth = practice_answers(Path(folder))[number]
    begun = time.monotonic()
    answer, failure = diagnose_blind(Path(folder) / str(truth["case"]))
    return {
        "seed": number,
        "truth": truth,
        "diagnosis": answer,
        "failure": failure,
        "bound": None,
        "simulated_s": 0.0,
        "diagnosed_s": time.monotonic() - begun,
    }


def practice_answers(folder: Path) -> list[dict[str, Any]]:
    """What is hidden in each case of a practice folder. Raises OSError where there is no file."""
    found: list[dict[str, Any]] = json.loads((folder / ANSWERS).read_text(encoding="utf-8"))
    return found


@dataclass(frozen=True)
class AxisProof:
    """What came out: scores, the columns of the table, and where it was written."""

    title: str
    scores: list[AxisScore]
    practice: list[AxisScore]
    columns: dict[str, list[Row]]
    table_file: Path
    matrix_file: Path


def seeds_of(first: int, cases: int, half: Half) -> list[int]:
    """The seeds from `first` on, one a case; of a half every other one."""
    if half == "all":
        return list(range(first, first + cases))
    begin = first if first % 2 == (half == "odd") else first + 1
    return list(range(begin, begin + 2 * cases, 2))


def prove_axes(
    cases: int, first: int, half: Half, out: Path, practice: Path | None, means: Means
) -> AxisProof:
    """Run the cases of a range of seeds that are not in `out` yet, and score all.

    Raises ConfigError for a folder of another range and MissingFile for a practice folder without
    answers.
    """
    if cases < 0 or (cases == 0 and practice is None):
        raise ConfigError(f"--cases {cases}: at least one case is needed, or --practice FOLDER")
    parts = [Part("axis", seeds_of(first, cases, half), run_axis, _line)]
    if practice is not None:
        parts.append(_practice_part(practice))
    claim(out, {"machine": "axis", "seed": first, "half": half})
    run_missing(parts, first, out, means)
    scores = [score_axis(result) for result in parts[0].results(out)]
    known = [score_axis(result) for part in parts[1:] for result in part.results(out)]
    return _conclude(parts[0].numbers, scores, known, half, out)


def _practice_part(folder: Path) -> Part:
    folder = folder.resolve()
    try:
        count = len(practice_answers(folder))
    except OSError as error:
        raise MissingFile(f"--practice {folder}: has no {ANSWERS} to score by") from error
    return Part("practice", range(count), partial(run_practice, str(folder)), _line)


def _conclude(
    seeds: Sequence[int], scores: list[AxisScore], known: list[AxisScore], half: Half, out: Path
) -> AxisProof:
    """Write the table, what went wrong, and the pictures."""
    title = _title(seeds, scores, half) if seeds else f"{len(known)} practice axes"
    columns = {
        f"{name} seeds": axis_rows(own)
        for name, own in (
            ("even", [marks for marks in scores if marks.seed % 2 == 0]),
            ("odd", [marks for marks in scores if marks.seed % 2 == 1]),
        )
        if own
    }
    if known:
        columns["practice axes"] = axis_rows(known)
    every = [*scores, *known]
    wrong = f"## Wrong or contradictory\n\n{wrong_answers(every)}"
    put_text(out / "table.md", f"{title}\n\n{axis_markdown(columns)}\n{wrong}")
    put_text(out / "matrix.svg", picture(confusion(every), title))
    claims = [claim_ for marks in every for claim_ in marks.claims]
    put_text(out / "reliability.svg", diagram(claims, f"Stated and true, {title}"))
    return AxisProof(title, scores, known, columns, out / "table.md", out / "matrix.svg")


def _title(seeds: Sequence[int], scores: Sequence[AxisScore], half: Half) -> str:
    """Which seeds were used, and whether all of them were run."""
    words = {"all": "", "even": "even ", "odd": "odd "}[half]
    whole = "" if len(scores) == len(seeds) else f"the first {len(scores)} of "
    return f"{whole}{len(seeds)} single axes, {words}seeds {seeds[0]} to {seeds[-1]}"


def confusion(scores: Sequence[AxisScore]) -> Matrix:
    """(hidden, named first) -> cases, of the tiers with one answer at most."""
    cells: Matrix = {}
    for marks in scores:
        if marks.tier not in ONE_ANSWER:
            continue
        row = marks.truth[0] if marks.truth else "nothing"
        said = marks.said[0] if marks.said else "nothing"
        if marks.first and said != "unknown":
            # What is the same operator in this motion is on the diagonal.
            said = row
        cell = (row, "failed" if marks.failure is not None else said)
        cells[cell] = cells.get(cell, 0) + 1
    return cells


def _line(result: dict[str, Any]) -> str:
    marks = score_axis(result)
    truth = ", ".join(marks.truth) or "nothing"
    said = ", ".join(marks.said) or "nothing"
    seconds = result["simulated_s"] + result["diagnosed_s"]
    verdict = "right" if right(marks) else "WRONG"
    return (
        f"{marks.case} {marks.tier}: {truth} -> {marks.failure or said} {verdict} ({seconds:.0f} s)"
    )
