"""One case of the blind proof of repairing: a robot is recorded once, corrected in several ways.

The survey and its diagnosis cost most and are kept, so that another way of correcting costs a
second.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from deltactl.diagnosis.answer.corrected_robot import corrected_text
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.answer.tables import Tables
from deltactl.diagnosis.api import diagnose
from deltactl.firmware_py.job_file import JobFile, NetworkIk, load_job
from deltactl.firmware_py.kinematics_of_job import kinematics_of
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.check import make_plan
from deltactl.firmware_py.planner.plan import Plan
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.plain_file import write_whole
from deltactl.models.calibrated_inverse import corrections_of
from deltactl.recording.tables.flat_files import write_flat
from deltactl.repair.coverage import coverage
from deltactl.repair.limit import limit_of
from deltactl.repair.machine import Concealing, conceal
from deltactl.repair.network import trained
from deltactl.repair.played import Played, played
from deltactl.repair.tracking import Drawn

JOB, ROBOT = CONFIG_FOLDER / "demo-heart.yaml", CONFIG_FOLDER / "zhao-2023.yaml"
NETWORK = NetworkIk(kind="network", file="zhao-2023.tflite")
SURVEY_S = 240.0


@dataclass(frozen=True)
class Case:
    """What is concealed, and where what it costs is kept."""

    number: int
    seed: int
    effects: tuple[str, ...]
    unknown: bool
    folder: Path

    @property
    def name(self) -> str:
        """Of its files."""
        return f"repair-{self.seed}-{self.number:04d}"

    def machine(self) -> Concealing:
        """The robot; the same one every time."""
        return conceal(list(self.effects), 1000 * self.seed + self.number, self.unknown)

    def diagnosis(self, machine: Concealing) -> Diagnosis:
        """Of one survey; worked out once."""
        kept = self.folder / f"{self.name}-diagnosis.json"
        if kept.exists():
            return Diagnosis.model_validate_json(kept.read_text())
        recording = self.folder / f"{self.name}.csv.gz"
        write_flat(machine.survey(SURVEY_S), recording)
        answer = diagnose([recording], ROBOT)
        recording.unlink()
        write_whole(kept, json.dumps(answer.to_json()) + "\n")
        return answer


def run(case: Case, networks: bool) -> dict[str, Any]:
    """Record, diagnose, correct and draw again; as JSON, distances from the target RMS [m].

    networks: with a job that takes a network as well, which is trained. Raises DeltactlError.
    """
    machine, believed = case.machine(), load_robot(ROBOT)
    answer = case.diagnosis(machine)
    shipped = _drawing(believed)
    before = machine.draw(shipped)
    robot = _written(case, corrected_text(ROBOT, answer), "corrected")
    plan = _plan(robot)
    after = _again(machine, plan, shipped, before)
    limit = limit_of(plan, coverage(load_job(JOB), robot, JOB))
    result: dict[str, Any] = {
        "number": case.number,
        "concealed": [f"{one.effect} on {one.where}" for one in machine.answers],
        "found": [f"{one.effect} on {one.component}" for one in answer.findings],
        "corrected": [f"{one.effect} on {one.component}" for one in robot.effects],
        "before_m": before.rms_m,
        "after_m": after.rms_m,
        "possible_m": conceal([], 0).draw(shipped).rms_m,
        "limit_m": None if limit is None else limit.rms_m,
    }
    text = corrected_text(ROBOT, answer, tables=Tables.JOINTS)
    with_tables = _written(case, text, "tables")
    if with_tables.effects != robot.effects:
        result["tables_m"] = _again(machine, _plan(with_tables), shipped, before).rms_m
    if networks:
        result |= _by_network(case, machine, believed, robot)
    return result


def _by_network(
    case: Case, machine: Concealing, believed: RobotFile, robot: RobotFile
) -> dict[str, float]:
    """Before and after of a job that names the shipped network."""
    path = played(_plan(believed, NETWORK))
    before = machine.draw(path)
    if corrections_of(robot) != corrections_of(believed):
        kept = case.folder / f"{case.name}.tflite"
        if not kept.exists():
            trained(robot, kept)
        robot = robot.model_copy(update={"networks": {NETWORK.file: str(kept.resolve())}})
    after = _again(machine, _plan(robot, NETWORK), path, before)
    return {"network_before_m": before.rms_m, "network_after_m": after.rms_m}


def _drawing(robot: RobotFile) -> Played:
    return played(_plan(robot))


def _plan(robot: RobotFile, network: NetworkIk | None = None) -> Plan:
    job: JobFile = load_job(JOB)
    if network is not None:
        job = job.model_copy(update={"inverse_kinematics": network})
    return make_plan(job, robot, kinematics_of(job, robot, JOB))


def _written(case: Case, text: str, what: str) -> RobotFile:
    path = case.folder / f"{case.name}-{what}.yaml"
    write_whole(path, text)
    return load_robot(path)


def _again(machine: Concealing, plan: Plan, path: Played, before: Drawn) -> Drawn:
    """A run with another robot file; where the same counts are sent it is the same run."""
    new = played(plan)
    return before if new.is_same_as(path) else machine.draw(new)
