"""Files that clients name or send: only plain ones, and sent text under a safe name."""

from __future__ import annotations

import hashlib
import os
import re
import stat
from pathlib import Path

from deltactl.foundation.errors import ConfigError, MissingFile, ServiceError
from deltactl.foundation.plain_file import write_whole

SUFFIXES = (".yaml", ".yml")
MOST_BYTES = 4 * 2**20
"""A survey of 100 000 poses written out is about 3 MB."""
KEPT = 100
"""So many sent jobs are kept; the oldest go first."""


def check_job(named: str) -> Path:
    """A job file the daemon may read. Raises ConfigError, or MissingFile when it cannot be read.

    Whatever is no plain file (a pipe, a device) would hold up everybody.
    """
    path = Path(named)
    if not path.is_absolute():
        raise ConfigError(f"{named}: the daemon needs the whole path, from / on")
    if path.suffix not in SUFFIXES:
        raise ConfigError(f"{named}: a job file is named *.yaml")
    try:
        found = path.lstat()
    except OSError as error:
        raise MissingFile(f"{named}: the daemon cannot read it ({error.strerror})") from error
    if path.resolve() != path:
        # The client sends its text then; what lies behind a link is nobody's business here.
        raise MissingFile(f"{named}: is reached through a link; name the file itself")
    if not stat.S_ISREG(found.st_mode):
        raise ConfigError(f"{named}: is no plain file")
    if found.st_size > MOST_BYTES:
        raise ConfigError(f"{named}: is larger than {MOST_BYTES // 2**20} MB; split the job")
    if not os.access(path, os.R_OK):
        raise MissingFile(f"{named}: the daemon may not read it (permission denied)")
    return path


class JobStore:
    """Keeps texts that were sent, in one folder of the daemon."""

    def __init__(self, folder: Path):
        self._folder = folder

    def within(self, name: str) -> JobStore:
        """One for texts of another kind, in a folder inside."""
        return JobStore(self._folder / name)

    def keep(self, text: str, name: str) -> Path:
        """Write the text under a name of its own. Raises ServiceError when it cannot."""
        raw = text.encode()
        plain = re.sub(r"[^A-Za-z0-9_-]+", "-", Path(name).stem).strip("-")[:40] or "job"
        path = self._folder / f"{plain}-{hashlib.sha256(raw).hexdigest()[:12]}.yaml"
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            write_whole(path, raw)
            self._thin_out()
        except OSError as error:
            raise ServiceError(
                f"{path}: cannot be stored ({error.strerror}); make room or mend the folder"
            ) from error
        return path

    def _thin_out(self) -> None:
        kept = sorted(self._folder.glob("*.yaml"), key=lambda path: path.stat().st_mtime_ns)
        for path in kept[:-KEPT]:
            path.unlink(missing_ok=True)
