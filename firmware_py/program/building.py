"""From a job, with all it includes, to a program that may run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from deltactl.drivers.steps.contract import Counts
from deltactl.firmware_py.job_file import (
    InnerJob,
    JobFile,
    JobStep,
    PathStep,
    PauseStep,
    RepeatStep,
    SetStep,
    Step,
    WaitForStep,
    WaitStep,
)
from deltactl.firmware_py.path_file import PathSpec, Way
from deltactl.firmware_py.planner.plan import home_counts, make_plan
from deltactl.firmware_py.program.instructions import (
    Block,
    Instruction,
    Leaf,
    Move,
    Pause,
    Program,
    SetOutputs,
    Wait,
    WaitFor,
    visit,
)
from deltactl.firmware_py.program.names_used import unknown
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import ConfigError, LimitExceeded, UnreachablePoint
from deltactl.models.inverse_kinematics import InverseKinematics

KinematicsOf = Callable[[JobFile], InverseKinematics]


def make_program(
    job: JobFile, robot: RobotFile, kinematics_of: KinematicsOf, from_counts: Counts | None = None
) -> Program:
    """Check everything a job does, along the whole of it.

    from_counts: where the arms are before it, home where that is not known.
    Raises ConfigError, UnreachablePoint or LimitExceeded, naming the step and its first bad point.
    """
    if job.path is not None:
        plan = make_plan(job, robot, kinematics_of(job))
        return Program(job, robot, Block(1, (Move(plan),)))
    builder = _Builder(job, robot, kinematics_of)
    whole = Block(job.repeats, builder.block(job.steps or (), job, "steps"))
    _check_ways(whole, from_counts or home_counts(robot))
    return Program(job, robot, whole)


def _check_ways(whole: Block, counts: Counts) -> None:
    """Find the way to each move from where the arms are then. Raises UnreachablePoint."""
    known: set[tuple[int, Counts]] = set()

    def tell(leaf: Leaf, counts: Counts, times: int) -> None:
        if isinstance(leaf, Move) and (id(leaf.plan), counts) not in known:
            known.add((id(leaf.plan), counts))
            leaf.plan.way_in(counts)

    visit(whole, counts, tell)


class _Builder:
    """Plans each path once, however often it is followed."""

    def __init__(self, job: JobFile, robot: RobotFile, kinematics_of: KinematicsOf):
        self._outer, self._robot, self._kinematics_of = job, robot, kinematics_of
        self._made: dict[JobFile, Move] = {}
        self._end_m: tuple[float, float, float] | None = None

    def block(self, steps: Iterable[Step], job: JobFile, place: str) -> tuple[Instruction, ...]:
        """The instructions of steps; `job` has their timing and kinematics."""
        return tuple(
            self._instruction(one, job, f"{place}.{number}") for number, one in enumerate(steps)
        )

    def _instruction(self, one: Any, job: JobFile, place: str) -> Instruction:
        if isinstance(one, PathStep):
            timing = one.timing or job.timing
            return self._move(job, {"path": one.path, "timing": timing, "repeats": 1}, place)
        if isinstance(one, SetStep):
            self._check_known(one.set, self._robot.outputs, "outputs", f"{place}.set")
            return SetOutputs(dict(one.set))
        if isinstance(one, WaitStep):
            return Wait(one.wait_s)
        if isinstance(one, WaitForStep):
            wanted = one.wait_for
            named = self._robot.inputs.named
            self._check_known([wanted.input], named, "inputs.named", f"{place}.wait_for")
            return WaitFor(wanted.input, wanted.is_on, wanted.within_s)
        if isinstance(one, PauseStep):
            return Pause(one.pause)
        if isinstance(one, RepeatStep):
            return Block(one.repeat, self.block(one.steps, job, f"{place}.steps"))
        if isinstance(one, JobStep):
            return self._inner(one.job, f"{place}.job")
        raise ConfigError(f"{place}: an include that was not read; name the job by its file")

    def _inner(self, inner: InnerJob, place: str) -> Instruction:
        own = {"timing": inner.timing, "inverse_kinematics": inner.inverse_kinematics}
        job = self._outer.model_copy(update=own | {"name": inner.name})
        if inner.path is not None:
            return self._move(job, {"path": inner.path, "repeats": inner.repeats}, place)
        return Block(inner.repeats, self.block(inner.steps or (), job, f"{place}.steps"))

    def _move(self, job: JobFile, own: dict[str, Any], place: str) -> Move:
        own["path"] = self._begun(own["path"], place)
        try:
            key = job.model_copy(update=own | {"steps": None})
            if key not in self._made:
                path = type(own["path"]).model_validate(dict(own["path"]))
                job = JobFile.model_validate(dict(key) | {"path": path})
                self._made[key] = Move(make_plan(job, self._robot, self._kinematics_of(job)))
        except (ConfigError, LimitExceeded, UnreachablePoint) as error:
            raise error.worded(f"{place}: {error}") from error
        except ValueError as error:
            raise ConfigError(f"{place}: {_plain(error)}") from error
        move = self._made[key]
        end = (move.plan.again or move.plan.first).lap.position_m[-1].tolist()
        self._end_m = (end[0], end[1], end[2])
        return move

    def _begun(self, path: PathSpec, place: str) -> PathSpec:
        if not isinstance(path, Way) or path.start_m is not None:
            return path
        if self._end_m is None:
            raise ConfigError(f"{place}.path.start_m: is missing, and no path comes before it")
        return path.model_copy(update={"start_m": self._end_m})

    def _check_known(
        self, named: Iterable[str], known: Mapping[str, Any], section: str, place: str
    ) -> None:
        for says in unknown(named, known, section, self._robot):
            raise ConfigError(f"{place}: {says}")


def _plain(error: ValueError) -> str:
    """What a validator said, without pydantic's frame around it."""
    found = getattr(error, "errors", None)
    return str(found()[0]["msg"]).removeprefix("Value error, ") if found else str(error)


@contextmanager
def told_with(job_file: Path | str) -> Iterator[None]:
    """Put the job file before whatever breaks a limit within."""
    try:
        yield
    except (LimitExceeded, UnreachablePoint) as error:
        raise error.worded(f"{job_file}: {error}") from error
