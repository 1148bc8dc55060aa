"""Every figure of the robot that stands in for Uzunovic's on the XYZ stage, with its source.

Nobody published what was wrong with the robot. What no source gives is CHOSEN, so that the errors
of the geometric model come out at the size the paper prints. That takes far more than a workshop's
tolerances: x and y errors of 1 mm at the borders of a 10 mm cube are a scale that is 16 % wrong.
Triples are joints 1 to 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.models.robot import FloatArray

Three = tuple[float, float, float]


@dataclass(frozen=True)
class StageRobot:
    """Departures from config/uzunovic-2013.yaml, and the encoders."""

    radius_error_m: Three = (2.5e-3, -3.5e-3, 5.5e-3)
    """Base radius. Chosen (see above)."""
    upper_arm_error_m: Three = (-1.1e-3, 0.3e-3, -2.4e-3)
    """Chosen (see above)."""
    forearm_error_m: Three = (0.4e-3, 1.0e-3, -1.8e-3)
    """Chosen (see above)."""
    azimuth_error_deg: Three = (9.5, -8.7, -2.6)
    """Motors against the stage's axes. Chosen (see above)."""
    start_deg: Three = (30.0, 30.0, 30.0)
    """What the encoders say at the start. Section 3.1: "all joint angles were equal 30"."""
    encoder_deg: float = 0.01
    """Section 5: resolution on the shaft side."""
    play_deg: Three = (0.10, 0.06, 0.06)
    """Between motor (where the encoder is) and arm. Chosen; a good planetary gear of 16 mm has
    1 degree, preloaded 0.1."""
    ripple_deg: Three = (0.075, 0.080, 0.078)
    """Amplitude of the tooth error of the gear's output stage. Chosen for the network's error."""
    ripples_per_turn: float = 147.0
    """Tooth meetings a turn of the arm. Assumed: three planets on a ring of 49 teeth."""
    worn_deg: float = 0.5
    """Joint 1, "manufacturing and tear problems are the biggest for this joint" (section 3.2): how
    far a worn gear lets the arm sag. Chosen for the network's error at joint 1."""
    worn_width_deg: float = 0.14
    """Half width of the sag, once in every meeting of teeth. Chosen: the worn tip of a tooth."""

    def gear_error_deg(self, angles_deg: FloatArray) -> FloatArray:
        """What the gears add between arm and encoder, (n, 3), at arm angles (n, 3)."""
        turns = np.deg2rad(angles_deg) * self.ripples_per_turn
        error: FloatArray = np.asarray(self.ripple_deg) * np.sin(turns)
        pitch_deg = 360.0 / self.ripples_per_turn
        away_deg = (angles_deg[:, 0] + 0.5 * pitch_deg) % pitch_deg - 0.5 * pitch_deg
        error[:, 0] += self.worn_deg * np.exp(-0.5 * (away_deg / self.worn_width_deg) ** 2)
        return error
