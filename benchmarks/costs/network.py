"""What one target costs: the network alone, and the whole way to checked step counts.

`python benchmarks/costs/network.py`: microseconds, one thread, each call timed by itself (the
clock's own cost, about 0.05 us, is included). Limits of the project: one network call 6 us,
one whole target 25 us, both at the median.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from deltactl.models.inverse_kinematics import GeometricInverse, TargetMapper
from deltactl.models.linkage import Linkage, inverse
from deltactl.models.network import Cylinder, InverseNetwork, NetworkFile
from deltactl.models.network.file import TRAINED_FOLDER
from deltactl.models.network.inverse import runtime_names
from deltactl.models.robot import DeltaRobot
from deltactl.models.robot_files import load_delta

CONFIG_FOLDER = Path(__file__).resolve().parents[2] / "config"
CYLINDER = Cylinder(radius_m=0.15, z_m=(-0.55, -0.40))
ARM_LIMITS_DEG = (-20.0, 110.0)
CALL_LIMIT_US, TARGET_LIMIT_US = 6.0, 25.0

Call = Callable[[float, float, float], Any]


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="cost of one target")
    parser.add_argument("--targets", type=int, default=20_000)
    count = parser.parse_args(arguments).targets
    robot = load_delta(CONFIG_FOLDER / "zhao-2023.yaml")
    targets_m = _targets(count)
    table = Table(title=f"One target, {runtime_names()[0]}, {count} targets")
    for column in ("", "p50 us", "p99 us", "limit us"):
        table.add_column(column, justify="left" if not column else "right")
    for name, call, limit_us in _subjects(robot):
        p50_us, p99_us = np.percentile(_time_us(call, targets_m), (50, 99))
        limit = f"{limit_us:g}" if limit_us else ""
        table.add_row(name, f"{p50_us:.2f}", f"{p99_us:.2f}", limit)
    Console().print(table)


def _subjects(robot: DeltaRobot) -> list[tuple[str, Call, float | None]]:
    shipped = InverseNetwork.open(TRAINED_FOLDER / "zhao-2023.tflite", robot)
    geometry = GeometricInverse(robot.geometry)
    assert robot.drive is not None
    linkage = Linkage.of(robot.geometry)
    subjects: list[tuple[str, Call, float | None]] = [
        (f"network as shipped ({shipped.metadata.parameters})", shipped.angles_rad, CALL_LIMIT_US)
    ]
    subjects += [(name, network.angles_rad, CALL_LIMIT_US) for name, network in _peers(robot)]
    for name, kinematics in (("network", shipped), ("geometry", geometry)):
        mapper = TargetMapper(kinematics, robot.drive, ARM_LIMITS_DEG)
        subjects.append((f"target to counts, {name}", mapper.counts, TARGET_LIMIT_US))
    subjects.append(("geometry, plain floats", geometry.angles_rad, None))
    subjects.append(
        ("geometry, numpy", lambda x, y, z: inverse(linkage, np.array([x, y, z])), None)
    )
    return subjects


def _peers(robot: DeltaRobot) -> list[tuple[str, InverseNetwork]]:
    """The papers' networks with random weights; empty without the training extra."""
    try:
        from deltactl.models.training.export import Effort, to_file
        from deltactl.models.training.graph import Graph
        from deltactl.models.training.perceptron import Perceptron, add_layers
        from deltactl.models.training.recipe import Task, Trained
    except ImportError:
        return []
    found = []
    networks = (
        ("Zhao 8x50 sigmoid", Perceptron((3, *[50] * 8, 3), "sigmoid")),
        ("Uzunovic 3-25-3 tanh", Perceptron((3, 25, 3), "tanh")),
    )
    for name, network in networks:
        graph = Graph()
        source = graph.input("position_m", (1, 3))
        layers = network.layers(network.start(np.random.default_rng(0)))
        result = add_layers(graph, source, layers, network.activation)
        trained = Trained(graph, source, result, "random", name, network.parameters, samples=0)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "peer.tflite"
            to_file(path, trained, Task(robot, CYLINDER, seed=0), Effort(10, 0))
            found.append((f"{name} ({network.parameters})", InverseNetwork(NetworkFile.load(path))))
    return found


def _targets(count: int) -> list[list[float]]:
    rng = np.random.default_rng(0)
    low_m, high_m = CYLINDER.bounding_box()
    targets: list[list[float]] = CYLINDER.clip(rng.uniform(low_m, high_m, (count, 3))).tolist()
    return targets


def _time_us(call: Call, targets_m: list[list[float]]) -> list[float]:
    clock, spent = time.perf_counter_ns, []
    for x_m, y_m, z_m in targets_m:
        start_ns = clock()
        call(x_m, y_m, z_m)
        spent.append((clock() - start_ns) / 1000.0)
    return spent


if __name__ == "__main__":
    main()
