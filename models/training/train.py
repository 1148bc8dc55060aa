"""Trains a network by one of the recipes and writes it: what `deltactl network train` does."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from deltactl.foundation.errors import NetworkError
from deltactl.foundation.plain_file import check_place
from deltactl.foundation.process import one_thread
from deltactl.models.network.file import NetworkFile
from deltactl.models.training import arm_networks
from deltactl.models.training.calibrated_physics import CalibratedSettings, train_calibrated
from deltactl.models.training.export import HeldOut, Origin, data_to_file, to_file, unwritable
from deltactl.models.training.recipe import Follow, Settings, Task, Trained, plain, unseen
from deltactl.models.training.samples import split
from deltactl.models.training.sources import Source
from deltactl.models.training.train_shipped import SHIPPED
from deltactl.models.training.uzunovic import UzunovicSettings, train_uzunovic
from deltactl.models.training.zhao import ZhaoSettings, train_zhao

Recipe = Literal["zhao", "uzunovic", "ours"]


@dataclass(frozen=True)
class Written:
    """A network on disk, and how its training went."""

    file: NetworkFile
    trained: Trained


def train_from_samples(
    source: Source,
    recipe: Recipe,
    path: Path,
    seed: int = 0,
    effort: int | None = None,
    follow: Follow = unseen,
) -> Written:
    """Train on measured samples and write the file; `effort` is epochs, or iterations.

    Raises NetworkError when there is nothing to learn or the file cannot be written.
    """
    check_writable(path)
    trained = trained_on(source, recipe, seed, effort, follow)
    _, held = split(len(source), seed)
    task = Task(source.robot, source.domain, seed, source.angle_deg)
    origin = Origin(source.words, source.digest, len(held), source.machine)
    kept = HeldOut(source.position_m[held], source.angles_rad[held])
    return Written(data_to_file(path, trained, task, origin, kept), trained)


def trained_on(
    source: Source,
    recipe: Recipe,
    seed: int = 0,
    effort: int | None = None,
    follow: Follow = unseen,
) -> Trained:
    """The network alone, not written."""
    samples = source.position_m, source.angles_rad
    settings = settings_of(recipe, effort)
    if isinstance(settings, ZhaoSettings):
        return train_zhao(*samples, settings, seed, follow)
    if isinstance(settings, UzunovicSettings):
        return train_uzunovic(*samples, settings, seed, follow)
    return train_calibrated(source.robot, *samples, settings, seed, follow)


def settings_of(
    recipe: Recipe, effort: int | None = None
) -> ZhaoSettings | UzunovicSettings | CalibratedSettings:
    """What a recipe trains with."""
    if recipe == "zhao":
        return ZhaoSettings() if effort is None else ZhaoSettings(epochs=effort)
    if recipe == "uzunovic":
        whole = UzunovicSettings()
        return whole if effort is None else whole.lasting(effort)
    ours = CalibratedSettings()
    if effort is None:
        return ours
    a_round = max(effort // 5, 1)
    short = replace(ours.effort, iterations=effort, iterations_a_round=a_round)
    return replace(ours, effort=short)


def settings_in_file(recipe: Recipe, effort: int | None = None) -> dict[str, float | int | str]:
    """The same as a network's file names them."""
    settings = settings_of(recipe, effort)
    return settings.as_metadata() if isinstance(settings, CalibratedSettings) else plain(settings)


@one_thread
def train_exact(task: Task, settings: Settings, path: Path, follow: Follow = unseen) -> Written:
    """Our recipe for a nominal robot: one small network shared by its arms, with a proven bound.

    Raises NetworkError when the arms differ, the domain cannot be reached or the disk is full.
    """
    check_writable(path)
    trained = arm_networks.train(task, settings, follow=follow)
    return Written(to_file(path, trained, task), trained)


def exact_task(source: Source, seed: int) -> tuple[Task, Settings]:
    """Region and effort of the shipped network of this robot, or the source's own region."""
    for shipped in SHIPPED:
        if shipped.robot == source.robot.name:
            return Task(source.robot, shipped.domain, seed, shipped.angle_deg), shipped.settings
    return Task(source.robot, source.domain, seed), Settings()


def with_iterations(settings: Settings, iterations: int | None) -> Settings:
    """Another number of iterations, if one is given."""
    return settings if iterations is None else replace(settings, iterations=iterations)


def check_writable(path: Path) -> None:
    """Raise NetworkError before any work where the result could not be put."""
    if path.is_dir():
        raise NetworkError(f"{path}: is a folder; name a file, as net.tflite")
    try:
        check_place(path)
    except OSError as error:
        raise unwritable(path, error) from error


def microsteps(error_deg: float, source: Source) -> float | None:
    """An angle in microsteps of the robot's drive; None without one."""
    drive = source.robot.drive
    rad_per_step = getattr(drive, "rad_per_step", None)
    return None if rad_per_step is None else float(np.deg2rad(error_deg) / rad_per_step)
