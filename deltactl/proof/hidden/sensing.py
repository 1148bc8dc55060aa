"""Effects of the vocabulary in the ranging sensors."""

from __future__ import annotations

import numpy as np

from deltactl.proof.hidden.hidden import RANGES, Kind, Parameters, either_sign, number
from deltactl.proof.recorded import Machine


def _offset(machine: Machine, axis: int, p: Parameters) -> None:
    machine.sensors.offset_m[axis] += number(p["offset"])


def _scale(machine: Machine, axis: int, p: Parameters) -> None:
    machine.sensors.scale[axis] *= number(p["scale"])


def _curvature(machine: Machine, axis: int, p: Parameters) -> None:
    machine.sensors.curvature_per_m[axis] += number(p["curvature"])


def _late(machine: Machine, _: int, p: Parameters) -> None:
    machine.sensors.late_s = number(p["time"])


def _draw_drift(rng: np.random.Generator, strength: float) -> Parameters:
    return {
        "offset": strength * either_sign(rng, 0.008, 0.014),
        "time_constant": float(rng.uniform(25.0, 80.0)),
    }


def _drift(machine: Machine, axis: int, p: Parameters) -> None:
    machine.sensors.drift_m[axis] = number(p["offset"])
    machine.sensors.drift_time_s[axis] = number(p["time_constant"])


def _draw_stale(rng: np.random.Generator, strength: float) -> Parameters:
    return {"duration": strength * float(rng.uniform(2.0, 5.0)), "time": float("nan")}


def _stale(machine: Machine, axis: int, p: Parameters) -> None:
    machine.sensors.held.append((axis, number(p["time"]), number(p["duration"])))


KINDS = (
    Kind(
        "sensor_offset", RANGES, "offset", {"offset": "m"},
        lambda rng, s: {"offset": s * either_sign(rng, 0.010, 0.020)}, _offset,
    ),
    Kind(
        "sensor_scale", RANGES, "scale", {"scale": "1"},
        lambda rng, s: {"scale": 1.0 + s * either_sign(rng, 0.010, 0.020)}, _scale,
    ),
    Kind(
        "sensor_crosstalk", RANGES, "curvature", {"curvature": "1/m"},
        lambda rng, s: {"curvature": s * either_sign(rng, 0.02, 0.04)}, _curvature,
    ),
    Kind(
        "sensor_latency", ("sensors",), "time", {"time": "s"},
        lambda rng, s: {"time": s * float(rng.uniform(0.08, 0.20))}, _late,
    ),
    Kind(
        "sensor_drift", RANGES, "offset", {"offset": "m", "time_constant": "s"},
        _draw_drift, _drift,
    ),
    Kind(
        "stale_reading", RANGES, "duration", {"duration": "s", "time": "s"},
        _draw_stale, _stale, event=True,
    ),
)  # fmt: skip
