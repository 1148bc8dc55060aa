"""Play in which an arm hangs: on which flank it will be, and what to command there.

Inside the play the arm falls, no faster than its drag lets it. Where it is to move faster than it
falls the motor has to push it; where it is to move slower it hangs on the other flank. Which of
the two is decided beforehand, from speeds averaged over a moment and with hysteresis: near the
speed of falling both would do, and to change is to make the gear rattle.
"""

from __future__ import annotations

import numpy as np

from deltactl.models.chain.active import Active
from deltactl.models.effects.gear_backlash import STICKS, drag_on_teeth
from deltactl.models.effects.kind import scalar
from deltactl.models.robot import FloatArray

AVERAGED_S = 0.1
"""To either side."""
RELUCTANCE = 0.07
"""A flank is left when the speed is beyond that of falling by this share of it."""
STILL_RADPS = 1e-5


class Hanging:
    """One motor's play."""

    def __init__(self, play: Active):
        self.motor = play.kind.index(play.component)
        self._half_rad = 0.5 * scalar(play.values, "width")
        self._drag = max(scalar(play.values, "drag"), 1e-6)
        self._friction_nm = scalar(play.values, "friction")
        self._stiffness = scalar(play.values, "stiffness")

    @staticmethod
    def is_one(effect: Active) -> bool:
        """Whether an effect is play in which arms fall, and do not stick."""
        return "drag" in effect.values and scalar(effect.values, "drag") < STICKS

    def ahead_rad(
        self, t_s: FloatArray, angle_rad: FloatArray, torque_nm: FloatArray
    ) -> FloatArray:
        """What the gear must be ahead of the arm by, for angles meant at increasing times, (n,)."""
        beyond = np.maximum(np.abs(torque_nm) - self._friction_nm, 0.0)
        falls = np.sign(torque_nm) * beyond / self._drag
        late, early = t_s + AVERAGED_S, t_s - AVERAGED_S
        apart = np.minimum(late, t_s[-1]) - np.maximum(early, t_s[0])
        way = np.interp(late, t_s, angle_rad) - np.interp(early, t_s, angle_rad)
        speed = way / np.maximum(apart, 1e-9)
        yields = (torque_nm - drag_on_teeth(self._drag, speed)) / self._stiffness
        ahead: FloatArray = self._half_rad * _flanks(speed, falls) - yields
        return ahead


def _flanks(speed: FloatArray, falls: FloatArray) -> FloatArray:
    """1 where the gear is ahead of the arm, -1 where it is behind; speeds (n,) [rad/s]."""
    faster = speed - falls
    reluctance = RELUCTANCE * np.abs(falls) + STILL_RADPS
    sure = np.where(np.abs(faster) > reluctance, np.sign(faster), 0.0)
    decided = np.flatnonzero(sure)
    if not len(decided):
        return np.where(falls > 0.0, -1.0, 1.0)
    # As before, where it is not sure; at the beginning as it will be.
    last = np.maximum.accumulate(np.where(sure != 0.0, np.arange(len(sure)), decided[0]))
    flanks: FloatArray = sure[last]
    return flanks
