"""The plain-float forward kinematics against the vectorised one."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from deltactl.models.linkage import Linkage, Status, forward
from deltactl.models.linkage.scalar import forward_one

ANGLES = st.tuples(*[st.floats(-math.pi, math.pi)] * 3)
LINKAGES = (
    Linkage(
        np.full(3, 0.25),
        np.full(3, 0.25),
        np.full(3, 0.5),
        np.deg2rad([0.0, 120.0, 240.0]),
        np.zeros(3),
    ),
    Linkage(
        np.array([0.25, 0.26, 0.24]),
        np.array([0.25, 0.24, 0.26]),
        np.array([0.5, 0.52, 0.49]),
        np.deg2rad([1.0, 118.0, 241.0]),
        np.array([0.02, -0.01, 0.03]),
    ),
)


@given(ANGLES, st.sampled_from(LINKAGES))
def test_one_pose_is_what_the_vectorised_form_gives(
    angles: tuple[float, float, float], linkage: Linkage
) -> None:
    wanted = forward(linkage, np.array(angles))
    found = np.array(forward_one(linkage, angles))
    if wanted.status == Status.OK:
        np.testing.assert_allclose(found, wanted.position_m, rtol=1e-9, atol=1e-9)
    elif wanted.status == Status.UNREACHABLE:
        assert np.isnan(found).all()
