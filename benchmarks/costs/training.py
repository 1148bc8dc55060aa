"""What training costs, what each addition to the papers' recipes adds, and what ships.

    python benchmarks/costs/training.py               all but the ablation; two minutes
    python benchmarks/costs/training.py --ablation    Zhao's recipe piece by piece; three minutes
    python benchmarks/costs/training.py --keras PYTHON --keep keras.json
                                                the same in a Python with TensorFlow; half an hour
Samples: 5000 random arm angles of config/zhao-2023.yaml, exact positions, three quarters trained;
13 333 of eq. (1) of Uzunovic 2013 as that paper's robot gives them. CPU is of the whole process.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.optimize import least_squares
from threadpoolctl import threadpool_limits

from deltactl.models.linkage import Linkage
from deltactl.models.network.file import TRAINED_FOLDER, NetworkFile
from deltactl.models.robot import FloatArray
from deltactl.models.robot_files import load_delta
from deltactl.models.training.export import Effort, measure
from deltactl.models.training.perceptron import Perceptron, Scaling
from deltactl.models.training.recipe import Task
from deltactl.models.training.samples import random_poses, split
from deltactl.models.training.train_shipped import CONFIG_FOLDER
from deltactl.models.training.uzunovic import UzunovicSettings, train_uzunovic
from deltactl.models.training.zhao import AS_KERAS, AS_PRINTED, ZhaoSettings, train_zhao

SAMPLES, ANGLE_DEG, DATA_SEED = 5000, (-20.0, 110.0), 1
EPOCHS = 5000
ZHAO_LIMIT_S, LM_LIMIT_S = 120.0, 20.0
SLOW_DEG = 1.0
LIBRARY_STEPS = 60
"""scipy takes about a second a step, and is not at its end then."""
SHIPPED_RMS_DEG, MICROSTEP_DEG, SHIPPED_PARAMETERS = 0.001, 0.0225, 400
KERAS_SCRIPT = Path(__file__).with_name("training_keras.py")

console = Console(highlight=False, markup=False)


@dataclass(frozen=True)
class Timed:
    """An error and what it cost."""

    rmse_deg: float
    wall_s: float
    cpu_s: float


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description="cost of training")
    parser.add_argument("--ablation", action="store_true", help="what each addition adds")
    parser.add_argument("--epochs", type=int, default=EPOCHS)
    parser.add_argument("--keras", type=Path, help="a Python with TensorFlow: run Keras, too")
    parser.add_argument("--keep", type=Path, help="Keras' result is written to, or read from here")
    steps = "of scipy's; 1000 let it end by itself and take twenty minutes"
    parser.add_argument("--library-steps", type=int, default=LIBRARY_STEPS, help=steps)
    given = parser.parse_args(arguments)
    _hide_neighbours()
    if given.ablation:
        ablation(given.epochs)
        return
    zhao(given.epochs, given.keras, given.keep)
    levenberg_marquardt(given.library_steps)
    shipped()


def _hide_neighbours() -> None:
    """numba imports a module `coverage`: it must not find the benchmark of that name in here."""
    here = Path(__file__).resolve().parent
    sys.path[:] = [part for part in sys.path if Path(part).resolve() != here]


def zhao(epochs: int, python: Path | None, kept: Path | None) -> None:
    """Zhao's network: ours, and the paper's recipe here and in Keras."""
    samples = _zhao_samples()
    table = _table(f"Zhao 2023: 8x50 sigmoid, {epochs} epochs, 5000 samples, batch 32")
    for name, settings in (("this program", ZhaoSettings()), ("the recipe, here", AS_KERAS)):
        found = _timed(lambda s=settings: _zhao(samples, replace(s, epochs=epochs)))  # type: ignore[misc]
        table.add_row(name, *_cells(found), f"{ZHAO_LIMIT_S:g}")
    keras = _keras(samples, epochs, python, kept)
    if isinstance(keras, Timed):
        table.add_row("the recipe in Keras", *_cells(keras), "")
    console.print(table)
    if isinstance(keras, str):
        console.print(keras)


def ablation(epochs: int) -> None:
    """From the recipe as printed to ours, one addition after the other."""
    samples = _zhao_samples()
    falling = replace(AS_KERAS, schedule="cosine")
    steps = (
        ("as printed: metres, degrees", AS_PRINTED),
        ("+ standardised", AS_KERAS),
        ("+ rate falls to 0", falling),
        ("+ wide, centred start", ZhaoSettings()),
        ("from rate 0.003", replace(ZhaoSettings(), rate=3e-3)),
    )
    table = _table(f"Zhao's recipe piece by piece, {epochs} epochs", f"epochs to {SLOW_DEG:g} deg")
    for name, settings in steps:
        course: list[tuple[int, float]] = []
        done = replace(settings, epochs=epochs)
        found = _timed(lambda s=done, c=course: _zhao(samples, s, c))  # type: ignore[misc]
        under = [str(epoch) for epoch, error_deg in course if error_deg < SLOW_DEG]
        table.add_row(name, *_cells(found), under[0] if under else "never")
    console.print(table)


def levenberg_marquardt(library_steps: int) -> None:
    """Uzunovic's network: ours, and scipy from one random start."""
    from deltactl.reproduction.uzunovic_2013.kinematics import ROBOT_FILE
    from deltactl.reproduction.uzunovic_2013.kinematics_stage import SAMPLES as ALL
    from deltactl.reproduction.uzunovic_2013.kinematics_stage import StageRobot
    from deltactl.reproduction.uzunovic_2013.kinematics_stage import measure as lead

    measured = lead(load_delta(ROBOT_FILE), StageRobot())
    samples = measured.position_m, measured.angles_rad
    settings = UzunovicSettings(hold_out=False)
    table = _table(f"Uzunovic 2013: 3-25-3 by Levenberg-Marquardt, {ALL} samples")
    found = _timed(lambda: train_uzunovic(*samples, settings).rmse_deg(*samples))
    table.add_row("this program", *_cells(found), f"{LM_LIMIT_S:g}")
    for method in ("lm", "trf"):
        found = _timed(lambda m=method: _scipy(samples, m, library_steps))  # type: ignore[misc]
        table.add_row(f"scipy {method}, {library_steps} steps", *_cells(found), "")
    console.print(table)


