"""A chain of joints by its efforts: what they are beyond what the model of the chain needs.

gain * effort - (inverse dynamics of the motion) = friction + rotors + load + what is missing,
linear in all sizes (Gautier 1997; Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca 2019, IEEE
Robotics and Automation Letters 4, 4147-4154). The joints are end to end in one channel, so that a
load, which all of them feel, is one regressor.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from deltactl.diagnosis.answer.records import NotTestable
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.chain.joint_efforts import CHAIN, JointEfforts
from deltactl.diagnosis.plants.lone.odds import FILE_SPREADS
from deltactl.diagnosis.plants.lone.options import FORCED_AXIS, LONE
from deltactl.diagnosis.plants.options import SPLINE_TERMS
from deltactl.diagnosis.plants.regression import (
    Columns,
    Draws,
    Regressor,
    Shown,
    Size,
    Sizes,
)
from deltactl.diagnosis.plants.spline_terms import KeepsBeside, less_spanned
from deltactl.models.effects.chain_joints import (
    JOINT_EFFECTS,
    LOAD,
    load_log_odds,
    rotor_log_odds,
)
from deltactl.models.rigid_chain import BODY, RigidChain
from deltactl.models.robot import ChainRobot
from deltactl.recording.tables.flat import FlatRecording

UNKNOWN = "unknown"
BRAKES = ("dry", "viscous")
"""No joint has less than none of these."""


class ChainPlant(JointEfforts, KeepsBeside):
    """All joints of a chain; `observed` is effort that model and robot file do not explain."""

    averages = False
    rounding = 0.0
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

    # ---- the robot file ------------------------------------------------------------------------

    @cached_property
    def _explained(self) -> FloatArray:
        """Efforts (n,) of the model and of the linear effects in the robot file."""
        made, gains = self.layout.laid(self._needed), np.ones(len(self.joints))
        for entry in self.robot.effects:
            sizes = {name: float(np.mean(value)) for name, value in entry.parameters.items()}
            name = (entry.effect, entry.component)
            for key, columns in {**self._acting, LOAD: self._load}.items():
                if self._name(key) == name:
                    made = made + columns.values @ self._entered(key, sizes)
            for j, joint in enumerate(self.joints):
                if name == self._name(f"gain {joint}"):
                    gains[j] *= sizes["scale"]
        return np.asarray(made / gains[self.kinds])

    def _late_by_file(self) -> FloatArray:
        """What dead times of the robot file change of the efforts, (n,)."""
        dead_s: dict[str, float] = {}
        for one in self.robot.effects:
            if (one.effect, one.component) == self._name(key := f"lag {one.component}"):
                more_s = float(np.mean(one.parameters["dead_time"]))
                dead_s[f"{key}.dead_time"] = dead_s.get(f"{key}.dead_time", 0.0) + more_s
        return self.base(frozenset(name.rpartition(".")[0] for name in dead_s), dead_s)

    def _entered(self, key: str, sizes: Mapping[str, float]) -> FloatArray:
        """Sizes of a regressor's columns that the robot file gives."""
        if key == LOAD:
            x, y, z = (sizes.get(f"centre_{axis}", 0.0) for axis in "xyz")
            moments = [1.0, x, y, z, x * x, y * y, z * z, x * y, x * z, y * z]
            return sizes.get("mass", 0.0) * np.array(moments)
        column, joint = self._place(key)
        size = sizes.get(JOINT_EFFECTS[column].parameter, 0.0)
        return np.array([size - self._kept(column, joint)])

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
                **{"log_odds": one.log_odds, **self._differing(key, j)},
            )
            for j, joint in moving for key, one in JOINT_EFFECTS.items()
        ]  # fmt: skip
        last = f"link {self.joints[-1]}"
        found.append(
            Regressor(LOAD, LOAD, load_log_odds(), self.chain.tip, alone=False, takes_over=last)
        )
        return found + [
            Regressor(
                f"{UNKNOWN} {joint} {name}", UNKNOWN, SPLINE_TERMS.unknown_log_odds, joint,
                follows=one.follows, left_over=True,
            )
            for j, joint in moving for name, one in self._ways(j).items()
        ]  # fmt: skip

    def _differing(self, key: str, joint: int) -> dict[str, Any]:
        """How the regressor of an effect at a joint differs from others."""
        as_built, step_s = EVIDENCE.tolerated, 0.05 * self.moved.whole.period_s
        name = self.joints[joint]
        by_gain = {"measured_by": f"gain {name}.scale"}
        if key in BRAKES:
            stated = (self.chain.friction, self.chain.damping)[BRAKES.index(key)][joint]
            as_built *= CHAIN.friction_as_stated * float(stated)
            positive = (JOINT_EFFECTS[key].parameter,)
            return {"positive": positive, "as_built": as_built, **by_gain}
        if key == "gain":
            return {"as_built": as_built * CHAIN.as_built, "takes_over": f"{key} {name}"}
        if key == "rotor":
            return {"log_odds": rotor_log_odds(self._kept(key, joint) > 0.0), **by_gain}
        if key != "lag":
            return by_gain
        as_built *= self._apart_s
        lag = Size("dead_time", "half", CHAIN.dead_time_s, 0.0, LONE.longest_lag_s, step_s)
        return {
            "sizes": (lag,), "as_built": as_built, "takes_over": f"{key} {name}",
            "saturated": False,
        }  # fmt: skip

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """Efforts less what they were when the motion that they make was asked for, (n,)."""
        made = np.zeros(len(self.t_s))
        for key in keys:
            if key.startswith("lag "):
                made += self._since(self._place(key)[1], sizes[f"{key}.dead_time"])
        return made

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Efforts (n, k) of one regressor."""
        return self._unknown[key] if key.startswith(UNKNOWN) else self._shapes[key]

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
        made = {}
        for column, (values, spreads) in tables.items():
            name, each = (JOINT_EFFECTS[column].parameter,), self._each(values)
            for j, joint in enumerate(self.joints):
                made[f"{column} {joint}"] = Columns(each[:, [j]], spreads[[j]], name)
        return made

    @cached_property
    def _shapes(self) -> dict[str, Columns]:
        """The same, and what drives make of it."""
        found, share = {**self._acting, LOAD: self._load}, np.array([FILE_SPREADS.gain_share])
        name = (JOINT_EFFECTS["gain"].parameter,)
        given = self._explained + self._load.values @ self._carried
        for j, joint in enumerate(self.joints):
            own = np.where(self.kinds == j, given, 0.0)
            found[f"gain {joint}"] = Columns(own[:, None], share, name)
            found[f"lag {joint}"] = Columns(np.zeros((len(self.t_s), 0)), np.zeros(0))
        return found

    @cached_property
    def _carried(self) -> FloatArray:
        """Most probable moments (10,) of a load beside all that has a name.

        A drive that is off gives a share of the load's effort, too: gain times load is no sum, so
        that one of both has to be known first.
        """
        moments, own = np.zeros(len(BODY)), self.kinds[:, None] == np.arange(len(self.joints))
        spread = np.full(len(self.joints), FILE_SPREADS.gain_share)
        left = self.observed[self.rows] / (CHAIN.noise * self.usual[self.rows])
        for _ in range(CHAIN.rounds):
            given = self._explained + self._load.values @ moments
            drives = Columns(given[:, None] * own, spread)
            white = self.whitened([self._load, drives, self.free(), *self._acting.values()])
            known = np.eye(white.shape[1]) + white.T @ white
            size = np.linalg.solve(known, white.T @ left)
            moments = size[: len(BODY)] * self._load.spread
        return moments

    def _spanned(self, joint: int, name: str) -> FloatArray:
        """Named shapes that no spline term of a joint may take the place of, (n, j).

        A torque constant that drifts is off on average, too. A load is at all joints together, and
        at one of them its ten moments have nearly any shape.
        """
        keys = [*BRAKES, "rotor"] if name == "scale" else list(JOINT_EFFECTS)
        named = [self._shapes[f"{key} {self.joints[joint]}"].values for key in keys]
        late = self._at(joint, self._changing[:, joint])[:, None]
        return np.concatenate([*named, late, self.beside], axis=1)

    @cached_property
    def _unknown(self) -> dict[str, Columns]:
        found = {}
        for j in self.moving():
            rows, joint = self.rows_of(j), self.joints[j]
            usual = FORCED_AXIS.unknown_of_size * float(self.sizes[j])
            for name, way in self._ways(j).items():
                shapes = less_spanned(way.basis(rows), self._spanned(j, name), rows)
                shapes = shapes * (self.kinds == j)[:, None]
                key = f"{UNKNOWN} {joint} {name}"
                found[key] = Columns(shapes, np.full(shapes.shape[1], usual))
        return found

    def followed(self, key: str) -> FloatArray:
        """Covariate (n,) of an unknown; NaN where it does not act."""
        joint, _, name = key.removeprefix(f"{UNKNOWN} ").rpartition(" ")
        number = self.joints.index(joint)
        return np.where(self.kinds == number, self._ways(number)[name].along, np.nan)

    def not_testable(self) -> list[NotTestable]:
        """All effects at joints that hardly move."""
        still = [joint for j, joint in enumerate(self.joints) if j not in self.moving()]
        return [
            NotTestable(effect=one.name, component=joint, why="it hardly moves in this recording")
            for joint in still
            for one in JOINT_EFFECTS.values()
        ]

    def noise_bounds(self, left: FloatArray) -> None:
        """The low-pass leaves nothing beyond its band that would show the noise in it."""

    def variant(self) -> ChainPlant:
        """The same under a narrower low-pass: what differs between the two is no knowledge."""
        return self._narrower

    @cached_property
    def _narrower(self) -> ChainPlant:
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
            centre = [
                Shown(f"centre_{axis}", "m", _centre(f"first_{axis}"), nothing=np.nan)
                for axis in "xyz"
            ]
            return [Shown("mass", "kg", lambda v: v["mass"]), *centre]
        column, joint = self._place(key)
        one, kept = JOINT_EFFECTS[column], self._kept(column, joint)
        name, unit = one.parameter, one.unit_of(self.chain.slides[joint])
        if column == "gain":
            return [Shown(name, unit, lambda v: 1.0 / (1.0 + v[name]), one.nothing)]
        if column == "lag":
            return [Shown(name, unit, lambda v: v[name])]
        gain = f"gain {self.joints[joint]}.scale"
        return [Shown(name, unit, lambda v: kept + v[name] / (1.0 + v.get(gain, 0.0)), kept)]

    def impossible(
        self, keys: frozenset[str], sizes: Sizes, linear: Mapping[str, FloatArray]
    ) -> bool:
        """Friction that drives, a rotor or a gain below zero."""
        late_s = [sizes[name] for key in keys if (name := f"{key}.dead_time") in sizes]
        if any(not 0.0 < one_s < LONE.longest_lag_s for one_s in late_s):
            return True
        bounded = [k for k in keys if k.partition(" ")[0] in (*BRAKES, "gain", "rotor")]
        places = [(float(linear[key][0]), *self._place(key)) for key in bounded]
        return any(v <= (-1.0 if c == "gain" else -self._kept(c, j)) for v, c, j in places)

    def starts(self, key: str, residual: FloatArray) -> Sequence[dict[str, float]]:
        """Starts of a dead time: all others are linear."""
        if not key.startswith("lag "):
            return [{}]
        return [{f"{key}.dead_time": at} for at in CHAIN.dead_times_s]


def _centre(first: str) -> Callable[[Draws], FloatArray]:
    """Distance of a load's centre, by its first moment."""
    return lambda v: np.asarray(v[first] / np.where(v["mass"] == 0.0, 1e-300, v["mass"]))
