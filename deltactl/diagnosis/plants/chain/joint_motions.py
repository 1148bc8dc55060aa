"""Recordings of a chain: motion and effort of every joint behind one low-pass, laid end to end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import binary_dilation, binary_opening

from deltactl.diagnosis.observations.inverse_dynamics import Motion, motion_of
from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.outliers import without_gross
from deltactl.diagnosis.observations.readings import (
    BoolArray,
    FloatArray,
    IntArray,
    Readings,
    gather,
    smoothly_bridged,
)
from deltactl.diagnosis.plants.lone.options import FORCED_AXIS
from deltactl.models.robot import ChainRobot
from deltactl.recording.tables.flat import FlatRecording

NEEDED = ("theta", "effort")
MEASURED = (*NEEDED, "velocity")
WIDER = 3.0
"""Times the edge of the low-pass, of the one before it: centrifugal efforts have twice the
frequency of the motion, and those of three joints together three times."""


def columns_of(robot: ChainRobot, stem: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The column of each joint, and the names that a table may have for it: by its place among the
    joints, by the joint's name; an angle also by the joint's name alone.
    """
    for number, joint in enumerate(robot.joints, 1):
        bare = (joint,) if stem == "theta" else ()
        yield f"{stem}_{number}", (f"{stem}_{number}", f"{stem}_{joint}", f"{joint}_{stem}", *bare)


def joint_columns(robot: ChainRobot, recording: FlatRecording, stem: str) -> list[str | None]:
    """What the column of each joint is called in a table; None where it has none."""
    table = {**recording.extra, **recording.columns}
    each = (others for _, others in columns_of(robot, stem))
    return [next((name for name in others if _numbers(table.get(name))), None) for others in each]


def prepared(robot: ChainRobot, recordings: Sequence[FlatRecording]) -> list[FlatRecording]:
    """With the columns of the joints under one name each, and without single wild readings."""
    made = []
    for recording in recordings:
        table = {**recording.extra, **recording.columns}
        own = {
            f"{stem}_{number}": np.asarray(table[name], dtype=float)
            for stem in MEASURED
            for number, name in enumerate(joint_columns(robot, recording, stem), 1)
            if name is not None
        }
        whole = replace(recording, columns={**recording.columns, **own})
        made.append(without_gross(whole, list(own)))
    return made


def _numbers(values: object) -> bool:
    return isinstance(values, np.ndarray) and values.dtype.kind in "fiu" and len(values) > 0


@dataclass(frozen=True, slots=True, eq=False)
class JointMotions:
    """Motions and efforts of all joints, (n, joints), and which rows count of each."""

    whole: Readings
    """Angles, each sample once."""
    wide: tuple[Motion, ...]
    """Behind a low-pass that only takes the noise of differentiating."""
    edge: tuple[Motion, ...]
    """Behind the low-pass that efforts and all that explains them pass."""
    force: FloatArray
    counts: BoolArray
    stride: int
    """Samples between rows that count: nearer ones repeat each other."""

    @property
    def at(self) -> FloatArray:
        """Positions."""
        return np.stack([one.position for one in self.wide], axis=1)

    @property
    def speed(self) -> FloatArray:
        """Velocities."""
        return np.stack([one.velocity for one in self.wide], axis=1)

    @property
    def change(self) -> FloatArray:
        """Accelerations."""
        return np.stack([one.acceleration for one in self.wide], axis=1)

    def low_passed(self, values: FloatArray) -> FloatArray:
        """(n, joints) behind the low-pass of the efforts."""
        each = [one.low_passed(values[:, j]) for j, one in enumerate(self.edge)]
        return np.stack(each, axis=1)

    def slope(self, values: FloatArray) -> FloatArray:
        """Change (n, joints) in time."""
        each = [one.slope(values[:, j]) for j, one in enumerate(self.edge)]
        return np.stack(each, axis=1)


