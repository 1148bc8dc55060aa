"""What happened, as the flat dictionaries that become JSON messages.

A value that does not exist (NaN, None) is left out: JSON has no NaN, and viewers want plain
types. Numbers are rounded to 1e-9 of their unit, which no sensor of this robot comes near.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from deltactl.recording.format.edges import Int64Array

Steps = Sequence[int] | Int64Array
Three = Sequence[float] | np.ndarray[Any, np.dtype[np.float64]]
Message = dict[str, Any]
_DECIMALS = 9


class _Named(Protocol):
    @property
    def value(self) -> Any: ...


class ReadingLike(Protocol):
    """What is recorded of a reading; `deltactl.drivers.ranging.contract.Reading` has it."""

    @property
    def axis(self) -> str: ...
    @property
    def t_ns(self) -> int: ...
    @property
    def distance_m(self) -> float: ...
    @property
    def status(self) -> int: ...
    @property
    def raw_status(self) -> int: ...
    @property
    def signal_mcps(self) -> float: ...
    @property
    def ambient_mcps(self) -> float: ...
    @property
    def sigma_m(self) -> float: ...
    @property
    def stream_count(self) -> int: ...
    @property
    def gate(self) -> _Named: ...


class ServoLike(Protocol):
    """What is recorded of a servo's loop; `firmware_py.servo.loop.ServoSample` has it."""

    @property
    def t_ns(self) -> int: ...
    @property
    def reference_rad(self) -> Sequence[float]: ...
    @property
    def angle_rad(self) -> Sequence[float]: ...
    @property
    def current_a(self) -> Sequence[float]: ...
    @property
    def disturbance_a(self) -> Sequence[float]: ...


def target(t_ns: int, index: int, position_m: Three, steps: Steps) -> Message:
    """Fields of `/target`."""
    return {"t_ns": t_ns, "index": int(index)} | _position(position_m) | counts(steps)


def counts(steps: Steps) -> Message:
    """Three signed counts."""
    first, second, third = steps
    return {"steps_1": int(first), "steps_2": int(second), "steps_3": int(third)}


def reading(t_ns: int, sample: ReadingLike) -> Message:
    """Fields of `/reading/<axis>`."""
    numbers = {
        "distance_m": sample.distance_m,
        "signal_mcps": sample.signal_mcps,
        "ambient_mcps": sample.ambient_mcps,
        "sigma_m": sample.sigma_m,
    }
    return {
        "t_ns": t_ns,
        "axis": sample.axis,
        "status": int(sample.status),
        "raw_status": int(sample.raw_status),
        "stream_count": int(sample.stream_count),
        "gate": str(sample.gate.value),
    } | _numbers(numbers)


def truth(t_ns: int, position_m: Three, angles_rad: Three) -> Message:
    """Fields of `/truth`."""
    first, second, third = angles_rad
    angles = {"theta_1_rad": first, "theta_2_rad": second, "theta_3_rad": third}
    return {"t_ns": t_ns} | _position(position_m) | _numbers(angles)


_SERVO = tuple(
    f"{stem}_{joint}_{unit}"
    for stem, unit in (
        ("reference", "rad"),
        ("theta", "rad"),
        ("current", "a"),
        ("disturbance", "a"),
    )
    for joint in (1, 2, 3)
)


def servo(t_ns: int, sample: ServoLike) -> Message:
    """Fields of `/servo`."""
    values = (*sample.reference_rad, *sample.angle_rad, *sample.current_a, *sample.disturbance_a)
    return {"t_ns": t_ns} | _numbers(dict(zip(_SERVO, values, strict=True)))


def pace(t_ns: int, rate: float, goal: float, ramp_s: float) -> Message:
    """Fields of `/pace`."""
    return {"t_ns": t_ns, "rate": float(rate), "goal": float(goal), "ramp_s": float(ramp_s)}


def settings(t_ns: int, t_pwm_s: float | None) -> Message:
    """Fields of `/settings`."""
    return {"t_ns": t_ns} | _numbers({"t_pwm_s": t_pwm_s})


def _position(position_m: Three) -> Message:
    x_m, y_m, z_m = position_m
    return _numbers({"x_m": x_m, "y_m": y_m, "z_m": z_m})


def _numbers(values: Mapping[str, float | None]) -> Message:
    return {
        name: round(float(value), _DECIMALS)
        for name, value in values.items()
        if value is not None and math.isfinite(value)
    }
