"""One target in plain floats is the same as the arrays, refusals included."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.foundation.errors import MotionError, UnreachablePoint
from deltactl.models.linkage import Linkage, Status, inverse, inverse_one
from deltactl.models.robot import Geometry

CROOKED = Linkage.of(
    Geometry(
        base_radius_m=0.325,
        platform_radius_m=0.075,
        upper_arm_m=(0.25, 0.243, 0.258),
        forearm_m=(0.49, 0.5, 0.512),
        azimuth_deg=(3.0, 117.0, 244.5),
        home_offset_deg=(1.5, -2.0, 0.7),
    )
)


def test_agrees_with_the_arrays_everywhere(linkage: Linkage) -> None:
    reach_m = float((linkage.upper_arm_m + linkage.forearm_m).max())
    rng = np.random.default_rng(31)
    points_m = rng.uniform([-0.8, -0.8, -1.05], [0.8, 0.8, 0.2], (300, 3)) * reach_m
    angles_rad, status = inverse(linkage, points_m)
    assert 30 < (status == Status.OK).sum() < 270
    np.testing.assert_allclose(
        [one_by_one(linkage, point) for point in points_m.tolist()],
        np.where((status == Status.OK)[:, None], angles_rad, np.nan),
        atol=1e-12,
    )


def one_by_one(linkage: Linkage, point_m: list[float]) -> tuple[float, ...]:
    """Angles of one target; NaN where it is refused."""
    try:
        return inverse_one(linkage, *point_m)
    except UnreachablePoint:
        return (np.nan,) * 3


coordinate = st.floats(allow_nan=True, allow_infinity=True) | st.floats(-0.7, 0.7)


@pytest.mark.study
@settings(max_examples=100, deadline=None)
@given(coordinate, coordinate, coordinate)
def test_any_numbers_give_angles_or_unreachable_point(x_m: float, y_m: float, z_m: float) -> None:
    expected_rad, status = inverse(CROOKED, np.array([x_m, y_m, z_m]))
    if status == Status.OK:
        np.testing.assert_allclose(inverse_one(CROOKED, x_m, y_m, z_m), expected_rad, atol=1e-9)
    else:
        with pytest.raises(UnreachablePoint, match=r"^target \(.*\) m is .*$"):
            inverse_one(CROOKED, x_m, y_m, z_m)


def test_says_which_target_and_why(zhao: Linkage) -> None:
    with pytest.raises(MotionError, match=r"target \(0\.9, 0, -0\.25\) m is out of reach"):
        inverse_one(zhao, 0.9, 0.0, -0.25)
    for wrong_m in (-200.0, -0.9, 0.9):
        with pytest.raises(
            UnreachablePoint, match=r"at this x and y, z from -\d+ to -?\d+ mm .* in mm\)$"
        ):
            inverse_one(zhao, 0.0, 0.0, wrong_m)
    with pytest.raises(UnreachablePoint, match="at this x and y no z is in reach"):
        inverse_one(zhao, 90.0, 0.0, -0.5)
    with pytest.raises(UnreachablePoint, match=r"did you mean z = -500 mm\?"):
        inverse_one(zhao, 0.0, 0.0, 0.5)
    with pytest.raises(ValueError, match=r"target \(0, 0, 0\) m is singular"):
        inverse_one(zhao, 0.0, 0.0, 0.0)


def test_the_circle_that_it_names_is_the_widest_in_reach(zhao: Linkage) -> None:
    with pytest.raises(UnreachablePoint) as refused:
        inverse_one(zhao, 0.9, 0.0, -0.5)
    found = re.search(r"circles of up to (\d+) mm radius", str(refused.value))
    assert found is not None
    turns_rad = np.linspace(0.0, 2.0 * np.pi, 360)
    ring = np.stack([np.cos(turns_rad), np.sin(turns_rad), np.zeros(360)], axis=1)
    for wider_mm, whole in ((0, True), (12, False)):
        places_m = ring * (int(found[1]) + wider_mm) * 1e-3 + [0.0, 0.0, -0.5]
        assert (inverse(zhao, places_m).status == Status.OK).all() == whole


def test_needs_one_linkage(zhao: Linkage) -> None:
    many = zhao.with_(upper_arm_m=np.full((5, 3), 0.25))
    with pytest.raises(ValueError, match="differs from pose to pose"):
        inverse_one(many, 0.0, 0.0, -0.5)
