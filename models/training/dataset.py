"""A data set: commanded counts with the positions that were measured there, as a folder.

    settings.yaml   robot, machine, seed, sensors, T_PWM, versions: all that is needed to repeat it
    samples.csv     number, counts [steps], measured position [m] in the robot's frame

Samples are appended as they are taken. A line counts once its line break is written: a torn last
line (power cut, full disk) is left out on reading and cut off on going on.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import yaml
from pydantic import Field

from deltactl.foundation.errors import MissingFile, RecordingError
from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.strict_yaml import Document, StrictModel
from deltactl.models.network.metadata import fingerprint
from deltactl.models.robot import (
    ARMS,
    DeltaRobot,
    DriveSection,
    FloatArray,
    Geometry,
    Sensors,
    per_arm,
)

IntArray = np.ndarray[Any, np.dtype[np.int64]]
BoolArray = np.ndarray[Any, np.dtype[np.bool_]]
SETTINGS, SAMPLES = "settings.yaml", "samples.csv"
HEADER = "number,steps_1,steps_2,steps_3,x_m,y_m,z_m"
FEWEST = 50
"""Fewer samples than this fit neither a network nor a calibration."""

Text = Annotated[str, Field(min_length=1, max_length=200)]


class DataSettings(StrictModel):
    """How a data set was taken."""

    format: Literal[1] = 1
    robot: Text
    fingerprint: str
    """`deltactl.models.network.metadata.fingerprint` of `geometry`."""
    geometry: Geometry
    drive: DriveSection
    sensors: Sensors
    """The sensors of the robot file when ranges became positions."""
    machine: Literal["robot", "simulated", "as-built"]
    """The robot itself, its simulated chain, or the MuJoCo robot as it was built."""
    as_built: str = ""
    """Name and digest of the file that says how the MuJoCo robot was built."""
    source: Text = "survey"
    """What was commanded: a survey of random arm angles, or a curve."""
    seed: Annotated[int, Field(ge=0)]
    angle_deg: tuple[float, float]
    t_pwm_s: Annotated[float, Field(gt=0.0)]
    dwell_s: Annotated[float, Field(ge=0.0)]
    versions: dict[str, str] = Field(default_factory=dict)

    @property
    def machine_words(self) -> str:
        """Which machine was measured; of real ones of one design and name nothing tells which."""
        return f"{self.machine} {self.as_built}".strip()


@dataclass(frozen=True, eq=False)
class DataSet:
    """counts: (n, 3) [steps], position_m: (n, 3) measured [m], in the order in which they came."""

    folder: Path
    settings: DataSettings
    counts: IntArray
    position_m: FloatArray
    torn: bool = False
    """Whether a torn last line was left out."""

    def __len__(self) -> int:
        return len(self.counts)

    @property
    def angles_rad(self) -> FloatArray:
        """Commanded arm angles, (n, 3)."""
        return self.counts * self.settings.drive.rad_per_step

    def first(self, count: int) -> DataSet:
        """The first samples: what a shorter collection with the same seed would have given."""
        return replace(self, counts=self.counts[:count], position_m=self.position_m[:count])

    @property
    def digest(self) -> str:
        """16 hex digits of settings and samples; a network's file names the data it is from."""
        lines = yaml.safe_dump(self.settings.model_dump(mode="json"), sort_keys=True).encode()
        numbers = self.counts.astype("<i8").tobytes() + self.position_m.astype("<f8").tobytes()
        return hashlib.sha256(lines + numbers).hexdigest()[:16]

    def check(self, robot: DeltaRobot | None = None, fewest: int = FEWEST) -> None:
        """Raise RecordingError, in one line, where nothing could be learned from the samples."""
        where = self.folder / SAMPLES
        if robot is not None and (
            robot.name != self.settings.robot
            or fingerprint(robot.geometry) != self.settings.fingerprint
        ):
            raise RecordingError(
                f"{self.folder}: was taken with robot '{self.settings.robot}' "
                f"({self.settings.fingerprint}), not with '{robot.name}' "
                f"({fingerprint(robot.geometry)}); name that robot's file or collect again"
            )
        if len(self) < fewest:
            raise RecordingError(
                f"{where}: has {len(self)} samples and {fewest} are needed; "
                "go on with deltactl network collect"
            )
        self.check_rows()
        for name, column in zip(HEADER.split(",")[1:], self._columns(), strict=True):
            if np.ptp(column) == 0.0:
                raise RecordingError(
                    f"{where}: column {name} is the same in all samples; that motor or sensor "
                    "did not work, collect again"
                )

    def check_rows(self) -> None:
        """Raise RecordingError for the first sample that no collection writes."""
        where = self.folder / SAMPLES
        bad = ~np.isfinite(self.position_m).all(axis=1)
        if bad.any():
            raise RecordingError(
                f"{where}: sample {int(np.argmax(bad)) + 1} has no position (NaN); the file was "
                "changed, restore it or collect into another folder"
            )
        astray = self._astray()
        if astray.any():
            raise RecordingError(
                f"{where}: sample {int(np.argmax(astray)) + 1} is none of this robot (turned or "
                "gone further than its arms can); the file was changed, restore it or collect "
                "into another folder"
            )

    def _astray(self) -> BoolArray:
        """Rows (n,) no survey writes: beyond a whole turn, or twice as far as the arms reach."""
        own = self.settings.geometry
        arms_m = own.radius_m + per_arm(own.upper_arm_m) + per_arm(own.forearm_m)
        turned = np.abs(self.angles_rad).max(axis=1) > 2.0 * np.pi
        gone = np.abs(self.position_m).max(axis=1) > 2.0 * arms_m.max()
        astray: BoolArray = turned | gone
        return astray

    def _columns(self) -> list[Any]:
        return [*self.counts.T, *self.position_m.T]


