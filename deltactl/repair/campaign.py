"""One case of the blind proof of repairing: a robot is recorded once, corrected in several ways.

The survey and its diagnosis cost most and are kept, so that another way of correcting costs a
second.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.diagnosis.answer.corrected_robot import corrected_text
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.answer.tables import Tables
from deltactl.diagnosis.api import diagnose
from deltactl.firmware_py.job_file import JobFile, NetworkIk, load_job
from deltactl.firmware_py.job_targets import kinematics_of
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import Plan, make_plan
from deltactl.firmware_py.program.coverage import coverage
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.plain_file import write_whole
from deltactl.models.calibrated_inverse import corrections_of
from deltactl.models.effects import Compensated, compensated
from deltactl.proof.hidden.vocabulary import SINGLES
from deltactl.proof.prove.resumable import Means, workers
from deltactl.recording.tables.flat_files import write_flat
from deltactl.repair.correct import trained
from deltactl.repair.limit import ENOUGH, ENOUGH_M, limit_of
from deltactl.repair.machine import FaultyRobot, faulty_robot
from deltactl.repair.played import Drawn, Played, played

JOB, ROBOT = CONFIG_FOLDER / "demo-heart.yaml", CONFIG_FOLDER / "zhao-2023.yaml"
NETWORK = NetworkIk(kind="network", file="zhao-2023.tflite")
SURVEY_S = 240.0


@dataclass(frozen=True)
class Case:
    """The hidden faults of a case, and the folder for its tracking errors."""

    number: int
    seed: int
    effects: tuple[str, ...]
    unknown: bool
    folder: Path

    @property
    def name(self) -> str:
        """Stem of its file names."""
        return f"repair-{self.seed}-{self.number:04d}"

    def machine(self) -> FaultyRobot:
        """The robot; the same one every time."""
        return faulty_robot(list(self.effects), 1000 * self.seed + self.number, self.unknown)

    def diagnosis(self, machine: FaultyRobot) -> Diagnosis:
        """Diagnosis of one survey; worked out once."""
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
    machine, accepted = case.machine(), load_robot(ROBOT)
    answer = case.diagnosis(machine)
    shipped = _drawing(accepted)
    before = machine.draw(shipped)
    robot = _written(case, corrected_text(ROBOT, answer), "corrected")
    plan = _plan(robot)
    after = _again(machine, plan, shipped, before)
    limit = limit_of(plan, coverage(load_job(JOB), robot, JOB))
    result: dict[str, Any] = {
        "number": case.number,
        "concealed": [f"{answered.effect} on {answered.where}" for answered in machine.answers],
        "found": [f"{finding.effect} on {finding.component}" for finding in answer.findings],
        "corrected": [f"{effect.effect} on {effect.component}" for effect in robot.effects],
        "before_m": before.rms_m,
        "after_m": after.rms_m,
        "possible_m": faulty_robot([], 0).draw(shipped).rms_m,
        "limit_m": None if limit is None else limit.rms_m,
    }
    text = corrected_text(ROBOT, answer, tables=Tables.JOINTS)
    with_tables = _written(case, text, "tables")
    if with_tables.effects != robot.effects:
        result["tables_m"] = _again(machine, _plan(with_tables), shipped, before).rms_m
    if networks:
        result |= _by_network(case, machine, accepted, robot)
    return result


def _by_network(
    case: Case, machine: FaultyRobot, accepted: RobotFile, robot: RobotFile
) -> dict[str, float]:
    """Before and after of a job that names the shipped network."""
    path = played(_plan(accepted, NETWORK))
    before = machine.draw(path)
    if corrections_of(robot) != corrections_of(accepted):
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


def _again(machine: FaultyRobot, plan: Plan, path: Played, before: Drawn) -> Drawn:
    """A run with another robot file; where the same counts are sent it is the same run."""
    new = played(plan)
    return before if new.is_same_as(path) else machine.draw(new)


WORSE, WORSE_M = 1.05, 0.02e-3
"""Beyond both, correcting made a job worse."""
EXTRA = ("pair", "pair", "pair", "unknown", "nothing")
BESIDE_FROM = 104
"""From this case on: an effect that is compensated, and an unknown beside it."""
# Without what rings: another list would make other robots of the same numbers.
_WAYS = (
    Compensated.INVERSE,
    Compensated.AHEAD,
    Compensated.AT_REVERSALS,
    Compensated.WARMING,
)
COMPENSATED = tuple(name for name in SINGLES if name in compensated(*_WAYS))


@dataclass(frozen=True)
class Row:
    """One case; distances from the target, RMS [m].

    possible_m: of the same robot without a hidden fault. limit_m: the tracking limit of the
    corrected robot file. network: before and after of the job with a network; tables_m: after,
    with tables of what has no name. NaN where it was not worked out.
    """

    number: int
    hidden: tuple[str, ...]
    found: tuple[str, ...]
    before_m: float
    after_m: float
    possible_m: float
    limit_m: float = np.nan
    network_before_m: float = np.nan
    network_after_m: float = np.nan
    tables_m: float = np.nan
    corrected: tuple[str, ...] = ()
    failure: str = ""

    @property
    def enough(self) -> bool:
        """Whether it draws as well as could be asked."""
        return self._is_enough(self.after_m)

    @property
    def network_enough(self) -> bool:
        """The same with a network."""
        return self._is_enough(self.network_after_m)

    @property
    def tables_enough(self) -> bool:
        """The same with tables of what has no name."""
        return self._is_enough(self.tables_m)

    @property
    def worse(self) -> bool:
        """Whether a job got worse, in whatever way it was corrected."""
        pairs = (
            (self.before_m, self.after_m),
            (self.before_m, self.tables_m),
            (self.network_before_m, self.network_after_m),
        )
        return any(after > max(WORSE * before, before + WORSE_M) for before, after in pairs)

    def _is_enough(self, after_m: float) -> bool:
        return after_m <= max(ENOUGH * self.possible_m, ENOUGH_M)


def kinds_of(seed: int, number: int) -> tuple[list[str], bool]:
    """The hidden faults of a case, and whether something unknown is among them.

    Every effect alone first, then pairs, an unknown and nothing in turn; at last an effect with an
    unknown beside it.
    """
    if number >= BESIDE_FROM:
        return [COMPENSATED[(number - BESIDE_FROM) % len(COMPENSATED)]], True
    if number < len(SINGLES):
        return [SINGLES[number]], False
    group = EXTRA[(number - len(SINGLES)) % len(EXTRA)]
    rng = np.random.default_rng([seed, number, 7])
    if group == "pair":
        return [str(name) for name in rng.permutation(SINGLES)[:2]], False
    return [], group == "unknown"


def run_case(seed: int, number: int, folder: Path, networks: bool) -> dict[str, Any]:
    """One case as JSON; an error of the program is a result, not the end."""
    effects, unknown = kinds_of(seed, number)
    case = Case(number, seed, tuple(effects), unknown, folder)
    try:
        return run(case, networks)
    except DeltactlError as error:
        named = [*effects, *(["unknown"] if unknown else [])]
        return {"number": number, "concealed": named, "failure": str(error)}


def prove_repair(cases: int, seed: int, out: Path, networks: bool, means: Means) -> list[Row]:
    """Run what is not in `out` yet; returns all rows in order.

    After `means.minutes` no further case is begun; the rows are of those that are there.
    """
    until = time.monotonic() + 60.0 * means.minutes
    out.mkdir(parents=True, exist_ok=True)
    missing = [number for number in range(cases) if not _is_there(out, seed, number, networks)]
    means.progress(cases - len(missing), cases, "")
    case = partial(run_case, folder=out.resolve(), networks=networks)
    with workers(means.count, means.scheduler, means.say) as at_work:
        jobs = [(case, seed, number) for number in missing]
        for done, (place, result) in enumerate(at_work(jobs), start=1):
            write_whole(_file(out, seed, missing[place]), json.dumps(result, indent=1) + "\n")
            means.progress(cases - len(missing) + done, cases, "")
            if time.monotonic() > until and done < len(missing):
                means.say(
                    f"stopped after {means.minutes:g} minutes; the same command again goes on"
                )
                break
    return list(read_rows(out, seed, cases))


def _is_there(out: Path, seed: int, number: int, networks: bool) -> bool:
    path = _file(out, seed, number)
    if not path.exists():
        return False
    return not networks or "network_after_m" in json.loads(path.read_text())


def read_rows(out: Path, seed: int, cases: int) -> Iterator[Row]:
    """The rows there are."""
    for number in range(cases):
        path = _file(out, seed, number)
        if path.exists():
            yield _row(json.loads(path.read_text()))


def summary(rows: Sequence[Row]) -> list[tuple[str, str]]:
    """The figures of all rows in words."""
    ran = [row for row in rows if not row.failure]
    by_network = [row for row in ran if np.isfinite(row.network_after_m)]
    tables = [row for row in ran if np.isfinite(row.tables_m)]
    healthy = [row for row in ran if not row.hidden]
    return [
        ("as good as can be asked", _share([row.enough for row in ran])),
        ("the same with a network", _share([row.network_enough for row in by_network])),
        ("better with a table", _share([row.tables_m < row.after_m for row in tables])),
        ("as good with a table as can be asked", _share([row.tables_enough for row in tables])),
        ("made worse", _share([row.worse for row in ran])),
        ("changed with nothing wrong", _share([bool(row.corrected) for row in healthy])),
        ("failed", str(len(rows) - len(ran))),
    ]


def _share(each: Sequence[bool]) -> str:
    return f"{sum(each)} of {len(each)}"


def _row(found: dict[str, Any]) -> Row:
    names = (
        *("before_m", "after_m", "possible_m", "limit_m", "tables_m"),
        *("network_before_m", "network_after_m"),
    )
    sizes = {name: found.get(name) for name in names}
    return Row(
        number=found["number"],
        hidden=tuple(found["concealed"]),
        found=tuple(found.get("found", ())),
        corrected=tuple(found.get("corrected", ())),
        failure=found.get("failure", ""),
        **{name: np.nan if size is None else float(size) for name, size in sizes.items()},
    )


def _file(out: Path, seed: int, number: int) -> Path:
    return out / f"repair-{seed}-{number:04d}.json"
