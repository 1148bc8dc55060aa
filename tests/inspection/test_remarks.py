"""Comments in the middle of a table and a line of text at its end are no rows."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

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
