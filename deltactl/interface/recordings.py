"""Recordings as a notebook has them: read from files, from data frames, and back."""

from __future__ import annotations

import html
import tempfile
import warnings
from collections.abc import Mapping as AnyMapping
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from deltactl.foundation.errors import ConfigError, DeltactlError, RecordingError
from deltactl.foundation.extras import needs
from deltactl.foundation.printable import count
from deltactl.foundation.release import OF_A_RESULT
from deltactl.interface import older
from deltactl.recording.tables.flat import UNITS, FlatRecording, from_columns

if TYPE_CHECKING:
    import pandas as pd

    from deltactl.firmware_py.controller.contract import JobResult
    from deltactl.recording.foreign.found import Inspection
    from deltactl.recording.tables.flat import AnyArray

AnyPath = str | Path
Columns = AnyMapping[str, str] | Sequence[str]
"""Column and unit for each name that the program knows, `{"position": "angle[deg]"}`; or the
`options` of an inspection."""
FRAME = "data frame"
"""Source of a recording that comes from no file."""


@dataclass(frozen=True, eq=False)
class Recording:
    """Samples of one machine in SI units, one row a sample.

    Attributes
    ----------
    table : FlatRecording
        The arrays: `t_s` of shape (n,), and `columns`, by name, of shape (n,) each.
    notes : tuple of str
        What the reader found in the file and nobody said: separators, units in headings, gaps.
    ended : JobResult or None
        How the job ended, of a recording that `simulate` made.

    Examples
    --------
    >>> import deltactl as dc
    >>> import pandas as pd
    >>> frame = pd.DataFrame({"t": [0.0, 0.1], "command": [0.0, 0.02], "position": [0.0, 0.01]})
    >>> recording = dc.Recording.from_pandas(frame)
    >>> recording
    Recording('data frame': 2 rows in 0.1 s; command, position)
    >>> recording["command"]
    array([0.  , 0.02])
    """

    table: FlatRecording
    notes: tuple[str, ...] = ()
    ended: JobResult | None = None

    @classmethod
    def from_file(cls, path: AnyPath, columns: Columns | None = None) -> Recording:
        """Read a file; the same as `deltactl.read`."""
        return read(path, columns)

    @classmethod
    def from_pandas(
        cls, frame: pd.DataFrame, columns: Columns | None = None, source: str = FRAME
    ) -> Recording:
        """Make a recording of a data frame.

        Parameters
        ----------
        frame : pandas.DataFrame
            One row a sample. An index with a name is a column too.
        columns : mapping, optional
            As in `read`. Without it the columns must have the program's own names and SI units:
            `t` in s, and `command`, `position`, `steps_1`, `range_x`, ...
        source : str, optional
            What answers and messages call the recording.

        Raises
        ------
        RecordingError, ConfigError
            One line that says which column is missing or wrong.
        """
        whole = frame.reset_index() if frame.index.name else frame
        if columns:
            return _mapped_frame(whole, columns, source)
        named = {str(name): whole[name].to_numpy() for name in whole.columns}
        return cls(from_columns(named, source))

    @property
    def source(self) -> str:
        """The file it comes from, or what it is called."""
        return self.table.source

    @property
    def t(self) -> AnyArray:
        """Times [s], shape (n,), increasing."""
        return self.table.t_s

    @property
    def columns(self) -> list[str]:
        """Names of the columns that the program knows, without `t`."""
        return list(self.table.columns)

    def __getitem__(self, name: str) -> AnyArray:
        """One column, shape (n,). Raises KeyError, naming those that there are."""
        if name == "t":
            return self.table.t_s
        everything = {**self.table.extra, **self.table.columns}
        if name not in everything:
            raise KeyError(f"{name!r}; there are t, {', '.join(everything)}")
        return everything[name]

    def __len__(self) -> int:
        return len(self.table)

    def to_pandas(self) -> pd.DataFrame:
        """Every column as a data frame, `t` first; `attrs["units"]` has the units.

        Raises MissingExtra without pandas.
        """
        with needs("diagnosis", "to_pandas"):
            import pandas as pd

        columns = {"t": self.table.t_s, **self.table.columns, **self.table.extra}
        frame = pd.DataFrame(columns)
        frame.attrs["units"] = {name: UNITS[name] for name in columns if name in UNITS}
        return frame

    def save(self, path: AnyPath) -> None:
        """Write a `.csv`, `.csv.gz`, `.parquet` or `.mat` file; replaces it.

        Raises RecordingError when it cannot be written, or for another ending.
        """
        from deltactl.recording.tables.flat_files import write_flat

        write_flat(self.table, Path(path))

    def __getattr__(self, name: str) -> Any:
        """What `simulate` returned in version 0.1."""
        if name not in OF_A_RESULT or self.ended is None:
            raise AttributeError(f"'Recording' object has no attribute {name!r}")
        older(f"simulate(...).{name}")
        return getattr(self.ended, name)

    def __repr__(self) -> str:
        span_s = float(self.t[-1] - self.t[0]) if len(self) else 0.0
        has = ", ".join(self.columns)
        return f"Recording({self.source!r}: {count(len(self), 'row')} in {span_s:.4g} s; {has})"

    def _repr_html_(self) -> str:
        notes = "".join(f"<br>{html.escape(note)}" for note in self.notes)
        return f"<p>{html.escape(repr(self))}{notes}</p>"


