"""The cases of frozen_answers.py: recordings with what is known of them, and one diagnosis each.

Simulated cases are those of the proof (`proof/cases.py`), practice and real recordings those of the
project's shared material. A case is known by its name: SEED_NNNN, practice__CASE or
real__MACHINE__RECORDING.
"""

from __future__ import annotations

import json
import os
import resource
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from deltactl.diagnosis.api import diagnose
from deltactl.diagnosis.estimation.side_by_side import alone
from deltactl.proof.cases import ROUND, draw
from deltactl.proof.write_case import HOLDOUT, RECORDING, ROBOT_FILE, write_blind

TENTH, TURN = 10, 7
"""A tenth takes another residue in every round of groups, so that it holds all groups."""
Answer = dict[str, Any]


@dataclass(frozen=True)
class Frozen:
    """One case: files, group, and the truth as JSON."""

    name: str
    group: str
    truth: Any
    folder: Path
    recording: Path
    robot: Path
    holdout: Path | None
    seed: int | None = None
    number: int = 0


def simulated(keep: Path, seeds: Sequence[int], count: int, tenth: bool) -> Iterator[Frozen]:
    """Proof cases, seeds in turn, so that a run that is cut off has its share of each."""
    for number in range(count):
        if tenth and (number - TURN * (number // len(ROUND))) % TENTH:
            continue
        for seed in seeds:
            name = f"{seed}_{number:04d}"
            folder = keep / "cases" / name
            yield Frozen(
                name, ROUND[number % len(ROUND)], None, folder, folder / RECORDING,
                folder / ROBOT_FILE, folder / HOLDOUT, seed, number,
            )  # fmt: skip


def practice(recordings: Path, tenth: bool) -> Iterator[Frozen]:
    """The practice recordings with their answers."""
    folder = recordings / "practice"
    if not (folder / "answers.json").exists():
        return
    for truth in json.loads((folder / "answers.json").read_text())[:: TENTH if tenth else 1]:
        case = folder / truth["case"]
        yield Frozen(
            f"practice__{truth['case']}", "practice", {"group": "practice", **truth}, case,
            case / RECORDING, folder / ROBOT_FILE, case / HOLDOUT,
        )  # fmt: skip


def real(recordings: Path, tenth: bool) -> Iterator[Frozen]:
    """Recordings of real machines with what is known of them, a group each."""
    files = sorted(recordings.glob("*/expected.json"))
    rows = [
        (file.parent, name, known)
        for file in files
        for name, known in json.loads(file.read_text()).items()
        if not name.startswith("_") and (file.parent / name).exists()
    ]
    for folder, name, known in rows[:: TENTH if tenth else 1]:
        held = known.get("holdout")
        there = isinstance(held, str) and (folder / held).exists()
        yield Frozen(
            f"real__{folder.name}__{name}", f"real {folder.name}", known, folder, folder / name,
            folder / ROBOT_FILE, folder / held if there else None,
        )  # fmt: skip


def truth_of(case: Frozen, keep: Path) -> Any:
    """What is known of a case; None for a simulated one that was not made yet."""
    if case.seed is None:
        return case.truth
    file = keep / "cases" / f"{case.name}.truth.json"
    return json.loads(file.read_text()) if file.exists() else None


def answer_of(job: tuple[Frozen, Path, str]) -> tuple[str, float]:
    """Diagnose one case, alone in its process, and keep the answer. Name and seconds."""
    case, keep, label = job
    _make(case, keep)
    begun, answer, failure = time.perf_counter(), None, None
    try:
        with alone():
            held_out = [case.holdout] if case.holdout is not None else []
            answer = diagnose([case.recording], case.robot, held_out).to_json()
    except Exception as error:  # whatever it is, it is what came out
        failure = f"{type(error).__name__}: {error}"
    seconds = time.perf_counter() - begun
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    kept = {"answer": answer, "failure": failure, "seconds": seconds, "peak_mb": peak_mb}
    write(answer_file(keep, label, case.name), kept)
    return case.name, seconds


def _make(case: Frozen, keep: Path) -> None:
    """Simulate a case that is not there yet; its truth is written last."""
    truth = keep / "cases" / f"{case.name}.truth.json"
    if case.seed is None or truth.exists():
        return
    drawn = draw(case.seed, case.number)
    write_blind(drawn, case.folder, case.seed)
    write(truth, drawn.truth())


def answer_file(keep: Path, label: str, name: str) -> Path:
    """Where the answer of a case is kept."""
    return keep / "answers" / label / f"{name}.json"


def write(path: Path, values: Any) -> None:
    """All or nothing, so that a run that was cut off can go on."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_text(json.dumps(values))
    os.replace(part, path)
