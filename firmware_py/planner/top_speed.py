"""Whether a path ever reaches the speed that its job asks for, and if not, what keeps it slower."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from firmware_py.job_file import Accelerated
from firmware_py.planner.plan import Plan, motor_limits
from firmware_py.planner.timing_accelerated import CurveSchedule
from firmware_py.planner.timing_moves import MotorLimits

REACHED = 0.99
"""Share of the speed asked for from which it counts as reached: targets are rounded."""


@dataclass(frozen=True, slots=True)
class Slower:
    """The platform never moves as fast as was asked."""

    asked_mps: float
    top_mps: float
    by: str
    """The limit that holds where it moves fastest, as in the robot file, with its value."""

    def says(self) -> str:
        """One line."""
        return (
            f"the speed asked for, {self.asked_mps:.4g} m/s, is never reached on this path: it gets"
            f" to {self.top_mps:.3g} m/s at most, because of {self.by}"
        )


def slower(plans: Iterable[Plan]) -> Slower | None:
    """Of paths one after another the one that comes nearest to its speed; None where it is reached,
    or no speed is asked for.
    """
    found = [one for plan in plans if (one := _fastest(plan)) is not None]
    best = max(found, key=lambda one: one.top_mps / one.asked_mps, default=None)
    return None if best is None or best.top_mps >= REACHED * best.asked_mps else best


def _fastest(plan: Plan) -> Slower | None:
    timing, schedule = plan.job.timing, plan.first.schedule
    if not isinstance(timing, Accelerated) or timing.speed_mps is None:
        return None
    if not isinstance(schedule, CurveSchedule):
        return None
    limits = motor_limits(plan.job, plan.robot)
    by = f"joint_acceleration_radps2 {limits.acceleration_radps2:g}"
    if schedule.top_joint_radps >= REACHED * limits.planned_speed_radps:
        by = _speed_limit(limits)
    return Slower(schedule.asked_mps, schedule.top_speed_mps, by)


def _speed_limit(limits: MotorLimits) -> str:
    if limits.planned_speed_radps < limits.speed_radps:
        return f"step_rate_hz {limits.step_rate_hz:g}"
    return f"joint_speed_radps {limits.speed_radps:g}"
