"""What each repair alone would do to a job: the findings ranked by what removing them is worth.

The robot is taken to be as the corrected file says, with all that was found. The job is planned
with one finding accepted at a time, and what it would draw is simulated; intervals follow from
those of the sizes.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.firmware_py.planner.plan import plan_of
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.firmware_py.run_report.tracking import acting
from deltactl.models.robot import EffectEntry
from deltactl.repair.limit import moved_by_sigma, reached_on, rms_m
from deltactl.repair.played import played

TWO_SIDED_95 = 1.96
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


def ranked(job: Path, robot: RobotFile, corrected: RobotFile) -> list[Worth]:
    """Every effect that `corrected` has and `robot` has not, the most useful repair first.

    Raises MotionError where the job cannot be planned so.
    """
    real = acting(corrected)
    at_best = _drawn(job, corrected, real)
    now = _drawn(job, robot, real)
    found = []
    for entry in (one for one in real if one not in robot.effects):
        kept = tuple(one for one in robot.effects if _name(one) != _name(entry))
        alone = _drawn(job, robot.model_copy(update={"effects": (*kept, entry)}), real)
        share = (now.rms_m - alone.rms_m) / now.rms_m
        interval_m = alone.ci95_m(at_best.exact_m)
        found.append(Worth(*_name(entry), now.rms_m, alone.rms_m, interval_m, share))
    return sorted(found, key=lambda one: one.alone_m)


@dataclass(frozen=True, slots=True)
class _Drawing:
    """exact_m: RMS distance where all sizes are as found; square_m2: mean square where they scatter
    as their intervals say, and its standard deviation.
    """

    exact_m: float
    square_m2: float
    sigma_m2: float

    @property
    def rms_m(self) -> float:
        """Root of the mean square."""
        return float(np.sqrt(self.square_m2))

    def ci95_m(self, floor_m: float) -> tuple[float, float]:
        """Ends of the 95 % interval.

        floor_m: what whole steps leave at best. What is in no model (rotors that swing, bodies
        that yield a little) adds up to as much again.
        """
        off_m2 = TWO_SIDED_95 * self.sigma_m2
        low_m2, high_m2 = max(self.square_m2 - off_m2, 0.0), self.square_m2 + off_m2
        return float(np.sqrt(low_m2)), float(np.sqrt(high_m2 + floor_m**2))


def _name(entry: EffectEntry) -> tuple[str, str]:
    return entry.effect, entry.component


def _drawn(job: Path, accepted: RobotFile, real: Effects) -> _Drawing:
    """A job planned by one file on such a robot.

    With sizes off by z d each, z normal, the square is that of e + sum of z d: its mean is larger
    than that of e by those of d, and it varies by 2 z e d and z^2 d^2.
    """
    path = played(plan_of(job, accepted))
    reached_m = reached_on(accepted, real, path)
    error_m = reached_m - path.target_m
    moved_m = [reached_on(accepted, effects, path) - reached_m for effects in moved_by_sigma(real)]
    squares = np.array([rms_m(moved) ** 2 for moved in moved_m])
    along = np.array([np.nanmean(np.sum(error_m * moved, axis=1)) for moved in moved_m])
    exact_m = rms_m(error_m)
    sigma_m2 = float(np.sqrt(np.sum(4.0 * along**2 + 2.0 * squares**2)))
    return _Drawing(exact_m, exact_m**2 + float(squares.sum()), sigma_m2)
