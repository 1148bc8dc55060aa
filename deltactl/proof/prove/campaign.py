"""A whole proof: run what is not there yet, then score everything that is."""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.plain_file import write_whole
from deltactl.proof.cases import MORE
from deltactl.proof.prove.matrix import confusion, picture
from deltactl.proof.prove.one_case import run_case, run_more
from deltactl.proof.prove.one_tie import run_tie
from deltactl.proof.prove.reliability import diagram
from deltactl.proof.prove.score import Score, score
from deltactl.proof.prove.score_tie import score_tie, tie_rows
from deltactl.proof.prove.table import Row, markdown, more_rows, table
from deltactl.proof.prove.workers import Task, workers

PLAN, RESULT = "prove.json", "result.json"
Progress = Callable[[int, int, str], None]
Say = Callable[[str], None]


@dataclass(frozen=True)
class Proof:
    """What came out: scores by case, the table, and where it was written."""

    title: str
    scores: list[Score]
    rows: list[Row]
    table_file: Path
    matrix_file: Path


@dataclass(frozen=True)
class _Part:
    """Cases or ties: where they are kept and what runs them."""

    stem: str
    count: int
    task: Task
    line: Callable[[dict[str, Any]], str]

    def file(self, out: Path, number: int) -> Path:
        return out / f"{self.stem}_{number:04d}" / RESULT

    def results(self, out: Path) -> list[dict[str, Any]]:
        """What is there, up to the first that is missing: a cut-off must not prefer quick ones."""
        files = [self.file(out, number) for number in range(self.count)]
        there = itertools.takewhile(Path.exists, files)
        return [json.loads(file.read_text(encoding="utf-8")) for file in there]


def prove(
    cases: int,
    seed: int,
    out: Path,
    ties: int = 0,
    count: int = 2,
    scheduler: str | None = None,
    minutes: float = float("inf"),
    progress: Progress = lambda done, all_, text: None,
    say: Say = lambda text: None,
    more: int = 0,
) -> Proof:
    """Run the cases and ties of a seed that are not in `out` yet, and score them all.

    more: cases of the second set, with four and five causes and more kinds of unknowns.
    minutes: no further case is begun after that time; the table is then of those before the
    first that is missing.
    Raises ConfigError for a folder of another seed, or when the scheduler does not answer.
    """
    if cases < 1 or ties < 0 or more < 0:
        asked = f"--cases {cases} --ties {ties} --more {more}"
        raise ConfigError(f"{asked}: at least one case is needed, and no number below zero")
    until = time.monotonic() + 60.0 * minutes
    _claim(out, seed)
    parts = (
        _Part("case", cases, run_case, _line),
        _Part("tie", ties, run_tie, _tie_line),
        _Part(MORE, more, run_more, _line),
    )
    total = cases + ties + more
    missing = [job for job in _in_turn(parts) if not job[0].file(out, job[1]).exists()]
    done = total - len(missing)
    progress(done, total, f"{done} were there already" if done else "")
    if missing:
        with workers(count, scheduler, say) as run:
            for place, result in run([(part.task, seed, n) for part, n in missing]):
                part, number = missing[place]
                _write(part.file(out, number), json.dumps(result, indent=1))
                done += 1
                progress(done, total, part.line(result))
                if time.monotonic() > until:
                    say(f"stopped after {minutes:g} minutes; the same command again goes on")
                    break
    return _conclude(parts, seed, out)


def _in_turn(parts: Sequence[_Part]) -> list[tuple[_Part, int]]:
    """All evenly mixed, so that a proof that is cut off has its share of each."""
    jobs = [(part, number) for part in parts for number in range(part.count)]
    return sorted(jobs, key=lambda job: (job[1] + 0.5) / job[0].count)


def _conclude(parts: tuple[_Part, _Part, _Part], seed: int, out: Path) -> Proof:
    """Score what is in the folder, and write the table and the picture."""
    cases, ties, more = parts
    first = [score(result) for result in cases.results(out)]
    second = [score(result) for result in more.results(out)]
    scores = [*first, *second]
    tied = [score_tie(result) for result in ties.results(out)]
    rows = [*table(scores), *more_rows(second), *(tie_rows(tied) if tied else [])]
    title = f"{_of(len(first), cases.count)} cases"
    title += f", {_of(len(second), more.count)} more" if more.count else ""
    title += f" and {_of(len(tied), ties.count)} ties of seed {seed}"
    _write(out / "table.md", f"{title}\n\n{markdown(rows)}")
    _write(out / "matrix.svg", picture(confusion(scores), title))
    claims = [claim for marks in scores for claim in marks.claims]
    _write(out / "reliability.svg", diagram(claims, f"Stated and true, {title}"))
    return Proof(title, scores, rows, out / "table.md", out / "matrix.svg")


def _of(there: int, wanted: int) -> str:
    return str(wanted) if there == wanted else f"the first {there} of {wanted}"


def _claim(out: Path, seed: int) -> None:
    out.mkdir(parents=True, exist_ok=True)
    plan = out / PLAN
    if not plan.exists():
        _write(plan, json.dumps({"seed": seed}))
        return
    before = json.loads(plan.read_text(encoding="utf-8"))["seed"]
    if before != seed:
        raise ConfigError(f"{out}: holds a proof with seed {before}; use that seed or a new folder")


def _write(path: Path, text: str) -> None:
    """All or nothing, so that a proof that was cut off can go on."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, text + ("" if text.endswith("\n") else "\n"))


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
