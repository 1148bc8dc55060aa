"""The whole way once: conceal, draw, record, diagnose, correct, draw again, compare."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from deltactl.diagnosis.answer.corrected_robot import save_corrected
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.tables import Tables
from deltactl.diagnosis.api import diagnose
from deltactl.firmware_py.planner.check import plan_of
from deltactl.firmware_py.robot_file import load_robot
from deltactl.proof.hidden.hidden import Hidden
from deltactl.recording.tables.flat_files import write_flat
from deltactl.repair.correct import held_back
from deltactl.repair.coverage import Coverage, coverage_of
from deltactl.repair.limit import Limit, limit_of
from deltactl.repair.machine import conceal
from deltactl.repair.played import played
from deltactl.repair.tracking import Drawn

Progress = Callable[[str], None]
RECORDING, CORRECTED = "survey.csv.gz", "corrected.yaml"


@dataclass(frozen=True, eq=False)
class Demonstration:
    """One robot, before and after; `possible` is the same robot without what was concealed."""

    answers: Sequence[Hidden]
    before: Drawn
    after: Drawn
    possible: Drawn
    diagnosis: Diagnosis
    coverage: Coverage
    held_back: Sequence[tuple[Finding, str]]
    """Findings that were not written into the corrected file, and why."""
    limit: Limit | None
    """What the corrected robot file says is possible."""
    robot_file: Path
    corrected: Path
    recording: Path
    survey_s: float

    @property
    def gain(self) -> float:
        """Share of what is above the possible that is gone; 1 where nothing was."""
        above = self.before.rms_m - self.possible.rms_m
        return 1.0 if above <= 0.0 else (self.before.rms_m - self.after.rms_m) / above


def demonstrate(
    job: Path,
    robot_file: Path,
    folder: Path,
    effects: Sequence[str],
    seed: int,
    unknown: bool = False,
    survey_s: float = 120.0,
    progress: Progress = lambda _: None,
) -> Demonstration:
    """Run it all and leave recording and corrected robot file in `folder`.

    Raises ConfigError for an effect that cannot be concealed, or any error of the steps.
    """
    machine = conceal(list(effects), seed, unknown)
    progress("drawing with the robot as it was built")
    believed = load_robot(robot_file)
    path = played(plan_of(job, believed))
    before = machine.draw(path)
    possible = conceal([], seed).draw(path)
    progress(f"recording a survey of {survey_s:.0f} s")
    recording = folder / RECORDING
    write_flat(machine.survey(survey_s), recording)

    def show(text: str) -> None:
        progress(f"diagnosing: {text}")

    answer = diagnose([recording], robot_file, progress=show)
    corrected = folder / CORRECTED
    corrected.unlink(missing_ok=True)
    save_corrected(robot_file, answer, corrected)
    progress("drawing with the corrected robot")
    plan, covered = plan_of(job, load_robot(corrected)), coverage_of(job, corrected)
    new = played(plan)
    after = before if new.is_same_as(path) else machine.draw(new)
    return Demonstration(
        answers=machine.answers,
        before=before,
        after=after,
        possible=possible,
        diagnosis=answer,
        coverage=covered,
        held_back=held_back(answer, believed, False, Tables.NONE),
        limit=limit_of(plan, covered),
        robot_file=robot_file,
        corrected=corrected,
        recording=recording,
        survey_s=survey_s,
    )
