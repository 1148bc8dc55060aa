"""Writes a trained network to a file that knows its robot, its errors and its own checksum."""

from __future__ import annotations

import importlib.metadata
import os
from pathlib import Path

from models.network.file import NetworkFile, checked_metadata, checksum, checksum_start
from models.network.metadata import (
    NO_CHECKSUM,
    NetworkMetadata,
    TrainedRobot,
    Training,
    Validation,
    fingerprint,
)
from models.training.accuracy import Effort, measure
from models.training.recipe import Task, Trained


def to_file(
    path: Path, trained: Trained, task: Task, effort: Effort | None = None, source: str = "geometry"
) -> NetworkFile:
    """Measure the network as it runs and write it. Raises OSError when it cannot be written.

    The bytes are checked like any file's before they replace what was at `path`.
    """
    unmeasured = Validation(samples=0, rmse_deg=0.0, max_deg=0.0, bound_deg=0.0)
    draft = _file(path, trained, _metadata(trained, task, source, unmeasured))
    measured = measure(draft, task, effort)
    final = _file(path, trained, _metadata(trained, task, source, measured))
    partial = path.with_suffix(".partial")
    try:
        partial.write_bytes(final.content)
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)
    return final


def seal(content: bytes) -> bytes:
    """The bytes with their checksum filled in."""
    start = checksum_start(content)
    digits = checksum(content).encode()
    return content[:start] + digits + content[start + len(NO_CHECKSUM) :]


def _file(path: Path, trained: Trained, metadata: NetworkMetadata) -> NetworkFile:
    description = f"arm angles of delta robot {metadata.robot.name}: {trained.architecture}"
    text = metadata.model_dump_json().encode()
    content = seal(trained.graph.to_bytes(trained.source, trained.result, description, text))
    return NetworkFile(path, content, checked_metadata(content, str(path)))


def _metadata(trained: Trained, task: Task, source: str, validation: Validation) -> NetworkMetadata:
    geometry = task.robot.geometry
    return NetworkMetadata(
        written_by=f"deltactl {_version()}",
        robot=TrainedRobot(
            name=task.robot.name, fingerprint=fingerprint(geometry), geometry=geometry
        ),
        architecture=trained.architecture,
        parameters=trained.parameters,
        domain=task.domain,
        angle_deg=task.angle_deg,
        training=Training(
            recipe=trained.recipe,
            seed=task.seed,
            settings=trained.settings,
            samples=trained.samples,
            source=source,
        ),
        validation=validation,
    )


def _version() -> str:
    try:
        return importlib.metadata.version("deltactl")
    except importlib.metadata.PackageNotFoundError:
        return "(not installed)"