def joint_motions(
    robot: ChainRobot, recordings: Sequence[FlatRecording], narrower: float
) -> JointMotions:
    """The motions in prepared recordings with all columns that are needed.

    All joints pass one low-pass, as each joint's effort hangs on the motion of all: where the first
    position meets its noise. What a motion needs is worked out before that low-pass, and passes it
    as the effort does: products of velocities have twice their frequency.
    """
    names = [name for name, _ in columns_of(robot, "theta")]
    whole = gather(recordings, names, dict.fromkeys(names, "rad"))
    forces = robot.effort_per_unit * _side_by_side(recordings, robot, "effort")
    at = _side_by_side(recordings, robot, "theta")
    speeds = None
    if all(name in one.columns for one in recordings for name, _ in columns_of(robot, "velocity")):
        speeds = _side_by_side(recordings, robot, "velocity")

    def motion(joint: int, share: float) -> Motion:
        speed = None if speeds is None else speeds[:, joint]
        return motion_of(whole.t_s, whole.fresh, at[:, joint], speed, share)

    own = [motion(j, 1.0).cut_off_hz for j in range(len(names))]
    edge_hz = narrower * min(own)
    motions = tuple(motion(j, edge_hz / one) for j, one in enumerate(own))
    wide = tuple(motion(j, WIDER * edge_hz / one) for j, one in enumerate(own))
    period = edge_hz * whole.period_s
    counts = np.stack([_counts(one, period) for one in motions], axis=1) & whole.valid
    return JointMotions(
        whole, wide, motions, forces, counts, max(1, int(FORCED_AXIS.periods_a_row / period))
    )


def _side_by_side(recordings: Sequence[FlatRecording], robot: ChainRobot, stem: str) -> FloatArray:
    names = [name for name, _ in columns_of(robot, stem)]
    each = [np.stack([smoothly_bridged(one, name) for name in names], axis=1) for one in recordings]
    return np.concatenate(each)


def _counts(motion: Motion, period: float) -> BoolArray:
    """Samples (n,) of a joint in clear motion; period: between samples, in periods of the low-pass.

    At rest friction is anything.
    """
    slowest = FORCED_AXIS.slowest_share * motion.top_speed
    slow = np.abs(motion.velocity) <= max(FORCED_AXIS.resolved * motion.velocity_noise, slowest)
    rests = binary_opening(slow, np.ones(max(2, int(FORCED_AXIS.rest_periods / period)), bool))
    reach = max(1, int(FORCED_AXIS.smeared_periods / period))
    smeared = binary_dilation(rests, np.ones(2 * reach + 1, bool))
    counted: BoolArray = motion.settled & ~slow & ~smeared
    return counted


class Layout:
    """How the efforts of all joints are one column: joint after joint, section after section.

    Samples a filter's memory apart say all that passed the low-pass; the others are left out.

    Sections hold equally many rows that count, so that a share of the column left out is a time
    left out of all joints, as a size is to be foretold in another motion and not in another joint.
    """

    def __init__(self, moved: JointMotions, sections: int, stride: int):
        """stride: samples from one that is kept to the next."""
        self.kept = np.arange(0, len(moved.counts), stride)
        samples, self.joints = len(self.kept), moved.counts.shape[1]
        counted = np.cumsum(moved.counts[self.kept].sum(axis=1))
        ends = np.searchsorted(counted, counted[-1] * np.arange(1, sections) / sections)
        section = np.searchsorted(ends, np.arange(samples), side="right")
        key = section[:, None] * self.joints + np.arange(self.joints)
        self.order: IntArray = np.argsort(key.T.ravel(), kind="stable")
        self.joint: IntArray = np.repeat(np.arange(self.joints), samples)[self.order]
        self._row: IntArray = np.tile(np.arange(samples), self.joints)[self.order]
        self.sample: IntArray = self.kept[self._row]

    def laid(self, values: FloatArray) -> FloatArray:
        """(samples, joints) or (samples, joints, k) as (n,) or (n, k)."""
        laid: FloatArray = values[self.sample, self.joint]
        return laid

    def by_joint(self, column: FloatArray) -> FloatArray:
        """(n,) as (samples, joints)."""
        made = np.empty((len(self.kept), self.joints))
        made[self._row, self.joint] = column
        return made

    def readings(self, moved: JointMotions, observed: FloatArray, unit: str) -> Readings:
        """What was observed (samples, joints) as one channel, in stretches of a joint each."""
        whole = moved.whole
        own_s, period_s = whole.t_s[self.sample], whole.period_s
        stretch = np.cumsum(whole.fresh)[self.sample]
        fresh = np.diff(stretch, prepend=-1) != 0
        fresh |= np.diff(self.joint, prepend=-1) != 0
        fresh |= np.diff(self._row, prepend=-2) != 1
        step = np.diff(own_s, prepend=own_s[0])
        step[fresh] = OBSERVATIONS.between_recordings_s
        step[0] = 0.0
        t_s = own_s[0] + np.cumsum(np.maximum(step, 1e-3 * period_s))
        return Readings(
            t_s, fresh, whole.part[self.sample], whole.shift_s, ("effort",), (unit,),
            self.laid(observed)[:, None], moved.counts[self.sample, self.joint][:, None],
        )  # fmt: skip
