"""What a robot draws by a network, before and after it heals, for each kind of network.

`python -m benchmarks.proofs.healed_networks --cases 4 --seed 1`. Robots of the independent
simulator with one hidden cause draw the heart by the shipped network (three small ones side by
side) and by Zhao's 8x50, which is trained here on the robot file. Distances are those of the true
platform, beside the same heart by the geometry of a robot with nothing wrong.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
import yaml

from deltactl.firmware_py.named_files import TRAINED_FOLDER
from deltactl.firmware_py.robot_file import load_robot
from deltactl.models.effects import Compensated, compensated
from deltactl.models.robot_files import load_delta
from deltactl.models.training.sources import of_geometry
from deltactl.models.training.train import train_from_samples
from deltactl.proof.hidden.vocabulary import SINGLES
from deltactl.repair.campaign import JOB, ROBOT
from deltactl.repair.heal import Healer, Order
from deltactl.repair.heal_campaign import ProofPatient
from deltactl.repair.machine import FaultyRobot, faulty_robot
from deltactl.repair.played import Paths

SAMPLES = 5000
"""As Zhao 2023."""
LEARNED = [name for name in SINGLES if name in compensated(Compensated.INVERSE)]
"""What a network can learn: effects that follow from where the robot is."""


def zhao_network(folder: Path) -> Path:
    """Zhao's 8x50, taught the geometry of the robot file."""
    path = folder / "zhao-8x50.tflite"
    train_from_samples(of_geometry(load_delta(ROBOT), SAMPLES, 1), "zhao", path, 1, None)
    return path


def drawn_m(machine: FaultyRobot, paths: Paths, robot_file: Path) -> float:
    """Distance from the path RMS [m]."""
    return machine.draw(paths.path(load_robot(robot_file))).rms_m


def healed_m(machine: FaultyRobot, network: Path, folder: Path) -> tuple[str, float, float]:
    """Outcome, and distances before and after by this network [m]."""
    folder.mkdir(parents=True)
    robot_file, job = folder / ROBOT.name, folder / "heart.yaml"
    robot_file.write_bytes(ROBOT.read_bytes())
    plain = yaml.safe_load(JOB.read_text(encoding="utf-8"))
    plain["inverse_kinematics"] = {"kind": "network", "file": str(network)}
    job.write_text(yaml.safe_dump(plain), encoding="utf-8")
    paths = Paths(job)
    before_m = drawn_m(machine, paths, robot_file)
    order = Order(robot_file, job, folder / "healing")
    answer = Healer(order, ProofPatient(machine, job, paths), lambda _: None, paths).heal()
    return answer["outcome"], before_m, drawn_m(machine, paths, robot_file)


def main() -> None:
    """Print a line for each robot and network, and a mean for each network."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=4)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        networks = {"small": TRAINED_FOLDER / "zhao-2023.tflite", "8x50": zhao_network(folder)}
        possible_m = drawn_m(faulty_robot([], 0), Paths(JOB), ROBOT)
        print(f"by the geometry, nothing wrong: {possible_m * 1e3:.3f} mm", flush=True)
        after_m: dict[str, list[float]] = {name: [] for name in networks}
        for number in range(given.cases):
            cause = str(np.random.default_rng([given.seed, number]).choice(LEARNED))
            for name, network in networks.items():
                machine = faulty_robot([cause], 1000 * given.seed + number)
                there = folder / f"{number}-{name}"
                outcome, before_m, now_m = healed_m(machine, network, there)
                after_m[name].append(now_m)
                print(
                    f"{number} {cause:22} {name:6} {before_m * 1e3:.3f} -> {now_m * 1e3:.3f} mm,"
                    f" {outcome}",
                    flush=True,
                )
        for name, values in after_m.items():
            print(
                f"{name}: {np.mean(values) * 1e3:.3f} mm in the mean, at most"
                f" {max(values) * 1e3:.3f} mm, of {len(values)}"
            )


if __name__ == "__main__":
    main()
