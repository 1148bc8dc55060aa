"""What a job would do, in numbers: the dry run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from deltactl.drivers.steps.contract import Counts
from deltactl.firmware_py.job_file import Accelerated, NetworkIk, Together
from deltactl.firmware_py.path_file import Way
from deltactl.firmware_py.planner.plan import Plan, TimedLap, motor_limits
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.planner.targets import Lap
from deltactl.firmware_py.planner.timing_accelerated import CurveSchedule
from deltactl.firmware_py.planner.timing_moves import MotorLimits
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.robot import FloatArray

Triple = tuple[float, float, float]
Range = tuple[float, float]


@dataclass(frozen=True, slots=True)
class CheckSummary:
    """The result of a dry run; figures of the path leave the approach out."""

    job: str
    robot: str
    inverse_kinematics: str
    timing: str
    targets: int
    """Targets of one repeat."""
    repeats: int
    targets_in_all: int
    """Targets of all repeats; one that begins where the last ended shares its first target."""
    path_length_m: float
    """All repeats and the ways back between them."""
    duration_s: float
    """From home until the last rest is over."""
    approach_s: float
    moving_s: float
    """Time on the path without the rests."""
    mean_speed_mps: float
    """Path length by the time it takes, without the rests."""
    path_per_step_period_m: float | None
    """Mean path length per T_PWM when stepping together (Zhao 2023, Table 4: 0.09305 mm)."""
    peak_step_rate_hz: Triple
    """Fastest steps of each motor on the path."""
    approach_step_rate_hz: float
    """Fastest steps of any motor on the way to the path's start."""
    arm_range_deg: tuple[Range, Range, Range]
    """Lowest and highest angle of each arm on the path."""
    smallest_margin: float
    """Nearest to singular on the path (limits.singularity_margin)."""
    box_m: tuple[Range, Range, Range]
    """Lowest and highest x, y, z of the platform on the path."""
    instructions: int | None = None
    """How many things a job of steps does, one after another; None for a job of one path."""
    waits_at_most_s: float = 0.0
    """How much longer it takes where inputs come as late as they may."""
    pauses: int = 0
    """How often it waits until somebody says `resume`; that time is in no other figure."""
    slower: Slower | None = None
    """Where the speed that the job asks for is never reached: what is, and why."""

    def as_json(self) -> dict[str, Any]:
        """Plain types only."""
        return asdict(self)


def summarise(plan: Plan, from_counts: Counts) -> CheckSummary:
    """Figures of a plan run from some counts. Raises UnreachablePoint for the approach."""
    job, timed = plan.job, plan.timed
    stream = MotionStream(plan, from_counts)
    times = [1] if plan.again is None else [1, job.repeats - 1]
    length_m = sum(n * lap.length_m for n, lap in zip(times, timed, strict=True))
    moving_s = sum(n * _moving_s(lap) for n, lap in zip(times, timed, strict=True))
    rates = [lap.schedule.peak_rate_hz for lap in timed]
    mean_mps = length_m / moving_s if moving_s > 0.0 else 0.0
    return CheckSummary(
        job=job.name,
        robot=plan.robot.name,
        inverse_kinematics=_kinematics_in_words(plan),
        timing=_timing_in_words(plan),
        targets=len(plan.first.lap),
        repeats=job.repeats,
        targets_in_all=_targets_in_all(plan),
        path_length_m=length_m,
        duration_s=stream.end_ns / NS_PER_S,
        approach_s=stream.path_start_ns / NS_PER_S,
        moving_s=moving_s,
        mean_speed_mps=mean_mps,
        path_per_step_period_m=(
            mean_mps * job.timing.t_pwm_s if isinstance(job.timing, Together) else None
        ),
        peak_step_rate_hz=_triple(np.max(rates, axis=0)),
        approach_step_rate_hz=float(stream.approach.peak_rate_hz.max()),
        arm_range_deg=_arm_range_deg(timed),
        smallest_margin=min(_margin(lap) for lap in timed),
        box_m=_box(timed),
        slower=slower([plan]),
    )


def _targets_in_all(plan: Plan) -> int:
    again = 0 if plan.again is None else int((plan.again.lap.number[1:] >= 0).sum())
    return len(plan.first.lap) + (plan.job.repeats - 1) * again


def _moving_s(timed: TimedLap) -> float:
    return (timed.schedule.duration_ns - timed.schedule.rest_ns) / NS_PER_S


def _margin(timed: TimedLap) -> float:
    return float(min(timed.margins.min(), timed.reach.margin.min(initial=1.0)))


def _arm_range_deg(laps: list[TimedLap]) -> tuple[Range, Range, Range]:
    angles = np.rad2deg(np.concatenate([timed.lap.angles_rad for timed in laps]))
    return _pairs(angles.min(axis=0), angles.max(axis=0))


def _box(laps: list[TimedLap]) -> tuple[Range, Range, Range]:
    places = [timed.lap.position_m for timed in laps]
    lows = [*places, *(timed.reach.low_m for timed in laps)]
    highs = [*places, *(timed.reach.high_m for timed in laps)]
    return _pairs(np.concatenate(lows).min(axis=0), np.concatenate(highs).max(axis=0))


def _pairs(low: FloatArray, high: FloatArray) -> tuple[Range, Range, Range]:
    first, second, third = zip(low.tolist(), high.tolist(), strict=True)
    return first, second, third


