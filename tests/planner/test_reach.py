"""What a move in joint space is said to do, against looking very closely."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.paths import reach
from deltactl.models.linkage import Linkage, forward

angle = st.floats(-0.3, 1.9)
pose = st.tuples(angle, angle, angle)


@pytest.fixture(scope="module")
def linkage(zhao):
    return Linkage.of(zhao.geometry)


@settings(max_examples=40, deadline=None)
@given(way=st.lists(pose, min_size=2, max_size=5))
def test_margins_box_and_length_agree_with_a_close_look(linkage, way):
    angles = np.array(way)
    seen = reach.moves(linkage, angles)
    for move in range(len(way) - 1):
        part = np.linspace(0.0, 1.0, 2001)[:, None]
        close = angles[move] + part * (angles[move + 1] - angles[move])
        poses = reach.poses(linkage, close)
        if poses.margin.min() < 0.05:  # a pose cannot be assembled, or nearly so
            assert seen.margin[move] < 0.06
            continue
        assert seen.margin[move] == pytest.approx(poses.margin.min(), abs=5e-3)
        place = forward(linkage, close).position_m
        assert seen.low_m[move] == pytest.approx(place.min(axis=0), abs=1e-3)
        assert seen.high_m[move] == pytest.approx(place.max(axis=0), abs=1e-3)
        hops = np.linalg.norm(np.diff(place, axis=0), axis=1)
        assert seen.length_m[move] == pytest.approx(hops.sum(), rel=5e-3, abs=1e-6)
        assert seen.steepest_m[move] == pytest.approx(hops.max() * 2000, rel=0.15, abs=1e-6)


def test_blocks_make_no_difference(linkage, monkeypatch):
    angles = np.random.default_rng(2).uniform(0.0, 1.5, (40, 3))
    whole = reach.moves(linkage, angles)
    monkeypatch.setattr(reach, "_BLOCK", 50)
    in_blocks = reach.moves(linkage, angles)
    for name in reach.Reach.__slots__:
        assert getattr(whole, name) == pytest.approx(getattr(in_blocks, name), rel=1e-12)


def test_the_pose_with_all_arms_level_is_singular_on_the_zhao_robot(linkage):
    """0.25 m + 0.25 m of reach are just the forearm's 0.5 m."""
    through = reach.moves(linkage, np.deg2rad([[-20.0] * 3, [40.0] * 3]))
    assert through.parallel[0] == pytest.approx(-1.0)