def read(path: AnyPath, columns: Columns | None = None) -> Recording:
    """Read a recording: `.csv`, `.csv.gz`, `.parquet`, `.mat`, or an `.mcap` run.

    Parameters
    ----------
    path : path
        The file.
    columns : mapping, optional
        Column and unit for each name that the program knows, `{"position": "angle[deg]"}`, as
        `--set` of the command takes them. `inspect` proposes them. Without it a table whose
        columns have other names is read as `inspect` proposes; a warning says how.

    Returns
    -------
    Recording
        In SI units.

    Raises
    ------
    RecordingError, MissingFile, ConfigError
        One line that says what is wrong, where, and what to do.
    """
    if not columns:
        from deltactl.recording.tables.flat_files import read_flat

        try:
            return Recording(read_flat(Path(path)))
        except RecordingError as error:
            if (seen := _as_inspected(Path(path))) is None:
                raise error.worded(str(error).removesuffix(error.typed)) from None
        return seen
    with needs("diagnosis", "reading other columns"):
        from deltactl.recording.foreign.mapping import load_mapping
        from deltactl.recording.foreign.reading import read_mapped
    notes: list[str] = []
    mapping = load_mapping(None, _options(columns))
    table = read_mapped(Path(path), mapping, notes.append)
    return Recording(table, tuple(notes))


def _as_inspected(path: Path) -> Recording | None:
    """A table with names of its own as its inspection reads it, with a warning; None where that
    leaves something to be said, as the unit of a motion.
    """
    with needs("diagnosis", "reading other columns"):
        from deltactl.recording.foreign.inspection import inspect as look_at
        from deltactl.recording.foreign.notes import Hint
        from deltactl.recording.foreign.reading import read_mapped
    notes: list[str] = []
    try:
        seen = look_at(path)
        guessed = seen.factors or any(isinstance(one, Hint) for one in seen.warnings)
        if guessed or seen.kind is None or seen.mapping.rate_hz is not None:
            return None
        table = read_mapped(path, seen.mapping, notes.append)
    except RecordingError:
        return None
    notes = [f"{path.name}: is read as inspected: columns={seen.columns}", *seen.in_python, *notes]
    warnings.warn("; ".join(notes), stacklevel=3)
    return Recording(table, tuple(notes))


def read_recording(recording: AnyPath, columns: Columns | None = None) -> FlatRecording:
    """Use `read(...).table`; this name goes."""
    older("read_recording")
    return read(recording, columns).table


def inspect(path: AnyPath, columns: Columns | None = None) -> Inspection:
    """Find out what a table of another program seems to hold.

    Parameters
    ----------
    path : path
        The file.
    columns : mapping, optional
        Those that are known already, as in `read`.

    Returns
    -------
    Inspection
        Columns, units, rate and kind of machine: `kind`, `guesses`, `warnings`; `columns` is what
        `read` takes. Printed, it says all of that.

    Raises
    ------
    RecordingError, ConfigError
        One line that says what is wrong.
    """
    with needs("diagnosis", "inspect"):
        from deltactl.recording.foreign.inspection import inspect as look_at
        from deltactl.recording.foreign.mapping import load_mapping
    return look_at(Path(path), load_mapping(None, _options(columns)) if columns else None)


def tables_of(
    recordings: Any, columns: Columns | None, beside: AnyMapping[Path, FlatRecording] = {}
) -> dict[Path, FlatRecording]:
    """Recordings and paths, one or several, each by a name of its own.

    beside: names that are taken. Raises ConfigError for something else, and what `read` raises.
    """
    several = [recordings] if isinstance(recordings, str | Path | Recording) else list(recordings)
    found: dict[Path, FlatRecording] = {}
    for one in several:
        if not isinstance(one, str | Path | Recording):
            what = type(one).__name__
            raise ConfigError(
                f"recordings: {what} is no recording; give a path, what deltactl.read returns, or"
                " deltactl.Recording.from_pandas(frame)"
            )
        table = one.table if isinstance(one, Recording) else read(one, columns).table
        name, number = table.source, 2
        while Path(name) in found or Path(name) in beside:
            name, number = f"{table.source} ({number})", number + 1
        found[Path(name)] = table
    return found


def _mapped_frame(frame: pd.DataFrame, columns: Columns, source: str) -> Recording:
    """Through the reader of tables, which knows units, marks and doubts."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "frame.csv"
        frame.to_csv(path, index=False)
        try:
            made = read(path, columns)
        except DeltactlError as error:
            raise error.worded(_renamed(str(error), path, source)) from None
    return Recording(
        replace(made.table, source=source),
        tuple(_renamed(note, path, source) for note in made.notes),
    )


def _renamed(text: str, path: Path, source: str) -> str:
    return text.replace(str(path), source).replace(path.name, source)


def _options(columns: Columns) -> list[str]:
    """As `--set` takes them. Raises ConfigError for what is no text."""
    if not isinstance(columns, AnyMapping):
        return [option for option in columns if option != "--set"]
    for name, source in columns.items():
        if not isinstance(source, str):
            raise ConfigError(f"columns: {name}: {source!r} is no text such as 'angle[deg]'")
    return [f"{name}={source}" for name, source in columns.items()]
