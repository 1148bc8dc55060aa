"""Tables of others: any names, any separator, lines before the heading, or no heading at all."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from foundation.errors import RecordingError
from recording.csv_table import read_text
from recording.flat import AnyArray


def read_table(
    path: Path, skip_lines: int = 0, heading: Sequence[str] = (), separator: str = ","
) -> dict[str, AnyArray]:
    """Columns of numbers by name, shape (n,) each; NaN where a cell holds no number.

    heading: names of the columns where the file has none. Raises RecordingError.
    """
    lines = read_text(path).split("\n")[skip_lines:]
    if not heading:
        if not lines:
            raise RecordingError(f"{path}: has no line {skip_lines + 1} with a heading")
        heading = [name.strip().strip('"') for name in lines[0].split(separator)]
        lines = lines[1:]
    cells = [line.split(separator) for line in lines if line.strip()]
    if not cells:
        raise RecordingError(f"{path}: has a heading but no rows")
    for row, parts in enumerate(cells):
        if len(parts) != len(heading):
            line = row + skip_lines + 2
            raise RecordingError(
                f"{path}: about line {line}: has {len(parts)} cells, the heading {len(heading)}"
            )
    columns = zip(*cells, strict=True)
    return {
        name: np.array([_number(cell) for cell in column])
        for name, column in zip(heading, columns, strict=True)
    }


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")
