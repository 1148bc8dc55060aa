"""Flat recordings: every format round trips, and a bad file gets one line that says where."""

from __future__ import annotations

import gzip
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pyarrow import parquet
from scipy.io import savemat

from deltactl.foundation.errors import RecordingError
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import read_flat, write_flat

ENDINGS = (".csv", ".csv.gz", ".parquet", ".mat")


def small() -> FlatRecording:
    return FlatRecording(
        t_s=np.array([0.0, 0.02, 0.04]),
        columns={
            "steps_1": np.array([0.0, 5.0, -10.0]),
            "range_x": np.array([0.6, np.nan, 0.6004999999999999]),
            "status_x": np.array([0.0, 4.0, np.nan]),
        },
        extra={"truth_x_m": np.array([0.1, 0.2, 1e-9])},
    )


@pytest.mark.parametrize("ending", ENDINGS)
def test_round_trip(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"table{ending}"
    write_flat(small(), path)
    back = read_flat(path)
    np.testing.assert_array_equal(back.t_s, small().t_s)
    assert list(back.columns) == list(small().columns)
    for name, values in small().columns.items():
        np.testing.assert_array_equal(back.columns[name], values)
    np.testing.assert_array_equal(back.extra["truth_x_m"], small().extra["truth_x_m"])


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=20, deadline=None
)
@given(
    values=st.lists(
        st.floats(allow_nan=True, allow_infinity=False, width=64), min_size=1, max_size=8
    )
)
def test_csv_keeps_every_digit(tmp_path: Path, values: list[float]) -> None:
    path = tmp_path / "digits.csv"
    recording = FlatRecording(np.arange(len(values), dtype=float), {"position": np.array(values)})
    write_flat(recording, path)
    np.testing.assert_array_equal(read_flat(path).columns["position"], values)


def test_same_table_same_bytes(tmp_path: Path) -> None:
    first, second = tmp_path / "a.csv.gz", tmp_path / "b.csv.gz"
    write_flat(small(), first)
    write_flat(small(), second)
    assert first.read_bytes() == second.read_bytes()


def test_whole_numbers_look_whole(tmp_path: Path) -> None:
    path = tmp_path / "look.csv"
    write_flat(small(), path)
    assert path.read_text().splitlines()[2] == "0.02,5,,4,0.2"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "is empty"),
        ("\n\n", "is empty"),
        ("t,steps_1\n", "has a heading but no rows"),
        ("time,steps_1\n0,1\n", ":1: has no column 't'; it has time, steps_1"),
        ("t,foo\n0,1\n1,2\n", "none of its columns foo is one that the program knows"),
        ("t,steps_1,steps_1\n0,1,1\n", ":1: column 'steps_1' occurs here twice"),
        ("t,steps_1\n0,1\n0,2\n", r":3: t does not increase \(0 after 0\)"),
        ("t,steps_1\n0,1\n1,2\n0.5,3\n", r":4: t does not increase \(0.5 after 1\)"),
        ("t,steps_1\n0,1\n,2\n", ":3: t is empty"),
        ("t,steps_1\n0,1\n1,abc\n", r":3: steps_1 must be a number \(got 'abc'\)"),
        ("t,steps_1\n0,1\n1,1_0\n", r":3: steps_1 must be a number \(got '1_0'\)"),
        ("t,steps_1\n0,1\n1,１２\n", r":3: steps_1 must be a number \(got '１２'\)"),
        ("t,steps_1\n0,1\n1\n", ":3: this row has one cell, the heading has 2"),
        ("t,steps_1\n0,1\n1,2,3\n", ":3: this row has 3 cells, the heading has 2"),
        ("t,steps_1\n0,1\n\n1,2\n", ":3: this row is empty, the heading has 2"),
        ("t,range_x\n0,1\n1,inf\n", ":3: range_x is infinite"),
        ("t;steps_1\n0;1\n", "has no column 't'"),
        ("t," + ",".join(map(str, range(100_000))) + "\n", "100001 columns, at most 1000 are read"),
    ],
)
def test_bad_tables_say_what_and_where(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(RecordingError, match=says) as caught:
        read_flat(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.csv", b"\xff\xfe\x00t", "is not a text file"),
        ("a.csv.gz", b"t,steps_1\n0,1\n", "is not a whole gzip file"),
        (
            "a.csv.gz",
            gzip.compress(b"t,steps_1\n0,1\n" * 99, mtime=0)[:40],
            "is not a whole gzip file",
        ),
        ("a.parquet", b"PAR1 nothing", "is not a readable Parquet file"),
        ("a.mat", b"MATLAB 5.0", "is not a readable .mat file"),
        ("a.mcap", b"garbage", "is not an MCAP recording"),
        ("a.xlsx", b"", "the name must end in .csv"),
    ],
)
def test_files_of_another_kind(tmp_path: Path, name: str, content: bytes, says: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=says):
        read_flat(path)


@pytest.mark.parametrize("ending", [*ENDINGS, ".mcap"])
def test_absent_files(tmp_path: Path, ending: str) -> None:
    with pytest.raises(RecordingError):
        read_flat(tmp_path / f"none{ending}")


