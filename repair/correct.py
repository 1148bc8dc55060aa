"""Recordings in, a corrected robot out: its file, and a network that knows what the file knows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml

from diagnosis.answer.corrected_robot import corrected_text, lasts, sure
from diagnosis.answer.records import Diagnosis, Finding
from diagnosis.api import diagnose
from firmware_py.robot_file import TRAINED_FOLDER, RobotFile, load_robot
from foundation.errors import ConfigError, DeltactlError, RecordingError
from models.calibrated_inverse import corrections_of
from models.network.file import NetworkFile
from repair.coverage import Coverage, robot_coverage

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Corrected:
    """What came of it. network: None where none was trained. held_back: found, but not written."""

    diagnosis: Diagnosis
    robot_file: Path
    robot: RobotFile
    changed: bool
    coverage: Coverage
    held_back: tuple[tuple[Finding, str], ...]
    network: Path | None = None
    network_error_deg: float | None = None
    instead_of: str = ""


def correct(
    recordings: Sequence[Path],
    robot_file: Path,
    out: Path,
    all_of_them: bool = False,
    train: bool = True,
    progress: Progress = lambda _: None,
) -> Corrected:
    """Diagnose, write the robot file, train. Raises ConfigError, RecordingError, NetworkError."""
    if out.exists():
        raise RecordingError(f"{out}: exists already; choose another name")
    before = load_robot(robot_file)
    answer = diagnose(recordings, robot_file, progress=progress)
    text = corrected_text(robot_file, answer, all_of_them)
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise RecordingError(f"{out}: cannot be written ({error.strerror})") from error
    robot = _loaded(out)
    changed = robot.effects != before.effects
    learned = None
    if train and corrections_of(robot) != corrections_of(before):
        learned = _trained(robot, out, progress)
    if learned is not None:
        name, network, _ = learned
        block = yaml.safe_dump({"networks": {name: str(network.resolve())}}, sort_keys=False)
        out.write_text(f"{text.rstrip()}\n\n{block}", encoding="utf-8")
        robot = _loaded(out)
    return Corrected(
        diagnosis=answer,
        robot_file=out,
        robot=robot,
        changed=changed,
        coverage=robot_coverage(robot),
        held_back=tuple(_held_back(answer, all_of_them)),
        network=learned[1] if learned else None,
        network_error_deg=learned[2] if learned else None,
        instead_of=learned[0] if learned else "",
    )


def _held_back(answer: Diagnosis, all_of_them: bool) -> list[tuple[Finding, str]]:
    """Findings that were not written, and why."""
    held = []
    for finding in answer.findings:
        if finding.effect == "unknown":
            held.append((finding, "it has no name, so no command is known that makes it better"))
        elif not lasts(finding):
            held.append((finding, "it happened once: home the robot, and look why"))
        elif not all_of_them and not sure(finding):
            rivals = ", ".join(f"{one.effect} on {one.component}" for one in finding.alternatives)
            why = f"it could as well be {rivals}" if rivals else "it is not probable enough"
            held.append((finding, f"{why} (--all writes it all the same)"))
    return held


def _trained(robot: RobotFile, out: Path, progress: Progress) -> tuple[str, Path, float] | None:
    """Train for the network that jobs of this robot name; its name, the new file, its error."""
    shipped = _shipped_network(robot)
    if shipped is None:
        return None
    from models.training.corrected import train_corrected
    from models.training.recipe import Task

    metadata = shipped.metadata
    task = Task(robot, metadata.domain, metadata.training.seed, metadata.angle_deg)

    def follow(done: int, total: int, text: str) -> None:
        progress(f"training the network: {100 * done // max(total, 1)} %, {text}")

    network = out.with_suffix(".tflite")
    written = train_corrected(task, network, follow=follow)
    return shipped.path.name, network, written.file.metadata.validation.rmse_deg


def _shipped_network(robot: RobotFile) -> NetworkFile | None:
    """The network in models/trained that is of this robot."""
    for path in sorted(TRAINED_FOLDER.glob("*.tflite")):
        file = NetworkFile.load(path)
        try:
            file.check(robot)
        except DeltactlError:
            continue
        return file
    return None


def _loaded(path: Path) -> RobotFile:
    try:
        return load_robot(path)
    except ConfigError:
        path.unlink(missing_ok=True)
        raise
