"""Robots of a fleet, simulated by code of its own: nothing of models/ is used here.

A geared axis is a backlash operator, a ratio and white noise. A delta is three spheres about the
elbows that meet at the platform, found by elimination; its gears have play, its arms may be
of another length than the robot file says, its ranging sensors round to millimetres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

RAD_PER_STEP = 2.0 * math.pi / 16_000
AXIS_SPAN_S, AXIS_PERIOD_S, AXIS_NOISE_RAD = 12.0, 0.02, 2e-4
DELTA_SPAN_S, DELTA_PERIOD_S, RANGE_NOISE_M, RANGE_STEP_M = 30.0, 0.02, 1.5e-3, 1e-3
BASE_M, PLATFORM_M, UPPER_M, FOREARM_M = 0.325, 0.075, 0.25, 0.5
FloatArray = np.ndarray[Any, np.dtype[np.float64]]
OFFSETS_M = np.array([0.6, 0.6, 0.9])

AXIS_FILE = """kind: stepper_axis
name: {name}
zero: arbitrary
drive: {{microsteps_per_rev: 1600, gear_ratio: 10}}
"""
DELTA_FILE = """kind: delta
name: {name}
geometry: {{base_radius_m: 0.325, platform_radius_m: 0.075, upper_arm_m: 0.25, forearm_m: 0.5}}
masses: {{upper_arm_kg: 0.205, forearm_kg: 0.153, platform_kg: 0.653}}
drive: {{microsteps_per_rev: 1600, gear_ratio: 10}}
sensors:
  x: {{offset_m: 0.60, axis: [1, 0, 0]}}
  y: {{offset_m: 0.60, axis: [0, 1, 0]}}
  z: {{offset_m: 0.90, axis: [0, 0, 1]}}
"""


@dataclass(frozen=True)
class Concealed:
    """What a machine has that its file leaves out."""

    play_rad: float = 0.0
    """In the gearbox of the (first) motor."""
    ratio: float = 1.0
    """For an axis: turned over meant to be turned."""
    arm: float = 1.0
    """For a delta: length of the upper arms over that in the file."""


def play(angles_rad: FloatArray, width_rad: float) -> FloatArray:
    """The classical backlash operator, sample by sample."""
    out, here = np.empty_like(angles_rad), float(angles_rad[0])
    for k, angle in enumerate(angles_rad):
        here = min(max(here, angle - 0.5 * width_rad), angle + 0.5 * width_rad)
        out[k] = here
    return out


def record_axis(path: Path, rng: np.random.Generator, its: Concealed) -> None:
    """Twelve seconds of two sines on a geared axis."""
    t_s = np.arange(0.0, AXIS_SPAN_S, AXIS_PERIOD_S)
    slow, fast = rng.uniform(4.0, 8.0), rng.uniform(1.5, 3.0)
    asked = 0.5 * np.sin(2 * np.pi * t_s / slow) + 0.2 * np.sin(2 * np.pi * t_s / fast)
    steps = np.round(asked / RAD_PER_STEP)
    theta = play(steps * RAD_PER_STEP * its.ratio, its.play_rad)
    theta += AXIS_NOISE_RAD * rng.standard_normal(len(t_s))
    _write(path, "t,steps_1,theta_1", [t_s, steps, theta], ["%.3f", "%d", "%.7f"])


def record_delta(path: Path, rng: np.random.Generator, its: Concealed) -> None:
    """Half a minute of two sines on each arm, ranged at 50 Hz."""
    t_s = np.arange(0.0, DELTA_SPAN_S, DELTA_PERIOD_S)
    period_s, phase = rng.uniform(2.5, 6.0, (2, 3)), rng.uniform(0.0, 2.0 * np.pi, (2, 3))
    waves = np.sin(2 * np.pi * t_s[None, :, None] / period_s[:, None, :] + phase[:, None, :])
    steps = np.round((0.6 + 0.3 * waves[0] + 0.1 * waves[1]) / RAD_PER_STEP)
    arms = steps * RAD_PER_STEP
    arms[:, 0] = play(arms[:, 0], its.play_rad)
    ranges = OFFSETS_M + platform_m(arms, UPPER_M * its.arm)
    ranges += RANGE_NOISE_M * rng.standard_normal(ranges.shape)
    ranges = np.round(ranges / RANGE_STEP_M) * RANGE_STEP_M
    head, formats = (
        "t,steps_1,steps_2,steps_3,range_x,range_y,range_z",
        "%.3f %d %d %d %.3f %.3f %.3f",
    )
    _write(path, head, [t_s, steps, ranges], formats.split())


def _write(path: Path, head: str, columns: list[FloatArray], formats: list[str]) -> None:
    table = np.column_stack(columns)
    np.savetxt(path, table, fmt=formats, delimiter=",", comments="", header=head)


def platform_m(arms_rad: FloatArray, upper_m: float) -> FloatArray:
    """Where three spheres of the forearm's length about the elbows meet below; shape (n, 3)."""
    turn = np.radians([0.0, 120.0, 240.0])
    out = BASE_M - PLATFORM_M + upper_m * np.cos(arms_rad)
    centres = np.stack(
        [out * np.cos(turn), out * np.sin(turn), -upper_m * np.sin(arms_rad)], axis=-1
    )
    square = (centres**2).sum(axis=-1)
    # Differences of the spheres are two planes: x and y are straight lines in z.
    lines = 2.0 * (centres[:, 1:, :2] - centres[:, :1, :2])
    constant = square[:, 1:] - square[:, :1]
    slope = -2.0 * (centres[:, 1:, 2] - centres[:, :1, 2])
    at = np.linalg.solve(lines, np.stack([constant, slope], axis=-1))
    start = np.concatenate([at[..., 0], np.zeros((len(at), 1))], axis=1) - centres[:, 0]
    along = np.concatenate([at[..., 1], np.ones((len(at), 1))], axis=1)
    a, b = (along**2).sum(axis=1), (start * along).sum(axis=1)
    z = (-b - np.sqrt(b**2 - a * ((start**2).sum(axis=1) - FOREARM_M**2))) / a
    place: FloatArray = centres[:, 0] + start + along * z[:, None]
    return place
