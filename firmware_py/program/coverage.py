"""What of a robot's known effects a job takes into account, and what is left as work to do."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from deltactl.firmware_py.compensation.lead import can_lead
from deltactl.firmware_py.file_access import FileAccess
from deltactl.firmware_py.job_file import JobFile, NetworkIk
from deltactl.firmware_py.job_targets import network_file, read_network
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.program.includes import kinematics_in, paths_of, read_whole
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.calibrated_inverse import corrections_of
from deltactl.models.effects import Compensated, card_of, effect_kind
from deltactl.models.robot import EffectEntry

NOT_TOGETHER = "stepping by gpiozero cannot step one motor shortly after the other"


@dataclass(frozen=True, slots=True)
class Covered:
    """One known effect in one job. how: by what it is compensated; empty where it is not."""

    effect: str
    component: str
    says: str
    how: str
    why_not: str = ""

    def as_json(self) -> dict[str, Any]:
        """Plain types."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class Coverage:
    """All known effects of a robot in one job, and a warning where there is reason for one."""

    effects: tuple[Covered, ...]
    warning: str = ""

    @property
    def compensated(self) -> tuple[Covered, ...]:
        """Those taken into account."""
        return tuple(effect for effect in self.effects if effect.how)

    @property
    def left(self) -> tuple[Covered, ...]:
        """Those that are work to do."""
        return tuple(effect for effect in self.effects if not effect.how)


def coverage_of(
    job_path: Path, robot_path: Path | None = None, files: FileAccess | None = None
) -> Coverage:
    """Coverage of a job file on its robot or another. Raises ConfigError, NetworkError.

    files: what was read before, and is not read again.
    """
    files = files or FileAccess()
    job = read_whole(job_path, files).job
    where = find(job.robot, beside=job_path) if robot_path is None else robot_path
    return coverage(job, files.robot(where), job_path, where, files)


def coverage(
    job: JobFile,
    robot: RobotFile,
    job_path: Path | None,
    robot_path: Path | None = None,
    files: FileAccess | None = None,
) -> Coverage:
    """What the job does about each effect in the robot file."""
    files = files or FileAccess()
    if all(path.shape in ("joints", "survey") for path in paths_of(job)):
        why = "the path is given in arm angles, which are commanded as they are"
        return Coverage(tuple(_left(entry, why) for entry in robot.effects))
    corrections = known = corrections_of(robot)
    insides, warnings = [], []
    for chosen in kinematics_in(job):
        inside, warning = Compensated.INVERSE.value, ""
        if isinstance(chosen, NetworkIk):
            file = network_file(chosen, robot, job_path)
            learned = read_network(file, files).metadata.robot.effects
            inside = "in the network"
            warning = _network_warning(file.name, corrections, learned, robot_path)
            known = tuple(entry for entry in known if entry in learned)
        insides.append(inside)
        warnings.append(warning)
    inside = " and ".join(dict.fromkeys(insides))
    warning = "; ".join(text for text in dict.fromkeys(warnings) if text)
    return Coverage(tuple(_covered(robot, known, inside)), warning)


def robot_coverage(robot: RobotFile) -> Coverage:
    """What any job in space does about each effect, with an inverse that knows them all."""
    return Coverage(tuple(_covered(robot, corrections_of(robot), Compensated.INVERSE.value)))


def _covered(robot: RobotFile, known: tuple[EffectEntry, ...], inside: str) -> list[Covered]:
    covered = []
    for entry in robot.effects:
        card = card_of(entry.effect)
        if card.compensated is Compensated.INVERSE:
            is_known = entry.model_copy(update={"found": None}) in known
            why = "the network does not know it"
            covered.append(_by(entry, inside) if is_known else _left(entry, why))
        elif not can_lead(robot) and card.compensated in (Compensated.AHEAD, Compensated.SHAPED):
            covered.append(_left(entry, NOT_TOGETHER))
        elif card.compensated is Compensated.NOT:
            covered.append(_left(entry, card.left))
        else:
            covered.append(_by(entry, card.compensated.value))
    return covered


def _network_warning(
    name: str,
    known: tuple[EffectEntry, ...],
    learned: tuple[EffectEntry, ...],
    robot_path: Path | None,
) -> str:
    """Where a network and a robot file have different effects."""
    missing = [entry for entry in known if entry not in learned]
    more = [entry for entry in learned if entry not in known]
    if not missing and not more:
        return ""
    words = ", ".join(f"{effect.effect} on {effect.component}" for effect in missing or more)
    says = "does not know" if missing else "corrects what the robot file does not know:"
    robot = "the robot file" if robot_path is None else str(robot_path)
    return (
        f"network {name} {says} {words}; train one that agrees with 'deltactl network train --robot"
        f" {robot} --out {Path(name).stem}-corrected.tflite' and name it in the job, or use"
        " inverse_kinematics: {kind: geometry}"
    )


def _by(entry: EffectEntry, how: str) -> Covered:
    return Covered(entry.effect, entry.component, _sentence(entry), how)


def _left(entry: EffectEntry, why: str) -> Covered:
    return Covered(entry.effect, entry.component, _sentence(entry), "", why)


def _sentence(entry: EffectEntry) -> str:
    kind = effect_kind(entry.effect)
    given = {p.name: p.default for p in kind.parameters if p.default is not None}
    return kind.sentence(entry.component, {**given, **entry.parameters})
