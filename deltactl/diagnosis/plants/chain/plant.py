"""A chain of joints by its efforts: what they are beyond what the model of the chain needs.

gain * effort - (inverse dynamics of the motion) = friction + rotors + load + what is missing,
linear in all sizes (Gautier 1997; Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca 2019, IEEE
Robotics and Automation Letters 4, 4147-4154). The joints are end to end in one channel, so that a
load, which all of them feel, is one regressor.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from deltactl.diagnosis.assessment.options import ASSESSMENT
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
    Sizes,
)
from deltactl.diagnosis.plants.spline_terms import KeepsBeside, spline_terms
from deltactl.models.effects.chain_joints import JOINT_EFFECTS, LOAD, load_log_odds
from deltactl.models.rigid_chain import BODY, RigidChain
from deltactl.models.robot import ChainRobot
from deltactl.recording.tables.flat import FlatRecording

UNKNOWN = "unknown"
BRAKES = ("dry", "viscous", "lag")
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
    load_of_mass: float = 0.1
    """Usual load as a share of what moves: arms carry a tenth to a third of what they weigh."""
    load_off_of_reach: float = 0.1
    """Usual distance of its centre from the flange, as a share of the reach."""


CHAIN = ChainOptions()


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
                if (self._effect(key), self._component(key)) == (effect.effect, effect.component):
                    done += columns.values @ self._entered(key, effect.parameters)
        return done

    def _entered(self, key: str, parameters: Mapping[str, float | tuple[float, ...]]) -> FloatArray:
        """Sizes of a regressor's columns that the robot file gives."""
        values = {name: float(np.mean(value)) for name, value in parameters.items()}
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
                f"{one.key} {joint}", one.name, one.log_odds, joint,
                alone=False, positive=(one.parameter,) if one.key in BRAKES else (),
            )
            for joint in self.joints for one in JOINT_EFFECTS.values()
        ]  # fmt: skip
        found.append(Regressor(LOAD, LOAD, load_log_odds(), self.chain.tip, alone=False))
        found += [
            Regressor(
                f"{UNKNOWN} {joint} {name}", UNKNOWN, SPLINE_TERMS.unknown_log_odds, joint,
                follows=(name,), left_over=True,
            )
            for joint in self.joints for name in self.covariates
        ]  # fmt: skip
        return found

    @cached_property
    def sizes(self) -> FloatArray:
        """How large efforts of each joint are here, (joints,), by their root mean square."""
        both = np.stack([self.layout.laid(self._filtered), self.layout.laid(self._needed)])
        rms = [np.sqrt(np.mean(both[:, self.rows_of(j)] ** 2)) for j in range(len(self.joints))]
        return np.maximum(np.array(rms), 1e-300)

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """Nothing is predicted of what model and robot file do not explain, (n,)."""
        return np.zeros(len(self.t_s))

    def free(self) -> Columns:
        """No findings: efforts are held between samples and filtered before they are recorded, and
        no arm is built exactly as its model.
        """
        spread = max(FORCED_AXIS.clocks_s, FORCED_AXIS.clocks_periods * self.moved.whole.period_s)
        late = [self._at(j, self._changing[:, j]) for j in range(len(self.joints))]
        built = [self._at(j, self._needed[:, j]) for j in range(len(self.joints))]
        spreads = np.repeat([spread, CHAIN.as_built], len(self.joints))
        names = [f"{name} {joint}" for name in ("late", "built") for joint in self.joints]
        return Columns(np.stack([*late, *built], axis=1), spreads, tuple(names))

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
                "lag": (self._changing[:, j], LONE.lag_spread_s),
            }
            for column, (shape, spread) in shapes.items():
                name = JOINT_EFFECTS[column].parameter
                own = self._at(j, shape)[:, None]
                found[f"{column} {joint}"] = Columns(own, np.array([spread]), (name,))
        found[LOAD] = self._load
        return found

    @cached_property
    def _load(self) -> Columns:
        """All ten moments of a load: a heavy one far from the flange turns as well as weighs."""
        moved, chain = self.moved, self.chain
        columns = chain.load_columns(moved.at, moved.speed, moved.change)
        each = [moved.low_passed(columns[:, :, k]) for k in range(len(BODY))]
        mass, off = CHAIN.load_of_mass * chain.mass_kg, CHAIN.load_off_of_reach * chain.reach_m
        spread = mass * np.array([1.0] + [off] * 3 + [off**2] * 6)
        return Columns(self.layout.laid(np.stack(each, axis=-1)), spread, BODY)

    @cached_property
    def covariates(self) -> dict[str, FloatArray]:
        """Each joint's own position and velocity, the effort that it needs, and time, (n,)."""
        stacked = {"position": self.moved.at, "velocity": self.moved.speed}
        found = {name: self.layout.laid(values) for name, values in stacked.items()}
        return found | {"time": self.moved.whole.t_s[self.layout.sample]}

    def _spanned(self, joint: int) -> FloatArray:
        """Named shapes that no spline term of a joint may take the place of, (n, j)."""
        own = {LOAD, *(f"{key} {self.joints[joint]}" for key in JOINT_EFFECTS)}
        named = [columns.values for key, columns in self._shapes.items() if key in own]
        return np.concatenate([*named, self.beside], axis=1)

    @cached_property
    def _unknown(self) -> dict[str, Columns]:
        found = {}
        for j, joint in enumerate(self.joints):
            rows, spanned = self.rows_of(j), self._spanned(j)
            usual = FORCED_AXIS.unknown_of_size * float(self.sizes[j])
            for name, covariate in self.covariates.items():
                shapes = spline_terms(covariate, SERVO_JOINTS.joint_pieces, spanned, rows)
                shapes = shapes * (self.kinds == j)[:, None]
                key = f"{UNKNOWN} {joint} {name}"
                found[key] = Columns(shapes, np.full(shapes.shape[1], usual))
        return found

    def followed(self, key: str) -> FloatArray:
        """Covariate (n,) of an unknown; NaN where it does not act."""
        joint, _, name = key.removeprefix(f"{UNKNOWN} ").rpartition(" ")
        return np.where(self.kinds == self.joints.index(joint), self.covariates[name], np.nan)

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
            size = float(linear[key][0])
            if column in BRAKES and size <= 0.0:
                return True
            if column == "rotor" and self._kept(column, joint) + size <= 0.0:
                return True
            if column == "gain" and size <= -1.0:
                return True
        return False

    def starts(self, key: str, residual: FloatArray) -> Sequence[dict[str, float]]:
        """All sizes are linear."""
        return [{}]


def _centre(first: str) -> Callable[[Draws], FloatArray]:
    """Distance of a load's centre, by its first moment."""

    def of(drawn: Draws) -> FloatArray:
        mass = np.asarray(drawn["mass"])
        centre: FloatArray = np.asarray(drawn[first]) / np.where(mass == 0.0, 1e-300, mass)
        return centre

    return of
