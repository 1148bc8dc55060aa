"""Recordings of a chain: motion and effort of every joint behind one low-pass, laid end to end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from deltactl.diagnosis.observations.inverse_dynamics import Motion, motion_of
from deltactl.diagnosis.observations.outliers import without_gross
from deltactl.diagnosis.observations.readings import (
    BoolArray,
    FloatArray,
    Readings,
    gather,
    smoothly_bridged,
)
from deltactl.diagnosis.plants.lone.clear_motion import direction_of, in_clear_motion, rows_apart
from deltactl.models.effects.chain_joints import known_gains
from deltactl.models.robot import ChainRobot
from deltactl.recording.tables.chain_tables import by_joint, columns_of
from deltactl.recording.tables.flat import FlatRecording

NEEDED = ("theta", "effort")
MEASURED = (*NEEDED, "velocity")
WIDER = 3.0
"""Times the edge of the low-pass, of the one before it: centrifugal efforts have twice the
frequency of the motion, and those of three joints together three times."""


def prepared(robot: ChainRobot, recordings: Sequence[FlatRecording]) -> list[FlatRecording]:
    """With the columns of the joints under one name each, and without single wild readings."""
    names = [name for stem in MEASURED for name, _ in columns_of(robot.joints, stem)]
    each = [by_joint(robot.joints, recording, MEASURED) for recording in recordings]
    return [without_gross(one, [name for name in names if name in one.columns]) for one in each]


@dataclass(frozen=True, slots=True, eq=False)
class JointMotions:
    """Motions and efforts of all joints, (n, joints), and which rows count of each."""

    whole: Readings
    """Angles, each sample once."""
    at: FloatArray
    """Positions, velocities and accelerations behind a low-pass that only takes the noise of
    differentiating."""
    speed: FloatArray
    change: FloatArray
    signs: FloatArray
    """Ways of the motions, from -1 to 1."""
    passed: Sequence[Motion]
    """Motions behind the low-pass that efforts and all that explains them pass, but for turning."""
    force: FloatArray
    counts: BoolArray
    stride: int
    """Samples between rows that count: nearer ones repeat each other."""


def joint_motions(
    robot: ChainRobot, recordings: Sequence[FlatRecording], narrower: float
) -> JointMotions:
    """The motions in prepared recordings with all columns that are needed.

    All joints pass one low-pass, as each joint's effort hangs on the motion of all: where the first
    position meets its noise. What a motion needs is worked out before that low-pass, and passes it
    as the effort does: products of velocities have twice their frequency.
    """
    named = {stem: [name for name, _ in columns_of(robot.joints, stem)] for stem in MEASURED}

    def read(stem: str) -> FloatArray:
        each = [[smoothly_bridged(one, name) for one in recordings] for name in named[stem]]
        return np.stack([np.concatenate(parts) for parts in each], axis=1)

    whole = gather(recordings, named["theta"], dict.fromkeys(named["theta"], "rad"))
    at = read("theta")
    known = all(name in one.columns for one in recordings for name in named["velocity"])
    speeds = [*read("velocity").T] if known else [None] * len(robot.joints)

    def motion(joint: int, share: float) -> Motion:
        return motion_of(whole.t_s, whole.fresh, at[:, joint], speeds[joint], share)

    own_hz = [motion(j, 1.0).cut_off_hz for j in range(len(robot.joints))]
    edge_hz = narrower * min(own_hz)
    edges = [motion(j, edge_hz / one) for j, one in enumerate(own_hz)]
    wide = [motion(j, WIDER * edge_hz / one) for j, one in enumerate(own_hz)]
    period = edge_hz * whole.period_s
    counts = np.stack([in_clear_motion(one, period) for one in edges], axis=1) & whole.valid
    each = [(one.position, one.velocity, one.acceleration, direction_of(one)) for one in wide]
    passed = [replace(e, turning=w.turning) for e, w in zip(edges, wide, strict=True)]
    placed, speed, change, signs = np.stack(each, axis=2)
    force, apart = robot.effort_per_unit * known_gains(robot) * read("effort"), rows_apart(period)
    return JointMotions(whole, placed, speed, change, signs, passed, force, counts, apart)
