"""An axis that follows commands (stepper or servo) and its recordings, as the engine sees them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.observations.needed_columns import (
    filled,
    first_of,
    needed,
    refuse_other_units,
    refuse_still,
)
from diagnosis.observations.readings import FloatArray, Readings, gather
from diagnosis.plants import axis_candidates as moves
from diagnosis.plants.candidate import Candidate, Coordinate, Shape, Term
from diagnosis.plants.nuisance import Nuisance
from models.chain.axis import AxisChain
from models.chain.commands import Commands
from models.effects.lone_axis import COMPONENT, Motion
from models.robot import ServoAxis, StepperAxis
from recording.flat import FlatRecording

OBSERVED = ("theta_1", "position")
COMMANDED = ("command_1", "command")
FREE = 1e3
"""Spread of a constant that is free: nothing is held near zero by this."""
WIDTHS = (0.15, 0.4, 1.0)
"""Widths of play to start from, as shares of how far reading and command are apart."""


class AxisModel:
    """Predictions of the chain for the position of an axis."""

    def __init__(self, robot: StepperAxis | ServoAxis, recordings: Sequence[FlatRecording]):
        self.robot = robot
        self.motion: Motion = robot.motion if isinstance(robot, ServoAxis) else "rotary"
        self.unit = "m" if self.motion == "linear" else "rad"
        self.rad_per_step = robot.drive.rad_per_step if isinstance(robot, StepperAxis) else 0.0
        self.chain = self._chain()
        servo = isinstance(robot, ServoAxis)
        order = OBSERVED[::-1] if servo else OBSERVED
        name = needed(recordings[0], order, "position" if servo else "theta_1")
        self.readings: Readings = gather(recordings, [name], {name: self.unit})
        commanded = [self._commanded(r) for r in recordings]
        self.commanded = np.concatenate(commanded)
        refuse_still(self.commanded, "the command", recordings[0].source)
        refuse_still(self.readings.values[:, 0], name, recordings[0].source)
        refuse_other_units(
            self.commanded, self.readings.values[:, 0], f"{name} and the command",
            recordings[0].source,
        )  # fmt: skip
        self._commands = self._split()
        loads = [self._load(r) for r in recordings]
        self._pulls = [
            self.chain.pull(c, load) for c, load in zip(self._commands, loads, strict=True)
        ]
        self.nuisances = [self._zero()] if robot.zero == "arbitrary" else []
        self.tolerances: list[Nuisance] = []
        self.candidates = self._candidates()
        self.groups: list[Candidate] = []

    def _chain(self) -> AxisChain:
        robot = self.robot
        if isinstance(robot, StepperAxis):
            return AxisChain("rotary", None, None, robot.drive.rad_per_step, robot.effects)
        return AxisChain(robot.motion, robot.gravity, robot.drive_stiffness, 0.0, robot.effects)

    def _commanded(self, recording: FlatRecording) -> FloatArray:
        servo = isinstance(self.robot, ServoAxis)
        name = first_of(recording, COMMANDED[::-1] if servo else COMMANDED)
        if name is not None:
            return filled(recording, name)
        if isinstance(self.robot, StepperAxis) and first_of(recording, ["steps_1"]):
            return filled(recording, "steps_1") * self.rad_per_step
        needed(recording, (), "command" if servo else "command_1")
        raise AssertionError("needed() raises")

    def _load(self, recording: FlatRecording) -> FloatArray | None:
        return filled(recording, "load") if first_of(recording, ["load"]) else None

    def _split(self) -> list[Commands]:
        readings = self.readings
        return [
            Commands.of_angles(readings.t_s[rows], self.commanded[rows, None], readings.fresh[rows])
            for rows in (readings.part == n for n in range(int(readings.part[-1]) + 1))
        ]

    def _zero(self) -> Nuisance:
        kind = self.chain.kinds["home_offset"]
        candidate = Candidate(
            kind, COMPONENT, (Coordinate("angle", step=self._small),), (Shape((0.0,)),), {}
        )
        difference = np.nanmedian(self.readings.values[:, 0] - self.commanded)
        return Nuisance(Term(candidate, np.array([float(difference)])), (FREE,))

    @property
    def _small(self) -> float:
        """A step far below what can be seen, for derivatives."""
        return 1e-4 * float(np.ptp(self.commanded))

    @property
    def apart(self) -> float:
        """How far reading and command are apart, from low to high."""
        error = self.readings.values[:, 0] - self.commanded
        return float(np.nanquantile(error, 0.98) - np.nanquantile(error, 0.02))

    def _candidates(self) -> list[Candidate]:
        kinds, period_s = self.chain.kinds, self.readings.period_s
        widths = [share * max(self.apart, 10.0 * self._small) for share in WIDTHS]
        found = [
            moves.lag(kinds["following_lag"], period_s),
            moves.latency(kinds["sensor_latency"], period_s),
            moves.simple(kinds["gear_ratio"], 1e-4),
            moves.play(kinds["gear_backlash"], widths),
            moves.play(kinds["joint_friction"], widths),
            moves.periodic(kinds["transmission_error"], self.commanded, self._small),
            moves.periodic(kinds["encoder_error"], self.commanded, self._small),
            moves.ringing(kinds["resonance"], period_s),
        ]
        if self.robot.zero == "absolute":
            found.append(moves.simple(kinds["home_offset"], self._small))
        found += self._under_load()
        return found

    def _under_load(self) -> list[Candidate]:
        kinds, found = self.chain.kinds, []
        most = max(float(np.abs(pull).max()) for pull in self._pulls)
        if most > 0.0:
            found.append(moves.compliance(kinds["joint_compliance"], self._small / most))
        stiffness = self.chain.drive_stiffness
        if stiffness is not None:
            reach = 0.01 * self.readings.period_s * stiffness
            found.append(moves.simple(kinds["viscous_friction"], reach, {"stiffness": stiffness}))
        return found

    def predict(self, terms: Sequence[Term]) -> FloatArray:
        """The reading without noise, (n, 1)."""
        parts = [
            self.chain.simulate(commands, [term.active for term in terms], pull)
            for commands, pull in zip(self._commands, self._pulls, strict=True)
        ]
        return np.concatenate(parts)[:, None]

    def drivers(self) -> dict[str, FloatArray]:
        """Position, velocity, time and load."""
        t_s = self.readings.t_s
        drivers = {
            "position": self.commanded,
            "velocity": np.nan_to_num(np.gradient(self.commanded, t_s)),
            "time": t_s,
        }
        pull = np.concatenate(self._pulls)[:, 0]
        if pull.any():
            drivers["load"] = pull
        return drivers

    def ports(self) -> dict[str, FloatArray]:
        """The axis itself: whatever enters shows in its reading."""
        return {COMPONENT: np.ones((len(self.readings.t_s), 1))}
