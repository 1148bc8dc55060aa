"""Parquet and MATLAB files, and the folders of Parquet that LeRobot data sets are.

Both formats need the `tables` extra and say so when it is absent. LeRobot's versions 2 (a file an
episode) and 3 (several episodes a file) have what their columns are in `meta/info.json`:
https://huggingface.co/docs/lerobot/lerobot-dataset-v3
"""

from __future__ import annotations

import importlib
import json
import math
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.extras import how_to_install
from deltactl.foundation.plain_file import whole_file
from deltactl.recording.tables.flat import (
    MOST_COLUMNS,
    UNITS,
    AnyArray,
    FlatRecording,
    from_columns,
)

INFO = Path("meta", "info.json")
JOINTS = ("action", "observation.state")
"""Features with one value a joint: what was asked of them, and what came of it."""
FOLDERS_UP = 3
"""From a file of a data set to its folder: data/chunk-000/file-000.parquet."""


def is_data_set(path: Path) -> bool:
    """Whether a path is the folder of a LeRobot data set."""
    return (path / INFO).is_file()


def one_joint_at_a_time(path: Path) -> RecordingError:
    """What is said where a whole data set is to be diagnosed."""
    return RecordingError(
        f"{path}: is a LeRobot data set; one of its joints is diagnosed at a time;"
        f" which options choose it: deltactl inspect {path}"
    )


def files_of(path: Path) -> list[Path]:
    """The tables of a data set, in the order of their episodes; raises RecordingError without any.

    Files whose data were not fetched (Git LFS) are refused where they are read.
    """
    files = sorted((path / "data").glob("*/*.parquet"))
    if not files:
        raise RecordingError(
            f"{path}: is a LeRobot data set without data/chunk-*/*.parquet; fetch those files too"
        )
    return files


def names_of(path: Path) -> dict[str, list[str]]:
    """Names of the joints by feature, of a data set or of a file in one; empty where none is said.

    Raises RecordingError where meta/info.json is not what it should be.
    """
    folders = [path, *path.resolve().parents[:FOLDERS_UP]]
    folder = next((one for one in folders if is_data_set(one)), None)
    if folder is None:
        return {}
    try:
        features = json.loads((folder / INFO).read_text(encoding="utf-8"))["features"]
        found = {name: _listed(features[name].get("names")) for name in JOINTS if name in features}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise RecordingError(f"{folder / INFO}: is not that of a LeRobot data set") from error
    return {name: names for name, names in found.items() if names}


def _listed(names: Any) -> list[str]:
    """Names of joints: a list, or a list under a heading such as `motors` (version 2.0)."""
    if isinstance(names, Mapping):
        names = next(iter(names.values()), [])
    plain = isinstance(names, list) and all(isinstance(name, str) for name in names)
    return names if plain and len(set(names)) == len(names) else []


MOST_CELLS = 80_000_000
"""A day at 50 Hz in eighteen columns; twice 0.6 GB in memory while it is read."""


def parquet_columns(path: Path) -> dict[str, AnyArray]:
    """Columns of a Parquet file, whatever they are called. Raises RecordingError."""
    parquet = _needs("pyarrow.parquet", "pyarrow", path)
    arrow = _needs("pyarrow", "pyarrow", path)
    try:
        facts = parquet.read_metadata(path)
        check_size(path, facts.num_rows, facts.num_columns)
        table = parquet.read_table(path)
        return {name: _from_arrow(table.column(name)) for name in table.column_names}
    except (OSError, arrow.ArrowException) as error:
        raise RecordingError(f"{path}: is not a readable Parquet file ({_first(error)})") from error


def write_parquet(recording: FlatRecording, path: Path) -> None:
    """Write a Parquet file. Raises RecordingError."""
    parquet = _needs("pyarrow.parquet", "pyarrow", path)
    arrow = _needs("pyarrow", "pyarrow", path)
    try:
        with whole_file(path) as out:
            parquet.write_table(arrow.table(_all(recording)), out)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written ({error.strerror})") from error


def read_mat(path: Path) -> FlatRecording:
    """Read a MATLAB file whose variables are the columns. Raises RecordingError."""
    matlab = _needs("scipy.io", "scipy", path)
    try:
        for name, shape, _ in matlab.whosmat(path):
            check_size(path, math.prod(shape), 1, f"variable '{name}' of ")
        found: dict[str, Any] = matlab.loadmat(path, squeeze_me=False)
    except RecordingError:
        raise
    except Exception as error:  # scipy raises nearly anything for a damaged file
        raise RecordingError(f"{path}: is not a readable .mat file ({_first(error)})") from error
    columns = {
        name: np.ravel(values) for name, values in found.items() if not name.startswith("__")
    }
    return from_columns(_of_one_length(path, columns), str(path))


def check_size(path: Path, rows: int, columns: int, what: str = "") -> None:
    """Refuse what would not fit into memory. Raises RecordingError."""
    if columns > MOST_COLUMNS or rows * columns > MOST_CELLS:
        raise RecordingError(
            f"{path}: {what}{rows} rows of {columns} columns are more than can be read "
            f"({MOST_COLUMNS} columns, {MOST_CELLS} cells); cut it up"
        )


def write_mat(recording: FlatRecording, path: Path) -> None:
    """Write a MATLAB file with one column vector a column. Raises RecordingError."""
    matlab = _needs("scipy.io", "scipy", path)
    try:
        with whole_file(path) as out:
            matlab.savemat(out, _all(recording), oned_as="column", do_compression=True)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written ({error.strerror})") from error


def _all(recording: FlatRecording) -> dict[str, AnyArray]:
    return {"t": recording.t_s, **recording.columns, **recording.extra}


def _from_arrow(column: Any) -> AnyArray:
    values = column.to_numpy()
    if values.dtype.kind == "O" and all(value is None for value in values):
        return np.full(len(values), np.nan)
    return np.asarray(values)


def _of_one_length(path: Path, columns: dict[str, AnyArray]) -> dict[str, AnyArray]:
    """The columns as long as `t`; a MATLAB file may hold other variables beside them."""
    rows = len(columns.get("t", ()))
    for name, values in columns.items():
        if name in UNITS and "t" in columns and len(values) != rows:
            raise RecordingError(f"{path}: {name} has {len(values)} values, t has {rows}")
    return {name: values for name, values in columns.items() if len(values) == rows}


def _needs(module: str, package: str, path: Path) -> ModuleType:
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise RecordingError(
            f"{path}: {path.suffix} files need {package}, which is not installed; use .csv.gz, or "
            f"type: {how_to_install('tables')}"
        ) from error
    except ImportError as error:
        raise RecordingError(f"{path}: {package} does not load ({_first(error)})") from error


def _first(error: BaseException) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0][:200]
