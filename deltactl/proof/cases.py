"""Draw a case by seed and number: a machine with something hidden, and how it moves.

On disk, what the diagnosis may see is in one folder, the answers in another file.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.foundation.plain_file import write_whole
from deltactl.proof.hidden.hidden import Hidden
from deltactl.proof.hidden.more_oddities import SEEN, SURVEY_ONLY, UNKNOWN, UNSEEN
from deltactl.proof.hidden.oddities import ODDITIES
from deltactl.proof.hidden.vocabulary import (
    SINGLES,
    VOCABULARY,
    Planned,
    construct,
    hidden,
    plan,
    settle,
)
from deltactl.proof.motions import SHAPES, curve, survey
from deltactl.proof.ranging import Noise, Sensors
from deltactl.proof.recorded import Machine, record, record_with_truth
from deltactl.proof.robot.as_built import AsBuilt, StepTrain
from deltactl.proof.robot.run import Truth
from deltactl.recording.tables.flat_files import write_flat

LENGTH_M = 1e-4
ANGLE_RAD = 4e-4
SENSOR_M = 4e-4
SHARE = 3e-4


def tolerances(machine: Machine, rng: np.random.Generator) -> None:
    """Standard deviations: 0.1 mm in lengths, 0.023 degrees in angles, 0.4 mm in sensors."""
    body, joints, sensors = machine.robot.body, machine.robot.joints, machine.sensors

    def three(size: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        return size * np.clip(rng.standard_normal(3), -2.5, 2.5)

    body.upper_arm_m += three(LENGTH_M)
    body.forearm_m += three(LENGTH_M)
    body.base_radius_m += three(LENGTH_M)
    body.azimuth_rad += three(ANGLE_RAD)
    joints.home_rad += three(ANGLE_RAD)
    joints.scale += three(SHARE)
    joints.wave_rad += np.abs(three(ANGLE_RAD))
    joints.play_rad += np.abs(three(ANGLE_RAD))
    joints.friction_nm += np.abs(three(0.5))
    sensors.offset_m += three(SENSOR_M)
    sensors.scale += three(SHARE)
    sensors.turned_rad += three(ANGLE_RAD)


ROUND = (
    *["nothing"] * 4,
    *["single"] * 4,
    *["faint"] * 3,
    *["two"] * 2,
    *["three"] * 2,
    *["tolerance"] * 2,
    *["unknown"] * 3,
)
"""Groups of twenty successive cases."""
MORE_ROUND = ("four", "five", "seen", "unseen", "beside")
"""Groups of five successive cases of the second set: many causes, new unknowns of which the
diagnosis' makers may look at half, and an unknown beside a named effect."""
MORE = "more"
CURVES = 0.25
"""Share of cases that only draw curves."""
FAINT = 1.0 / 3.0
SURVEY_S = (120.0, 240.0)
CURVE_S = (60.0, 120.0)
HOLDOUT_S = 60.0
SURVEY_T_PWM_S = (0.001, 0.002, 0.004)
CURVE_T_PWM_S = (0.002, 0.004, 0.006)


@dataclass
class Case:
    """One robot with its two runs; `answers` are its hidden faults."""

    number: int
    group: str
    motion: str
    machine: Machine
    holdout_machine: Machine
    train: StepTrain
    holdout_train: StepTrain
    answers: list[Hidden] = field(default_factory=list)
    planned: list[Planned] = field(default_factory=list)
    stem: str = "case"
    """Which set it is of, in names of folders."""

    def truth(self) -> dict[str, Any]:
        """In the form of the practice recordings' answers.json, with more keys."""
        noise = self.machine.noise
        return {
            "case": f"{self.stem}_{self.number:04d}",
            "group": self.group,
            "motion": self.motion,
            "answers": [part.answer() for part in self.answers],
            "t_pwm": self.train.t_pwm_s,
            "sigma": noise.sigma_m,
            "rho": noise.rho,
            "outliers": noise.outliers,
            "dropouts": noise.dropouts,
            "dropout_samples": noise.dropout_samples,
            "seconds": self.train.seconds,
        }


def draw(seed: int, number: int) -> Case:
    """Case `number` of a proof with this seed; the same arguments give the same case."""
    group = ROUND[number % len(ROUND)]
    rng = np.random.default_rng([seed, number])
    # Kinds take turns within a group, so that a short proof does not miss any by chance.
    turn = number // len(ROUND) * ROUND.count(group) + number % len(ROUND) - ROUND.index(group)
    order = np.random.default_rng([seed, sum(group.encode())])
    if group == "unknown":
        names = order.permutation(sorted(ODDITIES))
        return assemble(number, group, [str(names[turn % len(names)])], rng)
    names = order.permutation(SINGLES)
    first = str(names[turn % len(names)])
    if group == "nothing":
        return assemble(number, group, [], rng)
    count = {"two": 2, "three": 3}.get(group, 1)
    others = [name for name in rng.permutation(SINGLES).tolist() if name != first]
    return assemble(number, group, [first, *others[: count - 1]], rng)


