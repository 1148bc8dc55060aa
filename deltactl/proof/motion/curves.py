"""Level circles, hearts and spirals, as the controller of Zhao 2023 draws them: point by point."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from deltactl.proof.motion.inverse import arm_angles
from deltactl.proof.robot.as_built import Body, FloatArray, Joints
from deltactl.proof.robot.stepping import IntArray, StepTrain, cut, together

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
