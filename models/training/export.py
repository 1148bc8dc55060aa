"""Writes a trained network to a file that knows its robot, its errors and its own checksum."""

from __future__ import annotations

import importlib.metadata
import os
from pathlib import Path

import numpy as np

from models.linkage import Linkage
from models.network.file import NetworkFile, checked_metadata, checksum, checksum_start
from models.network.inverse import InverseNetwork
from models.network.metadata import (
    NO_CHECKSUM,
    NetworkMetadata,
    TrainedRobot,
    Training,
    Validation,
    fingerprint,
)
from models.robot import FloatArray
from models.training.recipe import Task, Trained
from models.training.samples import around, edges, hardest, labels_rad, spread

VALIDATION_SAMPLES = 20_000
_EDGE_SHARE = 0.5
_FINEST_M = 1e-9
_VALIDATION_STREAM = 1
"""Second word of the validation's seed: never the stream that chose training samples."""


def to_file(path: Path, trained: Trained, task: Task, source: str = "geometry") -> NetworkFile:
    """Measure the network as it runs and write it. Raises OSError when it cannot be written.

    The bytes are checked like any file's before they replace what was at `path`.
    """
    unmeasured = Validation(samples=0, rmse_deg=0.0, max_deg=0.0, bound_deg=0.0)
    draft = _file(path, trained, _metadata(trained, task, source, unmeasured))
    final = _file(path, trained, _metadata(trained, task, source, measure(draft, task)))
    partial = path.with_suffix(".partial")
    try:
        partial.write_bytes(final.content)
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)
    return final


def measure(file: NetworkFile, task: Task) -> Validation:
    """Errors of the running network against the float64 geometry, on points of its own."""
    rng = np.random.default_rng([task.seed, _VALIDATION_STREAM])
    linkage, network = Linkage.of(task.robot.geometry), InverseNetwork(file)
    even_m = spread(task.domain, rng, VALIDATION_SAMPLES)
    anchor_m = hardest(task.domain, linkage, rng)
    extra = round(_EDGE_SHARE * VALIDATION_SAMPLES)
    hard_m = np.vstack(
        [
            anchor_m,
            edges(task.domain, rng, extra),
            around(task.domain, anchor_m, rng, extra, _FINEST_M),
        ]
    )
    even_deg, hard_deg = (_errors_deg(network, linkage, task, p) for p in (even_m, hard_m))
    return Validation(
        samples=len(even_deg),
        rmse_deg=float(np.sqrt(np.mean(even_deg**2))),
        max_deg=float(np.abs(even_deg).max()),
        bound_deg=float(max(np.abs(even_deg).max(), np.abs(hard_deg).max())),
    )


def seal(content: bytes) -> bytes:
    """The bytes with their checksum filled in."""
    start = checksum_start(content)
    digits = checksum(content).encode()
    return content[:start] + digits + content[start + len(NO_CHECKSUM) :]


def _errors_deg(
    network: InverseNetwork, linkage: Linkage, task: Task, position_m: FloatArray
) -> FloatArray:
    wanted_rad = labels_rad(linkage, position_m)
    learned = task.learns(wanted_rad)
    error_rad = network.raw_rad_many(position_m[learned]) - wanted_rad[learned]
    error_deg: FloatArray = np.rad2deg(error_rad)
    return error_deg


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
