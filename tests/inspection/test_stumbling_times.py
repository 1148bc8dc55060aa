"""Times that do not increase in a few rows: those are named, and what to do about them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.foundation.errors import RecordingError
from deltactl.recording.foreign.found import Inspection
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from tests.rigs.owners_words import owner_says

T_S = np.round(0.1 * np.arange(150), 3)
ASKED = np.sin(T_S)
SEEN = np.interp(T_S - 0.2, T_S, ASKED) + 1e-3 * np.random.default_rng(0).standard_normal(150)
READ = ["command=command_rad", "position=position_rad"]


def table(folder: Path, t_s: np.ndarray, name: str = "time", factor: float = 1.0) -> Path:
    rows = "".join(
        f"{factor * t:.6g},{a:.5f},{s:.5f}\n" for t, a, s in zip(t_s, ASKED, SEEN, strict=True)
    )
    path = folder / "log.csv"
    path.write_text(f"{name},command_rad,position_rad\n# a comment\n\n{rows}")
    return path


def changed(row: int, by_s: float) -> np.ndarray:
    t_s = T_S.copy()
    t_s[row] = t_s[row - 1] + by_s
    return t_s


def look(found: Inspection, name: str) -> str:
    (says,) = [one for one in found.warnings if one.startswith(f"{name}: does not increase")]
    return says


@pytest.mark.parametrize(("name", "factor"), [("t", 1.0), ("time", 1.0), ("t_ms", 1e3)])
@pytest.mark.parametrize("by_s", [0.0, -0.05])
def test_the_command_that_is_printed_reads_a_time_that_stumbles(
    tmp_path: Path, name: str, factor: float, by_s: float
) -> None:
    """It was called unused and the command ended in a refusal."""
    found = inspect(table(tmp_path, changed(66, by_s), name, factor))
    says = look(found, name)
    assert f"at line 70 ({factor * (6.5 + by_s):.6g} after {factor * 6.5:g})" in says
    assert "evenly spaced, 10 a second (their mean rate)" in says
    assert "delete that row and inspect the file again" in says
    assert "rate_hz=10" in found.options
    assert not any("no column increases" in one for one in found.warnings)
    assert found.unused(name) == "its times do not increase in every row"
    options = owner_says(found)
    read = read_mapped(found.path, load_mapping(None, options))
    np.testing.assert_allclose(read.t_s, 0.1 * np.arange(150))


def test_uneven_times_are_kept_and_the_row_is_to_go(tmp_path: Path) -> None:
    t_s = T_S + 0.04 * np.random.default_rng(1).standard_normal(150)
    t_s = np.sort(t_s)
    t_s[80], t_s[90] = t_s[79], t_s[89]
    found = inspect(table(tmp_path, t_s))
    assert "at lines 84, 94 (the first" in look(found, "time")
    assert "delete those rows before you type the printed command" in look(found, "time")
    assert "t=time" in found.options


def test_a_time_that_starts_again_or_is_coarse_is_no_mistyped_row(tmp_path: Path) -> None:
    again = inspect(table(tmp_path, np.concatenate([T_S[:75], T_S[:75]])))
    assert "at line 79 (0 after 7.4); where another run begins" in look(again, "time")
    coarse = look(inspect(table(tmp_path, np.floor(T_S))), "time")
    assert "at lines 5, 6, 7 and 132 more" in coarse
    assert "its steps are too coarse" in coarse


@pytest.mark.parametrize(
    ("t_s", "says"),
    [
        (
            changed(66, 0.0),
            "log.csv:70: t does not increase (6.5 after 6.5); delete that row, or, if the rows were"
            " taken evenly, say so with --set rate_hz=10 (their mean rate)",
        ),
        (np.concatenate([T_S[:75], T_S[:75]]), "log.csv:79: t does not increase (0 after 7.4); wh"),
        (0.0 * T_S, "log.csv:5: t does not increase (0 after 0), nor in 148 more rows; it is no"),
    ],
)
def test_a_refusal_names_the_line_and_what_to_do(
    tmp_path: Path, t_s: np.ndarray, says: str
) -> None:
    path = table(tmp_path, t_s)
    with pytest.raises(RecordingError) as caught:
        read_mapped(path, load_mapping(None, ["t=time", *READ]))
    assert says in str(caught.value)


def test_what_is_said_about_a_cell_is_said_by_its_line(tmp_path: Path) -> None:
    """Text was told by the line, and the gap that it made by the row."""
    path = table(tmp_path, T_S)
    lines = path.read_text().splitlines()
    lines[52] = lines[52].rpartition(",")[0] + ",abc"
    path.write_text("\n".join(lines) + "\n")
    said: list[str] = []
    read_mapped(path, load_mapping(None, ["t=time", *READ]), said.append)
    about = [one for one in said if "position_rad" in one]
    assert len(about) == 2
    assert all("line 53" in one and "row" not in one.replace("rows", "") for one in about)
