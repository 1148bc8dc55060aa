"""The motion of a plan, made while it runs: a few hundred targets at a time.

Each target in space is mapped again, one by one, as Zhao 2023 asks its network "at each time
step", and must give the counts it gave when the whole path was checked. The steps of late drives
are moved ahead; all else waits as long as they need. Where the platform rings, what is made is
another motion, worked out before that.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from deltactl.drivers.steps.contract import NO_TICKS, Counts, Int64Array, Ticks
from deltactl.firmware_py.compensation.lead import (
    Lead,
    ahead_s,
    fastest_hz,
    lags_s,
    merged_s,
    smoothed_s,
)
from deltactl.firmware_py.compensation.ringing import Along, Ringing, knot_s, rings
from deltactl.firmware_py.paths.path import BoolArray, Space
from deltactl.firmware_py.planner.motion import NOTHING_REACHED, Chunk, Reached, Schedule, StepGate
from deltactl.firmware_py.planner.plan import Plan, TimedLap
from deltactl.firmware_py.planner.targets import Lap, in_repeat
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S, ns
from deltactl.foundation.errors import MotionError
from deltactl.models.inverse_kinematics import TargetMapper

BETWEEN_COUNTS_S = 0.004
"""What is smooth already is smoothed by so little more."""
Made = tuple[Int64Array, Int64Array, int]
"""Times of steps of one motor, their directions, and up to when that is all."""


class LeadStream:
    """Turns the chunks of a motion into chunks `after_ns` later, late drives less so."""

    def __init__(
        self,
        robot: RobotFile,
        jump_hz: float = 0.0,
        ringing: Ringing | None = None,
        as_given: bool = False,
    ):
        """jump_hz: by so much the step rates of the motion may change at once.

        ringing: makes a smooth motion of it, which does not ring. as_given: nothing is changed.
        """
        dead_s, lag_s = lags_s(robot)
        pairs = list(zip(dead_s.tolist(), lag_s.tolist(), strict=True))
        late = any(dead + lag > 0.0 for dead, lag in pairs)
        self.active = (late or ringing is not None) and not as_given
        step_s, window_s = 1.0 / robot.limits.step_rate_hz, merged_s(robot)
        fastest = fastest_hz(robot)
        acceleration = robot.limits.joint_acceleration_radps2 / robot.drive.rad_per_step
        self._ringing, least_s, reach_s = ringing, 0.0, 0.0
        if ringing is not None:
            jump_hz, least_s, reach_s = 0.0, BETWEEN_COUNTS_S, ringing.reach_s
        smoothed = [max(smoothed_s(lag, acceleration, jump_hz), least_s) for _, lag in pairs]
        ahead = [ahead_s(dead, over_s) for (dead, _), over_s in zip(pairs, smoothed, strict=True)]
        self.after_ns = ns(max(ahead) + reach_s) if self.active else 0
        self._leads = [
            Lead(dead, lag, self.after_ns, fastest, acceleration, jump_hz, least_s)
            for dead, lag in pairs
        ]
        self._gate = StepGate()
        self._gate.rules(ns(window_s), ns(step_s))

    def chunks(self, planned: Iterator[Chunk]) -> Iterator[Chunk]:
        """The same motion, nothing of it lost."""
        waiting: list[Reached] = []
        until_ns = 0
        for chunk in planned:
            until_ns = max(until_ns, chunk.until_ns)
            yield from self._moved(chunk, waiting)
        # The plan ends here: the arms rest, and nothing more need be known.
        rest = Chunk(NO_TICKS, NOTHING_REACHED, until_ns + 3 * self.after_ns)
        yield from self._moved(rest, waiting)

    def _moved(self, chunk: Chunk, waiting: list[Reached]) -> Iterator[Chunk]:
        made = self._shaped(chunk) if self._ringing is not None else self._led(chunk)
        until_ns = min(known for _, _, known in made)
        ticks = self._gate.ticks([due for due, _, _ in made], [way for _, way, _ in made], until_ns)
        if len(chunk.reached):
            waiting.append(chunk.reached)
        settled = min(until_ns, self._gate.settled_ns)
        yield Chunk(ticks, self._reached(waiting, settled), settled)

    def _led(self, chunk: Chunk) -> list[Made]:
        made = []
        for motor, lead in enumerate(self._leads):
            mine = np.flatnonzero(chunk.ticks.steps[:, motor])
            signs = chunk.ticks.steps[mine, motor].astype(np.int64)
            made.append(lead.steps(chunk.ticks.due_ns[mine], signs, chunk.until_ns))
        return made

    def _shaped(self, chunk: Chunk) -> list[Made]:
        assert self._ringing is not None
        counts = self._ringing.counts(chunk.ticks, chunk.until_ns)
        return [lead.along(counts[:, motor]) for motor, lead in enumerate(self._leads)]

    def _reached(self, waiting: list[Reached], until_ns: int) -> Reached:
        """Targets that are due by then, moved as the whole motion is."""
        if not waiting:
            return NOTHING_REACHED
        first = Reached.joined(waiting)
        t_ns = first.t_ns + self.after_ns
        count = int(np.searchsorted(t_ns, until_ns, side="right"))
        waiting[:] = [first.part(slice(count, None))] if count < len(first) else []
        return replace(first.part(slice(None, count)), t_ns=t_ns[:count])


BLOCK = 256
"""Targets mapped ahead: some milliseconds of work, a second or two of motion."""


class MotionStream:
    """Chunks of a motion from where the arms are to the end of the job.

    Iterating raises MotionError when a target no longer maps to the counts of the check.
    """

    def __init__(self, plan: Plan, from_counts: Counts):
        """Find the way to the path's start. Raises UnreachablePoint."""
        self.plan = plan
        way_in = plan.way_in(from_counts)
        self.approach, self.otherwise = way_in.schedule, way_in.says
        """The way to the path, and what of it is otherwise than was asked for."""
        as_given = plan.first.lap.space is Space.JOINT
        begins_ns = self.approach.duration_ns + ns(plan.first_dwell_s)
        ringing = None if as_given else _ringing(plan, from_counts, begins_ns)
        self._lead = LeadStream(plan.robot, plan.jump_hz, ringing, as_given)
        self.path_start_ns = self.approach.duration_ns + self._lead.after_ns
        """When the first target is reached; before that comes the approach."""
        self.end_ns = _end_ns(plan, self.approach.duration_ns) + 4 * self._lead.after_ns
        robot = plan.robot
        self._mapper = TargetMapper(plan.kinematics, robot.drive, robot.limits.arm_deg)
        self._gate = StepGate()

    def __iter__(self) -> Iterator[Chunk]:
        return self._lead.chunks(self._planned()) if self._lead.active else self._planned()

    def _planned(self) -> Iterator[Chunk]:
        yield from self._approach()
        lap_ns = self.approach.duration_ns + ns(self.plan.first_dwell_s)
        index = 1
        for repeat, timed in self.plan.laps():
            self._gate.rules(*timed.schedule.gate_ns)
            for first in range(0, len(timed.lap) - 1, BLOCK):
                last = min(first + BLOCK, len(timed.lap) - 1)
                self._map_again(timed.lap, first + 1, last, repeat)
                reached = _reached(timed, first, last, repeat, lap_ns, index)
                yield from _chunks(timed.schedule, first, last, lap_ns, self._gate, reached)
                index += last - first
            lap_ns += timed.schedule.duration_ns
            yield Chunk(NO_TICKS, NOTHING_REACHED, lap_ns)

    def _approach(self) -> Iterator[Chunk]:
        first = self.plan.first
        self._map_again(first.lap, 0, 0, 1)
        self._gate.rules(*self.approach.gate_ns)
        row = np.zeros(1, dtype=np.int64)
        there = _rows(first.lap, row, row + self.approach.duration_ns, 1, row, row > 0)
        moves = len(self.approach.reached_ns) - 1
        yield from _chunks(self.approach, 0, moves, 0, self._gate, there)
        if self.plan.first_dwell_s > 0.0:
            until_ns = self.approach.duration_ns + ns(self.plan.first_dwell_s)
            yield Chunk(NO_TICKS, NOTHING_REACHED, until_ns)

    def _map_again(self, lap: Lap, first: int, last: int, repeat: int) -> None:
        if lap.space is Space.JOINT:
            return
        counts_of = self._mapper.counts
        checked = lap.mapped_counts[first : last + 1].tolist()
        for row, (x_m, y_m, z_m) in enumerate(lap.targets[first : last + 1].tolist()):
            counts = counts_of(x_m, y_m, z_m)
            if list(counts) != checked[row]:
                point = lap.says(first + row) + in_repeat(repeat, self.plan.job.repeats)
                raise MotionError(
                    f"{self.plan.job.name}: {point} maps to"
                    f" counts {counts} now and to {tuple(checked[row])} when it was checked;"
                    " the inverse kinematics has changed, check the job again"
                )


