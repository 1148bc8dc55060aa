"""A delta and its recordings, as the engine sees them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.outliers import begun_in_motion
from deltactl.diagnosis.observations.readings import FloatArray, bridged, gather
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.candidates import (
    candidates_of,
    contact,
    late_readings,
    runout,
    tolerances,
)
from deltactl.diagnosis.plants.delta.measured_before import beside, changes, joined, measured_before
from deltactl.diagnosis.plants.delta.safe_poses import fragile
from deltactl.diagnosis.plants.nuisance import Nuisance
from deltactl.diagnosis.plants.shared_parameters import groups_of
from deltactl.models.chain import Chain, Commands
from deltactl.models.chain.delta import Course, standing
from deltactl.models.effects import VOCABULARY, Port, Trait, has
from deltactl.models.effects.card import Coordinate
from deltactl.models.linkage import forward, jacobian
from deltactl.models.robot import AXES, DeltaRobot
from deltactl.recording.column_measures import first_of
from deltactl.recording.tables.flat import FlatRecording

RANGES = tuple(f"range_{axis}" for axis in AXES)
POSITIONS = tuple(f"pos_{axis}" for axis in AXES)
MOTORS = (1, 2, 3)
ANGLES = tuple(f"theta_{motor}" for motor in MOTORS)
UNITS = {**dict.fromkeys((*RANGES, *POSITIONS), "m"), **dict.fromkeys(ANGLES, "rad")}
STATUS = {name: name.replace("range_", "status_") for name in RANGES}


class OwnTimes:
    """When each range of one recording was measured, from the time of its row.

    Sensors are read one after another, which would look like latencies of some milliseconds.
    """

    def __init__(self, recording: FlatRecording):
        self._t_s = recording.t_s
        self._late_s: dict[str, FloatArray] = {}
        for axis in AXES:
            own = recording.extra.get(f"t_{axis}")
            if own is None or own.dtype.kind not in "fiu":
                continue
            late_s = np.nan_to_num(own.astype(np.float64) - self._t_s)
            if np.any(late_s) and np.abs(late_s).max() < OBSERVATIONS.furthest_own_s:
                self._late_s[f"range_{axis}"] = late_s

    def shift(self, names: Sequence[str], predicted: FloatArray) -> FloatArray:
        """Predictions (n, channels) for the times of the rows, carried to each range's own time."""
        for column, name in enumerate(names):
            if name in self._late_s:
                own_s = self._t_s + self._late_s[name]
                predicted[:, column] = np.interp(own_s, self._t_s, predicted[:, column])
        return predicted


