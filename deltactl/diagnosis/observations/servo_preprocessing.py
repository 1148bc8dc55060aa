"""Recordings of a servo delta as motions and disturbances at an even, slower pace.

The observer's estimate carries the encoder's steps at full rate; means over 10 ms carry little of
them. The same means are taken of what the model predicts, so they favour no answer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation

from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import (
    BoolArray,
    FloatArray,
    IntArray,
    smoothly_bridged,
    starts_of,
)
from deltactl.foundation.scatter import MAD_TO_SIGMA
from deltactl.models.chain.servo_delta import Motion, ServoChain
from deltactl.recording.column_measures import first_of
from deltactl.recording.tables.flat import FlatRecording

JOINTS = (1, 2, 3)
OUTSIDE = [f"{stem}_{axis}" for stem in ("range", "pos") for axis in "xyz"]
INSIDE = ("theta_", "steps_", "command_", "current_", "disturbance_")
STATUS = ("status_",)


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
    moving: float
    """Share of the samples in which a joint moves fast enough for its friction to show,"""
    twitching_radps: float
    """and the speed below which encoder steps hide it."""

    def means(self, values: FloatArray) -> FloatArray:
        """(n, 3) at full pace to (m, 3)."""
        blocks: FloatArray = values[self.rows].mean(axis=1)
        return blocks


def reads_disturbance(recording: FlatRecording) -> bool:
    """Whether angles and either disturbances or currents of all joints are there."""

    def known(stem: str) -> bool:
        return all(first_of(recording, [f"{stem}_{joint}"]) for joint in JOINTS)

    return known("theta") and (known("disturbance") or known("current"))


def estimates_disturbance(recording: FlatRecording) -> bool:
    """Whether the drives recorded what their observers estimate."""
    return recording.has(*(f"disturbance_{joint}" for joint in JOINTS))


def signals_of(recording: FlatRecording, chain: ServoChain) -> Signals:
    """Signals from columns that `admission` has found complete."""
    angle = _three(recording, "theta")
    fresh = starts_of(recording)
    step_s = float(np.median(np.diff(recording.t_s)))
    motion, noise = _motion(recording.t_s, angle, fresh, step_s)
    observed = _observed(recording, chain, motion)
    drive = chain.drive
    twitching = OBSERVATIONS.dithered * drive.rad_per_count * drive.disturbance_bandwidth_radps
    share = OBSERVATIONS.slowest_share * np.abs(motion.speed_radps).max(axis=0)
    still = np.maximum(OBSERVATIONS.at_rest * noise, share)
    slow = np.abs(motion.speed_radps) < np.maximum(still, twitching)
    around, smoothed = (
        2 * int(margin_s / step_s) + 1
        for margin_s in (OBSERVATIONS.around_rest_s, OBSERVATIONS.smoothing_s)
    )
    near = binary_dilation(slow, np.ones((around, 1), dtype=bool))
    edge = binary_dilation(fresh, np.ones(smoothed, dtype=bool))
    usable = ~near & ~edge[:, None] & np.isfinite(observed) & np.isfinite(angle)
    size = max(1, round(OBSERVATIONS.means_s / step_s))
    return Signals(
        *_in_blocks(motion, np.nan_to_num(observed), usable, size),
        float((~near).any(axis=1).mean()),
        twitching,
    )


def _in_blocks(
    motion: Motion, observed: FloatArray, usable: BoolArray, size: int
) -> tuple[Motion, FloatArray, BoolArray, FloatArray, BoolArray, IntArray]:
    """The first fields of `Signals`."""
    starts = np.flatnonzero(motion.fresh)
    firsts = [
        np.arange(first, last - size + 1, size)
        for first, last in zip(starts, [*starts[1:], len(motion.t_s)], strict=True)
    ]
    rows = np.concatenate(firsts)[:, None] + np.arange(size)
    fresh = np.concatenate([np.arange(len(one)) == 0 for one in firsts])
    means, whole = observed[rows].mean(axis=1), usable[rows].all(axis=1)
    return motion, means, whole, motion.t_s[rows].mean(axis=1), fresh, rows


def _observed(recording: FlatRecording, chain: ServoChain, motion: Motion) -> FloatArray:
    """The disturbance at the arm, (n, 3); from the currents where no estimate was recorded."""
    if estimates_disturbance(recording):
        return chain.torque_per_ampere_nm * _three(recording, "disturbance")
    drive = chain.drive
    nominal = drive.gear_ratio**2 * drive.nominal_inertia_kgm2
    return (
        chain.torque_per_ampere_nm * _three(recording, "current")
        - nominal * motion.acceleration_radps2
    )


def _three(recording: FlatRecording, stem: str) -> FloatArray:
    return np.stack([smoothly_bridged(recording, f"{stem}_{joint}") for joint in JOINTS], axis=1)


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


def sensor_rounds(recording: FlatRecording) -> FlatRecording | None:
    """Rounds of the sensors, with measured angles in place of commands.

    Between two readings of a sensor come many samples of the loop, and each sensor's readings
    are in rows of their own: they are brought to the rows of the one that was read most.
    """
    columns = recording.columns
    seen = {name: np.flatnonzero(np.isfinite(columns[name])) for name in OUTSIDE if name in columns}
    seen = {name: rows for name, rows in seen.items() if len(rows) >= OBSERVATIONS.fewest_outside}
    if not seen:
        return None
    base = max(seen.values(), key=len)
    table = {
        name: values[base]
        for name, values in columns.items()
        if not name.startswith((*OUTSIDE, *INSIDE, *STATUS))
    }
    extra = {name: values[base] for name, values in recording.extra.items()}
    half_s = 0.5 * float(np.median(np.diff(recording.t_s[base])))
    for name, rows in seen.items():
        chosen, near = _nearest(recording.t_s, base, rows, half_s)
        beside = {name: table, name.replace("range_", "status_"): table}
        beside[name.replace("range_", "t_")] = extra
        for other, into in beside.items():
            source = columns.get(other, recording.extra.get(other))
            if source is not None:
                into[other] = np.where(near, source[chosen], np.nan)
    for joint in JOINTS:
        table[f"command_{joint}"] = columns[f"theta_{joint}"][base]
    return FlatRecording(recording.t_s[base], table, extra, recording.source)


def _nearest(
    t_s: FloatArray, base: IntArray, rows: IntArray, most_s: float
) -> tuple[IntArray, BoolArray]:
    """For each of the `base` rows the nearest of `rows`, and whether it is near enough."""
    after = np.clip(np.searchsorted(rows, base), 1, len(rows) - 1)
    before_s = np.abs(t_s[rows[after - 1]] - t_s[base])
    chosen = np.where(before_s <= np.abs(t_s[rows[after]] - t_s[base]), after - 1, after)
    nearest: IntArray = rows[chosen]
    return nearest, np.abs(t_s[nearest] - t_s[base]) <= most_s
