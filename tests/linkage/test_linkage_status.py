"""Singular, unreachable and meaningless poses are reported as such, right where they begin."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.foundation.errors import UnreachablePoint
from deltactl.models.linkage import (
    SINGULAR_MARGIN,
    Linkage,
    Status,
    forward,
    inverse,
    inverse_one,
    parallel_margin,
    serial_margin,
)
from deltactl.models.robot import FloatArray


def outstretched(linkage: Linkage, length_scale: float) -> FloatArray:
    """The point that arm 1 just reaches when it and its forearm make one straight line.

    With `length_scale` over 1 the forearm would have to be that much longer.
    """
    angle_rad = np.deg2rad(70.0)
    along_m = linkage.upper_arm_m[0] + length_scale * linkage.forearm_m[0]
    return np.array(
        [linkage.radius_m[0] + along_m * np.cos(angle_rad), 0.0, -along_m * np.sin(angle_rad)]
    )


def test_an_outstretched_arm_is_the_edge_of_the_workspace(uzunovic: Linkage) -> None:
    others = uzunovic.with_(forearm_m=[0.068, 0.11, 0.11])  # so that arm 1 is the one that ends
    for scale, expected in (
        (1.0, Status.SINGULAR),
        (1.0 + 1e-9, Status.UNREACHABLE),
        (1.0 - 1e-9, Status.OK),
        (1.0 + 1e-15, Status.SINGULAR),
        (1.0 - 1e-14, Status.SINGULAR),
    ):
        angles_rad, status = inverse(others, outstretched(others, scale))
        assert status == expected, scale
        assert np.isnan(angles_rad).all() == (expected == Status.UNREACHABLE)
        if expected != Status.OK:
            with pytest.raises(UnreachablePoint):
                inverse_one(others, *outstretched(others, scale))


def test_singular_values_are_still_good(uzunovic: Linkage) -> None:
    others = uzunovic.with_(forearm_m=[0.068, 0.11, 0.11])
    point_m = outstretched(others, 1.0)
    angles_rad, status = inverse(others, point_m)
    assert status == Status.SINGULAR
    np.testing.assert_allclose(angles_rad[0], np.deg2rad(70.0), atol=1e-7)
    np.testing.assert_allclose(forward(others, angles_rad).position_m, point_m, atol=1e-8)
    margins = serial_margin(others, angles_rad, point_m)
    assert abs(margins[0]) < SINGULAR_MARGIN
    assert (margins[1:] > 0.1).all()


def test_zhao_with_level_arms_is_flat(zhao: Linkage) -> None:
    """Radius and upper arm add up to the forearm: all arms level put everything in one plane."""
    position_m, status = forward(zhao, np.zeros(3))
    assert status == Status.SINGULAR
    np.testing.assert_allclose(position_m, 0.0, atol=1e-8)
    assert inverse(zhao, np.zeros(3)).status == Status.SINGULAR
    assert parallel_margin(zhao, np.zeros(3), np.zeros(3)) == pytest.approx(0.0, abs=1e-12)
    assert forward(zhao, np.deg2rad([0.1, 0.1, 0.1])).status == Status.OK


def test_elbows_too_far_apart(zhao: Linkage) -> None:
    wide = zhao.with_(radius_m=0.26)
    position_m, status = forward(wide, np.zeros(3))
    assert status == Status.UNREACHABLE
    assert np.isnan(position_m).all()


def test_elbows_in_one_spot_leave_the_platform_free(zhao: Linkage) -> None:
    position_m, status = forward(zhao, np.full(3, np.pi))
    assert status == Status.SINGULAR
    assert np.isnan(position_m).all()


def test_elbows_in_a_vertical_plane_have_no_lower_point() -> None:
    tall = Linkage(
        radius_m=np.array([0.1, 0.1, 0.1]),
        upper_arm_m=np.array([0.2, 0.21, 0.22]),
        forearm_m=np.array([0.4, 0.4, 0.4]),
        azimuth_rad=np.deg2rad([0.0, 180.0, 0.0]),
        home_offset_rad=np.zeros(3),
    )
    position_m, status = forward(tall, np.array([0.2, 0.2, 1.2]))
    assert status == Status.SINGULAR
    assert np.isnan(position_m).all()
    for side_m in (0.1, -0.1):
        target_m = (0.02, side_m, -0.3)
        assert inverse(tall, np.array(target_m)).status == Status.SINGULAR
        with pytest.raises(UnreachablePoint, match="is singular"):
            inverse_one(tall, *target_m)


def test_the_platform_above_its_elbows_is_refused(uzunovic: Linkage) -> None:
    """Every arm could get there, but only after taking the robot apart."""
    rng = np.random.default_rng(4)
    points_m = rng.uniform([-0.06, -0.06, -0.06], [0.06, 0.06, 0.0], (20_000, 3))
    angles_rad, status = inverse(uzunovic, points_m)
    closable = _every_arm_reaches(uzunovic, points_m)
    above = closable & (status == Status.UNREACHABLE)
    assert above.sum() > 20
    assert np.isnan(angles_rad[above]).all()
    np.testing.assert_array_equal(closable | (status != Status.OK), True)


def _every_arm_reaches(linkage: Linkage, points_m: FloatArray) -> np.ndarray:
    """Whether each arm's circle of elbows comes within the forearm of the point."""
    reached = np.ones(len(points_m), dtype=bool)
    for arm in range(3):
        east, north = np.cos(linkage.azimuth_rad[arm]), np.sin(linkage.azimuth_rad[arm])
        out = points_m @ [east, north, 0.0] - linkage.radius_m[arm]
        side = points_m @ [-north, east, 0.0]
        in_plane = np.hypot(out, points_m[:, 2])
        nearest = np.hypot(in_plane - linkage.upper_arm_m[arm], side)
        farthest = np.hypot(in_plane + linkage.upper_arm_m[arm], side)
        reached &= (nearest < linkage.forearm_m[arm]) & (linkage.forearm_m[arm] < farthest)
    return reached


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_meaningless_input_is_unreachable_and_spoils_nobody_else(
    linkage: Linkage, bad: float, axis: int
) -> None:
    poses = np.deg2rad(np.full((3, 3), 50.0))
    sound_m, _ = forward(linkage, poses)
    points_m = sound_m.copy()
    points_m[1, axis] = bad
    angles_rad, status = inverse(linkage, points_m)
    assert status.tolist() == [Status.OK, Status.UNREACHABLE, Status.OK]
    assert np.isnan(angles_rad[1]).all()
    assert np.isfinite(angles_rad[[0, 2]]).all()
    if np.isfinite(bad):
        return  # an angle of 1e300 rad is odd but is one
    poses[1, axis] = bad
    position_m, status = forward(linkage, poses)
    assert status.tolist() == [Status.OK, Status.UNREACHABLE, Status.OK]
    assert np.isnan(position_m[1]).all()
    np.testing.assert_array_equal(position_m[[0, 2]], sound_m[[0, 2]])
