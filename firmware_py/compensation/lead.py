"""Steps of a drive that follows late, made early enough that the arm is there in time.

A drive with a dead time d and a lag T does x at t when commanded u(t) = x(t + d) + T x'(t + d).
The counts of the plan are smoothed over a part of T to have a speed at all (a triangle, so that
single steps do not show), and where the speed of the plan jumps by v so much that the motor can
follow: T v of way within an acceleration a need sqrt(T v / a) to either side. The path is known
before it is driven: nothing has to be guessed, all drives only start a little later. No drive is
commanded more than `MOST_LEAD_S` early.
"""

from __future__ import annotations

import math

import numpy as np

from deltactl.drivers.steps.contract import MOTORS, Int64Array
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.chain.active import of_entries
from deltactl.models.effects import Compensated, Trait, compensated, has
from deltactl.models.effects.kind import scalar
from deltactl.models.robot import FloatArray

MOST_LEAD_S = 0.5
MERGE_S = 20e-6
"""Steps of different motors this near to each other are one tick, or as near as the step output
cannot tell apart."""
GRID_S = 0.001
LOOK_S = 0.005
"""How finely a path is looked at for what leading it asks of the drives."""
SMOOTHED = 0.3
"""Half-width of the smoothing as a share of the lag."""
LEAST_SMOOTHED_S = 0.012
"""And at least this: a few steps of slow motion."""
BACK = 0.9
"""Share of a step that must be wrong before a motor turns round for it."""
NOTHING = np.empty(0, dtype=np.int64)


def can_lead(robot: RobotFile) -> bool:
    """Whether steps can be moved ahead: gpiozero cannot step motors one shortly after the other."""
    return robot.steps.backend != "gpiozero"


def accepted_lags_s(robot: RobotFile) -> tuple[FloatArray, FloatArray]:
    """Dead times and lags of the drives in the robot file, both (3,) [s]."""
    dead, lag = np.zeros(MOTORS), np.zeros(MOTORS)
    ahead = compensated(Compensated.AHEAD)
    for active in of_entries(entry for entry in robot.effects if entry.effect in ahead):
        motor, values = active.kind.index(active.component), active.values
        if has(active.kind.name, Trait.DRIVE_DELAY):
            dead[motor] += scalar(values, "dead_time")
            lag[motor] += scalar(values, "time")
        else:
            lag[motor] += scalar(values, "coefficient") / scalar(values, "stiffness")
    return dead, lag


def lags_s(robot: RobotFile) -> tuple[FloatArray, FloatArray]:
    """Those that are compensated: no drive is led by more than `MOST_LEAD_S`."""
    if not can_lead(robot):
        return np.zeros(MOTORS), np.zeros(MOTORS)
    dead, lag = accepted_lags_s(robot)
    share = np.minimum(1.0, MOST_LEAD_S / np.maximum(dead + lag, 1e-9))
    return dead * share, lag * share


def smoothed_s(lag_s: float, acceleration_hzps: float = math.inf, jump_hz: float = 0.0) -> float:
    """To either side, at most the lag where that is long; nothing for a drive without lag."""
    if not lag_s:
        return 0.0
    followed_s = min(math.sqrt(lag_s * jump_hz / acceleration_hzps), lag_s)
    return max(SMOOTHED * lag_s, LEAST_SMOOTHED_S, followed_s)


def ahead_s(dead_s: float, smoothed_s: float) -> float:
    """How far ahead of time the plan must be known."""
    return dead_s + (smoothed_s + 2.0 * GRID_S if smoothed_s else 0.0)


def merged_s(robot: RobotFile) -> float:
    """Steps of different motors nearer than this become one tick."""
    return max(min(MERGE_S, 1.0 / (6.0 * robot.limits.step_rate_hz)), robot.tick_s)


