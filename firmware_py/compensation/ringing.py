"""What to command so that a platform that rings goes where it is meant to.

It answers the motion x that the arms make with y'' + 2 d w y' + w^2 y = 2 d w x' + w^2 x. The
motion is known before it is made, so this is turned round: x = y + e, where T e' + e = y'' / w^2
with T = 2 d / w. At a corner y'' has no end, so the motion meant is smoothed by a cubic B-spline,
whose knots are as near to each other as the drives can follow. What that takes off a corner is
smoothed too and put back (Tukey's twicing): no more is asked of the drives, and half is left of it.

A motor takes up play before its arm moves, and the arm before the platform rings. So the motion is
made without what motors take up of play, and they take it up in what is made.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from deltactl.drivers.steps.contract import MOTORS, NO_TICKS, Counts, Int64Array, Ticks
from deltactl.firmware_py.compensation.hanging import Hanging, Pace
from deltactl.firmware_py.compensation.lead import GRID_S, can_lead, lags_s
from deltactl.firmware_py.compensation.remembering import STILL_STEPS
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.chain import Chain, Commands
from deltactl.models.chain.active import Active, at, of_entries
from deltactl.models.effects import Compensated, compensated
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.joint_friction import without_swing
from deltactl.models.effects.kind import Port, scalar
from deltactl.models.robot import FloatArray
from deltactl.models.signals import clipped, lagged

BOXES = 4
"""A cubic B-spline is a box four times over."""
KNOTS_S = np.arange(0.012, 0.25, 0.002)
LOOKED_S = 0.004
SPARE = 0.9
"""Share of the drives' acceleration for the motion as it is looked at beforehand."""
GENTLY = 0.4
"""And for gears that cross play: an arm that is let go and caught makes the platform ring."""
MOST_AWAY_M = 0.03
"""The arms leave the path by no more."""
GRID_NS = round(GRID_S * NS_PER_S)


def rings(robot: RobotFile) -> bool:
    """Whether it is known to, and can be kept from it."""
    shaped = compensated(Compensated.SHAPED)
    return can_lead(robot) and any(entry.effect in shaped for entry in robot.effects)


class Along(NamedTuple):
    """A path as it is planned, first lap and a later one: rows (n, 3) at times (n,) [s]."""

    t_s: FloatArray
    angle_rad: FloatArray
    place_m: FloatArray
    mapped_rad: FloatArray
    """Where arms are meant, without what motors take up."""
    begins_s: float
    """From the start of the motion."""
    lap_s: float
    """How long the last lap takes, which is repeated."""


class Plays:
    """Where gears are in the play in which arms hang: as planned, and as the smooth motion asks."""

    def __init__(self, robot: RobotFile, knot: float, along: Along):
        self._along, taken_rad = along, along.angle_rad - along.mapped_rad
        turns, self._grid_s = _aimed_turns(robot, knot, along)
        chain, limits = Chain(robot.model_copy(update={"effects": ()})), robot.limits
        torque_nm = chain.course(Commands.of_angles(self._grid_s, turns)).load().torque_nm
        gently = GENTLY * limits.joint_acceleration_radps2
        pace = Pace(self._grid_s, limits.joint_speed_radps, gently)
        self._hang = np.zeros(MOTORS, dtype=np.bool_)
        """Whose arms hang."""
        self._planned, self._made = np.zeros_like(taken_rad), np.zeros_like(turns)
        for hanging in (Hanging(one) for one in _at_joints(robot) if Hanging.is_one(one)):
            m, half_rad = hanging.motor, 0.5 * hanging.width_rad
            self._hang[m] = True
            self._planned[:, m] = np.clip(taken_rad[:, m], -half_rad, half_rad)
            across = hanging.across(pace, turns[:, m], torque_nm[:, m])
            self._made[:, m] = half_rad * across

    def planned_rad(self, t_s: FloatArray, way_in_rad: FloatArray) -> FloatArray:
        """How far gears are ahead of their arms at times (n,) of the motion, (n, 3).

        way_in_rad: (n, 3), what counts on the way to the path.
        """
        return self._after(
            t_s, way_in_rad, _at_times(self._path_s(t_s), self._along.t_s, self._planned)
        )

    def made_rad(self, t_s: FloatArray, way_in_rad: FloatArray) -> FloatArray:
        """The same in the smooth motion."""
        return self._after(t_s, way_in_rad, _at_times(self._path_s(t_s), self._grid_s, self._made))

    def _after(self, t_s: FloatArray, way_in_rad: FloatArray, path_rad: FloatArray) -> FloatArray:
        chosen = np.where((t_s < self._along.begins_s)[:, None], way_in_rad, path_rad)
        return np.where(self._hang, chosen, 0.0)

    def _path_s(self, t_s: FloatArray) -> FloatArray:
        """Since the path began; laps beyond those that are known are as the last one is."""
        path_s, known_s = t_s - self._along.begins_s, float(self._along.t_s[-1])
        laps = np.ceil(np.maximum(path_s - known_s, 0.0) / self._along.lap_s)
        moved: FloatArray = path_s - laps * self._along.lap_s
        return moved


