"""Runs as the page lists them: whose they are, how they ended, and what is made of them."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.controller.contract import JobResult, Status
from deltactl.web.behind.history import Ended, History, Trace
from deltactl.web.behind.known_robots import KnownRobot
from deltactl.web.behind.link import DaemonLink, Seen
from deltactl.web.behind.own_recordings import OwnRecordings, reader
from deltactl.web.behind.shelf import Shelf
from deltactl.web.behind.worker import errors, playback
from deltactl.web.motion_card import to_point
from deltactl.web.state_card import said_of_end
from deltactl.web.visit import NEXT, what_next
from tests.rigs.served import served
from tests.web.conftest import CIRCLE
from tests.web.test_hidden_fault import run_job, simulated_robot
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


def test_a_run_is_played_with_counts_curves_and_robot_in_step(tmp_path: Path) -> None:
    controller = simulated_robot(tmp_path)
    job = tmp_path / "circle.yaml"
    job.write_text(CIRCLE.format(name="circle", robot="zhao-2023.yaml", turns=1))
    run = run_job(controller, job)
    controller.close()
    playback(run, tmp_path)
    played = json.loads((tmp_path / "played.json").read_text())
    known = KnownRobot.of(tmp_path / "played.yaml")
    t_s, values = played["t_s"], played["values"]
    assert all(a < b for a, b in pairwise(t_s))
    assert {len(column) for column in values.values()} == {len(t_s)}
    assert len(played["counts"]) == len(played["measured_m"]) == len(t_s)
    seen = 0
    for place in range(0, len(t_s), 25):
        position = known.pose(tuple(played["counts"][place]))[1]
        assert position is not None
        drawn = [values[axis][place] for axis in "xyz"]
        assert drawn == pytest.approx([1e3 * part for part in position], abs=0.02)
        if (measured := played["measured_m"][place]) is not None:
            seen += 1
            assert measured == pytest.approx(position, abs=0.02)
            assert 0.0 <= values["error"][place] < 20.0
    assert seen > 5
    at = np.array([values[f"motor {k}"] for k in (1, 2, 3)])
    assert np.abs(at).max() > 100.0, "steps a second"
    assert errors(run)["errors_m"]["measured"] < 0.01


def test_the_history_is_kept_and_follows_a_recording(tmp_path: Path) -> None:
    history = History(tmp_path / "history.json")
    for number in range(3):
        result = JobResult(number, f"job{number}", "done", "", f"/x/r{number}.mcap")
        history.add(Ended.of(result, 100.0 + number, 102.5 + number))
    history.renamed("r1.mcap", "mine.mcap")
    again = History(tmp_path / "history.json").newest_first()
    assert [one.name for one in again] == ["job2", "job1", "job0"]
    assert again[0].duration_s == 2.5
    history.add(Ended.of(JobResult(9, "x", "stopped", "why", None), 1.0, 2.0))
    kept = History(tmp_path / "history.json").newest_first()
    assert [one.recording for one in kept] == ["", "r2.mcap", "mine.mcap", "r0.mcap"]


def test_a_trace_has_rates_and_starts_anew_with_another_daemon(tmp_path: Path) -> None:
    status = Status("ready", "", "r", True, 10.0, (0, 0, 0), None, (0.0, 0.0, -0.4), None, None,
                    0.0, None, (), None, "", 0)  # fmt: skip
    trace = Trace()
    for step in range(40):
        moved = replace(status, time_s=10.0 + 0.05 * step, counts=(step, 0, -2 * step))
        trace.note(moved, lambda _: (0.003, 0.004, -0.4))
    curves = trace.curves()
    assert len(curves.t_s) == 10
    assert (curves.t_s[-1], curves.values["error"][-1]) == (0.0, pytest.approx(5.0))
    assert curves.values["motor 1"][1:] == pytest.approx([20.0] * 9)
    assert curves.values["motor 3"][1:] == pytest.approx([-40.0] * 9)
    assert len(curves.last(1.0).t_s) == len(curves.last(1.0).values["x"]) == 6
    trace.note(replace(status, time_s=1.0), lambda _: None)
    assert len(trace.curves().t_s) == 1
