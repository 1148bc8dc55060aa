"""What a job's targets are, and the inverse kinematics that maps them to angles of the arms."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from deltactl.firmware_py.file_access import FileAccess
from deltactl.firmware_py.job_file import CalibratedIk, JobFile, NetworkIk
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.path_file import (
    Circle,
    Heart,
    Joints,
    Points,
    Spiral,
    StraightTo,
    Way,
)
from deltactl.firmware_py.paths.path import Path as Targets
from deltactl.firmware_py.paths.shapes import circle, heart, joints, points, spiral
from deltactl.firmware_py.paths.survey import held, survey
from deltactl.firmware_py.paths.way import way
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import ConfigError
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.inverse_kinematics import GeometricInverse, InverseKinematics
from deltactl.models.linkage import Linkage

USUAL_SPACING_M = 0.0005
"""Spacing for a path of one target, which needs none."""


def path_of(job: JobFile, robot: RobotFile) -> Targets:
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
    spare = held(Linkage.of(robot.geometry), robot.limits.singularity_margin)
    return survey(spare, spec.count, spec.angle_deg, spec.dwell_s, spec.seed)


if TYPE_CHECKING:
    from deltactl.models.network.file import NetworkFile


def network_file(
    chosen: NetworkIk, robot: RobotFile, job_path: Path | None, listing: bool = True
) -> Path:
    """The network a job means, or what the robot file says to take instead. Raises MissingFile."""
    return find(robot.networks.get(chosen.file, chosen.file), job_path, listing)


def read_network(path: Path, how: FileAccess) -> NetworkFile:
    """A network's file, read once. Raises MissingFile, NetworkError."""
    from deltactl.models.network.file import NetworkFile

    return how.once("network file", path, lambda: NetworkFile.load(path, how.follow))


def kinematics_of(
    job: JobFile, robot: RobotFile, job_path: Path | None, how: FileAccess | None = None
) -> InverseKinematics:
    """Geometry and known effects of the robot file, or the network named in the job.

    A network is sought beside `job_path`; how: with which access it is opened. Raises MissingFile,
    NetworkError (also for another robot's network), or ConfigError for a calibrated job of a
    robot file without effects.
    """
    chosen = job.inverse_kinematics
    if isinstance(chosen, NetworkIk):
        # Not at the top: the TFLite runtime takes a third of a second to load.
        from deltactl.models.network import InverseNetwork

        how = how or FileAccess()
        found = read_network(network_file(chosen, robot, job_path, how.follow), how)
        found.check(robot)
        return InverseNetwork(found)
    calibrated = CalibratedInverse(robot)
    if calibrated.effects:
        return calibrated
    if isinstance(chosen, CalibratedIk):
        raise ConfigError(
            f"inverse_kinematics: calibrated: robot '{robot.name}' has no effects in its file that "
            "could be corrected; name a calibrated robot file, or use kind: geometry"
        )
    return GeometricInverse(robot.geometry)
