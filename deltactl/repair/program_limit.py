"""What tracking is possible in a whole job: of one path, or of many with steps between them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from deltactl.drivers.steps.contract import Counts
from deltactl.firmware_py.planner.check import home_counts
from deltactl.firmware_py.planner.plan import Plan
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.program.instructions import Leaf, Move, Program, visit
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.linkage import Linkage, jacobian
from deltactl.models.robot import AXES, FloatArray
from deltactl.repair.coverage import coverage
from deltactl.repair.limit import MOST_S, Limit, limit_of

AT_ONCE = 20_000
"""Targets looked at together: a few MB."""
IN_ANGLES = "none to state: the path is given in arm angles, which are commanded as they are"
BY_SERVO = "none to state: it lies in how closely the servo drives follow, which is not in the file"
NO_PATH = "none to state: nothing moves"


def limit_of_program(program: Program, job_path: Path) -> Limit | str:
    """Of all targets in space, each move as often as it comes; or a sentence why there is none.

    The first `MOST_S` of a job stand for the whole of it. Raises MotionError, NetworkError.
    """
    if program.robot.drive.kind == "servo":
        return BY_SERVO
    moves = _Moves()
    visit(program.whole, home_counts(program.robot), moves.tell)
    if not moves.first:
        return NO_PATH
    found: list[tuple[Limit, float]] = []
    left_s = MOST_S
    for plan, counts in moves.first.values():
        covered = coverage(plan.job, program.robot, job_path)
        limit = limit_of(plan, covered, counts, left_s) if left_s > 0.0 else None
        if limit is not None:
            left_s -= MotionStream(plan, counts).end_ns / NS_PER_S
            found.append((limit, float(moves.targets[id(plan)])))
    return _together(found) if found else IN_ANGLES


def microstep_m(program: Program) -> FloatArray:
    """How far one microstep of every arm moves the platform at most in x, y and z, (3,) [m].

    Where it moves it farthest on any of the paths.
    """
    linkage = Linkage.of(program.robot.geometry)
    farthest = np.zeros(len(AXES))
    for plan in program.plans():
        lap = plan.first.lap
        for first in range(0, len(lap), AT_ONCE):
            some = slice(first, first + AT_ONCE)
            moved = np.abs(jacobian(linkage, lap.angles_rad[some], lap.position_m[some]))
            farthest = np.fmax(farthest, np.nanmax(moved.sum(axis=-1), axis=0, initial=0.0))
    return farthest * program.robot.drive.rad_per_step


@dataclass
class _Moves:
    """Each plan from where the arms are when it first comes, and how many targets it has in all."""

    first: dict[int, tuple[Plan, Counts]] = field(default_factory=dict)
    targets: dict[int, int] = field(default_factory=dict)

    def tell(self, leaf: Leaf, counts: Counts, times: int) -> None:
        """See instructions.Visit."""
        if not isinstance(leaf, Move):
            return
        plan = leaf.plan
        self.first.setdefault(id(plan), (plan, counts))
        again = times * plan.job.repeats * len(plan.first.lap)
        self.targets[id(plan)] = self.targets.get(id(plan), 0) + again


def _together(found: list[tuple[Limit, float]]) -> Limit:
    """Mean squares, weighed by targets."""
    weights = [weight for _, weight in found]

    def mean(sizes_m: list[float]) -> float:
        return float(np.sqrt(np.average(np.square(sizes_m), weights=weights)))

    return Limit(
        rms_m=mean([one.rms_m for one, _ in found]),
        steps_m=mean([one.steps_m for one, _ in found]),
        sizes_m=mean([one.sizes_m for one, _ in found]),
        left_m=mean([one.left_m for one, _ in found]),
        counted_m=mean([one.counted_m for one, _ in found]),
    )
