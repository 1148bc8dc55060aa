"""The network that belongs to a corrected robot file."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml

from deltactl.diagnosis.answer.corrected_robot import corrected_text, lasts, sure
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.tables import Tables, table_of
from deltactl.diagnosis.api import diagnose
from deltactl.firmware_py.named_files import TRAINED_FOLDER
from deltactl.firmware_py.program.coverage import Coverage, robot_coverage
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.errors import ConfigError, DeltactlError
from deltactl.foundation.plain_file import check_fresh, said_of_output, write_whole
from deltactl.models.calibrated_inverse import corrections_of
from deltactl.models.network.file import NetworkFile
from deltactl.recording.tables.flat import FlatRecording

Progress = Callable[[str], None]
_NETWORKS = re.compile(r"^networks:.*\n(?:[ \t#].*\n|\n)*", re.MULTILINE)


def trained(
    robot: RobotFile,
    out: Path,
    progress: Progress = lambda _: None,
    replaces: NetworkFile | None = None,
) -> tuple[str, Path, float] | None:
    """Train a network with the effects of a robot file: the one it replaces, its file, its error.

    replaces: whose place and region it takes; else the shipped one's. The error is in degrees RMS,
    held out. None where no network of this robot is shipped. Raises NetworkError.
    """
    shipped = replaces or _shipped_network(robot)
    if shipped is None:
        return None
    from deltactl.models.training.corrected import train_corrected
    from deltactl.models.training.recipe import Task

    metadata = shipped.metadata
    task = Task(robot, metadata.domain, metadata.training.seed, metadata.angle_deg)

    def follow(done: int, total: int, text: str) -> None:
        progress(f"training the network: {100 * done // max(total, 1)} %, {text}")

    written = train_corrected(task, out, follow=follow)
    return shipped.path.name, out, written.file.metadata.validation.rmse_deg


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
    tables: Tables = Tables.NONE,
    progress: Progress = lambda _: None,
    read: Callable[[Path], FlatRecording] | None = None,
) -> Corrected:
    """Diagnose, write the robot file, train. Raises ConfigError, RecordingError, NetworkError.

    read: turns a file into columns, for tables of others.
    """
    check_fresh(out)
    before = load_robot(robot_file)
    answer = diagnose(recordings, robot_file, progress=progress, read=read)
    text = corrected_text(robot_file, answer, all_of_them, tables)
    _write(out, text)
    robot = _loaded(out)
    changed = robot.effects != before.effects
    learned = None
    if train and corrections_of(robot) != corrections_of(before):
        learned = trained(robot, out.with_suffix(".tflite"), progress)
    if learned is not None:
        name, network, _ = learned
        _write(out, with_network(text, robot, name, network))
        robot = _loaded(out)
    return Corrected(
        diagnosis=answer,
        robot_file=out,
        robot=robot,
        changed=changed,
        coverage=robot_coverage(robot),
        held_back=tuple(held_back(answer, before, all_of_them, tables)),
        network=learned[1] if learned else None,
        network_error_deg=learned[2] if learned else None,
        instead_of=learned[0] if learned else "",
    )


def with_network(text: str, robot: RobotFile, name: str, network: Path) -> str:
    """The text of a robot file with this file in place of the network that jobs name."""
    networks = {**robot.networks, name: str(network.resolve())}
    block = yaml.safe_dump({"networks": networks}, sort_keys=False)
    rest = _NETWORKS.sub("", text.rstrip() + "\n").rstrip()
    return f"{rest}\n\n{block}"


def held_back(
    answer: Diagnosis, robot: RobotFile, all_of_them: bool, tables: Tables
) -> list[tuple[Finding, str]]:
    """Findings that are not written into a robot file, and why."""
    held = []
    for finding in answer.findings:
        if finding.effect == "unknown":
            why_not = table_of(finding, robot, tables)
            if isinstance(why_not, str):
                held.append((finding, why_not))
        elif not lasts(finding):
            held.append((finding, "it happened once: home the robot, and look why"))
        elif not all_of_them and not sure(finding, answer):
            alternatives = ", ".join(
                f"{other.effect} on {other.component}" for other in finding.alternatives
            )
            why = (
                f"it could as well be {alternatives}"
                if alternatives
                else "it is not probable enough"
            )
            held.append((finding, f"{why} (--all writes it all the same)"))
    return held


def _write(out: Path, text: str) -> None:
    with said_of_output(out):
        write_whole(out, text)


def _loaded(path: Path) -> RobotFile:
    try:
        return load_robot(path)
    except ConfigError:
        path.unlink(missing_ok=True)
        raise
