"""Play in which an arm hangs: on which flank its gear is to be, and when it crosses the play.

Inside the play the arm falls, no faster than its drag lets it. Where it is to move faster than it
falls the motor has to push it; where it is to move slower it hangs on the other flank. So the gear
crosses where the arm turns round beside one that only falls, unless it turns back soon: to cross
is to make the gear rattle. Meanwhile nothing holds the arm, and a gear that is as fast as it can be
slows the path down. So beginning and length of each crossing are tried out on a model of the fall,
and what keeps the arm nearest to its path is taken.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from deltactl.models.chain.active import Active
from deltactl.models.effects.gear_backlash import STICKS, drag_on_teeth
from deltactl.models.effects.kind import scalar
from deltactl.models.robot import FloatArray

AVERAGED_S = 0.1
"""To either side: how fast arms turn."""
CROSSES = 0.25
"""A gear crosses the play where its arm would else be off by this share of it."""
LOOK_S, COARSE_S, FINE_S = 1.0, 0.04, 0.01
"""A crossing begins so near to where the arm turns round, and is tried out so finely."""
LONGEST_S, LENGTHS = 0.8, 9
"""The longest crossing that is tried out, and how many lengths are."""


@dataclass(frozen=True, eq=False)
class Pace:
    """Times (n,) [s] of a path before play is taken up, and what motors can do."""

    t_s: FloatArray
    speed_radps: float = math.inf
    acceleration_radps2: float = math.inf
    from_rest: bool = True
    """Whether arms hang when it begins."""


class Hanging:
    """One motor's play."""

    def __init__(self, play: Active):
        self.motor = play.kind.index(play.component)
        self.width_rad = scalar(play.values, "width")
        self._drag = max(scalar(play.values, "drag"), 1e-6)
        self._friction_nm = scalar(play.values, "friction")
        self._stiffness = scalar(play.values, "stiffness")

    @staticmethod
    def is_one(effect: Active) -> bool:
        """Whether an effect is play in which arms fall, and do not stick."""
        return "drag" in effect.values and scalar(effect.values, "drag") < STICKS

    def ahead_rad(self, pace: Pace, angle_rad: FloatArray, torque_nm: FloatArray) -> FloatArray:
        """What the gear must be ahead of the arm by, for angles meant at increasing times, (n,)."""
        t_s = pace.t_s
        late, early = t_s + AVERAGED_S, t_s - AVERAGED_S
        apart = np.minimum(late, t_s[-1]) - np.maximum(early, t_s[0])
        way = np.interp(late, t_s, angle_rad) - np.interp(early, t_s, angle_rad)
        speed = way / np.maximum(apart, 1e-9)
        yields = (torque_nm - drag_on_teeth(self._drag, speed)) / self._stiffness
        across = self.across(pace, angle_rad, torque_nm)
        ahead: FloatArray = 0.5 * self.width_rad * across - yields
        return ahead

    def across(self, pace: Pace, angle_rad: FloatArray, torque_nm: FloatArray) -> FloatArray:
        """Where in the play the gear is to be, from -1 (behind the arm) to 1 (ahead), (n,)."""
        beyond = np.maximum(np.abs(torque_nm) - self._friction_nm, 0.0)
        falls = np.sign(torque_nm) * beyond / self._drag
        return Crossings(pace, angle_rad, falls, self.width_rad).across()


