"""Refusing a reading of an axis that no explanation brings near its command.

Sizes are told in degrees or mm, beside how far the axis moved. Where both move alike and one
farther, that factor is what was mistyped, or a unit, and is told.
"""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.answer.records import Finding, Fit
from deltactl.diagnosis.plants.lone.commanded_axis import CommandedAxis
from deltactl.diagnosis.plants.lone.recorded_axis import COMMANDED
from deltactl.foundation.errors import RecordingError
from deltactl.models.effects.lone_axis import plain, said
from deltactl.models.robot import Drive, StepperAxis
from deltactl.recording.column_measures import first_of, travel
from deltactl.recording.tables.flat import FlatRecording

ANOTHER_S = "are columns, units or the robot file another machine's?"


def check_together(
    plant: CommandedAxis, fit: Fit, found: list[Finding], recording: FlatRecording
) -> None:
    """Refuse what no explanation brings near. Raises RecordingError.

    recording: the first of those that were diagnosed.
    """
    scatter = float(np.std(plant.observed[plant.rows]))
    if not found or min(fit.rms_before_m, fit.rms_after_m) <= ADMISSION.hopeless * scatter:
        return
    sizes = (fit.rms_before_m, travel(plant.observed[plant.rows]), fit.rms_after_m)
    before, span, after = (said(size, fit.unit) for size in sizes)
    raise RecordingError(
        f"{recording.source}: recording and robot file do not belong together: reading and command"
        f" are {before} apart (root mean square) in a motion over {span}, and {after} with the best"
        f" explanation; {_why(plant, recording)}"
    )


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
