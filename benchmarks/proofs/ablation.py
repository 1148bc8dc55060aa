"""Which of the numbers that decide an answer matter: each of them halved and doubled.

    python -m benchmarks.proofs.ablation --cases 12 --seed 84000 --out ablation
    python -m benchmarks.proofs.ablation --practice FOLDER --out practice

Draws single axes and range sensors (even seeds, for tuning), diagnoses them with every number of
every table of options halved and doubled, and compares names and verdict with those of the engine
as it is. A tuple is scaled as a whole, a whole number by at least one. Each variation is a process
of its own that changes the number before the engine is imported, so that what is computed from it
changes, too. `--out` keeps the answers; the same command resumes. Numbers of effects, of deltas and
of chains are not varied.
"""

from __future__ import annotations

import argparse
import importlib
import json
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, fields, is_dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

ROOMS = "observations plants plants.lone evidence priors selection assessment pipelines answer"
"""Rooms of the engine whose numbers an axis or a range sensor meets."""
FACTORS = (0.5, 2.0)
Answer = dict[str, Any]


@dataclass(frozen=True)
class Number:
    """A number of a table, or a tuple of them."""

    room: str
    table: str
    name: str

    @property
    def shown(self) -> str:
        """As the engine's source spells it."""
        return f"{self.table}.{self.name}"


def numbers() -> Iterator[Number]:
    """All numbers of the tables."""
    for room in ROOMS.split():
        for table, held in vars(_options(room)).items():
            if is_dataclass(held) and not isinstance(held, type):
                for field in fields(held):
                    if scaled(getattr(held, field.name), 2.0) is not None:
                        yield Number(room, table, field.name)


def _options(room: str) -> Any:
    return importlib.import_module(f"deltactl.diagnosis.{room}.options")


def scaled(value: object, factor: float) -> object:
    """The value times a factor; None of what is no number."""
    if isinstance(value, tuple):
        parts = [scaled(part, factor) for part in value]
        return None if not parts or None in parts else tuple(parts)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    if isinstance(value, int):
        return max(int(value * factor), 1) if factor < 1.0 else max(int(value * factor), value + 1)
    return value * factor


def diagnosed(cases: Path, changed: Number | None, factor: float) -> dict[str, Answer]:
    """Answers to all cases by an engine with one number changed, in a fresh process."""
    if changed is not None:
        table = getattr(_options(changed.room), changed.table)
        object.__setattr__(table, changed.name, scaled(getattr(table, changed.name), factor))
    from deltactl.proof.prove.axis_score import right, score_axis
    from deltactl.proof.prove.one_case import diagnose_blind

    found = {}
    for case in sorted(cases.iterdir()):
        truth = json.loads((case / "truth.json").read_text(encoding="utf-8"))
        with tempfile.TemporaryDirectory() as blind:
            shutil.copytree(
                case, blind, dirs_exist_ok=True, ignore=shutil.ignore_patterns("truth.json")
            )
            answer, failure = diagnose_blind(Path(blind))
        result = {"seed": 0, "truth": truth, "diagnosis": answer, "failure": failure}
        marks = score_axis({**result, "bound": None, "diagnosed_s": 0.0})
        verdict = answer["verdict"] if answer else "failed"
        found[case.name] = {"names": sorted(marks.said), "verdict": verdict, "right": right(marks)}
    return found


def draw(folder: Path, count: int, seed: int) -> None:
    """So many cases, from an even seed on, with what they hide."""
    from deltactl.proof.axis.cases import draw as drawn
    from deltactl.proof.axis.cases import write_blind

    for number in range(seed, seed + 2 * count, 2):
        place = folder / f"{number:06d}"
        if not (place / "truth.json").exists():
            case = drawn(number)
            place.mkdir(parents=True, exist_ok=True)
            write_blind(case, place)
            (place / "truth.json").write_text(json.dumps(case.truth()), encoding="utf-8")


def table(answers: Mapping[str, Mapping[str, Answer]], names: Sequence[str]) -> Iterator[str]:
    """Numbers whose change changes an answer, those that change most first; how many change none.

    answers: case -> answer by number and factor; that of the engine as it is has an empty name.
    """
    plain = answers[""]
    right = sum(one["right"] for one in plain.values())
    yield f"{len(plain)} cases, {right} right with the numbers as they are"
    yield ""
    yield "| number | answers changed, halved / doubled | right, halved / doubled |"
    yield "|---|---|---|"
    rows = []
    for name in names:
        both = [answers[f"{name} {factor:g}"] for factor in FACTORS]
        moved = [sum(_other(one[case], plain[case]) for case in plain) for one in both]
        rows.append((moved, [sum(one[case]["right"] for case in plain) for one in both], name))
    for moved, scores, name in sorted(rows, key=lambda row: (-sum(row[0]), row[2])):
        if any(moved):
            yield f"| {name} | {moved[0]} / {moved[1]} | {scores[0]} / {scores[1]} |"
    still = sum(not any(moved) for moved, _, _ in rows)
    yield f"\n{still} of {len(rows)} numbers change no answer when they are halved or doubled."


def _other(one: Answer, plain: Answer) -> bool:
    return any(one[key] != plain[key] for key in ("names", "verdict"))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=12)
    parser.add_argument("--seed", type=int, default=84000, help="even: for tuning")
    parser.add_argument("--practice", type=Path, metavar="FOLDER", help="its cases instead")
    parser.add_argument("--tables", nargs="*", metavar="NAME", help="these tables alone")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, required=True)
    asked = parser.parse_args()
    cases = asked.out / "cases"
    if asked.practice:
        copy_practice(asked.practice, cases)
    else:
        draw(cases, asked.cases, asked.seed)
    chosen = [one for one in numbers() if not asked.tables or one.table in asked.tables]
    answers = _all_answers(cases, chosen, asked.out, asked.workers)
    print("\n".join(table(answers, [one.shown for one in chosen])))


def copy_practice(folder: Path, cases: Path) -> None:
    """The cases of a practice folder, each with what it hides."""
    from deltactl.proof.prove.axis_campaign import practice_answers

    for truth in practice_answers(folder):
        place = cases / truth["case"]
        shutil.copytree(folder / truth["case"], place, dirs_exist_ok=True)
        (place / "truth.json").write_text(json.dumps(truth), encoding="utf-8")


def _all_answers(
    cases: Path, chosen: Sequence[Number], out: Path, workers: int
) -> dict[str, dict[str, Answer]]:
    """By number and factor, as `table` takes them; those that the folder holds are not repeated."""
    asked: dict[str, tuple[Number | None, float]] = {"": (None, 1.0)}
    asked |= {f"{one.shown} {factor:g}": (one, factor) for one in chosen for factor in FACTORS}
    kept = out / "answers"
    kept.mkdir(exist_ok=True)
    files = {name: kept / f"{name or 'as it is'}.json" for name in asked}
    fresh = get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=fresh, max_tasks_per_child=1) as pool:
        running = {
            pool.submit(diagnosed, cases, *asked[name]): name
            for name, file in files.items()
            if not file.exists()
        }
        for done in as_completed(running):
            files[running[done]].write_text(json.dumps(done.result()), encoding="utf-8")
    return {name: json.loads(file.read_text(encoding="utf-8")) for name, file in files.items()}


if __name__ == "__main__":
    main()
