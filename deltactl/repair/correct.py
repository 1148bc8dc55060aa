"""From a diagnosis to a corrected robot file, its network, and the work that needs a hand."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import yaml

from deltactl.diagnosis.answer.corrected_robot import corrected_text, lasts, sure
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.tables import Tables, Values, table_of
from deltactl.diagnosis.api import diagnose
from deltactl.firmware_py.named_files import TRAINED_FOLDER
from deltactl.firmware_py.program.coverage import Coverage, robot_coverage
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.firmware_py.run_report.tracking import acting
from deltactl.foundation.errors import ConfigError, DeltactlError
from deltactl.foundation.plain_file import check_fresh, said_of_output, write_whole
from deltactl.foundation.strict_yaml import Document
from deltactl.models.calibrated_inverse import corrections_of
from deltactl.models.effects.kind import MOTORS
from deltactl.models.effects.tables import JOINT_TABLE
from deltactl.models.network.file import NetworkFile
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.models.robot_files import with_effects_in
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


class Asked(NamedTuple):
    """What of an answer is written: also what is not sure, and what has no name as a table."""

    all_of_them: bool = False
    tables: Tables = Tables.NONE


CERTAIN = Asked()


def correct(
    recordings: Sequence[Path],
    robot_file: Path,
    out: Path,
    asked: Asked = CERTAIN,
    train: bool = True,
    progress: Progress = lambda _: None,
    read: Callable[[Path], FlatRecording] | None = None,
) -> Corrected:
    """Diagnose, write the robot file, train. Raises ConfigError, RecordingError, NetworkError.

    read: turns a file into columns, for tables of others.
    """
    check_fresh(out)
    before = load_robot(robot_file)
    answer = diagnose(recordings, robot_file, progress=progress, read=read)
    text = corrected_text(robot_file, answer, *asked)
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
        held_back=tuple(held_back(answer, before, *asked)),
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


def work_list(answer: Diagnosis, robot: RobotFile, covered: Coverage) -> list[dict[str, str]]:
    """What no compensation takes away, each with why."""
    work = [
        _item(finding.effect, finding.component, finding.says, why.partition(" (--all")[0])
        for finding, why in held_back(answer, robot, False, Tables.JOINTS)
    ]
    named = {(one["effect"], one["component"]) for one in work}
    work += [
        _item(one.effect, one.component, one.says, one.why_not or "not compensated")
        for one in covered.left
        if (one.effect, one.component) not in named
    ]
    return work


def moves_nothing(answer: Diagnosis, listed: list[dict[str, str]]) -> list[dict[str, str]]:
    """What is sure and does not change what is drawn, unless it is listed."""
    why = "it does not change what is drawn: mend it, or accept it with 'deltactl correct'"
    says = {one["says"] for one in listed}
    return [
        _item(one.effect, one.component, one.says, why)
        for one in answer.findings
        if sure(one, answer) and one.says not in says
    ]


def _item(effect: str, component: str, says: str, why: str) -> dict[str, str]:
    return {"effect": effect, "component": component, "says": says, "why": why}


def as_found(robot_file: Path, corrected: RobotFile, answer: Diagnosis) -> tuple[EffectEntry, ...]:
    """All that is known to move the robot: also what is not sure, or has no name.

    What enters at a joint without a name turns it by the size that was found, one way.
    """
    text = corrected_text(robot_file, answer, all_of_them=True, tables=Tables.SENSORS)
    try:
        robot = with_effects_in(Document(robot_file, text))
    except ConfigError:  # what is not sure is more than a machine can have
        robot = corrected
    assert isinstance(robot, DeltaRobot)
    unknown = [one for one in answer.findings if one.effect == "unknown"]
    left = [one for one in unknown if isinstance(table_of(one, robot, Tables.SENSORS), str)]
    turned = [_turned(one) for one in left if one.component in MOTORS]
    return (*acting(robot), *(one for one in turned if one is not None))


def _turned(finding: Finding) -> EffectEntry | None:
    """None where no size was found."""
    sizes = [one.value for one in finding.parameters.values() if isinstance(one.value, float)]
    if not sizes:
        return None
    ends: Values = {"lowest": -math.pi, "highest": math.pi, "follows": 1.0}
    error = (sizes[0], sizes[0])
    return EffectEntry(
        effect=JOINT_TABLE.name, component=finding.component, parameters=ends | {"error": error}
    )


def _write(out: Path, text: str) -> None:
    with said_of_output(out):
        write_whole(out, text)


def _loaded(path: Path) -> RobotFile:
    try:
        return load_robot(path)
    except ConfigError:
        path.unlink(missing_ok=True)
        raise
