"""Building a linkage: from a robot file, from arrays, changed, and different from pose to pose."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.models.linkage import Linkage, forward, inverse, jacobian
from deltactl.models.robot import Geometry


def test_of_a_geometry() -> None:
    linkage = Linkage.of(
        Geometry(
            base_radius_m=(0.3, 0.31, 0.32),
            platform_radius_m=0.1,
            upper_arm_m=0.25,
            forearm_m=(0.5, 0.51, 0.52),
            azimuth_deg=(0.0, 90.0, 180.0),
            home_offset_deg=(0.0, 1.8, -1.8),
        )
    )
    np.testing.assert_allclose(linkage.radius_m, [0.2, 0.21, 0.22])
    np.testing.assert_allclose(linkage.upper_arm_m, [0.25, 0.25, 0.25])
    np.testing.assert_allclose(linkage.forearm_m, [0.5, 0.51, 0.52])
    np.testing.assert_allclose(linkage.azimuth_rad, [0.0, np.pi / 2, np.pi])
    np.testing.assert_allclose(linkage.home_offset_rad, [0.0, np.pi / 100, -np.pi / 100])


def test_values_cannot_be_changed_in_place(zhao: Linkage) -> None:
    with pytest.raises(ValueError, match="read-only"):
        zhao.upper_arm_m[0] = 1.0
    given = np.full(3, 0.3)
    changed = zhao.with_(upper_arm_m=given)
    given[0] = 9.0
    assert changed.upper_arm_m[0] == 0.3


def test_with_changes_one_thing(zhao: Linkage) -> None:
    changed = zhao.with_(forearm_m=0.6)
    np.testing.assert_array_equal(changed.forearm_m, [0.6, 0.6, 0.6])
    np.testing.assert_array_equal(changed.upper_arm_m, zhao.upper_arm_m)
    np.testing.assert_array_equal(zhao.forearm_m, [0.5, 0.5, 0.5])
    point_m = np.array([0.02, 0.03, -0.5])
    assert (inverse(changed, point_m).angles_rad != inverse(zhao, point_m).angles_rad).all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"upper_arm_m": [0.25, 0.0, 0.25]}, "upper_arm_m: must be positive"),
        ({"forearm_m": [0.5, 0.5, -0.5]}, "forearm_m: must be positive"),
        ({"radius_m": [0.2, np.nan, 0.2]}, "radius_m: must be finite"),
        ({"azimuth_rad": [0.0, 1.0]}, r"azimuth_rad: the last dimension must be 3, got \(2,\)"),
    ],
)
def test_nonsense_is_refused(zhao: Linkage, changes: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        zhao.with_(**changes)


def test_arms_that_grow_from_pose_to_pose(zhao: Linkage) -> None:
    rng = np.random.default_rng(41)
    strain = np.linspace(0.0, 1e-2, 5000)[:, None]
    growing = zhao.with_(
        upper_arm_m=zhao.upper_arm_m * (1.0 + strain), forearm_m=zhao.forearm_m * (1.0 + strain)
    )
    angles_rad = np.deg2rad(rng.uniform(5.0, 70.0, (5000, 3)))
    position_m, status = forward(growing, angles_rad)
    slopes = jacobian(growing, angles_rad, position_m)
    assert (status == 0).all()
    np.testing.assert_allclose(inverse(growing, position_m).angles_rad, angles_rad, atol=1e-11)
    for row in (0, 1, 2047, 2048, 4999):
        alone = zhao.with_(upper_arm_m=growing.upper_arm_m[row], forearm_m=growing.forearm_m[row])
        expected_m = forward(alone, angles_rad[row]).position_m
        np.testing.assert_allclose(position_m[row], expected_m, atol=1e-14)
        np.testing.assert_allclose(
            slopes[row], jacobian(alone, angles_rad[row], expected_m), atol=1e-12
        )


def test_one_pose_with_many_linkages(zhao: Linkage) -> None:
    radii_m = np.linspace(0.2, 0.25, 7)[:, None] * np.ones(3)
    position_m, status = forward(zhao.with_(radius_m=radii_m), np.deg2rad([30.0, 40.0, 50.0]))
    assert position_m.shape == (7, 3)
    assert status.tolist() == [0] * 7
    assert (np.diff(position_m[:, 2]) > 0.0).all()
