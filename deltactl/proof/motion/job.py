"""A job (as `deltactl run` takes it) as step counts: so that this robot can run what was proposed.

Own, smaller code than the planner's: all motors step together at the job's T_PWM; a job with
`mode: accelerated` runs at 2 ms.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from deltactl.foundation.errors import ConfigError
from deltactl.proof.motion.curves import SHAPES, to_counts
from deltactl.proof.motion.inverse import arm_angles
from deltactl.proof.motion.survey import HIGHEST, LOWEST
from deltactl.proof.robot.as_built import Body, FloatArray
from deltactl.proof.robot.stepping import IntArray, StepTrain, together

USUAL_T_PWM_S = 0.002
SPACING_M = 0.0015
Path = tuple[IntArray, FloatArray]


def from_job(job: dict[str, Any]) -> StepTrain:
    """Counts over time. Raises ConfigError for a shape it does not know, or an unreachable point
    as UnreachablePoint."""
    path = job["path"]
    shape = path["shape"]
    if shape in SHAPES:
        targets, dwells = _curve(path)
    elif shape in ("points", "joints", "survey"):
        targets, dwells = {"points": _points, "joints": _joints, "survey": _survey}[shape](path)
    else:
        raise ConfigError(f"the proposed job's path has shape '{shape}', which is unknown here")
    t_pwm_s = float(job.get("timing", {}).get("t_pwm_s", USUAL_T_PWM_S))
    repeats = int(job.get("repeats", 1))
    return together(targets[0], np.tile(targets, (repeats, 1)), np.tile(dwells, repeats), t_pwm_s)


def _curve(path: dict[str, Any]) -> Path:
    shape, turns = path["shape"], float(path.get("turns", 1))
    size_m = {
        "circle": path.get("radius_m", 0.0),
        "heart": 0.5 * path.get("width_m", 0.0),
        "spiral": path.get("outer_radius_m", 0.0),
    }[shape]
    laps = 1 if shape == "spiral" else max(1, round(abs(turns)))
    coarse = SHAPES[shape](np.linspace(0.0, 1.0, 721), size_m)
    length_m = float(np.linalg.norm(np.diff(coarse, axis=0), axis=1).sum())
    turn = np.tile(np.linspace(0.0, 1.0, max(60, round(length_m / SPACING_M)) + 1), laps)
    plane = SHAPES[shape](turn[::-1] if turns < 0 else turn, size_m)
    points = np.column_stack([plane, np.zeros(len(plane))]) + np.asarray(path["centre_m"])
    return to_counts(arm_angles(points, Body())), np.zeros(len(points))


def _points(path: dict[str, Any]) -> Path:
    corners = np.asarray(path["points_m"], dtype=float)
    pieces, dwells = [corners[:1]], [np.array([_dwell(path)])]
    for start, end in itertools.pairwise(corners):
        count = max(1, int(np.ceil(np.linalg.norm(end - start) / SPACING_M)))
        share = np.arange(1, count + 1)[:, None] / count
        pieces.append(start + share * (end - start))
        dwells.append(np.append(np.zeros(count - 1), _dwell(path)))
    return to_counts(arm_angles(np.concatenate(pieces), Body())), np.concatenate(dwells)


def _joints(path: dict[str, Any]) -> Path:
    angles = np.radians(np.asarray(path["angles_deg"], dtype=float))
    corners = to_counts(angles)
    pieces, dwells = [corners[:1]], [np.array([_dwell(path)])]
    for start, end in itertools.pairwise(corners):
        # A straight line in joint space: the motor with most steps sets the pace.
        count = max(1, int(np.abs(end - start).max()))
        share = np.arange(1, count + 1)[:, None] / count
        pieces.append(np.rint(start + share * (end - start)).astype(np.int64))
        dwells.append(np.append(np.zeros(count - 1), _dwell(path)))
    return np.concatenate(pieces), np.concatenate(dwells)


def _survey(path: dict[str, Any]) -> Path:
    low, high = to_counts(np.radians(np.asarray(path.get("angle_deg", (0.0, 75.0)), dtype=float)))
    rng = np.random.default_rng(int(path.get("seed", 1)))
    shape = (int(path["count"]), 3)
    counts = rng.integers(max(low, LOWEST), min(high, HIGHEST) + 1, shape)
    return counts, np.full(shape[0], _dwell(path))


def _dwell(path: dict[str, Any]) -> float:
    return float(path.get("dwell_s", 0.0))
