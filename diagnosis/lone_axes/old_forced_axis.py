"""An axis that is driven by effort and its recordings, as the engine sees them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from diagnosis.observations.needed_columns import filled, first_of, needed, refuse_still
from diagnosis.observations.readings import BoolArray, FloatArray, Readings, gather
from diagnosis.observations.sign_check import refuse_wrong_sign
from diagnosis.plants import axis_candidates as moves
from diagnosis.plants.candidate import Candidate, Coordinate, Shape, Term
from diagnosis.plants.nuisance import Nuisance
from foundation.errors import RecordingError
from models.chain.axis import gravity_pull
from models.chain.effort_axis import Driven, EffortChain
from models.effects.lone_axis import COMPONENT
from models.robot import ServoAxis
from recording.flat import FlatRecording

TAU_S = 0.15
GAIN_SPREAD = 5e-4
BLURRED = 1.6
FEWEST_PER_TAU = 12.0
SMOOTHING_S = 0.06
"""Longest polynomial by which positions are turned into velocities."""
STEADY_VELOCITY = 0.004
"""Noise of the velocity, as a share of the highest one, that calls for no longer polynomial."""
AT_REST = 4.0
"""Standard deviations of the velocity below which the axis stands."""
SPEEDS = (0.01, 0.03, 0.1, 0.3)
"""Stribeck speeds to start from, as shares of the highest speed."""


class EffortAxisModel:
    """Predictions of the position from effort over a short horizon."""

    def __init__(self, robot: ServoAxis, recordings: Sequence[FlatRecording], blurred: float = 1.0):
        """blurred: the polynomial that gives velocities is so many times as long as it need be."""
        self._recordings, self._blurred = tuple(recordings), blurred
        if robot.inertia is None:
            raise RecordingError(
                f"{recordings[0].source}: effort in needs `inertia` in the robot file"
            )
        self.robot = robot
        self.unit = "m" if robot.motion == "linear" else "rad"
        name = needed(recordings[0], ("position", "theta_1"), "position")
        self.readings: Readings = gather(recordings, [name], {name: self.unit})
        refuse_still(self.readings.values[:, 0], name, recordings[0].source)
        tau_s = max(TAU_S, FEWEST_PER_TAU * self.readings.period_s)
        self.chain = EffortChain(
            robot.inertia, tau_s, robot.motion, robot.effort_gain, robot.gravity, robot.effects
        )
        self._driven = [self._of(n, recording) for n, recording in enumerate(recordings)]
        efforts = np.concatenate([d.effort[:, 0] for d in self._driven])
        refuse_still(efforts, "effort", recordings[0].source)
        self._force = robot.effort_gain * efforts
        self._velocity = np.concatenate([d.velocity[:, 0] for d in self._driven])
        self._refuse_wrong_sign(recordings[0].source)
        settled = np.concatenate([self.chain.settled(d) for d in self._driven])
        self.readings.valid[~settled] = False
        self._refuse_other_units(recordings[0].source)
        self.nuisances = [self._timing(), self._holding(), self._calibrated()]
        self.tolerances: list[Nuisance] = []
        self.candidates = self._candidates()
        self.groups: list[Candidate] = []

    def _of(self, number: int, recording: FlatRecording) -> Driven:
        rows = self.readings.part == number
        t_s, fresh = self.readings.t_s[rows], self.readings.fresh[rows]
        name = needed(recording, ("position", "theta_1"), "position")
        position = filled(recording, name)
        effort = filled(recording, needed(recording, ("effort",), "effort"))
        velocity, noise = _velocity(t_s, position, fresh, self._blurred)
        slow = np.abs(velocity) < AT_REST * noise + 1e-4 * np.abs(velocity).max()
        load = np.zeros(len(t_s))
        if first_of(recording, ["load"]):
            load = filled(recording, "load")
        return Driven(
            t_s, fresh, effort[:, None], position[:, None], velocity[:, None], slow[:, None],
            load[:, None],
        )  # fmt: skip

    def _refuse_wrong_sign(self, source: str) -> None:
        assert self.robot.inertia is not None
        loads = np.concatenate([driven.load[:, 0] for driven in self._driven])
        places = np.concatenate([driven.position[:, 0] for driven in self._driven])
        refuse_wrong_sign(
            self.readings.t_s, self.readings.fresh, self._velocity,
            self._force + loads + gravity_pull(self.robot.gravity, places),
            self.robot.inertia, source,
        )  # fmt: skip

    def _refuse_other_units(self, source: str) -> None:
        """Force and the acceleration it should make must be of one order of magnitude."""
        assert self.robot.inertia is not None
        pushed = self.predict([])[:, 0] - self.readings.values[:, 0]
        span = float(np.nanmax(self.readings.values) - np.nanmin(self.readings.values))
        off = float(np.nanquantile(np.abs(pushed[self.readings.valid[:, 0]]), 0.9))
        if off > 30.0 * span:
            raise RecordingError(
                f"{source}: with this inertia and effort_gain the effort would move the axis "
                f"{off / span:.0f} times as far as it went; are the units or the robot file wrong?"
            )

    def _timing(self) -> Nuisance:
        """Effort is held between samples: it acts half a period late, give or take."""
        half = 0.5 * self.readings.period_s
        kind = self.chain.kinds["following_lag"]
        late = Coordinate("dead_time", step=0.2 * half, low=-4 * half, high=4 * half)
        candidate = Candidate(kind, COMPONENT, (late,), (Shape((half,)),), {"time": 0.0})
        return Nuisance(Term(candidate, np.array([half])), (0.5 * half,))

    def _holding(self) -> Nuisance:
        """Held between samples or smooth."""
        candidate = Candidate(
            self.chain.kinds["effort_hold"], COMPONENT,
            (Coordinate("share", step=0.1, low=-3.0, high=5.0),), (Shape((1.0,)),), {},
        )  # fmt: skip
        return Nuisance(Term(candidate, np.array([1.0])), (0.5,))

    def _calibrated(self) -> Nuisance:
        """No robot file gives the effort more exactly than to 0.05 %."""
        candidate = moves.simple(self.chain.kinds["effort_gain"], 1e-3)
        return Nuisance(Term(candidate, np.array([1.0])), (GAIN_SPREAD,))

    def _candidates(self) -> list[Candidate]:
        kinds, robot = self.chain.kinds, self.robot
        assert robot.inertia is not None
        force = max(float(np.std(self._force)), 1e-12)
        speed = max(float(np.quantile(np.abs(self._velocity), 0.98)), 1e-12)
        mass = moves.simple(kinds["inertia"], 1e-3 * robot.inertia)
        mass = Candidate(
            mass.kind, COMPONENT, mass.coordinates,
            (Shape((robot.inertia,), (0,), 1e-3 * robot.inertia),), {},
        )  # fmt: skip
        return [
            moves.lag(kinds["following_lag"], self.readings.period_s),
            moves.simple(kinds["effort_gain"], 1e-3),
            moves.simple(kinds["effort_offset"], 1e-3 * force),
            moves.simple(kinds["joint_friction"], 1e-3 * force),
            moves.simple(kinds["viscous_friction"], 1e-3 * force / speed),
            moves.falling(kinds["stribeck_friction"], 1e-3 * force, [s * speed for s in SPEEDS]),
            mass,
        ]

    def predict(self, terms: Sequence[Term]) -> FloatArray:
        """The position over a short horizon, (n, 1)."""
        active = [term.active for term in terms]
        return np.concatenate([self.chain.simulate(d, active) for d in self._driven])[:, None]

    def blurrier(self) -> EffortAxisModel:
        """The same with velocities from a longer polynomial: what differs is no knowledge."""
        return EffortAxisModel(self.robot, self._recordings, BLURRED)

    def drivers(self) -> dict[str, FloatArray]:
        """Position, velocity, force and time."""
        position = np.concatenate([d.position[:, 0] for d in self._driven])
        return {
            "position": position,
            "velocity": self._velocity,
            "effort": self._force,
            "time": self.readings.t_s,
        }

    def ports(self) -> dict[str, FloatArray]:
        """A force that enters at the axis, as it shows in the position."""
        return {COMPONENT: np.ones((len(self.readings.t_s), 1))}


def _velocity(
    t_s: FloatArray, position: FloatArray, fresh: BoolArray, blurred: float
) -> tuple[FloatArray, float]:
    """Smoothed derivative stretch by stretch, (n,), and the standard deviation of its noise."""
    from scipy.signal import savgol_filter  # takes 0.3 s to import; most runs need none

    step_s = float(np.median(np.diff(t_s)))
    third = np.diff(position, 3)
    noise = 1.4826 * float(np.median(np.abs(third))) / np.sqrt(20.0)
    top = float(np.quantile(np.abs(np.gradient(position, t_s)), 0.98))
    half = 2
    while _spread(half, step_s, noise) > STEADY_VELOCITY * top and half * step_s < SMOOTHING_S / 2:
        half += 1
    half = int(np.ceil(half * blurred))
    size = 2 * half + 1
    velocity = np.zeros_like(position)
    starts = [*np.flatnonzero(fresh).tolist(), len(position)]
    for first, last in pairwise(starts):
        part = position[first:last]
        if len(part) > size:
            velocity[first:last] = savgol_filter(part, size, 2, deriv=1, delta=step_s)
        elif len(part) > 1:
            velocity[first:last] = np.gradient(part, t_s[first:last])
    return velocity, _spread(half, step_s, noise)


def _spread(half: int, step_s: float, noise: float) -> float:
    """Standard deviation of the slope of a polynomial over 2 half + 1 noisy samples."""
    return noise * float(np.sqrt(3.0 / (half * (half + 1) * (2 * half + 1)))) / step_s