class DeltaModel:
    """Predictions of the chain for every observation channel of one or several recordings."""

    def __init__(self, robot: DeltaRobot, recordings: Sequence[FlatRecording]):
        self.robot = robot
        seen = self.channels(robot, recordings)
        self.readings = gather(recordings, seen, UNITS, status=STATUS)
        self.commanded_rad = np.concatenate([self._commands(r) for r in recordings])
        if any(name in ANGLES for name in seen):  # drives may be behind at the beginning
            begun = begun_in_motion(self.readings.t_s, self.commanded_rad, self.readings.fresh)
            self.readings.valid[begun] = False
        self._own_times = [OwnTimes(recording) for recording in recordings]
        stays, self._measured = measured_before(robot, self._travel(), self.readings.span_s)
        self.chain = Chain.delta(stays)
        self._courses = self._split()
        self.position_m = forward(self.chain.linkage, self.commanded_rad).position_m
        lost = ~np.isfinite(self.position_m[:, 0])
        self.unassembled = float(lost.mean())
        """Share of the samples in which the commanded angles cannot be assembled."""
        self.readings.valid[lost | fragile(self.chain.linkage, self.commanded_rad)] = False
        self._jacobian = jacobian(self.chain.linkage, self.commanded_rad, self.position_m)
        self._late = late_readings()
        half = 0.5 * self.readings.period_s
        read_late = replace(
            self._late, coordinates=(Coordinate("time", step=2e-3, low=0.0, high=2.0 * half),)
        )
        # Somewhere within a sample, between the middle of the exposure and its end; never later
        # than the next sample.
        late = Nuisance(Term(read_late, np.array([0.5 * half])), (0.5 * half,))
        self.nuisances = [late, *self._measured] if self._timed else self._measured
        single = changes(self._candidates(), self._measured)
        self.candidates = [*single, *groups_of(single)]
        self.tolerances = tolerances(single)
        if robot.drive is not None and robot.drive.gear_ratio > 1.0:
            self.tolerances += runout(robot.drive.gear_ratio)
        known = [entry.found for entry in robot.effects if entry.found is not None]
        self.loosely_built = any(found.loosely_built for found in known)
        if self.loosely_built:
            self.nuisances = [*self.nuisances, *beside(self._measured, self.tolerances)]

    @staticmethod
    def channels(robot: DeltaRobot, recordings: Sequence[FlatRecording]) -> list[str]:
        """What looks at the machine in these recordings."""
        channels = (*RANGES, *POSITIONS, *ANGLES)
        seen = [name for name in channels if any(first_of(one, [name]) for one in recordings)]
        return seen if robot.sensors else [name for name in seen if name not in RANGES]

    @staticmethod
    def commands_in(recording: FlatRecording) -> str | None:
        """Stem of the columns in which all three motors are commanded."""
        stems = ("command_", "steps_")
        return next((one for one in stems if recording.has(*(f"{one}{m}" for m in MOTORS))), None)

    @property
    def _timed(self) -> bool:
        return any(name in RANGES for name in self.readings.names)

    def _commands(self, recording: FlatRecording) -> FloatArray:
        stem = self.commands_in(recording)
        given = np.stack([bridged(recording, f"{stem}{motor}") for motor in MOTORS], axis=1)
        drive = self.robot.drive
        return given * drive.rad_per_step if stem == "steps_" and drive else given

    def _split(self) -> list[Course]:
        readings, courses = self.readings, []
        for number in range(int(readings.part[-1]) + 1):
            rows = readings.part == number
            commands = Commands.of_angles(
                readings.t_s[rows], self.commanded_rad[rows], readings.fresh[rows]
            )
            courses.append(self.chain.course(commands))
        return courses

    def predict(self, terms: Sequence[Term]) -> FloatArray:
        """Channels (n, channels) with the terms at work."""
        parts, actives = [], [term.active for term in joined(terms, self._measured)]
        for course, own_times in zip(self._courses, self._own_times, strict=True):
            try:
                out = self.chain.simulate(course, actives)
            except ValueError:  # an arm of no length: as far off as can be, so no fit goes there
                parts.append(np.zeros((len(course.commands.t_s), len(self.readings.names))))
                continue
            block = {RANGES[i]: out.ranges[:, i] for i in range(3)}
            block |= {POSITIONS[i]: out.position[:, i] for i in range(3)}
            block |= {ANGLES[i]: out.measured[:, i] for i in range(3)}
            # A fit that comes where nothing can be assembled must find its way back; from a robot
            # at nowhere it would not.
            rows = standing(np.stack([block[name] for name in self.readings.names], axis=1))
            parts.append(own_times.shift(self.readings.names, rows))
        return np.nan_to_num(np.concatenate(parts))

    def _candidates(self) -> list[Candidate]:
        measured = any(name in ANGLES for name in self.readings.names)
        found: list[Candidate] = []
        for name in VOCABULARY:
            if has(name, Trait.READING) and not self._timed:
                continue
            if VOCABULARY[name].port is Port.ENCODER and not measured:
                continue
            found += candidates_of(name, self._travel(), self.readings.span_s)
        if self._timed:
            found.append(self._late)
        heights = self.position_m[:, 2]
        found.append(contact(float(np.nanmin(heights)), float(np.nanmax(heights))))
        return found

    def _travel(self) -> float:
        """Largest angle that a joint moved through [rad]."""
        return float(np.ptp(self.commanded_rad, axis=0).max())

    def covariates(self) -> dict[str, FloatArray]:
        """Angles, position, speed and time, by the names the contract gives them."""
        t_s, rad = self.readings.t_s, self.commanded_rad
        covariates = {f"theta_{j + 1}": rad[:, j] for j in range(3)}
        covariates |= {f"range_{a}": self.position_m[:, i] for i, a in enumerate(AXES)}
        speed = np.gradient(rad, t_s, axis=0)
        covariates |= {f"speed_{j + 1}": speed[:, j] for j in range(3)}
        moving = np.gradient(np.nan_to_num(self.position_m), t_s, axis=0)
        covariates |= {f"speed_range_{a}": moving[:, i] for i, a in enumerate(AXES)}
        covariates["range_x, range_y"] = np.hypot(self.position_m[:, 0], self.position_m[:, 1])
        load = np.concatenate([course.load().torque_nm for course in self._courses])
        if load.any():
            covariates |= {f"torque_{j + 1}": load[:, j] for j in range(3)}
        covariates["time"] = t_s
        return {name: np.nan_to_num(values) for name, values in covariates.items()}

    def inputs(self) -> dict[str, FloatArray]:
        """Joints through the linkage, forces on the platform through joints that yield alike, and
        each sensor by itself.
        """
        names = self.readings.names
        inputs: dict[str, FloatArray] = {}
        axes = self.robot.sensors.axes if self.robot.sensors else np.eye(3)
        seen = np.einsum("ij,njk->nik", axes, self._jacobian)
        for joint in range(3):
            block = np.zeros((len(self.readings.t_s), len(names)))
            for column, name in enumerate(names):
                if name in RANGES:
                    block[:, column] = seen[:, RANGES.index(name), joint]
                elif name in POSITIONS:
                    block[:, column] = self._jacobian[:, POSITIONS.index(name), joint]
                elif name == f"theta_{joint + 1}":
                    block[:, column] = 1.0
            inputs[f"motor{joint + 1}"] = np.nan_to_num(block)
        joints = np.stack([inputs[name] for name in inputs], axis=2)
        pulled = np.nan_to_num(self._jacobian)
        for axis, letter in enumerate(AXES):
            usual = np.sqrt(np.mean(np.sum(pulled[:, axis] ** 2, axis=1) ** 2))
            inputs[f"{PLATFORM}{letter}"] = np.einsum("ncj,nj->nc", joints, pulled[:, axis]) / usual
        for column, name in enumerate(names):
            if name in RANGES:
                block = np.zeros((len(self.readings.t_s), len(names)))
                block[:, column] = 1.0
                inputs[name] = block
        return inputs


