"""Effects of the vocabulary in lengths, directions and the platform."""

from __future__ import annotations

import numpy as np

from deltactl.proof.hidden.hidden import ARMS, MOTORS, Kind, Parameters, either_sign, number
from deltactl.proof.recorded import Machine

YIELDS_AT_NM = 8.0
"""Gravity and acceleration ask for 1 to 4 N m."""


def _upper(machine: Machine, arm: int, p: Parameters) -> None:
    machine.robot.body.upper_arm_m[arm] += number(p["length_error"])


def _fore(machine: Machine, arm: int, p: Parameters) -> None:
    machine.robot.body.forearm_m[arm] += number(p["length_error"])


def _base(machine: Machine, _: int, p: Parameters) -> None:
    machine.robot.body.base_radius_m += number(p["length_error"])


def _azimuth(machine: Machine, motor: int, p: Parameters) -> None:
    machine.robot.body.azimuth_rad[motor] += number(p["angle"])


def _draw_tilt(rng: np.random.Generator, strength: float) -> Parameters:
    way = rng.standard_normal(3)
    size = strength * float(rng.uniform(0.010, 0.018))
    return {"rotation": (size * way / np.linalg.norm(way)).tolist()}


def _tilt(machine: Machine, _: int, p: Parameters) -> None:
    machine.sensors.turned_rad = machine.sensors.turned_rad + np.asarray(p["rotation"])


def _draw_growth(rng: np.random.Generator, strength: float) -> Parameters:
    return {
        "strain": strength * either_sign(rng, 0.006, 0.012),
        "time_constant": float(rng.uniform(25.0, 80.0)),
    }


def _growth(machine: Machine, _: int, p: Parameters) -> None:
    machine.robot.body.growth = number(p["strain"])
    machine.robot.body.growth_time_s = number(p["time_constant"])


def _draw_ringing(rng: np.random.Generator, strength: float) -> Parameters:
    return {
        "frequency": float(rng.uniform(1.5, 4.0)) / strength,
        "damping": float(rng.uniform(0.05, 0.15)),
    }


def _ringing(machine: Machine, _: int, p: Parameters) -> None:
    machine.robot.body.ringing_hz = number(p["frequency"])
    machine.robot.body.ringing_damping = number(p["damping"])


def _contact(machine: Machine, _: int, p: Parameters) -> None:
    machine.robot.body.table_height_m = number(p["height"])
    # The drives press on with what their gears bear; they come back when the motor does. Only
    # there do stiff gears give way: as long as it moves freely the robot is that of the others.
    machine.robot.joints.yields_at_nm = YIELDS_AT_NM
    machine.robot.joints.limit_nm = 400.0


def _draw_contact(rng: np.random.Generator, strength: float) -> Parameters:
    """How far into the motion's lowest reach the table stands; its height follows from that."""
    return {"depth": strength * float(rng.uniform(0.02, 0.04)), "height": float("nan")}


def _length(low: float, high: float, rng: np.random.Generator, strength: float) -> Parameters:
    return {"length_error": strength * either_sign(rng, low, high)}


KINDS = (
    Kind(
        "upper_arm_length", ARMS, "length_error", {"length_error": "m"},
        lambda rng, s: _length(0.0015, 0.003, rng, s), _upper,
    ),
    Kind(
        "forearm_length", ARMS, "length_error", {"length_error": "m"},
        lambda rng, s: _length(0.003, 0.005, rng, s), _fore,
    ),
    Kind(
        "base_radius", ("frame",), "length_error", {"length_error": "m"},
        lambda rng, s: _length(0.003, 0.006, rng, s), _base,
    ),
    Kind(
        "motor_azimuth", MOTORS, "angle", {"angle": "rad"},
        lambda rng, s: {"angle": s * either_sign(rng, 0.012, 0.024)}, _azimuth,
    ),
    Kind("frame_tilt", ("frame",), "rotation", {"rotation": "rad"}, _draw_tilt, _tilt),
    Kind(
        "thermal_expansion", ("arms",), "strain", {"strain": "1", "time_constant": "s"},
        _draw_growth, _growth,
    ),
    Kind("contact", ("platform",), "height", {"height": "m"}, _draw_contact, _contact, order=3),
    Kind(
        "resonance", ("platform",), "frequency", {"frequency": "Hz", "damping": "1"},
        _draw_ringing, _ringing,
    ),
)  # fmt: skip
