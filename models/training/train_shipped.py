"""Train the networks in `models/trained`: `python -m deltactl.models.training.train_shipped`.

Two minutes. The same seed gives the same file on the same machine, libraries and number of
threads (the shipped ones: OPENBLAS_NUM_THREADS=1, which is also as fast); elsewhere sums are
rounded in another order, and the file differs but is as good.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from deltactl.foundation.process import PACKAGE
from deltactl.models.network.file import TRAINED_FOLDER, NetworkFile
from deltactl.models.network.metadata import Box, Cylinder, Range
from deltactl.models.robot_files import load_delta
from deltactl.models.training import arm_networks
from deltactl.models.training.export import to_file
from deltactl.models.training.recipe import Progress, Settings, Task

CONFIG_FOLDER = PACKAGE / "config"


@dataclass(frozen=True)
class Shipped:
    """One shipped network: its robot file, the region it serves, and the effort."""

    robot: str
    domain: Cylinder | Box
    seed: int
    angle_deg: Range
    settings: Settings = field(default_factory=Settings)


SHIPPED = (
    # Three points of the lower rim are on the edge of the workspace: there an arm is stretched
    # at 126.87 deg, and float32 cannot distinguish angles. The highest angle leaves out a sliver
    # some 0.01 mm wide around them; the robot file's limit (110 deg) is well before it.
    Shipped("zhao-2023", Cylinder(radius_m=0.2, z_m=(-0.6, -0.35)), 0, (-20.0, 126.5)),
    # The 10 mm cube of eq. (1), z from -0.0708 to -0.0808 m, and about 2 mm around it.
    Shipped(
        "uzunovic-2013",
        Box(x_m=(-0.007, 0.007), y_m=(-0.007, 0.007), z_m=(-0.083, -0.067)),
        seed=0,
        angle_deg=(-20.0, 110.0),
        settings=Settings(hidden=(8, 8), iterations=300, rounds=2, cluster=1000, finest_m=1e-5),
    ),
)


def train_one(shipped: Shipped, config: Path, folder: Path, progress: Progress) -> NetworkFile:
    """Train one network and write it to `folder`. Raises ConfigError or NetworkError."""
    robot = load_delta(config / f"{shipped.robot}.yaml")
    task = Task(robot, shipped.domain, shipped.seed, shipped.angle_deg)
    trained = arm_networks.train(task, shipped.settings, progress)
    return to_file(folder / f"{shipped.robot}.tflite", trained, task)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    names = [shipped.robot for shipped in SHIPPED]
    parser = argparse.ArgumentParser(prog="python -m deltactl.models.training.train_shipped")
    parser.add_argument("robots", nargs="*", default=names, help=f"of {', '.join(names)}")
    parser.add_argument("--config", type=Path, default=CONFIG_FOLDER, help="folder of robot files")
    parser.add_argument("--out", type=Path, default=TRAINED_FOLDER, help="folder to write to")
    parser.add_argument("--seed", type=int, help="instead of the shipped one")
    chosen = parser.parse_args(arguments)
    for shipped in SHIPPED:
        if shipped.robot in chosen.robots:
            seeded = shipped if chosen.seed is None else replace(shipped, seed=chosen.seed)
            print(f"{shipped.robot}: {shipped.domain.describe()}")
            file = train_one(
                seeded, chosen.config, chosen.out, lambda line: print(line, flush=True)
            )
            print(_summary(file))


def _summary(file: NetworkFile) -> str:
    errors = file.metadata.validation
    return (
        f"{file.path}: {file.metadata.architecture}, {file.metadata.parameters} parameters, "
        f"RMS {errors.rmse_deg:.5f} deg, max {errors.max_deg:.5f} deg, "
        f"anywhere in the domain {errors.bound_deg:.5f} deg"
    )


if __name__ == "__main__":
    main()
