"""How answers on real recordings of lone machines stand up to changes that leave the truth alone.

    python -m benchmarks.proofs.recording_variations [--recordings DIR] [--kinds whole,halves]

Halves and thirds of each recording, fewer samples, more noise, gross outliers, missing rows, other
units, the mirrored axis, another zero of time, two recordings in one: what is known of the machine
(`expected.json`) holds for all of them, and so do the rules of the judge that stands beside the
recordings, `tools/score_recordings.py`. A part of a recording may tell less, but nothing false.
"""

from __future__ import annotations

import argparse
import importlib.util
import itertools
import json
import os
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from benchmarks.proofs.contradictions import contradictions
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.foundation.errors import DeltactlError
from deltactl.models.effects import Rule, Search, card_of, found_by
from deltactl.models.robot import DeltaRobot, RangeSensor, RobotModel, ServoAxis
from deltactl.models.robot_files import load_robot_model
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import read_flat

DEFAULT = Path(__file__).resolve().parents[2] / "../shared/recordings"
OF_THE_AXIS = ("position", "velocity", "command", "command_1", "theta_1", "steps_1", "load")
READ = ("position", "theta_1", "range")
OUTLIERS, MISSING = 0.01, 0.1


@dataclass(frozen=True)
class Case:
    """One recording as the diagnosis gets it."""

    robot: RobotModel
    recordings: list[FlatRecording]
    holdout: list[FlatRecording]


Vary = Callable[[Case], Case | None]
"""Another case of the same machine; None where it makes no sense."""


def rows(recording: FlatRecording, chosen: Any) -> FlatRecording:
    """Some rows of a recording."""
    columns = {name: values[chosen] for name, values in recording.columns.items()}
    return FlatRecording(recording.t_s[chosen], columns, {}, recording.source)


def with_columns(recording: FlatRecording, change: Callable[[str, Any], Any]) -> FlatRecording:
    """A recording whose columns are changed."""
    columns = {name: change(name, values) for name, values in recording.columns.items()}
    return FlatRecording(recording.t_s, columns, {}, recording.source)


def everywhere(case: Case, change: Callable[[FlatRecording], FlatRecording]) -> Case:
    """Recordings and held-out ones changed alike."""
    return Case(case.robot, [change(r) for r in case.recordings], [change(r) for r in case.holdout])


def part(number: int, of: int, case: Case) -> Case:
    """One part of the recording, the held-out one whole."""
    (recording,) = case.recordings
    edges = np.linspace(0, len(recording), of + 1).astype(int)
    return replace(case, recordings=[rows(recording, slice(edges[number], edges[number + 1]))])


def every(stride: int, case: Case) -> Case | None:
    """Every so many rows."""
    if len(case.recordings[0]) < 80 * stride or "segment" in case.recordings[0].columns:
        return None
    return everywhere(case, lambda r: rows(r, slice(None, None, stride)))


def without_holdout(case: Case) -> Case | None:
    """No held-out recording."""
    return replace(case, holdout=[]) if case.holdout else None


def exchanged(case: Case) -> Case | None:
    """Recording and held-out one change places."""
    if not case.holdout:
        return None
    return replace(case, recordings=[case.holdout[0]], holdout=case.recordings)


def together(case: Case) -> Case | None:
    """Recording and held-out one diagnosed as two of one machine."""
    if not case.holdout:
        return None
    return replace(case, recordings=[*case.recordings, case.holdout[0]], holdout=[])


def mirrored(case: Case) -> Case:
    """The axis counted the other way round."""
    robot = case.robot
    if isinstance(robot, ServoAxis) and robot.gravity is not None:
        turned = robot.gravity.model_copy(update={"zero_rad": -robot.gravity.zero_rad})
        robot = robot.model_copy(update={"gravity": turned})
    names = (*OF_THE_AXIS, "effort")
    change = everywhere(case, lambda r: with_columns(r, lambda name, v: -v if name in names else v))
    return replace(change, robot=robot)


def effort_in_thousandths(case: Case) -> Case | None:
    """Effort in a thousandth of its unit, and a robot file that says so."""
    robot = case.robot
    if not isinstance(robot, ServoAxis) or not case.recordings[0].has("effort"):
        return None
    changed = everywhere(
        case, lambda r: with_columns(r, lambda name, v: 1e3 * v if name == "effort" else v)
    )
    gain = robot.force_per_effort / 1e3
    return replace(changed, robot=robot.model_copy(update={"effort_gain": gain}))


def inertia_times(factor: float, case: Case) -> Case | None:
    """A robot file whose inertia is a guess."""
    robot = case.robot
    if not isinstance(robot, ServoAxis) or robot.inertia is None:
        return None
    return replace(case, robot=robot.model_copy(update={"inertia": robot.inertia * factor}))


