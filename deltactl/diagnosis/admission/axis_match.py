"""Whether an axis moves as its command or effort says: times, signs, order, mass, and, once it is
diagnosed, whether any explanation brings reading and command together.

Sizes are given in degrees or mm, beside how far the axis moved. Where both move alike and one
farther, that factor is what was mistyped, or a unit, and is given.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.admission.refusal import Doubt, doubt, refusal, refuse
from deltactl.diagnosis.answer.records import Finding, Fit
from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.lone.commanded_axis import CommandedAxis
from deltactl.diagnosis.plants.lone.forced_axis import ForcedAxis
from deltactl.diagnosis.plants.lone.recorded_axis import COMMANDED
from deltactl.foundation.errors import RefusedRecording
from deltactl.models.effects.units_in_use import plain, said
from deltactl.models.robot import Drive, StepperAxis
from deltactl.recording.column_measures import first_of, travel
from deltactl.recording.foreign.doubts import TOO_LARGE, slope_ratio
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.tables.flat import FlatRecording

FACTORS = {
    **{10.0**k: f"a power of ten ({10.0**k:g})" for k in (-6, -4, -3, -2, 2, 3, 4, 6)},
    180.0 / np.pi: "degrees in place of radians (57.3)",
    np.pi / 180.0: "radians in place of degrees (1 / 57.3)",
}
"""Factors that a wrong unit makes."""
ANOTHER_S = "are columns, units or the robot file another machine's?"


def check_times(recording: FlatRecording) -> None:
    """Refuse times that are no seconds. Raises RefusedRecording."""
    shortest_s, longest_s = ADMISSION.times_s
    period_s = float(np.median(np.diff(recording.t_s))) if len(recording) > 1 else shortest_s
    if shortest_s <= period_s <= longest_s:
        return
    which = "is it in ms or us?" if period_s > longest_s else "was another unit given for it?"
    refuse("times_of_axis", recording.source, "t", period=period_s, which=which)


def too_large() -> RefusedRecording:
    """What is said of readings whose squares no number holds, which only the evidence shows."""
    return refusal("too_large").error()


def check_direction(plant: CommandedAxis, source: str) -> None:
    """Refuse a reading that runs against what it should follow. Raises RefusedRecording."""
    seen, expected = plant.observed[plant.rows], plant.nominal[plant.rows]
    if np.ptp(expected) > 0.0 and np.ptp(seen) > 0.0:
        alike = float(np.corrcoef(expected, seen)[0, 1])
        if alike < ADMISSION.against:
            refuse("against_command", source, plant.name, alike=alike)


def ahead_of_command(plant: CommandedAxis, source: str) -> Doubt | None:
    """That a reading moves before its command does, as that of a loop with feed-forward may."""
    for part in plant.parts:
        known = np.asarray(part, dtype=bool) & plant.readings.valid[:, 0]
        ahead_s = lead_s(plant.t_s[known], plant.commanded[known], plant.observed[known])
        if ahead_s > 0.0:
            return doubt("ahead_of_command", source, plant.name, ahead=ahead_s)
    return None


def lead_s(t_s: FloatArray, commanded: FloatArray, observed: FloatArray) -> float:
    """By how long a reading (n,) leads its command (n,); 0 where it does not."""
    most_s = min(ADMISSION.most_ahead_s, 0.1 * float(np.ptp(t_s)))
    period_s = float(np.median(np.diff(t_s)))
    inside = (t_s > t_s[0] + most_s) & (t_s < t_s[-1] - most_s)
    if not 0.0 < period_s < most_s or inside.sum() < OBSERVATIONS.fewest_samples:
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

    needed, velocity: (m,), of the rows that count. Raises RefusedRecording.
    """
    ways = [float(np.mean(velocity > 0.0)), float(np.mean(velocity < 0.0))]
    size = float(np.sqrt(np.mean(needed**2) * np.mean(velocity**2)))
    if min(ways) < ADMISSION.least_each_way or size <= 0.0:
        return
    if float(np.mean(needed * velocity)) < ADMISSION.brakes * size:
        refuse("always_brakes", plant.source, "effort")


