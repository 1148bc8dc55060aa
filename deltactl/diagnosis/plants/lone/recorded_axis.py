"""A recording of an axis that follows commands: its readings, its commands, and its load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.ndimage import median_filter

from deltactl.diagnosis.observations.inverse_dynamics import white_noise
from deltactl.diagnosis.observations.log_errors import sampling_times, unrounded
from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.outliers import begun_in_motion, without_gross
from deltactl.diagnosis.observations.readings import (
    BoolArray,
    FloatArray,
    IntArray,
    Readings,
    bridged,
    gather,
    known_loads,
)
from deltactl.diagnosis.plants.lone.known_effects import Foretold, begun, foretold_by, may_leave
from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS, LONE
from deltactl.diagnosis.plants.lone.travel import (
    arrivals,
    direction_of,
    ends_earlier_move,
    rests_under_loads,
    turns,
)
from deltactl.diagnosis.plants.lone.waves import resolved_waves
from deltactl.models.chain.axis import AxisChain, entries_of, gravity_pull
from deltactl.models.chain.commands import Commands
from deltactl.models.effects.speed_limit import rate_limited
from deltactl.models.robot import ServoAxis, StepperAxis
from deltactl.models.signals import lagged
from deltactl.recording.column_measures import first_of, step_of
from deltactl.recording.tables.excerpt import excerpt
from deltactl.recording.tables.flat import FlatRecording

OBSERVED = ("theta_1", "position")
COMMANDED = ("command_1", "command")
OFTEN = 0.99
"""Quantile of speeds that is no single reading."""
NOISE_OF_TWO = 3.0 * float(np.sqrt(2.0))
"""Standard deviations of one reading by which two differ in 3 of 1000 pairs."""
SETTLED_S = COMMANDED_AXIS.settling_lags * LONE.lag_spread_s
"""After a move, until a drive has arrived."""


class RecordedAxis:
    """Readings (n,) of an axis, its command, its nominal prediction, and which rows count."""

    done_by_known: FloatArray | None = None

    def __init__(self, robot: StepperAxis | ServoAxis, recordings: Sequence[FlatRecording]):
        self.robot = robot
        self.unit = unit_of(robot)
        self._motor = robot.drive if isinstance(robot, StepperAxis) else None
        self.rad_per_step = self._motor.rad_per_step if self._motor else 0.0
        self._chain = self._bare_chain()
        self.recordings = recordings = prepared(recordings)
        order = observed_in(robot)
        self.name = first_of(recordings[0], order) or order[0]
        self.readings: Readings = gather(recordings, [self.name], {self.name: self.unit})
        self.observed = np.nan_to_num(self.readings.values[:, 0])
        self.commanded = np.concatenate([commanded(robot, one) for one in recordings])
        self.t_s = sampling_times(self.readings.t_s, self.readings.fresh, self.commanded)
        self.readings = replace(self.readings, t_s=self.t_s)
        self.resolution = step_of(self.readings.values[:, 0])
        """Smallest step of the reading: no play below it can be distinguished from rounding."""
        self.rounding = self.resolution / float(np.sqrt(12.0))
        self._restore_commands()
        self._commands = [
            Commands.of_angles(self.t_s[p], self.commanded[p, None], self.readings.fresh[p])
            for p in self.parts
        ]
        self.pull = self._pull(recordings)
        self._foretell()
        self.rows = self._rows()
        self.kinds = self._moving()

    def _restore_commands(self) -> None:
        """Less the rounding of a log; a motor's steps are what it does, and a command of coarser
        steps than the reading is as it was given.
        """
        step = 0.0 if self._motor else step_of(self.commanded)
        if not 0.0 < step <= 1.001 * self.resolution:
            return
        self.asked_rounding = step / float(np.sqrt(12.0))
        self.asked = np.unique(np.rint(self.commanded / step), return_inverse=True)[1]
        groups = np.cumsum(self.readings.fresh).astype(np.intp)
        self.commanded = unrounded(self.commanded, step, groups)

    def _foretell(self) -> None:
        """By the robot file (n,), and what its effects may leave; each recording for itself."""
        constant = self.robot.zero != "absolute"
        nominal, left, bare = [], [], []
        for commands, part in zip(self._commands, self.parts, strict=True):
            foretold = self._by_effects(commands, self.pull[part, None])
            stretches = np.cumsum(self.readings.fresh[part]).astype(np.intp) - 1
            read = self.readings.values[part, 0]
            known = begun(self.robot.effects, foretold, read, stretches, constant)
            nominal.append(foretold_by(known, foretold, stretches))
            left.append(may_leave(known, nominal[-1], foretold, stretches, constant))
            unfound = [[one for one in effects if one.found is None] for effects in known]
            bare.append(foretold_by(unfound, foretold, stretches))
        self.nominal = np.concatenate(nominal)
        self.left_by_known: Sequence[tuple[float, FloatArray]] = [
            (parts[0][0], np.concatenate([alone for _, alone in parts]))
            for parts in zip(*left, strict=True)
        ]
        if self.left_by_known:
            self.done_by_known = self.nominal - np.concatenate(bare)

    def _by_effects(self, commands: Commands, pull: FloatArray) -> Foretold:
        chain = self._chain
        return lambda known: chain.simulate(commands, entries_of(known, chain.kinds), pull)

    def _bare_chain(self) -> AxisChain:
        """Without the effects of the robot file, which begin elsewhere in each recording."""
        robot = self.robot
        if isinstance(robot, StepperAxis):
            return AxisChain("rotary", None, None, self.rad_per_step)
        return AxisChain(robot.motion, robot.gravity, robot.drive_stiffness)

    @cached_property
    def parts(self) -> list[FloatArray]:
        """Which rows belong to each recording, (n,) of booleans."""
        part = self.readings.part
        return [part == n for n in range(int(part[-1]) + 1)]

    def _pull(self, recordings: Sequence[FlatRecording]) -> FloatArray:
        """Known load on the axis (n,): gravity where the axis is, and what a column gives."""
        at = np.where(self.readings.valid[:, 0], self.observed, self.commanded)
        gravity = self.robot.gravity if isinstance(self.robot, ServoAxis) else None
        return known_loads(recordings) + gravity_pull(gravity, at)

    def _rows(self) -> IntArray:
        hair = max(self.resolution, COMMANDED_AXIS.least_move_share * float(np.ptp(self.commanded)))
        came = ends_earlier_move(
            self.t_s, self.commanded, self.readings.values[:, 0], self.readings.fresh, hair
        )
        came |= begun_in_motion(self.t_s, self.commanded[:, None], self.readings.fresh)
        valid = np.flatnonzero(self.readings.valid[:, 0] & ~came)
        most = COMMANDED_AXIS.most_followed_rows
        if len(valid) <= most:
            return valid
        return valid[np.linspace(0, len(valid) - 1, most).round().astype(np.intp)]

    def _moving(self) -> IntArray:
        """1 while the command moves or has just moved: there a drive does what no model follows.

        Where a row is read long after each move, none is in motion.
        """
        if self.readings.period_s > SETTLED_S:
            return np.zeros(len(self.t_s), dtype=np.intp)
        moving = self._under_way.astype(np.intp)
        least, most = COMMANDED_AXIS.of_each_kind
        share = float(moving[self.rows].mean())
        return moving if least < share < most else np.zeros_like(moving)

    @cached_property
    def noises(self) -> IntArray:
        """By `kinds`, where there are rests enough to show a noise of their own; else one."""
        rests = rests_under_loads(self.stays[self.rows], self.pull[self.rows])
        return self.kinds if rests >= COMMANDED_AXIS.fewest_rests else np.zeros_like(self.kinds)

    @cached_property
    def _under_way(self) -> BoolArray:
        """Rows (n,) in which the command moves, or has within the time that a drive settles in."""
        step_s = np.maximum(np.diff(self.t_s, prepend=self.t_s[0] - 1.0), 1e-9)
        speed = np.abs(np.diff(self.commanded, prepend=self.commanded[0])) / step_s
        # How a stretch began nobody knows: what the axis was doing counts as motion.
        speed[self.readings.fresh] = float(np.max(speed[~self.readings.fresh], initial=0.0))
        late = lagged(speed[:, None], np.where(self.readings.fresh, 0.0, step_s), SETTLED_S, {})
        top = np.quantile(late, OBSERVATIONS.top_speed_quantile)
        moving: BoolArray = late[:, 0] > OBSERVATIONS.moving_share * top
        return moving

    @cached_property
    def stays(self) -> IntArray:
        """Number of the rest (n,) that a row lies in; -1 in motion, and just after it."""
        begins = np.diff(self._under_way, prepend=True) | self.readings.fresh
        return np.where(self._under_way, -1, np.cumsum(begins)).astype(np.intp)

    @cached_property
    def steady(self) -> bool:
        """Whether the command is a straight line: position and time tell the same."""
        chosen = self.commanded[self.rows], self.t_s[self.rows]
        return abs(float(np.corrcoef(*chosen)[0, 1])) > COMMANDED_AXIS.steady_correlation

    @cached_property
    def direction(self) -> FloatArray:
        """Way of the last move of the command (n,): 1 up, -1 down, 0 where it is not known."""
        hair = max(self.resolution, COMMANDED_AXIS.least_move_share * self.span)
        way = direction_of(self.commanded, self.readings.fresh, hair)
        return arrivals(self.commanded, way, hair) if self.arrived else way

    @cached_property
    def turns_back(self) -> bool:
        """Whether the command turns back within a stretch."""
        return turns(self.direction, self.readings.fresh)

    @property
    def arrived(self) -> bool:
        """Whether rows are so far apart that every move is over before the next is read."""
        return self.readings.period_s > LONE.longest_lag_s

    @cached_property
    def resolved_waves(self) -> float:
        """Most waves over the travel that the readings can follow."""
        return resolved_waves(self.commanded[self.rows], self.span, self.resolution)

    @cached_property
    def span(self) -> float:
        """Travel of the command."""
        return float(np.ptp(self.commanded[self.rows]))

    @cached_property
    def mismatch(self) -> float:
        """How far reading and nominal prediction are apart: the spread of shapes of any size."""
        left = (self.observed - self.nominal)[self.rows]
        left = left - np.median(left) if self.robot.zero == "arbitrary" else left
        return max(float(np.sqrt(np.mean(left**2))), 1e-12 * max(self.span, 1e-12))

    @cached_property
    def speeds(self) -> tuple[float, float]:
        """Mean and highest speed of the command: an axis below the mean would not arrive.

        The first is that which the readings keep up for some samples, where it is higher.
        """
        moved, step_s = np.abs(np.diff(self.nominal)), self.readings.step_s[1:]
        within = step_s > 0.0
        highest = float(np.max(moved[within] / step_s[within], initial=1e-300))
        mean = float(moved[within].sum() / max(step_s.sum(), 1e-300))
        return max(mean, self._reached), highest

    @property
    def _reached(self) -> float:
        """Speed that the readings surely have in a hundredth of the time, over any span of it."""
        read, groups = self.readings.valid[:, 0], np.cumsum(self.readings.fresh)[self.rows]
        # Without single readings off their neighbours, which are no motion.
        at, t_s = median_filter(self.observed[self.rows], 3), self.t_s[self.rows]
        off = NOISE_OF_TWO * max(white_noise(self.observed[read]), self.resolution)
        found = 0.0
        for apart in 2 ** np.arange(int(np.log2(max(len(at) // 2, 1)))):
            together = groups[apart:] == groups[:-apart]
            moved = np.abs(at[apart:] - at[:-apart])[together] - off
            took_s = (t_s[apart:] - t_s[:-apart])[together]
            if len(moved):
                found = max(found, float(np.quantile(moved / took_s, OFTEN)))
        return found

    def behind_a_limit(self, limit: float) -> float:
        """How far an axis with a limit of its speed falls behind, but for a rounded command."""
        held = rate_limited(self.nominal, self.readings.step_s, limit, float(self.nominal[0]))
        return float(np.max(np.abs(self.nominal - held))) - self._command_step

    @cached_property
    def _command_step(self) -> float:
        return step_of(self.commanded)

    @cached_property
    def usual_speed(self) -> float:
        """Speed of the command, root mean square over the rows that count."""
        speed = np.gradient(self.commanded, self.t_s)[self.rows]
        return float(np.sqrt(np.mean(speed**2)))

    @property
    def full_step(self) -> float:
        """Least that a motor loses at the axis [rad]: one of its 200 full steps a turn."""
        if self._motor is None:
            return 0.0
        return (
            self.rad_per_step * self._motor.microsteps_per_rev / COMMANDED_AXIS.full_steps_per_turn
        )


def unit_of(robot: StepperAxis | ServoAxis) -> str:
    """Unit of its motion."""
    return "m" if isinstance(robot, ServoAxis) and robot.motion == "linear" else "rad"


def observed_in(robot: StepperAxis | ServoAxis) -> tuple[str, ...]:
    """Columns that may hold its motion, the first that does counts."""
    return OBSERVED[::-1] if isinstance(robot, ServoAxis) else OBSERVED


def commanded_in(robot: StepperAxis | ServoAxis) -> tuple[str, ...]:
    """Columns that may hold its command as a motion, the first that does counts."""
    return COMMANDED[::-1] if isinstance(robot, ServoAxis) else COMMANDED


def commanded(robot: StepperAxis | ServoAxis, recording: FlatRecording) -> FloatArray:
    """The command as a motion (n,); `admission` sees that there is one."""
    name = first_of(recording, commanded_in(robot))
    if name is None and isinstance(robot, StepperAxis) and robot.drive:
        return bridged(recording, "steps_1") * robot.drive.rad_per_step
    return bridged(recording, name or commanded_in(robot)[0])


def prepared(recordings: Sequence[FlatRecording]) -> list[FlatRecording]:
    """Without single readings that are none, and with no more rows than are worked on."""
    return [_thinned(without_gross(one, OBSERVED)) for one in recordings]


def _thinned(recording: FlatRecording) -> FlatRecording:
    """Leave rows out while the others show how late a drive is, then use whole stretches.

    Rows that are too far apart for that from the start are left out evenly.
    """
    most = COMMANDED_AXIS.most_followed_samples
    every = max(-(-len(recording) // most), 1)
    near = int(LONE.lag_spread_s / (COMMANDED_AXIS.rows_a_lag * recording.period_s()))
    return excerpt(recording, most, min(every, near) if near else every, OBSERVED)
