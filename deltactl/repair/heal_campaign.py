"""The blind proof of healing: MuJoCo robots with hidden causes go through the whole sequence.

What counts is where the platform truly was while it drew, which the healing never sees.
"""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Iterator, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any, cast

import numpy as np

from deltactl.firmware_py.planner.plan import plan_of
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.plain_file import write_whole
from deltactl.models.robot import AXES
from deltactl.proof.hidden.vocabulary import SINGLES
from deltactl.proof.prove.resumable import Means, workers
from deltactl.proof.recorded import record as recorded
from deltactl.proof.robot.as_built import StepTrain
from deltactl.recording.tables.flat_files import write_flat
from deltactl.repair.campaign import JOB, ROBOT, WORSE, WORSE_M
from deltactl.repair.compared import Seen
from deltactl.repair.heal import CANDIDATE, Healer, Order
from deltactl.repair.limit import ENOUGH, ENOUGH_M
from deltactl.repair.machine import FaultyRobot, faulty_robot
from deltactl.repair.patients import Homed, Ran
from deltactl.repair.played import Drawn, Paths, played
from deltactl.repair.worth import ranked

HEALTHY_EVERY = 6
"""Every sixth robot has no hidden cause."""
MOST_CAUSES = 3
KEPT_OF_ANSWER = (
    *("outcome", "found", "corrected", "by_hand", "robot_s", "drawings", "why"),
    *("goal_m", "expected_m"),
)
PLANS = 12
"""So many are remembered: before, after, and with each repair alone."""
AS_GOOD = 1.02
"""A repair that leaves so little more than the best is as good."""


class ProofPatient:
    """A robot of the independent simulator, as a healing sees it."""

    def __init__(self, machine: FaultyRobot, job: Path, paths: Paths):
        """paths: of the job that is drawn before and after."""
        self._machine, self._job, self._paths = machine, job, paths
        self._seen: dict[Path, Seen] = {}

    def home(self, robot_file: Path) -> Homed:
        """See Patient; it always starts from home."""
        return Homed("simulated", self._machine.machine.noise.sigma_m)

    def run(self, job: Path, robot_file: Path, record: Path) -> Ran:
        """See Patient."""
        robot = load_robot(robot_file)
        motion = self._paths.path(robot) if job == self._job else played(plan_of(job, robot))
        rng = np.random.default_rng([self._machine.seed, 11, len(self._seen)])
        table = recorded(self._machine.machine, cast(StepTrain, motion), rng)
        path = record.with_suffix(".csv.gz")
        write_flat(table, path)
        columns = [
            np.interp(table.t_s, motion.target_s, column, np.nan, np.nan)
            for column in motion.target_m.T
        ]
        target_m = np.stack(columns, axis=1)
        self._seen[path] = Seen(table, np.repeat(target_m[:, None, :], len(AXES), axis=1))
        return Ran(path, motion.seconds)

    def seen(self, recording: Path, job: Path, robot_file: Path) -> Seen:
        """See Patient."""
        return self._seen[recording]


def causes_of(seed: int, number: int) -> list[str]:
    """The hidden causes of a case: none, or one to three different ones."""
    if number % HEALTHY_EVERY == HEALTHY_EVERY - 1:
        return []
    rng = np.random.default_rng([seed, number, 13])
    return [str(name) for name in rng.permutation(SINGLES)[: rng.integers(1, MOST_CAUSES + 1)]]


def heal_case(seed: int, number: int, folder: Path) -> dict[str, Any]:
    """One robot as JSON, distances from the target RMS [m]; a refusal is a result too."""
    causes = causes_of(seed, number)
    result: dict[str, Any] = {"number": number, "hidden": causes}
    work = folder / f"heal-{seed}-{number:04d}"
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    robot_file = work / ROBOT.name
    write_whole(robot_file, ROBOT.read_bytes())
    machine, paths = faulty_robot(causes, 1000 * seed + number), Paths(JOB, PLANS)
    before = _drawn(machine, paths, robot_file)
    try:
        order = Order(robot_file, JOB, work / "healing")
        patient = ProofPatient(machine, JOB, paths)
        answer = Healer(order, patient, lambda _: None, paths).heal()
        result |= {name: answer[name] for name in KEPT_OF_ANSWER if name in answer}
    except DeltactlError as error:
        result |= {"outcome": "failed", "why": str(error)}
    corrected = work / "healing" / CANDIDATE
    if corrected.exists():
        result["advice"] = advice(machine, paths, ROBOT, corrected)
    changed = robot_file.read_bytes() != ROBOT.read_bytes()
    after = _drawn(machine, paths, robot_file) if changed else before
    for recording in work.glob("healing/*.csv.gz"):
        recording.unlink()
    return result | {
        "changed": changed,
        "before_m": before.rms_m,
        "after_m": after.rms_m,
        "possible_m": possible_m(),
    }


