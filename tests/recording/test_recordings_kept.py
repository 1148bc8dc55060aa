"""The daemon's thread that makes room."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
from pydantic import ValidationError

from deltactl.recording.writing.retention import DAY_S, GIB, KeptRecordings, RecordingKeeper

NOW_S = 1_000_000_000.0


def fill(folder: Path, ages_days: list[float], size: int = 100) -> None:
    for number, age in enumerate(ages_days):
        path = folder / f"r{number}.mcap"
        path.write_bytes(bytes(size))
        os.utime(path, (NOW_S - age * DAY_S, NOW_S - age * DAY_S))


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.glob("*.mcap"))


def test_by_age_in_days(tmp_path: Path) -> None:
    fill(tmp_path, [10.0, 5.0, 1.0])
    kept = KeptRecordings(max_age_days=6.0, keep_free_gib=0.0)
    gone = RecordingKeeper(tmp_path, kept, lambda: NOW_S).tidy()
    assert [path.name for path in gone] == ["r0.mcap"]
    assert names(tmp_path) == ["r1.mcap", "r2.mcap"]


def test_by_size_in_gib(tmp_path: Path) -> None:
    fill(tmp_path, [3.0, 2.0, 1.0], size=round(0.004 * GIB))
    RecordingKeeper(tmp_path, KeptRecordings(max_gib=0.01, keep_free_gib=0.0)).tidy()
    assert names(tmp_path) == ["r1.mcap", "r2.mcap"]


def test_for_free_space_all_but_the_newest_go(tmp_path: Path) -> None:
    fill(tmp_path, [3.0, 2.0, 1.0])
    RecordingKeeper(tmp_path, KeptRecordings(keep_free_gib=1e5)).tidy()
    assert names(tmp_path) == ["r2.mcap"]


def test_it_looks_by_itself_and_ends(tmp_path: Path) -> None:
    fill(tmp_path, [10.0, 1.0])
    kept = KeptRecordings(max_age_days=6.0, keep_free_gib=0.0)
    keeper = RecordingKeeper(tmp_path, kept, lambda: NOW_S, period_s=0.01)
    keeper.start()
    give_up_s = time.monotonic() + 30.0
    while names(tmp_path) != ["r1.mcap"] and time.monotonic() < give_up_s:
        time.sleep(0.01)
    keeper.close()
    keeper.close()
    assert names(tmp_path) == ["r1.mcap"]


def test_a_folder_that_is_not_there_is_no_trouble(tmp_path: Path) -> None:
    assert RecordingKeeper(tmp_path / "none", KeptRecordings()).tidy() == []


@pytest.mark.parametrize(
    "wrong", [{"max_gib": 0.0}, {"max_age_days": 0.0}, {"keep_free_gib": -1.0}, {"max_days": 1.0}]
)
def test_bounds(wrong: dict[str, float]) -> None:
    with pytest.raises(ValidationError):
        KeptRecordings(**wrong)
