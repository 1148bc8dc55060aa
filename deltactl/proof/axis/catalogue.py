"""What may be hidden in each machine: effects of the contract's vocabulary, and physics beyond it.

Each entry builds its parameters from one size `x` that grows from zero, so that a case can be made
faint or gross. The mapping from physics to the contract's size is exact where not said otherwise:

- `joint_friction` `width`: a bearing of force F on a shaft of stiffness k is behind by F / k either
  way, 2 F / k in all. On a mass, `torque` is the force of steady sliding of the bristles.
- `gear_backlash` `width`: lost motion of the load, the dead band and what its bearing winds up the
  spring at the flanks by, at most a twentieth.
- `following_lag` `time`, `dead_time`: a position loop of gain 1 / time that is not fed forward;
  a queue before it.
- `stribeck_friction` `torque`, `speed`: break-away over sliding force, and the scale of its fall.
- `gear_ratio`, `effort_gain` `scale`, `inertia`: true over stated; `inertia` is the true one.
- `speed_limit`, `effort_limit` `limit`: where the loop's demand is cut.
- `resonance` `frequency`, `damping`: undamped frequency of a mass on a spring moved at its foot.
- `transmission_error`, `encoder_error` `amplitude`, `period`: of the first harmonic, at the axis.
- `lost_steps` `steps`: microsteps by which the motor is behind from `time` on.
- `home_offset`, `effort_offset`, `sensor_*`: constants of the reading or of the force balance, in
  the contract's signs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from deltactl.proof.axis.commanded import Sizes, Values


@dataclass(frozen=True)
class Scale:
    """What sizes are measured by on a machine in its motion.

    length: stroke, time: of a stroke, speed: fastest, force: typical (0 where none is recorded).
    step: of a microstep; load: root mean square of what pulls, 0 where nothing is known to.
    period: of the rows; spans: of the whole recording [s]; inertia: of the robot file.
    """

    length: float
    time: float
    speed: float
    period: float
    span: float
    force: float = 0.0
    inertia: float = 0.0
    step: float = 0.0
    load: float = 0.0
    highest: float = 0.0
    """Force peak."""
    fastest: float = 0.0
    """Speed peak; `speed` is what is exceeded in one row of fifty."""
    away: float = 1.0
    """Largest distance of a range sensor."""


Drawn = Mapping[str, float]
Build = Callable[[float, Drawn, Scale], dict[str, float]]


@dataclass(frozen=True)
class Kind:
    """One thing that can be hidden.

    first: size x to begin with, most: largest, both in units that `build` knows. extras: what is
    drawn beside the size. needs: 'load', 'steps', 'zero' or 'inertia' where the machine must have
    it. follows: covariates of an unknown; beside: what may be named beside it without being wrong.
    """

    effect: str
    build: Build
    first: Callable[[Scale], float]
    most: Callable[[Scale], float]
    extras: Callable[[np.random.Generator, Scale], dict[str, float]] = field(
        default=lambda rng, scale: {}
    )
    signed: bool = False
    needs: str = ""
    unknown: bool = False
    follows: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()

    def values(self, x: float, drawn: Drawn, scale: Scale) -> Values:
        """Parameters of this effect at a size."""
        return self.build(x, drawn, scale)


def _plain(name: str) -> Build:
    return lambda x, drawn, scale: {name: x}


def _scale(x: float, drawn: Drawn, scale: Scale) -> dict[str, float]:
    return {"scale": 1.0 + x}


def _with(name: str, *drawn_names: str) -> Build:
    return lambda x, drawn, scale: {name: x, **{other: drawn[other] for other in drawn_names}}


def _lag(x: float, drawn: Drawn, scale: Scale) -> dict[str, float]:
    return {"time": x * drawn["share"], "dead_time": x * (1.0 - drawn["share"])}


def _shares(rng: np.random.Generator, scale: Scale) -> dict[str, float]:
    return {"share": float(rng.choice([1.0, 1.0, 0.0, 0.5]))}


def _wave(rng: np.random.Generator, scale: Scale) -> dict[str, float]:
    return {
        "period": scale.length * float(np.exp(rng.uniform(np.log(0.04), np.log(0.6)))),
        "phase": float(rng.uniform(-np.pi, np.pi)),
    }


def _moment(rng: np.random.Generator, scale: Scale) -> dict[str, float]:
    return {"time": scale.span * float(rng.uniform(0.3, 0.7))}


def _tenth(scale: Scale) -> float:
    return 0.1 * scale.length


COMMANDED = (
    Kind("home_offset", _plain("angle"), _tenth, _tenth, signed=True, needs="zero"),
    Kind("gear_ratio", _scale, lambda s: 0.01, lambda s: 0.2, signed=True),
    Kind("gear_backlash", _plain("width"), _tenth, _tenth),
    Kind("joint_friction", _plain("width"), _tenth, _tenth),
    Kind("following_lag", _lag, lambda s: 0.02 * s.time, lambda s: 0.15 * s.time, _shares),
    Kind("sensor_latency", _plain("time"), lambda s: 0.02 * s.time, lambda s: 0.15 * s.time),
    Kind("transmission_error", _with("amplitude", "period", "phase"), _tenth,
         lambda s: 0.05 * s.length, _wave),
    Kind("encoder_error", _with("amplitude", "period", "phase"), _tenth,
         lambda s: 0.05 * s.length, _wave),
    Kind("lost_steps",
         lambda x, d, s: {"steps": float(max(round(x / s.step), 1.0)), "time": d["time"]},
         _tenth, _tenth, _moment, needs="steps"),
    Kind("joint_compliance", lambda x, d, s: {"stiffness": s.load / x}, _tenth, _tenth,
         needs="load"),
    Kind("resonance", lambda x, d, s: {"frequency": x**-0.5, "damping": d["damping"]},
         lambda s: (0.25 * s.time) ** 2, lambda s: (0.4 * s.time) ** 2,
         lambda rng, s: {"damping": float(rng.uniform(0.03, 0.25))}),
    Kind("speed_limit", lambda x, d, s: {"limit": s.fastest / (1.0 + x)}, lambda s: 0.2,
         lambda s: 0.6),
)  # fmt: skip
FORCED = (
    Kind("joint_friction", _plain("torque"), lambda s: s.force, lambda s: 5.0 * s.force),
    Kind("viscous_friction", lambda x, d, s: {"coefficient": x / s.speed}, lambda s: s.force,
         lambda s: 5.0 * s.force),
    Kind("stribeck_friction", _with("torque", "speed"), lambda s: s.force, lambda s: 3.0 * s.force,
         lambda rng, s: {"speed": s.speed * float(rng.uniform(0.08, 0.25))}),
    Kind("effort_offset", _plain("offset"), lambda s: s.force, lambda s: 5.0 * s.force,
         signed=True),
    Kind("effort_gain", _scale, lambda s: 0.1, lambda s: 0.5, signed=True),
    Kind("inertia", lambda x, d, s: {"inertia": s.inertia * (1.0 + x)}, lambda s: 0.1,
         lambda s: 0.6, signed=True),
    Kind("following_lag", _lag, lambda s: 0.02 * s.time, lambda s: 0.06 * s.time, _shares),
    Kind("effort_limit", lambda x, d, s: {"limit": s.highest / (1.0 + x)}, lambda s: 0.2,
         lambda s: 0.35),
)  # fmt: skip
RANGING = (
    Kind("sensor_offset", _plain("offset"), _tenth, lambda s: 0.4 * s.away, signed=True),
    Kind("sensor_scale", _scale, lambda s: 0.01, lambda s: 0.3, signed=True),
    Kind("sensor_crosstalk", lambda x, d, s: {"curvature": x / s.away**2}, _tenth,
         lambda s: 0.3 * s.away, signed=True),
    Kind("sensor_drift", _with("offset", "time_constant"), _tenth, lambda s: 0.3 * s.away,
         lambda rng, s: {"time_constant": s.span * float(rng.uniform(0.1, 0.35))}, signed=True),
    Kind("sensor_latency", _plain("time"), lambda s: 0.02 * s.time, lambda s: 0.2 * s.time),
)  # fmt: skip


def _odd(
    effect: str,
    build: Build,
    first: Callable[[Scale], float],
    most: Callable[[Scale], float],
    follows: str,
    beside: str = "",
    extras: Callable[[np.random.Generator, Scale], dict[str, float]] = lambda rng, s: {},
) -> Kind:
    return Kind(effect, build, first, most, extras, unknown=True,
                follows=tuple(follows.split()), beside=tuple(beside.split()))  # fmt: skip


UNKNOWN_COMMANDED = (
    _odd("lag_by_direction", _with("time", "back"), lambda s: 0.02 * s.time,
         lambda s: 0.1 * s.time, "velocity direction", "following_lag sensor_latency",
         lambda rng, s: {"back": float(rng.uniform(2.5, 5.0))}),
    _odd("overshoot", lambda x, d, s: {"time": d["time"], "extra": x}, lambda s: 0.1,
         lambda s: 0.6, "velocity acceleration", "resonance",
         lambda rng, s: {"time": s.time * float(rng.uniform(0.05, 0.15))}),
    _odd("coupling", _plain("size"), _tenth, _tenth, "time", "home_offset"),
    _odd("growing_friction", _plain("width"), _tenth, _tenth, "position direction",
         "joint_friction gear_backlash home_offset"),
    _odd("warming_ratio", _with("share", "time"), lambda s: 0.01, lambda s: 0.1, "time",
         "gear_ratio home_offset",
         lambda rng, s: {"time": s.span * float(rng.uniform(0.2, 0.5))}),
    _odd("elastic_cable", _plain("size"), _tenth, _tenth, "position", "home_offset gear_ratio"),
)  # fmt: skip
UNKNOWN_FORCED = (
    _odd("coupling", _plain("size"), lambda s: s.force, lambda s: 4.0 * s.force, "time",
         "effort_offset"),
    _odd("friction_by_position", _plain("torque"), lambda s: s.force, lambda s: 4.0 * s.force,
         "position direction", "joint_friction effort_offset viscous_friction stribeck_friction"),
    _odd("gain_drifts", _with("share", "time"), lambda s: 0.1, lambda s: 0.5, "time",
         "effort_gain", lambda rng, s: {"time": s.span * float(rng.uniform(0.2, 0.5))}),
    _odd("weight_not_given", _with("size", "zero"), lambda s: s.force, lambda s: 4.0 * s.force,
         "position", "effort_offset",
         lambda rng, s: {"zero": float(rng.uniform(-np.pi, np.pi))}),
    _odd("cogging", _with("size", "period"), lambda s: s.force, lambda s: 2.0 * s.force,
         "position", "",
         lambda rng, s: {"period": s.length * float(rng.uniform(0.08, 0.4))}),
    _odd("elastic_cable", _plain("size"), lambda s: s.force, lambda s: 4.0 * s.force, "position",
         "effort_offset"),
)  # fmt: skip
UNKNOWN_RANGING = (
    _odd("hysteresis", _plain("width"), _tenth, _tenth, "velocity direction distance",
         "sensor_offset sensor_latency"),
    _odd("temperature", _plain("size"), _tenth, lambda s: 0.2 * s.away, "time", "sensor_offset"),
    _odd("stripes", _with("size", "period"), _tenth, _tenth, "distance", "",
         lambda rng, s: {"period": s.length * float(rng.uniform(0.1, 0.4))}),
    _odd("reflection", _with("size", "at", "within"), _tenth, lambda s: 0.2 * s.away, "distance",
         "sensor_offset sensor_scale",
         lambda rng, s: {"at": s.away - s.length * float(rng.uniform(0.3, 0.7)),
                         "within": s.length * float(rng.uniform(0.08, 0.2))}),
)  # fmt: skip
LIMITS = ("speed_limit", "effort_limit")
"""Effects that an answer may also call unknown: a limit has no pattern of its own."""
KINDS = {"commanded": COMMANDED, "effort": FORCED, "range": RANGING}
UNKNOWN = {"commanded": UNKNOWN_COMMANDED, "effort": UNKNOWN_FORCED, "range": UNKNOWN_RANGING}


def one(kind: Kind, values: Values) -> Sizes:
    """Only this, at these sizes."""
    return {kind.effect: values}
