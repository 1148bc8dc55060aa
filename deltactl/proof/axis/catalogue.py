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
Size = Callable[[Scale], float]
Extras = Callable[[np.random.Generator, Scale], dict[str, float]]


@dataclass(frozen=True)
class Kind:
    """One thing that can be hidden.

    first: size x to begin with, most: largest, both in units that `build` knows. extras: what is
    drawn beside the size. needs: 'load', 'steps', 'zero' or 'inertia' where the machine must have
    it. follows: covariates of an unknown; beside: what may be named beside it without being wrong.
    least: size below which it is no cause, as any machine is off by as much.
    """

    effect: str
    build: Build
    first: Size
    most: Size
    extras: Extras = field(default=lambda rng, scale: {})
    signed: bool = False
    needs: str = ""
    unknown: bool = False
    follows: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()
    least: Size = field(default=lambda scale: 0.0)

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


def _drawn(name: str, low: float, high: float, unit: str = "") -> Extras:
    """Something drawn evenly, in a unit of the scale."""
    return lambda rng, scale: {
        name: (getattr(scale, unit) if unit else 1.0) * float(rng.uniform(low, high))
    }


def _of(unit: str, share: float = 1.0) -> Size:
    return lambda scale: share * float(getattr(scale, unit))


def _flat(size: float) -> Size:
    return lambda scale: size


_tenth = _of("length", 0.1)
_moment = _drawn("time", 0.3, 0.7, "span")
COMMANDED = (
    Kind("home_offset", _plain("angle"), _tenth, _tenth, signed=True, needs="zero"),
    Kind("gear_ratio", _scale, _flat(0.01), _flat(0.2), signed=True),
    Kind("gear_backlash", _plain("width"), _tenth, _tenth),
    Kind("joint_friction", _plain("width"), _tenth, _tenth),
    Kind("following_lag", _lag, _of("time", 0.02), _of("time", 0.15), _shares),
    Kind("sensor_latency", _plain("time"), _of("time", 0.02), _of("time", 0.15)),
    Kind("transmission_error", _with("amplitude", "period", "phase"), _tenth, _of("length", 0.05),
         _wave),
    Kind("encoder_error", _with("amplitude", "period", "phase"), _tenth, _of("length", 0.05),
         _wave),
    Kind("lost_steps", lambda x, d, s: {"steps": float(max(round(x / s.step), 1.0)), "time":
         d["time"]}, _tenth, _tenth, _moment, needs="steps"),
    Kind("joint_compliance", lambda x, d, s: {"stiffness": s.load / x}, _tenth, _tenth,
         needs="load"),
    Kind("resonance", lambda x, d, s: {"frequency": x**-0.5, "damping": d["damping"]}, lambda s:
         (0.25 * s.time) ** 2, lambda s: (0.4 * s.time) ** 2, _drawn("damping", 0.03, 0.25)),
    Kind("speed_limit", lambda x, d, s: {"limit": s.fastest / (1.0 + x)}, _flat(0.2), _flat(0.6)),
)  # fmt: skip
STATED = 0.02
"""Parts are weighed, and torque constants stated, to a hundredth or so; an effort is held for a
period, and stamped as early or as late as its logger likes."""
FORCED = (
    Kind("joint_friction", _plain("torque"), _of("force"), _of("force", 5.0)),
    Kind("viscous_friction", lambda x, d, s: {"coefficient": x / s.speed}, _of("force"),
         _of("force", 5.0)),
    Kind("stribeck_friction", _with("torque", "speed"), _of("force"), _of("force", 3.0),
         _drawn("speed", 0.08, 0.25, "speed")),
    Kind("effort_offset", _plain("offset"), _of("force"), _of("force", 5.0), signed=True),
    Kind("effort_gain", _scale, _flat(0.1), _flat(0.5), signed=True, least=_flat(STATED)),
    Kind("inertia", lambda x, d, s: {"inertia": s.inertia * (1.0 + x)}, _flat(0.1), _flat(0.6),
         signed=True, least=_flat(STATED)),
    Kind("following_lag", _lag, _of("time", 0.02), _of("time", 0.06), _shares,
         least=_of("period")),
    Kind("effort_limit", lambda x, d, s: {"limit": s.highest / (1.0 + x)}, _flat(0.2), _flat(0.35)),
)  # fmt: skip
RANGING = (
    Kind("sensor_offset", _plain("offset"), _tenth, _of("away", 0.4), signed=True),
    Kind("sensor_scale", _scale, _flat(0.01), _flat(0.3), signed=True),
    Kind("sensor_crosstalk", lambda x, d, s: {"curvature": x / s.away**2}, _tenth, _of("away", 0.3),
         signed=True),
    Kind("sensor_drift", _with("offset", "time_constant"), _tenth, _of("away", 0.3),
         _drawn("time_constant", 0.1, 0.35, "span"), signed=True),
    Kind("sensor_latency", _plain("time"), _of("time", 0.02), _of("time", 0.2)),
)  # fmt: skip


