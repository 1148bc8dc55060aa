"""Writes a trained network to a file that knows its robot, its errors and its own checksum."""

from __future__ import annotations

import contextlib
import importlib.metadata
import platform
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from deltactl.foundation.errors import NetworkError
from deltactl.foundation.plain_file import write_whole
from deltactl.models.network.file import NetworkFile, checked_metadata, checksum, checksum_start
from deltactl.models.network.inverse import InverseNetwork
from deltactl.models.network.metadata import (
    NO_CHECKSUM,
    NetworkMetadata,
    TrainedRobot,
    Training,
    Validation,
    fingerprint,
)
from deltactl.models.robot import FloatArray
from deltactl.models.training.accuracy import Effort, measure
from deltactl.models.training.recipe import Task, Trained
from deltactl.models.training.samples import spread

_LIBRARIES = ("numpy", "scipy", "numba")
_PARITY_POINTS = 1000
_UNMEASURED = Validation(samples=0, rmse_deg=0.0, max_deg=0.0)


@dataclass(frozen=True)
class Origin:
    """Where samples come from."""

    source: str
    data: str = ""
    """Digest of the data set."""
    held_out: int = 0
    machine: str = ""


GEOMETRY = Origin("geometry")


def to_file(path: Path, trained: Trained, task: Task, effort: Effort | None = None) -> NetworkFile:
    """Measure the network as it runs and write it. Raises NetworkError when it cannot be written.

    The bytes are checked like any file's before they replace what was at `path`.
    """
    draft = _file(path, trained, _metadata(trained, task, GEOMETRY, _UNMEASURED))
    measured = measure(draft, task, effort)
    rng = np.random.default_rng(task.seed)
    parity = parity_deg(draft, trained, spread(task.domain, rng, _PARITY_POINTS))
    measured = measured.model_copy(update={"parity_deg": parity})
    return _write(path, trained, _metadata(trained, task, GEOMETRY, measured))


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Samples the network was not trained on: positions [m] and angles [rad], both (n, 3)."""

    position_m: FloatArray
    angles_rad: FloatArray


def data_to_file(
    path: Path, trained: Trained, task: Task, origin: Origin, held: HeldOut
) -> NetworkFile:
    """`to_file` for a network of measured samples: it is judged by those held out.

    There is no bound on its error: only the samples are known. Raises NetworkError.
    """
    draft = _file(path, trained, _metadata(trained, task, origin, _UNMEASURED))
    running = InverseNetwork(draft).raw_rad_many(held.position_m)
    error_deg = np.rad2deg(running - held.angles_rad)
    measured = Validation(
        samples=len(error_deg),
        rmse_deg=float(np.sqrt(np.mean(error_deg**2))),
        max_deg=float(np.abs(error_deg).max()),
        parity_deg=parity_deg(draft, trained, held.position_m),
    )
    return _write(path, trained, _metadata(trained, task, origin, measured))


def parity_deg(file: NetworkFile, trained: Trained, position_m: FloatArray) -> float:
    """Largest difference [deg] between the file as it runs and float64, over positions (n, 3)."""
    running = InverseNetwork(file).raw_rad_many(position_m)
    return float(np.rad2deg(np.abs(running - trained.angles_rad_many(position_m)).max()))


def versions() -> dict[str, str]:
    """Of Python and the libraries that did the arithmetic, as far as they are installed."""
    found = {"python": platform.python_version()}
    for name in _LIBRARIES:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found[name] = importlib.metadata.version(name)
    return found


def unwritable(path: Path, error: OSError) -> NetworkError:
    """In one line that a network cannot be written here."""
    reason = error.strerror or str(error)
    return NetworkError(
        f"{path}: cannot be written ({reason}); what was there is unchanged, "
        "make room or name another place with --out"
    )


def _write(path: Path, trained: Trained, metadata: NetworkMetadata) -> NetworkFile:
    """Beside what is there, then in its place: a full disk leaves the old file as it was."""
    final = _file(path, trained, metadata)
    try:
        write_whole(path, final.content)
    except OSError as error:
        raise unwritable(path, error) from error
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


def _metadata(
    trained: Trained, task: Task, origin: Origin, validation: Validation
) -> NetworkMetadata:
    geometry = task.robot.geometry
    return NetworkMetadata(
        written_by=f"deltactl {_version()}",
        robot=TrainedRobot(
            name=task.robot.name,
            fingerprint=fingerprint(geometry),
            geometry=geometry,
            effects=trained.effects,
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
            source=origin.source,
            data=origin.data,
            machine=origin.machine,
            held_out=origin.held_out,
            versions=versions(),
        ),
        validation=validation,
    )


def _version() -> str:
    try:
        return importlib.metadata.version("deltactl")
    except importlib.metadata.PackageNotFoundError:
        return "(not installed)"
