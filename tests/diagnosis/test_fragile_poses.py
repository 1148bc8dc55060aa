"""Poses near where the arms lie flat are left out; a file that is wrong everywhere is not."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.plants.delta.safe_poses import fragile
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import DeltaRobot


def test_flat_arms_are_fragile_and_bent_ones_are_not(delta: DeltaRobot) -> None:
    linkage = Linkage.of(delta.geometry)
    # All three arms of the Zhao robot alike: flat at 0, where upper arm and forearm just reach.
    angles = np.repeat(np.radians([[1.0], *[[30.0 + k] for k in range(9)]]), 3, axis=1)
    assert np.isfinite(forward(linkage, angles).position_m).all()
    assert fragile(linkage, angles).tolist() == [True] + 9 * [False]


def test_not_everything_is_left_out(delta: DeltaRobot) -> None:
    linkage = Linkage.of(delta.geometry)
    angles = np.repeat(np.radians([[1.0], [40.0]]), 3, axis=1)
    assert not fragile(linkage, angles).any()
