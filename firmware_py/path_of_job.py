"""The path of a job."""

from __future__ import annotations

import numpy as np

from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.path_file import (
    Circle,
    Heart,
    Joints,
    Points,
    Spiral,
    StraightTo,
    Way,
)
from deltactl.firmware_py.paths.circle import circle
from deltactl.firmware_py.paths.heart import heart
from deltactl.firmware_py.paths.joints import joints
from deltactl.firmware_py.paths.path import Path
from deltactl.firmware_py.paths.points import points
from deltactl.firmware_py.paths.spiral import spiral
from deltactl.firmware_py.paths.survey import survey
from deltactl.firmware_py.paths.way import way
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.linkage import Linkage

USUAL_SPACING_M = 0.0005
"""Of a path of one target, which needs none."""


def path_of(job: JobFile, robot: RobotFile) -> Path:
    """One repeat of the job's path. Raises UnreachablePoint for a survey that finds no poses."""
    spec = job.path
    assert spec is not None
    if isinstance(spec, Circle):
        return circle(spec.centre_m, spec.radius_m, spec.turns, spec.spacing_m)
    if isinstance(spec, Heart):
        return heart(spec.centre_m, spec.width_m, spec.turns, spec.spacing_m)
    if isinstance(spec, Spiral):
        return spiral(
            spec.centre_m, spec.inner_radius_m, spec.outer_radius_m, spec.turns, spec.spacing_m
        )
    if isinstance(spec, Points):
        return points(spec.points_m, spec.dwell_s, spec.spacing_m)
    if isinstance(spec, StraightTo):
        return points([spec.to_m], 0.0, USUAL_SPACING_M)
    if isinstance(spec, Way):
        return way(np.array(spec.start_m), spec.legs, spec.corner_m, spec.spacing_m)
    if isinstance(spec, Joints):
        return joints(spec.angles_deg, spec.dwell_s)
    return survey(
        Linkage.of(robot.geometry),
        spec.count,
        spec.angle_deg,
        spec.dwell_s,
        spec.seed,
        robot.limits.singularity_margin,
    )
