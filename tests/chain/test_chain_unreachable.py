"""Where the arms cannot be assembled nothing is known, and what remembers forgets nothing else."""

from __future__ import annotations

import numpy as np

from deltactl.models.chain import Chain, Commands
from deltactl.models.robot import DeltaRobot, EffectEntry

RINGING = EffectEntry(
    effect="resonance", component="platform", parameters={"frequency": 3.0, "damping": 0.2}
)
WIDE = EffectEntry(effect="base_radius", component="frame", parameters={"length_error": 0.005})
FLAT_RAD = 0.0
"""Arms that lie flat reach no platform on a base that is too wide."""


def test_ringing_goes_on_after_a_pose_that_cannot_be_reached(
    robot: DeltaRobot, motion: tuple[np.ndarray, np.ndarray]
) -> None:
    t_s, counts = motion
    rad = Commands.of_counts(t_s, counts, robot.drive).angles_rad.copy()
    rad[50:53] = FLAT_RAD
    chain = Chain(robot)
    plain = chain.simulate(Commands.of_angles(t_s, rad), [WIDE]).position
    rung = chain.simulate(Commands.of_angles(t_s, rad), [WIDE, RINGING])
    lost = np.isnan(plain).any(axis=1)
    assert lost.any()
    assert not lost[:40].any()
    assert not lost[60:].any()
    np.testing.assert_array_equal(np.isnan(rung.position).any(axis=1), lost)
    np.testing.assert_array_equal(np.isnan(rung.ranges).any(axis=1), lost)
    # Three seconds later the jump has rung out: only the motion's own ringing is left.
    assert np.abs(rung.position - plain)[220:].max() < 0.01
