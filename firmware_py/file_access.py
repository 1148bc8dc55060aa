"""How files are opened for somebody who may not be allowed to read them himself."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from deltactl.firmware_py.named_files import CONFIG_FOLDER, TRAINED_FOLDER
from deltactl.foundation.errors import ConfigError, MissingFile, NetworkError
from deltactl.foundation.strict_yaml import MAX_BYTES, Document

EVERYBODYS = (CONFIG_FOLDER, TRAINED_FOLDER)
"""Folders of the program: what stands there is no secret."""


@dataclass(frozen=True, slots=True)
class FileAccess:
    """How a file is opened; as they are, for a person who runs the program himself."""

    follow: bool = True
    """Whether links may lead to it."""
    quote: bool = True
    """Whether a refusal may say what stands in it."""
    most_bytes: int = MAX_BYTES
    _read: dict[Path, Document | ConfigError] = field(
        default_factory=dict, repr=False, compare=False
    )

    def document(self, path: Path) -> Document:
        """A file, read once however often it is asked for. Raises MissingFile, ConfigError."""
        place = path.absolute()
        if place not in self._read:
            try:
                self._read[place] = Document.read(path, self.follow, self.most_bytes)
            except ConfigError as error:
                self._read[place] = error
        found = self._read[place]
        if isinstance(found, ConfigError):
            raise found
        return found

    @property
    def named(self) -> FileAccess:
        """For files that such a file names: whoever sent a text to the daemon wrote only that."""
        return replace(self, quote=self.quote and self.follow)


@contextmanager
def without_quoting(path: Path, how: FileAccess) -> Iterator[None]:
    """Where quoting is forbidden, refuse a file without a word of what stands in it."""
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
