"""Text and gaps in a column of numbers are told, with their place, and read as no reading."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.foundation.errors import RecordingError
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped


def told(tmp_path: Path, cells: list[str]) -> tuple[list[str], np.ndarray]:
    rows = "".join(f"{row * 0.1:.1f},{row % 7},{cell},ok\n" for row, cell in enumerate(cells))
    path = tmp_path / "log.csv"
    path.write_text(f"time,goal,present,state\n{rows}")
    said: list[str] = []
    mapping = load_mapping(None, ["t=time", "position=present[deg]", "command=goal[deg]"])
    read = read_mapped(path, mapping, said.append)
    return said, np.flatnonzero(np.isnan(read.column("position")))


def test_a_cell_of_text_is_told_by_its_line_and_its_word(tmp_path: Path) -> None:
    cells = [str(row % 5) for row in range(60)]
    cells[7] = "err"
    said, gaps = told(tmp_path, cells)
    assert gaps.tolist() == [7]
    assert (
        "log.csv: line 9: 'err' in column 'present' is no number and is read as no reading" in said
    )
    assert not [line for line in said if "'state'" in line], "a column of words is none of numbers"
    cells[9] = cells[11] = "err"
    assert "(2 more cells of it likewise)" in " ".join(told(tmp_path, cells)[0])


def test_what_logs_write_where_nothing_was_read_is_only_counted(tmp_path: Path) -> None:
    cells = [str(row % 5) for row in range(60)]
    cells[7], cells[8] = "NaN", ""
    said, gaps = told(tmp_path, cells)
    assert gaps.tolist() == [7, 8]
    assert said == [
        "log.csv: read without 2 cells of 'present' that hold no number (the first in line 9)"
    ]
    every_other = [cell if row % 2 else "" for row, cell in enumerate(cells)]
    assert told(tmp_path, every_other)[0] == []


def test_a_heading_that_says_counts_is_believed_though_they_are_few(tmp_path: Path) -> None:
    path = tmp_path / "counts.csv"
    goal = np.round(90.0 * np.sin(0.1 * np.arange(200))).astype(int)
    rows = "".join(f"{row * 20},{told},{told + 3}\n" for row, told in enumerate(goal))
    for heading, counts in (("t_ms,goal_ticks,present_raw", True), ("t_ms,goal,present", False)):
        path.write_text(f"{heading}\n{rows}")
        found = inspect(path)
        assert ("0.001534" in " ".join(found.options)) == counts


@pytest.mark.parametrize(
    ("text", "prose"),
    [
        ("Notes on the rig\n\nWe recorded the axis on Monday, with 3 runs.\nOne was odd.\n", True),
        ("time,u,y\n", False),
        ("on,off\noff,on\n", False),
    ],
)
def test_a_file_without_numbers_is_told_what_a_table_is(
    tmp_path: Path, text: str, prose: bool
) -> None:
    path = tmp_path / "NOTES.txt"
    path.write_text(text)
    with pytest.raises(RecordingError, match="a table has a line of numbers for each") as caught:
        inspect(path)
    assert ("it looks like text ('Notes on the rig')" in str(caught.value)) == prose
