"""Effects of the contract's vocabulary: how large they are drawn, and how a machine gets them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import mujoco
import numpy as np

from deltactl.proof.hidden.hidden import (
    ARMS,
    MOTORS,
    RANGES,
    Apply,
    Draw,
    Hidden,
    Kind,
    Parameters,
    either_sign,
    number,
    split_interval,
)
from deltactl.proof.recorded import Machine
from deltactl.proof.robot.as_built import FloatArray, StepTrain
from deltactl.proof.robot.bodies import Assembly, build

Where = Callable[[Machine], FloatArray]
"""The array of a machine, one number a motor, arm or sensor, that an effect changes."""
SHAFT_NM_PER_RAD = 2000.0
"""A shaft soft enough that a few N m of friction wind it up by milliradians."""
YIELDS_AT_NM = 8.0
"""Gravity and acceleration ask for 1 to 4 N m."""


def _even(name: str, low: float, high: float) -> Draw:
    return lambda rng, strength: {name: strength * float(rng.uniform(low, high))}


def _signed(name: str, low: float, high: float) -> Draw:
    return lambda rng, strength: {name: strength * either_sign(rng, low, high)}


def _about_one(name: str, low: float, high: float) -> Draw:
    return lambda rng, strength: {name: 1.0 + strength * either_sign(rng, low, high)}


def _also(draw: Draw, name: str, low: float, high: float) -> Draw:
    """And a size that is the same for faint effects."""
    return lambda rng, strength: draw(rng, strength) | {name: float(rng.uniform(low, high))}


def _then(draw: Draw, name: str) -> Draw:
    """And a size that follows from the motion (`settle`)."""
    return lambda rng, strength: draw(rng, strength) | {name: float("nan")}


def _adds(where: Where, name: str) -> Apply:
    def apply(machine: Machine, index: int, p: Parameters) -> None:
        where(machine)[index] += number(p[name])

    return apply


def _scales(where: Where, name: str) -> Apply:
    def apply(machine: Machine, index: int, p: Parameters) -> None:
        where(machine)[index] *= number(p[name])

    return apply


def _backlash(machine: Machine, m: int, p: Parameters) -> None:
    joints = machine.robot.joints
    joints.friction_nm[m] = max(joints.friction_nm[m], number(p["friction"]))
    # The width is what is lost between the two directions; teeth that push against friction
    # yield a little, which is part of it.
    yields = 2.0 * joints.friction_nm[m] / joints.stiffness_nm_per_rad[m]
    joints.play_rad[m] = max(number(p["width"]) - yields, 0.0)
    joints.drag_nms_per_rad[m] = max(joints.drag_nms_per_rad[m], number(p["drag"]))


def _friction(machine: Machine, m: int, p: Parameters) -> None:
    joints = machine.robot.joints
    k = min(joints.stiffness_nm_per_rad[m], SHAFT_NM_PER_RAD)
    joints.stiffness_nm_per_rad[m] = k
    joints.friction_nm[m] = 0.5 * k * number(p["width"])
    p["torque"] = float(joints.friction_nm[m])


def _compliance(machine: Machine, m: int, p: Parameters) -> None:
    stiffness = machine.robot.joints.stiffness_nm_per_rad
    np.minimum(stiffness, number(p["stiffness"]), out=stiffness)


def _viscous(machine: Machine, m: int, p: Parameters) -> None:
    joints = machine.robot.joints
    joints.stiffness_nm_per_rad[m] = min(joints.stiffness_nm_per_rad[m], SHAFT_NM_PER_RAD)
    joints.drag_nms_per_rad[m] = number(p["coefficient"])


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


def _draw_tilt(rng: np.random.Generator, strength: float) -> Parameters:
    way = rng.standard_normal(3)
    size = strength * float(rng.uniform(0.010, 0.018))
    return {"rotation": (size * way / np.linalg.norm(way)).tolist()}


def _tilt(machine: Machine, _: int, p: Parameters) -> None:
    machine.sensors.turned_rad = machine.sensors.turned_rad + np.asarray(p["rotation"])


def _base(machine: Machine, _: int, p: Parameters) -> None:
    machine.robot.body.base_radius_m += number(p["length_error"])


def _growth(machine: Machine, _: int, p: Parameters) -> None:
    machine.robot.body.growth = number(p["strain"])
    machine.robot.body.growth_time_s = number(p["time_constant"])


def _draw_ringing(rng: np.random.Generator, strength: float) -> Parameters:
    return {"frequency": float(rng.uniform(1.5, 4.0)) / strength}


def _ringing(machine: Machine, _: int, p: Parameters) -> None:
    machine.robot.body.ringing_hz = number(p["frequency"])
    machine.robot.body.ringing_damping = number(p["damping"])


def _contact(machine: Machine, _: int, p: Parameters) -> None:
    machine.robot.body.table_height_m = number(p["height"])
    # The drives press on with what their gears bear; they come back when the motor does. Only
    # there do stiff gears give way: as long as it moves freely the robot is that of the others.
    machine.robot.joints.yields_at_nm = YIELDS_AT_NM
    machine.robot.joints.limit_nm = 400.0


def _late(machine: Machine, _: int, p: Parameters) -> None:
    machine.sensors.late_s = number(p["time"])


def _drift(machine: Machine, axis: int, p: Parameters) -> None:
    machine.sensors.drift_m[axis] = number(p["offset"])
    machine.sensors.drift_time_s[axis] = number(p["time_constant"])


def _stale(machine: Machine, axis: int, p: Parameters) -> None:
    machine.sensors.held.append((axis, number(p["time"]), number(p["duration"])))


JOINTS, FRAME, PLATFORM = ("joints",), ("frame",), ("platform",)
STIFFNESS = {"stiffness": "N m/rad"}
LENGTH = {"length_error": "m"}
# In stiff grease. Two extremes are ties by nature and are left out of what must be named: in a
# bearing that sticks play is the same as friction wind-up, and a free arm hangs on one flank all
# the time, which is a home offset.
_PLAY = _also(_also(_even("width", 0.006, 0.011), "friction", 0.05, 0.4), "drag", 4.0, 15.0)
_DRAG = _even("coefficient", 100.0, 250.0)
_STRAIN = _also(_signed("strain", 0.006, 0.012), "time_constant", 25.0, 80.0)
_DRIFT = _also(_signed("offset", 0.008, 0.014), "time_constant", 25.0, 80.0)
_RINGING = _also(_draw_ringing, "damping", 0.05, 0.15)
_UPPER = _adds(lambda machine: machine.robot.body.upper_arm_m, "length_error")
_FORE = _adds(lambda machine: machine.robot.body.forearm_m, "length_error")
_AZIMUTH = _adds(lambda machine: machine.robot.body.azimuth_rad, "angle")
_HOME = _adds(lambda machine: machine.robot.joints.home_rad, "angle")
_RATIO = _scales(lambda machine: machine.robot.joints.scale, "scale")
_OFFSET = _adds(lambda machine: machine.sensors.offset_m, "offset")
_SCALE = _scales(lambda machine: machine.sensors.scale, "scale")
_CURVATURE = _adds(lambda machine: machine.sensors.curvature_per_m, "curvature")
WAVE, LOST = {"amplitude": "rad", "period": "rad"}, {"steps": "microsteps", "time": "s"}
GROWTH, RINGING = {"strain": "1", "time_constant": "s"}, {"frequency": "Hz", "damping": "1"}
LAG, STALE = {"time": "s", "dead_time": "s"}, {"duration": "s", "time": "s"}
DRIFT, ANGLE, SCALE = {"offset": "m", "time_constant": "s"}, {"angle": "rad"}, {"scale": "1"}
_HEIGHT = _then(_even("depth", 0.02, 0.04), "height")
"""How far the table reaches into the motion's lowest part; its height follows from that."""
_BOWED = _signed("curvature", 0.02, 0.04)
_HELD = _then(_even("duration", 2.0, 5.0), "time")
ALL = (
    Kind("gear_backlash", MOTORS, {"width": "rad"}, _PLAY, _backlash, 4),
    Kind("joint_friction", MOTORS, {"width": "rad"}, _even("width", 0.006, 0.010), _friction, 2),
    Kind("viscous_friction", MOTORS, {"coefficient": "N m s/rad"}, _DRAG, _viscous, 2),
    Kind("joint_compliance", JOINTS, STIFFNESS, _draw_stiffness, _compliance, 1),
    Kind("home_offset", MOTORS, ANGLE, _signed("angle", 0.010, 0.018), _HOME),
    Kind("gear_ratio", MOTORS, SCALE, _about_one("scale", 0.010, 0.020), _RATIO),
    Kind("transmission_error", MOTORS, WAVE, _draw_wave, _wave),
    Kind("lost_steps", MOTORS, LOST, _draw_lost, _lost, event=True),
    Kind("following_lag", MOTORS, LAG, _draw_lag, _lag),
    Kind("upper_arm_length", ARMS, LENGTH, _signed("length_error", 0.0015, 0.003), _UPPER),
    Kind("forearm_length", ARMS, LENGTH, _signed("length_error", 0.003, 0.005), _FORE),
    Kind("base_radius", FRAME, LENGTH, _signed("length_error", 0.003, 0.006), _base),
    Kind("motor_azimuth", MOTORS, ANGLE, _signed("angle", 0.012, 0.024), _AZIMUTH),
    Kind("frame_tilt", FRAME, {"rotation": "rad"}, _draw_tilt, _tilt),
    Kind("thermal_expansion", ("arms",), GROWTH, _STRAIN, _growth),
    Kind("contact", PLATFORM, {"height": "m"}, _HEIGHT, _contact, 3),
    Kind("resonance", PLATFORM, RINGING, _RINGING, _ringing),
    Kind("sensor_offset", RANGES, {"offset": "m"}, _signed("offset", 0.010, 0.020), _OFFSET),
    Kind("sensor_scale", RANGES, SCALE, _about_one("scale", 0.010, 0.020), _SCALE),
    Kind("sensor_crosstalk", RANGES, {"curvature": "1/m"}, _BOWED, _CURVATURE),
    Kind("sensor_latency", ("sensors",), {"time": "s"}, _even("time", 0.08, 0.20), _late),
    Kind("sensor_drift", RANGES, DRIFT, _DRIFT, _drift),
    Kind("stale_reading", RANGES, STALE, _HELD, _stale, event=True),
)
"""In the order in which machines are drawn from them."""
VOCABULARY: dict[str, Kind] = {kind.effect: kind for kind in ALL}
TIED = ("viscous_friction",)
"""Kinds no motion of positions alone can name: a lag of c / k is a lag."""
SINGLES = tuple(name for name in VOCABULARY if name not in TIED)
LOOKS = 400


