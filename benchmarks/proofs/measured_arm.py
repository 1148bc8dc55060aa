"""A six-axis arm with hidden errors, looked at by a tracker, that shares no code with the models.

Its frames are multiplied out joint by joint, and the moments of its weights are summed as points.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from deltactl.models.robot import FloatArray

JOINTS = ("base_pan", "shoulder", "elbow", "roll", "pitch", "flange")
AXES = np.array([[0, 0, 1], [0, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 0], [1, 0, 0]], dtype=float)
ORIGINS = np.array(
    [[0, 0, 0.25], [0.12, 0, 0.2], [0, 0, 0.55], [0.2, 0, 0.1], [0, 0, 0.35], [0.09, 0, 0]]
)
TURNS = np.zeros((6, 3))
TURNS[3:5, 1] = 0.5 * np.pi, -0.5 * np.pi
"""How each joint's frame is turned against the link before it: the roll joint turns about its z."""
MASSES = np.array([12.0, 10.0, 7.0, 3.0, 2.0, 1.0])
CENTRES = np.array(
    [[0.05, 0, 0.1], [0, 0, 0.25], [0.1, 0, 0.05], [0, 0, 0.15], [0.04, 0, 0], [0.05, 0, 0.02]]
)
PULL = np.array([0.0, 0.0, -9.81])
REACHES = np.array([2.5, 1.0, 1.2, 2.8, 1.8, 3.0])


@dataclass
class Hidden:
    """What is wrong; nothing by default. off: shift [m] and turn [rad] before each joint."""

    home_rad: FloatArray = field(default_factory=lambda: np.zeros(6))
    ratio: FloatArray = field(default_factory=lambda: np.zeros(6))
    off: FloatArray = field(default_factory=lambda: np.zeros((6, 6)))
    compliance: FloatArray = field(default_factory=lambda: np.zeros(6))
    wave_rad: FloatArray = field(default_factory=lambda: np.zeros(6))
    waves: FloatArray = field(default_factory=lambda: np.ones(6))
    play_rad: FloatArray = field(default_factory=lambda: np.zeros(6))
    tool_m: FloatArray = field(default_factory=lambda: np.array([0.11, 0.02, 0.06]))
    ahead_rad: float = 0.0
    """Usual command less encoder; with it the table has commands."""
    windup: FloatArray = field(default_factory=lambda: np.zeros(6))
    missing: float = 0.0
    """Share of the last move that is yet to come."""
    noise_m: float = 2e-5