def check_force(plant: ForcedAxis) -> None:
    """Refuse effort of the wrong sign, and a mass that only another unit explains.

    The mass is fitted without a prior beside friction and a constant: where friction rules it is
    hardly known, and nothing is refused. Raises RefusedRecording.
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
    # Rows are a filter's length apart; what is left is still correlated over several.
    error = float(np.sqrt(inverse[0, 0] * np.mean(left**2) * ADMISSION.correlated)) / scale[0]
    ratio, error = float(size[0] / scale[0]) / plant.inertia, error / plant.inertia
    if abs(ratio - 1.0) < ADMISSION.sure_of_mass * error:
        return
    for factor, words in FACTORS.items():
        known = error < ADMISSION.known_mass * abs(ratio)
        if known and abs(abs(ratio) / factor - 1.0) < ADMISSION.near_factor:
            refuse("unit_of_mass", plant.source, "effort", ratio=abs(ratio), factor=words)
    if ratio < ADMISSION.least_against and ratio < -ADMISSION.sure_of_mass * error:
        alike = float(np.corrcoef(plant.filtered_force[rows], motion.position[rows])[0, 1])
        case = "effort_asks" if alike > GUESSES.asked_alike else "against_effort"
        refuse(case, plant.source, "effort", ratio=ratio)


def check_velocity(recordings: Sequence[FlatRecording]) -> None:
    """Refuse a velocity in another unit than the position's. Raises RefusedRecording."""
    for recording in recordings:
        name = next((n for n in ("position", "theta_1") if n in recording.columns), None)
        if name is None or "velocity" not in recording.columns:
            continue
        columns = recording.columns
        ratio = slope_ratio(recording.t_s, columns[name], columns["velocity"])
        if ratio is None or 1.0 / GUESSES.other_unit < ratio < GUESSES.other_unit:
            continue
        near = [says for factor, says in TOO_LARGE if abs(ratio / factor - 1.0) < GUESSES.near_unit]
        other = f"is a gear or a sign between them? Else velocity=COLUMN*{1.0 / ratio:.4g}"
        values = {"position": name, "ratio": ratio, "near": near[0] if near else other}
        refuse("other_velocity", recording.source, "velocity", **values)


def check_together(
    plant: CommandedAxis, fit: Fit, found: list[Finding], recording: FlatRecording
) -> None:
    """Refuse what no explanation brings near: the one check that needs the answer.

    recording: the first of those that were diagnosed. Raises RefusedRecording.
    """
    scatter = float(np.std(plant.observed[plant.rows]))
    if not found or min(fit.rms_before_m, fit.rms_after_m) <= ADMISSION.hopeless * scatter:
        return
    sizes = (fit.rms_before_m, travel(plant.observed[plant.rows]), fit.rms_after_m)
    before, span, after = (said(size, fit.unit) for size in sizes)
    values = {"before": before, "span": span, "after": after, "likely": _why(plant, recording)}
    refuse("hopeless", recording.source, **values)


def _why(plant: CommandedAxis, recording: FlatRecording) -> str:
    """What is likely wrong: the gear, where steps were counted, and by which factor."""
    times = times_as_far(plant)
    robot, by_steps = plant.robot, first_of(recording, COMMANDED) is None
    drive = robot.drive if isinstance(robot, StepperAxis) and by_steps else None
    if times is None:
        of_drive = ", gear_ratio and microsteps_per_rev included" if drive else ""
        return f"{ANOTHER_S[:-1]}{of_drive}?"
    farther = f"the command moves {plain(times)} times as far as the reading"
    if times < 1.0:
        farther = f"the reading moves {plain(1.0 / times)} times as far as the command"
    return f"{farther}: {_gear(drive, times) if drive else ANOTHER_S}"


def _gear(drive: Drive, times: float) -> str:
    """The gear and the pulses of a turn that would make both move as far."""
    gear, pulses = drive.gear_ratio, drive.microsteps_per_rev
    return (
        f"is gear_ratio {plain(gear * times)} in place of {gear:g}, or microsteps_per_rev"
        f" {plain(pulses * times)} in place of {pulses}? Or is it another machine's robot file?"
    )


def times_as_far(plant: CommandedAxis) -> float | None:
    """By which factor the command moves farther than the reading; None where the two do not move
    alike, or nearly as far.
    """
    asked, seen = plant.nominal[plant.rows], plant.observed[plant.rows]
    wide, told = travel(asked), travel(seen)
    if min(wide, told) <= 0.0 or float(np.corrcoef(asked, seen)[0, 1]) < ADMISSION.moves_alike:
        return None
    times = wide / told
    return times if max(times, 1.0 / times) > ADMISSION.as_far else None