def with_outliers(case: Case) -> Case:
    """Single readings far off, one in a hundred."""
    rng = np.random.default_rng(1)

    def change(name: str, values: Any) -> Any:
        if name not in READ:
            return values
        hit = rng.random(len(values)) < OUTLIERS
        return np.where(hit, values + rng.choice([-3, 3, 50]) * np.ptp(values), values)

    return replace(case, recordings=[with_columns(r, change) for r in case.recordings])


def with_noise(noise: float, case: Case) -> Case:
    """Readings with independent noise as large as what is left of them."""
    rng = np.random.default_rng(2)

    def change(name: str, values: Any) -> Any:
        return values + noise * rng.standard_normal(len(values)) if name in READ else values

    return replace(case, recordings=[with_columns(r, change) for r in case.recordings])


def with_rows_missing(case: Case) -> Case | None:
    """One row in ten lost, here and there."""
    if len(case.recordings[0]) < 200:
        return None
    rng = np.random.default_rng(3)
    return everywhere(case, lambda r: rows(r, np.flatnonzero(rng.random(len(r)) > MISSING)))


def with_gaps(case: Case) -> Case | None:
    """Three stretches of the recording lost."""
    if len(case.recordings[0]) < 400:
        return None

    def change(recording: FlatRecording) -> FlatRecording:
        place = np.arange(len(recording)) / len(recording)
        kept = ~(((place > 0.2) & (place < 0.26)) | ((place > 0.45) & (place < 0.5)))
        return rows(recording, np.flatnonzero(kept & ~((place > 0.7) & (place < 0.77))))

    return replace(case, recordings=[change(r) for r in case.recordings])


def of_the_day(case: Case) -> Case:
    """Times as seconds since 1970."""
    return everywhere(case, lambda r: FlatRecording(r.t_s + 1.7e9, r.columns, r.extra, r.source))


def with_zero_moved(case: Case) -> Case | None:
    """Command and reading counted from elsewhere."""
    robot, recording = case.robot, case.recordings[0]
    if isinstance(robot, RangeSensor) or (isinstance(robot, ServoAxis) and robot.gravity):
        return None
    span = max(float(np.ptp(recording.columns[n])) for n in READ if n in recording.columns)
    names = ("position", "theta_1", "command", "command_1")
    if "steps_1" in recording.columns:
        return None
    return everywhere(
        case, lambda r: with_columns(r, lambda n, v: v + 3.0 * span if n in names else v)
    )


KINDS: dict[str, list[Vary]] = {
    "whole": [lambda case: case],
    "halves": [partial(part, n, 2) for n in range(2)],
    "thirds": [partial(part, n, 3) for n in range(3)],
    "every 2nd": [partial(every, 2)],
    "every 3rd": [partial(every, 3)],
    "every 5th": [partial(every, 5)],
    "no holdout": [without_holdout],
    "exchanged": [exchanged],
    "together": [together],
    "mirrored": [mirrored],
    "zero moved": [with_zero_moved],
    "units": [effort_in_thousandths],
    "inertia x 3": [partial(inertia_times, 3.0)],
    "inertia / 3": [partial(inertia_times, 1.0 / 3.0)],
    "outliers": [with_outliers],
    "noise": [],
    "rows missing": [with_rows_missing],
    "gaps": [with_gaps],
    "clock time": [of_the_day],
}


