"""A chain of joints by its efforts: what they are beyond what the model of the chain needs.

gain * effort - (inverse dynamics of the motion) = friction + rotors + load + what is missing,
linear in all sizes (Gautier 1997; Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca 2019, IEEE
Robotics and Automation Letters 4, 4147-4154). The joints are end to end in one channel, so that a
load, which all of them feel, is one regressor.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from deltactl.diagnosis.answer.records import NotTestable
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray
from deltactl.diagnosis.plants.chain.joint_efforts import CHAIN, JointEfforts
from deltactl.diagnosis.plants.left_over import UNKNOWN
from deltactl.diagnosis.plants.lone.clear_motion import clocks_apart_s
from deltactl.diagnosis.plants.lone.drive_by_effort import EffortLimit, late_sizes
from deltactl.diagnosis.plants.lone.options import FILE_SPREADS, FORCED_AXIS
from deltactl.diagnosis.plants.regressor import Columns, Draws, Regressor, Shown, Sizes, instead
from deltactl.models.effects.chain_joints import (
    JOINT_EFFECTS,
    LOAD,
    load_log_odds,
    load_moments,
    rotor_log_odds,
)
from deltactl.models.effects.effort_offset import ZERO_OFF
from deltactl.models.effects.following_lag import JOINT_S, JOINT_STARTS_S
from deltactl.models.effects.joint_friction import FRICTION_OFF
from deltactl.models.rigid_chain import BODY, RigidChain, force_per_unit
from deltactl.models.robot import ChainRobot
from deltactl.recording.tables.flat import FlatRecording

LATE = ("dead", "lag")  # by themselves: a drive with a dead time may have no time constant
DRIVEN = ("lag ", "dead ", "limit ")  # what a drive makes of its effort


class ChainPlant(JointEfforts):
    """All joints of a chain; `observed` is effort that model and robot file do not explain."""

    channel = "effort"

    def __init__(
        self, robot: ChainRobot, recordings: Sequence[FlatRecording], chain: RigidChain,
        narrower: float = 1.0,
    ):  # fmt: skip
        """narrower: the low-pass ends at this share of where the position meets its noise."""
        super().__init__(robot, recordings, chain, narrower)
        filtered = self.layout.laid(self._filtered)
        self.observed = filtered - self._explained
        self.observed = self.observed - self._driven_by_file()
        self.drawn_on = filtered - self.observed
        self.regressors = tuple(self._regressors())

    def of_measured_gain(self) -> ChainRobot:
        """The robot with what one unit of each effort makes, as its model needs it unladen."""
        rubs = [one.values for key, one in self._acting.items() if not key.startswith("rotor ")]
        beside = np.concatenate(rubs, axis=1)
        drawn, rows = self.layout.laid(self._filtered), self.rows
        gains = force_per_unit(drawn[rows], self._explained[rows], beside[rows], self.own[rows])
        return self.robot.with_gains(gains)

    # ---- the robot file ------------------------------------------------------------------------

    @cached_property
    def _explained(self) -> FloatArray:
        """Efforts (n,) of the model and of the linear effects in the robot file."""
        made = self.layout.laid(self._needed) + self._load.values @ self._loaded
        for key, sizes in self._stated:
            if not key.startswith((*DRIVEN, "gain ", LOAD)):  # a gain is in the efforts already
                column, joint = self._place(key)
                size = sizes[JOINT_EFFECTS[column].parameter] - self._kept(column, joint)
                made = made + self._acts(key, sizes.get("speed", 0.0)).values[:, 0] * size
        return made

    @property
    def _loaded(self) -> FloatArray:
        """Moments (10,) of the loads in the robot file."""
        each = [load_moments(sizes) for key, sizes in self._stated if key == LOAD]
        return np.asarray(np.sum([np.zeros(len(BODY)), *each], axis=0))

    @property
    def _stated(self) -> list[tuple[str, dict[str, float]]]:
        """Regressors of the effects in the robot file, with the sizes there."""
        keys = {(JOINT_EFFECTS[k].name, j): f"{k} {j}" for k in JOINT_EFFECTS for j in self.joints}
        keys[LOAD, self.chain.tip] = LOAD
        return [
            (key, {name: float(np.mean(value)) for name, value in one.parameters.items()})
            for one in self.robot.effects
            if (key := keys.get((one.effect, one.component)))
        ]

    def _driven_by_file(self) -> FloatArray:
        """What dead times and limits of the robot file change of the efforts, (n,)."""
        found: dict[str, float] = {}
        column_of = {one.parameter: key for key, one in JOINT_EFFECTS.items()}
        for key, sizes in self._stated:
            for name, size in sizes.items() if key.startswith(DRIVEN) else ():
                own = f"{column_of[name]} {key.partition(' ')[2]}.{name}"
                found[own] = found.get(own, 0.0) + size
        return self.base(frozenset(name.rpartition(".")[0] for name in found), found)

    def _place(self, key: str) -> tuple[str, int]:
        column, _, joint = key.partition(" ")
        return column, self.joints.index(joint)

    def _kept(self, column: str, joint: int) -> float:
        """What the model has of a size already."""
        return float(self.chain.armature[joint]) if column == "rotor" else 0.0

    # ---- what may be missing -------------------------------------------------------------------

    def _regressors(self) -> list[Regressor]:
        moving = [(j, self.joints[j]) for j in self.moving()]
        found = [
            Regressor(f"{key} {joint}", one.name, component=joint, alone=False, **differing)
            for j, joint in moving for key, one in JOINT_EFFECTS.items()
            for differing in [self._differing(key, j)]
        ]  # fmt: skip
        last = f"link {self.joints[-1]}"
        found.append(
            Regressor(LOAD, LOAD, load_log_odds(), self.chain.tip, alone=False, takes_over=last)
        )
        return [*found, *self.unknowns()]

    def _differing(self, key: str, joint: int) -> dict[str, Any]:
        """How the regressor of an effect at a joint differs from others."""
        name, chain, period_s = self.joints[joint], self.chain, self.moved.whole.period_s
        kept, by_gain = self._kept(key, joint), {"measured_by": f"gain {name}.scale"}

        def off(share: float, **more: Any) -> dict[str, Any]:
            return {"as_built": EVIDENCE.tolerated * share, **more}

        time, dead = late_sizes(JOINT_S, period_s)
        late = off(clocks_apart_s(period_s), saturated=False, starts=JOINT_STARTS_S)
        either = {"equivalents": instead("effort/offset")}
        brakes = {"positive": (JOINT_EFFECTS[key].parameter,), "above": 0.0, **by_gain}
        table = {
            "dry": off(FRICTION_OFF * float(chain.friction[joint]), **brakes),
            "viscous": off(FRICTION_OFF * float(chain.damping[joint]), **brakes),
            "rotor": {"above": -kept, "log_odds": rotor_log_odds(kept > 0.0), **by_gain},
            "stribeck": self._slow[joint].differs(f"gain {name}.scale"),
            "gain": off(CHAIN.as_built, above=-1.0),
            "offset": off(ZERO_OFF * float(self.sizes[joint]), **by_gain, **either),
            "lag": late | {"sizes": (time,)},
            "dead": late | {"sizes": (dead,), "takes_over": f"lag {name}"},
            "limit": self._limits[joint].differs,
        }  # fmt: skip
        usual = {"log_odds": JOINT_EFFECTS[key].log_odds, "takes_over": f"{key} {name}"}
        return usual | table[key]

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """Efforts less what they were when the motion that they make was asked for, (n,)."""
        made = np.zeros(len(self.t_s))
        own = {name: size for name, size in sizes.items() if name.rpartition(".")[0] in keys}
        for j, joint in enumerate(self.joints):
            late = [own.get(f"{key} {joint}.{JOINT_EFFECTS[key].parameter}", 0.0) for key in LATE]
            if any(late):
                made += self._since(j, *late)
            if (limit := own.get(f"limit {joint}.limit")) is not None and j in self._limits:
                made += self._limits[j].kept_back(limit)
        return made

    @cached_property
    def _limits(self) -> dict[int, EffortLimit]:
        """Limit of the drive at each joint that moves."""
        force, needed, load = self.layout.laid(self._filtered), self._explained, self._load.values
        found: dict[int, EffortLimit] = {}
        for j in self.moving():
            shapes = np.hstack([self.spanned(f"{self.joints[j]} effort"), load])
            own, rows = self.own[:, j], self.rows_of(j)
            found[j] = EffortLimit(force * own, needed, rows, self.observed, shapes)
        return found

    def without_noise(self, keys: frozenset[str], sizes: Sizes) -> BoolArray | None:
        """Rows whose effort is cut at a limit, and its noise with it, see `RegressionPlant`."""
        limits = frozenset(key for key in keys if key.startswith("limit "))
        return self.base(limits, sizes) != 0.0 if limits else None

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Efforts (n, k) of one regressor."""
        if key.startswith(UNKNOWN):
            return self.unknown(key)
        if key.startswith(DRIVEN):
            return Columns.none(len(self.t_s))
        return self._shapes.get(key) or self._acts(key, sizes[f"{key}.speed"])

    def _acts(self, key: str, speed: float) -> Columns:
        """Efforts (n, 1) of what acts at a joint; speed: within which it falls off, if it does."""
        if key in self._acting:
            return self._acting[key]
        joint = self._place(key)[1]
        slow, spread = self._slow[joint], FORCED_AXIS.stribeck_of_size * self.sizes[joint]
        shape = self._at(joint, slow.shapes @ slow.speeds.weights(speed))
        return Columns.of(shape, spread, "torque")

    @cached_property
    def _shapes(self) -> dict[str, Columns]:
        """The same, and what drives that are off make of it."""
        given = self._explained + self._load.values @ (self._carried - self._loaded)
        pairs, spread = zip(self.joints, self.own.T, strict=True), FILE_SPREADS.gain_share
        gains = {f"gain {j}": Columns.of(own * given, spread, "scale") for j, own in pairs}
        return {**self._acting, **gains, LOAD: self._load}

    def spanned(self, name: str) -> FloatArray:
        """Named shapes that no spline term of a joint may take the place of, (n, j).

        A torque constant that drifts is off on average, too. A load is at all joints together, and
        at one of them its ten moments have nearly any shape.
        """
        joint, _, follows = name.rpartition(" ")
        keys = ["dry", "viscous", "rotor"] if follows == "scale" else list(JOINT_EFFECTS)
        shapes = [self._shapes.get(f"{key} {joint}") for key in keys]
        named = [one.values for one in shapes if one]
        late = self._each(self._changing)[:, [self.joints.index(joint)]]
        return np.concatenate([*named, late], axis=1)

    def spread_of(self, name: str, shapes: int) -> float:
        """A third of the efforts of its joint."""
        usual = self.sizes[self.joints.index(name.rpartition(" ")[0])]
        return FORCED_AXIS.unknown_of_size * float(usual)

    def not_testable(self) -> list[NotTestable]:
        """All effects at joints that hardly move."""
        why, effects = "it hardly moves in this recording", JOINT_EFFECTS.values()
        still = [joint for j, joint in enumerate(self.joints) if j not in self.moving()]
        return [NotTestable.of(one.name, joint, why) for joint in still for one in effects]

    def noise_bounds(self, left: FloatArray) -> None:
        """The low-pass leaves nothing beyond its band that would show the noise in it."""

    @cached_property
    def variant(self) -> ChainPlant:
        """The same under a narrower low-pass: what differs between the two is no knowledge."""
        return ChainPlant(self.robot, self._recordings, self.chain, FORCED_AXIS.narrower)

    def adopt(self, trained: ChainPlant) -> None:
        """Spreads and load of the recording that sizes were found on."""
        self.sizes, self._carried = trained.sizes, trained._carried
        for own, other in zip(self._slow, trained._slow, strict=True):
            own.speeds = other.speeds
        for name in ("_acting", "_shapes"):
            self.__dict__.pop(name, None)

    def shown(self, key: str) -> Sequence[Shown]:
        """Parameters of the effects, in SI units."""
        if key.startswith(UNKNOWN):
            return []
        if key == LOAD:
            at = [Shown(f"centre_{a}", "m", _centre(f"first_{a}"), np.nan) for a in "xyz"]
            return [Shown("mass", "kg", lambda v: v["mass"]), *at]
        column, joint = self._place(key)
        one, kept = JOINT_EFFECTS[column], self._kept(column, joint)
        name, unit = one.parameter, one.unit_of(self.chain.slides[joint])
        if column == "gain":
            return [Shown(name, unit, lambda v: 1.0 / (1.0 + v[name]), one.nothing)]
        if column in LATE:
            return [Shown(name, unit, lambda v: v[name])]
        gain, nothing = f"gain {self.joints[joint]}.scale", kept or one.nothing
        found = [Shown(name, unit, lambda v: kept + v[name] / (1.0 + v.get(gain, 0.0)), nothing)]
        if one.besides:
            unit = one.unit_of(self.chain.slides[joint], one.besides)
            found.append(Shown(one.besides, unit, lambda v: v[one.besides]))
        return found


def _centre(first: str) -> Callable[[Draws], FloatArray]:
    """Distance of a load's centre, by its first moment."""
    return lambda v: np.asarray(v[first] / np.where(v["mass"] == 0.0, 1e-300, v["mass"]))
