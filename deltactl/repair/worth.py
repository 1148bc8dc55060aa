"""What each repair alone would do to a job: the findings ranked by what removing them is worth.

The robot is taken to be as the corrected file says, with all that was found. The job is planned
with one finding accepted at a time, and what it would draw is simulated. Intervals follow from
those of the sizes, from what operators leave of what they describe, and from what is in no model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from deltactl.firmware_py.program.coverage import Coverage
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.firmware_py.run_report.tracking import acting
from deltactl.models.effects import Compensated, card_of, effect_kind
from deltactl.models.effects.kind import EXACT
from deltactl.models.robot import EffectEntry, FloatArray
from deltactl.repair.compared import Seen, distance
from deltactl.repair.limit import goal_of, moved_by_sigma, reached_on
from deltactl.repair.played import Paths, Played

ENDS = (0.025, 0.975)
AT_MOST = 1.96
"""An operator leaves at most its share: that is a 95 % bound, so many standard deviations."""
BESIDE = 2.0
"""What is in no model (rotors that swing, bodies that yield a little) adds between nothing and this
times the mean square that whole steps leave, as much again in the mean."""
DRAWS = 4000
Effects = tuple[EffectEntry, ...]


@dataclass(frozen=True, slots=True)
class Worth:
    """The job's RMS distance from its path as it is, and with one effect corrected alone [m].

    share: part of the distance that goes with it.
    """

    effect: str
    component: str
    now_m: float
    alone_m: float
    ci95_m: tuple[float, float]
    share: float

    def as_json(self) -> dict[str, Any]:
        """Plain types."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class Left:
    """RMS distance of a job from its path that the findings leave, and its 95 % interval [m]."""

    rms_m: float
    ci95_m: tuple[float, float]


def ranked(paths: Paths, robot: RobotFile, corrected: RobotFile) -> list[Worth]:
    """Every effect that `corrected` has and `robot` has not, the most useful repair first.

    What is known and not compensated moves no count: it is no repair, and left out. Raises
    MotionError where the job cannot be planned so.
    """
    real = acting(corrected)
    at_best = paths.path(corrected)
    best_m = reached_on(corrected, real, at_best) - at_best.target_m
    floor_m2 = float(np.nanmean(np.sum(best_m**2, axis=1)))
    as_now = paths.path(robot)
    now_m = _root_mean(_squares_m2(robot, real, as_now, floor_m2))
    found = []
    for entry in (one for one in real if one not in robot.effects):
        kept = tuple(one for one in robot.effects if _name(one) != _name(entry))
        accepted = robot.model_copy(update={"effects": (*kept, entry)})
        path = paths.path(accepted)
        if path.is_same_as(as_now):
            continue
        squares_m2 = _squares_m2(accepted, real, path, floor_m2)
        alone_m = _root_mean(squares_m2)
        low_m, high_m = np.sqrt(np.quantile(squares_m2, ENDS)).tolist()
        share = (now_m - alone_m) / now_m
        found.append(Worth(*_name(entry), now_m, alone_m, (low_m, high_m), share))
    return sorted(found, key=lambda one: one.alone_m)


def left_over(paths: Paths, corrected: RobotFile, real: Effects) -> Left:
    """What a corrected robot file leaves of a job, if the robot is so: with what it has not, too.

    Raises MotionError where the job cannot be planned so.
    """
    path = paths.path(corrected)
    best_m = reached_on(corrected, acting(corrected), path) - path.target_m
    floor_m2 = float(np.nanmean(np.sum(best_m**2, axis=1)))
    squares_m2 = _squares_m2(corrected, real, path, floor_m2)
    low_m, high_m = np.sqrt(np.quantile(squares_m2, ENDS)).tolist()
    return Left(_root_mean(squares_m2), (low_m, high_m))


