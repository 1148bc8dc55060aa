"""Against a solver that shares nothing with the closed forms.

The loop is written out anew with rotation matrices, base and platform radius apart, and is
solved numerically: roots of one arm's loop on the circle (inverse), Newton's method from below
(forward). Reachability is decided by whether such roots exist.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from deltactl.models.linkage import Linkage, Status, forward, inverse, serial_margin
from deltactl.models.robot import FloatArray, Geometry, per_arm

CIRCLE = np.linspace(-np.pi, np.pi, 721)


class LoopClosure:
    """The loop-closure equations of a geometry, straight from the picture of a delta."""

    def __init__(self, geometry: Geometry):
        self.base_m = per_arm(geometry.base_radius_m)
        self.platform_m = per_arm(geometry.platform_radius_m)
        self.upper_m = per_arm(geometry.upper_arm_m)
        self.forearm_m = per_arm(geometry.forearm_m)
        self.offset_rad = np.deg2rad(geometry.home_offset_deg)
        self.turns = [_about_z(np.deg2rad(degrees)) for degrees in geometry.azimuth_deg]
        self.circles = [np.array([self.elbow_m(arm, a) for a in CIRCLE]) for arm in range(3)]

    def elbow_m(self, arm: int, true_rad: float) -> FloatArray:
        down = np.array([np.cos(true_rad), 0.0, -np.sin(true_rad)])
        shoulder = np.array([self.base_m[arm], 0.0, 0.0])
        elbow: FloatArray = self.turns[arm] @ (shoulder + self.upper_m[arm] * down)
        return elbow

    def wrist_m(self, arm: int, position_m: FloatArray) -> FloatArray:
        wrist: FloatArray = position_m + self.turns[arm] @ [self.platform_m[arm], 0.0, 0.0]
        return wrist

    def gap_m2(self, arm: int, true_rad: float, position_m: FloatArray) -> float:
        forearm = self.wrist_m(arm, position_m) - self.elbow_m(arm, true_rad)
        return float(forearm @ forearm) - float(self.forearm_m[arm]) ** 2

    def arm_angles(self, arm: int, position_m: FloatArray) -> list[float]:
        """All angles in (-pi, pi] that close one arm's loop."""
        forearms = self.wrist_m(arm, position_m) - self.circles[arm]
        outside = np.linalg.norm(forearms, axis=-1) > self.forearm_m[arm]
        return [
            brentq(
                lambda a: self.gap_m2(arm, a, position_m), CIRCLE[at], CIRCLE[at + 1], xtol=1e-14
            )
            for at in np.flatnonzero(outside[1:] != outside[:-1])
        ]

    def assembled(self, position_m: FloatArray) -> FloatArray | None:
        """Commanded angles with all elbows out and the platform below them, if there are any."""
        roots = [
            [a for a in self.arm_angles(arm, position_m) if self.is_outer(arm, a, position_m)]
            for arm in range(3)
        ]
        if any(len(outer) != 1 for outer in roots):
            return None
        true_rad = np.array([outer[0] for outer in roots])
        if self.mirrored_height_m(true_rad, position_m) < position_m[2]:
            return None
        return true_rad - self.offset_rad

    def mirrored_height_m(self, true_rad: FloatArray, position_m: FloatArray) -> float:
        """Height of the other meeting point: the platform mirrored in the plane of its elbows."""
        corners = [
            self.elbow_m(arm, true_rad[arm]) - self.wrist_m(arm, position_m) for arm in range(3)
        ]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        normal = normal / np.linalg.norm(normal)
        return float(position_m[2] + 2.0 * normal[2] * (normal @ corners[0]))

    def is_outer(self, arm: int, true_rad: float, position_m: FloatArray) -> bool:
        """Whether the elbow is on the outer side of the line from shoulder to wrist."""
        back = self.turns[arm].T
        shoulder = np.array([self.base_m[arm], 0.0, 0.0])
        along = back @ self.wrist_m(arm, position_m) - shoulder
        elbow = back @ self.elbow_m(arm, true_rad) - shoulder
        return bool(along[2] * elbow[0] - along[0] * elbow[2] < 0.0)

    def position(self, angles_rad: FloatArray) -> FloatArray:
        """The lower meeting point, by Newton's method from well below the elbows."""
        true_rad = angles_rad + self.offset_rad
        elbows = np.array([self.elbow_m(arm, true_rad[arm]) for arm in range(3)])
        point = elbows.mean(axis=0) - [0.0, 0.0, 2.0 * self.forearm_m.max()]
        for _ in range(25):
            slopes = [2.0 * (self.wrist_m(arm, point) - elbows[arm]) for arm in range(3)]
            gaps = [self.gap_m2(arm, true_rad[arm], point) for arm in range(3)]
            point = point - np.linalg.solve(slopes, gaps)
        return point


