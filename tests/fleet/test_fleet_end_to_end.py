"""`deltactl fleet` from recordings to table and page."""

from __future__ import annotations

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

from deltactl.cli.main import app
from deltactl.fleet.run import PAGE, TABLE, diagnose_fleet
from deltactl.fleet.task import NAME, Book
from deltactl.fleet.together import courses, trends
from deltactl.foundation.errors import ConfigError, MissingFile


@pytest.mark.study
def test_a_fleet_is_diagnosed_once_and_a_bad_file_costs_one_line(
    fleet_folder: Path, tmp_path: Path
) -> None:
    runs, robots, out = fleet_folder / "runs", fleet_folder / "robots", tmp_path / "out"
    (runs / "axis-00" / "axis-00-2026-03-03.csv").write_text("t,steps_1,theta_1\n0.0,1\n")
    (runs / "stranger.csv").write_text("t\n0\n")
    call = ["fleet", f"{runs}/**/*.csv", "--robots", str(robots), "--out", str(out),
            "--workers", "0", "--limit", "gear_backlash.width=0.0087"]  # fmt: skip
    first = CliRunner().invoke(app, call)
    assert first.exit_code == 0, first.output
    assert "16 recordings: 14 with a model error, 2 unreadable" in first.output
    lines = (out / NAME).read_text().splitlines()
    assert len(lines) == 16
    table = pq.read_table(out / TABLE).to_pylist()
    assert {row["recording"] for row in table if row["error"]} == {
        str(runs / "axis-00" / "axis-00-2026-03-03.csv"), str(runs / "stranger.csv"),
    }  # fmt: skip
    text = (out / PAGE).read_text()
    assert "no robot file fits" in text
    assert "axis-01" in text

    # Asked again after the last line was cut off: only that one is done again.
    (out / NAME).write_text("\n".join([*lines[:-1], lines[-1][:20]]))
    done = []
    rows = diagnose_fleet(
        f"{runs}/**/*.csv", robots, out, progress=lambda count, of, row: done.append(row)
    )
    assert [row["recording"] for row in done] == [json.loads(lines[-1])["recording"]]
    assert len(rows) == 16


@pytest.mark.study
def test_growing_play_is_a_trend_with_the_true_rate_and_a_day(
    fleet_folder: Path, tmp_path: Path
) -> None:
    recordings = f"{fleet_folder}/runs/**/axis-01-*.csv"
    rows = diagnose_fleet(recordings, fleet_folder / "robots", tmp_path)
    (trend,) = trends(courses(rows), {"gear_backlash.width": 0.0087})
    true_per_day = (0.006 - 0.0005) / 180.0
    assert trend.per_day == pytest.approx(true_per_day, rel=0.05)
    days = trend.days_to_limit()
    assert days is not None
    best, soonest, latest = days
    assert soonest <= best <= latest
    assert best == pytest.approx((0.0087 - 0.006) / true_per_day, rel=0.1)


def test_mistakes_are_told(tmp_path: Path) -> None:
    with pytest.raises(MissingFile, match="no recording"):
        diagnose_fleet(f"{tmp_path}/*.mcap", tmp_path, tmp_path / "out")
    (tmp_path / "x.csv").write_text("t\n0\n")
    with pytest.raises(ConfigError, match="no robot file"):
        diagnose_fleet(f"{tmp_path}/*.csv", tmp_path, tmp_path / "out")
    book = Book(tmp_path / "out")
    assert not list(book.rows())
    book.close()
