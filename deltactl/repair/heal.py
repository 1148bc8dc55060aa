"""One safe sequence from a robot that draws badly to one that draws well.

Survey, diagnosis, experiments that break ties, correction, and the same job before and after it by
the sensors. Until a correction has been shown to help, the robot file is not touched.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from deltactl.diagnosis.answer.corrected_robot import corrected_text, sure
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.answer.tables import Tables
from deltactl.diagnosis.api import diagnose
from deltactl.diagnosis.experiment.propose import write_job
from deltactl.diagnosis.report.page import write_report
from deltactl.firmware_py.job_file import NetworkIk, load_job
from deltactl.firmware_py.job_targets import network_file
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import home_counts, plan_of
from deltactl.firmware_py.program.coverage import coverage_of
from deltactl.firmware_py.program.totals import program_of, summarise_program
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.errors import ConfigError, DeltactlError, MotionError
from deltactl.foundation.plain_file import check_place, said_of_output, write_whole
from deltactl.models.network.file import NetworkFile
from deltactl.models.robot_files import load_with_effects
from deltactl.repair.compared import Distance, Gain, Seen, distance, gain
from deltactl.repair.correct import as_found, moves_nothing, trained, with_network, work_list
from deltactl.repair.drawing import heart_for, refuse_other_machine
from deltactl.repair.heal_answer import REFUSED, ROLLED_BACK, if_kept, if_nothing
from deltactl.repair.healing_state import (
    BEFORE,
    EXPERIMENT,
    NEW,
    OLD,
    SURVEY,
    Healing,
    Recorded,
    digest_of,
    exchange,
    read_healing,
    write_healing,
)
from deltactl.repair.patients import Patient
from deltactl.repair.played import Paths
from deltactl.repair.surveys import (
    first_s,
    heights_in_the_way,
    left_s,
    more_s,
    of_the_later,
    open_s,
    read_above,
    settled,
    survey_in,
)
from deltactl.repair.worth import Worth, beside_goal, in_readings, ranked, worded

Say = Callable[[str], None]
Heights = Sequence[float]
CANDIDATE = "corrected.yaml"
MOST_EXPERIMENTS, MOST_SURVEYS = 2, 2
MOST_DRAWINGS = 5
"""So often is the job drawn before and after, while noise hides which is better."""

OLD_IN_FORCE = "the old robot file is in force"
GO_ON = "it goes on from there with --continue, or with Heal on the page"


@dataclass(frozen=True, slots=True)
class Order:
    """What is to be healed. minutes: of the survey, instead of what accuracy and noise ask for.

    job: of this machine; None for the heart, which any robot draws that can reach it. goal_m: what
    is near enough to its path, RMS; None for what a robot without any effect can do.
    """

    robot_file: Path
    job: Path | None
    out: Path
    minutes: float | None = None
    go_on: bool = False
    goal_m: float | None = None


class Healer:
    """Carries one order out; every step is written down before the next one begins.

    To make one raises ConfigError or MotionError for an order that cannot be carried out.
    """

    def __init__(self, order: Order, patient: Patient, say: Say, paths: Paths | None = None):
        """paths: of the job, where it was planned before."""
        self._order, self._patient, self._say = order, patient, say
        self._begun_s = time.monotonic()
        self._doing = "before anything moved"
        self._earlier: list[dict[str, str]] = []
        self._robot = self._checked()
        self._job = self._of_this_machine(self._robot)
        self._paths = paths or Paths(self._job)
        self._state = self._begin()

    def heal(self) -> dict[str, Any]:
        """The answer, as JSON. Raises DeltactlError, which names the file in force."""
        if self._state.answer is not None:
            return self._state.answer
        try:
            return self._carried_out(self._robot)
        except DeltactlError as error:
            kept = self._state.is_exchanged
            says = "the corrected robot file is in force" if kept else OLD_IN_FORCE
            raise error.worded(f"{self._doing}: {error}; {says}; {GO_ON}") from error

    def _carried_out(self, robot: RobotFile) -> dict[str, Any]:
        if self._state.kept is not None and self._state.is_exchanged:
            return self._ended(self._kept(self._state.kept))
        if not self._state.of(SURVEY):
            self._record_first_survey(robot)
        answer = self._diagnosed()
        for _ in range(MOST_EXPERIMENTS - len(self._state.of(EXPERIMENT))):
            if answer.next_experiment is None or all(sure(one, answer) for one in answer.findings):
                break
            self._record_experiment(answer)
            answer = self._diagnosed()
        while (more_s := self._more_s(answer)) > 0.0:
            self._record_survey(robot, more_s, heights_in_the_way(answer))
            answer = self._diagnosed()
        return self._ended(self._treated(robot, answer))

    def _begin(self) -> Healing:
        """The state to go on from: an unfinished one of the same file, or a new one."""
        order = self._order
        order.out.mkdir(parents=True, exist_ok=True)
        old, robot_file = read_healing(order.out), order.robot_file.resolve()
        if old is not None and old.robot_file != robot_file:
            raise ConfigError(f"{order.out}: is of {old.robot_file}; name another --out")
        if order.go_on and old is None:
            raise ConfigError(f"{order.out}: no healing was begun here; leave --continue out")
        now = digest_of(robot_file)
        if order.go_on and old is not None:
            same = old.old_sha256 == now or (old.kept is not None and old.is_exchanged)
            if old.answer is None and same and old.job == self._job.resolve():
                self._say(f"going on after: {old.step or 'nothing yet'}")
                return old
            self._earlier = (old.answer or {}).get("by_hand", [])
        new = Healing(robot_file=robot_file, job=self._job.resolve(), old_sha256=now)
        if old is not None and old.exchange is not None and old.exchange.new_sha256 == now:
            new = new.model_copy(update={"exchange": old.exchange})  # it can still be undone
        write_healing(order.out, new)
        return new

    def _checked(self) -> RobotFile:
        """Before anything moves: a robot that is seen and whose file can be written.

        Raises ConfigError, RecordingError.
        """
        path = self._order.robot_file
        if path.resolve().parent == CONFIG_FOLDER.resolve():
            raise ConfigError(f"{path.name}: is an example; copy {path} first, and heal the copy")
        robot = load_robot(path)
        with said_of_output(path):
            check_place(path)
        if robot.drive.kind == "servo":
            raise ConfigError(f"{path}: has servo drives; only steppers can be healed")
        if robot.sensors is None:
            raise ConfigError(f"{path}: has no sensors; nothing can be measured")
        return robot

    def _of_this_machine(self, robot: RobotFile) -> Path:
        """The job, which this robot can draw. Raises ConfigError, MotionError, RecordingError."""
        order = self._order
        job = heart_for(order.robot_file, order.out) if order.job is None else order.job
        refuse_other_machine(job, robot)
        self._check_job(job, robot)
        plan_of(job, robot)
        return job

    def _check_job(self, job: Path, robot: RobotFile) -> None:
        program = program_of(job, robot)
        summarise_program(program, home_counts(program.robot))

    def _record_first_survey(self, robot: RobotFile) -> None:
        self._do("homing, and holding the sensors against each other (about 5 s)")
        path, given = self._order.robot_file, self._order.minutes
        homed = self._patient.home(path)
        self._say(f"home: {homed.text}; readings scatter by {homed.noise_m * 1e3:.2f} mm")
        seconds = first_s(self._job, path, homed.noise_m) if given is None else 60.0 * given
        self._record_survey(robot, seconds)

    def _record_survey(self, robot: RobotFile, seconds: float, above_m: Heights = ()) -> None:
        """above_m: heights that it keeps above."""
        number = len(self._state.of(SURVEY)) + 1
        job = self._order.out / ("survey.yaml" if number == 1 else f"survey-{number}.yaml")
        survey = survey_in(seconds, robot, self._order.robot_file, number, above_m)
        write_whole(job, yaml.safe_dump(survey))
        self._check_job(job, robot)
        what = f"{'another ' if number > 1 else ''}survey of {survey['path']['count']} poses"
        self._run(SURVEY, job, f"{what} ({seconds / 60.0:.0f} min)")

    def _more_s(self, answer: Diagnosis) -> float:
        """How much longer the sizes have to be surveyed [s]; 0 for a length that was given."""
        surveys = self._state.of(SURVEY)
        if self._order.minutes is not None or len(surveys) >= MOST_SURVEYS:
            return 0.0
        text = corrected_text(self._order.robot_file, answer, tables=Tables.SENSORS)
        write_whole(self._candidate, text)
        surveyed_s, robot_s = sum(one.seconds for one in surveys), self._state.robot_s
        again_s = open_s(answer, surveyed_s, left_s(robot_s, self._paths.path(self._robot)))
        return again_s or more_s(self._job, self._paths, self._candidate, surveyed_s, robot_s)

    @property
    def _candidate(self) -> Path:
        return self._order.out.resolve() / CANDIDATE

    def _record_experiment(self, answer: Diagnosis) -> None:
        experiment = answer.next_experiment
        assert experiment is not None
        job = self._order.out / f"experiment-{len(self._state.of(EXPERIMENT)) + 1}.yaml"
        write_job(experiment, job, self._order.robot_file)
        self._run(
            EXPERIMENT,
            job,
            f"experiment that tells apart {', '.join(experiment.tells_apart)}"
            f" ({experiment.minutes:.1f} min)",
        )

    def _run(self, kind: str, job: Path, what: str, robot_file: Path | None = None) -> Recorded:
        """Run and record a job by the robot file in force, or by another, and write it down."""
        self._do(what)
        number = len(self._state.recordings)
        name = self._order.out.resolve() / f"{kind}-{number}-{time.time_ns() // 1_000_000}"
        robot_file = robot_file or self._order.robot_file
        ran = self._patient.run(job, robot_file, name)
        made = Recorded(kind=kind, file=ran.recording, seconds=ran.seconds)
        self._write(what, recordings=(*self._state.recordings, made))
        return made

    def _do(self, what: str) -> None:
        """Something that takes a while begins."""
        self._doing = what.partition(" (")[0]
        self._say(what)

    def _write(self, step: str, **changes: Any) -> None:
        self._state = self._state.model_copy(update={"step": step, **changes})
        write_healing(self._order.out, self._state)

    def _diagnosed(self) -> Diagnosis:
        """All recordings, without readings while something was in the way; where that leaves
        something open, those before the second survey, or those after the first, if they do not.
        """
        files = [one.file for one in self._state.of(SURVEY, EXPERIMENT)]
        if len(self._state.of(SURVEY)) < MOST_SURVEYS:
            return self._diagnosis_of(files, "")
        earlier = self._diagnosis_of(files[:-1], "")
        heights_m = heights_in_the_way(earlier)
        answer = self._diagnosis_of(files, "clear " if heights_m else "", heights_m)
        if settled(answer) or settled(earlier):
            best = answer if settled(answer) else earlier
            return of_the_later(earlier, best) if heights_m else best
        return of_the_later(answer, self._diagnosis_of(files[1:], "later "))

    def _diagnosis_of(self, files: list[Path], which: str, above_m: Heights = ()) -> Diagnosis:
        """Worked out once for each number of recordings, all or the `which` ones.

        above_m: heights of what was in the way in some of them.
        """
        kept = self._order.out / f"diagnosis-{which.replace(' ', '-')}{len(files)}.json"
        step = f"diagnosis of {len(files)} {which}recording{'s' if len(files) > 1 else ''}"
        if kept.exists():
            answer = Diagnosis.model_validate_json(kept.read_text(encoding="utf-8"))
            if answer.recordings == [str(file) for file in files]:
                return answer
        self._do(f"{step} (about a minute on a PC)")
        read = read_above(self._robot, above_m) if above_m else None
        answer = diagnose(files, self._order.robot_file, read=read)
        write_whole(kept, json.dumps(answer.to_json()) + "\n")
        self._write(step)
        return answer

    def _treated(self, robot: RobotFile, answer: Diagnosis) -> dict[str, Any]:
        """Correct, draw before and after, keep or leave; what came of it."""
        path = self._order.robot_file
        found: dict[str, Any] = {"found": [finding.says for finding in answer.findings]}
        text = corrected_text(path, answer, tables=Tables.SENSORS)
        candidate = self._candidate
        write_whole(candidate, text)
        try:
            corrected = self._with_network(load_robot(candidate), candidate)
            old, new = self._paths.path(robot), self._paths.path(corrected)
            self._check_job(self._job, corrected)
        except (ConfigError, MotionError) as error:
            by_hand = work_list(answer, robot, coverage_of(self._job, path))
            why = f"a machine cannot have or follow the correction: {error}"
            return found | {"outcome": REFUSED, "why": why, "by_hand": by_hand}
        real = as_found(path, corrected, answer)
        found |= beside_goal(self._paths, robot, corrected, real, self._order.goal_m)
        if new.is_same_as(old):
            by_hand = work_list(answer, robot, coverage_of(self._job, path))
            by_hand += moves_nothing(answer, by_hand)
            return found | {"outcome": if_nothing(found), "by_hand": by_hand}
        covered = coverage_of(self._job, candidate)
        found["worth"] = worded(self._ranked(robot, corrected), covered)
        before, after, better = self._drawn(candidate, corrected)
        measured = {
            "before_rms_m": before.rms_m,
            "before_ci95_m": before.ci95_m,
            "after_rms_m": after.rms_m,
            "after_ci95_m": after.ci95_m,
            "gain_m2": better.square_m2,
            "gain_ci95_m2": better.ci95_m2,
            "drawings": len(self._state.of(OLD)),
            "readings": worded(in_readings(self._seen(NEW), robot, corrected), covered),
            "by_hand": work_list(answer, corrected, covered),
            "corrected": [effect.says for effect in covered.compensated],
        }
        if better.sign != 1:
            return found | measured | {"outcome": ROLLED_BACK}
        self._do("keeping the correction, and homing by it")
        kept = found | measured
        kept["outcome"] = if_kept(kept)
        self._write("a correction that is to be kept", kept=kept)
        self._state = exchange(self._order.out, self._state, candidate.read_text(encoding="utf-8"))
        return self._kept(kept)

    def _kept(self, answer: dict[str, Any]) -> dict[str, Any]:
        """The corrected file has taken the place of the old one: the robot is homed by it."""
        self._patient.home(self._order.robot_file)
        return answer

    def _ranked(self, robot: RobotFile, corrected: RobotFile) -> list[Worth]:
        """What each correction is worth; nothing for a network, which learned all of them."""
        if isinstance(load_job(self._job).inverse_kinematics, NetworkIk):
            return []
        return ranked(self._paths, robot, corrected)

    def _with_network(self, robot: RobotFile, candidate: Path) -> RobotFile:
        """The same with a network that learned the correction in place of the job's, if it has one.

        Whatever its shape: what the job's network was taught is not what the robot is.
        """
        chosen = load_job(self._job).inverse_kinematics
        if not isinstance(chosen, NetworkIk):
            return robot
        self._do("training the network of the corrected robot (about half a minute)")
        replaces = NetworkFile.load(network_file(chosen, robot, self._job))
        learned = trained(robot, candidate.with_suffix(".tflite"), replaces=replaces)
        if learned is None:
            return robot
        text = candidate.read_text(encoding="utf-8")
        write_whole(candidate, with_network(text, robot, chosen.file, learned[1]))
        return load_robot(candidate)

    def _drawn(self, candidate: Path, corrected: RobotFile) -> tuple[Distance, Distance, Gain]:
        """The job before and after, again while noise hides which is nearer to its path and there
        is time.
        """
        job, path = self._job, self._order.robot_file
        while True:
            for kind, file in ((OLD, path), (NEW, candidate)):
                done = min(len(self._state.of(OLD)), len(self._state.of(NEW)))
                if len(self._state.of(kind)) == done and done < MOST_DRAWINGS:
                    words = "as it was" if kind == OLD else "corrected"
                    self._run(kind, job, f"drawing {job.name}, the robot {words}", file)
            drawn, redrawn = self._seen(OLD), self._seen(NEW)
            before, after = (distance(runs, corrected) for runs in (drawn, redrawn))
            better = gain(drawn, redrawn, corrected)
            self._say(f"by the sensors: before {before.text}, after {after.text}")
            over = left_s(self._state.robot_s, self._paths.path(corrected), times=1) < 0.0
            if over or better.sign != 0 or len(self._state.of(NEW)) >= MOST_DRAWINGS:
                return before, after, better

    def _seen(self, kind: str) -> list[Seen]:
        file = self._order.robot_file if kind == OLD else self._candidate
        return [self._patient.seen(one.file, self._job, file) for one in self._state.of(kind)]

    def _ended(self, answer: dict[str, Any]) -> dict[str, Any]:
        report = self._order.out / "report.html"
        old = self._order.out / BEFORE if self._state.is_exchanged else self._order.robot_file
        write_report(self._diagnosed(), load_with_effects(old), report)
        open_now = {(one["effect"], one["component"]) for one in answer["by_hand"]}
        answer |= {
            "robot": str(self._order.robot_file),
            "report": str(report),
            "job": str(self._job),
            "robot_s": self._state.robot_s,
            "took_s": time.monotonic() - self._begun_s,
            "recordings": [str(one.file) for one in self._state.recordings],
            "done_by_hand": [
                one["says"]
                for one in self._earlier
                if (one["effect"], one["component"]) not in open_now
            ],
        }
        self._write("the end", answer=answer)
        return answer