def _triple(values: FloatArray) -> Triple:
    first, second, third = values.tolist()
    return first, second, third


def _kinematics_in_words(plan: Plan) -> str:
    chosen = plan.job.inverse_kinematics
    return f"network {chosen.file}" if isinstance(chosen, NetworkIk) else "geometry"


def _timing_in_words(plan: Plan) -> str:
    timing = plan.job.timing
    if isinstance(timing, Together):
        return f"together, T_PWM {timing.t_pwm_s:g} s"
    if timing.speed_mps is None:
        return f"accelerated, {timing.duration_s:g} s"
    slowest_mps, fastest_mps = _asked_mps(plan, timing.speed_mps)
    slowest = "" if slowest_mps == fastest_mps else f"{slowest_mps * 1e3:g} to "
    return f"accelerated, {slowest}{fastest_mps * 1e3:g} mm/s"


def _asked_mps(plan: Plan, job_mps: float) -> Range:
    """The lowest and the highest speed asked for on the path, where legs have their own."""
    legs_mps = plan.first.lap.speed_mps
    if legs_mps is None or len(legs_mps) < 2:
        return job_mps, job_mps
    asked_mps = np.minimum(job_mps, legs_mps[1:])
    return float(asked_mps.min()), float(asked_mps.max())


REACHED = 0.99
"""Share of the speed asked for from which it counts as reached: targets are rounded."""


HELD_BACK = 0.7
"""Share of the speed asked for below which a whole way is said to be slow: ramps at its ends and
a bend here and there cost less."""


@dataclass(frozen=True, slots=True)
class Slower:
    """The platform never moves as fast as was asked, or is slow on most of a way."""

    asked_mps: float
    top_mps: float
    by: str
    """The limit that holds where it moves fastest, as in the robot file, with its value."""
    mean_share: float = 1.0
    """The time that a way would take at the speeds asked for, by what it takes."""
    stops: int = 0
    """Corners of a way at which it stops, though nobody asked it to wait there."""
    led: float = 1.0
    """How many times as long it takes, so that drives that follow late can be led."""

    @property
    def matters(self) -> bool:
        """Whether it is slow enough to report."""
        reached = self.top_mps >= REACHED * self.asked_mps and self.mean_share >= HELD_BACK
        return not reached or self.led > 1.0

    def says(self) -> str:
        """One line."""
        if self.led > 1.0:
            return (
                f"this path takes {self.led:.3g} times as long as was asked for: a drive that"
                f" follows late has to be led, and {self.by} allows no more"
            )
        corners = f"; it stops at {self.stops} corners, which corner_m rounds" if self.stops else ""
        if self.top_mps < REACHED * self.asked_mps:
            return (
                f"the speed asked for, {self.asked_mps:.4g} m/s, is never reached on this path: it"
                f" gets to {self.top_mps:.3g} m/s at most, because of {self.by}{corners}"
            )
        return (
            f"this path takes as long as at {self.mean_share:.0%} of the speed asked for: its"
            f" corners keep it slow, because of {self.by}{corners}"
        )


def slower(plans: Iterable[Plan]) -> Slower | None:
    """Where a path is slower than asked: the one of several that comes nearest to its speed; if it
    reaches it, a way that is slow on the whole. None without a speed, or where nothing is slow;
    but a path along which a drive could not be led is slow whatever its timing.
    """
    found = [held for plan in plans if (held := _fastest(plan)) is not None]
    best = max(found, key=lambda held: held.top_mps / held.asked_mps, default=None)
    slowest = min(found, key=lambda held: held.mean_share, default=None)
    return next((held for held in (best, slowest) if held is not None and held.matters), None)


def _fastest(plan: Plan) -> Slower | None:
    timing, schedule = plan.job.timing, plan.first.schedule
    if plan.first.led > 1.0:
        by = _speed_limit(motor_limits(plan.job, plan.robot))
        return Slower(1.0, 1.0 / plan.first.led, by, led=plan.first.led)
    if not isinstance(timing, Accelerated) or timing.speed_mps is None:
        return None
    if not isinstance(schedule, CurveSchedule):
        return None
    limits = motor_limits(plan.job, plan.robot)
    by = f"joint_acceleration_radps2 {limits.acceleration_radps2:g}"
    if schedule.top_joint_radps >= REACHED * limits.planned_speed_radps:
        by = _speed_limit(limits)
    if not isinstance(plan.job.path, Way):
        return Slower(schedule.asked_mps, schedule.top_speed_mps, by)
    lap = plan.first.lap
    share = _ideal_s(lap, timing.speed_mps) / max(_moving_s(plan.first), 1e-9)
    stops = int((lap.rest & (lap.dwell_s == 0.0))[1:-1].sum())
    return Slower(schedule.asked_mps, schedule.top_speed_mps, by, share, stops)


def _ideal_s(lap: Lap, job_mps: float) -> float:
    """How long a lap takes at the speeds asked for, without ramps."""
    hops_m = np.linalg.norm(np.diff(lap.position_m, axis=0), axis=1)
    legs_mps = np.inf if lap.speed_mps is None else lap.speed_mps[1:]
    return float((hops_m / np.minimum(job_mps, legs_mps)).sum())


def _speed_limit(limits: MotorLimits) -> str:
    if limits.planned_speed_radps < limits.speed_radps:
        return f"step_rate_hz {limits.step_rate_hz:g}"
    return f"joint_speed_radps {limits.speed_radps:g}"
