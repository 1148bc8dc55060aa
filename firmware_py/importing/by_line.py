"""What is wrong with a job made of a file: the line to blame, and an origin that would do."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from deltactl.firmware_py.describing.first_job import heights_m
from deltactl.firmware_py.importing.drawn import MOST_MISTAKES, Drawn, Point, job_data
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.job_targets import kinematics_of
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.path_file import FARTHEST_M, MOST_DWELL_S, SPEEDS_MPS, Way
from deltactl.firmware_py.paths.way import way
from deltactl.firmware_py.planner.plan import make_plan
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.errors import ConfigError, MotionError
from deltactl.models.linkage import Linkage, inverse
from deltactl.models.robot import FloatArray

_LEG = re.compile(r"\blegs\.(\d+)")
_STEP = re.compile(r"\bsteps\.(\d+)\b")
START = "where the path begins"
_MOST_LINES = 5
"""So many other lines are named where more than one move ends out of reach."""


def checked_job(
    source: Path, drawn: Drawn, name: str, robot: str, speed_mps: float, corner_m: float
) -> JobFile:
    """The job that job_text writes. Raises ConfigError, naming lines of `source`."""
    if says := list(itertools.islice(_beyond_bounds(source, drawn), MOST_MISTAKES + 1)):
        if len(says) > MOST_MISTAKES:
            says[MOST_MISTAKES] = f"{source}: and more mistakes after these"
        raise ConfigError(*says)
    try:
        return JobFile.model_validate(job_data(drawn, name, robot, speed_mps, corner_m))
    except ValidationError as error:
        found = error.errors(include_url=False, include_input=False)[:MOST_MISTAKES]
        told = [
            _named(source, drawn, f"{'.'.join(map(str, one['loc']))}: {one['msg']}")
            for one in found
        ]
        raise ConfigError(*dict.fromkeys(told)) from None


def _beyond_bounds(source: Path, drawn: Drawn) -> Iterator[str]:
    """What no job may have, whatever the robot."""
    if max(map(abs, drawn.start_m)) > FARTHEST_M:
        yield f"{source}:{drawn.start_line}: the path begins {_beyond(drawn.start_m)}"
    least_mps, most_mps = SPEEDS_MPS
    legs = drawn.legs
    far = np.abs(legs.to_m).max(axis=1) > FARTHEST_M
    far_axis = np.abs(np.nan_to_num(legs.centre_m)).max(axis=1) > FARTHEST_M
    speeds_mps = np.where(np.isinf(legs.speed_mps), most_mps, legs.speed_mps)
    odd = (speeds_mps < least_mps) | (speeds_mps > most_mps)
    long = legs.dwell_s > MOST_DWELL_S
    for number in np.flatnonzero(far | far_axis | odd | long).tolist():
        where, (x_m, y_m, z_m) = _line(source, drawn, number), legs.to_m[number].tolist()
        if far[number]:
            yield f"{where}: this move ends {_beyond((x_m, y_m, z_m))}"
        if far_axis[number]:
            x_m, y_m = legs.centre_m[number].tolist()
            yield f"{where}: the centre of this arc lies {_beyond((x_m, y_m))}"
        if odd[number]:
            yield (
                f"{where}: a speed of {1e3 * speeds_mps[number]:.6g} mm/s; 0.001 mm/s to"
                f" {1e3 * most_mps:g} mm/s can be given: are the units right?"
            )
        if long[number]:
            yield f"{where}: a wait of {legs.dwell_s[number]:.6g} s; an hour at most"


@contextmanager
def told_by_line(source: Path, drawn: Drawn, job: JobFile, robot: RobotFile) -> Iterator[None]:
    """Refusals of the job's motion name the line of `source` that is to blame."""
    try:
        yield
    except MotionError as error:
        wrong = error.at_point
        if wrong is None or wrong.point is None:
            raise
        first, spec = _path_of(drawn, job, str(error))
        others = _others(drawn, robot)
        if wrong.point == 0 and first == 0 and drawn.start_line is not None:
            said = f"{source}:{drawn.start_line}: {START}: {wrong.says()}"
            raise error.worded(said + _and_lines(others, drawn.start_line)) from error
        leg = _leg_at(spec, wrong.point)
        if leg is None:
            raise
        way_to = "on the way to the end of " if wrong.on_the_way else ""
        raise error.worded(
            f"{_line(source, drawn, first + leg)}: {way_to}this move: {wrong.says()}"
            f"{_and_lines(others, _number(drawn, first + leg))}"
        ) from error


