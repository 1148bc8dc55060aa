"""Where the 0 0 0 of a file would have to be for all of it to be within the robot's reach."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from deltactl.firmware_py.describing.first_job import heights_m
from deltactl.firmware_py.importing.by_line import ends_reached
from deltactl.firmware_py.importing.drawn import Drawn, Point, job_data
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.kinematics_of_job import kinematics_of
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.planner.plan import make_plan
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.errors import MotionError
from deltactl.models.robot import FloatArray

MOST_TRIED = 3
"""Places at which the whole path is checked, each as long as the check that was refused."""
FORM = (
    "--origin \"X Y Z\" says where the file's 0 0 0 is in the robot's frame, in mm (z is negative"
    " below the motors)"
)


@contextmanager
def with_an_origin(
    drawn: Drawn, robot: str, zero_m: Point, speed_mps: float, corner_m: float
) -> Iterator[None]:
    """A refusal of a place says which origin, in place of zero_m, brings the whole path in reach.

    robot, speed_mps and corner_m are those of the job that was made of it.
    """
    try:
        yield
    except MotionError as error:
        if error.at_point is None:
            raise
        try:
            origin = _origin_m(drawn, robot, zero_m, speed_mps, corner_m)
        except MotionError:  # of the robot file itself
            origin = None
        if origin is None:
            raise error.worded(f"{error}; {FORM}") from error
        said = " ".join(f"{1e3 * value:.6g}" for value in origin)
        raise error.worded(f'{error}; all of it is within reach with --origin "{said}"') from error


def _origin_m(
    drawn: Drawn, robot_name: str, zero_m: Point, speed_mps: float, corner_m: float
) -> Point | None:
    """As near as can be to what was asked for: at another height, else in the middle as well."""
    robot = load_robot(find(robot_name))
    points_m = np.concatenate([np.array(drawn.start_m)[None], drawn.legs.to_m])
    fitting = (
        one for one in _shifts_m(robot, points_m) if ends_reached(robot, points_m + one).all()
    )
    for shift_m in itertools.islice(fitting, MOST_TRIED):
        data = job_data(_moved(drawn, shift_m), "moved", robot_name, speed_mps, corner_m)
        job = JobFile.model_validate(data)
        try:
            make_plan(job, robot, kinematics_of(job, robot, None))
        except MotionError:
            continue
        x_m, y_m, z_m = (np.array(zero_m) + shift_m).round(6).tolist()
        return x_m + 0.0, y_m + 0.0, z_m + 0.0
    return None


def _shifts_m(robot: RobotFile, points_m: FloatArray) -> Iterator[FloatArray]:
    """To heights at which the robot works well, first as it lies, then with its middle at 0 0."""
    middle_m = (points_m.min(axis=0) + points_m.max(axis=0)) / 2.0
    for aside, height_m in itertools.product((0.0, 1.0), heights_m(robot)):
        goal_m = np.array([*((1.0 - aside) * middle_m[:2]), height_m])
        yield np.round(goal_m - middle_m, 3)


def _moved(drawn: Drawn, shift_m: FloatArray) -> Drawn:
    x_m, y_m, z_m = (np.array(drawn.start_m) + shift_m).tolist()
    return replace(drawn, start_m=(x_m, y_m, z_m), legs=drawn.legs.moved(shift_m), between=())
