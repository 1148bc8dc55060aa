"""Figures of a whole program, and of what a job file would do, without doing it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from operator import mul
from pathlib import Path
from typing import TypeVar

from deltactl.drivers.steps.contract import Counts
from deltactl.firmware_py.job_targets import kinematics_of
from deltactl.firmware_py.named_files import ROBOT_KEY, find
from deltactl.firmware_py.planner.plan import Plan, home_counts
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.planner.summary import CheckSummary, Range, slower, summarise
from deltactl.firmware_py.program.building import make_program, told_with
from deltactl.firmware_py.program.includes import read_whole
from deltactl.firmware_py.program.instructions import (
    Leaf,
    Move,
    Pause,
    Program,
    Wait,
    WaitFor,
    visit,
)
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.clock import NS_PER_S, ns

Figure = TypeVar("Figure")


@dataclass
class Totals:
    """What adds up while a program is gone through."""

    duration_ns: int = 0
    waits_s: float = 0.0
    pauses: int = 0
    instructions: int = 0
    streams: dict[tuple[int, Counts], int] = field(default_factory=dict)
    moves: list[tuple[Plan, Counts, int]] = field(default_factory=list)

    def tell(self, leaf: Leaf, counts: Counts, times: int) -> None:
        """See instructions.Visit."""
        self.instructions += times
        if isinstance(leaf, Move):
            self.duration_ns += times * self.move_ns(leaf.plan, counts)
            self.moves.append((leaf.plan, counts, times))
        elif isinstance(leaf, Wait):
            self.duration_ns += times * ns(leaf.seconds)
        elif isinstance(leaf, WaitFor):
            self.waits_s += times * leaf.within_s
        elif isinstance(leaf, Pause):
            self.pauses += times

    def move_ns(self, plan: Plan, counts: Counts) -> int:
        """How long a move takes, with the way to its beginning."""
        key = (id(plan), counts)
        if key not in self.streams:
            self.streams[key] = MotionStream(plan, counts).end_ns
        return self.streams[key]


def totals(program: Program, from_counts: Counts) -> Totals:
    """Totals of a program from some counts. Raises UnreachablePoint for a way to a path's start."""
    found = Totals()
    visit(program.whole, from_counts, found.tell)
    return found


def summarise_program(program: Program, from_counts: Counts) -> CheckSummary:
    """One summary of all moves. Raises UnreachablePoint for a way to a path's start."""
    if program.job.steps is None and program.first is not None:
        return summarise(program.first, from_counts)
    found = totals(program, from_counts)
    still = _without_moves(program, found)
    if not found.moves:
        return still
    plans, starts, times = zip(*found.moves, strict=True)
    ones = list(map(summarise, plans, starts))

    def every(figure: Callable[[CheckSummary], Figure]) -> list[Figure]:
        return [figure(one) for one in ones]

    moving_s = sum(map(mul, times, every(lambda one: one.moving_s)))
    length_m = sum(map(mul, times, every(lambda one: one.path_length_m)))
    in_all = sum(map(mul, times, every(lambda one: one.targets_in_all)))
    return replace(
        still,
        inverse_kinematics=_either(every(lambda one: one.inverse_kinematics)),
        timing=_either(every(lambda one: one.timing)),
        targets=in_all,
        targets_in_all=in_all,
        path_length_m=length_m,
        approach_s=sum(map(mul, times, every(lambda one: one.approach_s))),
        moving_s=moving_s,
        mean_speed_mps=length_m / moving_s if moving_s > 0.0 else 0.0,
        peak_step_rate_hz=_largest(every(lambda one: one.peak_step_rate_hz)),
        approach_step_rate_hz=max(every(lambda one: one.approach_step_rate_hz)),
        arm_range_deg=_ranges(every(lambda one: one.arm_range_deg)),
        smallest_margin=min(every(lambda one: one.smallest_margin)),
        box_m=_ranges(every(lambda one: one.box_m)),
        slower=slower(plans),
    )


def _without_moves(program: Program, found: Totals) -> CheckSummary:
    nowhere: Range = (0.0, 0.0)
    return CheckSummary(
        job=program.job.name,
        robot=program.robot.name,
        inverse_kinematics="none",
        timing="none",
        targets=0,
        repeats=1,
        targets_in_all=0,
        path_length_m=0.0,
        duration_s=found.duration_ns / NS_PER_S,
        approach_s=0.0,
        moving_s=0.0,
        mean_speed_mps=0.0,
        path_per_step_period_m=None,
        peak_step_rate_hz=(0.0, 0.0, 0.0),
        approach_step_rate_hz=0.0,
        arm_range_deg=(nowhere,) * 3,
        smallest_margin=1.0,
        box_m=(nowhere,) * 3,
        instructions=found.instructions,
        waits_at_most_s=found.waits_s,
        pauses=found.pauses,
    )


def _either(words: list[str]) -> str:
    return "; ".join(dict.fromkeys(words))


def _largest(triples: list[tuple[float, float, float]]) -> tuple[float, float, float]:
    first, second, third = (max(column) for column in zip(*triples, strict=True))
    return first, second, third


def _ranges(triples: list[tuple[Range, Range, Range]]) -> tuple[Range, Range, Range]:
    first, second, third = (
        (min(low for low, _ in column), max(high for _, high in column))
        for column in zip(*triples, strict=True)
    )
    return first, second, third


def check_job(
    job_path: Path, from_counts: Counts | None = None, robot_file: Path | None = None
) -> CheckSummary:
    """Dry run of a job file from home (or other counts): what it would do.

    `robot_file`: instead of the one the job names. Raises MissingFile, ConfigError,
    NetworkError, UnreachablePoint or LimitExceeded.
    """
    robot = None if robot_file is None else load_robot(robot_file)
    program = program_of(job_path, robot, from_counts)
    return summarise_program(program, from_counts or home_counts(program.robot))


def program_of(
    job_path: Path, robot: RobotFile | None = None, from_counts: Counts | None = None
) -> Program:
    """The program of a job file, for the robot it names or for one that is there already."""
    job = read_whole(job_path, robot=robot).job
    if robot is None:
        robot = load_robot(find(job.robot, beside=job_path, key=ROBOT_KEY))
    known = robot
    with told_with(job_path):
        return make_program(
            job, known, lambda one: kinematics_of(one, known, job_path), from_counts
        )
