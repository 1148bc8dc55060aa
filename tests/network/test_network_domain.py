"""The region a network may be asked in."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from deltactl.models.network import Box, Cylinder
from deltactl.models.network.metadata import EDGE_M

CYLINDER = Cylinder(radius_m=0.2, z_m=(-0.6, -0.35))
BOX = Box(x_m=(-0.1, 0.2), y_m=(-0.3, 0.1), z_m=(-0.5, -0.4))
number = st.floats(min_value=-1.0, max_value=1.0)
any_domain = st.sampled_from([CYLINDER, BOX])


@given(any_domain, number, number, number)
def test_what_is_inside_stays_and_what_is_outside_moves_to_the_edge(
    domain: Cylinder | Box, x_m: float, y_m: float, z_m: float
) -> None:
    point_m = np.array([x_m, y_m, z_m])
    clipped_m = domain.clip(point_m)
    assert domain.contains(*clipped_m.tolist())
    moved_m = float(np.linalg.norm(clipped_m - point_m))
    if domain.contains(x_m, y_m, z_m):
        assert moved_m <= 2.0 * EDGE_M
    else:
        assert moved_m > 0.0


@given(any_domain, number, number, number)
def test_no_inside_point_is_outside_the_bounding_box(
    domain: Cylinder | Box, x_m: float, y_m: float, z_m: float
) -> None:
    low_m, high_m = domain.bounding_box()
    in_box = np.all((low_m - EDGE_M <= [x_m, y_m, z_m]) & ([x_m, y_m, z_m] <= high_m + EDGE_M))
    assert in_box or not domain.contains(x_m, y_m, z_m)


@pytest.mark.parametrize("domain", [CYLINDER, BOX])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_not_a_number_is_outside(domain: Cylinder | Box, axis: int) -> None:
    point_m = [0.0, 0.0, -0.45]
    assert domain.contains(*point_m)
    point_m[axis] = float("nan")
    assert not domain.contains(*point_m)


def test_the_edges_themselves_are_inside() -> None:
    for angle in np.linspace(0.0, 6.0, 50):
        assert CYLINDER.contains(0.2 * np.cos(angle), 0.2 * np.sin(angle), -0.6)
    assert not CYLINDER.contains(0.2001, 0.0, -0.5)
    assert not CYLINDER.contains(0.0, 0.0, -0.6001)
    assert BOX.contains(-0.1, 0.1, -0.4)
    assert not BOX.contains(-0.1001, 0.1, -0.4)


def test_ranges_must_be_ordered() -> None:
    with pytest.raises(ValidationError, match="lowest, highest"):
        Cylinder(radius_m=0.2, z_m=(-0.3, -0.6))
    with pytest.raises(ValidationError, match=r"y_m must be"):
        Box(x_m=(0.0, 1.0), y_m=(1.0, 0.0), z_m=(0.0, 1.0))