def beside_goal(
    paths: Paths, robot: RobotFile, corrected: RobotFile, real: Effects, goal_m: float | None
) -> dict[str, Any]:
    """The remaining error and the goal, as plain types; nothing for a path in angles.

    goal_m: None for as good as can be asked.
    """
    best_m = goal_of(paths, robot)
    if best_m is None:
        return {}
    left = left_over(paths, corrected, real)
    expected = {"expected_m": left.rms_m, "expected_ci95_m": left.ci95_m}
    return {"goal_m": best_m if goal_m is None else goal_m, **expected}


def in_readings(runs: Sequence[Seen], robot: RobotFile, corrected: RobotFile) -> list[Worth]:
    """The same for effects that are in the readings alone: they move nothing, and are expected.

    Distances are those of the corrected drawing, by the sensors: as they were taken to read, and
    with one more effect expected.
    """
    own = [one for one in corrected.effects if _only_read(one) and one not in robot.effects]
    rest = tuple(one for one in corrected.effects if one not in own)
    now_m = distance(runs, corrected.model_copy(update={"effects": rest})).rms_m
    found = []
    for entry in own if now_m > 0.0 else []:
        alone = distance(runs, corrected.model_copy(update={"effects": (*rest, entry)}))
        share = (now_m - alone.rms_m) / now_m
        found.append(Worth(*_name(entry), now_m, alone.rms_m, alone.ci95_m, share))
    return sorted(found, key=lambda one: one.alone_m)


def worded(found: Sequence[Worth], covered: Coverage) -> list[dict[str, Any]]:
    """As plain types, each with its sentence."""
    says = {(one.effect, one.component): one.says for one in covered.effects}
    return [
        one.as_json() | {"says": says.get((one.effect, one.component), one.effect)} for one in found
    ]


def _only_read(entry: EffectEntry) -> bool:
    return card_of(entry.effect).compensated is Compensated.IN_READINGS


def _name(entry: EffectEntry) -> tuple[str, str]:
    return entry.effect, entry.component


def _root_mean(squares_m2: FloatArray) -> float:
    return float(np.sqrt(squares_m2.mean()))


def _squares_m2(accepted: RobotFile, real: Effects, path: Played, floor_m2: float) -> FloatArray:
    """Mean squared distances from the path of robots that what is known allows, (DRAWS,).

    Counts are those of one file. Whatever is uncertain moves the platform along by its standard
    deviation times a normal number.
    """
    reached_m = reached_on(accepted, real, path)
    moved_m = [reached_on(accepted, other, path) - reached_m for other in moved_by_sigma(real)]
    moved_m += [
        share * (reached_m - reached_on(accepted, without, path))
        for share, without in _left_by_operators(real)
    ]
    fields = np.stack([reached_m - path.target_m, *moved_m])
    known = np.isfinite(fields).all(axis=(0, 2))
    products_m2 = np.einsum("ikc,jkc->ij", fields[:, known], fields[:, known]) / known.sum()
    rng = np.random.default_rng(0)
    weights = np.insert(rng.standard_normal((DRAWS, len(moved_m))), 0, 1.0, axis=1)
    squares_m2: FloatArray = np.einsum("ni,ij,nj->n", weights, products_m2, weights)
    return squares_m2 + BESIDE * floor_m2 * rng.random(DRAWS)


def _left_by_operators(real: Effects) -> list[tuple[float, Effects]]:
    """For each effect that no operator describes exactly: how far its size may seem off in another
    motion, as a standard deviation and share of it, and the robot without it.
    """
    left = [_share_left(one.effect) for one in real]
    return [
        (float(np.sqrt(share)) / AT_MOST, (*real[:number], *real[number + 1 :]))
        for number, share in enumerate(left)
        if share > EXACT
    ]


def _share_left(effect: str) -> float:
    """Share of what it explains that its operator may leave in another motion.

    Sizes of one unit divide what they do: another motion divides it otherwise, and changes their
    sum as little as another pose does.
    """
    kind, fit = effect_kind(effect), card_of(effect).fit
    units = {one.name: one.unit for one in kind.parameters}
    parts = [] if fit is None else [units[c.parameter] for c in fit.coordinates if c.how == "plain"]
    shared = len(set(parts)) < len(parts)
    return kind.discrepancy.in_pose if shared else kind.discrepancy.elsewhere
