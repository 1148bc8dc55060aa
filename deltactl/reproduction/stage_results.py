"""Results of long stages on disk: worked out once, then read again until their causes change."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.plain_file import whole_file

Arrays = dict[str, np.ndarray[Any, Any]]
MARK = "mark"


def kept(path: Path, mark: str, make: Callable[[], Arrays]) -> Arrays:
    """Arrays of `path` (.npz) if it carries this mark; made and written otherwise.

    mark: everything the result depends on, in one line. Raises RecordingError on a full disk.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            found = {name: file[name] for name in file.files}
        if str(found.pop(MARK, "")) == mark:
            return found
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        pass
    made = make()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as stream:
            np.savez(stream, **{MARK: np.array(mark), **made})
    except OSError as error:
        raise RecordingError(
            f"{path}: cannot be written ({error.strerror or error}); make room, the same command "
            "goes on from here"
        ) from error
    return made