def _chunks(
    schedule: Schedule, first: int, last: int, start_ns: int, gate: StepGate, reached: Reached
) -> Iterator[Chunk]:
    """Ticks from one target to another with what is reached on the way."""
    end_ns = start_ns + int(schedule.reached_ns[last])
    waiting: Ticks | None = None
    for ticks in schedule.play(first, last, start_ns, gate):
        if not len(ticks):
            continue
        if waiting is not None:
            here, reached = _until(waiting, reached, int(waiting.due_ns[-1]))
            yield here
        waiting = ticks
    ticks = waiting or NO_TICKS
    # A motor that turned round may have been held back for a moment.
    last_ns = max(end_ns, int(ticks.due_ns[-1])) if len(ticks) else end_ns
    if len(reached):
        reached.t_ns[-1] = last_ns
    yield Chunk(ticks, reached, min(last_ns, gate.settled_ns))


def _until(ticks: Ticks, reached: Reached, until_ns: int) -> tuple[Chunk, Reached]:
    count = int(np.searchsorted(reached.t_ns, until_ns, side="right"))
    # The last target is kept back: its time is known only after the last tick.
    count = min(count, max(0, len(reached) - 1))
    chunk = Chunk(ticks, reached.part(slice(None, count)), until_ns)
    return chunk, reached.part(slice(count, None))


