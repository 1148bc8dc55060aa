"""Cases that every tool gets, deltactl's own answers, and what the drawn axes hide.

A case is a folder with `recording.csv.gz`, `robot.yaml`, its values as `robot.json` for tools
without YAML, and, where there is one, `holdout.csv.gz`.

Drawn axes: odd seeds of the proof's generator, which judge the diagnosis and never tune it. Half of
the axes are healthy, the others hide one to three effects that have a name (tiers single, gross,
pair and three): no tool but deltactl can say "unknown", "a tie" or "too faint".
"""

from __future__ import annotations

import gzip
import json
import shutil
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.rivals.each_case import each_case
from deltactl.proof.axis.build import Design
from deltactl.proof.axis.cases import (
    HOLDOUT,
    MACHINES,
    RECORDING,
    ROUND,
    AxisCase,
    draw,
    write_blind,
)
from deltactl.proof.prove.axis_score import score_axis
from deltactl.proof.prove.one_case import diagnose_blind

Json = dict[str, Any]
NAMED_TIERS = ("single", "gross", "pair", "three")
FOLLOWS_OR_FORCED = ("commanded", "effort")
SEEDS_APART = 100_000
ROBOT_JSON = "robot.json"
HALVES = ("first", "second")


@dataclass(frozen=True)
class Answers:
    """What one tool said of every case: case -> answer, and its peak memory in one case."""

    by_case: dict[str, Json]
    peak_mb: float

    def unbegun(self) -> int:
        """Cases that the tool had no time for."""
        return sum(bool(own.get("unbegun")) for own in self.by_case.values())


@dataclass(frozen=True)
class Scored:
    """One case as one tool answered it."""

    case: str
    group: str
    """Group of the table: cases with one title."""
    truth: list[str]
    said: list[str]
    right: bool
    """Each hidden effect is a finding, and nothing needless is. Alternatives do not count: only one
    of the tools offers any."""
    false: bool | None
    """Something is claimed that is not there; None where the group counts it elsewhere."""
    seconds: float
    failure: str | None = None
    sizes: list[bool] = field(default_factory=list)
    """For each known size that is stated: whether its 95 % interval holds the truth."""
    over_bound: list[float] = field(default_factory=list)
    """Errors of sizes over their Cramer-Rao standard deviation."""
    heldout_over_noise: float = float("nan")
    agree: list[bool] = field(default_factory=list)
    """For each size that both halves state: whether they agree within their intervals."""
    outright: bool | None = None
    """Right by its findings alone, where an alternative counts too."""


def drawn(count: int, seed: int) -> list[AxisCase]:
    """So many axes with commands or effort, every other one healthy."""
    healthy, faulty = _seeds(seed, ("none",)), _seeds(seed, NAMED_TIERS)
    return [draw(next(faulty if number % 2 else healthy)) for number in range(count)]


def _seeds(seed: int, tiers: Sequence[str]) -> Iterator[int]:
    """Odd seeds of these tiers from a place of their own."""
    number = seed * SEEDS_APART + 1
    while True:
        turn = number // 2
        machine = MACHINES[turn % len(MACHINES)]
        if ROUND[turn % len(ROUND)] in tiers and machine in FOLLOWS_OR_FORCED:
            yield number
        number += 2


def write_cases(cases: Sequence[AxisCase], folder: Path) -> list[Json]:
    """A folder a case. Returns the truths with the bounds of sizes, which no tool sees.

    Beside the folder stands what a tool may be told: the names of what is hidden.
    """
    truths = [case.truth() | {"bound": case.bound()} for case in cases]
    for case, truth in zip(cases, truths, strict=True):
        own = folder / truth["case"]
        write_blind(case, own)
        text = json.dumps(robot_values(case.design))
        (own / ROBOT_JSON).write_text(text, encoding="utf-8")
    told = {one["case"]: [f"{line['names'][0]} axis" for line in one["answers"]] for one in truths}
    folder.with_name(f"{folder.name}-told.json").write_text(json.dumps(told), encoding="utf-8")
    return truths


def robot_values(plan: Design) -> Json:
    """What the robot file states, in SI units.

    Commanded axes: `zero` and `step` (position of one unit of the command). Axes with effort:
    `inertia`, `gain`, `weight`, `gravity` and `gravity_zero`, zero where the file is silent.
    """
    if plan.machine == "commanded":
        zero = "absolute" if plan.absolute else "arbitrary"
        return {"zero": zero, "step": plan.step_size if plan.counted else 1.0}
    torque, zero_rad = plan.gravity if plan.states_gravity else (0.0, 0.0)
    weight = plan.weight if plan.states_gravity else 0.0
    stated = {"inertia": plan.inertia, "gain": plan.gain, "weight": weight}
    return stated | {"gravity": torque, "gravity_zero": zero_rad}


def cut_in_halves(folder: Path) -> None:
    """Beside each case two more, CASE.first and CASE.second, with half of its rows each."""
    for case in [one for one in sorted(folder.iterdir()) if one.is_dir()]:
        with gzip.open(case / RECORDING, "rt", encoding="utf-8") as text:
            head, *rows = text.readlines()
        middle = len(rows) // 2
        for name, own in zip(HALVES, (rows[:middle], rows[middle:]), strict=True):
            half = folder / f"{case.name}.{name}"
            shutil.copytree(case, half)
            with gzip.open(half / RECORDING, "wt", encoding="utf-8") as text:
                text.writelines([head, *own])


