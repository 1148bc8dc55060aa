"""Which separator a table has, where its dates hold a blank."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.foundation.errors import ConfigError
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from deltactl.recording.tables.table_format import guess_format
from tests.cli.conftest import Deltactl
from tests.rigs.owners_words import owner_says

SEPARATORS = ("\t", ";", ",", "   ", " | ")
STEP_S = 0.5
T_S = STEP_S * np.arange(200)
ASKED_UM = 9000.0 * np.sin(0.05 * T_S) - 2000.0
BEGIN = datetime(2024, 7, 3, 10, 12, 16, 204299)
STAGE = ("Time", "stage_setpoint_um", "laser_um")


def stage(path: Path, between: str, heading: Sequence[str], decimal: str = ".") -> Path:
    """A slide's setpoints and readings, at times with a blank after the day."""
    rows = [
        (str(BEGIN + timedelta(seconds=t)), f"{q:.3f}".replace(".", decimal), f"{q + 40.0:.2f}")
        for t, q in zip(T_S, ASKED_UM, strict=True)
    ]
    rows = [(t, asked, seen.replace(".", decimal)) for t, asked, seen in rows]
    lines = [between.join(cells) for cells in ([heading] if heading else []) + rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("between", SEPARATORS)
def test_a_blank_in_dates_separates_no_columns(tmp_path: Path, between: str) -> None:
    seen = inspect(stage(tmp_path / "stage.tsv", between, STAGE))
    assert tuple(seen.table) == STAGE
    assert {guess.name: guess.unit for guess in seen.guesses.values()} == {
        "t": "s",
        "command": "um",
        "position": "um",
    }
    assert seen.motion == "linear"
    options = owner_says(seen)
    read = read_mapped(seen.path, load_mapping(None, options))
    np.testing.assert_allclose(read.t_s - read.t_s[0], T_S, atol=1e-6)
    np.testing.assert_allclose(read.columns["command"], ASKED_UM * 1e-6, atol=1e-9)


@pytest.mark.parametrize("between", SEPARATORS)
def test_without_a_heading_such_a_date_is_one_column(tmp_path: Path, between: str) -> None:
    seen = inspect(stage(tmp_path / "stage.tsv", between, ()))
    assert list(seen.table) == ["column_1", "column_2", "column_3"]
    options = owner_says(seen)
    read = read_mapped(seen.path, load_mapping(None, options))
    np.testing.assert_allclose(read.t_s - read.t_s[0], T_S, atol=1e-6)


def test_single_blanks_separate_a_day_from_its_time_where_the_heading_does(tmp_path: Path) -> None:
    path = stage(tmp_path / "stage.txt", " ", ("Date", "Time", "cmd_um", "laser_um"))
    assert guess_format(path).separator == " "
    read = read_mapped(path, load_mapping(None, ["t=Time", "command=cmd_um", "position=laser_um"]))
    np.testing.assert_allclose(read.t_s - read.t_s[0], T_S, atol=1e-6)


@pytest.mark.study
def test_what_a_heading_calls_them_is_what_is_spoken_of(deltactl: Deltactl, tmp_path: Path) -> None:
    path = stage(tmp_path / "stage.tsv", "\t", STAGE)
    axis = tmp_path / "axis.yaml"
    axis.write_text("kind: servo_axis\nname: stage\nmotion: linear\n")
    done = deltactl("diagnose", str(path), "--robot", str(axis))
    assert "column_1" not in done.stderr
    assert "command=stage_setpoint_um" in done.stderr


@pytest.mark.study
def test_a_table_without_a_heading_has_no_names_to_be_spoken_of(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    path = stage(tmp_path / "stage.tsv", "\t", ())
    axis = tmp_path / "axis.yaml"
    axis.write_text("kind: servo_axis\nname: stage\nmotion: linear\n")
    assert "is read as inspected" in deltactl("diagnose", str(path), "--robot", str(axis)).stderr
    axis.write_text("kind: range_sensor\nname: lidar\n")
    done = deltactl("diagnose", str(path), "--robot", str(axis), status=2)
    assert "column_1" not in done.stderr
    assert "looks like a table of a servo_axis" in done.stderr


def test_two_characters_separate_only_if_they_are_spaces(tmp_path: Path) -> None:
    path = stage(tmp_path / "stage.txt", "   ", STAGE)
    seen = inspect(path, load_mapping(None, ["separator=spaces"]))
    assert tuple(seen.table) == STAGE
    with pytest.raises(ConfigError, match="separator: must be one character, or two spaces"):
        load_mapping(None, ["separator=;;"])


MARKS = st.sampled_from([
    (between, decimal)
    for between, decimal in itertools.product(SEPARATORS, (".", ","))
    if between != decimal
])  # fmt: skip
NUMBERS = st.lists(
    st.tuples(st.integers(-99999, 99999), st.integers(-99999, 99999)), min_size=4, max_size=30
)


@given(marks=MARKS, numbers=NUMBERS, headed=st.booleans(), iso=st.booleans())
def test_any_numbers_beside_dates(
    tmp_path_factory: pytest.TempPathFactory,
    marks: tuple[str, str],
    numbers: list[tuple[int, int]],
    headed: bool,
    iso: bool,
) -> None:
    between, decimal = marks
    form = "%Y-%m-%d %H:%M:%S" if iso else "%d.%m.%Y %H:%M:%S"
    lines = [between.join(("when", "asked", "read"))] if headed else []
    for n, pair in enumerate(numbers):
        cells = [f"{value / 1000.0:.3f}".replace(".", decimal) for value in pair]
        lines.append(between.join([(BEGIN + timedelta(seconds=n)).strftime(form), *cells]))
    path = tmp_path_factory.mktemp("dates") / "table.txt"
    path.write_text("\n".join(lines) + "\n")
    found = guess_format(path)
    assert (found.named, len(found.names), found.decimal) == (headed, 3, decimal)
