"""Old recordings go, new ones and those being written stay."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.writing.retention import prune
from deltactl.recording.writing.writer import RunRecorder

NOW_S = 1_000_000.0


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Five recordings of 100 bytes, an hour apart, r0 the oldest; and another file."""
    for number in range(5):
        path = tmp_path / f"r{number}.mcap"
        path.write_bytes(bytes(100))
        os.utime(path, (0, NOW_S - 3600.0 * (5 - number)))
    (tmp_path / "notes.txt").write_text("keep")
    os.utime(tmp_path / "notes.txt", (0, 0))
    return tmp_path


def left(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.glob("*.mcap"))


def test_by_size(folder: Path) -> None:
    assert [path.name for path in prune(folder, max_bytes=250)] == ["r0.mcap", "r1.mcap", "r2.mcap"]
    assert left(folder) == ["r3.mcap", "r4.mcap"]
    assert (folder / "notes.txt").exists()


def test_by_age(folder: Path) -> None:
    prune(folder, max_age_s=2.5 * 3600, now_s=NOW_S)
    assert left(folder) == ["r3.mcap", "r4.mcap"]


def test_the_newest_always_stays(folder: Path) -> None:
    prune(folder, max_bytes=0, max_age_s=0.0, now_s=NOW_S)
    assert left(folder) == ["r4.mcap"]


def test_for_free_space(folder: Path) -> None:
    prune(folder, keep_free_bytes=2**62)
    assert left(folder) == ["r4.mcap"]


def test_within_limits_nothing_goes(folder: Path) -> None:
    assert prune(folder, max_bytes=500, max_age_s=1e9, keep_free_bytes=1, now_s=NOW_S) == []
    assert prune(folder / "absent", max_bytes=0) == []


def test_one_being_written_stays(folder: Path) -> None:
    with RunRecorder(folder / "now.mcap", RunConfiguration("r", "j")) as recorder:
        os.utime(recorder.path, (0, 0))
        prune(folder, max_bytes=0)
        assert left(folder) == ["now.mcap", "r4.mcap"]
    os.utime(recorder.path, (0, 0))
    prune(folder, max_bytes=0)
    assert left(folder) == ["r4.mcap"]


def test_links_are_not_followed(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    target = tmp_path_factory.mktemp("elsewhere") / "precious.mcap"
    target.touch()
    (folder / "link.mcap").symlink_to(target)
    prune(folder, max_bytes=0)
    assert target.exists()
    assert (folder / "link.mcap").is_symlink()


def test_a_clock_that_was_set_back_deletes_nothing_new(folder: Path) -> None:
    """The newest by what came last, not by its date, which lies years before the others."""
    prune(folder, max_bytes=10_000, now_s=NOW_S)
    path = folder / "new.mcap"
    path.write_bytes(bytes(100))
    os.utime(path, (0, 1.0))
    prune(folder, max_bytes=10_000, now_s=2.0)
    assert [one.name for one in prune(folder, max_bytes=250, now_s=2.0)] == [
        *(f"r{number}.mcap" for number in range(4)),
    ]
    assert left(folder) == ["new.mcap", "r4.mcap"]


def test_the_sequence_is_kept_over_a_restart_and_never_through_a_link(folder: Path) -> None:
    prune(folder, max_bytes=10_000, now_s=NOW_S)
    kept = folder / ".sequence"
    assert kept.read_text().split() == [f"r{number}.mcap" for number in range(5)]
    for number in range(5):
        os.utime(folder / f"r{number}.mcap", (0, NOW_S + 3600.0 * (5 - number)))
    assert [one.name for one in prune(folder, max_bytes=450, now_s=NOW_S)] == ["r0.mcap"]
    elsewhere = folder / "notes.txt"
    kept.unlink()
    kept.symlink_to(elsewhere)
    prune(folder, max_bytes=10_000, now_s=NOW_S)
    assert elsewhere.read_text() == "keep"
    assert not kept.is_symlink()


def test_a_folder_that_may_not_be_written_is_looked_through(folder: Path, monkeypatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError

    monkeypatch.setattr(Path, "replace", refuse)
    assert len(prune(folder, max_bytes=250)) == 3