def turn(vector: FloatArray) -> FloatArray:
    """Rotation matrix of a rotation vector (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turned: FloatArray = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return turned


def _frames(q: FloatArray, off: FloatArray) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """Frame, place and axis of each link in one pose."""
    frame, place, found = np.eye(3), np.zeros(3), []
    for j in range(6):
        place = place + frame @ (ORIGINS[j] + off[j, :3])
        frame = frame @ turn(off[j, 3:]) @ turn(TURNS[j])
        axis = frame @ AXES[j]
        frame = frame @ turn(AXES[j] * q[j])
        found.append((frame, place, axis))
    return found


def torques(q: FloatArray) -> FloatArray:
    """What weight does to each joint, (6,) [N m]."""
    links, made = _frames(q, np.zeros((6, 6))), np.zeros(6)
    for j in range(6):
        _, anchor, axis = links[j]
        for k in range(j, 6):
            frame, place, _ = links[k]
            made[j] += axis @ np.cross(place + frame @ CENTRES[k] - anchor, MASSES[k] * PULL)
    return made


def place(q: FloatArray, hidden: Hidden) -> tuple[FloatArray, FloatArray]:
    """Where the reflector is, and how the flange is turned."""
    frame, at, _ = _frames(q, hidden.off)[-1]
    return at + frame @ hidden.tool_m, frame


def measured(hidden: Hidden, count: int = 300, seed: int = 3) -> FloatArray:
    """Rows of six angles, six commands where there are any, and the reflector's place in the
    tracker's frame, [rad] and [m].
    """
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1.0, 1.0, (count, 6)) * REACHES
    q[:, 4] += 0.6
    base, shift = turn(np.array([0.3, -1.9, 0.8])), np.array([2.1, -0.7, 0.4])
    rows, before = [], q[0]
    for angles in q:
        way = np.sign(angles - before)
        true = angles + hidden.home_rad + hidden.ratio * angles + 0.5 * hidden.play_rad * way
        true = true + hidden.wave_rad * np.sin(hidden.waves * angles)
        true = true + hidden.compliance * torques(angles) + hidden.missing * (before - angles)
        ahead = hidden.ahead_rad * rng.standard_normal(6)
        true = true + hidden.windup * ahead
        point, _ = place(true, hidden)
        seen = base @ point + shift + hidden.noise_m * rng.standard_normal(3)
        rows.append([*angles, *(angles + ahead if hidden.ahead_rad else ()), *seen])
        before = angles
    return np.array(rows)


def oriented(hidden: Hidden, count: int = 150, seed: int = 4) -> tuple[list[str], FloatArray]:
    """Heading and rows of angles, places of a reflector at the elbow and one at the tool, and the
    tool's orientation as a quaternion.
    """
    rng = np.random.default_rng(seed)
    base, hand = turn(np.array([1.1, 0.4, -2.0])), turn(np.array([0.2, -0.5, 0.9]))
    shift, elbow = np.array([-1.0, 0.6, 0.2]), np.array([0.15, -0.08, 0.05])
    rows = []
    for angles in rng.uniform(-1.0, 1.0, (count, 6)) * REACHES:
        links = _frames(angles + hidden.home_rad, hidden.off)
        seen = []
        for (frame, at, _), off in ((links[2], elbow), (links[5], hidden.tool_m)):
            noise = hidden.noise_m * rng.standard_normal(3)
            seen += [*(base @ (at + frame @ off) + shift + noise)]
        wobble = turn(1e-4 * rng.standard_normal(3))
        rows.append([*angles, *seen, *_quaternion(base @ wobble @ links[5][0] @ hand)])
    head = [f"theta_{n}" for n in range(1, 7)]
    head += [f"pos{k}_{axis}" for k in (1, 2) for axis in "xyz"] + [f"quat_{q}" for q in "wxyz"]
    return head, np.array(rows)


def _quaternion(turned: FloatArray) -> FloatArray:
    """w, x, y, z of a rotation matrix: the direction that all its images keep (Bar-Itzhack)."""
    (a, b, c), (d, e, f), (g, h, i) = turned
    matrix = np.array(
        [
            [a + e + i, h - f, c - g, d - b],
            [h - f, a - e - i, b + d, c + g],
            [c - g, b + d, e - a - i, f + h],
            [d - b, c + g, f + h, i - a - e],
        ]
    )
    return np.asarray(np.linalg.eigh(matrix)[1][:, -1])


def heading(rows: FloatArray) -> list[str]:
    """Names of the columns that `measured` makes."""
    angles = [f"theta_{n}" for n in range(1, 7)]
    commands = [f"command_{n}" for n in range(1, 7)] if rows.shape[1] > 9 else []
    return [*angles, *commands, *(f"pos_{axis}" for axis in "xyz")]


def table(
    folder: Path,
    rows: FloatArray,
    name: str = "poses.csv",
    times: bool = True,
    head: list[str] | None = None,
) -> Path:
    """The rows as a table, a pose every five seconds."""
    head = head or heading(rows)
    if times:
        head, rows = ["t", *head], np.column_stack([5.0 * np.arange(len(rows)), rows])
    path = folder / name
    np.savetxt(path, rows, "%.9g", ",", header=",".join(head), comments="")
    return path


def urdf_text() -> str:
    """The arm as its drawing has it."""
    parts = ['<robot name="six"><link name="base"/>']
    for j, name in enumerate(JOINTS):
        parent = "base" if j == 0 else f"link_{JOINTS[j - 1]}"
        vectors = (ORIGINS, TURNS, AXES, CENTRES)
        origin, rpy, axis, centre = (" ".join(map(str, rows[j])) for rows in vectors)
        parts.append(
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/>'
            f'<child link="link_{name}"/><origin xyz="{origin}" rpy="{rpy}"/><axis xyz="{axis}"/>'
            '<limit lower="-3.2" upper="3.2" effort="9" velocity="9"/></joint>'
            f'<link name="link_{name}"><inertial><origin xyz="{centre}"/>'
            f'<mass value="{MASSES[j]}"/>'
            '<inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )
    return "".join([*parts, "</robot>"])
