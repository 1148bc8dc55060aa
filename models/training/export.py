"""Measures how wrong a network is as it runs, and writes it to a file that knows its errors."""

from __future__ import annotations

import contextlib
import importlib.metadata
import platform
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from deltactl.foundation.errors import NetworkError
from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.release import own_version
from deltactl.models.linkage import Linkage
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
from deltactl.models.training.recipe import Task, Trained
from deltactl.models.training.samples import around, edges, hardest, labels_rad, spread

STREAM = 1
"""Second word of the validation's seed: never the stream that chose training samples."""

_FINEST_M = 1e-9
_HEADROOM = 1.5
"""The bound is this many times the worst found: searches from other starts differ by a tenth."""

_CLIMBERS, _TRIES, _NARROW = 50, 50, 0.85


@dataclass(frozen=True)
class Effort:
    """How hard to look: even samples, and rounds of the search for the worst point."""

    samples: int = 20_000
    rounds: int = 40


Errors = Callable[[FloatArray], FloatArray]
"""Positions (n, 3) to the size of the largest of three errors [deg], (n,)."""


def measure(file: NetworkFile, task: Task, effort: Effort | None = None) -> Validation:
    """Errors of the running network against the float64 geometry, on points of its own."""
    effort = effort or Effort()
    rng = np.random.default_rng([task.seed, STREAM])
    linkage, network = Linkage.of(task.robot.geometry), InverseNetwork(file)
    even_m = spread(task.domain, rng, effort.samples)
    even_m = even_m[task.learns(labels_rad(linkage, even_m))]
    even_deg = errors_deg(network, linkage, task, even_m)
    return Validation(
        samples=len(even_deg),
        rmse_deg=float(np.sqrt(np.mean(even_deg**2))),
        max_deg=float(np.abs(even_deg).max()),
        bound_deg=_HEADROOM * worst_deg(network, task, rng, effort),
    )


def errors_deg(
    network: InverseNetwork, linkage: Linkage, task: Task, position_m: FloatArray
) -> FloatArray:
    """Network minus geometry [deg], shape (n, 3); 0 at poses the task is not about."""
    wanted_rad = labels_rad(linkage, position_m)
    error_rad = network.raw_rad_many(position_m) - wanted_rad
    error_rad[~task.learns(wanted_rad)] = 0.0
    error_deg: FloatArray = np.rad2deg(error_rad)
    return error_deg


def worst_deg(
    network: InverseNetwork, task: Task, rng: np.random.Generator, effort: Effort
) -> float:
    """The largest error that a search finds: many points, then uphill from the worst of them."""
    linkage, some = Linkage.of(task.robot.geometry), effort.samples // 2
    anchor_m = hardest(task.domain, linkage, rng)
    start_m = np.vstack(
        [
            anchor_m,
            spread(task.domain, rng, some),
            edges(task.domain, rng, some),
            around(task.domain, anchor_m, rng, some, _FINEST_M),
        ]
    )

    def size_deg(position_m: FloatArray) -> FloatArray:
        error_deg = errors_deg(network, linkage, task, position_m)
        largest: FloatArray = np.abs(error_deg).max(axis=1)
        return largest

    return _climb(size_deg, task, start_m, rng, effort.rounds)


def _climb(
    size_deg: Errors, task: Task, start_m: FloatArray, rng: np.random.Generator, rounds: int
) -> float:
    """Keep the worst points, try others near them at all scales, in ever closer rounds."""
    low_m, high_m = task.domain.bounding_box()
    reach_m = 0.03 * (high_m - low_m)
    points_m, found_deg = start_m, size_deg(start_m)
    for _ in range(rounds):
        worst = np.argsort(-found_deg)[:_CLIMBERS]
        points_m, found_deg = points_m[worst], found_deg[worst]
        scale = 10.0 ** rng.uniform(-3.0, 0.0, (len(points_m) * _TRIES, 1))
        step_m = rng.normal(size=(len(points_m) * _TRIES, 3)) * reach_m * scale
        tries_m = task.domain.clip(np.repeat(points_m, _TRIES, axis=0) + step_m)
        points_m = np.vstack([points_m, tries_m])
        found_deg = np.concatenate([found_deg, size_deg(tries_m)])
        reach_m = _NARROW * reach_m
    return float(found_deg.max())


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
    """Versions of Python and of the installed libraries that did the arithmetic."""
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
        written_by=f"deltactl {own_version()}",
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
