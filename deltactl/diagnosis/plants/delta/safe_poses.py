"""Which arm angles a proposed motion may use, and which tell nothing reliable."""

from __future__ import annotations

import itertools
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.delta.options import DELTA_FITS, NEXT_RUNS
from deltactl.models.linkage import (
    Linkage,
    Status,
    forward,
    neighbours,
    parallel_margin,
    serial_margin,
)

BoolArray = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
Box = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


class MotionLimits(BaseModel):
    """What a motion may not exceed; the defaults are those of a robot file without `limits`."""

    model_config = ConfigDict(extra="ignore", frozen=True)
    arm_deg: tuple[float, float] = (-20.0, 110.0)
    box_m: Box | None = None
    singularity_margin: float = 0.05
    joint_speed_radps: Annotated[float, Field(gt=0.0)] = 8.0
    step_rate_hz: Annotated[float, Field(gt=0.0)] = 20_000.0
    shortest_period_s: float = NEXT_RUNS.pulses_s

    @classmethod
    def of(cls, robot_file: dict[str, Any]) -> MotionLimits:
        """From the whole of a robot file; what it does not say, or says wrongly, is as by default.

        Whoever drives the job checks it against the robot file once more.
        """
        try:
            limits = cls.model_validate(robot_file.get("limits") or {})
        except ValidationError:
            return cls()
        steps = robot_file.get("steps")
        software = isinstance(steps, dict) and steps.get("backend") == "gpiozero"
        pulses_s = NEXT_RUNS.software_pulses_s if software else NEXT_RUNS.pulses_s
        shortest = max(pulses_s, 1.0 / limits.step_rate_hz)
        return limits.model_copy(update={"shortest_period_s": shortest})


def is_safe(linkage: Linkage, limits: MotionLimits, angles_rad: FloatArray) -> bool:
    """Whether straight moves in joint space through angles (k, 3) keep to the limits all along."""
    low, high = np.deg2rad(limits.arm_deg)
    if (angles_rad < low).any() or (angles_rad > high).any():
        return False
    along = between(angles_rad)
    pose = forward(linkage, along)
    if (pose.status != Status.OK).any():
        return False
    serial = serial_margin(linkage, along, pose.position_m).min()
    parallel = parallel_margin(linkage, along, pose.position_m).min()
    if min(serial, parallel) < NEXT_RUNS.margin_factor * limits.singularity_margin:
        return False
    if limits.box_m is None:
        return True
    box = np.array(limits.box_m)
    return bool(((pose.position_m >= box[:, 0]) & (pose.position_m <= box[:, 1])).all())


def between(angles_rad: FloatArray) -> FloatArray:
    """Poses along the moves, ends included, at most `pose_step_deg` apart in any arm."""
    parts, step_rad = [angles_rad[:1]], float(np.deg2rad(NEXT_RUNS.pose_step_deg))
    for start, end in itertools.pairwise(angles_rad):
        count = max(1, int(np.ceil(np.abs(end - start).max() / step_rad)))
        share = np.arange(1, count + 1)[:, None] / count
        parts.append(start + share * (end - start))
    return np.concatenate(parts)


def fragile(linkage: Linkage, angles_rad: FloatArray) -> BoolArray:
    """Samples, of angles (n, 3) [rad], that cannot be assembled with all arms off alike; (n,).

    Near where the arms lie flat, a wrong length moves the platform by many times itself, and a
    little more and the arms cannot be assembled at all. A fit would meet cliffs there.
    """
    lost = np.zeros(len(angles_rad), dtype=bool)
    for other in neighbours(linkage):
        lost |= ~np.isfinite(forward(other, angles_rad).position_m[:, 0])
    few = lost.mean() <= DELTA_FITS.most_fragile
    return lost if few else np.zeros(len(angles_rad), dtype=bool)
