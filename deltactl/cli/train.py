"""`deltactl network train`: a network of a data set, or of a robot file's geometry."""

from __future__ import annotations

import time
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deltactl.cli.collect import robot_file_of
from deltactl.cli.output import bar, console, duration, facts, print_json, say
from deltactl.cli.robot.jobs import JsonOption
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.extras import needs

if TYPE_CHECKING:
    from deltactl.models.training.sources import Source
    from deltactl.models.training.train import Written


class Recipe(StrEnum):
    """What is trained, and how."""

    ZHAO = "zhao"
    UZUNOVIC = "uzunovic"
    OURS = "ours"


def train(
    out: Annotated[Path, typer.Option(help="The network's file (.tflite).")],
    dataset: Annotated[
        Path | None, typer.Argument(help="Folder that deltactl network collect wrote.")
    ] = None,
    recipe: Annotated[Recipe, typer.Option(help="Whose network, and how.")] = Recipe.OURS,
    robot: Annotated[
        str | None,
        typer.Option(help="Robot file; without a data set its geometry is learned."),
    ] = None,
    epochs: Annotated[
        int | None, typer.Option(min=1, help="Epochs (zhao) or iterations; the recipe's own.")
    ] = None,
    samples: Annotated[
        int | None, typer.Option(min=1, help="Use the first so many; without a data set, 5000.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Any number; repeats the training.")] = 0,
    json_out: JsonOption = False,
) -> None:
    """Train a network that turns positions into arm angles.

    zhao: 8 x 50 sigmoid, Adam. uzunovic: 3-25-3, Levenberg-Marquardt. ours: calibrate the robot,
    then teach its inverse to small networks (of geometry alone: one that its arms share; of a
    robot file with effects: the exact inverse of what it knows).

    ```
    deltactl network train data --recipe zhao --out zhao.tflite
    deltactl network train --robot zhao-2023.yaml --out nominal.tflite
    deltactl network train --robot corrected.yaml --out corrected.tflite
    ```
    """
    with needs("training", "network train"):
        from deltactl.models.training import corrected
        from deltactl.models.training import train as training
    started_s = time.monotonic()
    source = _source(dataset, robot, samples, seed)
    training.check_writable(out)
    with bar(hidden=json_out, took=True) as show:
        if dataset is None and recipe is Recipe.OURS and source.robot.effects:
            task, _ = training.exact_task(source, seed)
            effort = corrected.with_iterations(corrected.EFFORT, epochs)
            written = corrected.train_corrected(task, out, effort, show)
        elif dataset is None and recipe is Recipe.OURS:
            task, settings = training.exact_task(source, seed)
            settings = training.with_iterations(settings, epochs)
            written = training.train_exact(task, settings, out, show)
        else:
            written = training.train_from_samples(source, recipe.value, out, seed, epochs, show)
    seconds = time.monotonic() - started_s
    if json_out:
        print_json(_as_json(written, source, seconds))
        return
    console.print(facts("", _rows(written, source, seconds)))
    say(f"network: {out}")


def _source(dataset: Path | None, robot: str | None, samples: int | None, seed: int) -> Source:
    from deltactl.firmware_py.named_files import find
    from deltactl.models.robot_files import load_delta
    from deltactl.models.training.dataset import load_dataset
    from deltactl.models.training.sources import of_dataset, of_geometry

    if dataset is None:
        if robot is None:
            raise ConfigError(
                "nothing to learn from: name a data set (deltactl network collect writes one), "
                "or a robot file with --robot"
            )
        return of_geometry(load_delta(find(robot)), samples or 5000, seed)
    data = load_dataset(dataset)
    return of_dataset(data, load_delta(robot_file_of(data, robot)), samples)


def _rows(written: Written, source: Source, seconds: float) -> list[tuple[str, str]]:
    """What people want to know, in words."""
    metadata = written.file.metadata
    training, errors_deg = metadata.training, metadata.validation
    rows = [
        ("network", f"{metadata.architecture}, {metadata.parameters} parameters"),
        ("recipe", f"{training.recipe}, seed {training.seed}"),
        ("learned from", f"{training.source}; {training.samples} samples"),
        ("judged by", f"{errors_deg.samples} samples it was not trained on"),
        ("error RMS", _angle(errors_deg.rmse_deg, source)),
        ("largest error", _angle(errors_deg.max_deg, source)),
    ]
    if errors_deg.bound_deg is not None:
        rows.append(("bound anywhere", _angle(errors_deg.bound_deg, source)))
    if errors_deg.parity_deg is not None:
        rows.append(("file against float64", f"at most {_angle(errors_deg.parity_deg, source)}"))
    rows += written.trained.remarks
    return [*rows, ("answers in", metadata.domain.describe()), ("took", duration(seconds))]


def _angle(error_deg: float, source: Source) -> str:
    from deltactl.models.training.train import microsteps

    steps = microsteps(error_deg, source)
    beside = "" if steps is None else f" ({steps:.3g} microsteps)"
    return f"{error_deg:.3g} deg{beside}"


def _as_json(written: Written, source: Source, seconds: float) -> dict[str, Any]:
    from deltactl.models.training.train import microsteps

    metadata = written.file.metadata
    return {
        "file": str(written.file.path),
        "seconds": seconds,
        "rmse_microsteps": microsteps(metadata.validation.rmse_deg, source),
        "remarks": dict(written.trained.remarks),
        "course": [list(point) for point in written.trained.course],
        **metadata.model_dump(mode="json"),
    }
