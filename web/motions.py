"""Small jobs that the page makes itself: go to a point, go to arm angles."""

from __future__ import annotations

from typing import Any

import yaml

from models.linkage.vectors import Vector


def to_point(robot_file: str, position_m: Vector, name: str = "go-to") -> str:
    """A job that brings the platform to a point [m] in the robot's frame."""
    point = [round(value, 7) for value in position_m]
    return _job(name, robot_file, {"shape": "points", "points_m": [point]})


def to_angles(robot_file: str, angles_deg: Vector, name: str = "jog") -> str:
    """A job that brings the arms to angles [degrees]."""
    angles = [round(value, 6) for value in angles_deg]
    return _job(name, robot_file, {"shape": "joints", "angles_deg": [angles]})


def _job(name: str, robot_file: str, path: dict[str, Any]) -> str:
    job = {
        "name": name,
        "robot": robot_file,
        "path": path,
        "timing": {"mode": "accelerated", "speed_mps": 0.1},
        "inverse_kinematics": {"kind": "geometry"},
    }
    return yaml.safe_dump(job, sort_keys=False)
