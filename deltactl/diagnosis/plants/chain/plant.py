"""A chain of joints by its efforts: what they are beyond what the model of the chain needs.

gain * effort - (inverse dynamics of the motion) = friction + rotors + load + what is missing,
linear in all sizes (Gautier 1997; Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca 2019, IEEE
Robotics and Automation Letters 4, 4147-4154). The joints are end to end in one channel, so that a
load, which all of them feel, is one regressor.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import FloatArray, IntArray, Readings
from deltactl.diagnosis.plants.chain.joint_motions import (
    JointMotions,
    Layout,
    joint_motions,
    prepared,
)
from deltactl.diagnosis.plants.lone.odds import FILE_SPREADS
from deltactl.diagnosis.plants.lone.options import FORCED_AXIS, LONE, SERVO_JOINTS
from deltactl.diagnosis.plants.options import SPLINE_TERMS
from deltactl.diagnosis.plants.regression import (
    Columns,
    Draws,
    Regressor,
    Shown,
    Size,
    Sizes,
)
from deltactl.diagnosis.plants.spline_terms import KeepsBeside, less_spanned, spline_basis
from deltactl.models.effects.chain_joints import (
    JOINT_EFFECTS,
    LOAD,
    load_log_odds,
    rotor_log_odds,
)
from deltactl.models.rigid_chain import BODY, RigidChain
from deltactl.models.robot import ChainRobot
from deltactl.models.signals import clipped, late
from deltactl.recording.tables.flat import FlatRecording

UNKNOWN = "unknown"
BRAKES = ("dry", "viscous")
"""No joint has less than none of these."""


@dataclass(frozen=True, slots=True)
class ChainOptions:
    """What is usual of chains."""

    most_rows: int = 3000
    """Rows of all joints beyond which more tell nothing, as neighbours are alike."""
    fewest_rows: int = 30
    """Rows of a joint in clear motion, as of a single axis."""
    fewest_poses: int = 15
    """Five numbers for each of the nine of base and target, three of which each pose gives."""
    as_built: float = 0.02
    """Share by which efforts that the model needs are off on any arm: masses of a drawing, without
    cables, grease and screws, and torque constants that change with the warmth."""
    friction_as_stated: float = 0.05
    """Share by which friction differs from what the model states: two days differ by 5 to 10 % with
    the warmth (UR10e)."""
    yields_of_travel: float = 1e-3
    """Way over which a bearing yields before it slides, as a share of the travel (a harmonic drive:
    minutes of arc),"""
    yields_of_size: float = 0.1
    """and the friction that does, as a share of all effort."""
    bends: int = 2
    """Pieces of a spline by which friction grows along the way, or a torque constant in time."""
    dead_time_s: float = 0.05
    """Spread of a drive's dead time: a slow bus, or a filter of its own,"""
    dead_times_s: tuple[float, ...] = (0.003, 0.015, 0.08, 0.3)
    """and from where fits of it begin, apart by a factor of five."""
    load_of_mass: float = 0.1
    """Usual load as a share of what moves: arms carry a tenth to a third of what they weigh."""
    load_off_of_reach: float = 0.1
    """Usual distance of its centre from the end of the last link, as a share of the reach."""


CHAIN = ChainOptions()


@dataclass(frozen=True, slots=True, eq=False)
class _Way:
    """What an unknown effort follows, (n,), times what else it grows with; pieces: of its spline, 0
    of a straight line.
    """

    follows: tuple[str, ...]
    along: FloatArray
    times: FloatArray | float
    pieces: int

    def basis(self, rows: IntArray) -> FloatArray:
        """Shapes (n, k)."""
        if not self.pieces:
            return self.along[:, None]
        low, high = (float(x) for x in np.quantile(self.along[rows], SPLINE_TERMS.covered))
        basis = spline_basis(self.along, self.pieces, low, high)
        return basis * (self.times if isinstance(self.times, float) else self.times[:, None])


