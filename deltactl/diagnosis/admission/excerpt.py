"""An excerpt of a recording too long for memory: whole stretches, spread over all of it.

Stretches keep what lives between one row and the next (play, lag, the memory of the noise); every
so many rows would not. Each is the one in its part of the recording in which most moves.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.admission.refusal import refuse
from deltactl.diagnosis.answer.records import Thinned
from deltactl.diagnosis.observations.readings import IntArray
from deltactl.models.robot import DeltaRobot, RangeSensor, RobotModel
from deltactl.models.servo_drive import ServoDrive
from deltactl.recording.tables.flat import GAP_PERIODS, FlatRecording

APART = int(GAP_PERIODS) + 1
"""Rows between two stretches, so that each is one."""
MOVES = ("steps_", "command", "theta_", "position", "distance")


def most_rows(robot: RobotModel) -> int:
    """Rows of all recordings together that a diagnosis of such a machine takes."""
    if isinstance(robot, RangeSensor):
        return ADMISSION.range_rows
    if isinstance(robot, DeltaRobot) and not isinstance(robot.drive, ServoDrive):
        return ADMISSION.delta_rows
    return ADMISSION.fast_rows


def excerpt(recording: FlatRecording, most: int) -> FlatRecording:
    """The recording itself, or stretches of it with `most` rows together."""
    if len(recording) <= most:
        return recording
    kept = recording.rows(_chosen(recording, most))
    return replace(kept, taken_from=recording.taken_from or len(recording))


def excerpts(recordings: Sequence[FlatRecording], most: int) -> list[FlatRecording]:
    """Recordings with no more than `most` rows together: the longest are cut to one length.

    Raises RefusedRecording where there are too many of them.
    """
    lengths = sorted(len(recording) for recording in recordings)
    if sum(lengths) <= most:
        return list(recordings)
    left = most
    for place, length in enumerate(lengths):
        share = left // (len(lengths) - place)
        if length > share:
            break
        left -= length
    if share < ADMISSION.fewest_of_each:
        refuse("too_many", recordings=len(recordings), rows=sum(lengths), most=most)
    return [excerpt(recording, share) for recording in recordings]


def thinned(recordings: Sequence[FlatRecording]) -> list[Thinned]:
    """What to say of recordings of which only a part was used."""
    return [
        Thinned(
            recording=number,
            rows_used=len(recording),
            rows=recording.taken_from,
            stretches=len(recording.stretches()),
            span_s=float(recording.t_s[-1] - recording.t_s[0]),
        )
        for number, recording in enumerate(recordings, 1)
        if recording.taken_from
    ]


def _chosen(recording: FlatRecording, most: int) -> IntArray:
    """Rows of the stretches, with a gap between each and the next."""
    count, length = len(recording), most // ADMISSION.stretches
    moved = np.concatenate([[0.0], np.cumsum(_moving(recording))])
    edges = np.linspace(0, count, ADMISSION.stretches + 1).astype(int)
    found = []
    for begin, end in itertools.pairwise(edges.tolist()):
        first = np.arange(begin, max(begin + 1, end - length - APART))
        best = int(first[np.argmax(moved[first + length - 1] - moved[first])])
        found.append(np.arange(best, min(best + length, count)))
    rows: IntArray = np.unique(np.concatenate(found))
    return rows


def _moving(recording: FlatRecording) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """How much moves from each row to the next, (n - 1,), each column in its own measure."""
    total = np.zeros(len(recording) - 1)
    for name, values in recording.columns.items():
        if name.startswith(MOVES):
            step = np.abs(np.nan_to_num(np.diff(values)))
            # Not the size: a reading that leaps would draw all stretches to it.
            total += step > 0.0
    return total