def load_dataset(folder: Path) -> DataSet:
    """Read a data set. Raises MissingFile, ConfigError or RecordingError, each in one line."""
    settings = Document.read(folder / SETTINGS).check(DataSettings)
    text, torn = whole_lines(_read(folder / SAMPLES))
    counts, position_m = parse_lines(text, folder / SAMPLES)
    return DataSet(folder, settings, counts, position_m, torn)


def whole_lines(content: bytes) -> tuple[bytes, bool]:
    """Content up to its last line break, and whether anything stood behind it."""
    end = content.rfind(b"\n") + 1
    return content[:end], end < len(content)


def parse_lines(content: bytes, where: Path) -> tuple[IntArray, FloatArray]:
    """Counts and positions of whole lines. Raises RecordingError naming the first bad line."""
    lines = content.decode("utf-8", "replace").splitlines()
    if lines[:1] not in ([], [HEADER]):
        raise RecordingError(f"{where}:1: must be '{HEADER}'; this is not a data set's file")
    counts = np.empty((max(len(lines) - 1, 0), ARMS), dtype=np.int64)
    position_m = np.empty(counts.shape)
    for row, line in enumerate(lines[1:]):
        parts = line.split(",")
        try:
            if len(parts) != 7 or int(parts[0]) != row + 1:
                raise ValueError
            counts[row] = [int(part) for part in parts[1:4]]
            position_m[row] = [float(part) for part in parts[4:]]
        except (ValueError, OverflowError):
            raise RecordingError(
                f"{where}:{row + 2}: is not sample {row + 1} ('{line[:60]}'); "
                "the file was changed or damaged, restore it or collect again"
            ) from None
    return counts, position_m


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        reason = error.strerror or str(error)
        raise MissingFile(f"{path}: cannot be read ({reason}); check the path") from error


Sample = tuple[IntArray, FloatArray]
"""Counts (3,) and measured position (3,) [m]."""
VOLATILE = ("versions",)
"""Settings that may differ between the parts of one collection."""


class DataSetWriter:
    """Begins a data set or goes on with one.

    Raises RecordingError when the folder holds a data set with other settings or a damaged one, or
    when nothing can be written.
    """

    def __init__(self, folder: Path, settings: DataSettings):
        self.folder, self.path = folder, folder / SAMPLES
        self._end = 0
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._settle(settings)
            self._file = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise self._failed(error) from error
        try:
            self.count = self._resume(settings)
        except BaseException:
            os.close(self._file)
            raise

    def __enter__(self) -> DataSetWriter:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._file)

    def append(self, samples: Iterable[Sample]) -> None:
        """Write samples and make sure they are on the disk. Raises RecordingError.

        After a failure the file ends with the last whole line.
        """
        lines = ""
        count = self.count
        for counts, position_m in samples:
            count += 1
            steps = ",".join(str(int(value)) for value in counts)
            lines += f"{count},{steps},{','.join(f'{value:.6f}' for value in position_m)}\n"
        self._write(lines.encode())
        self.count = count

    def keep(self, count: int) -> None:
        """Leave only the first samples. Raises RecordingError."""
        content = os.pread(self._file, self._end, 0)
        lines = content.splitlines(keepends=True)[: count + 1]
        self._end = sum(map(len, lines))
        try:
            os.ftruncate(self._file, self._end)
        except OSError as error:
            raise self._failed(error) from error
        self.count = min(count, self.count)

    def _settle(self, settings: DataSettings) -> None:
        path = self.folder / SETTINGS
        if path.exists():
            before = Document.read(path).check(DataSettings)
            for name in DataSettings.model_fields:
                had, has = getattr(before, name), getattr(settings, name)
                if name not in VOLATILE and had != has:
                    raise RecordingError(
                        f"{path}: this data set was begun with another {name} ({had}, now {has}); "
                        "collect into another folder"
                    )
            return
        if self.path.exists():
            raise RecordingError(f"{self.path}: is there without {SETTINGS}; use another folder")
        text = yaml.safe_dump(settings.model_dump(mode="json"), sort_keys=False)
        write_whole(path, text)

    def _resume(self, settings: DataSettings) -> int:
        size = os.fstat(self._file).st_size
        content, _ = whole_lines(os.pread(self._file, size, 0))
        counts, position_m = parse_lines(content, self.path)
        DataSet(self.folder, settings, counts, position_m).check_rows()
        self._end = len(content)
        os.ftruncate(self._file, self._end)
        if not content:
            self._write(f"{HEADER}\n".encode())
        return len(counts)

    def _write(self, content: bytes) -> None:
        try:
            written = 0
            while written < len(content):
                written += os.pwrite(self._file, content[written:], self._end + written)
            os.fsync(self._file)
        except OSError as error:
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, self._end)
            raise self._failed(error) from error
        self._end += len(content)

    def _failed(self, error: OSError) -> RecordingError:
        reason = error.strerror or str(error)
        return RecordingError(
            f"{self.folder}: cannot be written ({reason}); what was taken before is kept, "
            "the same command goes on from there"
        )
