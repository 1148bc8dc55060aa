"""Where the targets on a chain are by its model and by sizes of what is wrong with it, and how that
changes with each size.

Everything is in the axes of the chain's base. The base's place in the frame of the measurements and
the targets' on their links are found with the sizes, by Gauss-Newton from a closed form (Kabsch
1976, Acta Crystallographica A32, 922-923).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from deltactl.diagnosis.observations.readings import BoolArray, FloatArray
from deltactl.diagnosis.plants.chain.pose_readings import Poses
from deltactl.foundation.scatter import MAD_TO_SIGMA
from deltactl.models.rigid_chain import Placed, RigidChain
from deltactl.models.robot import ChainRobot, Target

LEVER_M = 0.1
"""Orientations count as displacements at this distance: trackers read both about as well there."""
ROUNDS = 30
SETTLED_M = 1e-8
FINEST_M = 1e-7
"""No tracker is finer."""
HUBER = 3.0
"""Standard deviations beyond which a reading counts less."""


@dataclass(eq=False)
class Shape:
    """What the sizes (k,) of one error change. angles: joint -> (n, k) its position. before: joint
    -> (6, k) the transform before it. about: joint -> (n, 3, k) a rotation at it.
    """

    angles: dict[int, FloatArray] = field(default_factory=dict)
    before: dict[int, FloatArray] = field(default_factory=dict)
    about: dict[int, FloatArray] = field(default_factory=dict)
    acts: bool = True
    """Whether it changes anything in these poses."""

    @property
    def count(self) -> int:
        """Sizes."""
        first, *_ = [*self.angles.values(), *self.before.values(), *self.about.values()]
        return int(first.shape[-1])


@dataclass(frozen=True, eq=False)
class At:
    """The chain at some sizes: residual (n, channels) [m] and what columns are made of."""

    left: FloatArray
    placed: Placed
    points: FloatArray
    """Targets, (n, k, 3)."""
    arms: FloatArray
    """From each joint's anchor to each target, (n, k, joints, 3); 0 where it is not moved."""