def _about_z(angle_rad: float) -> FloatArray:
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def test_inverse_agrees_with_the_roots_of_the_loop(geometry: Geometry, linkage: Linkage) -> None:
    loop = LoopClosure(geometry)
    reach_m = float(linkage.upper_arm_m.max() + linkage.forearm_m.max())
    rng = np.random.default_rng(11)
    points_m = rng.uniform([-0.8, -0.8, -1.05], [0.8, 0.8, 0.1], (400, 3)) * reach_m
    angles_rad, status = inverse(linkage, points_m)
    reached = 0
    for point_m, angles, code in zip(points_m, angles_rad, status, strict=True):
        expected_rad = loop.assembled(point_m)
        assert code == (Status.UNREACHABLE if expected_rad is None else Status.OK)
        if expected_rad is None:
            assert np.isnan(angles).all()
        else:
            np.testing.assert_allclose(angles, expected_rad, atol=1e-9)
            reached += 1
    assert 60 < reached < 340


@pytest.mark.study
def test_forward_agrees_with_newton(geometry: Geometry, linkage: Linkage) -> None:
    loop = LoopClosure(geometry)
    rng = np.random.default_rng(12)
    # From where the forearms hang well down: Newton's method has no branch to lose there.
    angles_rad = np.deg2rad(rng.uniform(15.0, 75.0, (200, 3)))
    position_m, status = forward(linkage, angles_rad)
    assert (status == Status.OK).all()
    for angles, found_m in zip(angles_rad, position_m, strict=True):
        expected_m = loop.position(angles)
        assert expected_m is not None
        np.testing.assert_allclose(found_m, expected_m, atol=1e-10)


def test_forward_closes_the_loop_everywhere(geometry: Geometry, linkage: Linkage) -> None:
    loop = LoopClosure(geometry)
    rng = np.random.default_rng(13)
    angles_rad = rng.uniform(-np.pi, np.pi, (1000, 3))
    position_m, status = forward(linkage, angles_rad)
    ok = status == Status.OK
    assert ok.sum() > 700
    for angles, point_m in zip(angles_rad[ok], position_m[ok], strict=True):
        true_rad = angles + loop.offset_rad
        gaps = [loop.gap_m2(arm, true_rad[arm], point_m) for arm in range(3)]
        assert np.abs(gaps).max() < 1e-11 * float(linkage.forearm_m.max()) ** 2
        assert loop.mirrored_height_m(true_rad, point_m) > point_m[2]


def test_forward_refuses_only_elbows_too_far_apart(uzunovic: Linkage) -> None:
    angles_rad = np.random.default_rng(14).uniform(-np.pi, np.pi, (2000, 3))
    _, status = forward(uzunovic, angles_rad)
    # Three equal forearms meet only if the circle through their elbows is not wider than they.
    apart = _circumradius_m(_elbows_less_platform(uzunovic, angles_rad)) > uzunovic.forearm_m[0]
    assert 50 < apart.sum() < 1950
    np.testing.assert_array_equal(status == Status.UNREACHABLE, apart)


def test_serial_margin_is_the_slope_of_the_loop(geometry: Geometry, linkage: Linkage) -> None:
    loop = LoopClosure(geometry)
    angles_rad = np.deg2rad(np.random.default_rng(15).uniform(0.0, 90.0, (50, 3)))
    position_m, _ = forward(linkage, angles_rad)
    margins = serial_margin(linkage, angles_rad, position_m)
    step_rad = 1e-5
    for angles, point_m, margin in zip(angles_rad, position_m, margins, strict=True):
        for arm in range(3):
            true_rad = angles[arm] + loop.offset_rad[arm]
            rise = loop.gap_m2(arm, true_rad + step_rad, point_m) - loop.gap_m2(
                arm, true_rad - step_rad, point_m
            )
            slope = -rise / (4.0 * step_rad * loop.forearm_m[arm] * loop.upper_m[arm])
            np.testing.assert_allclose(margin[arm], slope, atol=1e-8)


def _elbows_less_platform(linkage: Linkage, angles_rad: FloatArray) -> FloatArray:
    reach_m = linkage.radius_m + linkage.upper_arm_m * np.cos(angles_rad)
    return np.stack(
        [
            reach_m * np.cos(linkage.azimuth_rad),
            reach_m * np.sin(linkage.azimuth_rad),
            -linkage.upper_arm_m * np.sin(angles_rad),
        ],
        axis=-1,
    )


def _circumradius_m(corners: FloatArray) -> FloatArray:
    """Radius of the circle through each triangle's corners (n, 3, xyz), by Heron's formula."""
    a, b, c = (np.linalg.norm(corners[:, i] - corners[:, i - 1], axis=-1) for i in range(3))
    radius: FloatArray = a * b * c / np.sqrt((a + b + c) * (b + c - a) * (a + c - b) * (a + b - c))
    return radius
