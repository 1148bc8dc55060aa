"""Jobs that clients name or send, and how often a client that watches is told: bounds and names."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest

from deltactl.firmware_py.daemon import job_store
from deltactl.firmware_py.daemon.connection import Connection
from deltactl.firmware_py.daemon.job_store import JobStore, check_job
from deltactl.firmware_py.daemon.limits import Limits, Lines
from deltactl.firmware_py.daemon.protocol import BadRequest, parse
from deltactl.foundation.errors import ConfigError

MIB = 2**20


@pytest.mark.parametrize(("size", "fine"), [(4 * MIB, True), (4 * MIB + 1, False)])
def test_a_job_file_has_four_megabytes_at_most(tmp_path: Path, size: int, fine: bool) -> None:
    path = tmp_path / "long.yaml"
    with path.open("wb") as file:
        file.truncate(size)
    if fine:
        assert check_job(str(path)) == path
    else:
        with pytest.raises(ConfigError, match="is larger than 4 MB; split the job"):
            check_job(str(path))


def test_names_of_sent_jobs_are_short_and_plain(tmp_path: Path) -> None:
    store = JobStore(tmp_path)
    kept = store.keep("a: 1", "../../et c/" + "heart" * 20 + ".yaml")
    assert kept.parent == tmp_path
    assert kept.stem.rpartition("-")[0] == ("heart" * 20)[:40]
    assert store.keep("a: 1", "\x1b[2J/.yaml").stem.rpartition("-")[0] == "yaml"
    assert store.keep("a: 1", "???").stem.rpartition("-")[0] == "job"


def test_the_newest_are_kept_also_where_somebody_tidies_up_meanwhile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(job_store, "KEPT", 3)
    unlink = Path.unlink

    def second(path: Path, missing_ok: bool = False) -> None:
        unlink(path)
        unlink(path, missing_ok=missing_ok)

    monkeypatch.setattr(Path, "unlink", second)
    store = JobStore(tmp_path / "jobs")
    for number in range(6):
        os.utime(store.keep(f"a: {number}", "job"), ns=(number, number))
    texts = sorted(path.read_text() for path in (tmp_path / "jobs").iterdir())
    # A file is as old as the clock says when the next one comes.
    assert texts == ["a: 3", "a: 4", "a: 5"]


def test_a_path_has_one_letter_at_least() -> None:
    assert parse(b'{"id": 1, "do": "run", "job": "/", "name": "h"}').arguments["name"] == "h"
    with pytest.raises(BadRequest, match="'name'"):
        parse(b'{"id": 1, "do": "run", "job": "/", "name": ""}')


def test_a_line_may_be_as_long_as_is_said_and_no_longer() -> None:
    assert Lines(8).feed(b"12345678\n123456789\n1234\n") == [b"12345678", None, b"1234"]
    half = Lines(8)
    assert half.feed(b"12345678") == []
    assert half.feed(b"\n") == [b"12345678"]


def test_who_watches_is_told_as_often_as_was_asked() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        # Not started: nothing is sent, so neither actions nor a worker are asked for anything.
        connection = Connection(ours, None, None, Limits(), lambda _: None)  # type: ignore[arg-type]
        connection._answer(parse(b'{"id": "w", "do": "watch", "rate_hz": 4}'))
        assert connection._watch is not None
        assert (connection._watch.id, connection._watch.period_s) == ("w", 0.25)