class PoseModel:
    """Measured poses beside the model.

    turns (parts, 3, 3) and shifts (parts, 3): of the base in each recording. tools (k, 3): targets
    on their links. hand (3, 3): orientation on the last link of what measures it.
    """

    def __init__(self, robot: ChainRobot, chain: RigidChain, poses: Poses):
        """Placed as the robot file has it."""
        self.chain, self.poses = chain, poses
        parts, nowhere = int(poses.part.max()) + 1, (0.0, 0.0, 0.0)
        turn = Rotation.from_euler("xyz", robot.base.get("rpy", nowhere)).as_matrix()
        self.turns = np.tile(turn, (parts, 1, 1))
        self.shifts = np.tile(robot.base.get("xyz", nowhere), (parts, 1))
        targets = [robot.targets.get(t, Target(link="", xyz=nowhere)) for t in poses.targets]
        self.tools, self.hand = np.array([one.xyz for one in targets], dtype=float), np.eye(3)
        self.placed_well = robot.placement == "known"
        self.links = [*(chain.moving_link(one.link) for one in targets), chain.tip]
        self.carried = np.array([chain.carries(link) for link in self.links])
        self.turns_seen = poses.turned.shape[1] > 0
        self.shapes: dict[str, Shape] = {}
        """All that may be wrong."""
        self.given: list[tuple[Shape, FloatArray]] = []
        """What effects of the robot file change, with its sizes."""

    @property
    def valid(self) -> BoolArray:
        """Which channels were read, (n, channels)."""
        seen = np.isfinite(self.poses.places).reshape(len(self.poses.at), -1)
        return np.concatenate([seen, np.isfinite(self.poses.turned)], axis=1)

    # ---- the model at some sizes ---------------------------------------------------------------

    def at(self, sizes: Mapping[str, FloatArray]) -> At:
        """The chain with these sizes and the present setup."""
        angles, off = self.poses.at.copy(), np.zeros((len(self.chain.joints), 6))
        acting = [*self.given, *((self.shapes[key], size) for key, size in sizes.items())]
        for shape, size in acting:
            for joint, change in shape.angles.items():
                angles[:, joint] += change @ size
            for joint, change in shape.before.items():
                off[joint] += change @ size
        placed = self.chain.placed(angles, self.links, off)
        points = self._points(placed)
        arms = points[:, :, None] - placed.anchors[:, None]
        arms = arms * self.carried[None, :, :, None]
        found = At(self._left(placed, points), placed, points[:, :-1], arms)
        for shape, size in acting:
            for joint, about in shape.about.items():
                found.left[:] -= self._twisted(found, joint, 0.0 * about, about) @ size
        return found

    def _points(self, placed: Placed) -> FloatArray:
        """Targets and the end of the last link, (n, k + 1, 3)."""
        tools = np.concatenate([self.tools, np.zeros((1, 3))])
        return np.asarray(placed.links + np.einsum("nkij,kj->nki", placed.frames, tools))

    def _seen(self) -> FloatArray:
        """Targets in the axes of the base as they were measured, (n, k, 3)."""
        turn, shift = self.turns[self.poses.part], self.shifts[self.poses.part]
        return np.asarray(np.einsum("nji,nkj->nki", turn, self.poses.places - shift[:, None]))

    def _left(self, placed: Placed, points: FloatArray) -> FloatArray:
        left: FloatArray = (self._seen() - points[:, :-1]).reshape(len(points), -1)
        if not self.turns_seen:
            return left
        turn, hand = self.turns[self.poses.part], placed.frames[:, -1] @ self.hand
        apart = np.swapaxes(turn, 1, 2) @ self._read_turns @ np.swapaxes(hand, 1, 2)
        turned = LEVER_M * Rotation.from_matrix(apart).as_rotvec()
        turned[~np.isfinite(self.poses.turned).all(axis=1)] = np.nan
        return np.concatenate([left, turned], axis=1)

    @cached_property
    def _read_turns(self) -> FloatArray:
        """Orientations that were measured, (n, 3, 3); any where none was."""
        return np.asarray(Rotation.from_rotvec(np.nan_to_num(self.poses.turned)).as_matrix())

    # ---- columns -------------------------------------------------------------------------------

    def _moves(self, shift: FloatArray, turn: FloatArray) -> FloatArray:
        """Channels (n, channels, k) of displacements (n, targets, 3, k) and turns (n, 3, k)."""
        made = shift.reshape(len(shift), -1, shift.shape[-1])
        return np.concatenate([made, LEVER_M * turn], axis=1) if self.turns_seen else made

    def _twisted(self, at: At, joint: int, shift: FloatArray, turn: FloatArray) -> FloatArray:
        """By displacements and rotations (n, 3, k) at a joint."""
        arms, carried = at.arms[:, :-1, joint], self.carried[:, joint]
        moved = shift[:, None] * carried[None, :-1, None, None]
        moved = moved + np.cross(turn[:, None], arms[..., None], axisa=2, axisb=2, axisc=2)
        return self._moves(moved, turn * carried[-1])

    def jacobian(self, at: At, joint: int) -> FloatArray:
        """Channels (n, channels) by one joint's position."""
        axis, slides = at.placed.axes[:, joint, :, None], float(self.chain.slides[joint])
        return self._twisted(at, joint, slides * axis, (1.0 - slides) * axis)[..., 0]

    def column(self, at: At, key: str) -> FloatArray:
        """Channels (n, channels, k) by the sizes of a key."""
        one = self.shapes[key]
        parts = [self.jacobian(at, j)[:, :, None] * q[:, None] for j, q in one.angles.items()]
        parts += [self.geometry(at, j) @ change for j, change in one.before.items()]
        parts += [self._twisted(at, j, 0.0 * about, about) for j, about in one.about.items()]
        return np.asarray(sum(parts))

    def geometry(self, at: At, joint: int) -> FloatArray:
        """Channels (n, channels, 6) by the fixed transform before a joint."""
        frame = at.placed.parents[:, joint]
        still = np.zeros_like(frame)
        shift, turn = ([frame, still], [still, frame])
        return self._twisted(at, joint, np.concatenate(shift, 2), np.concatenate(turn, 2))

    def placing(self, at: At) -> dict[str, FloatArray]:
        """Channels (n, channels, k) by the base's placement in each recording and the targets'."""
        unit = np.broadcast_to(np.eye(3), (len(at.points), 3, 3))
        shift = np.cross(unit[:, None], at.points[..., None], axisa=2, axisb=2, axisc=2)
        along = np.broadcast_to(unit[:, None], shift.shape)
        whole = np.concatenate([self._moves(along, 0.0 * unit), self._moves(shift, unit)], axis=2)
        parts = range(len(self.turns))
        made = {f"base {p}": whole * (self.poses.part == p)[:, None, None] for p in parts}
        for k in range(len(self.poses.targets)):
            only = (np.arange(len(self.poses.targets)) == k)[None, :, None, None]
            made[f"tool {k}"] = self._moves(at.placed.frames[:, :-1] * only, 0.0 * unit)
        if self.turns_seen:
            made["hand"] = self._moves(np.zeros_like(shift), at.placed.frames[:, -1])
        return made

    # ---- base, targets and sizes at their best -------------------------------------------------

    def place(self, sizes: Mapping[str, FloatArray]) -> At:
        """The chain at these sizes with base and targets at their best, from anywhere."""
        placed = self.at(sizes).placed
        for _ in range(0 if self.placed_well else ROUNDS):
            points = self._points(placed)
            for part in range(len(self.turns)):
                own = self.poses.part == part
                known = own[:, None] & np.isfinite(self.poses.places).all(axis=2)
                there, seen = points[:, :-1][known], self.poses.places[known]
                middle, centre = there.mean(axis=0), seen.mean(axis=0)
                turn = Rotation.align_vectors(seen - centre, there - middle)[0].as_matrix()
                self.turns[part], self.shifts[part] = turn, centre - turn @ middle
            off = self._seen() - placed.links[:, :-1]
            there = np.einsum("nkji,nkj->nki", placed.frames[:, :-1], off)
            self.tools = np.nanmedian(there, axis=0)
        if self.turns_seen:
            last = self.turns[self.poses.part] @ placed.frames[:, -1]
            known = np.isfinite(self.poses.turned).all(axis=1)
            each = np.swapaxes(last, 1, 2) @ self._read_turns
            self.hand = Rotation.from_matrix(each[known]).mean().as_matrix()
        return self.settle(sizes, {})[1]

    def settle(
        self, sizes: Mapping[str, FloatArray], spreads: Mapping[str, FloatArray]
    ) -> tuple[dict[str, FloatArray], At]:
        """The most probable sizes with base and targets, each step linearised anew.

        spreads: of the sizes to be found, beyond those of the robot file; other `sizes` are held.
        """
        found = {key: np.zeros(len(spread)) for key, spread in spreads.items()} | dict(sizes)
        at = self.at(found)
        for _ in range(ROUNDS):
            placing = self.placing(at)
            parts = placing | {key: self.column(at, key) for key in spreads}
            matrix = np.concatenate([*parts.values()], axis=2)[self.valid]
            anywhere = np.zeros(sum(one.shape[2] for one in placing.values()))
            prior = np.concatenate([anywhere, *(one**-2.0 for one in spreads.values())])
            now = np.concatenate([anywhere, *(found[key] for key in spreads)])
            step = _step(matrix, at.left[self.valid], prior, -now * prior)
            ends = np.cumsum([part.shape[2] for part in parts.values()])
            for name, own in zip(parts, np.split(step, ends[:-1]), strict=True):
                self._take(name, own, found)
            at = self.at(found)
            if float(np.sqrt(np.mean((matrix @ step) ** 2))) < SETTLED_M:
                break
        return found, at

    def _take(self, name: str, step: FloatArray, sizes: dict[str, FloatArray]) -> None:
        stem, _, number = name.partition(" ")
        if stem == "base":
            part, turn = int(number), self.turns[int(number)]
            self.shifts[part] += turn @ step[:3]
            self.turns[part] = turn @ Rotation.from_rotvec(step[3:]).as_matrix()
        elif stem == "tool":
            self.tools[int(number)] += step
        elif stem == "hand":
            self.hand = Rotation.from_rotvec(step).as_matrix() @ self.hand
        else:
            sizes[name] = sizes[name] + step


def _step(
    matrix: FloatArray, left: FloatArray, prior: FloatArray, pulled: FloatArray
) -> FloatArray:
    """A Gauss-Newton step with Huber's weights, and priors where they are given."""
    weight = np.full(len(left), FINEST_M**-2.0)
    for _ in range(3):
        gram = matrix.T @ (matrix * weight[:, None]) + np.diag(prior)
        right = matrix.T @ (weight * left) + pulled
        scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
        step = scale * np.linalg.lstsq(gram * np.outer(scale, scale), scale * right, rcond=1e-10)[0]
        rest = np.abs(left - matrix @ step)
        sigma = max(MAD_TO_SIGMA * float(np.median(rest)), FINEST_M)
        weight = np.minimum(1.0, HUBER * sigma / np.maximum(rest, 1e-12)) / sigma**2
    return np.asarray(step)
