"""How long the survey of a healing has to be, and the survey as a job.

A first one is as long as many small errors of building ask for at this noise. What is found in it
has intervals: where these, moved through the job, leave more than is wanted, another one follows.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from deltactl.firmware_py.planner.plan import plan_of
from deltactl.firmware_py.program.coverage import coverage_of
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.errors import ConfigError, MotionError
from deltactl.repair.limit import limit_of
from deltactl.repair.played import Paths

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
SURVEY_RADPS, DWELL_S = 0.2, 0.4
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
    left_s = MOST_ROBOT_S - robot_s - 2.0 * path.seconds
    return min(wanted_s, left_s) if min(wanted_s, left_s) > WORTH_S else 0.0


def survey_job(robot: RobotFile, robot_file: Path, poses: int, seed: int) -> dict[str, Any]:
    """Random poses within the limits of the robot file, slowly, as a job."""
    low, high = robot.limits.arm_deg
    return {
        "name": "survey",
        "robot": str(robot_file.resolve()),
        "path": {
            "shape": "survey",
            "count": poses,
            "angle_deg": [low, high],
            "dwell_s": DWELL_S,
            "seed": seed,
        },
        "timing": {"mode": "together", "t_pwm_s": robot.drive.rad_per_step / SURVEY_RADPS},
        "inverse_kinematics": {"kind": "geometry"},
    }
