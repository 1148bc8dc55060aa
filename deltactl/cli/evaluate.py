"""`deltactl network evaluate`: how wrong a network is, beside geometry and a calibration."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deltactl.cli.collect import SHIPPED_AS_BUILT, robot_file_of
from deltactl.cli.output import console, errors, print_json, say
from deltactl.cli.robot.jobs import JsonOption
from deltactl.foundation.extras import needs

if TYPE_CHECKING:
    from deltactl.firmware_py.evaluating.held_out import Angles, Errors, HeldOut
    from deltactl.firmware_py.robot_file import RobotFile
    from deltactl.models.network.inverse import InverseNetwork
    from deltactl.models.network.metadata import NetworkMetadata
    from deltactl.models.training.calibrate import Calibrated
    from deltactl.models.training.dataset import DataSet
    from deltactl.reproduction.zhao_2023.as_built import AsBuiltFile


def evaluate(
    network: Annotated[Path, typer.Argument(help="A trained network (.tflite).")],
    data: Annotated[Path, typer.Option(help="Folder that deltactl network collect wrote.")],
    robot: Annotated[
        str | None, typer.Option(help="Robot file; that of the data set if not given.")
    ] = None,
    as_built: Annotated[
        str | None,
        typer.Option(help="Also run curves on this as-built robot (a file, or zhao-2023)."),
    ] = None,
    part: Annotated[
        float, typer.Option(min=0.01, max=1.0, help="How much of each curve is followed.")
    ] = 1.0,
    save_robot: Annotated[
        Path | None, typer.Option(help="Write the robot file with the calibration's effects here.")
    ] = None,
    json_out: JsonOption = False,
) -> None:
    """Judge a network by samples it did not see, and on curves of an as-built robot.

    Beside it are the robot file's geometry, and that geometry calibrated on the same samples.
    Of a robot built far from its file, networks run with the file that --save-robot writes.

    ```
    deltactl network evaluate zhao.tflite --data data
    deltactl network evaluate zhao.tflite --data data --save-robot mine.yaml
    deltactl network evaluate zhao.tflite --data data --as-built zhao-2023
    ```
    """
    _check_installed()
    from deltactl.firmware_py.evaluating.held_out import held_out
    from deltactl.firmware_py.robot_file import load_robot
    from deltactl.models.network.inverse import InverseNetwork
    from deltactl.models.training.calibrate import calibrate
    from deltactl.models.training.calibrated_file import check_new
    from deltactl.models.training.dataset import load_dataset

    samples = load_dataset(data)
    path = robot_file_of(samples, robot)
    described = load_robot(path)
    samples.check(described)
    if save_robot is not None:
        check_new(path, save_robot)
    built = None if as_built is None else _built(as_built, described, samples)
    running = InverseNetwork.open(network, described)
    held = held_out(samples, running.metadata)
    known = held.trained
    calibrated = calibrate(described, samples.position_m[known], samples.angles_rad[known])
    models = _models(running, described, calibrated)
    asked = _asked_where_seen(models, running.metadata, calibrated)
    answer: dict[str, Any] = {"network": str(network)}
    answer |= _held_out(asked, samples, described, held, json_out)
    if built is not None:
        answer["curves"] = _curves(built, described, models, part, json_out)
    if save_robot is not None:
        _save(path, calibrated, samples, held, save_robot, json_out)
    if json_out:
        print_json(answer)


def _check_installed() -> None:
    with needs("training", "network evaluate"):
        import deltactl.models.training.calibrate  # noqa: F401


def _models(network: InverseNetwork, robot: RobotFile, calibrated: Calibrated) -> dict[str, Angles]:
    """The network, and what it is compared with."""
    from deltactl.models.calibrated_inverse import CalibratedInverse
    from deltactl.models.linkage import Linkage, inverse
    from deltactl.models.training.calibrated_file import calibrated_robot

    linkage = Linkage.of(robot.geometry)
    return {
        "network": network.raw_rad_many,
        "geometry": lambda position_m: inverse(linkage, position_m).angles_rad,
        "calibrated": CalibratedInverse(calibrated_robot(calibrated)).angles_rad_at_once,
    }


def _held_out(
    models: dict[str, Angles], samples: DataSet, robot: RobotFile, held: HeldOut, quiet: bool
) -> dict[str, Any]:
    """Errors on the samples that were held out: printed, and for the answer in JSON."""
    from deltactl.firmware_py.evaluating.held_out import errors as errors_of

    found = {
        name: errors_of(angles, samples, robot, held.judged) for name, angles in models.items()
    }
    if not quiet:
        _show(held.words, found)
    return {
        "judged_by": held.words,
        "held_out": {name: error.as_json() for name, error in found.items()},
    }


def _save(
    path: Path, calibrated: Calibrated, samples: DataSet, held: HeldOut, out: Path, quiet: bool
) -> None:
    from deltactl.models.training.calibrated_file import save_calibrated

    words = f"{len(held.trained)} samples of {samples.folder.name} ({samples.digest})"
    save_calibrated(path, calibrated, words, samples.settings.machine_words, out)
    if not quiet:
        say(f"calibrated robot file: {out}")


def _asked_where_seen(
    models: dict[str, Angles], metadata: NetworkMetadata, found: Calibrated
) -> dict[str, Angles]:
    """Models that answer for true positions, asked for measured ones: sensor errors come off."""
    from deltactl.models.training.calibrated_file import true_m

    def with_truth(angles: Angles) -> Angles:
        return lambda seen_m: angles(true_m(found, seen_m))

    true = {"calibrated"} | ({"network"} if metadata.training.recipe == "ours" else set())
    return {name: with_truth(model) if name in true else model for name, model in models.items()}


def _show(words: str, found: dict[str, Errors]) -> None:
    from deltactl.reproduction.outcome import Sheet

    rows = [
        [
            name,
            *(f"{value:.3f}" for value in error.joint_median_deg),
            *(f"{value:.3f}" for value in error.joint_rms_deg),
            f"{error.joint_max_deg.max():.2f}",
            *(f"{1e3 * value:.2f}" for value in error.axis_rms_m),
            f"{1e3 * error.axis_max_m.max():.1f}",
            str(error.unanswered),
        ]
        for name, error in found.items()
    ]
    head = [
        "model",
        "median 1",
        "2",
        "3",
        "RMS 1",
        "2",
        "3",
        "max [deg]",
        "RMS x",
        "y",
        "z",
        "max [mm]",
        "no answer",
    ]
    title = f"Errors on {words}: per joint [deg], per axis [mm]"
    say(Sheet(title, head, rows).text())


def _built(name: str, robot: RobotFile, samples: DataSet) -> AsBuiltFile:
    """The as-built robot, before any work. Raises ConfigError, or RecordingError for another's."""
    with needs("proof", "--as-built"):
        from deltactl.reproduction.zhao_2023 import tables
        from deltactl.reproduction.zhao_2023.as_built import AS_BUILT_FILE, load_as_built
    file = AS_BUILT_FILE if name == SHIPPED_AS_BUILT else Path(name)
    built = load_as_built(file, robot)
    tables.check_same(samples, built, file)
    return built


def _curves(
    built: AsBuiltFile, robot: RobotFile, models: dict[str, Angles], part: float, quiet: bool
) -> list[dict[str, Any]]:
    from deltactl.reproduction.zhao_2023 import tables

    with errors.status("") as status:
        rows = tables.evaluate(models, robot, built, part, status.update)
    if not quiet:
        console.print()
        say(tables.sheet(rows).text())
    return [row.as_json() for row in rows]
