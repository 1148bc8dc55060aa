"""Efforts of all joints of a chain in one motion, what its model needs of them, and what of that is
a little off on any arm as built.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.observations.ahead_in_time import AheadInTime, Curves
from deltactl.diagnosis.observations.readings import FloatArray, IntArray, Layout
from deltactl.diagnosis.plants.chain.joint_motions import joint_motions, prepared
from deltactl.diagnosis.plants.left_over import LeftOver, Way
from deltactl.diagnosis.plants.lone.clear_motion import clocks_apart_s
from deltactl.diagnosis.plants.lone.force_shapes import SlowFriction
from deltactl.diagnosis.plants.lone.options import FILE_SPREADS, LONE, SERVO_JOINTS
from deltactl.diagnosis.plants.regressor import Columns
from deltactl.models.effects.chain_joints import JOINT_EFFECTS
from deltactl.models.effects.joint_friction import FRICTION_OFF, OF_LOAD, YIELDING, YIELDS_OVER
from deltactl.models.effects.payload import OF_MASS, OFF_OF_REACH
from deltactl.models.rigid_chain import BODY, RigidChain
from deltactl.models.robot import ChainRobot
from deltactl.models.signals import clipped, lagged
from deltactl.recording.tables.flat import FlatRecording


@dataclass(frozen=True, slots=True)
class ChainOptions:
    """What is usual of chains."""

    most_rows: int = 3000
    """Rows of all joints beyond which more tell nothing, as neighbours are alike."""
    fewest_poses: int = 15
    """Five numbers for each of the nine of base and target, three of which each pose gives."""
    as_built: float = 0.02
    """Share by which efforts that the model needs are off on any arm: masses of a drawing, without
    cables, grease and screws, and torque constants that change with the warmth."""
    bends: int = 2
    """Pieces of a spline by which friction grows along the way, or a torque constant in time."""
    noise: float = 0.02
    """Usual noise of an effort, as a share of its root mean square."""
    rounds: int = 4
    """In which gain and load are found in turn; the third changes a gain by less than 0.1 %."""


CHAIN = ChainOptions()


class JointEfforts(LeftOver):
    """Efforts of all joints behind one low-pass, joint after joint (n,), and their tolerances."""

    def __init__(
        self, robot: ChainRobot, recordings: Sequence[FlatRecording], chain: RigidChain,
        narrower: float,
    ):  # fmt: skip
        """narrower: as of `ChainPlant`."""
        self.robot, self.chain, self.source = robot, chain, recordings[0].source
        self._recordings = tuple(recordings)
        self.joints = chain.joints
        self.unit = "N" if all(chain.slides) else "N m"
        self.moved = moved = joint_motions(robot, prepared(robot, recordings), narrower)
        self._low_passed = moved.passed[0].low_passed
        self._motion = moved.at, moved.speed, moved.change
        self._in_time = AheadInTime(moved.whole.t_s, moved.whole.fresh)
        self._filtered = self._low_passed(moved.force)
        self._direction = self._low_passed(moved.signs)
        self._speed, self._change = map(self._low_passed, (moved.speed, moved.change))
        self._bare = chain.efforts(*self._motion)
        self._needed = self._low_passed(self._bare) + chain.friction * self._direction
        stride = max(moved.stride, -(-int(moved.counts.sum()) // CHAIN.most_rows))
        self.layout = Layout(moved.counts, ASSESSMENT.folds, stride)
        self.readings = self.layout.readings(moved.whole, moved.counts, "effort", self.unit)
        self.kinds: IntArray = self.layout.column
        self.rows: IntArray = np.flatnonzero(self.readings.valid[:, 0])
        self.own = self.kinds[:, None] == np.arange(len(self.joints))
        """Whether a row is of a joint, (n, joints)."""

    def rows_of(self, joint: int) -> IntArray:
        """Those of one joint."""
        return np.asarray(self.rows[self.own[self.rows, joint]])

    @cached_property
    def sizes(self) -> FloatArray:
        """How large efforts of each joint are here, (joints,), by their root mean square."""
        both = np.stack([self._filtered, self._needed]) ** 2
        return np.asarray(np.sqrt(np.maximum(self._usually(both), 1e-300)).max(axis=0))

    def _usually(self, values: FloatArray) -> FloatArray:
        """Means (..., joints) of values (..., m, joints) in clear motion; of all without it."""
        counts = self.moved.counts | ~self.moved.counts.any(axis=0)
        return np.asarray(np.sum(values * counts, axis=-2) / np.sum(counts, axis=0))

    def moving(self) -> list[int]:
        """Joints with rows enough in clear motion for anything to show."""
        return [j for j in range(len(self.joints)) if len(self.rows_of(j)) >= LONE.rows_a_piece]

    @property
    def usual(self) -> FloatArray:
        """Efforts of the joint that a row is of: a wrist's are a hundredth of a shoulder's."""
        return np.asarray(self.sizes[self.kinds])

    def whitened(self, columns: Sequence[Columns]) -> FloatArray:
        """Rows (m, k) of columns in their usual sizes, by the usual noise of efforts."""
        noise = CHAIN.noise * self.usual[self.rows, None]
        return np.concatenate([c.values[self.rows] * c.spread / noise for c in columns], axis=1)

    def free(self) -> Columns:
        """No findings: efforts are held between samples and filtered before they are recorded, no
        arm is built exactly as its model, and bearings yield before they slide.
        """
        chain, each = self.chain, self._each
        grips = np.hypot(YIELDING * self.sizes, chain.friction)
        tables = {
            "lag": (each(self._changing), clocks_apart_s(self.moved.whole.period_s)),
            "gain": (each(self._smooth), CHAIN.as_built),
            "dry": (each(chain.friction * self._direction), FRICTION_OFF),
            "viscous": (each(chain.damping * self._speed), FRICTION_OFF),
            "loaded": (each(self._by_load), OF_LOAD),
            "link": (self._links, CHAIN.as_built),
        }
        yielding = [self._low_passed(held) - self._direction for held in self._held]
        tables |= {f"yields {k}": (each(one * grips), 1.0) for k, one in enumerate(yielding)}
        values = np.concatenate([shapes for shapes, _ in tables.values()], axis=1)
        spread = np.repeat([spread for _, spread in tables.values()], len(self.joints))
        return Columns(values, spread, tuple(f"{name} {j}" for name in tables for j in self.joints))

    @cached_property
    def _links(self) -> FloatArray:
        """Efforts (n, joints) by the weight and inertia of each joint's own links."""
        return self.layout.laid(self._low_passed(self.chain.link_columns(*self._motion)))

    @cached_property
    def _by_load(self) -> FloatArray:
        """Friction by the load of the gear, which its links are, less that at the usual load."""
        load = np.abs(self._bare - self.chain.damping * self.moved.speed)
        return self._low_passed(np.mean(self._held, axis=0) * (load - self._usually(load)))

    @cached_property
    def _carried(self) -> FloatArray:
        """Most probable moments (10,) of a load beside all that acts at the joints.

        A drive that is off gives a share of the load's effort, too: gain times load is no sum, so
        that one of both has to be known first.
        """
        moments, spread = np.zeros(len(BODY)), np.full(len(self.joints), FILE_SPREADS.gain_share)
        left = self.layout.laid(self._filtered - self._needed)[self.rows]
        left = left / (CHAIN.noise * self.usual[self.rows])
        for _ in range(CHAIN.rounds):
            drives = Columns(self._each(self._needed + self._load_efforts @ moments), spread)
            white = self.whitened([self._load, drives, *self._acting.values()])
            known = np.eye(white.shape[1]) + white.T @ white
            size = np.linalg.solve(known, white.T @ left)
            moments = size[: len(BODY)] * self._load.spread
        return moments

    @cached_property
    def _acting(self) -> dict[str, Columns]:
        """Efforts (n, k) of all that acts at a joint or at the last link."""
        tops = np.array([one.top_speed for one in self.moved.passed])
        brisk = np.sqrt(np.maximum(self._usually(self._change**2), 1e-300))
        tables = {
            "dry": (self._direction, self.sizes),
            "viscous": (self._speed, self.sizes / tops),
            "rotor": (self._change, self.sizes / brisk),
            "offset": (np.ones_like(self._change), self.sizes),
        }
        return {
            f"{column} {joint}": Columns.of(each, spread, JOINT_EFFECTS[column].parameter)
            for column, (values, spreads) in tables.items()
            for joint, each, spread in zip(self.joints, self._each(values).T, spreads, strict=True)
        }

    @cached_property
    def _held(self) -> FloatArray:
        """Friction of 1 of bearings that yield over each way and then slide, (ways, m, joints)."""
        at, one = self.moved.at, np.ones(len(self.moved.at))
        moves = np.diff(at, axis=0, prepend=at[:1]) / np.maximum(np.ptp(at, axis=0), 1e-300)
        moves[self.moved.whole.fresh] = 0.0
        ways = ((moves / way).T for way in YIELDS_OVER)
        return np.array([np.stack([clipped(m, -one, one, 0.0) for m in way], 1) for way in ways])

    @cached_property
    def _changing(self) -> FloatArray:
        return self._in_time.curves(self._filtered).slopes

    def _since(self, joint: int, dead_s: float, time_s: float) -> FloatArray:
        """Effort of a joint less what a dead time and a time constant leave of it, (n,).

        Noise is as late, and as large: behind a time constant, too, it would be smaller, so that
        the longest would fit best.
        """
        read, smooth = self._in_time.later(self._curves[joint], -dead_s, 0.0).T
        behind = read - smooth + lagged(smooth[:, None], self.moved.whole.step_s, time_s, {})[:, 0]
        return self._at(joint, self._filtered[:, joint] - behind)

    @cached_property
    def _smooth(self) -> FloatArray:
        """Efforts (m, joints) without their noise, which no time constant may explain: a drive that
        is off shows another share of all of them.
        """
        own, ones = [self._needed, self._direction, self._speed], np.ones_like(self._needed)
        acting = np.stack([*own, self._change, ones], axis=2)
        shapes = [acting, self._in_time.curves(acting).slopes, self._load_efforts]
        rows = self.moved.counts | ~self.moved.counts.any(axis=0)
        made = np.empty_like(ones)
        for j, shape in enumerate(np.concatenate(shapes, axis=2).swapaxes(0, 1)):
            seen = shape[rows[:, j]], self._filtered[rows[:, j], j]
            made[:, j] = shape @ np.linalg.lstsq(*seen, rcond=1e-10)[0]
        return made

    def _at(self, joint: int, efforts: FloatArray) -> FloatArray:
        """Efforts (m,) of one joint, (n,)."""
        return np.where(self.own[:, joint], efforts[self.layout.sample], 0.0)

    @cached_property
    def _slow(self) -> list[SlowFriction]:
        """Friction of each joint that falls with speed."""
        pairs = zip(self.moved.passed, self.moved.signs.T, strict=True)
        return [SlowFriction(motion, way) for motion, way in pairs]

    @cached_property
    def _curves(self) -> list[Curves]:
        pairs = np.stack([self._filtered, self._smooth], axis=2)
        return [self._in_time.curves(own) for own in pairs.swapaxes(0, 1)]

    def _each(self, efforts: FloatArray) -> FloatArray:
        """Efforts (m, joints) of all joints, each by itself, (n, joints)."""
        return np.where(self.own, self.layout.laid(efforts)[:, None], 0.0)

    @cached_property
    def _load_efforts(self) -> FloatArray:
        return self._low_passed(self.chain.load_columns(*self._motion))

    @cached_property
    def _load(self) -> Columns:
        """All ten moments of a load, (n, 10): far from the flange a heavy one turns, too."""
        chain, mass = self.chain, OF_MASS * self.chain.mass_kg
        values = self.layout.laid(self._load_efforts)
        off = OFF_OF_REACH * chain.reach_m + chain.tip_m
        return Columns(values, mass * np.array([1.0] + [off] * 3 + [off**2] * 6), BODY)

    @cached_property
    def covariates(self) -> dict[str, FloatArray]:
        """Each joint's own position and velocity, the effort that it needs, and time, (n,)."""
        moved, laid = self.moved, self.layout.laid
        found = {"position": laid(moved.at), "velocity": laid(moved.speed)}
        return found | {"time": moved.whole.t_s[self.layout.sample]}

    def ways(self) -> dict[str, Way]:
        """How efforts of a joint may hang on what no effect of the vocabulary does: its own
        place, velocity and time, friction that grows along the way, a torque constant that changes
        in time, and its neighbours, with which it may share a motor.
        """
        own, found = self.covariates, {}
        braked, driven = self.layout.laid(self._direction), self.layout.laid(self._needed)
        tables = {"effort": self._filtered, "velocity": self._speed}
        for j in self.moving():
            enough = len(self.rows_of(j)) // LONE.rows_a_piece
            pieces = int(np.clip(enough, LONE.fewest_pieces, SERVO_JOINTS.joint_pieces))
            each = {name: Way(values, pieces, (name,)) for name, values in own.items()}
            follows, bends = ("position", "direction"), CHAIN.bends
            each["friction"] = Way(own["position"], bends, follows, times=braked)
            each["scale"] = Way(own["time"], bends, ("time", "effort"), times=driven)
            for other in (j - 1, j + 1):
                for what, values in tables.items() if 0 <= other < len(self.joints) else ():
                    name = f"{what}_of_{self.joints[other]}"
                    along = values[self.layout.sample, other]
                    each[name] = Way(along, 0, (name,), given=along[:, None])
            joint, off = self.joints[j], CHAIN.as_built * float(self.sizes[j])
            for name, way in each.items():
                acts = self.own[:, j]
                found[f"{joint} {name}"] = replace(way, component=joint, acts=acts, as_built=off)
        return found
