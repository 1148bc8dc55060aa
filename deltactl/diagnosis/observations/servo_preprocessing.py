"""Recordings of a servo delta as motions and disturbances at an even, slower pace.

The observer's estimate carries the encoder's steps at full rate; means over 10 ms carry little of
them. The same means are taken of what the model predicts, so they favour no answer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation

from deltactl.diagnosis.observations.needed_columns import MAPPING, filled
from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import (
    BoolArray,
    FloatArray,
    IntArray,
    starts_of,
)
from deltactl.foundation.errors import MissingColumns, RecordingError
from deltactl.foundation.scatter import MAD_TO_SIGMA
from deltactl.models.chain.servo_delta import Motion, ServoChain
from deltactl.recording.tables.flat import FlatRecording

JOINTS = (1, 2, 3)


@dataclass(frozen=True, slots=True, eq=False)
class Signals:
    """One recording: its motion at full pace, what was observed, and which blocks count.

    block: first row of each block (and the end); observed_nm, valid: a row a block, (m, 3).
    """

    motion: Motion
    observed_nm: FloatArray
    valid: BoolArray
    t_s: FloatArray
    fresh: BoolArray
    rows: IntArray
    """Rows of the motion that make each block, (m, k)."""

    def means(self, values: FloatArray) -> FloatArray:
        """(n, 3) at full pace to (m, 3)."""
        blocks: FloatArray = values[self.rows].mean(axis=1)
        return blocks


def reads_disturbance(recording: FlatRecording) -> bool:
    """Whether angles and either disturbances or currents of all joints are there."""

    def known(stem: str) -> bool:
        names = [f"{stem}_{joint}" for joint in JOINTS]
        return recording.has(*names) and all(
            bool(np.isfinite(recording.columns[name]).any()) for name in names
        )

    return known("theta") and (known("disturbance") or known("current"))


def signals_of(recording: FlatRecording, chain: ServoChain) -> Signals:
    """Raises RecordingError for a recording from which nothing can be told."""
    angle = _three(recording, "theta")
    fresh = starts_of(recording)
    step_s = float(np.median(np.diff(recording.t_s)))
    shortest_s, longest_s = OBSERVATIONS.servo_period_s
    if not shortest_s <= step_s <= longest_s:
        raise RecordingError(
            f"{recording.source}: samples are {step_s:g} s apart; disturbances need "
            f"{1 / longest_s:g} to {1 / shortest_s:g} a second, t in seconds"
        )
    motion, noise = _motion(recording.t_s, angle, fresh, step_s)
    if not np.ptp(angle, axis=0).max() > OBSERVATIONS.least_turn_rad:
        raise RecordingError(
            f"{recording.source}: theta_1..3 never change; nothing can be told from it"
        )
    observed = _observed(recording, chain, motion)
    drive = chain.drive
    twitching = OBSERVATIONS.dithered * drive.rad_per_count * drive.disturbance_bandwidth_radps
    share = OBSERVATIONS.slowest_joint * np.abs(motion.speed_radps).max(axis=0)
    still = np.maximum(OBSERVATIONS.at_rest * noise, share)
    slow = np.abs(motion.speed_radps) < np.maximum(still, twitching)
    around, smoothed = (
        2 * int(margin_s / step_s) + 1
        for margin_s in (OBSERVATIONS.around_rest_s, OBSERVATIONS.smoothing_s)
    )
    near = binary_dilation(slow, np.ones((around, 1), dtype=bool))
    edge = binary_dilation(fresh, np.ones(smoothed, dtype=bool))
    if not np.isfinite(angle).all() or (~near).any(axis=1).mean() < OBSERVATIONS.least_usable:
        raise RecordingError(
            f"{recording.source}: the joints moved faster than {twitching:.2g} rad/s in less than "
            f"{100 * OBSERVATIONS.least_usable:g} % of the time; slower, encoder steps hide what "
            "friction does"
        )
    usable = ~near & ~edge[:, None] & np.isfinite(observed) & np.isfinite(angle)
    size = max(1, round(OBSERVATIONS.means_s / step_s))
    return _in_blocks(motion, np.nan_to_num(observed), usable, size)


def _in_blocks(motion: Motion, observed: FloatArray, usable: BoolArray, size: int) -> Signals:
    starts = np.flatnonzero(motion.fresh)
    firsts = [
        np.arange(first, last - size + 1, size)
        for first, last in zip(starts, [*starts[1:], len(motion.t_s)], strict=True)
    ]
    rows = np.concatenate(firsts)[:, None] + np.arange(size)
    fresh = np.concatenate([np.arange(len(one)) == 0 for one in firsts])
    return Signals(
        motion, observed[rows].mean(axis=1), usable[rows].all(axis=1),
        motion.t_s[rows].mean(axis=1), fresh, rows,
    )  # fmt: skip


def _observed(recording: FlatRecording, chain: ServoChain, motion: Motion) -> FloatArray:
    """The disturbance at the arm, (n, 3); from the currents where no estimate was recorded."""
    names = [f"disturbance_{joint}" for joint in JOINTS]
    if recording.has(*names):
        return chain.torque_per_ampere_nm * _three(recording, "disturbance")
    drive = chain.drive
    nominal = drive.gear_ratio**2 * drive.nominal_inertia_kgm2
    return (
        chain.torque_per_ampere_nm * _three(recording, "current")
        - nominal * motion.acceleration_radps2
    )


def _three(recording: FlatRecording, stem: str) -> FloatArray:
    names = [f"{stem}_{joint}" for joint in JOINTS]
    missing = [name for name in names if name not in recording.columns]
    if missing:
        raise MissingColumns(
            f"{recording.source}: column {missing[0]} is missing; a servo delta needs theta_1..3 "
            f"[rad] and disturbance_1..3 or current_1..3 [A]; {MAPPING}",
            recording.source,
        )
    return np.stack([filled(recording, name) for name in names], axis=1)


def _motion(
    t_s: FloatArray, angle: FloatArray, fresh: BoolArray, step_s: float
) -> tuple[Motion, FloatArray]:
    """Smooth angle, speed and acceleration stretch by stretch; the speeds' noise, (3,)."""
    from scipy.signal import savgol_filter  # takes 0.3 s to import; most runs need none

    degree = OBSERVATIONS.smoothing_degree
    size = max(2 * round(0.5 * OBSERVATIONS.smoothing_s / step_s) + 1, degree + 2)
    size += 1 - size % 2
    third = np.diff(angle, 3, axis=0)
    noise = MAD_TO_SIGMA * np.median(np.abs(third), axis=0) / np.sqrt(20.0)
    half = size // 2
    spread = noise * np.sqrt(3.0 / (half * (half + 1) * (2 * half + 1))) / step_s
    smooth, speed, acceleration = angle.copy(), np.zeros_like(angle), np.zeros_like(angle)
    starts = np.flatnonzero(fresh)
    for first, last in zip(starts, [*starts[1:], len(t_s)], strict=True):
        part = angle[first:last]
        if len(part) <= size:
            continue
        for order, into in enumerate((smooth, speed, acceleration)):
            into[first:last] = savgol_filter(part, size, degree, deriv=order, delta=step_s, axis=0)
    return Motion(t_s, fresh, smooth, speed, acceleration), spread