def _at_times(t_s: FloatArray, knots_s: FloatArray, rows: FloatArray) -> FloatArray:
    return np.stack([np.interp(t_s, knots_s, column) for column in rows.T], axis=1)


def _aimed_turns(robot: RobotFile, knot: float, along: Along) -> tuple[FloatArray, FloatArray]:
    """About where arms are to be so that the platform does not ring, (n, 3), and when [s]."""
    rest_s, boxes = 2 * BOXES * knot, round(knot / LOOKED_S)
    grid_s = np.arange(along.t_s[0] - rest_s, along.t_s[-1] + rest_s, LOOKED_S)
    turns = _smooth(_at_times(grid_s, along.t_s, along.mapped_rad), boxes)
    away = np.diff(turns, 2, axis=0) / LOOKED_S**2 / _omega(_mode(robot)) ** 2
    cut = (len(grid_s) - len(away)) // 2
    return turns[1:-1] + away, grid_s[cut : cut + len(away)]


def knot_s(robot: RobotFile, t_s: FloatArray, angle_rad: FloatArray, place_m: FloatArray) -> float:
    """How near the knots may be, in a motion that is at (n, 3) at times (n,); 0: none would do."""
    stiffness, (_, late_s) = _omega(_mode(robot)) ** 2, lags_s(robot)
    rest_s = 2 * BOXES * KNOTS_S[-1]
    grid_s = np.arange(t_s[0] - rest_s, t_s[-1] + rest_s, LOOKED_S)
    angles, places = (
        np.stack([np.interp(grid_s, t_s, column) for column in of.T], axis=1)
        for of in (angle_rad, place_m)
    )
    knots: list[float] = KNOTS_S.tolist()
    for knot in knots:
        boxes = round(knot / LOOKED_S)
        turns, moves = _smooth(angles, boxes), _smooth(places, boxes)
        told = turns[1:-1] + np.diff(turns, 2, axis=0) / LOOKED_S**2 / stiffness
        away_m = np.linalg.norm(np.diff(moves, 2, axis=0), axis=1) / LOOKED_S**2 / stiffness
        # Commands to drives that follow late contain more than positions.
        told = told[1:] + late_s * np.diff(told, axis=0) / LOOKED_S
        speed = np.abs(np.diff(told, axis=0)).max(initial=0.0) / LOOKED_S
        change = np.abs(np.diff(told, 2, axis=0)).max(initial=0.0) / LOOKED_S**2
        if (
            away_m.max(initial=0.0) <= MOST_AWAY_M
            and speed <= robot.limits.joint_speed_radps
            and change <= SPARE * robot.limits.joint_acceleration_radps2
        ):
            return knot
    return 0.0


