"""The three curves and four speeds of Zhao 2023, section 4.

The paper gives neither sizes nor heights. The sizes are of the order its figures show; the
heights lie in the working cylinder, chosen so that the geometric model's errors on the as-built
robot have the sizes of Table 3 (the lower the platform, the less its height depends on the arms).
"""

from __future__ import annotations

from deltactl.firmware_py.paths.circle import circle
from deltactl.firmware_py.paths.heart import heart
from deltactl.firmware_py.paths.spiral import spiral
from deltactl.models.robot import FloatArray

SPACING_M = 0.0005
T_PWM_S = (0.002, 0.006, 0.01, 0.02)
TRAINED_T_PWM_S = 0.006
CURVES = ("circle", "heart", "spiral")
TITLES = {"circle": "Circle", "heart": "Heart curve", "spiral": "Logarithmic spiral"}


def targets(curve: str) -> FloatArray:
    """Points of a curve one after another, (n, 3) [m]."""
    if curve == "circle":
        return circle((0.0, 0.0, -0.35), 0.1, 1.0, SPACING_M).targets
    if curve == "heart":
        return heart((0.0, 0.0, -0.57), 0.2, 1, SPACING_M).targets
    return spiral((0.0, 0.0, -0.60), 0.025, 0.1, 3.0, SPACING_M).targets