@pytest.mark.parametrize("ending", ENDINGS)
def test_places_that_cannot_be_written(tmp_path: Path, ending: str) -> None:
    with pytest.raises(RecordingError, match="cannot be written"):
        write_flat(small(), tmp_path / "no folder" / f"x{ending}")


@pytest.mark.parametrize(
    ("ending", "module", "package"),
    [(".parquet", "pyarrow.parquet", "pyarrow"), (".mat", "scipy.io", "scipy")],
)
def test_absent_extra_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str, module: str, package: str
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(RecordingError, match=rf"need {package}, .*make .*extras WITH=tables"):
        write_flat(small(), tmp_path / f"x{ending}")


def test_untidy_but_clear_csv_is_read(tmp_path: Path) -> None:
    """BOM, Windows line ends, quotes, words for 'nothing', an extra column of text."""
    path = tmp_path / "untidy.csv"
    path.write_bytes(
        b'\xef\xbb\xbft, steps_1 ,range_x,note\r\n0,1,NaN,"a, b"\r\n1,2, n/a,c\r\n2,3,0.5,\r\n\r\n'
    )
    found = read_flat(path)
    np.testing.assert_array_equal(found.t_s, [0, 1, 2])
    np.testing.assert_array_equal(found.columns["steps_1"], [1, 2, 3])
    np.testing.assert_array_equal(found.columns["range_x"], [np.nan, np.nan, 0.5])
    assert found.extra["note"].tolist() == ["a, b", "c", ""]


def test_texts_go_out_and_come_back(tmp_path: Path) -> None:
    path = tmp_path / "texts.csv"
    texts = np.array(["plain", 'a "quote", and comma', ""])
    recording = FlatRecording(np.arange(3.0), {"position": np.zeros(3)}, {"note": texts})
    write_flat(recording, path)
    assert read_flat(path).extra["note"].tolist() == texts.tolist()


def test_empty_cells_at_the_ends_of_rows(tmp_path: Path) -> None:
    path = tmp_path / "ends.csv"
    path.write_text("range_x,t,range_y\n,0,\n0.1,1,0.2\n,2,0.3\n0.4,3,\n")
    found = read_flat(path)
    np.testing.assert_array_equal(found.columns["range_x"], [np.nan, 0.1, np.nan, 0.4])
    np.testing.assert_array_equal(found.columns["range_y"], [np.nan, 0.2, 0.3, np.nan])


def test_a_four_minute_table_is_read_in_a_fifth_of_a_second(tmp_path: Path) -> None:
    rows = 12_000
    random = np.random.default_rng(1)
    columns = {f"steps_{k}": np.rint(random.normal(0, 1e4, rows)) for k in (1, 2, 3)}
    columns |= {f"range_{axis}": np.round(random.normal(0.6, 0.1, rows), 3) for axis in "xyz"}
    columns |= {f"status_{axis}": random.integers(0, 2, rows).astype(float) for axis in "xyz"}
    columns["range_x"][::7] = np.nan
    path = tmp_path / "long.csv.gz"
    write_flat(FlatRecording(np.arange(rows) * 0.02, columns), path)
    used_s = []
    for _ in range(3):
        start_s = time.process_time()
        assert len(read_flat(path)) == rows
        used_s.append(time.process_time() - start_s)
    assert min(used_s) < 0.2


def test_other_variables_of_a_matlab_file_are_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "more.mat"
    good = {"t": np.arange(3.0), "steps_1": np.arange(3.0)}
    savemat(path, {**good, "rate_hz": 50.0, "note": "hello"})
    assert read_flat(path).extra == {}
    savemat(path, {**good, "range_x": np.arange(2.0)})
    with pytest.raises(RecordingError, match="range_x has 2 values, t has 3"):
        read_flat(path)


def test_times_of_day_are_not_numbers(tmp_path: Path) -> None:
    path = tmp_path / "dates.parquet"
    dates = np.array(["2024-01-01", "2024-01-02"], dtype="datetime64[ns]")
    parquet.write_table(pyarrow.table({"t": dates, "steps_1": [0, 1]}), path)
    with pytest.raises(RecordingError, match="column 't' must hold numbers"):
        read_flat(path)


def test_missing_columns_are_named() -> None:
    with pytest.raises(RecordingError, match=r"column theta_1 missing; it has t, steps_1, range_x"):
        small().column("theta_1")
    assert small().motors("steps") is None
    assert small().axes("range") is None


def test_stretches_end_at_gaps_and_segments() -> None:
    t_s = np.concatenate([np.arange(10), np.arange(30.5, 35.5), np.arange(35.5, 40.5)]) * 0.02
    segment = np.array([0.0] * 15 + [1.0] * 5)
    plain = FlatRecording(t_s, {"position": t_s})
    assert plain.stretches() == [slice(0, 10), slice(10, 20)]
    marked = FlatRecording(t_s, {"position": t_s, "segment": segment})
    assert marked.stretches() == [slice(0, 10), slice(10, 15), slice(15, 20)]
    assert len(marked.rows(slice(10, 15))) == 5
    assert FlatRecording(t_s[:1], {"position": t_s[:1]}).stretches() == [slice(0, 1)]
