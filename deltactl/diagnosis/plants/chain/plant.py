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
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.chain.joint_efforts import CHAIN, JointEfforts
from deltactl.diagnosis.plants.left_over import UNKNOWN
from deltactl.diagnosis.plants.lone.clear_motion import clocks_apart_s
from deltactl.diagnosis.plants.lone.options import FILE_SPREADS, FORCED_AXIS, LONE
from deltactl.diagnosis.plants.regression import Columns, Draws, Regressor, Shown, Size, Sizes
from deltactl.models.effects.chain_joints import (
    JOINT_EFFECTS,
    LOAD,
    load_log_odds,
    load_moments,
    rotor_log_odds,
)
from deltactl.models.rigid_chain import BODY, RigidChain, force_per_unit
from deltactl.models.robot import ChainRobot
from deltactl.recording.tables.flat import FlatRecording


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
        self.observed = filtered - self._explained - self._late_by_file()
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
        made, gains = self.layout.laid(self._needed), np.ones(len(self.joints))
        for key, sizes in self._stated:
            if key == LOAD:
                made = made + self._load.values @ load_moments(sizes)
                continue
            column, joint = self._place(key)
            if column == "gain":
                gains[joint] *= sizes["scale"]
            elif column != "lag":
                size = sizes[JOINT_EFFECTS[column].parameter] - self._kept(column, joint)
                made = made + self._acting[key].values[:, 0] * size
        return np.asarray(made / gains[self.kinds])

    @property
    def _stated(self) -> list[tuple[str, dict[str, float]]]:
        """Regressors of the effects in the robot file, with the sizes there."""
        every = [LOAD, *(f"{key} {joint}" for key in JOINT_EFFECTS for joint in self.joints)]
        keys = {self._name(key): key for key in every}
        return [
            (key, {name: float(np.mean(value)) for name, value in one.parameters.items()})
            for one in self.robot.effects
            if (key := keys.get((one.effect, one.component)))
        ]

    def _late_by_file(self) -> FloatArray:
        """What dead times of the robot file change of the efforts, (n,)."""
        dead_s: dict[str, float] = {}
        for key, sizes in self._stated:
            if key.startswith("lag "):
                dead_s[key] = dead_s.get(key, 0.0) + sizes["dead_time"]
        return self.base(frozenset(dead_s), {f"{key}.dead_time": s for key, s in dead_s.items()})

    def _place(self, key: str) -> tuple[str, int]:
        column, _, joint = key.partition(" ")
        return column, self.joints.index(joint)

    def _name(self, key: str) -> tuple[str, str]:
        """Effect and component of a regressor."""
        column, _, joint = key.partition(" ")
        return (LOAD, self.chain.tip) if key == LOAD else (JOINT_EFFECTS[column].name, joint)

    def _kept(self, column: str, joint: int) -> float:
        """What the model has of a size already."""
        return float(self.chain.armature[joint]) if column == "rotor" else 0.0

    # ---- what may be missing -------------------------------------------------------------------

    def _regressors(self) -> list[Regressor]:
        moving = [(j, self.joints[j]) for j in self.moving()]
        found = [
            Regressor(
                f"{key} {joint}", one.name, component=joint, alone=False,
                takes_over=f"{key} {joint}",
                **{"log_odds": one.log_odds, **self._differing(key, j)},
            )
            for j, joint in moving for key, one in JOINT_EFFECTS.items()
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

        brakes = {"positive": (JOINT_EFFECTS[key].parameter,), "above": 0.0, **by_gain}
        spread_s, longest_s = CHAIN.dead_time_s, LONE.longest_lag_s
        late = Size(
            "dead_time", "half", spread_s, 0.0, longest_s, 0.05 * period_s, within=(0.0, longest_s)
        )
        table = {
            "dry": off(CHAIN.friction_as_stated * float(chain.friction[joint]), **brakes),
            "viscous": off(CHAIN.friction_as_stated * float(chain.damping[joint]), **brakes),
            "rotor": {"above": -kept, "log_odds": rotor_log_odds(kept > 0.0), **by_gain},
            "gain": off(CHAIN.as_built, above=-1.0),
            "offset": off(CHAIN.zero_of_current * float(self.sizes[joint]), **by_gain),
            "lag": off(
                clocks_apart_s(period_s), sizes=(late,), saturated=False,
                starts=tuple((dead_s,) for dead_s in CHAIN.dead_times_s),
            ),
        }  # fmt: skip
        return table.get(key, by_gain)

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """Efforts less what they were when the motion that they make was asked for, (n,)."""
        made = np.zeros(len(self.t_s))
        for key in keys:
            if key.startswith("lag "):
                made += self._since(self._place(key)[1], sizes[f"{key}.dead_time"])
        return made

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Efforts (n, k) of one regressor."""
        return self.unknown(key) if key.startswith(UNKNOWN) else self._shapes[key]

    @cached_property
    def _acting(self) -> dict[str, Columns]:
        """Efforts (n, k) of all that acts at a joint or at the last link."""
        change = self._low_passed(self.moved.change)
        brisk = np.sqrt(np.maximum(self._usually(change**2), 1e-300))
        tables = {
            "dry": (self._direction, self.sizes),
            "viscous": (self._speed, self.sizes / self.moved.top_speeds),
            "rotor": (change, self.sizes / brisk),
            "offset": (np.ones_like(change), self.sizes),
        }
        return {
            f"{column} {joint}": Columns.of(each, spread, JOINT_EFFECTS[column].parameter)
            for column, (values, spreads) in tables.items()
            for joint, each, spread in zip(self.joints, self._each(values).T, spreads, strict=True)
        }

    @cached_property
    def _shapes(self) -> dict[str, Columns]:
        """The same, and what drives make of it."""
        found = {**self._acting, LOAD: self._load}
        given = self._explained + self._load.values @ self._carried
        for joint, own in zip(self.joints, self.own.T, strict=True):
            found[f"gain {joint}"] = Columns.of(own * given, FILE_SPREADS.gain_share, "scale")
            found[f"lag {joint}"] = Columns.none(len(self.t_s))
        return found

    @cached_property
    def _carried(self) -> FloatArray:
        """Most probable moments (10,) of a load beside all that has a name.

        A drive that is off gives a share of the load's effort, too: gain times load is no sum, so
        that one of both has to be known first.
        """
        moments = np.zeros(len(BODY))
        spread = np.full(len(self.joints), FILE_SPREADS.gain_share)
        left = self.observed[self.rows] / (CHAIN.noise * self.usual[self.rows])
        for _ in range(CHAIN.rounds):
            given = self._explained + self._load.values @ moments
            drives = Columns(given[:, None] * self.own, spread)
            white = self.whitened([self._load, drives, self.free(), *self._acting.values()])
            known = np.eye(white.shape[1]) + white.T @ white
            size = np.linalg.solve(known, white.T @ left)
            moments = size[: len(BODY)] * self._load.spread
        return moments

    def spanned(self, name: str) -> FloatArray:
        """Named shapes that no spline term of a joint may take the place of, (n, j).

        A torque constant that drifts is off on average, too. A load is at all joints together, and
        at one of them its ten moments have nearly any shape.
        """
        joint, _, follows = name.rpartition(" ")
        keys = ["dry", "viscous", "rotor"] if follows == "scale" else list(JOINT_EFFECTS)
        named = [self._shapes[f"{key} {joint}"].values for key in keys]
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
        if column == "lag":
            return [Shown(name, unit, lambda v: v[name])]
        gain = f"gain {self.joints[joint]}.scale"
        return [Shown(name, unit, lambda v: kept + v[name] / (1.0 + v.get(gain, 0.0)), kept)]


def _centre(first: str) -> Callable[[Draws], FloatArray]:
    """Distance of a load's centre, by its first moment."""
    return lambda v: np.asarray(v[first] / np.where(v["mass"] == 0.0, 1e-300, v["mass"]))