def fastest_hz(robot: RobotFile) -> float:
    """Highest rate of steps that a led drive is given: merging takes up to a window from a gap."""
    limits = robot.limits
    rate_hz = 1.0 / (1.0 / limits.step_rate_hz + merged_s(robot))
    return min(rate_hz, limits.joint_speed_radps / robot.drive.rad_per_step)


def stretch(robot: RobotFile, t_s: FloatArray, angles_rad: FloatArray, jump_hz: float) -> float:
    """How many times as long a path must take, so that drives can be led along it; 1 or more.

    A drive is commanded to x + T x', at v + T a, and in k times the time at v / k + T a / k^2.
    angles_rad: (n, 3), commanded at t_s (n,); jump_hz: as for `Lead`.
    """
    _, lags = lags_s(robot)
    longest, fastest = 1.0, fastest_hz(robot)
    for motor in np.flatnonzero(lags):
        lag_s = float(lags[motor])
        most_hzps = robot.limits.joint_acceleration_radps2 / robot.drive.rad_per_step
        reach_s = smoothed_s(lag_s, most_hzps, jump_hz)
        half = max(1, round(reach_s / LOOK_S))
        grid_s = np.arange(t_s[0] - 2 * reach_s, t_s[-1] + 2 * reach_s, LOOK_S)
        counts = np.interp(grid_s, t_s, angles_rad[:, motor]) / robot.drive.rad_per_step
        smooth = np.convolve(counts, _triangle(half), mode="valid")
        if len(smooth) < 2:
            continue
        rate_hz = np.gradient(smooth, LOOK_S)
        growth = lag_s * np.gradient(rate_hz, LOOK_S)
        # Both signs: where speed and acceleration are opposed, one may outgrow the other.
        for way in (1.0, -1.0):
            ahead = np.maximum(way * growth, 0.0)
            root = np.sqrt(rate_hz**2 + 4.0 * fastest * ahead)
            longest = max(longest, float(((way * rate_hz + root) / (2.0 * fastest)).max()))
    return longest


def _triangle(half: int) -> FloatArray:
    """Weights (2 half - 1,) whose sum is 1."""
    weights: FloatArray = (
        np.concatenate([np.arange(1, half + 1), np.arange(half, 0, -1)[1:]]) / half**2
    )
    return weights


