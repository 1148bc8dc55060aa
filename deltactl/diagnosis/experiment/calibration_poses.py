"""Poses in which a chain should be measured: those that together tell most of its errors.

D-optimal design (Fedorov 1972, Theory of Optimal Experiments) among poses drawn within the limits
of the joints: each pose is taken that adds most to the information, then each is exchanged once for
a better one. For calibration the same measure is called an observability index (Sun and Hollerbach
2008, Proc. IEEE ICRA, 831-836).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.chain.pose_model import PoseModel
from deltactl.diagnosis.plants.chain.pose_readings import Poses
from deltactl.diagnosis.plants.chain.pose_shapes import PoseShapes
from deltactl.models.rigid_chain import RigidChain
from deltactl.models.robot import ChainRobot, Target

CANDIDATES = 20
"""Poses that are drawn for each that is wanted."""
WITHIN = 0.95
"""Share of the joints' ranges that is used."""
NOISE_M = 5e-5
"""A laser tracker has this over some metres."""
OFF_M = 0.1
"""The reflector is so far along each axis of the last link, where the robot file does not say: one
on a joint's axis would not show that joint."""
PLACED_M = 1.0
"""How well base and reflector are known before."""


def calibration_poses(robot: ChainRobot, chain: RigidChain, count: int) -> FloatArray:
    """Positions (count, joints) [rad or m], in the order in which to visit them.

    Whether the arm meets itself or anything else there is not looked at.
    """
    rng = np.random.default_rng(0)
    low, high = chain.limits
    middle, half = 0.5 * (low + high), 0.5 * WITHIN * (high - low)
    drawn = middle + half * rng.uniform(-1.0, 1.0, (CANDIDATES * count, len(low)))
    told = _information(robot, chain, drawn)
    chosen = _chosen(told, count)
    poses: FloatArray = drawn[rng.permutation(chosen)]
    return poses


def _information(robot: ChainRobot, chain: RigidChain, at: FloatArray) -> FloatArray:
    """Change (n, channels, p) of what is measured by all that may be wrong, each in its usual size
    and in standard deviations of the noise.
    """
    targets = robot.targets or {"pos": Target(link=chain.tip, xyz=(OFF_M,) * 3)}
    robot = robot.model_copy(update={"targets": targets})
    count, nothing = len(at), np.zeros_like(at)
    places = np.zeros((count, len(targets), 3))
    part, t_s = np.zeros(count, dtype=np.intp), np.arange(count, dtype=float)
    poses = Poses(at, nothing, tuple(targets), places, at[:, :0], part, nothing, t_s)
    model = PoseModel(robot, chain, poses)
    shapes = PoseShapes(robot, model)
    placed = model.at({})
    shapes.find_directions(placed)
    errors = (model.column(placed, key) * shapes.spread(key) for key in shapes.named)
    placings = (PLACED_M * one for one in model.placing(placed).values())
    told: FloatArray = np.concatenate([*placings, *errors], axis=2) / NOISE_M
    return told


def _chosen(told: FloatArray, count: int) -> list[int]:
    """Numbers of the poses that together tell most."""
    known = np.eye(told.shape[2])
    chosen: list[int] = []
    for _ in range(count):
        chosen.append(_best(told, known, chosen))
        known = known + told[chosen[-1]].T @ told[chosen[-1]]
    for place, pose in enumerate(list(chosen)):
        rest = known - told[pose].T @ told[pose]
        chosen[place] = _best(told, rest, [*chosen[:place], *chosen[place + 1 :]])
        known = rest + told[chosen[place]].T @ told[chosen[place]]
    return chosen


def _best(told: FloatArray, known: FloatArray, taken: Iterable[int]) -> int:
    """The pose that adds most to the logarithm of the determinant of the information."""
    spread = told @ np.linalg.inv(known)
    added = np.eye(told.shape[1]) + spread @ np.swapaxes(told, 1, 2)
    gain = np.linalg.slogdet(added)[1]
    gain[list(taken)] = -np.inf
    return int(np.argmax(gain))