def _reached(
    timed: TimedLap, first: int, last: int, repeat: int, lap_ns: int, index: int
) -> Reached:
    """What comes after target `first` is reached, up to target `last`; index: of the next one."""
    rests = first + np.flatnonzero(timed.lap.rest[first:last])
    if timed.lap.space is Space.JOINT:  # targets in joint space are compared by their counts
        rests = rests[:0]
    arrives = np.arange(first + 1, last + 1)
    left_ns = timed.schedule.left_ns[rests]
    rows = np.concatenate([rests, arrives])
    t_ns = lap_ns + np.concatenate([left_ns, timed.schedule.reached_ns[arrives]])
    # Left before the next is reached; a stable sort keeps the order of equal times.
    order = np.lexsort((np.concatenate([2 * rests + 1, 2 * arrives]), t_ns))
    rows, left = rows[order], order < len(rests)
    return _rows(timed.lap, rows, t_ns[order], repeat, index + rows - first - 1, left)


def _rows(
    lap: Lap, rows: Int64Array, t_ns: Int64Array, repeat: int, index: Int64Array, left: BoolArray
) -> Reached:
    return Reached(
        index=index,
        number=lap.number[rows],
        repeat=np.full(len(rows), repeat),
        t_ns=t_ns,
        position_m=lap.position_m[rows],
        angles_rad=lap.angles_rad[rows],
        counts=lap.counts[rows],
        left=left,
    )


def _ringing(plan: Plan, from_counts: Counts, begins_ns: int) -> Ringing | None:
    """What keeps the platform from ringing, where it would and the drives can follow."""
    if not rings(plan.robot):
        return None
    begins_s, times_s, rows = 0.0, [], []
    for timed in plan.timed:
        arrives_s, lap = begins_s + timed.schedule.reached_ns / NS_PER_S, timed.lap
        times_s.append(np.stack([arrives_s, arrives_s + lap.dwell_s], axis=1).ravel())
        mapped_rad = lap.mapped_counts * plan.robot.drive.rad_per_step
        row = np.hstack([lap.angles_rad, lap.position_m, mapped_rad])
        rows.append(np.repeat(row, 2, axis=0))
        begins_s += timed.schedule.duration_ns / NS_PER_S
    angle_rad, place_m, mapped_rad = np.hsplit(np.vstack(rows), 3)
    lap_s = plan.timed[-1].schedule.duration_ns / NS_PER_S
    t_s = np.concatenate(times_s)
    along = Along(t_s, angle_rad, place_m, mapped_rad, begins_ns / NS_PER_S, lap_s)
    knot = knot_s(plan.robot, *along[:3])
    return Ringing(plan.robot, knot, from_counts, along) if knot > 0.0 else None


def _end_ns(plan: Plan, approach_ns: int) -> int:
    end_ns = approach_ns + ns(plan.first_dwell_s) + plan.first.schedule.duration_ns
    if plan.again is not None:
        end_ns += (plan.job.repeats - 1) * plan.again.schedule.duration_ns
    return end_ns
