"""Effects of the vocabulary in drives, gears and bearings, as they are built into the robot."""

from __future__ import annotations

import numpy as np

from deltactl.proof.hidden.hidden import MOTORS, Kind, Parameters, either_sign, number
from deltactl.proof.recorded import Machine

SHAFT_NM_PER_RAD = 2000.0
"""A shaft soft enough that a few N m of friction wind it up by milliradians."""


def _backlash(machine: Machine, m: int, p: Parameters) -> None:
    joints = machine.robot.joints
    joints.friction_nm[m] = max(joints.friction_nm[m], number(p["friction"]))
    # The width is what is lost between the two directions; teeth that push against friction
    # yield a little, which is part of it.
    yields = 2.0 * joints.friction_nm[m] / joints.stiffness_nm_per_rad[m]
    joints.play_rad[m] = max(number(p["width"]) - yields, 0.0)
    joints.drag_nms_per_rad[m] = max(joints.drag_nms_per_rad[m], number(p["drag"]))


def _draw_backlash(rng: np.random.Generator, strength: float) -> Parameters:
    """In stiff grease. Two extremes are ties by nature and are left out of what must be named:
    in a bearing that sticks play is the same as friction wind-up, and a free arm hangs on one
    flank all the time, which is a home offset."""
    return {
        "width": strength * float(rng.uniform(0.006, 0.011)),
        "friction": float(rng.uniform(0.05, 0.4)),
        "drag": float(rng.uniform(4.0, 15.0)),
    }


def _friction(machine: Machine, m: int, p: Parameters) -> None:
    joints = machine.robot.joints
    k = min(joints.stiffness_nm_per_rad[m], SHAFT_NM_PER_RAD)
    joints.stiffness_nm_per_rad[m] = k
    joints.friction_nm[m] = 0.5 * k * number(p["width"])
    p["torque"] = float(joints.friction_nm[m])


def _compliance(machine: Machine, m: int, p: Parameters) -> None:
    stiffness = machine.robot.joints.stiffness_nm_per_rad
    np.minimum(stiffness, number(p["stiffness"]), out=stiffness)


def _one_compliance(machine: Machine, m: int, p: Parameters) -> None:
    machine.robot.joints.stiffness_nm_per_rad[m] = number(p["stiffness"])


def _draw_stiffness(rng: np.random.Generator, strength: float) -> Parameters:
    return {"stiffness": float(rng.uniform(250.0, 450.0)) / strength}


def _draw_lag(rng: np.random.Generator, strength: float) -> Parameters:
    late = strength * float(rng.uniform(0.08, 0.18))
    share = 0.4 if rng.random() < 0.3 else 0.0
    return {"time": (1.0 - share) * late, "dead_time": share * late}


def _lag(machine: Machine, m: int, p: Parameters) -> None:
    machine.robot.joints.lag_s[m] = number(p["time"])
    machine.robot.joints.dead_time_s[m] = number(p["dead_time"])


def _draw_wave(rng: np.random.Generator, strength: float) -> Parameters:
    waves = float(rng.choice([5.0, 10.0, 20.0], p=[0.15, 0.7, 0.15]))
    return {
        "amplitude": strength * float(rng.uniform(0.004, 0.008)),
        "period": 2.0 * np.pi / waves,
        "phase": float(rng.uniform(-np.pi, np.pi)),
    }


def _wave(machine: Machine, m: int, p: Parameters) -> None:
    joints = machine.robot.joints
    joints.wave_rad[m] = number(p["amplitude"])
    joints.wave_phase_rad[m] = number(p["phase"])
    joints.waves_per_turn = 2.0 * np.pi / number(p["period"])


def _draw_lost(rng: np.random.Generator, strength: float) -> Parameters:
    return {"steps": round(either_sign(rng, 60.0, 130.0) * strength), "time": float("nan")}


def _lost(machine: Machine, m: int, p: Parameters) -> None:
    machine.robot.joints.lost_steps[m] = number(p["steps"])
    machine.robot.joints.lost_at_s[m] = number(p["time"])


def _home(machine: Machine, m: int, p: Parameters) -> None:
    machine.robot.joints.home_rad[m] += number(p["angle"])


def _ratio(machine: Machine, m: int, p: Parameters) -> None:
    machine.robot.joints.scale[m] *= number(p["scale"])


def _viscous(machine: Machine, m: int, p: Parameters) -> None:
    joints = machine.robot.joints
    joints.stiffness_nm_per_rad[m] = min(joints.stiffness_nm_per_rad[m], SHAFT_NM_PER_RAD)
    joints.drag_nms_per_rad[m] = number(p["coefficient"])


KINDS = (
    Kind("gear_backlash", MOTORS, "width", {"width": "rad"}, _draw_backlash, _backlash,
        order=4),
    Kind(
        "joint_friction", MOTORS, "width", {"width": "rad"},
        lambda rng, s: {"width": s * float(rng.uniform(0.006, 0.010))}, _friction, order=2,
    ),
    Kind(
        "viscous_friction", MOTORS, "coefficient", {"coefficient": "N m s/rad"},
        lambda rng, s: {"coefficient": s * float(rng.uniform(100.0, 250.0))}, _viscous, order=2,
    ),
    Kind(
        "joint_compliance", ("joints",), "stiffness", {"stiffness": "N m/rad"},
        _draw_stiffness, _compliance, order=1,
    ),
    Kind(
        "home_offset", MOTORS, "angle", {"angle": "rad"},
        lambda rng, s: {"angle": s * either_sign(rng, 0.010, 0.018)}, _home,
    ),
    Kind(
        "gear_ratio", MOTORS, "scale", {"scale": "1"},
        lambda rng, s: {"scale": 1.0 + s * either_sign(rng, 0.010, 0.020)}, _ratio,
    ),
    Kind(
        "transmission_error", MOTORS, "amplitude", {"amplitude": "rad", "period": "rad"},
        _draw_wave, _wave,
    ),
    Kind(
        "lost_steps", MOTORS, "steps", {"steps": "microsteps", "time": "s"},
        _draw_lost, _lost, event=True,
    ),
    Kind(
        "following_lag", MOTORS, "time", {"time": "s", "dead_time": "s"}, _draw_lag, _lag,
    ),
)  # fmt: skip
ONE_SOFT_JOINT = Kind(
    "joint_compliance", MOTORS, "stiffness", {"stiffness": "N m/rad"},
    _draw_stiffness, _one_compliance, order=1,
)  # fmt: skip
