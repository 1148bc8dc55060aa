"""Comments in the middle of a table and a line of text at its end are no rows."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.foundation.errors import RecordingError
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.tables.foreign_table import read_table

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
ROWS = [f"{20 * n},{n % 50},{(n - 3) % 50}" for n in range(200)]
SAYS = "is read without 4 comment lines and the last line ('End of log, 200 rows')"


def write(path: Path, heading: str) -> None:
    remarks = ["# paused", "% by hand", "// resumed", "; all is well"]
    lines = [heading, *ROWS[:100], *remarks, *ROWS[100:], "End of log, 200 rows"]
    path.write_text("\n".join(lines) + "\n")


def test_they_are_left_out_and_that_is_said(deltactl: Deltactl, tmp_path: Path) -> None:
    write(tmp_path / "log.csv", "t_ms,soll,ist")
    assert ("remarks", SAYS) in inspect(tmp_path / "log.csv").facts
    write(tmp_path / "ours.csv", "t,command,position")
    deltactl("init", "axis", "axis.yaml", "--motion", "rotary")
    refused = deltactl("diagnose", "ours.csv", "--robot", "axis.yaml", status=2).stderr
    assert SAYS in refused
    assert "this row has" not in refused


def test_a_semicolon_may_also_separate(tmp_path: Path) -> None:
    lines = ["t;soll;ist", *(row.replace(",", ";") for row in ROWS), ";1;2", "; paused", "Total;;"]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    table = read_table(tmp_path / "log.csv", separator=";")
    assert len(table.columns["t"]) == len(ROWS) + 1


@pytest.mark.parametrize("last", ["4000,1", "4000"])
def test_a_row_that_was_cut_off_is_no_footer(tmp_path: Path, last: str) -> None:
    (tmp_path / "log.csv").write_text("\n".join(["t,soll,ist", *ROWS, last]) + "\n")
    with pytest.raises(RecordingError, match=r"log\.csv:202: this row has"):
        read_table(tmp_path / "log.csv")


@pytest.mark.parametrize(
    ("separator", "decimal", "more"),
    [
        (",", ".", ""),
        (";", ",", ""),
        ("\t", ".", ""),
        ("|", ".", "1.0|  -2e-3 | nan"),
        (",", ".", ",,"),
    ],
)
def test_a_table_of_numbers_is_read_as_one_with_a_remark(
    tmp_path: Path, separator: str, decimal: str, more: str
) -> None:
    """Numbers alone are read in blocks, a table with a remark cell by cell."""
    rows = [separator.join([str(0.1 * n), f"{n}", f" {-n / 7}"]) for n in range(50)]
    rows = [row.replace(".", decimal) for row in rows] + ([more] if more else [])
    heading = separator.join(["t", "soll", "ist"])
    (tmp_path / "plain.csv").write_text("\n".join([heading, *rows, ""]))
    (tmp_path / "remark.csv").write_text("\n".join([heading, *rows[:9], "# by hand", *rows[9:]]))
    plain = read_table(tmp_path / "plain.csv", separator=separator, decimal=decimal)
    remark = read_table(tmp_path / "remark.csv", separator=separator, decimal=decimal)
    assert list(plain.lines) == list(range(2, 2 + len(rows)))
    assert plain.columns.keys() == remark.columns.keys()
    for name, values in plain.columns.items():
        np.testing.assert_array_equal(values, remark.columns[name])