def judge_of(folder: Path) -> ModuleType:
    """The judge that stands beside the recordings."""
    path = folder.parent / "tools" / "score_recordings.py"
    spec = importlib.util.spec_from_file_location("score_recordings", path)
    if spec is None or spec.loader is None or not path.exists():
        raise SystemExit(f"{path}: the judge is not there; --recordings names the shared folder")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def truths(folder: Path) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Set, recording and what is known of it, of every lone machine."""
    for known in sorted(folder.glob("*/expected.json")):
        if isinstance(load_robot_model(known.parent / "robot.yaml"), DeltaRobot):
            continue
        for name, truth in json.loads(known.read_text(encoding="utf-8")).items():
            if not name.startswith("_") and (known.parent / name).exists():
                yield known.parent.name, name, truth


def cases_of(folder: Path, job: tuple[str, str, str, dict[str, Any]]) -> Iterator[Case]:
    """All cases of one kind of one recording."""
    kind, machine, name, truth = job
    here = folder / machine
    held = truth.get("holdout")
    holdout = [read_flat(here / held)] if isinstance(held, str) and (here / held).exists() else []
    case = Case(load_robot_model(here / "robot.yaml"), [read_flat(here / name)], holdout)
    after = truth.get("rms_with_effect")
    noisy: list[Vary] = [partial(with_noise, float(after))] if kind == "noise" and after else []
    if case.recordings[0].has("effort"):
        noisy = []
    for vary in (*KINDS[kind], *noisy):
        varied = vary(case)
        if varied is not None:
            yield varied


Interval = tuple[float, float, float]
"""Value, low, high."""
Sizes = dict[tuple[str, str], Interval]
"""By effect and parameter."""


def sizes_of(answer: Diagnosis) -> Sizes:
    """What two parts of one motion must agree on."""
    return {
        (f.effect, name): (value, low, high)
        for f in answer.findings
        if f.effect not in ("unknown", found_by(Search.MOMENT).name)
        for name, size in f.parameters.items()
        for value, low, high in size.components
        if not (card_of(f.effect).rule is Rule.PHASOR and name == "phase")
    }


def apart(one: Interval, other: Interval) -> float:
    """How far two sizes are apart in standard errors of the difference, as the intervals have it.

    Each interval counts by the side that looks to the other.
    """
    low, high = sorted([one, other])
    return float((high[0] - low[0]) / max(np.hypot(low[2] - low[0], high[0] - high[1]), 1e-300))


def agreeing(cases: Sequence[Sizes]) -> list[tuple[tuple[str, str], bool]]:
    """Name of every size that all cases of a recording have, and whether each pair agrees."""
    if len(cases) < 2:
        return []
    return [
        (name, apart(one[name], other[name]) <= 1.0)
        for one, other in itertools.combinations(cases, 2)
        for name in one.keys() & other.keys()
    ]


def _in_words(finding: Finding) -> str:
    values = [size.value for size in finding.parameters.values()]
    return f"{finding.effect} " + ", ".join(f"{v:.4g}" for v in values if isinstance(v, float))


def scored(
    folder: Path, job: tuple[str, str, str, dict[str, Any]]
) -> tuple[list[tuple[str, str]], list[Sizes]]:
    """Grade and a line, and the sizes, of every case of one kind of one recording."""
    kind, machine, name, truth = job
    judge = judge_of(folder)
    found: list[tuple[str, str]] = []
    known: list[Sizes] = []
    for number, case in enumerate(cases_of(folder, job)):
        label = f"{kind} {number + 1} {machine}/{name.split('.')[0]}"
        start = time.perf_counter()
        try:
            answer = diagnose_recordings(case.robot, case.recordings, case.holdout)
        except DeltactlError as error:
            found.append(("refused", f"{label}: {str(error)[-150:]}"))
            continue
        known.append(sizes_of(answer))
        why, dishonest = judge.judge(answer.to_json(), truth)
        dishonest += contradictions(answer)
        grade = "dishonest" if dishonest else "wrong" if why else "right"
        wrong = "; ".join([*why, *dishonest])
        said = f"{answer.verdict} {'; '.join(_in_words(finding) for finding in answer.findings)}"
        took = time.perf_counter() - start
        found.append((grade, f"{label}: {wrong} | {said} ({took:.1f} s)"))
    return found, known


def main() -> None:
    """Print a row a kind of variation, and every answer that is not right."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--recordings")
    parser.add_argument("--kinds", default=",".join(KINDS), help="kinds of variation, by commas")
    parser.add_argument("--sets", default="", help="sets of recordings, by commas")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--all", action="store_true", help="print right answers as well")
    options = parser.parse_args()
    folder = Path(options.recordings or os.environ.get("DELTACTL_RECORDINGS") or DEFAULT)
    kinds, sets = options.kinds.split(","), set(filter(None, options.sets.split(",")))
    jobs = [(k, *truth) for k in kinds for truth in truths(folder) if not sets or truth[0] in sets]
    grades: dict[str, Counter[str]] = {kind: Counter() for kind in kinds}
    pairs: dict[str, Counter[bool]] = {kind: Counter() for kind in kinds}
    with ProcessPoolExecutor(options.processes, mp_context=get_context("spawn")) as pool:
        answers = pool.map(partial(scored, folder), jobs)
        for job, (results, sizes) in zip(jobs, answers, strict=True):
            for name, agrees in agreeing(sizes):
                pairs[job[0]][agrees] += 1
                if not agrees:
                    place = f"{job[0]} {job[1]}/{job[2]}"
                    print(f"disagrees {place}: {_side_by_side(name, sizes)}", flush=True)
            for grade, line in results:
                grades[job[0]][grade] += 1
                if grade != "right" or options.all:
                    print(f"{grade:9} {line}", flush=True)
    _print_tables(grades, pairs)


def _side_by_side(name: tuple[str, str], sizes: Sequence[Sizes]) -> str:
    known = [case[name] for case in sizes if name in case]
    each = "; ".join("{:.4g} [{:.4g}, {:.4g}]".format(*size) for size in known)
    return f"{' '.join(name)} {each}"


def _print_tables(grades: dict[str, Counter[str]], pairs: dict[str, Counter[bool]]) -> None:
    print(f"{'variation':14} cases  right  wrong  dishonest  refused")
    for kind, count in [*grades.items(), ("all", sum(grades.values(), Counter()))]:
        good = f"{count.total():5} {count['right']:6} {count['wrong']:6}"
        print(f"{kind:14} {good} {count['dishonest']:10} {count['refused']:8}")
    for kind, both in pairs.items():
        if both.total():
            share = f"{both[True]} of {both.total()}"
            print(f"{kind}: sizes of two parts agree within their intervals in {share}")


if __name__ == "__main__":
    main()
