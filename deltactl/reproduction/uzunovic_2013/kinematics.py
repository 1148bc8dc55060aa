"""Section 3 of Uzunovic 2013 over again: is the geometric model right, and is a network better?

The robot as built is led along eq. (1); the geometric model and networks are judged by what its
encoders said. `reproduce_kinematics` gives tables and figures as plain data.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from deltactl.charts.page import heading, paragraph
from deltactl.foundation.process import one_thread
from deltactl.models.linkage import Linkage, forward, inverse
from deltactl.models.robot import DeltaRobot, FloatArray
from deltactl.models.robot_files import load_delta
from deltactl.models.training.calibrate import Plausible, calibrate
from deltactl.models.training.recipe import Follow, unseen
from deltactl.models.training.samples_of_angles import IntArray, split
from deltactl.models.training.tooth_errors import find_tooth_errors
from deltactl.models.training.uzunovic import UzunovicSettings, train_uzunovic
from deltactl.reproduction.sheet import Sheet
from deltactl.reproduction.uzunovic_2013.kinematics_as_built import StageRobot
from deltactl.reproduction.uzunovic_2013.kinematics_figures import figures
from deltactl.reproduction.uzunovic_2013.kinematics_stage import (
    SAMPLES,
    Measured,
    Validation,
    measure,
)
from deltactl.reproduction.uzunovic_2013.kinematics_tables import range_sheet, recipe_sheet, table_1

ROBOT_FILE = Path(__file__).resolve().parents[2] / "config" / "uzunovic-2013.yaml"
QUICK_SAMPLES, QUICK_ITERATIONS = 1000, 30
TITLE = "Section 3: is the geometric model of the micro delta right?"
LEAD = (
    "An XYZ stage leads the robot along eq. (1), 13 333 samples over 1333.3 s, and encoders of "
    "0.01 degrees are read. The robot is the MuJoCo robot of the proof, built as "
    "reproduction/uzunovic_2013/kinematics_as_built.py says: nobody published what was wrong with "
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