class ChainPlant(KeepsBeside):
    """All joints of a chain; `observed` is effort that model and robot file do not explain."""

    averages = False
    rounding = 0.0
    channel = "effort"

    def __init__(
        self,
        robot: ChainRobot,
        recordings: Sequence[FlatRecording],
        chain: RigidChain,
        narrower: float = 1.0,
    ):
        """narrower: the low-pass ends at this share of where the position meets its noise."""
        self.robot, self.chain, self.source = robot, chain, recordings[0].source
        self._recordings = tuple(recordings)
        self.joints = chain.joints
        self.unit = "N" if all(chain.slides) else "N m"
        self.moved: JointMotions = joint_motions(robot, prepared(robot, recordings), narrower)
        moved = self.moved
        self._filtered = moved.low_passed(moved.force)
        needed = chain.efforts(moved.at, moved.speed, moved.change)
        self._needed = moved.low_passed(needed) + chain.friction * self._direction
        observed = self._filtered - self._needed
        stride = max(moved.stride, -(-int(moved.counts.sum()) // CHAIN.most_rows))
        self.layout = Layout(moved, ASSESSMENT.folds, stride)
        self.readings: Readings = self.layout.readings(moved, observed, self.unit)
        self.t_s = self.readings.t_s
        self.kinds: IntArray = self.layout.joint
        self.groups = np.cumsum(self.readings.fresh).astype(np.intp)
        self.rows: IntArray = np.flatnonzero(self.readings.valid[:, 0])
        self.beside = np.zeros((len(self.t_s), 0))
        self.observed = self.readings.values[:, 0] - self._known()
        self.drawn_on = self.layout.laid(self._filtered) - self.observed
        self.regressors = tuple(self._regressors())

    def rows_of(self, joint: int) -> IntArray:
        """Those of one joint."""
        own: IntArray = self.rows[self.kinds[self.rows] == joint]
        return own

    @cached_property
    def _direction(self) -> FloatArray:
        """Signs of velocities, smooth where a velocity is lost in its noise; low-passed."""
        widths = [
            max(one.velocity_noise, FORCED_AXIS.turning_share * one.top_speed)
            for one in self.moved.wide
        ]
        return self.moved.low_passed(np.tanh(self.moved.speed / np.array(widths)))

    def _known(self) -> FloatArray:
        """What the effects of the robot file do, (n,)."""
        done = np.zeros(len(self.t_s))
        for effect in self.robot.effects:
            for key, columns in self._shapes.items():
                if (self._effect(key), self._component(key)) != (effect.effect, effect.component):
                    continue
                if key.startswith("lag "):
                    sizes = {f"{key}.dead_time": _mean(effect.parameters["dead_time"])}
                    done += self.base(frozenset({key}), sizes)
                else:
                    done += columns.values @ self._entered(key, effect.parameters)
        return done

    def _entered(self, key: str, parameters: Mapping[str, float | tuple[float, ...]]) -> FloatArray:
        """Sizes of a regressor's columns that the robot file gives."""
        values = {name: _mean(value) for name, value in parameters.items()}
        if key == LOAD:
            mass = values.get("mass", 0.0)
            at = np.array([values.get(f"centre_{axis}", 0.0) for axis in "xyz"])
            x, y, z = at
            moments = [1.0, x, y, z, x * x, y * y, z * z, x * y, x * z, y * z]
            return mass * np.array(moments)
        column, joint = self._place(key)
        value = values.get(JOINT_EFFECTS[column].parameter, JOINT_EFFECTS[column].nothing)
        if JOINT_EFFECTS[column].nothing:
            return np.array([1.0 / value - 1.0])
        return np.array([value - self._kept(column, joint)])

    # ---- what may be missing -------------------------------------------------------------------

    def _place(self, key: str) -> tuple[str, int]:
        column, _, joint = key.partition(" ")
        return column, self.joints.index(joint)

    def _effect(self, key: str) -> str:
        return LOAD if key == LOAD else JOINT_EFFECTS[key.partition(" ")[0]].name

    def _component(self, key: str) -> str:
        return self.chain.tip if key == LOAD else key.partition(" ")[2]

    def _regressors(self) -> list[Regressor]:
        found = [
            Regressor(
                f"{key} {joint}", one.name, one.log_odds, joint, alone=False,
                **self._differing(key, j),
            )
            for j, joint in enumerate(self.joints) for key, one in JOINT_EFFECTS.items()
        ]  # fmt: skip
        found = [
            replace(one, log_odds=rotor_log_odds(self.chain.armature[self._place(one.key)[1]] > 0))
            if one.key.startswith("rotor ") else one
            for one in found
        ]  # fmt: skip
        found.append(Regressor(LOAD, LOAD, load_log_odds(), self.chain.tip, alone=False))
        found += [
            Regressor(
                f"{UNKNOWN} {joint} {name}", UNKNOWN, SPLINE_TERMS.unknown_log_odds, joint,
                follows=one.follows, left_over=True,
            )
            for j, joint in enumerate(self.joints) for name, one in self._ways(j).items()
        ]  # fmt: skip
        return found

    def _differing(self, key: str, joint: int) -> dict[str, Any]:
        """How the regressor of an effect at a joint differs from others."""
        as_built, step_s = EVIDENCE.tolerated, 0.05 * self.moved.whole.period_s
        takes_over = f"{key} {self.joints[joint]}"
        if key in BRAKES:
            stated = (self.chain.friction, self.chain.damping)[BRAKES.index(key)][joint]
            as_built *= CHAIN.friction_as_stated * float(stated)
            positive = (JOINT_EFFECTS[key].parameter,)
            return {"positive": positive, "as_built": as_built}
        if key == "gain":
            return {"as_built": as_built * CHAIN.as_built, "takes_over": takes_over}
        if key != "lag":
            return {}
        spread, most = CHAIN.dead_time_s, LONE.longest_lag_s
        as_built *= self._apart_s
        lag = (Size("dead_time", "half", spread, 0.0, most, step_s),)
        return {"sizes": lag, "as_built": as_built, "takes_over": takes_over, "saturated": False}

    @cached_property
    def sizes(self) -> FloatArray:
        """How large efforts of each joint are here, (joints,), by their root mean square."""
        both = np.stack([self.layout.laid(self._filtered), self.layout.laid(self._needed)])
        rms = [np.sqrt(np.mean(both[:, self.rows_of(j)] ** 2)) for j in range(len(self.joints))]
        return np.maximum(np.array(rms), 1e-300)

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """Efforts less what they were when the motion that they make was asked for, (n,)."""
        made = np.zeros(len(self.t_s))
        for key in keys:
            if key.startswith("lag "):
                joint = self._place(key)[1]
                made += self._at(joint, self._before(joint, sizes[f"{key}.dead_time"]))
        return made

    def _before(self, joint: int, dead_s: float) -> FloatArray:
        """Effort of a joint less what it was a dead time ago, (m,).

        Noise is late, too, and as large. Behind a time constant it would be smaller, so that the
        longest would fit best.
        """
        whole, force = self.moved.whole, self._filtered[:, joint]
        began_s = whole.t_s[whole.fresh][np.cumsum(whole.fresh) - 1]
        earlier = late(force, self._changing[:, joint], whole.t_s, began_s, dead_s, 0.0)
        return np.asarray(force - earlier)

    def free(self) -> Columns:
        """No findings: efforts are held between samples and filtered before they are recorded, no
        arm is built exactly as its model, and bearings yield before they slide.
        """
        chain, joints = self.chain, range(len(self.joints))
        tables = {
            "lag": (self._changing, self._apart_s),
            "gain": (self._needed, CHAIN.as_built),
            "dry": (chain.friction * self._direction, CHAIN.friction_as_stated),
            "viscous": (chain.damping * self.moved.low_passed(self.moved.speed),
                        CHAIN.friction_as_stated),
            "yields": (self._yielding * self.sizes, CHAIN.yields_of_size),
        }  # fmt: skip
        each = [self._at(j, values[:, j]) for values, _ in tables.values() for j in joints]
        spreads = np.repeat(
            [*(spread for _, spread in tables.values()), CHAIN.as_built], len(joints)
        )
        names = [f"{name} {joint}" for name in (*tables, "link") for joint in self.joints]
        made = np.concatenate([np.stack(each, axis=1), self._links], axis=1)
        return Columns(made, spreads, tuple(names))

    @cached_property
    def _links(self) -> FloatArray:
        """Efforts (n, joints) by the weight and inertia of each joint's own links."""
        moved = self.moved
        columns = self.chain.link_columns(moved.at, moved.speed, moved.change)
        each = [moved.low_passed(columns[:, :, k]) for k in range(len(self.joints))]
        return self.layout.laid(np.stack(each, axis=-1))

    @cached_property
    def _yielding(self) -> FloatArray:
        """Friction of a bearing that yields before it slides, less that of one that does not."""
        way = CHAIN.yields_of_travel * np.ptp(self.moved.at, axis=0)
        moves = np.diff(self.moved.at, axis=0, prepend=self.moved.at[:1]) / way
        moves[self.moved.whole.fresh] = 0.0
        one = np.ones(len(moves))
        held = np.stack([clipped(move, -one, one, 0.0) for move in moves.T], axis=1)
        return self.moved.low_passed(held) - self._direction

    @property
    def _apart_s(self) -> float:
        """Usual time between effort and position, by the clocks."""
        return max(FORCED_AXIS.clocks_s, FORCED_AXIS.clocks_periods * self.moved.whole.period_s)

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Efforts (n, k) of one regressor."""
        return self._unknown[key] if key.startswith(UNKNOWN) else self._shapes[key]

    @cached_property
    def _changing(self) -> FloatArray:
        return self.moved.slope(self._filtered)

    def _at(self, joint: int, effort: FloatArray) -> FloatArray:
        """An effort of one joint (m,) among the rows of all, (n,)."""
        made = np.zeros(len(self.t_s))
        own = self.kinds == joint
        made[own] = effort[self.layout.sample[own]]
        return made

    @cached_property
    def _shapes(self) -> dict[str, Columns]:
        found, moved = {}, self.moved
        speed, change = moved.low_passed(moved.speed), moved.low_passed(moved.change)
        for j, joint in enumerate(self.joints):
            size, top = float(self.sizes[j]), moved.edge[j].top_speed
            brisk = float(np.std(change[moved.counts[:, j], j]))
            shapes = {
                "dry": (self._direction[:, j], size),
                "viscous": (speed[:, j], size / top),
                "rotor": (change[:, j], size / max(brisk, 1e-300)),
                "offset": (np.ones(len(speed)), size),
                "gain": (self._needed[:, j], FILE_SPREADS.gain_share),
            }
            for column, (shape, spread) in shapes.items():
                name = JOINT_EFFECTS[column].parameter
                own = self._at(j, shape)[:, None]
                found[f"{column} {joint}"] = Columns(own, np.array([spread]), (name,))
            found[f"lag {joint}"] = Columns(np.zeros((len(self.t_s), 0)), np.zeros(0))
        found[LOAD] = self._load
        return found

    @cached_property
    def _load(self) -> Columns:
        """All ten moments of a load: a heavy one far from the flange turns as well as weighs."""
        moved, chain = self.moved, self.chain
        columns = chain.load_columns(moved.at, moved.speed, moved.change)
        each = [moved.low_passed(columns[:, :, k]) for k in range(len(BODY))]
        mass = CHAIN.load_of_mass * chain.mass_kg
        off = CHAIN.load_off_of_reach * chain.reach_m + chain.tip_m
        spread = mass * np.array([1.0] + [off] * 3 + [off**2] * 6)
        return Columns(self.layout.laid(np.stack(each, axis=-1)), spread, BODY)

    @cached_property
    def covariates(self) -> dict[str, FloatArray]:
        """Each joint's own position and velocity, the effort that it needs, and time, (n,)."""
        stacked = {"position": self.moved.at, "velocity": self.moved.speed}
        found = {name: self.layout.laid(values) for name, values in stacked.items()}
        return found | {"time": self.moved.whole.t_s[self.layout.sample]}

    def _ways(self, joint: int) -> dict[str, _Way]:
        """How efforts of a joint may hang on what no effect of the vocabulary does: its own
        place, velocity and time, friction that grows along the way, a torque constant that changes
        in time, and its neighbours, with which it may share a motor.
        """
        own, enough = self.covariates, len(self.rows_of(joint)) // LONE.rows_a_piece
        pieces = int(np.clip(enough, LONE.fewest_pieces, SERVO_JOINTS.joint_pieces))
        found = {name: _Way((name,), values, 1.0, pieces) for name, values in own.items()}
        braked = self.layout.laid(self._direction)
        found["friction"] = _Way(("position", "direction"), own["position"], braked, CHAIN.bends)
        driven = self.layout.laid(self._needed)
        found["scale"] = _Way(("time", "effort"), own["time"], driven, CHAIN.bends)
        tables = {"effort": self._filtered, "velocity": self.moved.low_passed(self.moved.speed)}
        for other in (joint - 1, joint + 1):
            for what, values in tables.items() if 0 <= other < len(self.joints) else ():
                name = f"{what}_of_{self.joints[other]}"
                along = values[self.layout.sample, other]
                found[name] = _Way((name,), along, 1.0, 0)
        return found

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
        for j, joint in enumerate(self.joints):
            rows = self.rows_of(j)
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

    def noise_bounds(self, left: FloatArray) -> None:
        """The low-pass leaves nothing beyond its band that would show the noise in it."""

    def variant(self) -> ChainPlant:
        """The same under a narrower low-pass: what differs between the two is no knowledge."""
        return self._narrower

    @cached_property
    def _narrower(self) -> ChainPlant:
        return ChainPlant(self.robot, self._recordings, self.chain, FORCED_AXIS.narrower)

    def adopt(self, trained: ChainPlant) -> None:
        """Spreads of the recording that sizes were found on."""
        self.sizes = trained.sizes
        self.__dict__.pop("_shapes", None)

    def _kept(self, column: str, joint: int) -> float:
        """What the model has of a size already."""
        return float(self.chain.armature[joint]) if column == "rotor" else 0.0

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
        if one.nothing:
            return [Shown(name, unit, lambda v: 1.0 / (1.0 + v[name]), one.nothing)]
        return [Shown(name, unit, lambda v: kept + v[name], kept)]

    def impossible(
        self, keys: frozenset[str], sizes: Sizes, linear: Mapping[str, FloatArray]
    ) -> bool:
        """Friction that drives, a rotor or a gain below zero."""
        for key in keys:
            if key == LOAD or key.startswith(UNKNOWN):
                continue
            column, joint = self._place(key)
            if column == "lag":
                if not 0.0 < sizes[f"{key}.dead_time"] < LONE.longest_lag_s:
                    return True
                continue
            size = float(linear[key][0])
            if column in BRAKES and size <= 0.0:
                return True
            if column == "rotor" and self._kept(column, joint) + size <= 0.0:
                return True
            if column == "gain" and size <= -1.0:
                return True
        return False

    def starts(self, key: str, residual: FloatArray) -> Sequence[dict[str, float]]:
        """Of a dead time: all others are linear."""
        if not key.startswith("lag "):
            return [{}]
        return [{f"{key}.dead_time": at} for at in CHAIN.dead_times_s]


def _mean(value: float | tuple[float, ...]) -> float:
    return float(np.mean(value))


def _centre(first: str) -> Callable[[Draws], FloatArray]:
    """Distance of a load's centre, by its first moment."""

    def of(drawn: Draws) -> FloatArray:
        mass = np.asarray(drawn["mass"])
        centre: FloatArray = np.asarray(drawn[first]) / np.where(mass == 0.0, 1e-300, mass)
        return centre

    return of
