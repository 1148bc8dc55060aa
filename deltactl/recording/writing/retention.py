"""Names of new recordings, and how long they are kept: old ones make room for new ones."""

from __future__ import annotations

import contextlib
import datetime
import fcntl
import itertools
import logging
import os
import re
import shutil
import stat
import threading
import time
from collections.abc import Callable, Container, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.strict_yaml import StrictModel

ENDING = ".mcap"
LONGEST = 200
"""Characters; file systems take 255 bytes."""
_PLAIN = re.compile(r"[^\x00-\x1f\x7f/\\]+")
_NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9._-]+")


def confined(folder: Path, wanted: str) -> Path:
    """Path of a recording that somebody asked for: directly in the folder, whatever they wrote.

    `wanted` is a name, or a whole path that lies there. Creating it afterwards must not follow
    links (AppendFile does not). Raises RecordingError.
    """
    given = Path(wanted)
    home = folder.absolute()
    if given.is_absolute() and given.parent in (home, home.resolve()):
        given = Path(given.name)
    name = given.name if given.suffix == ENDING else f"{given.name}{ENDING}"
    if given.name != str(given) or not _PLAIN.fullmatch(name) or name.startswith("."):
        raise RecordingError(
            f"{wanted[:LONGEST]!r}: recordings lie directly in {home}; give a plain name"
        )
    if len(name) > LONGEST:
        raise RecordingError(f"the name of a recording may have {LONGEST} characters; shorten it")
    return home / name


def fresh_path(
    folder: Path,
    job_name: str,
    start: datetime.datetime | None = None,
    taken: Container[Path] = (),
) -> Path:
    """`folder/<job>-<date>T<time>.mcap`, with a number behind when that is there or taken."""
    start = start or datetime.datetime.now()
    plain = _NOT_IN_NAMES.sub("-", job_name).strip("-.") or "run"
    stem = f"{plain}-{start:%Y-%m-%dT%H-%M-%S}"
    for number in itertools.count(1):
        path = folder / (f"{stem}.mcap" if number == 1 else f"{stem}-{number}.mcap")
        if path not in taken and not path.exists():
            return path
    raise AssertionError("numbers do not end")


@dataclass(frozen=True, slots=True)
class _Old:
    path: Path
    size: int
    modified_s: float


def prune(
    folder: Path,
    max_bytes: int | None = None,
    max_age_s: float | None = None,
    keep_free_bytes: int = 0,
    now_s: float | None = None,
) -> list[Path]:
    """Delete the oldest `.mcap` files of a folder until every limit given is kept.

    Only plain files directly in `folder`; never one that is being written (it is locked), and
    never the newest. Which is older goes by the order in which they were first seen here, not by
    a clock that may have been set back. Returns what was deleted, oldest first; what cannot be
    deleted is left.
    """
    now_s = time.time() if now_s is None else now_s
    found = in_sequence(folder, _recordings(folder))
    total = sum(old.size for old in found)
    deleted: list[Path] = []
    for old in found[:-1]:
        too_old = max_age_s is not None and now_s - old.modified_s > max_age_s
        too_many = max_bytes is not None and total > max_bytes
        too_full = shutil.disk_usage(folder).free < keep_free_bytes
        if (too_old or too_many or too_full) and _delete(old.path):
            deleted.append(old.path)
            total -= old.size
    return deleted


SEQUENCE = ".sequence"
"""Names of the recordings of a folder in the order in which they came, one a line."""
MOST_BYTES = 16 * 2**20


def in_sequence(folder: Path, found: list[_Old]) -> list[_Old]:
    """Recordings in the order in which they came; new ones, by their times, are put at the end."""
    known = _known(folder)
    place = {name: number for number, name in enumerate(known)}
    ordered = sorted(found, key=lambda old: (place.get(old.path.name, len(place)), old.modified_s))
    names = [old.path.name for old in ordered]
    if names != known:
        _remember(folder, names)
    return ordered


def _known(folder: Path) -> list[str]:
    try:
        descriptor = os.open(folder / SEQUENCE, os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW)
    except OSError:
        return []
    with os.fdopen(descriptor, "rb") as file:
        return file.read(MOST_BYTES).decode("utf-8", "surrogateescape").split("\n")[:-1]


