"""What tracking is possible: the distance from the target that no correction takes away.

Three errors are left when a robot file is right: counts are whole microsteps, made at whole
moments; sizes are known only as well as the sensors measured them; and some effects are not
compensated. The first and the last are found by simulating the accepted model with the counts of
the plan, the second by moving sizes by a standard deviation: those of one diagnosis together, as
they make up for each other, and those without a known spread one after the other.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from deltactl.drivers.steps.contract import Counts
from deltactl.firmware_py.paths.path import Space
from deltactl.firmware_py.planner.plan import Plan, home_counts
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.program.coverage import Coverage, coverage
from deltactl.firmware_py.program.instructions import Leaf, Move, Program, visit
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.firmware_py.run_report.tracking import SAMPLE_S, acting, reached_m
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.effects import effect_kind
from deltactl.models.linkage import Linkage, jacobian
from deltactl.models.robot import AXES, DeltaRobot, EffectEntry, FloatArray
from deltactl.repair.played import Paths, Played, played

MOST_S = 60.0
"""Part of a job that represents the whole of it."""
ENOUGH, ENOUGH_M = 1.3, 0.15e-3
"""As good as can be asked: within this factor of the possible, or below this."""
INTERVAL = 2.0 * 1.96
"""Width of a 95 % interval in standard deviations."""
Size = tuple[int, str]
"""Number of an effect, and name of a size of it."""
Direction = tuple[object, object]
"""Sizes that move together: from these recordings by the number of the direction, or one alone."""


@dataclass(frozen=True, slots=True)
class Limit:
    """Distances from the target [m], RMS.

    steps_m: what whole microsteps and their moments leave, with all that is compensated
    compensated. sizes_m: what the intervals of the sizes in the robot file leave open. left_m:
    what is known and not compensated. rms_m: all together, where rotors turn evenly from step to
    step. counted_m: what the row 'commanded' of a run shows, which is all but `sizes_m` for whole
    steps.
    """

    rms_m: float
    steps_m: float
    sizes_m: float
    left_m: float
    counted_m: float

    def as_json(self) -> dict[str, float]:
        """Plain types."""
        return asdict(self)


def limit_of(
    plan: Plan, covered: Coverage, from_counts: Counts | None = None, most_s: float = MOST_S
) -> Limit | None:
    """Tracking limit of a plan and its compensation; None for a path in arm angles.

    from_counts: where the arms are before it; None for home. most_s: so much of it is looked at.
    Raises MotionError where the plan does not hold any more.
    """
    if plan.first.lap.space is Space.JOINT:
        return None
    path, robot = played(plan, most_s, from_counts), plan.robot
    accepted = acting(robot)
    left = {(effect.effect, effect.component) for effect in covered.left}
    met = tuple(effect for effect in accepted if (effect.effect, effect.component) not in left)
    at_best_m, reached_m = (reached_on(robot, effects, path) for effects in (met, accepted))
    known_m = rms_m(reached_m - path.target_m)
    whole_m = rms_m(reached_on(robot, accepted, path, whole=True) - path.target_m)
    opened_m = [
        rms_m(reached_on(robot, moved, path) - reached_m) for moved in moved_by_sigma(accepted)
    ]
    sizes_m = float(np.sqrt(np.sum(np.square(opened_m))))
    return Limit(
        rms_m=float(np.hypot(known_m, sizes_m)),
        steps_m=rms_m(at_best_m - path.target_m),
        sizes_m=sizes_m,
        left_m=rms_m(reached_m - at_best_m),
        counted_m=whole_m,
    )


def goal_of(paths: Paths, robot: RobotFile) -> float | None:
    """As good as can be asked of a job, RMS [m]: by the limit of the robot without any effect.

    A network counts as it was shipped; None for a path in arm angles. Raises MotionError where the
    job cannot be planned so.
    """
    plan, path = paths.of(robot.model_copy(update={"effects": (), "networks": {}}))
    if plan.first.lap.space is Space.JOINT:
        return None
    limit_m = rms_m(reached_on(plan.robot, (), path) - path.target_m)
    return max(ENOUGH * limit_m, ENOUGH_M)


def reached_on(
    robot: DeltaRobot, effects: tuple[EffectEntry, ...], path: Played, whole: bool = False
) -> FloatArray:
    """Where the platform is when targets are due if the robot is so, (k, 3) [m].

    whole: of the whole steps that were sent until then, not of rotors that turn evenly.
    """
    t_s = np.arange(0.0, path.target_s[-1] + SAMPLE_S, SAMPLE_S)
    t_s = np.union1d(t_s, path.target_s) if whole else t_s
    counts = path.at(t_s).astype(np.float64) if whole else path.smooth(t_s)
    return reached_m(robot, effects, t_s, counts, path.target_s)


def moved_by_sigma(effects: tuple[EffectEntry, ...]) -> list[tuple[EffectEntry, ...]]:
    """The effects off by one standard deviation, in one independent direction after the other."""
    directions: dict[Direction, dict[Size, float]] = {}
    for number, entry in enumerate(effects):
        found = entry.found
        for name, interval in ({} if found is None else found.ci95).items():
            low, high = interval
            if not isinstance(entry.parameters.get(name), float) or not isinstance(low, float):
                continue
            assert found is not None
            assert isinstance(high, float)
            alone = {(number, name): (high - low) / INTERVAL}
            shared = {
                (found.recordings, k): off for k, off in enumerate(found.spread.get(name, ()))
            }
            for direction, off in (shared or alone).items():
                directions.setdefault(direction, {})[number, name] = off
    return [_off(effects, sizes) for sizes in directions.values()]


def _off(effects: tuple[EffectEntry, ...], sizes: dict[Size, float]) -> tuple[EffectEntry, ...]:
    """With sizes off by so much, or all by as much the other way where fewer meet a bound."""
    ways = [_bounded(effects, {size: way * off for size, off in sizes.items()}) for way in (1, -1)]
    values = min(ways, key=lambda way: sum(met for _, met in way.values()))
    moved = list(effects)
    for (number, name), (value, _) in values.items():
        parameters = moved[number].parameters | {name: value}
        moved[number] = moved[number].model_copy(update={"parameters": parameters})
    return tuple(moved)


def _bounded(
    effects: tuple[EffectEntry, ...], sizes: dict[Size, float]
) -> dict[Size, tuple[float, bool]]:
    """Sizes off by so much, and whether a bound is met."""
    found = {}
    for (number, name), off in sizes.items():
        known = effect_kind(effects[number].effect).parameters
        bounds = next((one.low, one.high) for one in known if one.name == name)
        value = float(np.asarray(effects[number].parameters[name])) + off
        found[number, name] = float(np.clip(value, *bounds)), not bounds[0] <= value <= bounds[1]
    return found


def rms_m(off_m: FloatArray) -> float:
    return float(np.sqrt(np.nanmean(np.sum(off_m**2, axis=1))))


AT_ONCE = 20_000
"""Targets looked at together: a few MB."""
IN_ANGLES = "none to state: the path is given in arm angles, which are commanded as they are"
BY_SERVO = "none to state: it lies in how closely the servo drives follow, which is not in the file"
NO_PATH = "none to state: nothing moves"


def limit_of_program(program: Program, job_path: Path) -> Limit | str:
    """All targets in space, each move as often as it comes; or a sentence why there is none.

    The first `MOST_S` of a job represent the whole of it. Raises MotionError, NetworkError.
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
        rms_m=mean([limit.rms_m for limit, _ in found]),
        steps_m=mean([limit.steps_m for limit, _ in found]),
        sizes_m=mean([limit.sizes_m for limit, _ in found]),
        left_m=mean([limit.left_m for limit, _ in found]),
        counted_m=mean([limit.counted_m for limit, _ in found]),
    )
