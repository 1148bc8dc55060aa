"""How many rows a diagnosis takes of recordings, and what the answer says of those it leaves."""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.admission.refusal import refuse
from deltactl.diagnosis.answer.records import Thinned
from deltactl.models.robot import DeltaRobot, RangeSensor, RobotModel
from deltactl.models.servo_drive import ServoDrive
from deltactl.recording.tables.excerpt import excerpt
from deltactl.recording.tables.flat import FlatRecording


def most_rows(robot: RobotModel) -> int:
    """Rows of all recordings together that a diagnosis of such a machine takes."""
    if isinstance(robot, RangeSensor):
        return ADMISSION.range_rows
    if isinstance(robot, DeltaRobot) and not isinstance(robot.drive, ServoDrive):
        return ADMISSION.delta_rows
    return ADMISSION.fast_rows


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
