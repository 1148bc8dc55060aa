"""How the proof's robot is moved: curves, surveys and jobs, by its own inverse, as counts."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

from deltactl.foundation.errors import ConfigError, UnreachablePoint
from deltactl.proof.robot.as_built import (
    Body,
    FloatArray,
    IntArray,
    Joints,
    StepTrain,
    cut,
    together,
)


def arm_angles(points_m: FloatArray, body: Body) -> FloatArray:
    """Arm angles (n, 3) [rad] for platform positions (n, 3) [m], knees outward.

    Raises UnreachablePoint when a rod cannot reach.
    """
    columns = []
    for arm in range(3):
        azimuth = body.azimuth_rad[arm]
        outward = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        sideways = np.array([-outward[1], outward[0], 0.0])
        radius_m = body.base_radius_m[arm] - body.platform_radius_m[arm]
        # In the arm's plane, seen from its hinge: how far out and how far down the wrist is.
        out = points_m @ outward - radius_m
        down = -points_m[:, 2]
        in_plane = body.forearm_m[arm] ** 2 - (points_m @ sideways) ** 2
        reach = np.hypot(out, down)
        upper = body.upper_arm_m[arm]
        cosine = (upper**2 + reach**2 - in_plane) / (2.0 * upper * reach)
        if not np.all(np.abs(cosine) <= 1.0):
            at = points_m[int(np.argmax(np.abs(cosine)))]
            raise UnreachablePoint(f"arm {arm + 1} cannot reach {np.round(at, 4).tolist()} m")
        columns.append(np.arctan2(down, out) - np.arccos(cosine))
    return np.stack(columns, axis=1)


SPACING_M = 0.0015


def circle(turn: FloatArray, size_m: float) -> FloatArray:
    """Points (n, 2) for turn in [0, 1]."""
    angle = 2.0 * np.pi * turn
    points: FloatArray = size_m * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return points


def heart(turn: FloatArray, size_m: float) -> FloatArray:
    """x = 16 sin^3 t, y = 13 cos t - 5 cos 2t - 2 cos 3t - cos 4t, by half its width."""
    t = 2.0 * np.pi * turn
    y = 13 * np.cos(t) - 5 * np.cos(2 * t) - 2 * np.cos(3 * t) - np.cos(4 * t)
    points: FloatArray = size_m / 16.0 * np.stack([16 * np.sin(t) ** 3, y], axis=1)
    return points


def spiral(turn: FloatArray, size_m: float) -> FloatArray:
    """Three turns outward with growing radius, and the same way back in."""
    out = 1.0 - np.abs(2.0 * turn - 1.0)
    radius = size_m * 0.25 * 4.0**out
    angle = 6.0 * np.pi * out
    points: FloatArray = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    return points


SHAPES: dict[str, Callable[[FloatArray, float], FloatArray]] = {
    "circle": circle,
    "heart": heart,
    "spiral": spiral,
}


def curve(
    shape: str,
    size_m: float,
    height_m: float,
    seconds: float,
    t_pwm_s: float,
    clockwise: bool = False,
) -> StepTrain:
    """Go round and round for `seconds`. Raises UnreachablePoint when it is too large."""
    coarse = SHAPES[shape](np.linspace(0.0, 1.0, 721), size_m)
    length_m = float(np.linalg.norm(np.diff(coarse, axis=0), axis=1).sum())
    turn = np.linspace(0.0, 1.0, max(60, round(length_m / SPACING_M)) + 1)[1:]
    plane = SHAPES[shape](turn[::-1] if clockwise else turn, size_m)
    points = np.column_stack([plane, np.full(len(plane), height_m)])
    counts = to_counts(arm_angles(points, Body()))
    once = together(counts[-1], counts, np.zeros(len(counts)), t_pwm_s)
    rounds = int(np.ceil(seconds / once.seconds))
    lap = once.counts[1:]
    return cut(StepTrain(t_pwm_s, np.concatenate([once.counts[:1], *[lap] * rounds])), seconds)


def to_counts(angles_rad: FloatArray) -> IntArray:
    """Nearest microsteps of the nominal drive."""
    counts: IntArray = np.rint(angles_rad / Joints().rad_per_step).astype(np.int64)
    return counts


LOWEST, HIGHEST = 667, 3333
"""Microsteps: 15 to 75 degrees, where every combination of angles can be assembled, also by a robot
with 6 mm more base radius. With all arms level even the robot of the file is at a singular pose:
a wider one is driven through it and its arm stays flipped, which a machine's end stops prevent."""
DWELLS_S = (0.1, 0.5)
KINDS = ("one", "alike", "all")


def survey(rng: np.random.Generator, seconds: float, t_pwm_s: float) -> StepTrain:
    """A survey of about `seconds`, cut to it."""
    here = rng.integers(1000, 1700, 3)
    targets: list[IntArray] = []
    dwells: list[float] = []
    start, spent = here, 0.0
    while spent < seconds:
        target = _next(rng, here)
        targets.append(target)
        dwells.append(float(rng.uniform(*DWELLS_S)))
        spent += float(np.abs(target - here).max()) * t_pwm_s + dwells[-1]
        here = target
    return cut(together(start, np.array(targets), np.array(dwells), t_pwm_s), seconds)


def _next(rng: np.random.Generator, here: IntArray) -> IntArray:
    kind = rng.choice(KINDS, p=(0.4, 0.2, 0.4))
    if kind == "all":
        return rng.integers(LOWEST, HIGHEST + 1, 3)
    target = here.copy()
    goal = int(rng.integers(LOWEST, HIGHEST + 1))
    if kind == "one":
        target[int(rng.integers(3))] = goal
        return target
    return np.clip(target + goal - int(np.mean(here)), LOWEST, HIGHEST)


USUAL_T_PWM_S = 0.002
Path = tuple[IntArray, FloatArray]


def from_job(job: dict[str, Any]) -> StepTrain:
    """Counts over time. Raises ConfigError for a shape it does not know, or an unreachable point
    as UnreachablePoint."""
    path = job["path"]
    shape = path["shape"]
    if shape in SHAPES:
        targets, dwells = _curve_of_job(path)
    elif shape in ("points", "joints", "survey"):
        targets, dwells = {"points": _points, "joints": _joints, "survey": _survey}[shape](path)
    else:
        raise ConfigError(f"the proposed job's path has shape '{shape}', which is unknown here")
    t_pwm_s = float(job.get("timing", {}).get("t_pwm_s", USUAL_T_PWM_S))
    repeats = int(job.get("repeats", 1))
    return together(targets[0], np.tile(targets, (repeats, 1)), np.tile(dwells, repeats), t_pwm_s)


def _curve_of_job(path: dict[str, Any]) -> Path:
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
