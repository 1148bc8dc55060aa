"""The drawn axes that every tool gets, and deltactl's own answers.

Odd seeds of the proof's generator, which judge the diagnosis and never tune it. Half of the axes
are healthy, the others hide one to three effects that have a name (tiers single, gross, pair and
three): no tool but deltactl can say "unknown", "a tie" or "too faint".
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.rivals.axis_signals import peak_mb
from deltactl.proof.axis.build import Design
from deltactl.proof.axis.cases import MACHINES, ROUND, AxisCase, draw, write_blind
from deltactl.proof.prove.axis_score import AxisScore, score_axis
from deltactl.proof.prove.one_case import diagnose_blind

Json = dict[str, Any]
NAMED_TIERS = ("single", "gross", "pair", "three")
FOLLOWS_OR_FORCED = ("commanded", "effort")
SEEDS_APART = 100_000
ROBOT_JSON = "robot.json"


@dataclass(frozen=True)
class Answers:
    """What one tool said of every axis: case -> answer, and its peak memory."""

    by_case: dict[str, Json]
    peak_mb: float


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
    """A folder a case: two recordings, the robot file, and its values for tools without YAML.

    Returns the truths, which no tool sees.
    """
    truths = [case.truth() for case in cases]
    for case, truth in zip(cases, truths, strict=True):
        own = folder / truth["case"]
        write_blind(case, own)
        text = json.dumps(robot_values(case.design))
        (own / ROBOT_JSON).write_text(text, encoding="utf-8")
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
    return {"inertia": plan.inertia, "gain": plan.gain, "weight": weight, "gravity": torque,
            "gravity_zero": zero_rad}  # fmt: skip


def by_deltactl(folder: Path) -> Answers:
    """Diagnose every case in a process of its own, on one core."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(_diagnosed, folder).result()


def _diagnosed(folder: Path) -> Answers:
    by_case = {}
    for one in sorted(folder.iterdir()):
        begun = time.monotonic()
        said, failure = diagnose_blind(one)
        seconds = time.monotonic() - begun
        heldout = said["fit"]["holdout_rms_after_m"] if said is not None else None
        by_case[one.name] = {"diagnosis": said, "failure": failure, "seconds": seconds,
                             "heldout": heldout}  # fmt: skip
    return Answers(by_case, peak_mb())


def read_answers(file: Path) -> Answers:
    """What the other environment wrote, in the form of the diagnosis.

    A tool without findings on an axis that it answered says that nothing is missing.
    """
    written = json.loads(file.read_text(encoding="utf-8"))
    by_case = {}
    for name, own in written["answers"].items():
        found = own.pop("findings")
        verdict = "explained" if found else "nothing_missing"
        left = {"rms_after_m": own["heldout"] or 0.0}
        own["diagnosis"] = None
        if found is not None:
            own["diagnosis"] = {"verdict": verdict, "findings": found, "fit": left}
        by_case[name] = own
    return Answers(by_case, written["peak_mb"])


@dataclass(frozen=True)
class Scored:
    """One axis as one tool answered it."""

    marks: AxisScore
    right: bool
    """Each hidden effect, or what an ideal observer cannot tell from it, is a finding, and nothing
    needless is. Alternatives do not count: only one of the tools offers any."""
    seconds: float
    heldout_over_noise: float
    """NaN for an axis with effort: each tool has a low-pass, and so a noise, of its own."""


def scored(truths: Sequence[Json], answers: Answers) -> list[Scored]:
    """By the proof's own scorer; axes that the tool does not take are left out."""
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
            "diagnosed_s": own["seconds"],
        }
        over = np.nan
        if truth["machine"] == "commanded" and own["heldout"] is not None:
            over = own["heldout"] / truth["noise_rms_high"]
        marks = score_axis(result)
        said = set(marks.said)
        named = all(said & {*line["names"], *line["ties"]} for line in truth["answers"])
        right = named and not marks.needless and marks.failure is None
        found.append(Scored(marks, right, own["seconds"], float(over)))
    return found