def shipped() -> None:
    """The shipped network of the Zhao robot against the geometry, in its whole cylinder."""
    file = NetworkFile.load(TRAINED_FOLDER / "zhao-2023.tflite")
    metadata = file.metadata
    robot = load_delta(CONFIG_FOLDER / "zhao-2023.yaml")
    task = Task(robot, metadata.domain, 20_231, metadata.angle_deg)
    found = measure(file, task, Effort(samples=20_000, rounds=25))
    assert found.bound_deg is not None
    table = Table(title=f"Shipped: {metadata.architecture}", title_justify="left")
    for heading in ("in " + metadata.domain.describe(), "found", "limit", "met"):
        table.add_column(heading)
    for name, value, limit in (
        ("parameters", metadata.parameters, SHIPPED_PARAMETERS),
        ("RMS deg", found.rmse_deg, SHIPPED_RMS_DEG),
        ("1.5 times the worst error found, deg", found.bound_deg, MICROSTEP_DEG),
    ):
        table.add_row(name, f"{value:.3g}", f"{limit:g}", "yes" if value <= limit else "NO")
    console.print(table)


def _zhao_samples() -> tuple[FloatArray, FloatArray]:
    robot = load_delta(CONFIG_FOLDER / "zhao-2023.yaml")
    return random_poses(Linkage.of(robot.geometry), SAMPLES, ANGLE_DEG, DATA_SEED)


