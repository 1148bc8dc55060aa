"""Keeps the answers of many recordings, and compares those of two states of the engine.

    python -m benchmarks.proofs.frozen_answers make LABEL --keep DIR [--tenth] [--processes N]
    python -m benchmarks.proofs.frozen_answers compare OLD NEW --keep DIR [--tenth] [--show]

`make` diagnoses proof cases of old seeds, the practice set and all real recordings with the code it
is run from, one process a case, and keeps what comes out in DIR/answers/LABEL; what is there is not
done again. `compare` says, group by group, how many answers are right under both labels, whether
the difference is more than chance (McNemar's exact test of the pairs), how many answers stayed
identical to the byte, and what they took. --tenth takes a tenth of all cases, of every group some.

Simulated cases are those of the proof (`proof/cases.py`), practice and real recordings those of the
project's shared material. A case is known by its name: SEED_NNNN, practice__CASE or
real__MACHINE__RECORDING.

Exit status of `compare`: 1 when a group is worse than chance allows (p < 0.05), else 0.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import resource
import sys
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

from scipy.stats import binomtest

from benchmarks.proofs.contradictions import contradictions
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose
from deltactl.proof.cases import HOLDOUT, RECORDING, ROBOT_FILE, ROUND, draw, write_blind
from deltactl.proof.prove.score import score

TENTH, TURN = 10, 7
"""A tenth takes another residue in every round of groups, so that it holds all groups."""


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
            files = (folder, folder / RECORDING, folder / ROBOT_FILE, folder / HOLDOUT)
            yield Frozen(name, ROUND[number % len(ROUND)], None, *files, seed, number)


def practice(recordings: Path, tenth: bool) -> Iterator[Frozen]:
    """The practice recordings with their answers."""
    folder = recordings / "practice"
    if not (folder / "answers.json").exists():
        return
    for truth in json.loads((folder / "answers.json").read_text())[:: TENTH if tenth else 1]:
        case = folder / truth["case"]
        files = (case, case / RECORDING, folder / ROBOT_FILE, case / HOLDOUT)
        known = {"group": "practice", **truth}
        yield Frozen(f"practice__{truth['case']}", "practice", known, *files)


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
        case, holdout = f"real__{folder.name}__{name}", folder / str(held) if there else None
        paths = (folder, folder / name, folder / ROBOT_FILE, holdout)
        yield Frozen(case, f"real {folder.name}", known, *paths)


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


SEEDS = (14142135, 31415926)
COUNT = 300
WORSE = 0.05
DEFAULT = Path(__file__).resolve().parents[2] / "../shared/recordings"
ALWAYS_NEW = ("recordings", "robot")
WORDS = ("says", "regime")
"""Written by the report, from the fields that are compared."""


class Pair(NamedTuple):
    """A case under both labels."""

    case: Frozen
    truth: Any
    old: dict[str, Any]
    new: dict[str, Any]


class Row(NamedTuple):
    """What came of a group."""

    cases: int
    old_right: int
    new_right: int
    lost: int
    won: int
    same: int
    p: float
    """Probability of as many changes one way by chance."""


def is_right(truth: Any, kept: dict[str, Any]) -> bool:
    """Silent where nothing is, `unknown` where physics of no list acts, else exactly what acts.

    Of a real machine: all that was published is a finding or an alternative of one, and the answer
    does not contradict itself.
    """
    answer = kept["answer"]
    if "group" not in truth:
        return answer is not None and _as_published(truth, answer)
    if truth["group"] == "practice":
        return answer is not None and _as_planted(truth["answers"], answer)
    marks = score({"truth": truth, "diagnosis": answer, "failure": kept["failure"]})
    if truth["group"] == "nothing":
        return not marks.alarmed
    return marks.flagged if truth["group"] == "unknown" else marks.exact


def _as_planted(planted: Sequence[dict[str, Any]], answer: dict[str, Any]) -> bool:
    found = {(finding["effect"], finding["component"]) for finding in answer["findings"]}
    if any(cause["effect"] == "unknown" for cause in planted):
        return any(effect == "unknown" for effect, _ in found)
    return found == {(cause["effect"], cause["where"]) for cause in planted}


def _as_published(known: dict[str, Any], answer: dict[str, Any]) -> bool:
    said = {finding["effect"] for finding in answer["findings"]}
    said |= {other["effect"] for finding in answer["findings"] for other in finding["alternatives"]}
    honest = not contradictions(Diagnosis.model_validate(answer))
    return honest and {cause["effect"] for cause in known.get("expected", [])} <= said


def paired(pairs: Sequence[Pair]) -> Row:
    """McNemar's exact test: of the cases right under one label only, are both halves alike?"""
    rights = [(is_right(p.truth, p.old), is_right(p.truth, p.new)) for p in pairs]
    lost, won = rights.count((True, False)), rights.count((False, True))
    return Row(
        cases=len(pairs),
        old_right=sum(old for old, _ in rights),
        new_right=sum(new for _, new in rights),
        lost=lost,
        won=won,
        same=sum(not changed(p.old["answer"], p.new["answer"]) for p in pairs),
        p=float(binomtest(lost, lost + won).pvalue) if lost + won else 1.0,
    )


def changed(old: Any, new: Any, place: str = "") -> list[str]:
    """Where two answers differ, as paths; lists of other lengths as a whole."""
    if isinstance(old, dict) and isinstance(new, dict):
        return _changed_keys(old, new, place)
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        pairs = enumerate(zip(old, new, strict=True))
        return [line for i, (a, b) in pairs for line in changed(a, b, f"{place}[{i}]")]
    return [] if old == new else [place]


