"""Jobs on the simulated robot: they follow the path, pause on it, and leave whole recordings."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.jobs.active_job import Phase
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import (
    ConfigError,
    LimitExceeded,
    NotReady,
    RecordingError,
    UnreachablePoint,
)
from deltactl.recording.reading.reader import read_run
from deltactl.recording.reading.run import Run


def run_of(result) -> Run:
    assert result.recording is not None
    return read_run(Path(result.recording))


def test_a_circle_is_followed_and_recorded(homed: Controller, write_job, finish) -> None:
    result = finish(homed, homed.submit(write_job()))
    assert (result.outcome, result.why, result.recording_error) == ("done", "", "")
    run = run_of(result)
    assert run.complete
    # The step edges end where the last target is, and the arms really went there.
    assert run.edges.counts[-1].tolist() == run.targets.steps[-1].tolist()
    assert run.edges.counts[-1].tolist() == list(homed.status().counts)
    at = np.searchsorted(run.truth.t_ns, run.targets.t_ns)
    inside = at < len(run.truth.t_ns)
    error_m = run.truth.position_m[at[inside]] - run.targets.position_m[inside]
    assert np.abs(error_m).max() < 0.002  # one reading round later: 20 ms at about 50 mm/s
    for axis in "xyz":
        rate_hz = np.diff(run.readings[axis].t_ns).mean() * 1e-9
        assert rate_hz == pytest.approx(0.02, rel=0.02)


@pytest.mark.study
def test_pausing_stays_on_the_path(homed: Controller, write_job, finish) -> None:
    number = homed.submit(write_job())
    sleep_s(homed.clock, 5.0)
    homed.pause()
    sleep_s(homed.clock, 1.0)
    assert homed.status().state == "paused"
    held = homed.status().counts
    sleep_s(homed.clock, 1.0)
    assert homed.status().counts == held
    homed.resume()
    paused = run_of(finish(homed, number))
    noted = [event.kind for event in paused.events if event.kind in ("pause", "resume")]
    assert noted == ["pause", "resume"]
    straight = run_of(finish(homed, homed.submit(write_job("again"))))
    path = paused.edges.counts[paused.edges.t_ns >= _path_start(paused)]
    same = straight.edges.counts[straight.edges.t_ns >= _path_start(straight)]
    # The same sequence of counts, whatever the times.
    assert _unique_rows(path)[-500:].tolist() == _unique_rows(same)[-500:].tolist()


@pytest.mark.study
def test_the_newest_target_is_told_while_a_path_is_drawn(
    homed: Controller, write_job, finish
) -> None:
    number = homed.submit(write_job())
    assert homed.status().target_m is None
    sleep_s(homed.clock, 5.0)
    seen = homed.status()
    run = run_of(finish(homed, number))
    assert homed.status().target_m is None
    assert seen.target_m is not None
    away_m = np.linalg.norm(run.targets.position_m - seen.target_m, axis=1)
    assert away_m.min() < 1e-6
    # At most the look-ahead before the arms: a tenth of a second at about 50 mm/s.
    assert np.linalg.norm(np.subtract(seen.target_m, seen.position_m)) < 0.01


def _path_start(run: Run) -> int:
    return next(event.t_ns for event in run.events if event.kind == "path_start")


def _unique_rows(counts: np.ndarray) -> np.ndarray:
    return counts[np.concatenate([[True], np.any(np.diff(counts, axis=0) != 0, axis=1)])]


def test_cancelling_what_is_not_there_is_refused_and_the_job_goes_on(
    homed: Controller, write_job
) -> None:
    number = homed.submit(write_job())
    sleep_s(homed.clock, 0.2)
    with pytest.raises(NotReady, match=f"job {number + 1} is neither running nor queued"):
        homed.cancel(number + 1)
    assert homed.status().job == "little"
    homed.cancel(number)


@pytest.mark.parametrize("asked", ["mine", "mine.mcap", "mine.csv"])
def test_a_recording_ends_in_mcap_whatever_was_asked_for(
    homed: Controller, write_job, tmp_path: Path, asked: str
) -> None:
    """The deletion of old ones looks for that."""
    homed.submit(write_job(), tmp_path / asked)
    sleep_s(homed.clock, 0.1)
    assert homed.jobs.running is not None
    assert homed.jobs.running.recording == str(tmp_path / "mine.mcap")


def test_cancelling_drops_the_queue(homed: Controller, write_job, finish) -> None:
    first = homed.submit(write_job())
    second = homed.submit(write_job("second"))
    sleep_s(homed.clock, 2.0)
    homed.cancel()
    assert finish(homed, first).outcome == "cancelled"
    assert finish(homed, second).outcome == "cancelled"
    assert homed.status().state == "ready"


@pytest.mark.study
def test_queued_jobs_run_one_after_the_other(homed: Controller, write_job, finish) -> None:
    numbers = [homed.submit(write_job(name)) for name in ("one", "two")]
    sleep_s(homed.clock, 1.0)
    assert homed.status().job == "one"
    assert homed.status().queued == ("two",)
    results = [finish(homed, number) for number in numbers]
    assert [result.outcome for result in results] == ["done", "done"]
    assert results[0].recording != results[1].recording


def test_the_emergency_stop_ends_the_pulses_and_the_job(
    homed: Controller, write_job, finish
) -> None:
    number = homed.submit(write_job())
    sleep_s(homed.clock, 5.0)
    bench = homed.machine.bench
    assert bench is not None
    bench.press_estop()
    sleep_s(homed.clock, 0.005)
    stopped_at = bench.counts()
    result = finish(homed, number)
    assert result.outcome == "stopped"
    assert "e-stop" in result.why
    sleep_s(homed.clock, 0.5)
    assert bench.counts() == stopped_at
    run = run_of(result)
    assert any(event.kind == "stop" for event in run.events)
    assert tuple(run.edges.counts[-1] - run.edges.counts[0]) == tuple(
        np.subtract(homed.status().counts, run.edges.counts[0])
    )


def test_a_drive_alarm_is_a_fault_that_names_the_motor(
    homed: Controller, write_job, finish
) -> None:
    number = homed.submit(write_job())
    sleep_s(homed.clock, 5.0)
    bench = homed.machine.bench
    assert bench is not None
    bench.trip(2)
    result = finish(homed, number)
    assert result.outcome == "fault"
    assert "motor2" in result.why
    assert homed.status().state == "fault"


def test_a_dead_bus_stops_the_robot_and_says_so(homed: Controller, write_job, finish) -> None:
    number = homed.submit(write_job())
    sleep_s(homed.clock, 5.0)
    rig = homed.machine.rig
    assert rig is not None
    rig.bus.stuck = True
    result = finish(homed, number)
    assert result.outcome == "fault"
    assert "errno 110" in result.why
    assert run_of(result).end_ns > 0


@pytest.mark.parametrize(
    ("radius_m", "error"), [(0.9, UnreachablePoint), (0.3, (UnreachablePoint, LimitExceeded))]
)
def test_a_path_out_of_reach_is_refused_before_anything_moves(
    homed: Controller, write_job, radius_m: float, error
) -> None:
    before = homed.status().counts
    with pytest.raises(error, match=r"point \d+"):
        homed.submit(write_job("wide", radius_m=radius_m))
    sleep_s(homed.clock, 0.5)
    assert homed.status().counts == before


def test_a_job_for_another_robot_is_refused(homed: Controller, write_job) -> None:
    from deltactl.firmware_py.named_files import CONFIG_FOLDER

    job = write_job("foreign", robot=CONFIG_FOLDER / "uzunovic-2013.yaml")
    with pytest.raises(ConfigError, match=r"this robot runs zhao-2023\.yaml"):
        homed.submit(job)


def test_a_recording_is_never_written_over(homed: Controller, write_job, tmp_path: Path) -> None:
    there = tmp_path / "there.mcap"
    there.write_bytes(b"precious")
    with pytest.raises(RecordingError, match="exists already"):
        homed.submit(write_job(), record=there)
    assert there.read_bytes() == b"precious"


@pytest.mark.study
def test_cancelling_one_job_leaves_the_others(homed: Controller, write_job, finish) -> None:
    first, second, third = (homed.submit(write_job(name)) for name in ("one", "two", "three"))
    sleep_s(homed.clock, 1.0)
    homed.cancel(second)
    assert finish(homed, second).outcome == "cancelled"
    homed.cancel(first)
    assert finish(homed, first).outcome == "cancelled"
    assert finish(homed, third).outcome == "done"
    with pytest.raises(NotReady):
        homed.cancel(third)


def test_a_stop_by_request_is_a_stop_and_no_fault(homed: Controller, write_job, finish) -> None:
    number = homed.submit(write_job())
    sleep_s(homed.clock, 2.0)
    homed.stop("tea time")
    result = finish(homed, number)
    assert (result.outcome, result.why) == ("stopped", "tea time")
    assert homed.status().state == "stopped"


@pytest.mark.study
def test_steps_that_a_drive_loses_are_told(homed: Controller, write_job, finish) -> None:
    job = write_job("sharp", t_pwm_s=0.00005)
    text = job.read_text().replace("shape: circle", "shape: heart")
    job.write_text(text.replace("radius_m: 0.02", "width_m: 0.2") + "on_step_loss: warn\n")
    result = finish(homed, homed.submit(job))
    assert result.outcome == "done"
    assert "lost" in result.warning
    assert "T_PWM" in result.warning
    assert finish(homed, homed.submit(write_job("calm"))).warning == ""


def test_progress_grows_to_all_of_it_and_the_path_begins_once(homed: Controller, write_job) -> None:
    number, seen = homed.submit(write_job(radius_m=0.005, t_pwm_s=0.003)), []
    while (result := homed.result(number)) is None:
        seen.append(homed.status().progress)
        sleep_s(homed.clock, 0.25)
    assert seen == sorted(seen)
    assert len(seen) > 5
    assert 0.0 <= seen[0] < 0.3
    assert 0.7 < seen[-1] <= 1.0
    kinds = [event.kind for event in run_of(result).events]
    assert [kinds.count(kind) for kind in ("approach", "path_start", "path_end")] == [1, 1, 1]


def test_what_feedback_says_at_the_end_is_a_warning_and_in_the_recording(
    homed: Controller, write_job, finish, monkeypatch: pytest.MonkeyPatch
) -> None:
    number = homed.submit(write_job(radius_m=0.005, t_pwm_s=0.003))
    while homed.jobs.running is None or homed.jobs.running.phase is not Phase.SETTLE:
        sleep_s(homed.clock, 0.05)
    said = SimpleNamespace(says=lambda: "the arms were up to 3 mm away")
    monkeypatch.setattr(homed.jobs.running, "feedback", said)
    result = finish(homed, number)
    assert result.warning == said.says()
    events = [(event.kind, event.text) for event in run_of(result).events]
    assert ("feedback", said.says()) in events
    assert result.warning == said.says()
