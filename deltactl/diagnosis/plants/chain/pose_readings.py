"""Poses of a chain that were measured from outside: its tables as arrays, one row a pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.models.robot import ChainRobot
from deltactl.recording.tables.chain_tables import joints_of, orientation, place_of, targets_in
from deltactl.recording.tables.flat import FlatRecording

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
    joints) command less encoder; 0 where only one of both is known. places: (n, k, 3) of the
    targets [m], NaN where one was not seen. turned: rotation vectors (n, 3) [rad]; (n, 0) without.
    part: number of the recording, (n,). step: (n, joints) from the pose before, 0 at the first.
    """

    at: FloatArray
    ahead: FloatArray
    targets: tuple[str, ...]
    places: FloatArray
    turned: FloatArray
    part: IntArray
    step: FloatArray
    t_s: FloatArray
    period_s: float = 0.0
    """Between rows in motion; 0 of poses at rest."""

    def those(self, rows: IntArray) -> Poses:
        """Some of them."""
        each = {one.name: getattr(self, one.name) for one in fields(self)}
        some: dict[str, Any] = {n: v[rows] for n, v in each.items() if isinstance(v, np.ndarray)}
        return replace(self, **some)


def poses_of(robot: ChainRobot, recordings: Sequence[FlatRecording]) -> Poses:
    """The poses of recordings that `admission` let pass, in rows that are known in full."""
    angles = [joints_of(robot.joints, one, "theta") for one in recordings]
    commands = [joints_of(robot.joints, one, "command") for one in recordings]
    read = all(one is not None for one in angles)
    at = _joined(angles if read else commands)
    both = read and all(one is not None for one in commands)
    ahead = _joined(commands) - at if both else np.zeros_like(at)
    targets = targets_in(recordings[0])
    places = np.stack([_joined([place_of(r, t) for r in recordings]) for t in targets], axis=1)
    turned = [orientation(one) for one in recordings]
    vectors = _joined(turned) if all(one is not None for one in turned) else at[:, :0]
    part = np.repeat(np.arange(len(recordings)), [len(one) for one in recordings])
    step = np.nan_to_num(np.diff(at, axis=0, prepend=at[:1]))
    step[np.diff(part, prepend=-1) != 0] = 0.0
    known = np.isfinite(at + ahead).all(axis=1) & np.isfinite(places).any(axis=(1, 2))
    t_s = np.concatenate([one.t_s for one in recordings])
    period_s, rows = _period_s(recordings, at[known], step[known]), np.flatnonzero(known)
    every = Poses(at, ahead, targets, places, vectors, part.astype(np.intp), step, t_s, period_s)
    return every.those(rows[:: -(-len(rows) // MOST_POSES)])


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
    return np.asarray(np.sign(np.take_along_axis(np.where(moved, step, 0.0), last, axis=0)))


def _joined(parts: Sequence[FloatArray | None]) -> FloatArray:
    return np.concatenate([part for part in parts if part is not None])
