"""A network file on disk, checked before any of it is run."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from deltactl.foundation.errors import NetworkError
from deltactl.foundation.plain_file import TooLong, read_plain
from deltactl.models.network.metadata import (
    METADATA_NAME,
    NO_CHECKSUM,
    NetworkMetadata,
    fingerprint,
)
from deltactl.models.network.structure import FlatError, check_structure, metadata_span
from deltactl.models.robot import DeltaRobot

TRAINED_FOLDER = Path(__file__).resolve().parent.parent / "trained"
"""Networks that ship with the program."""

LARGEST_BYTES = 64 * 1024 * 1024
"""Far above any network of this kind (the shipped one has 5 kB)."""

_CHECKSUM_KEY = b'"sha256":"'


@dataclass(frozen=True)
class NetworkFile:
    """The bytes of a file whose checksum holds, and what its metadata says."""

    path: Path
    content: bytes
    metadata: NetworkMetadata

    @classmethod
    def load(cls, path: Path, follow: bool = True) -> NetworkFile:
        """Read and check a file without running it.

        follow: whether links may lead to it. Raises MissingFile when it cannot be read;
        NetworkError (one line) when it is no TFLite file, broken, truncated, changed since it
        was written, or not ours.
        """
        content = _read(path, follow)
        metadata = checked_metadata(content, str(path))
        check_structure(content, str(path))
        return cls(path, content, metadata)

    def check(self, robot: DeltaRobot) -> None:
        """Raises NetworkError, naming both robots, unless the file is for this one.

        A network of measured samples is of the machine: a calibration of it may describe it anew.
        Not one of another machine of the same design, as of the simulated one.
        """
        trained, mark = self.metadata.robot, fingerprint(robot.geometry)
        if trained.name != robot.name:
            raise NetworkError(
                f"{self.path}: was trained for robot '{trained.name}', not for '{robot.name}'; "
                "name the right file in the job or train one for this robot"
            )
        if trained.fingerprint == mark:
            return
        learned = self.metadata.training
        if not learned.data or robot.calibrated_from != trained.fingerprint:
            raise NetworkError(
                f"{self.path}: was trained for '{trained.name}' with another geometry "
                f"({trained.fingerprint}) than '{robot.name}' has now ({mark}); train it again"
            )
        if learned.machine != robot.calibrated_on:
            raise NetworkError(
                f"{self.path}: learned from samples of '{learned.machine}', and the robot file is "
                f"a calibration on samples of '{robot.calibrated_on}'; calibrate on the network's "
                "own data set (deltactl network evaluate --save-robot)"
            )


def checked_metadata(content: bytes, where: str) -> NetworkMetadata:
    """The metadata of a whole file's bytes, after the checksum. Raises NetworkError."""
    try:
        span = metadata_span(content, METADATA_NAME)
    except FlatError as error:
        raise NetworkError(f"{where}: {error}; copy or train it again") from None
    if span is None:
        raise NetworkError(
            f"{where}: is a TFLite file of another program (no '{METADATA_NAME}' metadata); "
            "only networks written by deltactl say for which robot they are"
        )
    metadata = _parse(span.of(content), where)
    if metadata.sha256 != checksum(content):
        raise NetworkError(f"{where}: its checksum does not hold; copy or train it again")
    return metadata


def checksum(content: bytes) -> str:
    """SHA-256 of a file's bytes with its own checksum taken as zeros. Raises FlatError."""
    start = checksum_start(content)
    return hashlib.sha256(
        content[:start] + NO_CHECKSUM.encode() + content[start + len(NO_CHECKSUM) :]
    ).hexdigest()


def checksum_start(content: bytes) -> int:
    """Position of the checksum's digits. Raises FlatError."""
    span = metadata_span(content, METADATA_NAME)
    # The last one: text of the metadata before it may contain anything.
    found = -1 if span is None else span.of(content).rfind(_CHECKSUM_KEY)
    if span is None or found < 0:
        raise FlatError("has no checksum")
    return span.start + found + len(_CHECKSUM_KEY)


def _read(path: Path, follow: bool) -> bytes:
    try:
        return read_plain(path, LARGEST_BYTES, follow)
    except TooLong:
        raise NetworkError(
            f"{path}: has more than {LARGEST_BYTES} bytes; a network has a few thousand"
        ) from None


def _parse(text: bytes, where: str) -> NetworkMetadata:
    try:
        return NetworkMetadata.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        key = ".".join(str(part) for part in first["loc"])
        raise NetworkError(
            f"{where}: its metadata cannot be used ({key + ': ' if key else ''}{first['msg']}); "
            "it is broken or of another version, train it again"
        ) from None