class Crossings:
    """Where in the play one gear is, from -1 (behind its arm) to 1 (ahead of it)."""

    def __init__(self, pace: Pace, angle_rad: FloatArray, falls: FloatArray, width_rad: float):
        """falls: how fast the arm falls at each time, (n,) [rad/s]."""
        self._t_s, self._angle_rad, self._falls = pace.t_s, angle_rad, falls
        self._width_rad, self._fastest = width_rad, pace.speed_radps
        self._from_rest = pace.from_rest
        least_s = max(
            width_rad / pace.speed_radps, 2.0 * math.sqrt(width_rad / pace.acceleration_radps2)
        )
        self._lengths_s = np.geomspace(max(least_s, 1e-3), max(least_s, LONGEST_S), LENGTHS)

    def across(self) -> FloatArray:
        """For all times, (n,)."""
        t_s, falls = self._t_s, self._falls
        fallen = np.cumsum(0.5 * (falls[1:] + falls[:-1]) * np.diff(t_s))
        ahead_rad = self._angle_rad - np.append(0.0, fallen)
        turns = list(_turns(ahead_rad, CROSSES * self._width_rad))
        way = float(np.sign(ahead_rad[[*turns, -1][0]] - ahead_rad[0])) or -1.0
        if self._from_rest and way * falls[0] > 0.0:
            turns.insert(0, 0)
            way = -way
        knots_s, across = [t_s[0]], [way]
        for turn, after in pairwise([*turns, len(t_s) - 1]):
            way = -way
            knots_s += self._crossing_s(turn, after, way, knots_s[-1])
            across += [-way, way]
        found: FloatArray = np.interp(t_s, knots_s, across)
        return found

    def _crossing_s(self, turn: int, after: int, way: float, from_s: float) -> list[float]:
        """From when to when the gear crosses; the arm turns round at a row, and again at another.

        way: 1 where the gear is ahead afterwards. from_s: when the crossing before it ended.
        """
        t_s = self._t_s
        first_s, last_s = max(t_s[turn] - LOOK_S, from_s), min(t_s[turn] + LOOK_S, t_s[after])
        rows = slice(int(np.searchsorted(t_s, first_s)), int(np.searchsorted(t_s, last_s)) + 1)
        begins_s, lengths_s = np.arange(first_s, last_s, COARSE_S), self._lengths_s
        best = self._best_s(rows, way, begins_s, lengths_s, last_s)
        around_s = best[0] + np.arange(-COARSE_S, COARSE_S, FINE_S)
        begins_s = np.append(around_s[(around_s >= first_s) & (around_s < last_s)], best[0])
        lengths_s = max(best[1] - best[0], 1e-3) * np.geomspace(0.5, 2.0, 5)
        return list(self._best_s(rows, way, begins_s, lengths_s, last_s))

    def _best_s(
        self, rows: slice, way: float, begins_s: FloatArray, lengths_s: FloatArray, last_s: float
    ) -> tuple[float, float]:
        """Beginning and end of the best crossing of those that begin and last so."""
        t_s = self._t_s[rows]
        begin_s, length_s = (one.ravel() for one in np.meshgrid(begins_s, lengths_s))
        end_s = np.minimum(begin_s + np.maximum(length_s, self._lengths_s[0]), last_s)
        long_s = np.maximum(end_s - begin_s, 1e-9)
        done = (t_s - begin_s[:, None]) / long_s[:, None]
        across = way * np.clip(2.0 * done - 1.0, -1.0, 1.0)
        best = int(self._off_rad2s(rows, across).argmin())
        return float(begin_s[best]), float(end_s[best])

    def _off_rad2s(self, rows: slice, across: FloatArray) -> FloatArray:
        """By how much arms leave their path if gears are at (m, n) for some rows: (m,)."""
        half_rad, angle_rad, falls = 0.5 * self._width_rad, self._angle_rad[rows], self._falls[rows]
        gear_rad = angle_rad + half_rad * across
        t_s, number = self._t_s[rows], np.arange(len(angle_rad))
        late, early = (
            np.interp(t_s + AVERAGED_S, t_s, number),
            np.interp(t_s - AVERAGED_S, t_s, number),
        )
        between = np.interp(late, number, t_s) - np.interp(early, number, t_s)
        usual_s = (between / (late - early))[1:]
        # Whole ticks differ from row to row.
        slower_s = np.maximum(np.abs(np.diff(gear_rad)) / self._fastest - usual_s, 0.0)
        step_s = np.diff(t_s) + slower_s
        arm_rad, off = np.full(len(across), angle_rad[0]), np.zeros(len(across))
        for row in range(1, len(angle_rad)):
            arm_rad = arm_rad + falls[row] * step_s[:, row - 1]
            arm_rad = np.clip(arm_rad, gear_rad[:, row] - half_rad, gear_rad[:, row] + half_rad)
            off += (arm_rad - angle_rad[row]) ** 2 * step_s[:, row - 1]
        return off


def _turns(values: FloatArray, least: float) -> Iterator[int]:
    """Rows where values turn round by at least so much."""
    high, low, way = 0, 0, 0
    for row, value in enumerate(values.tolist()):
        if value > values[high]:
            high = row
        if value < values[low]:
            low = row
        if way >= 0 and value < values[high] - least:
            if way:
                yield high
            way, low = -1, row
        elif way <= 0 and value > values[low] + least:
            if way:
                yield low
            way, high = 1, row