def _changed_keys(old: dict[str, Any], new: dict[str, Any], place: str) -> list[str]:
    names = [n for n in {**old, **new} if place or n not in ALWAYS_NEW]
    there = [f"{place}.{n}" for n in names if (n in old) != (n in new) and _says(old, new, n)]
    both = [n for n in names if n in old and n in new and n not in WORDS]
    return there + [line for n in both for line in changed(old[n], new[n], f"{place}.{n}")]


def _says(old: dict[str, Any], new: dict[str, Any], name: str) -> bool:
    """Whether a key that only one has says anything: a new key that is not used yet does not."""
    return old.get(name, new.get(name)) not in (None, "", [], {})


def cases_of(options: argparse.Namespace) -> Iterator[Frozen]:
    """All cases, or a tenth."""
    recordings = Path(options.recordings or os.environ.get("DELTACTL_RECORDINGS") or DEFAULT)
    if not recordings.exists():
        print(f"{recordings}: not there; only simulated cases", file=sys.stderr)
    yield from practice(recordings, options.tenth)
    yield from real(recordings, options.tenth)
    yield from simulated(options.keep, options.seeds, options.count, options.tenth)


def make(options: argparse.Namespace) -> int:
    """Diagnose what is not there yet."""
    keep, label = options.keep, options.labels[0]
    jobs = [
        (case, keep, label)
        for case in cases_of(options)
        if not answer_file(keep, label, case.name).exists()
    ]
    spawn = multiprocessing.get_context("spawn")
    with spawn.Pool(options.processes, maxtasksperchild=1) as pool:
        made = pool.imap_unordered(answer_of, jobs)
        for number, (name, seconds) in enumerate(made, start=1):
            print(f"{number} of {len(jobs)}: {name} {seconds:.1f} s", flush=True)
    return 0


def compare(options: argparse.Namespace) -> int:
    """Print the table; 1 when a group is worse."""
    groups: dict[str, list[Pair]] = defaultdict(list)
    for case in cases_of(options):
        files = [answer_file(options.keep, label, case.name) for label in options.labels]
        truth = truth_of(case, options.keep)
        if truth is not None and all(file.exists() for file in files):
            old, new = (json.loads(file.read_text()) for file in files)
            groups[case.group].append(Pair(case, truth, old, new))
    rows = {group: paired(pairs) for group, pairs in groups.items()}
    old_label, new_label = options.labels
    print(f"{'group':28s} {'cases':>5s} {'right':>11s} {'lost':>4s} {'won':>4s} {'p':>6s} same")
    for group, row in rows.items():
        right = f"{row.old_right} -> {row.new_right}"
        print(
            f"{group:28s} {row.cases:5d} {right:>11s} {row.lost:4d} {row.won:4d} {row.p:6.2g} "
            f"{row.same}"
        )
    every = [pair for pairs in groups.values() for pair in pairs]
    _show_changes(every, options.show)
    _show_costs(every, old_label, new_label)
    return int(any(row.lost > row.won and row.p < WORSE for row in rows.values()))


def _show_changes(pairs: Sequence[Pair], every_line: bool) -> None:
    for pair in pairs:
        places = changed(pair.old["answer"], pair.new["answer"])
        if not places and pair.old["failure"] == pair.new["failure"]:
            continue
        before, after = _gist(pair.old), _gist(pair.new)
        if before == after and not every_line:
            continue
        rights = [is_right(pair.truth, kept) for kept in (pair.old, pair.new)]
        words = {(True, False): "LOST", (False, True): "won"}.get((rights[0], rights[1]), "")
        print(
            f"{pair.case.name} {words}\n    {before}"
            + (f"\n    {after}" if after != before else "")
        )
        if every_line:
            print(f"    changed: {', '.join(places)}")


def _gist(kept: dict[str, Any]) -> str:
    """Verdict and findings in a line."""
    if kept["answer"] is None:
        return f"refused: {kept['failure']}"
    found = ", ".join(f"{f['effect']} {f['component']}" for f in kept["answer"]["findings"])
    return f"{kept['answer']['verdict']}: {found or 'no finding'}"


def _show_costs(pairs: Sequence[Pair], old: str, new: str) -> None:
    for key, unit in (("seconds", "s"), ("peak_mb", "MB")):
        for label, took in ((old, [p.old[key] for p in pairs]), (new, [p.new[key] for p in pairs])):
            if took:
                print(f"{label}: median {median(took):.3g} {unit}, most {max(took):.3g} {unit}")


def main() -> int:
    """Exit status 1 when a group is worse."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("make", "compare"))
    parser.add_argument("labels", nargs="+", metavar="LABEL")
    parser.add_argument("--keep", type=Path, required=True, metavar="DIR")
    parser.add_argument("--recordings", metavar="DIR")
    parser.add_argument("--seeds", type=int, nargs="+", default=SEEDS)
    parser.add_argument("--count", type=int, default=COUNT, help="proof cases of each seed")
    parser.add_argument("--tenth", action="store_true")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--show", action="store_true", help="every field that changed")
    options = parser.parse_args()
    wanted = {"make": 1, "compare": 2}[options.what]
    if len(options.labels) != wanted:
        parser.error(f"{options.what} takes {wanted} label{'s' * (wanted > 1)}")
    return make(options) if options.what == "make" else compare(options)


if __name__ == "__main__":
    sys.exit(main())