@dataclass
class Planned:
    """A kind with the component and the sizes that were drawn for it."""

    kind: Kind
    index: int
    parameters: Parameters

    @property
    def component(self) -> str:
        return self.kind.components[self.index]


def plan(kind: Kind, rng: np.random.Generator, strength: float) -> Planned:
    """Draw a component and sizes."""
    return Planned(kind, int(rng.integers(len(kind.components))), kind.draw(rng, strength))


def settle(planned: list[Planned], rng: np.random.Generator, train: StepTrain) -> None:
    """Fill in what depends on the motion: moments of events, the height of a table."""
    for part in planned:
        if part.kind.event:
            part.parameters["time"] = split_interval(rng, train.seconds)
        if part.kind.effect == "contact":
            low = float(np.quantile(heights_m(train), 0.01))
            part.parameters["height"] = low + number(part.parameters["depth"])


def construct(machine: Machine, planned: list[Planned], with_events: bool) -> None:
    """Build everything in; the holdout run has none of the events."""
    for part in sorted(planned, key=lambda part: part.kind.order):
        if with_events or not part.kind.event:
            part.kind.apply(machine, part.index, part.parameters)


def hidden(part: Planned) -> Hidden:
    """The answer to write down."""
    kind = part.kind
    when = number(part.parameters["time"]) if kind.event else None
    return Hidden(
        kind.effect,
        part.component,
        part.parameters,
        kind.main,
        kind.units[kind.main],
        when,
        known_size=tuple(name for name in kind.units if name in part.parameters),
    )


def heights_m(train: StepTrain) -> FloatArray:
    """Heights the nominal platform visits, looked at a few hundred times, (n,) [m]."""
    machine = Machine()
    model: mujoco.MjModel = build(machine.robot.body, machine.robot.joints, 0.001)
    assembly = Assembly(model)
    start = int(model.joint("platform").qposadr[0])
    looks = np.linspace(0, len(train.counts) - 1, LOOKS).astype(int)
    # Each from the drawing board: from one look to the next is too far to keep the platform below.
    angles_rad = train.counts[looks] * machine.robot.joints.rad_per_step
    heights = [assembly.at(arms_rad)[start + 2] for arms_rad in angles_rad]
    return cast(FloatArray, np.array(heights))