def _remember(folder: Path, names: list[str]) -> None:
    """A folder that may not be written is looked through all the same."""
    text = "".join(f"{name}\n" for name in names if "\n" not in name)
    with contextlib.suppress(OSError):
        data = text.encode("utf-8", "surrogateescape")
        write_whole(folder / SEQUENCE, data, follow=False, mode=0o640)


def _recordings(folder: Path) -> list[_Old]:
    if not folder.is_dir():
        return []
    found = []
    for path in folder.glob("*.mcap"):
        with contextlib.suppress(FileNotFoundError):  # somebody else deleted it meanwhile
            state = path.lstat()
            if stat.S_ISREG(state.st_mode):
                found.append(_Old(path, state.st_size, state.st_mtime))
    return found


def _delete(path: Path) -> bool:
    """Delete unless a recorder holds it."""
    try:
        with _whole(path):
            path.unlink()
    except (OSError, RecordingError):
        return False
    return True


@contextlib.contextmanager
def _whole(path: Path) -> Iterator[None]:
    """Hold a recording that no recorder holds. Raises RecordingError, or OSError."""
    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW)
    try:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise RecordingError(f"{path.name}: is no plain file")
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise RecordingError(f"{path.name}: is being recorded; wait for its end") from error
        yield
    finally:
        os.close(descriptor)


def delete(folder: Path, name: str) -> None:
    """Delete a recording of the folder. Raises RecordingError where it cannot be."""
    path = confined(folder, name)
    with _said(path), _whole(path):
        path.unlink()


def rename(folder: Path, name: str, wanted: str) -> Path:
    """Give a recording of the folder another name. Raises RecordingError where it cannot be."""
    path, target = confined(folder, name), confined(folder, wanted)
    with _said(path), _whole(path):
        try:
            os.link(path, target, follow_symlinks=False)  # other than a rename it replaces nothing
        except FileExistsError as error:
            raise RecordingError(
                f"{target.name}: there is such a recording already; choose another name"
            ) from error
        path.unlink()
    return target


@contextlib.contextmanager
def _said(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise RecordingError(f"{path.name}: {error.strerror}; look at the list again") from error


GIB = 2**30
DAY_S = 86_400.0
LOOK_S = 60.0
"""A minute of recording is some 2 MB: no limit is passed by more than that."""

_log = logging.getLogger(__name__)


class KeptRecordings(StrictModel):
    """What the daemon keeps in its folder of recordings; the oldest go first, the newest never."""

    max_gib: Annotated[
        float, Field(ge=0.01, le=1e5, description="GiB; an hour of running is about 0.06")
    ] = 16.0
    """All recordings together."""
    max_age_days: (
        Annotated[float, Field(ge=0.001, le=36_500.0, description="days; a minute to a century")]
        | None
    ) = None
    """Absent: as long as there is room."""
    keep_free_gib: Annotated[
        float, Field(ge=0.0, le=1e5, description="GiB; below 0.06 no recording is begun")
    ] = 1.0
    """Left free on that disk: a Pi with a full card does not boot."""


class RecordingKeeper:
    """Deletes what may no longer stay, now and then, in a thread of its own.

    What cannot be deleted is left and looked at again the next time; nothing is ever raised.
    """

    def __init__(
        self,
        folder: Path,
        kept: KeptRecordings,
        now_s: Callable[[], float] = time.time,
        period_s: float = LOOK_S,
    ):
        self._folder, self._kept = folder, kept
        self._now_s, self._period_s = now_s, period_s
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="recordings", daemon=True)

    def start(self) -> None:
        """Begin, with a look at once."""
        self._thread.start()

    def close(self, timeout_s: float = 2.0) -> None:
        """End; safe without `start`, and twice."""
        self._ending.set()
        if self._thread.is_alive():
            self._thread.join(timeout_s)

    def tidy(self) -> list[Path]:
        """Look once; returns what was deleted."""
        kept, days = self._kept, self._kept.max_age_days
        try:
            gone = prune(
                self._folder,
                max_bytes=round(kept.max_gib * GIB),
                max_age_s=None if days is None else days * DAY_S,
                keep_free_bytes=round(kept.keep_free_gib * GIB),
                now_s=self._now_s(),
            )
        except OSError as error:
            _log.warning("%s: cannot be looked through (%s)", self._folder, error.strerror)
            return []
        for path in gone:
            _log.info("%s: deleted to make room, as 'recordings' of the robot file says", path)
        return gone

    def _run(self) -> None:
        while True:
            self.tidy()
            if self._ending.wait(self._period_s):
                return