@cache
def possible_m() -> float:
    """What a robot with nothing wrong draws, RMS [m]."""
    return _drawn(faulty_robot([], 0), Paths(JOB), ROBOT).rms_m


def advice(machine: FaultyRobot, paths: Paths, old: Path, corrected: Path) -> list[dict[str, Any]]:
    """What each repair alone was said to be worth, best first, and what it truly is.

    as JSON: `alone_m` and `ci95_m` as predicted, `true_m` as drawn [m]. The prediction takes the
    robot to be as the corrected file says; the truth is that of the machine.
    """
    robot, better = load_robot(old), load_robot(corrected)
    rows = []
    for worth in ranked(paths, robot, better):
        name = (worth.effect, worth.component)
        kept = [one for one in robot.effects if (one.effect, one.component) != name]
        taken = [one for one in better.effects if (one.effect, one.component) == name]
        alone = robot.model_copy(update={"effects": (*kept, *taken)})
        true_m = machine.draw(paths.path(alone)).rms_m
        rows.append(worth.as_json() | {"true_m": true_m})
    return rows


def _drawn(machine: FaultyRobot, paths: Paths, robot_file: Path) -> Drawn:
    return machine.draw(paths.path(load_robot(robot_file)))


def prove_heal(cases: int, seed: int, out: Path, means: Means) -> list[dict[str, Any]]:
    """Run what is not in `out` yet; all results there are, in order."""
    until = time.monotonic() + 60.0 * means.minutes
    out.mkdir(parents=True, exist_ok=True)
    missing = [number for number in range(cases) if not _file(out, seed, number).exists()]
    means.progress(cases - len(missing), cases, "")
    with workers(means.count, means.scheduler, means.say) as at_work:
        jobs = [(partial(heal_case, folder=out.resolve()), seed, number) for number in missing]
        for done, (place, result) in enumerate(at_work(jobs), start=1):
            text = json.dumps(result, indent=1, default=str) + "\n"
            write_whole(_file(out, seed, missing[place]), text)
            means.progress(cases - len(missing) + done, cases, "")
            if time.monotonic() > until and done < len(missing):
                means.say("time is up; the same command again goes on")
                break
    return list(_read(out, seed, cases))


def _read(out: Path, seed: int, cases: int) -> Iterator[dict[str, Any]]:
    for number in range(cases):
        path = _file(out, seed, number)
        if path.exists():
            yield json.loads(path.read_text())


def _file(out: Path, seed: int, number: int) -> Path:
    return out / f"heal-{seed}-{number:04d}.json"


def enough(row: dict[str, Any]) -> bool:
    """Whether it draws as well as can be asked."""
    return bool(row["after_m"] <= max(ENOUGH * row["possible_m"], ENOUGH_M))


def worse(row: dict[str, Any]) -> bool:
    """Whether it draws worse than before."""
    return bool(row["after_m"] > max(WORSE * row["before_m"], row["before_m"] + WORSE_M))


def figures(rows: Sequence[dict[str, Any]]) -> list[tuple[str, str]]:
    """The figures of all rows in words."""
    ill = [row for row in rows if row["hidden"]]
    healthy = [row for row in rows if not row["hidden"]]
    times = [row["robot_s"] / 60.0 for row in rows if "robot_s" in row]
    lasted = f"median {np.median(times):.1f}, most {max(times):.1f} minutes" if times else "-"
    return [
        ("as good as can be asked", _share([enough(row) for row in ill])),
        ("made worse", _share([worse(row) for row in rows])),
        ("healthy robots changed", _share([row["changed"] for row in healthy])),
        ("predicted gain of one repair within its interval", _share(predicted(rows))),
        ("first advice is the best repair", _share(best_first(rows))),
        ("rolled back or refused", str(_count(rows, "rolled_back", "refused"))),
        ("failed", str(_count(rows, "failed"))),
        ("robot time", lasted),
    ]


def predicted(rows: Sequence[dict[str, Any]]) -> list[bool]:
    """For each repair: whether what it truly draws alone lies in the predicted interval."""
    every = [one for row in rows for one in row.get("advice", [])]
    return [one["ci95_m"][0] <= one["true_m"] <= one["ci95_m"][1] for one in every]


def best_first(rows: Sequence[dict[str, Any]]) -> list[bool]:
    """For each robot with several repairs: whether the first advice is the best, or as good."""
    several = [row["advice"] for row in rows if len(row.get("advice", [])) > 1]
    return [
        ranking[0]["true_m"] <= AS_GOOD * min(one["true_m"] for one in ranking)
        for ranking in several
    ]


def _count(rows: Sequence[dict[str, Any]], *outcomes: str) -> int:
    return sum(row["outcome"] in outcomes for row in rows)


def _share(each: Sequence[bool]) -> str:
    return f"{sum(each)} of {len(each)}"
