"""Section 3 of Uzunovic 2013 over again: is the geometric model right, and is a network better?

The robot as built is led along eq. (1); the geometric model and networks are judged by what its
encoders said. `reproduce_kinematics` gives tables and figures as plain data.

Errors that repeat with an arm's angle, such as those of gear teeth, are looked for in what a
calibrated geometry leaves. An error of a gear repeats a fixed number of times a turn; the number
shows as a peak when what is left is held against sines of the arm's angle (Lomb 1976). The errors
of worn teeth are no sines: harmonics go with it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from deltactl.charts.page import heading, paragraph
from deltactl.foundation.process import one_thread
from deltactl.models.linkage import Linkage, forward, inverse
from deltactl.models.robot import ARMS, DeltaRobot, FloatArray
from deltactl.models.robot_files import load_delta
from deltactl.models.training.calibrate import Plausible, calibrate
from deltactl.models.training.recipe import Follow, unseen
from deltactl.models.training.samples import IntArray, split
from deltactl.models.training.uzunovic import UzunovicSettings, train_uzunovic
from deltactl.reproduction.outcome import Sheet
from deltactl.reproduction.uzunovic_2013.kinematics_results import (
    figures,
    range_sheet,
    recipe_sheet,
    table_1,
)
from deltactl.reproduction.uzunovic_2013.kinematics_stage import (
    SAMPLES,
    Measured,
    StageRobot,
    Validation,
    measure,
)

MOST_PER_TURN = 400.0
"""Finer than the teeth of any small gear."""
_LEAST_PERIODS = 3.0
"""An error that repeats fewer times over the measured angles could be anything smooth."""
_PER_PERIOD = 8
"""Trial frequencies for each that the measured range can tell apart."""
_HARMONICS = 4


@dataclass(frozen=True, eq=False)
class ToothErrors:
    """Errors of the three gears as sums of sines of the arm's angle."""

    per_turn: FloatArray
    """How often each repeats in a turn of its arm, (3,)."""
    parts_rad: FloatArray
    """(3 arms, 1 + 2 * harmonics): constant, then sine and cosine of each harmonic."""

    def error_rad(self, angles_rad: FloatArray) -> FloatArray:
        """Errors (n, 3) at angles (n, 3)."""
        columns = [
            _teeth_columns(angles_rad[:, arm], self.per_turn[arm]) @ self.parts_rad[arm]
            for arm in range(ARMS)
        ]
        return np.stack(columns, axis=1)

    @property
    def numbers(self) -> int:
        """How many numbers were fitted."""
        return self.per_turn.size + self.parts_rad.size


def find_tooth_errors(angles_rad: FloatArray, left_rad: FloatArray) -> ToothErrors:
    """From what a calibration leaves (n, 3) at angles (n, 3), for each arm by itself."""
    found = [_find_teeth(angles_rad[:, arm], left_rad[:, arm]) for arm in range(ARMS)]
    per_turn, parts = zip(*found, strict=True)
    return ToothErrors(np.array(per_turn), np.stack(parts))


def _find_teeth(angle_rad: FloatArray, left_rad: FloatArray) -> tuple[float, FloatArray]:
    turns = float(np.ptp(angle_rad)) / (2.0 * np.pi)
    trials = np.arange(_LEAST_PERIODS / turns, MOST_PER_TURN, 1.0 / (turns * _PER_PERIOD))
    centred = left_rad - left_rad.mean()
    powers = [abs(np.exp(-1j * trial * angle_rad) @ centred) for trial in trials]
    best = float(trials[int(np.argmax(powers))])
    nearby = np.linspace(best - 0.5 / turns, best + 0.5 / turns, 41)
    fits = [_fit_teeth(angle_rad, left_rad, per_turn) for per_turn in nearby]
    chosen = int(np.argmin([cost for cost, _ in fits]))
    return float(nearby[chosen]), fits[chosen][1]


def _fit_teeth(
    angle_rad: FloatArray, left_rad: FloatArray, per_turn: float
) -> tuple[float, FloatArray]:
    columns = _teeth_columns(angle_rad, per_turn)
    parts: FloatArray = np.linalg.lstsq(columns, left_rad, rcond=None)[0]
    return float(np.sum((columns @ parts - left_rad) ** 2)), parts


def _teeth_columns(angle_rad: FloatArray, per_turn: float) -> FloatArray:
    """(n, 1 + 2 * harmonics)."""
    phases = [k * per_turn * angle_rad for k in range(1, _HARMONICS + 1)]
    waves = [wave(phase) for phase in phases for wave in (np.sin, np.cos)]
    return np.stack([np.ones_like(angle_rad), *waves], axis=1)


