"""Runs as the page lists them: whose they are, how they ended, and what is made of them."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.controller.contract import JobResult
from deltactl.web.behind.link import DaemonLink, Seen
from deltactl.web.behind.own_recordings import OwnRecordings, reader
from deltactl.web.behind.shelf import Shelf
from deltactl.web.motion_card import to_point
from deltactl.web.state_card import said_of_end
from deltactl.web.visit import NEXT, what_next
from tests.rigs.served import served
from tests.web.test_together import a_run


def until(condition: Callable[[], bool], within_s: float = 20.0) -> None:
    give_up_s = time.monotonic() + within_s
    while not condition():
        assert time.monotonic() < give_up_s
        time.sleep(0.02)


def test_runs_of_other_robots_are_not_listed(tmp_path: Path) -> None:
    shelf = Shelf(tmp_path, OwnRecordings(tmp_path / "own"), tmp_path / "made")
    a_run(tmp_path / "mine-2026-01-01T00-00-00.mcap", "kind: delta\n")
    a_run(tmp_path / "theirs-2026-01-01T00-00-00.mcap", "kind: delta\n", "other")
    (tmp_path / "begun-2026-01-01T00-00-00.mcap").write_bytes(b"")
    assert {one.job for one in shelf.newest_first("r")} == {"mine", "begun"}
    assert {one.job for one in shelf.newest_first("other")} == {"theirs", "begun"}
    assert len(shelf.newest_first()) == 3


def test_a_job_that_was_stopped_is_not_said_to_have_ended_by_itself(tmp_path: Path) -> None:
    with served(tmp_path) as robot:
        link = DaemonLink(robot.socket)
        link.start()
        try:
            until(lambda: link.seen.status is not None)
            seen = link.seen.status
            assert seen is not None
            assert seen.position_m is not None
            x_m, y_m, z_m = seen.position_m
            number = link.submit_text(to_point("mine.yaml", (x_m, y_m, z_m - 0.03), "down"), "j")
            until(lambda: _job(link.seen) == number)
            link.stop("enough")
            until(lambda: link.seen.ended is not None)
            ended = link.seen.ended
        finally:
            link.close()
        status = robot.controller.status()
    assert what_next(status, operates=True) == NEXT["stopped"]
    assert what_next(status, operates=False) not in NEXT.values(), "a viewer has no such button"
    assert ended is not None
    assert (ended.job_id, ended.outcome) == (number, "stopped")
    assert "down was stopped" in said_of_end(ended)
    assert "enough" in said_of_end(ended)


def _job(seen: Seen) -> int | None:
    return None if seen.status is None else seen.status.job_id


@pytest.mark.parametrize("outcome", ["done", "cancelled", "stopped", "fault", "refused"])
def test_each_end_of_a_job_is_said_in_its_own_words(outcome: str) -> None:
    others = {"done", "cancelled", "stopped", "fault", "refused"} - {outcome}
    text = said_of_end(JobResult(1, "x", outcome, "w", None))
    assert text not in {said_of_end(JobResult(1, "x", other, "w", None)) for other in others}


def test_a_table_is_read_by_the_columns_that_are_found_in_it(tmp_path: Path) -> None:
    t_s = np.arange(300) * 0.02
    wanted, at = np.sin(t_s), np.sin(t_s - 0.01)
    path = tmp_path / "mine.csv"
    rows = [f"{1e3 * t:.1f},{a:.6f},{b:.6f}" for t, a, b in zip(t_s, wanted, at, strict=True)]
    path.write_text("\n".join(["time[ms],target[rad],angle[rad]", *rows]) + "\n")
    read = reader()(path)
    assert read.t_s == pytest.approx(t_s)
    assert read.columns["command"] == pytest.approx(wanted, abs=1e-6)
    assert read.columns["position"] == pytest.approx(at, abs=1e-6)
