"""Forward of inverse, and inverse of forward, over the whole workspace.

Rounding law checked here: a position comes back to within GROWTH eps l / parallel margin, an
angle to within GROWTH eps / (parallel margin * serial margin). Nothing is left out but poses
reported as not OK.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.models.linkage import (
    Linkage,
    Status,
    forward,
    inverse,
    parallel_margin,
    serial_margin,
)
from deltactl.models.robot import FloatArray

EPS = float(np.finfo(np.float64).eps)
GROWTH = 32.0


def whole_space(linkage: Linkage, per_axis: int) -> FloatArray:
    """A grid over the box that holds every point the linkage can touch, shape (n, 3)."""
    reach_m = float((np.abs(linkage.radius_m) + linkage.upper_arm_m + linkage.forearm_m).max())
    # Not a round fraction of the geometry, so that no grid point is special by accident.
    ticks = np.linspace(-1.0037 * reach_m, 1.0011 * reach_m, per_axis)
    return np.stack(np.meshgrid(ticks, ticks, ticks), axis=-1).reshape(-1, 3)


def assert_positions_return(linkage: Linkage, position_m: FloatArray) -> int:
    """Round trip of every OK point; returns how many there were."""
    angles_rad, status = inverse(linkage, position_m)
    ok = status == Status.OK
    back_m, forward_status = forward(linkage, angles_rad[ok])
    assert (forward_status == Status.OK).all()
    margin = parallel_margin(linkage, angles_rad[ok], position_m[ok])
    error_m = np.abs(back_m - position_m[ok]).max(axis=-1, initial=0.0)
    assert (error_m * margin <= GROWTH * EPS * linkage.forearm_m.max()).all()
    return int(ok.sum())


def assert_angles_return(linkage: Linkage, angles_rad: FloatArray) -> int:
    """Round trip of all angles with elbows on the outer side; returns how many there were."""
    position_m, status = forward(linkage, angles_rad)
    serial = serial_margin(linkage, angles_rad, position_m).min(axis=-1)
    outer = (status == Status.OK) & (serial > 1e-5)
    back_rad, back_status = inverse(linkage, position_m[outer])
    assert (back_status == Status.OK).all()
    margin = serial[outer] * parallel_margin(linkage, angles_rad[outer], position_m[outer])
    error_rad = np.abs(np.remainder(back_rad - angles_rad[outer] + np.pi, 2.0 * np.pi) - np.pi)
    assert (error_rad.max(axis=-1, initial=0.0) * margin <= GROWTH * EPS).all()
    return int(outer.sum())


def test_every_reachable_point_comes_back(linkage: Linkage) -> None:
    points_m = whole_space(linkage, per_axis=71)
    assert assert_positions_return(linkage, points_m) > 5000


def test_every_pose_with_elbows_out_comes_back(linkage: Linkage) -> None:
    ticks = np.linspace(-np.pi + 0.011, np.pi - 0.017, 61)
    angles_rad = np.stack(np.meshgrid(ticks, ticks, ticks), axis=-1).reshape(-1, 3)
    assert assert_angles_return(linkage, angles_rad) > 20_000


@st.composite
def any_linkage(draw: st.DrawFn) -> Linkage:
    """A delta of any size between 0.1 and 1 m with arms that differ."""

    def three(low: float, high: float) -> FloatArray:
        return np.array([draw(st.floats(low, high)) for _ in range(3)])

    size_m = draw(st.floats(0.1, 1.0))
    return Linkage(
        radius_m=size_m * three(0.1, 0.6),
        upper_arm_m=size_m * three(0.4, 0.6),
        forearm_m=size_m * three(0.9, 1.2),
        azimuth_rad=np.deg2rad([0.0, 120.0, 240.0]) + three(-0.2, 0.2),
        home_offset_rad=three(-0.1, 0.1),
    )


@settings(max_examples=50, deadline=None)
@given(any_linkage(), st.integers(0, 2**32 - 1))
def test_any_delta_both_ways(linkage: Linkage, seed: int) -> None:
    rng = np.random.default_rng(seed)
    reach_m = float(linkage.forearm_m.max() + linkage.upper_arm_m.max())
    points_m = rng.uniform(-reach_m, reach_m, (500, 3)) * [0.6, 0.6, 1.0]
    assert_positions_return(linkage, points_m)
    assert_angles_return(linkage, np.deg2rad(rng.uniform(-30.0, 110.0, (500, 3))))


angle = st.floats(-np.deg2rad(20.0), np.deg2rad(110.0))


@settings(max_examples=80, deadline=None)
@given(angle, angle, angle)
def test_any_pose_of_the_papers_range(first: float, second: float, third: float) -> None:
    for upper_m, forearm_m, radius_m in ((0.25, 0.5, 0.25), (0.04, 0.068, 0.01)):
        linkage = Linkage(
            radius_m=np.full(3, radius_m),
            upper_arm_m=np.full(3, upper_m),
            forearm_m=np.full(3, forearm_m),
            azimuth_rad=np.deg2rad([0.0, 120.0, 240.0]),
            home_offset_rad=np.zeros(3),
        )
        assert_angles_return(linkage, np.array([[first, second, third]]))


@pytest.mark.parametrize("shape", [(3,), (0, 3), (1, 3), (5, 7, 3), (2, 1, 4, 3)])
def test_shapes_are_kept(zhao: Linkage, shape: tuple[int, ...]) -> None:
    position_m = np.broadcast_to([0.05, -0.02, -0.45], shape)
    angles_rad, status = inverse(zhao, position_m)
    assert angles_rad.shape == shape
    assert status.shape == shape[:-1]
    back_m, status = forward(zhao, angles_rad)
    assert back_m.shape == shape
    assert status.shape == shape[:-1]
    np.testing.assert_allclose(back_m, position_m, atol=1e-14)


def test_results_do_not_depend_on_the_blocks(linkage: Linkage) -> None:
    rng = np.random.default_rng(5)
    angles_rad = np.deg2rad(rng.uniform(-20.0, 110.0, (5000, 3)))
    position_m, status = forward(linkage, angles_rad)
    for index in (0, 2047, 2048, 4095, 4096, 4999):
        alone_m, alone_status = forward(linkage, angles_rad[index])
        np.testing.assert_allclose(alone_m, position_m[index], rtol=0.0, atol=1e-14)
        assert alone_status == status[index]


def test_inputs_are_left_alone(zhao: Linkage) -> None:
    position_m = np.array([[0.05, 0.0, -0.4], [9.0, 0.0, 0.0]])
    before = position_m.copy()
    angles_rad, _ = inverse(zhao, position_m)
    kept = angles_rad.copy()
    forward(zhao, angles_rad)
    np.testing.assert_array_equal(position_m, before)
    np.testing.assert_array_equal(angles_rad, kept)


def test_home_offset_is_taken_off_and_put_back(zhao: Linkage) -> None:
    offset_rad = np.array([0.1, -0.2, 0.05])
    shifted = zhao.with_(home_offset_rad=offset_rad)
    point_m = np.array([0.03, 0.05, -0.5])
    angles_rad = inverse(zhao, point_m).angles_rad
    np.testing.assert_allclose(inverse(shifted, point_m).angles_rad, angles_rad - offset_rad)
    np.testing.assert_allclose(forward(shifted, angles_rad - offset_rad).position_m, point_m)


def test_three_numbers_a_pose_or_a_clear_error(zhao: Linkage) -> None:
    with pytest.raises(ValueError, match=r"shape \(\.\.\., 3\), got \(2, 4\)"):
        inverse(zhao, np.zeros((2, 4)))
