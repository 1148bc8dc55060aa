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
from deltactl.repair.played import Played, played

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
    now_m, _ = _drawn(job, robot, real)
    found = []
    for entry in (one for one in real if one not in robot.effects):
        kept = tuple(one for one in robot.effects if _name(one) != _name(entry))
        alone = robot.model_copy(update={"effects": (*kept, entry)})
        alone_m, sigma_m = _drawn(job, alone, real)
        ends_m = np.maximum(alone_m + TWO_SIDED_95 * sigma_m * np.array([-1.0, 1.0]), 0.0)
        low_m, high_m = ends_m.tolist()
        share = (now_m - alone_m) / now_m
        found.append(Worth(*_name(entry), now_m, alone_m, (low_m, high_m), share))
    return sorted(found, key=lambda one: one.alone_m)


def _name(entry: EffectEntry) -> tuple[str, str]:
    return entry.effect, entry.component


def _drawn(job: Path, accepted: RobotFile, real: Effects) -> tuple[float, float]:
    """RMS distance from the path of a job planned by one file on such a robot; its sigma [m]."""
    path = played(plan_of(job, accepted))

    def off_m(effects: Effects, motion: Played = path) -> float:
        return rms_m(reached_on(accepted, effects, motion) - motion.target_m)

    drawn_m = off_m(real)
    moved_m = [off_m(effects) - drawn_m for effects in moved_by_sigma(real)]
    return drawn_m, float(np.sqrt(np.sum(np.square(moved_m))))
