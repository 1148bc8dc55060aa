"""A network for a robot whose file knows effects: it learns the exact inverse of what is known.

Three small networks side by side, as for a calibrated robot; their teacher is the closed form with
lengths, directions, homes, gears and compliance as the file says, turned round.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from deltactl.foundation.errors import NetworkError
from deltactl.foundation.process import one_thread
from deltactl.models.calibrated_inverse import CalibratedInverse, corrections_of
from deltactl.models.network.metadata import Box, Cylinder
from deltactl.models.robot import FloatArray
from deltactl.models.training.arm_networks import train_arms
from deltactl.models.training.export import HeldOut, Origin, data_to_file
from deltactl.models.training.recipe import Follow, Settings, Task, Trained, unseen
from deltactl.models.training.samples import edges, spread
from deltactl.models.training.train import Written, check_writable

RECIPE = "corrected"
EFFORT = Settings(
    hidden=(16, 16), spread=2000, edge=1000, iterations=300, rounds=1, iterations_a_round=60
)
BEYOND = 0.01
"""Positions this share of the domain's size beyond it are learned too: its edge is not theirs."""
JUDGES = 2000
FEWEST = 500


@one_thread
def train_corrected(
    task: Task, path: Path, effort: Settings = EFFORT, follow: Follow = unseen
) -> Written:
    """Train for the effects in the task's robot file, over its domain, and write the network.

    Raises NetworkError when hardly any of the domain can be reached or the disk is full.
    """
    check_writable(path)
    robot, teacher = task.robot, CalibratedInverse(task.robot)
    rng = np.random.default_rng(task.seed)
    wide = _wider(task.domain)
    asked_m = np.concatenate([spread(wide, rng, effort.spread), edges(wide, rng, effort.edge)])
    exact_m, exact_rad = _reached(task, teacher, asked_m)
    graph, source, result, parameters = train_arms(
        teacher.linkage, exact_m, exact_rad, effort, task.seed, follow
    )
    sizes = "-".join(map(str, (3, *effort.hidden, 1)))
    known = corrections_of(robot)
    trained = Trained(
        graph=graph,
        source=source,
        result=result,
        recipe=RECIPE,
        architecture=f"{sizes} tanh, one an arm, of a corrected robot",
        parameters=parameters,
        samples=len(exact_m),
        settings=effort.as_metadata(),
        seed=task.seed,
        remarks=(("takes into account", ", ".join(teacher.effects) or "nothing but lengths"),),
        effects=known,
    )
    held = HeldOut(*_reached(task, teacher, spread(task.domain, rng, JUDGES)))
    words = f"exact inverse of {robot.name} with {len(known)} known effects"
    file = data_to_file(path, trained, task, Origin(words), held)
    return Written(file, trained)


def _reached(
    task: Task, teacher: CalibratedInverse, asked_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Those of the positions that can be had, with their commanded angles."""
    angles_rad = teacher.angles_rad_at_once(asked_m)
    good = np.isfinite(angles_rad).all(axis=1)
    good[good] = task.learns(angles_rad[good])
    if good.sum() < FEWEST:
        raise NetworkError(
            f"robot '{task.robot.name}' with its effects reaches hardly any of "
            f"{task.domain.describe()}; make the domain smaller, or look at the effects"
        )
    return asked_m[good], angles_rad[good]


def _wider(domain: Cylinder | Box) -> Cylinder | Box:
    low_m, high_m = domain.bounding_box()
    by_m = BEYOND * float((high_m - low_m).max())
    if isinstance(domain, Cylinder):
        (low, high), radius_m = domain.z_m, domain.radius_m + by_m
        return Cylinder(radius_m=radius_m, z_m=(low - by_m, high + by_m))
    pairs = zip((low_m - by_m).tolist(), (high_m + by_m).tolist(), strict=True)
    x, y, z = ((low, high) for low, high in pairs)
    return Box(x_m=x, y_m=y, z_m=z)


def with_iterations(effort: Settings, iterations: int | None) -> Settings:
    """Another number of iterations, if one is given."""
    if iterations is None:
        return effort
    return replace(effort, iterations=iterations, iterations_a_round=max(iterations // 5, 1))
