"""Recordings of a lone machine from which nothing can be told get one line, never a diagnosis."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.lone.commanded_axis import CommandedAxis
from deltactl.diagnosis.plants.lone.forced_axis import ForcedAxis
from deltactl.foundation.errors import RecordingError
from deltactl.recording.tables.flat import FlatRecording

FACTORS = {
    **{10.0**k: f"a power of ten ({10.0**k:g})" for k in (-6, -4, -3, -2, 2, 3, 4, 6)},
    180.0 / np.pi: "degrees in place of radians (57.3)",
    np.pi / 180.0: "radians in place of degrees (1 / 57.3)",
}
"""Factors that a wrong unit makes."""


def check_times(recording: FlatRecording) -> None:
    """Refuse times that are no seconds. Raises RecordingError."""
    shortest_s, longest_s = ADMISSION.times_s
    period_s = float(np.median(np.diff(recording.t_s))) if len(recording) > 1 else shortest_s
    if shortest_s <= period_s <= longest_s:
        return
    unit = "is it in ms or us?" if period_s > longest_s else "was another unit given for it?"
    raise RecordingError(
        f"{recording.source}: samples are {period_s:g} s apart; t must be in seconds ({unit})"
    )


def check_direction(plant: CommandedAxis, source: str) -> None:
    """Refuse a reading that runs against what it should follow. Raises RecordingError."""
    seen, expected = plant.observed[plant.rows], plant.nominal[plant.rows]
    if np.ptp(expected) > 0.0 and np.ptp(seen) > 0.0:
        alike = float(np.corrcoef(expected, seen)[0, 1])
        if alike < ADMISSION.against:
            raise RecordingError(
                f"{source}: {plant.name} moves against its command (correlation {alike:.2f}); "
                "is a sign or a column wrong?"
            )


def check_order(plant: CommandedAxis, source: str) -> None:
    """Refuse a reading that moves before its command does. Raises RecordingError."""
    for part in plant.parts:
        known = np.asarray(part, dtype=bool) & plant.readings.valid[:, 0]
        ahead_s = lead_s(plant.t_s[known], plant.commanded[known], plant.observed[known])
        if ahead_s > 0.0:
            raise RecordingError(
                f"{source}: {plant.name} moves {ahead_s:.2g} s before its command does; are the "
                "two columns swapped, or their times those of two clocks?"
            )


def lead_s(t_s: FloatArray, commanded: FloatArray, observed: FloatArray) -> float:
    """By how long a reading (n,) leads its command (n,); 0 where it does not."""
    most_s = min(ADMISSION.most_ahead_s, 0.1 * float(np.ptp(t_s)))
    period_s = float(np.median(np.diff(t_s)))
    inside = (t_s > t_s[0] + most_s) & (t_s < t_s[-1] - most_s)
    if not 0.0 < period_s < most_s or inside.sum() < ADMISSION.fewest_valid:
        return 0.0
    seen = observed[inside]

    def left(shift_s: float) -> float:
        told = np.interp(t_s[inside] - shift_s, t_s, commanded)
        shapes = np.column_stack([told, np.ones(len(told))])
        return float(np.std(seen - shapes @ np.linalg.lstsq(shapes, seen, rcond=None)[0]))

    shifts = np.geomspace(period_s, most_s, ADMISSION.shifts)
    later = min(left(shift) for shift in (0.0, *shifts))
    earlier = [left(-shift) for shift in shifts]
    best = int(np.argmin(earlier))
    return float(shifts[best]) if earlier[best] < ADMISSION.ahead * later else 0.0


def _check_power(plant: ForcedAxis, needed: FloatArray, velocity: FloatArray) -> None:
    """Refuse an effort that always brakes: on the way there and back friction takes power up.

    needed, velocity: (m,), of the rows that count. Raises RecordingError.
    """
    ways = [float(np.mean(velocity > 0.0)), float(np.mean(velocity < 0.0))]
    size = float(np.sqrt(np.mean(needed**2) * np.mean(velocity**2)))
    if min(ways) < ADMISSION.least_each_way or size <= 0.0:
        return
    if float(np.mean(needed * velocity)) < ADMISSION.brakes * size:
        raise RecordingError(
            f"{plant.source}: the axis moves against its effort nearly all the time, whichever way"
            " it goes, as if friction pushed it; is the sign of effort, of position or of"
            " effort_gain wrong?"
        )


def check_force(plant: ForcedAxis) -> None:
    """Refuse effort of the wrong sign, and a mass that only another unit explains.

    The mass is fitted without a prior beside friction and a constant: where friction rules it is
    hardly known, and nothing is refused. Raises RecordingError.
    """
    if plant.let_go:
        return
    motion, rows = plant.motion, plant.rows
    needed = plant.observed + plant.inertia * motion.acceleration
    _check_power(plant, needed[rows], motion.velocity[rows])
    shapes = np.stack(
        [motion.acceleration, motion.velocity, np.sign(motion.velocity), np.ones_like(needed)],
        axis=1,
    )[rows]
    scale = np.maximum(np.abs(shapes).max(axis=0), 1e-300)
    size, *_ = np.linalg.lstsq(shapes / scale, needed[rows], rcond=1e-10)
    left = needed[rows] - shapes / scale @ size
    inverse = np.linalg.pinv((shapes / scale).T @ (shapes / scale), hermitian=True)
    # Rows stand a filter's memory apart; what is left is still correlated over several.
    error = float(np.sqrt(inverse[0, 0] * np.mean(left**2) * ADMISSION.correlated)) / scale[0]
    ratio, error = float(size[0] / scale[0]) / plant.inertia, error / plant.inertia
    if abs(ratio - 1.0) < ADMISSION.sure_of_mass * error:
        return
    for factor, words in FACTORS.items():
        known = error < ADMISSION.known_mass * abs(ratio)
        if known and abs(abs(ratio) / factor - 1.0) < ADMISSION.near_factor:
            raise RecordingError(
                f"{plant.source}: the effort moves {abs(ratio):.3g} times the inertia that the "
                f"robot file gives: {words}; are the units of effort, position or inertia wrong?"
            )
    if ratio < ADMISSION.least_against and ratio < -ADMISSION.sure_of_mass * error:
        raise RecordingError(
            f"{plant.source}: the axis accelerates against its effort ({ratio:.2f} times the "
            "inertia of the robot file); is the sign of effort, of position or of effort_gain "
            "wrong, or does a weight pull at it that the file does not say (`gravity`; "
            "'deltactl init' has --hanging-nm for it)?"
        )