def _odd(
    effect: str,
    build: Build,
    first: Size,
    most: Size,
    follows: str,
    beside: str = "",
    extras: Extras = lambda rng, s: {},
) -> Kind:
    causes, named = tuple(follows.split()), tuple(beside.split())
    return Kind(effect, build, first, most, extras, unknown=True, follows=causes, beside=named)


UNKNOWN_COMMANDED = (
    _odd("lag_by_direction", _with("time", "back"), _of("time", 0.02), _of("time", 0.1),
         "velocity direction", "following_lag sensor_latency", _drawn("back", 2.5, 5.0)),
    _odd("overshoot", lambda x, d, s: {"time": d["time"], "extra": x}, _flat(0.1), _flat(0.6),
         "velocity acceleration", "resonance", _drawn("time", 0.05, 0.15, "time")),
    _odd("coupling", _plain("size"), _tenth, _tenth, "time", "home_offset"),
    _odd("growing_friction", _plain("width"), _tenth, _tenth, "position direction",
         "joint_friction gear_backlash home_offset"),
    _odd("warming_ratio", _with("share", "time"), _flat(0.01), _flat(0.1), "time",
         "gear_ratio home_offset", _drawn("time", 0.2, 0.5, "span")),
    _odd("elastic_cable", _plain("size"), _tenth, _tenth, "position", "home_offset gear_ratio"),
)  # fmt: skip
UNKNOWN_FORCED = (
    _odd("coupling", _plain("size"), _of("force"), _of("force", 4.0), "time", "effort_offset"),
    _odd("friction_by_position", _plain("torque"), _of("force"), _of("force", 4.0),
         "position direction", "joint_friction effort_offset viscous_friction stribeck_friction"),
    _odd("gain_drifts", _with("share", "time"), _flat(0.1), _flat(0.5), "time", "effort_gain",
         _drawn("time", 0.2, 0.5, "span")),
    _odd("weight_not_given", _with("size", "zero"), _of("force"), _of("force", 4.0), "position",
         "effort_offset", _drawn("zero", -np.pi, np.pi)),
    _odd("cogging", _with("size", "period"), _of("force"), _of("force", 2.0), "position", "",
         _drawn("period", 0.08, 0.4, "length")),
    _odd("elastic_cable", _plain("size"), _of("force"), _of("force", 4.0), "position",
         "effort_offset"),
)  # fmt: skip
UNKNOWN_RANGING = (
    _odd("hysteresis", _plain("width"), _tenth, _tenth, "velocity direction distance",
         "sensor_offset sensor_latency"),
    _odd("temperature", _plain("size"), _tenth, _of("away", 0.2), "time", "sensor_offset"),
    _odd("stripes", _with("size", "period"), _tenth, _tenth, "distance", "", _drawn("period", 0.1,
         0.4, "length")),
    _odd("reflection", _with("size", "at", "within"), _tenth, _of("away", 0.2), "distance",
         "sensor_offset sensor_scale", lambda rng, s: {"at": s.away - s.length *
         float(rng.uniform(0.3, 0.7)), "within": s.length * float(rng.uniform(0.08, 0.2))}),
)  # fmt: skip
LIMITS = ("speed_limit", "effort_limit")
"""Effects that an answer may also call unknown: a limit has no pattern of its own."""
KINDS = {"commanded": COMMANDED, "effort": FORCED, "range": RANGING}
UNKNOWN = {"commanded": UNKNOWN_COMMANDED, "effort": UNKNOWN_FORCED, "range": UNKNOWN_RANGING}


def one(kind: Kind, values: Values) -> Sizes:
    """Only this, at these sizes."""
    return {kind.effect: values}
