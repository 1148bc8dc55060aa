"""What this project adds to the paper's law: feedforward of the known dry friction.

At a reversal Coulomb friction changes by twice its size at once, and the observer needs a few of
its time constants to see it: that is nearly all of the tracking error. The reference says when a
joint will turn, and the robot file how large the friction is, so the current that it takes can
be given at that moment. The observer then sees only what the file has wrong.
"""

from __future__ import annotations

import numpy as np

from deltactl.models.robot import FloatArray
from deltactl.models.servo_drive import ServoDrive

FULL_AT_RADPS = 0.003
"""Speed of the arm's reference at which the whole friction is given. Slower, a part in proportion:
0.003 rad/s are 17 encoder counts a second."""


def friction_current_a(
    drive: ServoDrive, reference_rad: FloatArray, share: float = 1.0
) -> FloatArray:
    """Currents (n, 3) against the Coulomb friction of the robot file, for references (n, 3)."""
    speed_radps = np.gradient(reference_rad, drive.period_s, axis=0)
    whole_a = share * drive.coulomb_nm / drive.torque_constant_nmpa
    current: FloatArray = whole_a * np.clip(speed_radps / FULL_AT_RADPS, -1.0, 1.0)
    return current
