"""How files are opened for somebody who may not be allowed to read them himself."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

from deltactl.firmware_py.named_files import CONFIG_FOLDER, TRAINED_FOLDER
from deltactl.firmware_py.robot_file import RobotFile, robot_in
from deltactl.foundation.errors import ConfigError, DeltactlError, MissingFile, NetworkError
from deltactl.foundation.strict_yaml import MAX_BYTES, Document

MadeT = TypeVar("MadeT")

EVERYBODYS = (CONFIG_FOLDER, TRAINED_FOLDER)
"""Folders of the program: their contents are no secret."""


@dataclass(frozen=True, slots=True)
class FileAccess:
    """How a file is opened; as they are, for a person who runs the program himself."""

    follow: bool = True
    """Whether links may lead to it."""
    quote: bool = True
    """Whether a refusal may quote its contents."""
    most_bytes: int = MAX_BYTES
    _made: dict[tuple[str, Path], Any] = field(default_factory=dict, repr=False, compare=False)

    def document(self, path: Path) -> Document:
        """A file, read once however often it is asked for. Raises MissingFile, ConfigError."""
        return self.once("document", path, lambda: self._document(path))

    def _document(self, path: Path) -> Document:
        self.stamp(path)  # whatever is written later is newer
        return Document.read(path, self.follow, self.most_bytes)

    def robot(self, path: Path) -> RobotFile:
        """A robot file, read and checked once. Raises MissingFile, ConfigError."""
        return self.once("robot", path, lambda: robot_in(self.document(path)))

    def stamp(self, path: Path) -> Stamp:
        """Stamp of a file before it was read here."""
        return self.once("stamp", path, lambda: stamp_of(path))

    def once(self, kind: str, path: Path, make: Callable[[], MadeT]) -> MadeT:
        """What is made of a file, the same however often it is asked for; a refusal too."""
        key = (kind, path.absolute())
        if key not in self._made:
            try:
                self._made[key] = make()
            except (ConfigError, NetworkError) as error:
                self._made[key] = error
        found = self._made[key]
        if isinstance(found, DeltactlError):
            raise found
        made: MadeT = found
        return made

    @property
    def named(self) -> FileAccess:
        """For files that such a file names: whoever sent a text to the daemon wrote only that."""
        return replace(self, quote=self.quote and self.follow)


Stamp = tuple[int, int, int]


def stamp_of(path: Path) -> Stamp:
    """What changes when a file is written to; zeros where there is none."""
    try:
        found = os.stat(path)
    except OSError:
        return 0, 0, 0
    return found.st_mtime_ns, found.st_size, found.st_ino


@contextmanager
def without_quoting(path: Path, how: FileAccess) -> Iterator[None]:
    """Where quoting is forbidden, refuse a file without a word of its contents."""
    try:
        yield
    except MissingFile:
        raise
    except (ConfigError, NetworkError) as error:
        if how.quote or Path(os.path.abspath(path)).parent in EVERYBODYS:
            raise
        line = re.match(re.escape(str(path)) + r":\d+", str(error))
        raise type(error)(
            f"{line.group() if line else path}: is not as such a file should be;"
            " 'deltactl check' of the job says what is wrong, if you may read it"
        ) from None
