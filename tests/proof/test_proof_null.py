"""The second robot with nothing wrong: loops that hold, and the geometry it is meant to be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("mujoco", reason="the proof's robot needs the extra 'proof' (MuJoCo)")

from deltactl.foundation.errors import UnreachablePoint
from deltactl.proof.motions import arm_angles, survey
from deltactl.proof.null import silence
from deltactl.proof.recorded import Machine, sample_times
from deltactl.proof.robot.as_built import AsBuilt, Body, Joints
from deltactl.proof.robot.bodies import Assembly, build
from deltactl.proof.robot.run import run
from tests.rigs.clean_ranges import clean_ranges

ASSEMBLY = Assembly(build(Body(), Joints(), 0.001))


@pytest.fixture(scope="module")
def null_run():
    train = survey(np.random.default_rng(4), 12.0, 0.001)
    return train, run(AsBuilt(), train)


@settings(max_examples=15, deadline=None)
@given(
    st.floats(-0.14, 0.14), st.floats(-0.14, 0.14), st.floats(-0.55, -0.35)
)  # fmt: skip
def test_bodies_close_where_the_geometry_says(x, y, z):
    point = np.array([[x, y, z]])
    angles = arm_angles(point, Body())[0]
    assert ASSEMBLY.platform_m(angles) == pytest.approx(point[0], abs=1e-8)


def test_out_of_reach_is_said():
    with pytest.raises(UnreachablePoint, match="arm 1 cannot reach"):
        arm_angles(np.array([[-0.9, 0.0, -0.5]]), Body())


def test_loops_stay_closed(null_run):
    _, truth = null_run
    # At 22 degrees a second, started and stopped at once; the noise is 1.5 to 3 mm.
    assert truth.gap_m < 1e-4


def test_the_null_is_silent(null_run):
    """Readings against rigid bodies at the commanded angles: gravity's 0.04 mm and no more."""
    train, _ = null_run
    measured = silence(train)
    assert np.all(measured.rms_m < [1.2e-5, 1.2e-5, 6e-5])
    assert np.all(np.abs(measured.mean_m) < [5e-6, 5e-6, 6e-5])


def test_the_null_records_what_the_geometry_says(null_run):
    train, _ = null_run
    points = clean_ranges(Machine(), train) - [0.6, 0.6, 0.9]
    commanded = train.smooth(sample_times(train)) * Joints().rad_per_step
    error_rad = arm_angles(points, Body()) - commanded
    assert np.abs(error_rad.mean(axis=0)).max() < 1.5e-4
    assert error_rad.std(axis=0).max() < 2e-4