def by_deltactl(folder: Path, out: Path, most_s: float) -> None:
    """Diagnose every case, on one core."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        asked = pool.submit(each_case, _diagnosed, folder, ["deltactl.diagnosis.api"], most_s)
        answers, peak_mb = asked.result()
    written = {"answers": answers, "peak_mb": peak_mb}
    out.write_text(json.dumps(written), encoding="utf-8")


def _diagnosed(case: Path) -> Json:
    begun = time.process_time()
    said, failure = diagnose_blind(case)
    seconds = time.process_time() - begun
    apart = said is not None and (case / HOLDOUT).exists()
    heldout = said["fit"]["holdout_rms_after_m"] if said is not None and apart else None
    return {"diagnosis": said, "failure": failure, "seconds": seconds, "heldout": heldout}


def read_answers(file: Path) -> Answers:
    """What a tool wrote, in the form of the diagnosis.

    Another tool without findings on an axis that it answered says that nothing is missing.
    """
    written = json.loads(file.read_text(encoding="utf-8"))
    by_case = {}
    for name, own in written["answers"].items():
        by_case[name] = own
        if "findings" not in own:
            continue
        found = own.pop("findings")
        verdict = "explained" if found else "nothing_missing"
        left = {"rms_after_m": own["heldout"] or 0.0}
        own["diagnosis"] = None
        if found is not None:
            own["diagnosis"] = {"verdict": verdict, "findings": found, "fit": left}
    return Answers(by_case, written["peak_mb"])


def name_of(line: Json) -> str:
    """Name and place of what is hidden."""
    return f"{line['effect']} {line['where']}"


def in_places(truth: Json, own: Json) -> tuple[dict[str, Json], dict[str, Json]]:
    """What is hidden and what is found, by name and place.

    An error that an answer leaves unexplained is an unknown anywhere.
    """
    diagnosis = own["diagnosis"] or {"findings": [], "verdict": "nothing_missing"}
    said = {f"{one['effect']} {one['component']}": one for one in diagnosis["findings"]}
    if not said and diagnosis["verdict"] != "nothing_missing":
        said = {"unknown anywhere": {"parameters": {}}}
    return {name_of(line): line for line in truth["answers"]}, said


def in_place(
    group: str, truth: Json, answers: Answers, hidden: Json, said: Json, **figures: Any
) -> Scored:
    """Right: the findings are the hidden effects in their places, no more and no less."""
    own = answers.by_case[truth["case"]]
    failed = own["failure"] is not None
    return Scored(
        truth["case"],
        group,
        list(hidden),
        list(said),
        right=hidden.keys() == said.keys() and not failed,
        false=None if hidden else bool(said) or failed,
        seconds=own["seconds"],
        failure=own["failure"],
        agree=agreement(answers, truth["case"]),
        **figures,
    )


def write_names(truths: Sequence[Json], folder: Path) -> None:
    """Beside a folder of cases, the names that are hidden, for tools that are given them."""
    names = {one["case"]: [name_of(line) for line in one["answers"]] for one in truths}
    folder.with_name(f"{folder.name}-told.json").write_text(json.dumps(names), encoding="utf-8")


def agreement(answers: Answers, case: str) -> list[bool]:
    """Whether sizes that both halves of a case state agree within their intervals.

    The interval of a difference of two independent sizes is as wide as both at a right angle.
    """
    first, second = (_intervals(answers.by_case.get(f"{case}.{half}")) for half in HALVES)
    return [
        abs(first[name][0] - second[name][0]) <= np.hypot(first[name][1], second[name][1])
        for name in first.keys() & second.keys()
    ]


def _intervals(answer: Json | None) -> dict[tuple[str, str, str], tuple[float, float]]:
    """Middle and half width of every size with both ends; phases and moments are no sizes."""
    found = {}
    for finding in ((answer or {}).get("diagnosis") or {"findings": []})["findings"]:
        for name, size in finding["parameters"].items():
            if not isinstance(size, dict) or not isinstance(size["value"], float):
                continue
            low, high = size["ci95"]
            moment = name == "phase" or (name, finding["effect"]) == ("time", "lost_steps")
            if low is None or high is None or not np.isfinite(high - low) or moment:
                continue
            key = finding["effect"], finding.get("component", ""), name
            found[key] = 0.5 * (low + high), 0.5 * (high - low)
    return found


def scored(truths: Sequence[Json], answers: Answers) -> list[Scored]:
    """By the proof's own scorer; axes that the tool does not take are left out.

    What an ideal observer cannot tell from a hidden effect is as right. Held-out errors of axes
    with effort are left out: each tool has a low-pass, and so a noise, of its own.
    """
    found = []
    for truth in truths:
        own = answers.by_case[truth["case"]]
        if own["seconds"] is None:
            continue
        result = {
            "seed": truth["seed"],
            "truth": truth,
            "diagnosis": own["diagnosis"],
            "failure": own["failure"],
            "bound": truth.get("bound"),
            "diagnosed_s": own["seconds"],
        }
        over = np.nan
        if truth["machine"] == "commanded" and own["heldout"] is not None:
            over = own["heldout"] / truth["noise_rms_high"]
        marks = score_axis(result)
        said = set(marks.said)
        named = all(said & {*line["names"], *line["ties"]} for line in truth["answers"])
        right = named and not marks.needless and marks.failure is None
        hidden = bool(marks.truth)
        found.append(
            Scored(
                marks.case,
                {"effort": "with effort"}.get(marks.machine, marks.machine),
                marks.truth,
                marks.said,
                right,
                None if hidden else marks.alarmed,
                own["seconds"],
                marks.failure,
                marks.covered if hidden else [],
                marks.over_bound if hidden else [],
                float(over),
                agreement(answers, marks.case),
            )
        )
    return found