def _zhao(
    samples: tuple[FloatArray, FloatArray],
    settings: ZhaoSettings,
    course: list[tuple[int, float]] | None = None,
) -> float:
    """Held-out error [deg]; `course` is told the errors on the way."""
    position_m, angles_rad = samples
    trained = train_zhao(position_m, angles_rad, settings)
    if course is not None:
        course.extend(trained.course)
    _, held = split(len(position_m), 0)
    return trained.rmse_deg(position_m[held], angles_rad[held])


def _scipy(samples: tuple[FloatArray, FloatArray], method: str, steps: int) -> float:
    """The same network, Jacobian and standardised samples; one random start."""
    network = Perceptron((3, 25, 3))
    into, out = (Scaling.of(part) for part in samples)
    inputs, wanted = into.apply(samples[0]), out.apply(samples[1])

    def error(parameters: FloatArray) -> FloatArray:
        return (network.values(parameters, inputs) - wanted).ravel()

    def slope(parameters: FloatArray) -> FloatArray:
        return network.jacobian(parameters, inputs)[1].reshape(-1, network.parameters)

    start = network.start(np.random.default_rng(0))
    with threadpool_limits(limits=1, user_api="blas"):
        solved = least_squares(error, start, jac=slope, method=method, max_nfev=steps)
    left = error(solved.x).reshape(wanted.shape) * out.deviation
    return float(np.rad2deg(np.sqrt(np.mean(left**2))))


def _keras(
    samples: tuple[FloatArray, FloatArray], epochs: int, python: Path | None, kept: Path | None
) -> Timed | str:
    """Keras' result, or why there is none."""
    digest = hashlib.sha256(np.stack(samples).astype("<f8").tobytes()).hexdigest()[:16]
    with tempfile.TemporaryDirectory() as folder:
        result = kept or Path(folder) / "keras.json"
        if python is not None:
            _run_keras(samples, digest, epochs, python, Path(folder), result)
        if not result.is_file():
            return "Keras: skipped; name a Python that has TensorFlow with --keras PYTHON"
        found = json.loads(result.read_text())
    if found["data"] != digest or found["epochs"] != epochs:
        return f"Keras: {result} is of other samples or epochs; run it again with --keras PYTHON"
    return Timed(found["rmse_deg"], found["wall_s"], found["cpu_s"])


def _run_keras(
    samples: tuple[FloatArray, FloatArray],
    digest: str,
    epochs: int,
    python: Path,
    folder: Path,
    result: Path,
) -> None:
    rows, held = split(len(samples[0]), 0)
    into, out = (Scaling.of(part[rows]) for part in samples)
    x, y = into.apply(samples[0]), out.apply(samples[1])
    prepared: dict[str, Any] = {
        "x": x[rows],
        "y": y[rows],
        "xv": x[held],
        "yv": y[held],
        "deviation_deg": np.rad2deg(out.deviation),
        "digest": digest,
    }
    np.savez(folder / "samples.npz", **prepared)
    command = [
        str(python),
        str(KERAS_SCRIPT),
        str(folder / "samples.npz"),
        str(epochs),
        str(result),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no reason given"])[-1]
        sys.exit(f"Keras: {python} failed: {last}")


def _timed(work: Callable[[], float]) -> Timed:
    wall_s, cpu_s = time.monotonic(), time.process_time()
    rmse_deg = work()
    return Timed(rmse_deg, time.monotonic() - wall_s, time.process_time() - cpu_s)


def _table(title: str, last: str = "limit s") -> Table:
    table = Table(title=title, title_justify="left")
    for heading in ("", "RMS error deg", "wall s", "CPU s", last):
        table.add_column(heading, justify="right" if heading else "left")
    return table


def _cells(found: Timed) -> tuple[str, str, str]:
    return f"{found.rmse_deg:.4f}", f"{found.wall_s:.1f}", f"{found.cpu_s:.1f}"


if __name__ == "__main__":
    main()
