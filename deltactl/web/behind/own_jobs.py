"""Jobs that people keep on the page: texts in a folder of its own, by their names."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Final

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.plain_file import write_whole

ENDING: Final = ".yaml"
NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,58}")
MOST: Final = 200
MAX_CHARACTERS: Final = 60_000
"""What the daemon takes of a job's text."""


class OwnJobs:
    """A folder. `taken` gives the names of files that are not here, which stay theirs."""

    def __init__(self, folder: Path, taken: Callable[[], Collection[str]]):
        self._folder, self._taken = folder, taken

    def files(self) -> dict[str, Path]:
        """All of them by name, in alphabetical order."""
        return {path.name: path for path in sorted(self._folder.glob(f"*{ENDING}"))}

    def read(self, name: str) -> str:
        """The text of one. Raises ConfigError where there is none."""
        return self._known(name).read_text(encoding="utf-8")

    def save(self, name: str, text: str) -> str:
        """Keep a text under a name, which is returned in full. Raises ConfigError."""
        path = self._free(name)
        if len(text) > MAX_CHARACTERS:
            raise ConfigError(f"{path.name}: a job may have {MAX_CHARACTERS:,} characters")
        if not path.exists() and len(self.files()) >= MOST:
            raise ConfigError(f"{MOST} jobs are kept already; delete some first")
        self._folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, text.encode("utf-8", errors="replace"))
        return path.name

    def rename(self, name: str, wanted: str) -> str:
        """Another name for one; replaces none. Raises ConfigError."""
        path, target = self._known(name), self._free(wanted)
        if target == path:
            return path.name
        if target.exists():
            raise ConfigError(f"{target.name}: there is such a job already; choose another name")
        path.rename(target)
        return target.name

    def delete(self, name: str) -> None:
        """Forget one. Raises ConfigError where there is none."""
        self._known(name).unlink(missing_ok=True)

    def _known(self, name: str) -> Path:
        found = self.files().get(name)
        if found is None:
            raise ConfigError(f"{name[:60]!r}: there is no such job of yours")
        return found

    def _free(self, name: str) -> Path:
        """Where a job of that name is kept. Raises ConfigError for what is no plain name."""
        stem = name.strip().removesuffix(ENDING)
        if not NAME.fullmatch(stem):
            raise ConfigError(
                f"{name[:60]!r}: a job's name has letters, digits, blanks and . _ -, 59 at most"
            )
        if f"{stem}{ENDING}" in self._taken():
            raise ConfigError(
                f"{stem}{ENDING} belongs to the robot or the program; choose another name"
            )
        return self._folder / f"{stem}{ENDING}"