MOTOR, PLATFORM, SENSOR = "motor", "platform_", "range_"


def sensible(location: str, covariate: str) -> bool:
    """Whether a model error at an input location may follow a covariate: at a joint the angles and
    its own motion, at a sensor the distances and its own speed.
    """
    elsewhere = covariate[-1] != location[-1]
    if location.startswith(MOTOR):
        if covariate.startswith("speed_range") or "," in covariate:
            return False
        return covariate.startswith("theta") or not (covariate[-1] in "123" and elsewhere)
    if location.startswith(SENSOR):
        if covariate.startswith("speed_range"):
            return not elsewhere
        return not covariate.startswith(("speed", "torque"))
    return True


def unit_at(location: str) -> str:
    """Unit of what enters at an input location."""
    return "rad" if location.startswith(MOTOR) else "m"


def own_place(location: str) -> str:
    """Covariate of the place of what enters at an input location."""
    return location.replace(MOTOR, "theta_")


def on_platform(varying: Iterable[str]) -> list[list[tuple[str, str]]]:
    """Pairs of input location and covariate of what may pull at the platform: by its place or its
    speed.
    """
    pulls = [(f"{PLATFORM}{axis}", axis) for axis in AXES]
    by_place = [(at, name) for at, _ in pulls for name in RANGES]
    by_speed = [(at, f"speed_range_{axis}") for at, axis in pulls]
    known = set(varying)
    each = [[pair for pair in one if pair[1] in known] for one in (by_place, by_speed)]
    return [one for one in each if one]


def component_at(location: str) -> str:
    """Component of an input location."""
    return PLATFORM[:-1] if location.startswith(PLATFORM) else location
