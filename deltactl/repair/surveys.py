"""How long the survey of a healing has to be, and the survey as a job.

A first one is as long as many small errors of building ask for at this noise. What is found in it
has intervals: where these, moved through the job, leave more than is wanted, another one follows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.job_targets import kinematics_of
from deltactl.firmware_py.planner.plan import home_counts, make_plan, plan_of
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.program.coverage import coverage_of
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.clock import NS_PER_S
from deltactl.foundation.errors import ConfigError, MotionError
from deltactl.models.effects import VOCABULARY, Trait, effect_kind, with_trait
from deltactl.models.linkage import Linkage, forward, neighbours
from deltactl.models.robot import AXES, FloatArray
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import read_flat
from deltactl.repair.limit import limit_of
from deltactl.repair.played import Paths, Played

SIZES = 40
"""As many small errors of building as a survey has to tell apart."""
READINGS_PER_S = 150.0
SURVEY_S = (120.0, 300.0)
LEAST_WANTED_M = 5e-5
MOST_OPEN_M = 7.5e-5
"""Another survey follows where sizes leave more open, by one standard deviation: at twice that a
job is 0.15 mm from its path."""
POSE_S = 6.6
"""Mean time to a random pose and at it, at the speed of a survey."""
LEAST_POSES = 4
MOST_TRIED, ALMOST = 4, 0.95
"""A survey takes this share of its time at least, as soon as so many tries have found one."""
SURVEY_RADPS, DWELL_S = 0.2, 0.4
STEP_DEG, PLACES = 1.0, 5
"""How low arms may go is searched in such steps, at so many angles of each arm."""
EXPLAINED = ("explained", "nothing_missing")
"""Verdicts that leave nothing to look for."""
SWINGS_S = 1.0
"""Arms that follow late are pressed so long after the command, or before."""
RANGES = tuple(f"range_{axis}" for axis in "xyz")
PAIRS = 2
"""Drawings by each file that a survey leaves time for: one may not tell which is nearer."""
MOST_ROBOT_S, WORTH_S = 600.0, 60.0
"""A healing moves the robot no longer; less than the second of another survey changes nothing."""


def first_s(job: Path, robot_file: Path, noise_m: float) -> float:
    """So long that noise leaves the wanted accuracy, if it is the limit of the job [s].

    Raises MotionError where the job cannot be planned.
    """
    limit = limit_of(plan_of(job, load_robot(robot_file)), coverage_of(job, robot_file))
    wanted_m = max(LEAST_WANTED_M, 0.0 if limit is None else limit.rms_m)
    return min(max(SIZES * (noise_m / wanted_m) ** 2 / READINGS_PER_S, SURVEY_S[0]), SURVEY_S[1])


def more_s(job: Path, paths: Paths, corrected: Path, surveyed_s: float, robot_s: float) -> float:
    """How long another survey has to be for the sizes in a corrected file [s]; 0 for none.

    Their intervals are moved through the job, and shrink with the root of the time. surveyed_s,
    robot_s: how long was surveyed, and how long the robot has moved in all.
    """
    try:
        plan, path = paths.of(load_robot(corrected))
        limit = limit_of(plan, coverage_of(job, corrected))
    except (ConfigError, MotionError):
        return 0.0  # what cannot be followed is refused later, with its reason
    if limit is None:
        return 0.0
    wanted_s = surveyed_s * ((limit.sizes_m / MOST_OPEN_M) ** 2 - 1.0)
    more_s = min(wanted_s, left_s(robot_s, path))
    return more_s if more_s > WORTH_S else 0.0


def left_s(robot_s: float, path: Played, times: int = PAIRS) -> float:
    """How long the robot may still move before the job is drawn by both files so often [s]."""
    return MOST_ROBOT_S - robot_s - 2.0 * times * path.seconds


def heights_in_the_way(answer: Diagnosis) -> list[float]:
    """Where something stopped the platform while it was surveyed [m]."""
    found = [one for one in answer.findings if one.effect in with_trait(Trait.IN_THE_WAY)]
    sizes = [one.parameters[effect_kind(one.effect).main.name].value for one in found]
    return [size for size in sizes if isinstance(size, float)]


def of_one_run(finding: Finding) -> bool:
    """Whether it happened once or was in the way: another run need not meet it."""
    kind = VOCABULARY.get(finding.effect)
    return kind is not None and (kind.event or finding.effect in with_trait(Trait.IN_THE_WAY))


def settled(answer: Diagnosis) -> bool:
    """Whether it leaves nothing to look for."""
    return answer.verdict in EXPLAINED


def of_the_later(answer: Diagnosis, later: Diagnosis) -> Diagnosis:
    """The answer of later recordings, where it leaves less open than that of all of them.

    What happened in the first, or was in the way, is still to be looked at.
    """
    if not settled(later):
        return answer
    found = {(one.effect, one.component) for one in later.findings}
    met = [one for one in answer.findings if of_one_run(one)]
    more = [one for one in met if (one.effect, one.component) not in found]
    return later.model_copy(update={"findings": [*later.findings, *more]})


def open_s(answer: Diagnosis, surveyed_s: float, most_s: float) -> float:
    """How long another survey has to be where the first left something open [s]; 0 for none.

    As long as the first: what happened in it, or pressed the arms, hides what else is wrong.
    """
    more_s = 0.0 if answer.verdict in EXPLAINED else min(surveyed_s, most_s)
    return more_s if more_s > WORTH_S else 0.0


def _lowest_m(linkage: Linkage, angles_rad: FloatArray) -> FloatArray:
    """Height of the platform at angles (n, 3), the lowest of machines as far off as faulty ones may
    be, (n,).
    """
    machines = [linkage, *neighbours(linkage)]
    heights = [forward(one, angles_rad).position_m[:, 2] for one in machines]
    lowest_m: FloatArray = np.fmin.reduce(heights)
    return lowest_m


def highest_deg(robot: RobotFile, above_m: float) -> float:
    """Arms that go no lower than this keep the platform above a height.

    Also those of machines as far off as faulty ones may be. Raises MotionError where none do.
    """
    low, high = robot.limits.arm_deg
    linkage = Linkage.of(robot.geometry)
    for end in np.arange(high, low, -STEP_DEG):
        places = np.deg2rad(np.linspace(low, end, PLACES))
        angles_rad = np.stack(np.meshgrid(places, places, places), axis=-1).reshape(-1, len(AXES))
        if np.nanmin(_lowest_m(linkage, angles_rad)) > above_m:
            return float(end)
    raise MotionError(f"no survey keeps above {above_m * 1e3:.0f} mm, where something stops it")


def read_above(robot: RobotFile, above_m: Sequence[float]) -> Callable[[Path], FlatRecording]:
    """Reads recordings without what the sensors saw while something was in the way.

    above_m: its heights; commands are kept, and what follows from them.
    """

    def read(path: Path) -> FlatRecording:
        table = read_flat(path)
        counts = np.nan_to_num(table.side_by_side(f"steps_{motor}" for motor in (1, 2, 3)))
        low_m = _lowest_m(Linkage.of(robot.geometry), counts * robot.drive.rad_per_step)
        pressed_s = table.t_s[~(low_m > max(above_m))]
        near = np.searchsorted(pressed_s, table.t_s - SWINGS_S)
        seen = near == np.searchsorted(pressed_s, table.t_s + SWINGS_S, side="right")
        ranges = {name: np.where(seen, table.column(name), np.nan) for name in RANGES}
        return replace(table, columns=table.columns | ranges)

    return read


def survey_in(
    seconds: float, robot: RobotFile, robot_file: Path, seed: int, above_m: Sequence[float] = ()
) -> dict[str, Any]:
    """A survey of this length, as a job (see `survey_job`); where there is less room, poses are
    nearer to each other, and there are more of them.
    """
    poses = round(seconds / POSE_S)
    for _ in range(MOST_TRIED):
        survey = survey_job(robot, robot_file, max(LEAST_POSES, poses), seed, above_m)
        job = JobFile.model_validate(survey)
        plan = make_plan(job, robot, kinematics_of(job, robot, robot_file))
        took_s = MotionStream(plan, home_counts(robot)).end_ns / NS_PER_S
        if ALMOST * seconds <= took_s <= seconds:
            break
        poses = round(poses * 0.5 * (ALMOST + 1.0) * seconds / took_s)
    return survey


def survey_job(
    robot: RobotFile, robot_file: Path, poses: int, seed: int, above_m: Sequence[float] = ()
) -> dict[str, Any]:
    """Random poses within the limits of the robot file, slowly, as a job.

    above_m: heights of what is in the way. Raises MotionError where that leaves no room.
    """
    low, high = robot.limits.arm_deg
    high = min([high, *(highest_deg(robot, one) for one in above_m)])
    return {
        "name": "survey",
        "robot": str(robot_file.resolve()),
        "path": {
            "shape": "survey",
            "count": poses,
            "angle_deg": (low, high),
            "dwell_s": DWELL_S,
            "seed": seed,
        },
        "timing": {"mode": "together", "t_pwm_s": robot.drive.rad_per_step / SURVEY_RADPS},
        "inverse_kinematics": {"kind": "geometry"},
    }
