"""Jacobian against finite differences, and the margins against what they promise."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.models.linkage import (
    Linkage,
    forward,
    inverse,
    jacobian,
    parallel_margin,
    serial_margin,
)
from deltactl.models.robot import FloatArray


def workspace(linkage: Linkage, count: int, least_margin: float) -> tuple[FloatArray, FloatArray]:
    """Random poses of the papers' range that keep away from singular ones."""
    angles_rad = np.deg2rad(np.random.default_rng(21).uniform(-20.0, 110.0, (count, 3)))
    position_m, status = forward(linkage, angles_rad)
    keep = status == 0
    keep &= serial_margin(linkage, angles_rad, position_m).min(axis=-1) > least_margin
    keep &= parallel_margin(linkage, angles_rad, position_m) > least_margin
    assert keep.sum() > count // 3
    return angles_rad[keep], position_m[keep]


def differences(
    function: Callable[[FloatArray], FloatArray], at: FloatArray, step: float
) -> FloatArray:
    """d function / d at by fourth-order central differences, (..., 3, 3)."""
    columns = []
    for axis in range(3):
        ahead = np.zeros(3)
        ahead[axis] = step
        near = function(at + ahead) - function(at - ahead)
        far = function(at + 2.0 * ahead) - function(at - 2.0 * ahead)
        columns.append((8.0 * near - far) / (12.0 * step))
    return np.stack(columns, axis=-1)


def test_jacobian_is_the_slope_of_forward(linkage: Linkage) -> None:
    angles_rad, position_m = workspace(linkage, 3000, least_margin=0.05)
    exact = jacobian(linkage, angles_rad, position_m)
    measured = differences(lambda a: forward(linkage, a).position_m, angles_rad, step=2e-4)
    assert np.abs(exact - measured).max() < 1e-8 * float(linkage.upper_arm_m.max())


def test_inverse_moves_as_the_inverted_jacobian_says(linkage: Linkage) -> None:
    angles_rad, position_m = workspace(linkage, 3000, least_margin=0.05)
    size_m = float(linkage.upper_arm_m.max())
    exact = np.linalg.inv(jacobian(linkage, angles_rad, position_m))
    measured = differences(lambda p: inverse(linkage, p).angles_rad, position_m, 1e-5 * size_m)
    assert np.abs(exact - measured).max() * size_m < 1e-7


def test_shapes_and_single_poses_agree(zhao: Linkage) -> None:
    angles_rad = np.deg2rad(np.random.default_rng(3).uniform(20.0, 60.0, (4, 5, 3)))
    position_m = forward(zhao, angles_rad).position_m
    whole = jacobian(zhao, angles_rad, position_m)
    assert whole.shape == (4, 5, 3, 3)
    assert serial_margin(zhao, angles_rad, position_m).shape == (4, 5, 3)
    assert parallel_margin(zhao, angles_rad, position_m).shape == (4, 5)
    np.testing.assert_allclose(
        jacobian(zhao, angles_rad[2, 3], position_m[2, 3]), whole[2, 3], rtol=1e-13
    )


def test_margins_bound_the_forearm_directions(linkage: Linkage) -> None:
    angles_rad = np.random.default_rng(22).uniform(-np.pi, np.pi, (4000, 3))
    position_m, status = forward(linkage, angles_rad)
    angles_rad, position_m = angles_rad[status == 0], position_m[status == 0]
    true_rad = angles_rad + linkage.home_offset_rad
    reach_m = linkage.radius_m + linkage.upper_arm_m * np.cos(true_rad)
    outward = np.stack(
        [np.cos(linkage.azimuth_rad), np.sin(linkage.azimuth_rad), np.zeros(3)], axis=-1
    )
    up = np.array([0.0, 0.0, 1.0])
    elbows = reach_m[..., None] * outward - (linkage.upper_arm_m * np.sin(true_rad))[..., None] * up
    directions = (position_m[:, None, :] - elbows) / linkage.forearm_m[:, None]
    margin = parallel_margin(linkage, angles_rad, position_m)
    assert (margin > 0.0).all()
    np.testing.assert_allclose(margin, np.abs(np.linalg.det(directions)), atol=1e-13)
    smallest = np.linalg.svd(directions, compute_uv=False)[:, -1]
    assert (smallest >= 2.0 / 3.0 * margin - 1e-13).all()


def test_serial_margin_changes_sign_with_the_elbow(zhao: Linkage) -> None:
    """Through the outstretched arm: the platform comes back, the elbow is on the other side."""
    moving_deg = np.linspace(40.0, 150.0, 400)
    angles_rad = np.deg2rad(np.stack([moving_deg, *[np.full(400, 80.0)] * 2], axis=-1))
    position_m, status = forward(zhao, angles_rad)
    assert (status == 0).all()
    margin = serial_margin(zhao, angles_rad, position_m)[:, 0]
    assert margin[0] > 0.5
    assert margin[-1] < -0.1
    back_rad = inverse(zhao, position_m).angles_rad[:, 0]
    outer = margin > 1e-3
    np.testing.assert_allclose(back_rad[outer], angles_rad[outer, 0], atol=1e-10)
    assert (back_rad[margin < -1e-3] < angles_rad[margin < -1e-3, 0]).all()


def test_singular_and_unreachable_poses_give_nan(zhao: Linkage) -> None:
    assert np.isnan(jacobian(zhao, np.full(3, np.nan), np.full(3, np.nan))).all()
    flat = Linkage(
        radius_m=np.full(3, 0.5),
        upper_arm_m=np.full(3, 0.25),
        forearm_m=np.full(3, 0.75),
        azimuth_rad=np.zeros(3),
        home_offset_rad=np.zeros(3),
    )
    assert np.isnan(jacobian(flat, np.zeros(3), np.zeros(3))).all()


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 80.0), st.floats(-0.5, 0.5))
def test_a_turned_robot_has_a_turned_jacobian(angle_deg: float, turn_rad: float) -> None:
    base = Linkage(
        radius_m=np.full(3, 0.2),
        upper_arm_m=np.full(3, 0.25),
        forearm_m=np.full(3, 0.5),
        azimuth_rad=np.deg2rad([0.0, 120.0, 240.0]),
        home_offset_rad=np.zeros(3),
    )
    turned = base.with_(azimuth_rad=base.azimuth_rad + turn_rad)
    angles_rad = np.deg2rad([angle_deg, 30.0, 45.0])
    cos, sin = np.cos(turn_rad), np.sin(turn_rad)
    about_z = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    there = jacobian(turned, angles_rad, forward(turned, angles_rad).position_m)
    here = jacobian(base, angles_rad, forward(base, angles_rad).position_m)
    np.testing.assert_allclose(there, about_z @ here, atol=1e-12)
