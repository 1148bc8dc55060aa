"""A file is whole or as it was: full disks, links, permissions, streams."""

from __future__ import annotations

import errno
import os
import resource
import stat
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from deltactl.foundation.plain_file import (
    check_place,
    undone_on_failure,
    whole_file,
    write_whole,
)

LIMIT_BYTES = 64 * 1024


@contextmanager
def small_disk() -> Iterator[None]:
    """No file of this process may grow beyond LIMIT_BYTES; writing more fails as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT_BYTES, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def refused(path: Path, text: str = "text", **how: bool) -> OSError:
    """Why a text cannot be put there."""
    with pytest.raises(OSError, match=r".") as seen:
        write_whole(path, text, **how)
    return seen.value


def begin(path: Path, wrong: type[BaseException]) -> None:
    with whole_file(path) as out:
        out.write(b"new and then")
        raise wrong


def too_late(path: Path) -> None:
    with whole_file(path, fresh=True) as out:
        out.write(b"late")
        path.write_text("came meanwhile")


def refuse_checked(path: Path) -> None:
    with undone_on_failure(path):
        write_whole(path, "new")
        raise KeyboardInterrupt


def names(folder: Path) -> list[str]:
    return sorted(one.name for one in folder.iterdir())


@pytest.mark.parametrize("before", [None, "the old one\n"])
def test_what_does_not_fit_leaves_what_was_there(tmp_path: Path, before: str | None) -> None:
    path = tmp_path / "t.csv"
    if before is not None:
        path.write_text(before)
    there = names(tmp_path)
    with small_disk():
        error = refused(path, "x" * 3 * LIMIT_BYTES)
    assert (error.errno, error.filename) == (errno.EFBIG, str(path))
    assert names(tmp_path) == there
    assert before is None or path.read_text() == before


@pytest.mark.parametrize("wrong", [ValueError, KeyboardInterrupt, MemoryError])
def test_whatever_ends_the_writing_leaves_no_part(
    tmp_path: Path, wrong: type[BaseException]
) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(b"old")
    with pytest.raises(wrong):
        begin(path, wrong)
    assert names(tmp_path) == ["a.bin"]
    assert path.read_bytes() == b"old"


def test_an_error_of_another_file_keeps_its_name(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as seen, whole_file(tmp_path / "a"):
        (tmp_path / "other").read_text()
    assert seen.value.filename == str(tmp_path / "other")


def test_a_reader_sees_the_old_or_the_new_one(tmp_path: Path) -> None:
    path, ended = tmp_path / "a", threading.Event()
    write_whole(path, b"0" * 100_000)
    seen = set()

    def read() -> None:
        while not ended.is_set():
            data = path.read_bytes()
            seen.add((len(data), data[:1], data[-1:]))

    reader = threading.Thread(target=read)
    reader.start()
    for digit in b"123456789" * 5:
        write_whole(path, bytes([digit]) * 100_000)
    ended.set()
    reader.join()
    assert {(size, first == last) for size, first, last in seen} == {(100_000, True)}


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o755])
def test_permissions_of_the_old_file_are_kept(tmp_path: Path, mode: int) -> None:
    path = tmp_path / "a"
    path.write_text("old")
    path.chmod(mode)
    write_whole(path, "new")
    assert stat.S_IMODE(path.stat().st_mode) == mode


def test_a_new_file_has_those_of_the_umask_or_those_asked_for(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_whole(tmp_path / "a", "")
        write_whole(tmp_path / "b", "", mode=0o644)
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o640
    assert stat.S_IMODE((tmp_path / "b").stat().st_mode) == 0o644


def test_a_link_stays_and_its_file_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "a").write_text("old")
    link = tmp_path / "link"
    link.symlink_to("real/a")
    write_whole(link, "new")
    assert link.is_symlink()
    assert (tmp_path / "real" / "a").read_text() == "new"
    assert names(tmp_path / "real") == ["a"]


def test_a_link_to_nothing_yet_makes_its_file(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("later")
    write_whole(tmp_path / "link", "new")
    assert (tmp_path / "later").read_text() == "new"


def test_a_link_that_may_not_be_followed_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("keep")
    (tmp_path / "link").symlink_to("secret")
    write_whole(tmp_path / "link", "new", follow=False)
    assert (tmp_path / "secret").read_text() == "keep"
    assert (tmp_path / "link").read_text() == "new"


def test_a_fresh_file_never_replaces(tmp_path: Path) -> None:
    path = tmp_path / "a"
    write_whole(path, "first", fresh=True)
    with pytest.raises(FileExistsError):
        write_whole(path, "second", fresh=True)
    with pytest.raises(FileExistsError):
        too_late(tmp_path / "b")
    assert path.read_text() == "first"
    assert (tmp_path / "b").read_text() == "came meanwhile"
    assert names(tmp_path) == ["a", "b"]


@pytest.mark.parametrize("name", ["a" * 255, "ä" * 127, "with \n lines", ".hidden"])
def test_any_name_that_a_disk_takes(tmp_path: Path, name: str) -> None:
    write_whole(tmp_path / name, "text")
    assert names(tmp_path) == [name]


def test_folders_loops_and_missing_folders_are_refused(tmp_path: Path) -> None:
    (tmp_path / "loop").symlink_to("loop")
    for path in (tmp_path, tmp_path / "loop", tmp_path / "none" / "a"):
        assert refused(path).filename == str(path)
        with pytest.raises(OSError, match=r"."):
            check_place(path)
    assert names(tmp_path) == ["loop"]


def test_a_pipe_is_written_to_and_stays_one(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    write_whole(pipe, "through")
    reader.join(5.0)
    assert read == ["through"]
    assert pipe.is_fifo()


def test_standard_output_is_added_to(tmp_path: Path) -> None:
    code = (
        "from pathlib import Path\nfrom deltactl.foundation.plain_file import write_whole\n"
        "write_whole(Path('/dev/stdout'), 'two\\n')"
    )
    log = tmp_path / "log"
    with log.open("w") as out:
        out.write("one\n")
        out.flush()
        subprocess.run([sys.executable, "-c", code], stdout=out, check=True, timeout=30)
    assert log.read_text() == "one\ntwo\n"


def test_a_full_device_is_refused_and_stays() -> None:
    error = refused(Path("/dev/full"))
    assert (error.errno, error.filename) == (errno.ENOSPC, "/dev/full")
    assert Path("/dev/full").is_char_device()


@pytest.mark.parametrize("before", [None, "old"])
def test_what_is_refused_where_it_lies_is_undone(tmp_path: Path, before: str | None) -> None:
    path = tmp_path / "job.yaml"
    if before is not None:
        path.write_text(before)
        path.chmod(0o600)
    there = names(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        refuse_checked(path)
    assert names(tmp_path) == there
    if before is not None:
        assert path.read_text() == before
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
        with pytest.raises(KeyboardInterrupt), undone_on_failure(path):
            raise KeyboardInterrupt  # before anything was written
        assert (names(tmp_path), path.read_text()) == (there, before)
    with undone_on_failure(path):
        write_whole(path, "new")
    assert path.read_text() == "new"
    assert names(tmp_path) == ["job.yaml"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_protected_file_and_a_protected_folder_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_text("old")
    path.chmod(0o444)
    with pytest.raises(PermissionError):
        write_whole(path, "new")
    path.chmod(0o644)
    tmp_path.chmod(0o555)
    try:
        with pytest.raises(PermissionError, match="folder"):
            write_whole(path, "new")
    finally:
        tmp_path.chmod(0o755)
    assert path.read_text() == "old"