def _path_of(drawn: Drawn, job: JobFile, says: str) -> tuple[int, Way | None]:
    """The path that a refusal is about, and the number of its first leg in the file."""
    if job.steps is None:
        return 0, job.path if isinstance(job.path, Way) else None
    found = _STEP.search(says)
    steps = list(drawn.steps())
    if found is None or not isinstance(span := steps[int(found[1])], tuple):
        return 0, None
    path = getattr(job.steps[int(found[1])], "path", None)
    if not isinstance(path, Way):
        return span[0], None
    if path.start_m is None:
        path = path.model_copy(update={"start_m": tuple(drawn.legs.to_m[span[0] - 1].tolist())})
    return span[0], path


def _leg_at(spec: Way | None, point: int) -> int | None:
    """The leg that leads to a point of a path, from 0."""
    if spec is None or spec.start_m is None:
        return None
    path = way(np.array(spec.start_m), spec.legs, spec.corner_m, spec.spacing_m)
    if path.leg is None or not 0 <= point < len(path):
        return None
    return int(path.leg[point])


def ends_reached(robot: RobotFile, points_m: FloatArray) -> NDArray[np.bool_]:
    """Whether each place, shape (n, 3), is one where the arms may be."""
    angles_rad = inverse(Linkage.of(robot.geometry), points_m).angles_rad
    low_rad, high_rad = np.deg2rad(robot.limits.arm_deg)
    within = (angles_rad >= low_rad) & (angles_rad <= high_rad)  # NaN is out of reach
    reached: NDArray[np.bool_] = within.all(axis=1)
    return reached


def _others(drawn: Drawn, robot: RobotFile) -> list[int]:
    """Lines of all moves that end where the arms may not be."""
    reached = ends_reached(robot, drawn.legs.to_m)
    return list(dict.fromkeys(_number(drawn, leg) for leg in np.flatnonzero(~reached).tolist()))


def _and_lines(lines: list[int], told: int) -> str:
    others = [line for line in lines if line != told]
    if not others:
        return ""
    shown = ", ".join(str(line) for line in others[:_MOST_LINES])
    more = len(others) - _MOST_LINES
    moves = "line" if len(others) == 1 else "lines"
    return f" (so too {moves} {shown}{f' and {more} more' if more > 0 else ''})"


def _named(source: Path, drawn: Drawn, says: str) -> str:
    found = _LEG.search(says)
    if found is None:
        return f"{source}: {says}"
    leg, wrong = int(found[1]), says[found.end() :].lstrip(".: ")
    if step := _STEP.search(says):
        span = list(drawn.steps())[int(step[1])]
        leg += span[0] if isinstance(span, tuple) else 0
    return f"{_line(source, drawn, leg)}: {wrong}"


def _beyond(place_m: tuple[float, ...]) -> str:
    place = " ".join(f"{1e3 * value:.6g}" for value in place_m)
    return f"at {place} mm, beyond the reach of any arm; are the units right?"


def _number(drawn: Drawn, leg: int) -> int:
    return drawn.lines[leg] if leg < len(drawn.lines) else 0


def _line(source: Path, drawn: Drawn, leg: int) -> str:
    return (
        f"{source}:{drawn.lines[leg]}" if leg < len(drawn.lines) else f"{source}, point {leg + 2}"
    )


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
        except MotionError:  # the robot file itself is wrong
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
