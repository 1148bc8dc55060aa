"""Where the targets on a chain are by its model and by sizes of what is wrong with it, and how that
changes with each size.

Everything is in the axes of the chain's base. The base's place in the frame of the measurements and
the targets' on their links are found with the sizes, by Gauss-Newton from a closed form (Kabsch
1976, Acta Crystallographica A32, 922-923).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from deltactl.diagnosis.observations.readings import BoolArray, FloatArray
from deltactl.diagnosis.plants.chain.pose_readings import Poses
from deltactl.foundation.scatter import MAD_TO_SIGMA
from deltactl.models.rigid_chain import Placed, RigidChain
from deltactl.models.robot import ChainRobot

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

    @property
    def count(self) -> int:
        """Sizes."""
        parts = [*self.angles.values(), *self.before.values(), *self.about.values()]
        return int(parts[0].shape[-1])


Shapes = dict[str, Shape]


@dataclass(eq=False)
class Setup:
    """Bases (parts, 3, 3) and (parts, 3), targets (k, 3) on their links, and the orientation (3, 3)
    of what measures it on the last link.
    """

    turns: FloatArray
    shifts: FloatArray
    tools: FloatArray
    hand: FloatArray

    @classmethod
    def of(cls, robot: ChainRobot, poses: Poses) -> Setup:
        """As the robot file has it."""
        parts = int(poses.part.max()) + 1
        nowhere = (0.0, 0.0, 0.0)
        turn = Rotation.from_euler("xyz", robot.base.get("rpy", nowhere)).as_matrix()
        shift = np.array(robot.base.get("xyz", nowhere))
        tools = [robot.targets[t].xyz if t in robot.targets else (0, 0, 0) for t in poses.targets]
        return cls(
            np.tile(turn, (parts, 1, 1)), np.tile(shift, (parts, 1)),
            np.array(tools, dtype=float), np.eye(3),
        )  # fmt: skip


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
    """Measured poses beside the model."""

    def __init__(self, robot: ChainRobot, chain: RigidChain, poses: Poses):
        self.chain, self.poses = chain, poses
        self.setup = Setup.of(robot, poses)
        self.placed_well = robot.placement == "known"
        links = [robot.targets[t].link if t in robot.targets else "" for t in poses.targets]
        self.links = [*(chain.moving_link(link) for link in links), chain.tip]
        self.carried = np.array([chain.carries(link) for link in self.links])
        self.channels = 3 * len(poses.targets) + 3 * (poses.turned is not None)
        self.given: list[tuple[Shape, FloatArray]] = []
        """What effects of the robot file change, with its sizes."""

    @property
    def valid(self) -> BoolArray:
        """Which channels were read, (n, channels)."""
        seen = np.isfinite(self.poses.places).reshape(len(self.poses.at), -1)
        if self.poses.turned is None:
            return seen
        return np.concatenate([seen, np.isfinite(self.poses.turned)], axis=1)

    # ---- the model at some sizes ---------------------------------------------------------------

    def at(self, shapes: Shapes, sizes: Mapping[str, FloatArray]) -> At:
        """The chain with these sizes and the present setup."""
        angles, off = self.poses.at.copy(), np.zeros((len(self.chain.joints), 6))
        acting = [*self.given, *((shapes[key], size) for key, size in sizes.items())]
        for shape, size in acting:
            for joint, change in shape.angles.items():
                angles[:, joint] += change @ size
            for joint, change in shape.before.items():
                off[joint] += change @ size
        placed = self.chain.placed(angles, self.links, off)
        points = placed.links + np.einsum("nkij,kj->nki", placed.frames, self._tools)
        arms = points[:, :, None] - placed.anchors[:, None]
        arms = arms * self.carried[None, :, :, None]
        found = At(self._left(placed, points), placed, points[:, :-1], arms)
        for shape, size in acting:
            for joint, about in shape.about.items():
                found.left[:] -= self._turned(found, joint, about) @ size
        return found

    @property
    def _tools(self) -> FloatArray:
        return np.concatenate([self.setup.tools, np.zeros((1, 3))])

    def _left(self, placed: Placed, points: FloatArray) -> FloatArray:
        turn, shift = self.setup.turns[self.poses.part], self.setup.shifts[self.poses.part]
        seen = np.einsum("nji,nkj->nki", turn, self.poses.places - shift[:, None])
        left = (seen - points[:, :-1]).reshape(len(points), -1)
        if self.poses.turned is None:
            return np.asarray(left)
        read = Rotation.from_rotvec(np.nan_to_num(self.poses.turned)).as_matrix()
        apart = (
            np.swapaxes(turn, 1, 2)
            @ read
            @ np.swapaxes(placed.frames[:, -1] @ self.setup.hand, 1, 2)
        )
        turned = LEVER_M * Rotation.from_matrix(apart).as_rotvec()
        turned[~np.isfinite(self.poses.turned).all(axis=1)] = np.nan
        return np.concatenate([left, turned], axis=1)

    # ---- columns -------------------------------------------------------------------------------

    def _moves(self, shift: FloatArray, turn: FloatArray) -> FloatArray:
        """Channels (n, channels, k) of displacements (n, targets, 3, k) and turns (n, 3, k)."""
        made = shift.reshape(len(shift), -1, shift.shape[-1])
        return made if self.poses.turned is None else np.concatenate([made, LEVER_M * turn], axis=1)

    def _turned(self, at: At, joint: int, about: FloatArray) -> FloatArray:
        """By rotations (n, 3, k) at a joint."""
        arms = at.arms[:, :-1, joint]
        shift = np.cross(about[:, None], arms[..., None], axisa=2, axisb=2, axisc=2)
        return self._moves(shift, about * self.carried[-1, joint])

    def _shifted(self, at: At, joint: int, along: FloatArray) -> FloatArray:
        """By displacements (n, 3, k) at a joint."""
        shift = along[:, None] * self.carried[None, :-1, joint, None, None]
        return self._moves(shift, np.zeros_like(along))

    def jacobian(self, at: At, joint: int) -> FloatArray:
        """Channels (n, channels) by one joint's position."""
        axis = at.placed.axes[:, joint, :, None]
        slides = self.chain.slides[joint]
        found = self._shifted(at, joint, axis) if slides else self._turned(at, joint, axis)
        return np.asarray(found[..., 0])

    def column(self, at: At, shapes: Shapes, key: str) -> FloatArray:
        """Channels (n, channels, k) by the sizes of a key."""
        angles, before, about = shapes[key].angles, shapes[key].before, shapes[key].about
        parts = [self.jacobian(at, j)[:, :, None] * shape[:, None] for j, shape in angles.items()]
        parts += [self.geometry(at, j) @ change for j, change in before.items()]
        parts += [self._turned(at, j, each) for j, each in about.items()]
        return np.asarray(sum(parts))

    def geometry(self, at: At, joint: int) -> FloatArray:
        """Channels (n, channels, 6) by the fixed transform before a joint."""
        frame = at.placed.parents[:, joint]
        return np.concatenate(
            [self._shifted(at, joint, frame), self._turned(at, joint, frame)], axis=2
        )

    def placing(self, at: At) -> dict[str, FloatArray]:
        """Channels (n, channels, k) by the base's placement in each recording and the targets'."""
        unit = np.broadcast_to(np.eye(3), (len(at.points), 3, 3))
        shift = np.cross(unit[:, None], at.points[..., None], axisa=2, axisb=2, axisc=2)
        whole = np.concatenate(
            [
                self._moves(np.broadcast_to(unit[:, None], (*at.points.shape, 3)), 0.0 * unit),
                self._moves(shift, unit),
            ],
            axis=2,
        )
        parts = range(len(self.setup.turns))
        made = {f"base {p}": whole * (self.poses.part == p)[:, None, None] for p in parts}
        for k in range(len(self.poses.targets)):
            only = (np.arange(len(self.poses.targets)) == k)[None, :, None, None]
            made[f"tool {k}"] = self._moves(at.placed.frames[:, :-1] * only, 0.0 * unit)
        if self.poses.turned is not None:
            none = np.zeros((*at.points.shape, 3))
            made["hand"] = self._moves(none, at.placed.frames[:, -1])
        return made

    # ---- base, targets and sizes at their best -------------------------------------------------

    def place(self, shapes: Shapes, sizes: Mapping[str, FloatArray]) -> None:
        """Find base and targets at these sizes, from anywhere."""
        placed = self.at(shapes, sizes).placed
        for _ in range(0 if self.placed_well else ROUNDS):
            points = placed.links + np.einsum("nkij,kj->nki", placed.frames, self._tools)
            for part in range(len(self.setup.turns)):
                own = self.poses.part == part
                known = own[:, None] & np.isfinite(self.poses.places).all(axis=2)
                there, seen = points[:, :-1][known], self.poses.places[known]
                middle, centre = there.mean(axis=0), seen.mean(axis=0)
                turn = Rotation.align_vectors(seen - centre, there - middle)[0].as_matrix()
                self.setup.turns[part], self.setup.shifts[part] = turn, centre - turn @ middle
            self._targets(placed)
        if self.poses.turned is not None:
            read = Rotation.from_rotvec(np.nan_to_num(self.poses.turned)).as_matrix()
            turn = self.setup.turns[self.poses.part]
            known = np.isfinite(self.poses.turned).all(axis=1)
            each = np.swapaxes(turn @ placed.frames[:, -1], 1, 2) @ read
            self.setup.hand = Rotation.from_matrix(each[known]).mean().as_matrix()
        self.settle(shapes, {key: np.asarray(size) for key, size in sizes.items()}, {}, ())

    def _targets(self, placed: Placed) -> None:
        """The targets at their best, the base held."""
        turn, shift = self.setup.turns[self.poses.part], self.setup.shifts[self.poses.part]
        for k in range(len(self.poses.targets)):
            seen = np.einsum("nji,nj->ni", turn, self.poses.places[:, k] - shift)
            off = np.einsum("nji,nj->ni", placed.frames[:, k], seen - placed.links[:, k])
            self.setup.tools[k] = np.nanmedian(off, axis=0)

    def settle(
        self, shapes: Shapes, sizes: Mapping[str, FloatArray], spreads: Mapping[str, FloatArray],
        keys: Sequence[str],
    ) -> tuple[dict[str, FloatArray], At]:  # fmt: skip
        """The most probable sizes of some keys with base and targets, each step linearised anew.

        spreads: of the sizes beyond those of the robot file.
        """
        found = {key: np.array(size, dtype=float) for key, size in sizes.items()}
        for key in keys:
            found.setdefault(key, np.zeros(shapes[key].count))
        at = self.at(shapes, found)
        for _ in range(ROUNDS):
            placing = self.placing(at)
            columns = [*placing.values(), *(self.column(at, shapes, key) for key in keys)]
            matrix = np.concatenate(columns, axis=2)[self.valid]
            ends = np.cumsum([0, *(c.shape[2] for c in columns)])
            prior, pulled = np.zeros(ends[-1]), np.zeros(ends[-1])
            names = [*placing, *keys]
            for name, first, end in zip(names, ends, ends[1:], strict=False):
                if name in keys:
                    prior[first:end] = spreads[name] ** -2.0
                    pulled[first:end] = -found[name] * prior[first:end]
            step = _step(matrix, at.left[self.valid], prior, pulled)
            for name, first, end in zip(names, ends, ends[1:], strict=False):
                self._take(name, step[first:end], found)
            at = self.at(shapes, found)
            if float(np.sqrt(np.mean((matrix @ step) ** 2))) < SETTLED_M:
                break
        return found, at

    def _take(self, name: str, step: FloatArray, sizes: dict[str, FloatArray]) -> None:
        stem, _, number = name.partition(" ")
        if stem == "base":
            turn = self.setup.turns[int(number)]
            self.setup.shifts[int(number)] += turn @ step[:3]
            self.setup.turns[int(number)] = turn @ Rotation.from_rotvec(step[3:]).as_matrix()
        elif stem == "tool":
            self.setup.tools[int(number)] += step
        elif stem == "hand":
            self.setup.hand = Rotation.from_rotvec(step).as_matrix() @ self.setup.hand
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
