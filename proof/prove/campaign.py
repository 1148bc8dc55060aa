"""A whole proof: run what is not there yet, then score everything that is."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from foundation.errors import ConfigError
from proof.prove.matrix import confusion, picture
from proof.prove.score import Score, score
from proof.prove.table import Row, markdown, table
from proof.prove.workers import workers

PLAN, RESULT = "prove.json", "result.json"
Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Proof:
    """What came out: scores by case, the table, and where it was written."""

    scores: list[Score]
    rows: list[Row]
    table_file: Path
    matrix_file: Path


def prove(
    cases: int,
    seed: int,
    out: Path,
    count: int = 2,
    scheduler: str | None = None,
    progress: Progress = lambda done, all_, text: None,
    say: Callable[[str], None] = lambda text: None,
) -> Proof:
    """Run the cases 0..cases-1 of a seed that are not in `out` yet, and score them all.

    Raises ConfigError for a folder of another seed, or when the scheduler does not answer.
    """
    if cases < 1:
        raise ConfigError(f"--cases {cases}: at least one case is needed")
    _claim(out, seed)
    missing = [number for number in range(cases) if not _file(out, number).exists()]
    done = cases - len(missing)
    progress(done, cases, f"{done} were there already" if done else "")
    if missing:
        with workers(count, scheduler, say) as run:
            for number, result in run(seed, missing):
                _write(_file(out, number), json.dumps(result, indent=1))
                done += 1
                progress(done, cases, _line(result))
    return conclude(cases, seed, out)


def conclude(cases: int, seed: int, out: Path) -> Proof:
    """Score what is in the folder, and write the table and the picture."""
    results = [
        json.loads(_file(out, number).read_text(encoding="utf-8")) for number in range(cases)
    ]
    scores = [score(result) for result in results]
    rows = table(scores)
    title = f"{cases} cases of seed {seed}"
    _write(out / "table.md", f"{title}\n\n{markdown(rows)}")
    _write(out / "matrix.svg", picture(confusion(scores), title))
    return Proof(scores, rows, out / "table.md", out / "matrix.svg")


def _claim(out: Path, seed: int) -> None:
    out.mkdir(parents=True, exist_ok=True)
    plan = out / PLAN
    if not plan.exists():
        _write(plan, json.dumps({"seed": seed}))
        return
    before = json.loads(plan.read_text(encoding="utf-8"))["seed"]
    if before != seed:
        raise ConfigError(f"{out}: holds a proof with seed {before}; use that seed or a new folder")


def _file(out: Path, number: int) -> Path:
    return out / f"case_{number:04d}" / RESULT


def _write(path: Path, text: str) -> None:
    """All or nothing, so that a proof that was cut off can go on."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_text(text + ("" if text.endswith("\n") else "\n"), encoding="utf-8")
    os.replace(part, path)


def _line(result: dict[str, Any]) -> str:
    marks = score(result)
    truth = ", ".join(f"{effect} {where}" for effect, where in marks.truth) or "nothing"
    said = ", ".join(f"{effect} {where}" for effect, where in marks.said) or "nothing"
    seconds = result["simulated_s"] + result["diagnosed_s"]
    return f"{marks.case} {marks.motion}: {truth} -> {marks.failure or said} ({seconds:.0f} s)"
