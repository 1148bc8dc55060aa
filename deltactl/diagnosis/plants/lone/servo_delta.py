"""A servo delta by its disturbance estimates: what the observers say beyond the robot file.

The three joints' disturbances are end to end in one channel, joint after joint, so that what
they share (a payload) is one regressor. All sizes but that of a gain are linear in the torques.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import FloatArray, IntArray, Readings
from deltactl.diagnosis.observations.servo_preprocessing import Signals
from deltactl.diagnosis.plants.left_over import UNKNOWN, LeftOver, Way
from deltactl.diagnosis.plants.lone.options import FILE_SPREADS, LONE, SERVO_JOINTS
from deltactl.diagnosis.plants.regressor import Columns, Regressor, Shown, Sizes
from deltactl.models.chain.active import Active, activate
from deltactl.models.chain.servo_delta import Course, ServoChain
from deltactl.models.effects import card_of
from deltactl.models.effects.kind import MOTORS, EffectKind
from deltactl.models.effects.servo_joints import SERVO_EFFECTS

CHANNEL = "disturbance"
INERTIA = "kg m2"
"""Unit of what the robot file states of rotor and gear."""
LEAST_EFFORT_SHARE = 0.01
"""Share of an effort that any drive gives at least."""


class ServoDelta(LeftOver):
    """Three joints with what their observers estimated."""

    unit = "N m"
    unknown_log_odds = card_of("unknown").log_odds["joint"]
    fewest = SERVO_JOINTS.joints_of_samples * OBSERVATIONS.fewest_samples
    """Stretches in clear motion, below which `admission` refuses a recording."""

    def __init__(self, chain: ServoChain, signals: Sequence[Signals]):
        """signals: of each recording."""
        self.chain = chain
        self._signals = list(signals)
        self._courses: list[Course] = [self.chain.course(s.motion) for s in self._signals]
        self.readings = self._laid_end_to_end()
        self.channel = self.readings.names[0]
        self.span_s = max(float(np.ptp(s.motion.t_s)) for s in self._signals)
        self.observed = np.nan_to_num(self.readings.values[:, 0])
        valid = np.flatnonzero(self.readings.valid[:, 0])
        self.rows: IntArray = valid[:: max(1, -(-len(valid) // SERVO_JOINTS.most_joint_rows))]
        self.kinds = (self.readings.part // len(self._signals)).astype(np.intp)
        self.nominal = self._torque(())
        self.regressors = tuple(self._regressors()) if len(valid) >= self.fewest else ()

    def _laid_end_to_end(self) -> Readings:
        times: list[FloatArray] = []
        parts: list[IntArray] = []
        values, valid, fresh, shifts = [], [], [], []
        begin = 0.0
        for joint in range(3):
            for s in self._signals:
                shift = begin - float(s.t_s[0]) if times else 0.0
                times.append(s.t_s + shift)
                shifts.append(shift)
                begin = float(times[-1][-1]) + OBSERVATIONS.between_recordings_s
                values.append(s.observed_nm[:, joint])
                valid.append(s.valid[:, joint])
                fresh.append(s.fresh)
                parts.append(np.full(len(s.t_s), len(parts)))
        return Readings(
            np.concatenate(times), np.concatenate(fresh), np.concatenate(parts), tuple(shifts),
            (CHANNEL,), (self.unit,),
            np.concatenate(values)[:, None], np.concatenate(valid)[:, None],
        )  # fmt: skip

    def _stacked(self, each: Sequence[FloatArray]) -> FloatArray:
        """(m, 3) of each recording as one column (n,), joint after joint."""
        return np.concatenate([v[:, j] for j in range(3) for v in each])

    def _torque(self, effects: Sequence[Active]) -> FloatArray:
        """What the observers would say with effects, (n,) [N m at the arm]."""
        each = []
        for s, course in zip(self._signals, self._courses, strict=True):
            torque = self.chain.disturbance_nm(course, effects)
            late = torque - self.chain.late_s * np.gradient(torque, s.motion.t_s, axis=0)
            each.append(s.means(late))
        return np.nan_to_num(self._stacked(each))

    # ---- what may be missing -------------------------------------------------------------------

    def _regressors(self) -> list[Regressor]:
        named = [
            Regressor(
                f"{kind.name} {component}", kind.name, card_of(kind.name).log_odds["joint"],
                component, alone=False, above=self._above(kind),
            )
            for kind in SERVO_EFFECTS.values()
            for component in kind.components
        ]  # fmt: skip
        return [*named, *self.unknowns()]

    def _above(self, kind: EffectKind) -> float:
        """Size that no machine is at or below."""
        if kind.nothing == 1.0:
            return LEAST_EFFORT_SHARE - 1.0
        return -self.chain.rotor_kgm2 if kind.main.unit == INERTIA else -math.inf

    @cached_property
    def size(self) -> float:
        """How large torques are here."""
        return max(float(np.std(self.observed[self.rows])), 1e-12)

    @cached_property
    def _mismatch(self) -> float:
        left = (self.observed - self.nominal)[self.rows]
        return max(float(np.sqrt(np.mean(left**2))), 1e-12)

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """What the robot file says the observers see, (n,)."""
        return self.nominal

    def free(self) -> Columns:
        """How late the estimate is: the observer's own lag, and the clock's."""
        slope = np.gradient(self.nominal, self.t_s)
        slope[self.readings.fresh] = 0.0
        return Columns.of(-slope, SERVO_JOINTS.observer_late_spread_s, "late")

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Torques (n, k) of one regressor."""
        return self.unknown(key) if key.startswith(UNKNOWN) else self._shapes[key]

    @cached_property
    def _shapes(self) -> dict[str, Columns]:
        found = {}
        for kind in SERVO_EFFECTS.values():
            for component in kind.components:
                found[f"{kind.name} {component}"] = self._shape(kind, component)
        return found

    def _shape(self, kind: EffectKind, component: str) -> Columns:
        """Torque per unit of an effect: by the chain itself, which is linear in it."""
        name = kind.main.name
        if kind.nothing == 1.0:
            halved = self._torque([activate(kind, component, {name: 0.5})])
            return Columns.of(halved - self.nominal, FILE_SPREADS.gain_share, name)
        rotates = kind.main.unit == INERTIA
        nothing = self.chain.rotor_kgm2 if rotates else 0.0
        unit = 1e-3
        moved = self._torque([activate(kind, component, {name: nothing + unit})])
        shape = (moved - self.nominal) / unit
        typical = max(float(np.std(shape[self.rows])), 1e-12)
        spread = self._mismatch / typical
        if rotates:
            rotor = max(self.chain.rotor_kgm2, 1e-12)
            widest = FILE_SPREADS.inertia_share * rotor * SERVO_JOINTS.inertia_of_rotor
            spread = min(spread, widest)
        return Columns.of(shape, spread, name)

    @cached_property
    def covariates(self) -> dict[str, FloatArray]:
        """Each joint's own angle, speed and acceleration, and time."""
        motions = [(s, s.motion) for s in self._signals]
        each = {
            "position": [s.means(m.angle_rad) for s, m in motions],
            "velocity": [s.means(m.speed_radps) for s, m in motions],
            "acceleration": [s.means(m.acceleration_radps2) for s, m in motions],
            "time": [np.repeat(s.t_s[:, None], 3, axis=1) for s, _ in motions],
        }
        return {name: self._stacked(values) for name, values in each.items()}

    def ways(self) -> dict[str, Way]:
        """Over each joint's own covariates."""
        return {
            f"{motor} {name}": Way(
                values, SERVO_JOINTS.joint_pieces, (name,), motor, acts=self.kinds == j
            )
            for j, motor in enumerate(MOTORS)
            for name, values in self.covariates.items()
        }

    def spanned(self, name: str) -> FloatArray:
        """A constant and what acts at the joint or at the platform, (n, j)."""
        places = (name.partition(" ")[0], "platform")
        own = [c.values[:, 0] for key, c in self._shapes.items() if key.endswith(places)]
        return np.stack([np.ones(len(self.t_s)), *own], axis=1)

    def spread_of(self, name: str, shapes: int) -> float:
        """Half of what is to be explained."""
        return LONE.unknown_of_mismatch * self._mismatch

    def noise_bounds(self, left: FloatArray) -> None:
        """An observer filters what it estimates: beyond its band nothing shows the noise in it."""

    def shown(self, key: str) -> Sequence[Shown]:
        """Parameters of the contract's effects."""
        if key.startswith(UNKNOWN):
            return []
        kind = SERVO_EFFECTS[key.partition(" ")[0]]
        unit, name = kind.main.unit, kind.main.name
        if kind.nothing == 1.0:
            return [Shown(name, unit, lambda v: 1.0 / (1.0 + v[name]), nothing=1.0)]
        if unit == INERTIA:
            rotor = self.chain.rotor_kgm2
            return [Shown(name, unit, lambda v: rotor + v[name], nothing=rotor)]
        return [Shown(name, unit, lambda v: v[name])]
