"""What the robot file has from earlier diagnoses, for the answer to tell."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from deltactl.diagnosis.answer.records import Known
from deltactl.models.robot import RobotModel


def known_of(robot: RobotModel, recordings: Sequence[Path]) -> list[Known]:
    """Effects of the robot file that a diagnosis found; recordings: what is diagnosed now."""
    names = {path.name for path in recordings}
    return [
        Known(
            effect=one.effect,
            component=one.component,
            probability=one.found.probability,
            from_these_recordings=bool(names & set(one.found.recordings)),
        )
        for one in robot.effects
        if one.found is not None
    ]