class Ringing:
    """The motion of one robot: steps go in, counts to follow come out, `reach_s` behind."""

    def __init__(self, robot: RobotFile, knot: float, start: Counts, along: Along | None = None):
        """knot: as `knot_s` says, above 0 [s]. start: counts before the first step.

        along: needed where arms hang in play.
        """
        mode = _mode(robot)
        self._stiffness = _omega(mode) ** 2
        self._late_s = 2.0 * scalar(mode.values, "damping") / _omega(mode)
        self._kernel = _kernel(max(1, round(knot / GRID_S)))
        self._margin = len(self._kernel) // 2 + 1
        self.reach_s = self._margin * GRID_S
        """So much of the motion has to be known ahead."""
        self._static = CalibratedInverse(robot)
        self._chain = Chain(robot.model_copy(update={"effects": ()}))
        self._joints = _at_joints(robot)
        hang = along is not None and any(map(Hanging.is_one, self._joints))
        self._plays = Plays(robot, knot, along) if along is not None and hang else None
        self._half, self._offset = np.zeros(MOTORS), np.zeros(MOTORS)
        """Half of the play in which arms stick, and its middle, in counts."""
        self._moved: FloatArray | None = None
        self._step_rad = robot.drive.rad_per_step
        for active in filter(_sticks, self._joints):
            motor, half = active.kind.index(active.component), 0.5 * scalar(active.values, "width")
            self._half[motor] += half / self._step_rad
            self._offset[motor] += half / self._step_rad * active.values.get("asymmetry", 0.0)
        self._limits = np.radians(robot.limits.arm_deg) / self._step_rad
        self._start = self._count = np.array(start, dtype=np.int64)
        self._waiting = NO_TICKS
        self._known = self._done = 0
        self._rows = np.empty((0, 3 * MOTORS))
        """Places, counts without play and counts of the grid points that are still needed."""
        self._memory: dict[str, FloatArray] = {}

    def counts(self, ticks: Ticks, until_ns: int) -> FloatArray:
        """Counts since the start at the next grid points, (n, 3); all ticks to `until_ns` known."""
        planned = self._planned(ticks, until_ns)
        if not len(planned):
            return np.empty((0, MOTORS))
        place_m, taken = self._places_m(planned * self._step_rad)
        rows = np.hstack([place_m, planned - taken, planned])
        if not len(self._rows):
            rows = np.vstack([np.repeat(rows[:1], self._margin, axis=0), rows])
        self._rows = np.vstack([self._rows, rows])
        if len(self._rows) <= 2 * self._margin:
            return np.empty((0, MOTORS))
        smooth = _convolved(self._rows[:, : 2 * MOTORS], self._kernel)
        given = self._rows[:, 2 * MOTORS :]
        taken = (given - self._rows[:, MOTORS : 2 * MOTORS])[self._margin : -self._margin]
        moves = np.append(0, np.cumsum(np.diff(given, axis=0).any(axis=1)))
        rests = moves[2 * self._margin :] == moves[: -2 * self._margin]
        self._rows = self._rows[-2 * self._margin :]
        meant_m = smooth[:, :MOTORS]
        pushed = np.diff(meant_m, 2, axis=0) / GRID_S**2 / self._stiffness
        away_m = lagged(pushed, np.full(len(pushed), GRID_S), self._late_s, self._memory)
        counts = smooth[1:-1, MOTORS:] + self._more(meant_m[1:-1], away_m)
        made_s = (self._done + np.arange(len(counts))) * GRID_S
        self._done += len(counts)
        if self._plays is not None:
            counts += self._plays.made_rad(made_s, taken * self._step_rad) / self._step_rad
        if self._half.any():
            counts += self._taken(counts)
        if self._joints:
            counts[rests] = given[self._margin : -self._margin][rests]
        within: FloatArray = np.clip(counts, *self._limits) - self._start
        return within

    def _more(self, meant_m: FloatArray, away_m: FloatArray) -> FloatArray:
        """Counts that take the platform off a place (n, 3) by so much (n, 3)."""
        angles_rad = self._static.angles_rad_at_once(np.vstack([meant_m, meant_m + away_m]))
        more = (angles_rad[len(meant_m) :] - angles_rad[: len(meant_m)]) / self._step_rad
        # Beyond what the arms reach there is nothing to be done.
        return np.where(np.isfinite(more), more, 0.0)

    def _taken(self, arms: FloatArray) -> FloatArray:
        """Counts of play that motors have taken up, (n, 3), when arms stick at counts (n, 3)."""
        before = arms[0] if self._moved is None else self._moved
        low, high = arms - STILL_STEPS, arms + STILL_STEPS
        moved = np.empty_like(arms)
        for m in range(MOTORS):
            moved[:, m] = clipped(np.zeros(len(arms)), low[:, m], high[:, m], float(before[m]))
        self._moved = moved[-1]
        taken: FloatArray = self._half * (arms - moved) / STILL_STEPS + self._offset
        return taken

    def _planned(self, ticks: Ticks, until_ns: int) -> Int64Array:
        """Counts at grid points up to `until_ns`, (n, 3)."""
        every = Ticks.joined([self._waiting, ticks])
        grid_ns = np.arange(self._known, until_ns // GRID_NS + 1, dtype=np.int64) * GRID_NS
        total = np.vstack([np.zeros(MOTORS), np.cumsum(every.steps, axis=0)]).astype(np.int64)
        row = np.searchsorted(every.due_ns, grid_ns, side="right")
        planned: Int64Array = self._count + total[row]
        done = int(row[-1]) if len(row) else 0
        self._count = self._count + total[done]
        self._known += len(grid_ns)
        self._waiting = every.part(slice(done, None))
        return planned

    def _places_m(self, angles_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where the arms put what rings, with play and friction as they are by then.

        And the counts of play that motors have taken up; both (n, 3).
        """
        taken = np.zeros_like(angles_rad)
        if not self._joints:
            return self._static.position_m(angles_rad), taken
        t_s = (self._known - len(angles_rad) + np.arange(len(angles_rad))) * GRID_S
        fresh = np.zeros(len(t_s), dtype=np.bool_)
        fresh[0] = t_s[0] == 0.0
        load = self._chain.course(Commands.of_angles(t_s, angles_rad)).load
        flow = Flow(t_s, fresh, 0.0, angles_rad.copy(), load, previous_s=t_s[0] - GRID_S)
        for active in self._joints:
            driven_rad, motor = flow.angles_rad.copy(), active.kind.index(active.component)
            active.act(flow)
            if "width" not in active.values:
                continue
            yields = flow.load.torque_nm[:, motor] / scalar(active.values, "stiffness")
            ahead_rad = driven_rad - flow.angles_rad + yields[:, None]
            if self._plays is not None and Hanging.is_one(active):
                ahead_rad = self._plays.planned_rad(t_s, ahead_rad)
                flow.angles_rad[:, motor] = driven_rad[:, motor] - ahead_rad[:, motor] + yields
            if self._plays is not None or _sticks(active):
                taken[:, motor] += ahead_rad[:, motor]
        return self._static.place_m(flow.angles_rad), taken / self._step_rad


def _mode(robot: RobotFile) -> Active:
    shaped = compensated(Compensated.SHAPED)
    return of_entries(entry for entry in robot.effects if entry.effect in shaped)[0]


def _omega(mode: Active) -> float:
    return float(2.0 * np.pi * scalar(mode.values, "frequency"))


def _at_joints(robot: RobotFile) -> list[Active]:
    """What moves arms, in its order, where some of it remembers."""
    plays = compensated(Compensated.AT_REVERSALS)
    if not any(entry.effect in plays for entry in robot.effects):
        return []
    known = plays | compensated(Compensated.INVERSE)
    effects = of_entries([without_swing(entry) for entry in robot.effects if entry.effect in known])
    return [active for port in (Port.MOTOR, Port.GEAR, Port.ARM) for active in at(effects, port)]


def _sticks(joint: Active) -> bool:
    """Whether it is play in which an arm stays where it is pushed."""
    return "width" in joint.values and not Hanging.is_one(joint)


def _kernel(knot: int) -> FloatArray:
    """Weights of an odd number, whose sum is 1."""
    once, box = np.ones(1), np.ones(knot) / knot
    for _ in range(BOXES):
        once = np.convolve(once, box)
    kernel: FloatArray = 2.0 * np.pad(once, len(once) // 2) - np.convolve(once, once)
    return kernel


def _smooth(values: FloatArray, knot: int) -> FloatArray:
    """The same by sums, for long motions; shorter by the kernel."""
    once = _boxed(values, knot)
    twice = _boxed(once, knot)
    cut = (len(once) - len(twice)) // 2
    smooth: FloatArray = 2.0 * once[cut : cut + len(twice)] - twice
    return smooth


def _boxed(values: FloatArray, knot: int) -> FloatArray:
    for _ in range(BOXES):
        total = np.cumsum(np.vstack([np.zeros(values.shape[1]), values]), axis=0)
        values = (total[knot:] - total[:-knot]) / knot
    return values


def _convolved(rows: FloatArray, kernel: FloatArray) -> FloatArray:
    columns: Iterable[FloatArray] = rows.T
    return np.stack([np.convolve(column, kernel, mode="valid") for column in columns], axis=1)
