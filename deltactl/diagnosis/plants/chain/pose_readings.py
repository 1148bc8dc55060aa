"""Poses of a chain that were measured from outside: its tables as arrays, one row a pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.chain.joint_motions import joint_columns
from deltactl.models.robot import ChainRobot
from deltactl.recording.tables.flat import TARGET, AnyArray, FlatRecording

QUATERNION = ("quat_x", "quat_y", "quat_z", "quat_w")
ROTATION = ("rotvec_x", "rotvec_y", "rotvec_z")
IN_MM = "_mm"
MOST_POSES = 1500
"""More of a motion are thinned out: neighbours are alike."""
SMOOTH = 0.05
"""Share of a joint's range that it moves from row to row at most where it never rests."""
SMALLEST_MOVE = 1e-4
"""Share of a joint's range below which it rested: encoders and loops are noisy."""


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """Measured poses and the angles there.

    at: (n, joints) as the encoders read, or as commanded where they were not read. ahead: (n,
    joints) command less encoder; None where only one of both is known. places: (n, k, 3) of the
    targets [m], NaN where one was not seen. turned: rotation vectors (n, 3) [rad]; None without.
    part: number of the recording, (n,). step: (n, joints) from the pose before, 0 at the first.
    """

    at: FloatArray
    ahead: FloatArray | None
    targets: tuple[str, ...]
    places: FloatArray
    turned: FloatArray | None
    part: IntArray
    step: FloatArray
    t_s: FloatArray
    period_s: float = 0.0
    """Between rows in motion; 0 of poses at rest."""


def measures_poses(robot: ChainRobot, recording: FlatRecording) -> bool:
    """Whether a table has places, and no efforts in motion, which say more of it."""
    efforts = all(joint_columns(robot, recording, "effort"))
    at_rest = not recording.timed or len(recording.stretches()) == len(recording)
    return bool(targets_in(recording)) and (at_rest or not efforts)


def targets_in(recording: FlatRecording) -> tuple[str, ...]:
    """Stems of the columns of places: pos, pos1, pos2."""
    names = [*recording.columns, *recording.extra]
    found = {match[1] for name in names if (match := TARGET.fullmatch(name))}
    return tuple(sorted(found, key=lambda stem: (len(stem), stem)))


def place_of(recording: FlatRecording, stem: str) -> FloatArray | None:
    """Where a target was, (n, 3) [m]; None where a column is missing."""
    return block(recording, [f"{stem}_{axis}" for axis in "xyz"])


def block(recording: FlatRecording, names: Sequence[str]) -> FloatArray | None:
    """Columns (n, k) in SI units; None where one is missing."""
    table = {**recording.extra, **recording.columns}
    found = [_column(table, name) for name in names]
    known = [one for one in found if one is not None]
    return np.stack(known, axis=1) if len(known) == len(names) else None


def _column(table: dict[str, AnyArray], name: str) -> FloatArray | None:
    for called, factor in ((name, 1.0), (f"{name}{IN_MM}", 1e-3)):
        values = table.get(called)
        if values is not None and values.dtype.kind in "fiu":
            return factor * np.asarray(values, dtype=float)
    return None


def joints_of(robot: ChainRobot, recording: FlatRecording, stem: str) -> FloatArray | None:
    """Angles or commands of all joints, (n, joints)."""
    names = joint_columns(robot, recording, stem)
    known = [name for name in names if name is not None]
    return block(recording, known) if len(known) == len(names) else None


def orientation(recording: FlatRecording) -> FloatArray | None:
    """Rotation vectors (n, 3) [rad], NaN where none was measured; None without such columns."""
    quaternion, vector = block(recording, QUATERNION), block(recording, ROTATION)
    if quaternion is not None:
        size = np.linalg.norm(quaternion, axis=1)
        known = np.isfinite(size) & (size > 0.0)
        vector = np.full((len(size), 3), np.nan)
        vector[known] = Rotation.from_quat(quaternion[known]).as_rotvec()
    return vector


def poses_of(robot: ChainRobot, recordings: Sequence[FlatRecording]) -> Poses:
    """The poses of recordings that `admission` let pass; rows that are not known in full are left
    out.
    """
    angles = [joints_of(robot, one, "theta") for one in recordings]
    commands = [joints_of(robot, one, "command") for one in recordings]
    read = all(one is not None for one in angles)
    at = _joined(angles if read else commands)
    both = read and all(one is not None for one in commands)
    ahead = _joined(commands) - at if both else None
    targets = targets_in(recordings[0])
    places = np.stack([_joined([place_of(r, t) for r in recordings]) for t in targets], axis=1)
    turned = [orientation(one) for one in recordings]
    vectors = _joined(turned) if all(one is not None for one in turned) else None
    part = np.repeat(np.arange(len(recordings)), [len(one) for one in recordings])
    step = np.diff(at, axis=0, prepend=at[:1])
    step[np.diff(part, prepend=-1) != 0] = 0.0
    known = np.isfinite(at).all(axis=1) & np.isfinite(places).any(axis=(1, 2))
    if ahead is not None:
        known &= np.isfinite(ahead).all(axis=1)
    period_s = _period_s(recordings, at[known], np.nan_to_num(step[known]))
    rows = np.flatnonzero(known)
    known = rows[:: -(-len(rows) // MOST_POSES)]
    return Poses(
        at[known], None if ahead is None else ahead[known], targets, places[known],
        None if vectors is None else vectors[known], part[known].astype(np.intp),
        np.nan_to_num(step[known]), np.concatenate([one.t_s for one in recordings])[known],
        period_s,
    )  # fmt: skip


def _period_s(recordings: Sequence[FlatRecording], at: FloatArray, step: FloatArray) -> float:
    """Time between rows of a motion; 0 where the rows are poses at rest."""
    usual = np.median(np.abs(step), axis=0) / np.maximum(np.ptp(at, axis=0), 1e-12)
    moves = all(one.timed for one in recordings) and 0.0 < float(usual.max()) < SMOOTH
    return recordings[0].period_s() if moves else 0.0


def last_way(poses: Poses) -> FloatArray:
    """Signs (n, joints) of the last moves: a table has poses in the order of the visits."""
    step, travel = poses.step, np.maximum(np.ptp(poses.at, axis=0), 1e-12)
    moved = np.abs(step) > SMALLEST_MOVE * travel
    rows = np.arange(len(step))[:, None]
    last = np.maximum.accumulate(np.where(moved, rows, 0), axis=0)
    signs: FloatArray = np.sign(np.take_along_axis(np.where(moved, step, 0.0), last, axis=0))
    return signs


def _joined(parts: Sequence[FloatArray | None]) -> FloatArray:
    return np.concatenate([part for part in parts if part is not None])