ROBOT_FILE = Path(__file__).resolve().parents[2] / "config" / "uzunovic-2013.yaml"
QUICK_SAMPLES, QUICK_ITERATIONS = 1000, 30
TITLE = "Section 3: is the geometric model of the micro delta right?"
LEAD = (
    "An XYZ stage leads the robot along eq. (1), 13 333 samples over 1333.3 s, and encoders of "
    "0.01 degrees are read. The robot is the MuJoCo robot of the proof, built as "
    "reproduction/uzunovic_2013/kinematics_stage.py says: nobody published what was wrong with "
    "the real one, so what is wrong here was chosen to give errors of the printed size."
)
_STEPS = 5
_GEOMETRY_NUMBERS = 15
"""Five an arm: radius, upper arm, forearm, direction, zero."""
_STAGE_SEES = Plausible(
    length=0.1,
    azimuth_rad=0.2,
    gear_rad=0.0,
    sensor_offset_m=0.0,
    sensor_scale=0.0,
    sensor_turn_rad=0.0,
    sensor_curvature_per_m=0.0,
)
"""For a robot as wrong as this one; the stage itself is taken as right."""


@dataclass(frozen=True)
class KinematicsPart:
    """What section 3 gives to a report."""

    validation: Validation = field(repr=False)
    sheets: list[Sheet]
    figures: list[str] = field(repr=False)

    def html(self) -> list[str]:
        """Pieces for `deltactl.charts.page.page`."""
        tables = [sheet.html() for sheet in self.sheets]
        return [heading(TITLE), paragraph(LEAD), *tables, *self.figures]


def reproduce_kinematics(quick: bool = False, follow: Follow = unseen) -> KinematicsPart:
    """Measure, train, compare. quick: a thirteenth of the samples and fewer iterations."""
    network = UzunovicSettings(hold_out=False)
    if quick:
        found = validate(QUICK_SAMPLES, network.lasting(QUICK_ITERATIONS), follow)
    else:
        found = validate(SAMPLES, network, follow)
    sheets = [range_sheet(found.error_m), table_1(found), recipe_sheet(found)]
    return KinematicsPart(found, sheets, figures(found))


@one_thread
def validate(samples: int, settings: UzunovicSettings, follow: Follow = unseen) -> Validation:
    """The experiment and all models. Raises UnreachablePoint when the robot cannot follow."""
    robot = load_delta(ROBOT_FILE)
    follow(0, _STEPS, "leading the robot along eq. (1)")
    measured = measure(robot, StageRobot(), samples)
    everything = np.arange(samples)
    nominal = Linkage.of(robot.geometry)
    position_m, angles_rad = measured.position_m, measured.angles_rad
    models: dict[str, tuple[FloatArray, int, IntArray]] = {}
    models["mathematical model"] = (inverse(nominal, position_m).angles_rad, 0, everything)
    follow(1, _STEPS, "training the network on all samples")
    network = train_uzunovic(position_m, angles_rad, settings)
    models["network"] = (network.angles_rad_many(position_m), network.parameters, everything)
    follow(2, _STEPS, "training the network on three quarters")
    models["network, held-out samples"] = _held_out(measured, settings)
    follow(3, _STEPS, "calibrating the robot")
    exact_rad, numbers = _calibrated(robot, measured)
    models["calibrated geometry"] = (exact_rad, numbers, everything)
    follow(4, _STEPS, "looking for gear teeth in what the calibration leaves")
    teeth = find_tooth_errors(exact_rad, angles_rad - exact_rad)
    both_rad: FloatArray = exact_rad + teeth.error_rad(exact_rad)
    models["calibrated geometry and gears"] = (both_rad, numbers + teeth.numbers, everything)
    follow(_STEPS, _STEPS, "")
    return Validation(
        measured=measured,
        calculated_m=forward(nominal, angles_rad).position_m,
        angles_rad={name: made[0] for name, made in models.items()},
        parameters={name: made[1] for name, made in models.items()},
        judged={name: made[2] for name, made in models.items()},
    )


def _held_out(measured: Measured, settings: UzunovicSettings) -> tuple[FloatArray, int, IntArray]:
    """The paper's network again, judged by a quarter of the samples that it did not see."""
    judged = replace(settings, hold_out=True)
    network = train_uzunovic(measured.position_m, measured.angles_rad, judged)
    _, held = split(len(measured.t_s), network.seed)
    return network.angles_rad_many(measured.position_m), network.parameters, held


def _calibrated(robot: DeltaRobot, measured: Measured) -> tuple[FloatArray, int]:
    """Angles by geometry with fitted lengths, directions and zeros, and how many those are."""
    bare = robot.model_copy(update={"masses": None})
    found = calibrate(bare, measured.position_m, measured.angles_rad, _STAGE_SEES)
    return found.angles_rad_many(measured.position_m), _GEOMETRY_NUMBERS
