"""Vectors of three in plain floats, as numpy calls cost more; and sines of many angles."""

from __future__ import annotations

import math

import numpy as np

from deltactl.models.robot import FloatArray

Vector = tuple[float, float, float]
"""A place, a direction, or one number for each arm."""


def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def less(a: Vector, b: Vector) -> Vector:
    """From b to a."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def times(a: Vector, factor: float) -> Vector:
    """So many times as long."""
    return a[0] * factor, a[1] * factor, a[2] * factor


def unit(a: Vector) -> Vector:
    """Unit vectors in the same directions; no zero vector is taken."""
    return times(a, 1.0 / math.hypot(*a))


def cosine_and_sine(angle_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Both from the tangent of half the angle, to the last digit but one (of 1, not of each).

    NumPy has the tangent in vectors on processors that have registers for it, sine and cosine
    not: four times as fast there, and no slower elsewhere.
    """
    half = np.tan(0.5 * angle_rad)
    square = half * half
    whole = 1.0 / (1.0 + square)
    return (1.0 - square) * whole, 2.0 * half * whole