def draw_more(seed: int, number: int) -> Case:
    """Case `number` of the second set; it takes nothing away from what `draw` gives."""
    group = MORE_ROUND[number % len(MORE_ROUND)]
    rng = np.random.default_rng([seed, number, 2])
    turn = number // len(MORE_ROUND)
    order = np.random.default_rng([seed, sum(group.encode()), 2])
    first_of = {"seen": SEEN, "unseen": UNSEEN, "beside": tuple(sorted(UNKNOWN))}
    names = order.permutation(first_of.get(group, SINGLES))
    first = str(names[turn % len(names)])
    beside = {"four": 3, "five": 4, "beside": 1}.get(group, 0)
    works_through = ("joint_compliance",) if first in UNKNOWN else ()
    others = [n for n in rng.permutation(SINGLES).tolist() if n not in (first, *works_through)]
    case = assemble(number, group, [first, *others[:beside]], rng)
    case.stem = MORE
    return case


def assemble(
    number: int,
    group: str,
    kinds: list[str],
    rng: np.random.Generator,
    motion: str | None = None,
    seconds: float | None = None,
    strength: float | None = None,
) -> Case:
    """A case with given kinds (of the vocabulary or oddities); what is None is drawn."""
    moves = motion or _motion(rng, kinds)
    size = strength or (FAINT if group == "faint" else 1.0)
    noise = Noise(
        sigma_m=float(rng.uniform(0.0015, 0.003)),
        rho=float(rng.choice([0.0, 0.3, 0.6])),
        outliers=float(rng.choice([0.0, 0.003, 0.01])),
        dropouts=float(rng.choice([0.0, 0.01, 0.03])),
        dropout_samples=float(rng.choice([1.0, 5.0, 20.0])),
    )
    t_pwm_s = float(rng.choice(SURVEY_T_PWM_S if moves == "survey" else CURVE_T_PWM_S))
    length_s = seconds or float(rng.choice(SURVEY_S if moves == "survey" else CURVE_S))
    train = move(rng, moves, length_s, t_pwm_s)
    holdout_train = move(rng, moves, min(length_s, HOLDOUT_S), t_pwm_s)
    planned = [plan(VOCABULARY[kind], rng, size) for kind in kinds if kind in VOCABULARY]
    settle(planned, rng, train)
    build_seed = int(rng.integers(2**32))
    machines, odd = [], []
    for with_events in (True, False):
        machine = Machine(AsBuilt(), Sensors(), noise)
        built = np.random.default_rng(build_seed)
        if group == "tolerance":
            tolerances(machine, built)
        odd = [UNKNOWN[kind](machine, built, size) for kind in kinds if kind in UNKNOWN]
        construct(machine, planned, with_events)
        machines.append(machine)
    answers = [hidden(part) for part in planned] + odd
    return Case(
        number, group, moves, machines[0], machines[1], train, holdout_train, answers, planned
    )


def _motion(rng: np.random.Generator, kinds: list[str]) -> str:
    """A table is only ever met in a survey: a level curve is on it all the time or never. So is
    what shows at some places or speeds only."""
    if rng.random() < CURVES and not {"contact", *SURVEY_ONLY} & set(kinds):
        return str(rng.choice(sorted(SHAPES)))
    return "survey"


def move(rng: np.random.Generator, motion: str, seconds: float, t_pwm_s: float) -> StepTrain:
    """A survey or a curve of drawn size and height."""
    if motion == "survey":
        return survey(rng, seconds, t_pwm_s)
    size_m, height_m = float(rng.uniform(0.06, 0.12)), float(rng.uniform(-0.5, -0.4))
    return curve(motion, size_m, height_m, seconds, t_pwm_s, bool(rng.random() < 0.5))


ROBOT = """\
# What the robot of the proof was meant to be (Zhao 2023, Tables 1 and 2).
kind: delta
name: proof-robot
geometry:
  base_radius_m: 0.325
  platform_radius_m: 0.075
  upper_arm_m: 0.25
  forearm_m: 0.5
  azimuth_deg: [0, 120, 240]
masses: {upper_arm_kg: 0.205, forearm_kg: 0.153, platform_kg: 0.653}
drive: {microsteps_per_rev: 1600, gear_ratio: 10}
sensors:
  x: {offset_m: 0.60, axis: [1, 0, 0]}
  y: {offset_m: 0.60, axis: [0, 1, 0]}
  z: {offset_m: 0.90, axis: [0, 0, 1]}
"""
RECORDING, HOLDOUT, ROBOT_FILE = "recording.csv.gz", "holdout.csv.gz", "robot.yaml"


def write_blind(case: Case, folder: Path, seed: int) -> Truth:
    """Simulate both runs and write them with the robot file; no word of the hidden faults.

    Returns what really happened in the first run.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng([seed, case.number, 1])
    recording, truth = record_with_truth(case.machine, case.train, rng)
    write_flat(recording, folder / RECORDING)
    write_flat(record(case.holdout_machine, case.holdout_train, rng), folder / HOLDOUT)
    write_whole(folder / ROBOT_FILE, ROBOT)
    return truth


def write_answers(case: Case, path: Path) -> None:
    """The truth, as JSON."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, json.dumps(case.truth(), indent=1) + "\n")
