"""The picture of a delta robot in the docs, drawn from its robot file and its own kinematics."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import deltactl as dc
from deltactl.models.robot import DeltaRobot, FloatArray

ROBOT = "zhao-2023.yaml"
POSITION_M = (0.04, -0.03, -0.42)
WIDTH, HEIGHT, PIXELS_PER_M = 640, 440, 590.0
TURN_RAD, TILT_RAD = np.radians(-96.0), np.radians(22.0)
ROD_GAP_M = 0.05
"""Half the distance of the two rods of a forearm, for the eye."""
BASE, ARM, ROD, PLATFORM, WORDS = "#64748b", "#d97706", "#0f766e", "#1d4ed8", "#475569"


def robot_picture() -> str:
    """SVG text: base, arms, forearms and platform, and what they are called."""
    parts = "\n".join(_parts())
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'font-family="sans-serif" font-size="15">\n<title>A rotary delta robot</title>\n'
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>\n{parts}\n</svg>\n'
    )


def _parts() -> Iterator[str]:
    robot = dc.Robot.load(ROBOT)
    assert isinstance(robot.model, DeltaRobot)
    sizes = robot.model.geometry
    angles = dc.kinematics(robot).inverse([POSITION_M])[0]
    azimuth = np.radians(sizes.azimuth_deg)
    out = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(3)], axis=1)
    across = np.stack([-np.sin(azimuth), np.cos(azimuth), np.zeros(3)], axis=1)
    down = np.array([0.0, 0.0, -1.0])
    hips = sizes.base_radius_m * out
    reach = np.cos(angles)[:, None] * out + np.sin(angles)[:, None] * down
    elbows = hips + sizes.upper_arm_m * reach
    wrists = np.array(POSITION_M) + sizes.platform_radius_m * out
    yield _shape(_corners(hips, across, 0.16), BASE, 0.18)
    for hip, elbow, wrist, side in zip(hips, elbows, wrists, across, strict=True):
        for sign in (-1.0, 1.0):
            shift = sign * ROD_GAP_M * side
            yield _line(elbow + shift, wrist + shift, ROD, 4)
        yield _line(elbow - ROD_GAP_M * side, elbow + ROD_GAP_M * side, ROD, 5)
        yield _line(hip, elbow, ARM, 11)
        yield _dot(hip, BASE, 11)
    yield _shape(_corners(wrists, across, ROD_GAP_M), PLATFORM, 0.55)
    yield from _names(hips, elbows, wrists)


def _names(hips: FloatArray, elbows: FloatArray, wrists: FloatArray) -> Iterator[str]:
    for number, hip in enumerate(hips, 1):
        yield _word(hip, f"motor {number}", (14, -10))
    yield _word((hips[0] + elbows[0]) / 2, "upper arm", (14, 14))
    yield _word((elbows[1] + wrists[1]) / 2, "forearm (two rods)", (12, 40))
    yield _word(np.array(POSITION_M), "platform", (-24, 42))
    centre = np.zeros(3)
    for axis, tip in zip("xyz", 0.15 * np.eye(3), strict=True):
        yield _line(centre, tip, WORDS, 2)
        yield _word(tip, axis, (4, -4))


def _corners(places: FloatArray, across: FloatArray, half_m: float) -> FloatArray:
    """Outline of a plate with a side at each of three places, shape (6, 3)."""
    pairs = [(p - half_m * a, p + half_m * a) for p, a in zip(places, across, strict=True)]
    return np.array([corner for pair in pairs for corner in pair])


def _seen(place: FloatArray) -> tuple[float, float]:
    """Where a place is on the paper [px], seen from above the side."""
    x, y, z = place
    right = x * np.cos(TURN_RAD) - y * np.sin(TURN_RAD)
    away = x * np.sin(TURN_RAD) + y * np.cos(TURN_RAD)
    up = z * np.cos(TILT_RAD) + away * np.sin(TILT_RAD)
    return WIDTH / 2 + PIXELS_PER_M * right, HEIGHT * 0.3 - PIXELS_PER_M * up


def _line(begin: FloatArray, end: FloatArray, colour: str, width: int) -> str:
    (x1, y1), (x2, y2) = _seen(begin), _seen(end)
    return (
        f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" '
        f'stroke-width="{width}" stroke-linecap="round"/>'
    )


def _dot(place: FloatArray, colour: str, radius: int) -> str:
    x, y = _seen(place)
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}" fill="{colour}"/>'


def _shape(corners: FloatArray, colour: str, opacity: float) -> str:
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(_seen, corners))
    return (
        f'<polygon points="{points}" fill="{colour}" fill-opacity="{opacity}" '
        f'stroke="{colour}" stroke-width="2"/>'
    )


def _word(place: FloatArray, text: str, shift: tuple[int, int]) -> str:
    x, y = _seen(place)
    return f'<text x="{x + shift[0]:.1f}" y="{y + shift[1]:.1f}" fill="{WORDS}">{text}</text>'
