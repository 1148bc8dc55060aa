"""Times as spreadsheets and loggers of several countries write them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from deltactl.recording.tables.cells import seconds
from tests.rigs.owners_words import owner_says

STEP_S = 0.5
T_S = STEP_S * np.arange(300)
HOURS = 13


def clock(t_s: float, hour: int = HOURS) -> str:
    return f"{hour:02d}:{int(t_s // 60):02d}:{t_s % 60:06.3f}"


@pytest.mark.parametrize(
    ("heading", "cell"),
    [
        ("Timestamp", lambda t: f"05/03/2024 {clock(t, HOURS - 12)} PM"),
        ("Timestamp", lambda t: f"03/05/2024 {clock(t)}"),
        ("Date,Time", lambda t: f"03/05/2024,{clock(t)}"),
        ("Date,Time", lambda t: f"2024-05-03,{clock(t)}"),
        ("Datum,Uhrzeit", lambda t: f"3.5.2024,{clock(t)}"),
        ("Time", lambda t: clock(t, 0)),
    ],
)
def test_a_table_with_such_times(
    tmp_path: Path, heading: str, cell: Callable[[float], str]
) -> None:
    asked = np.sin(0.05 * T_S)
    rows = [f"{cell(t)},{q:.5f},{0.9 * q:.5f}" for t, q in zip(T_S, asked, strict=True)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([f"{heading},cmd,pos", *rows]) + "\n")
    options = owner_says(inspect(path))
    read = read_mapped(path, load_mapping(None, options))
    np.testing.assert_allclose(read.t_s - read.t_s[0], T_S, atol=1e-6)


@pytest.mark.parametrize(
    ("cells", "since"),
    [
        (["12/31/2024 11:59:59 PM", "1/1/2025 12:00:01 AM"], 2.0),
        (["31/12/2024 23:59:59", "01/01/2025 00:00:01"], 2.0),
        (["03/05/2024 23:59:59", "03/06/2024 0:00:01"], 2.0),
        (["05/03/2024 23:59:59", "06/03/2024 0:00:01"], 2.0),
        (["2024/05/03 9:00", "2024/05/04 9:00"], 86400.0),
        (["11:59:59 PM", "12:00:01 AM"], 2.0),
        (["05/03/2024", "99/99/2024"], np.nan),
    ],
)
def test_from_one_time_to_the_next(cells: list[str], since: float) -> None:
    np.testing.assert_allclose(seconds(cells), [0.0, since])