class Lead:
    """One motor: planned steps go in, with their times, and come out with times to make them at.

    Everything comes out `after_ns` later than planned, less what it has to be early.
    """

    def __init__(
        self,
        dead_s: float,
        lag_s: float,
        after_ns: int,
        fastest_hz: float,
        acceleration_hzps: float = math.inf,
        jump_hz: float = 0.0,
        least_smoothed_s: float = 0.0,
    ):
        """No more than `fastest_hz` steps a second, whose rate changes by no more than
        `acceleration_hzps` a second; that of the plan changes by up to `jump_hz` at once.
        """
        self._lag_s = lag_s
        smoothed = max(smoothed_s(lag_s, acceleration_hzps, jump_hz), least_smoothed_s)
        self._half = round(smoothed / GRID_S)
        self._shift_ns = after_ns - round(dead_s * NS_PER_S)
        self._most = fastest_hz * GRID_S
        self._most_change = acceleration_hzps * GRID_S**2
        self._speed = 0.0
        """Steps a grid point."""
        self._goal = self._goal_speed = 0.0
        self._grid_ns = round(GRID_S * NS_PER_S)
        self._due, self._sign = NOTHING, NOTHING
        self._rows = np.zeros(self._half)
        """Counts to follow, where they are given, from `_half` grid points before `_done` on."""
        self._done = 0
        """Grid points that were turned into commands."""
        self._count = 0
        """Planned count before the steps that wait."""
        self._told = 0.0
        self._made = 0
        self._way = 1

    def steps(
        self, due_ns: Int64Array, signs: Int64Array, until_ns: int
    ) -> tuple[Int64Array, Int64Array, int]:
        """Times and signs to make, and up to when that is all; the plan is known to `until_ns`."""
        if not self._lag_s:
            return due_ns + self._shift_ns, signs, until_ns + self._shift_ns
        self._due = np.concatenate([self._due, due_ns])
        self._sign = np.concatenate([self._sign, signs])
        last = until_ns // self._grid_ns - self._half
        if last <= self._done:
            return NOTHING, NOTHING, self._done * self._grid_ns + self._shift_ns
        told = self._commands(self._done, int(last))
        made = self._as_steps(told)
        self._done = int(last)
        self._forget()
        return *made, self._done * self._grid_ns + self._shift_ns

    def along(self, counts: FloatArray) -> tuple[Int64Array, Int64Array, int]:
        """The same for counts (n,) at the next grid points in place of steps."""
        self._rows = np.concatenate([self._rows, counts])
        more = len(self._rows) - 2 * self._half - 1
        made = (NOTHING, NOTHING)
        if more > 0:
            made = self._as_steps(self._told_for(self._rows))
            self._rows = self._rows[more:]
            self._done += more
        return *made, self._done * self._grid_ns + self._shift_ns

    def _commands(self, first: int, last: int) -> FloatArray:
        """What to tell at grid points first + 1 to last, in steps."""
        grid = np.arange(first - self._half, last + self._half + 1) * self._grid_ns
        row = np.searchsorted(self._due, grid, side="right")
        total = np.concatenate([[0], np.cumsum(self._sign)])
        return self._told_for((self._count + total[row]).astype(np.float64))

    def _told_for(self, counts: FloatArray) -> FloatArray:
        """For all grid points but the first `_half` + 1 and the last `_half`."""
        h = self._half
        smooth = np.convolve(counts, _triangle(h), mode="valid")
        # Slope of the triangle-smoothed counts, central.
        slope = np.gradient(smooth) / GRID_S
        wanted: FloatArray = smooth + self._lag_s * slope
        return wanted[2:-1]

    def _as_steps(self, wanted: FloatArray) -> tuple[Int64Array, Int64Array]:
        due, signs = [], []
        told = self._told
        for number, goal in enumerate(wanted.tolist()):
            new = told + self._step_to(goal, told)
            crossed = self._crossed(new)
            for count in range(abs(crossed)):
                sign = 1 if crossed > 0 else -1
                half = self._made + sign * (count + 0.5)
                part = min(max((half - told) / (new - told), 0.0), 1.0)
                due.append(round((self._done + number + part) * self._grid_ns) + self._shift_ns)
                signs.append(sign)
            self._made += crossed
            told = new
        self._told = told
        return np.array(due, dtype=np.int64), np.array(signs, dtype=np.int64)

    def _step_to(self, goal: float, told: float) -> float:
        """How far to go at a grid point, within speed and acceleration.

        Towards the goal no faster than can be braked from there, relative to its own motion.
        """
        off, self._goal_speed = goal - told, goal - self._goal
        self._goal = goal
        change = self._most_change
        left = off - self._goal_speed
        brakes = math.sqrt(2.0 * change * abs(left)) if math.isfinite(change) else math.inf
        towards = math.copysign(min(abs(left), brakes), left)
        speed = min(max(self._goal_speed + towards, -self._most), self._most)
        self._speed += min(max(speed - self._speed, -change), change)
        return self._speed

    def _forget(self) -> None:
        old = int(np.searchsorted(self._due, (self._done - self._half - 2) * self._grid_ns))
        self._count += int(self._sign[:old].sum())
        self._due, self._sign = self._due[old:], self._sign[old:]

    def _crossed(self, told: float) -> int:
        """Steps to make: one is due half-way; back again only when most of it is to be undone."""
        beyond = told - self._made
        if abs(beyond) < (0.5 if beyond * self._way >= 0.0 else BACK):
            return 0
        steps = max(1, int(np.floor(abs(beyond) + 0.5)))
        self._way = 1 if beyond > 0.0 else -1
        return self._way * steps
