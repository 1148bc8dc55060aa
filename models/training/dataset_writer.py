"""Appends to a data set so that nothing that was taken is lost, whatever happens to the program."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType

import yaml

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.strict_yaml import Document
from deltactl.models.robot import FloatArray
from deltactl.models.training.dataset import (
    HEADER,
    SAMPLES,
    SETTINGS,
    DataSet,
    DataSettings,
    IntArray,
    parse_lines,
    whole_lines,
)

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

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
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
