"""A servo delta and its disturbances, as the engine sees them.

The three joints' disturbances stand end to end in one channel: joint 2 begins where joint 1 ends,
as if it were a later recording. So the engine of lone axes, made for channels in which every model
leaves something, works on all joints at once, and what they share (a payload) is one effect.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.observations.readings import FEWEST_SAMPLES, FloatArray, IntArray, Readings
from diagnosis.observations.servo_preprocessing import signals_of
from diagnosis.plants.candidate import Candidate, Coordinate, Shape, Term
from diagnosis.plants.nuisance import Nuisance
from foundation.errors import RecordingError
from models.chain.servo_delta import Course, ServoChain
from models.effects.kind import MOTORS, EffectKind
from models.effects.lone_axis import command_effects
from models.effects.servo_joints import SERVO_EFFECTS
from models.robot import DeltaRobot
from recording.flat import FlatRecording

CHANNEL = "disturbance"
UNIT = "N m"
APART_S = 60.0
SMALL = 1e-3
"""Steps of the fit, as a share of what the torques scatter by."""
LATE_SPREAD_S = 0.001


class ServoModel:
    """Predictions of what the disturbance observers say, from the measured motion."""

    def __init__(self, robot: DeltaRobot, recordings: Sequence[FlatRecording]):
        self.chain = ServoChain(robot)
        self.unit = UNIT
        self._signals = [signals_of(recording, self.chain) for recording in recordings]
        self._courses: list[Course] = [self.chain.course(s.motion) for s in self._signals]
        self.readings = self._laid_end_to_end()
        self.span_s = max(float(np.ptp(s.motion.t_s)) for s in self._signals)
        if self.readings.valid.sum() < 3 * FEWEST_SAMPLES:
            raise RecordingError(
                f"{recordings[0].source}: {int(self.readings.valid.sum())} stretches of 10 ms in "
                "clear motion; that is too little to tell anything"
            )
        self._late = _late(self.readings.period_s)
        self.nuisances = [
            Nuisance(Term(self._late, np.array([self.chain.late_s])), (LATE_SPREAD_S,))
        ]
        self.tolerances: list[Nuisance] = []
        self.groups: list[Candidate] = []
        self.candidates = self._candidates()

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
                begin = float(times[-1][-1]) + APART_S
                values.append(s.observed_nm[:, joint])
                valid.append(s.valid[:, joint])
                fresh.append(s.fresh)
                parts.append(np.full(len(s.t_s), len(parts)))
        return Readings(
            np.concatenate(times), np.concatenate(fresh), np.concatenate(parts), tuple(shifts),
            (CHANNEL,), (UNIT,),
            np.concatenate(values)[:, None], np.concatenate(valid)[:, None],
        )  # fmt: skip

    def _stacked(self, each: Sequence[FloatArray]) -> FloatArray:
        """(m, 3) of each recording as one column (3 m in all, 1), joint after joint."""
        parts = [values[:, joint] for joint in range(3) for values in each]
        column: FloatArray = np.concatenate(parts)[:, None]
        return column

    def predict(self, terms: Sequence[Term]) -> FloatArray:
        """What the observers would say, times the torque constant; (n, 1) [N m at the arm]."""
        late_s = sum(float(t.at[0]) for t in terms if t.candidate is self._late)
        active = [term.active for term in terms if term.candidate is not self._late]
        each = []
        for s, course in zip(self._signals, self._courses, strict=True):
            torque = self.chain.disturbance_nm(course, active)
            torque = torque - late_s * np.gradient(torque, s.motion.t_s, axis=0)
            each.append(s.means(torque))
        return np.nan_to_num(self._stacked(each))

    def _candidates(self) -> list[Candidate]:
        torque = float(np.std(self.readings.values[self.readings.valid]))
        step = SMALL * max(torque, 1e-9)
        return [
            self._candidate(kind, component, step)
            for kind in SERVO_EFFECTS.values()
            for component in kind.components
        ]

    def _candidate(self, kind: EffectKind, component: str, step: float) -> Candidate:
        main, origin = kind.main, kind.nothing
        joint = MOTORS.index(component) if component in MOTORS else None
        motions = [s.motion for s in self._signals]
        if kind.name == "inertia":
            origin = self.chain.rotor_kgm2
        size = {
            "viscous_friction": _typical([m.speed_radps for m in motions], joint),
            "inertia": _typical([m.acceleration_radps2 for m in motions], joint),
            "payload": _typical([c.per_kg_nm for c in self._courses], joint),
        }.get(kind.name, 1.0)
        reach = SMALL if kind.name == "effort_gain" else step / size
        coordinate = Coordinate(main.name, step=reach, low=main.low, high=main.high)
        shape = Shape((origin,), (0,), reach)
        return Candidate(kind, component, (coordinate,), (shape,), {})

    def drivers(self) -> dict[str, FloatArray]:
        """Each joint's own angle, speed and expected torque, and time."""
        motions = [(s, s.motion) for s in self._signals]
        each = {
            "position": [s.means(m.angle_rad) for s, m in motions],
            "velocity": [s.means(m.speed_radps) for s, m in motions],
            "acceleration": [s.means(m.acceleration_radps2) for s, m in motions],
            "time": [np.repeat(s.t_s[:, None], 3, axis=1) for s, _ in motions],
        }
        return {name: self._stacked(values)[:, 0] for name, values in each.items()}

    def ports(self) -> dict[str, FloatArray]:
        """A torque that enters at one of the joints."""
        number = self.readings.part // len(self._signals)
        return {name: (number == joint)[:, None] * 1.0 for joint, name in enumerate(MOTORS)}


def _typical(each: Sequence[FloatArray], joint: int | None) -> float:
    values = np.concatenate(each)
    chosen = values if joint is None else values[:, joint]
    return max(float(np.sqrt(np.nanmean(np.square(chosen)))), 1e-12)


def _late(period_s: float) -> Candidate:
    """How late the estimate is: the observer's own lag, and the clock's."""
    kind = command_effects("rotary")["following_lag"]
    coordinate = Coordinate("dead_time", step=0.02 * period_s, low=-0.02, high=0.02)
    return Candidate(kind, "axis", (coordinate,), (Shape((0.0,), (0,), 1e-3),), {"time": 0.0})
