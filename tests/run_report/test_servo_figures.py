"""How servos followed, from made-up samples with known errors."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.run_report.sections import following, servo_section
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.reading.reader import read_run
from deltactl.recording.reading.run import Run, Servo
from deltactl.recording.writing.writer import RunRecorder

MS = 1_000_000


@pytest.fixture
def run(tmp_path: Path) -> Run:
    with RunRecorder(tmp_path / "r.mcap", RunConfiguration(robot_text="", job_text="")) as made:
        made.event(0, "path_start", "")
    t_ns = np.arange(0, 1000) * MS
    reference = np.outer(np.sin(2 * np.pi * t_ns * 1e-9), [0.1, 0.2, 0.4])
    error = np.where(np.arange(1000) % 2, 1.0, -1.0)[:, None] * [1e-3, 1e-3, 2e-3]
    error[900:] *= 100.0
    current = np.full((1000, 3), 0.05)
    servo = Servo(t_ns, reference, reference + error, current, current)
    return replace(read_run(tmp_path / "r.mcap"), servo=servo)


def test_errors_are_per_cent_of_peak_to_peak_on_the_path_only(run: Run) -> None:
    found = following(run, ((0, 899 * MS),))
    assert found is not None
    assert found.swing_rad == pytest.approx([0.2, 0.4, 0.8], rel=1e-4)
    assert found.max_percent == pytest.approx([0.5, 0.25, 0.25], rel=1e-3)
    assert found.rms_rad == pytest.approx([1e-3, 1e-3, 2e-3])
    assert found.current_rms_a == pytest.approx([0.05] * 3)
    assert following(run, ()) is None


def test_a_stepper_s_run_has_no_such_section(run: Run) -> None:
    assert "Following error" in "".join(servo_section(run, ((0, 899 * MS),)))
    nothing = Servo(np.empty(0, dtype=np.int64), *[np.empty((0, 3))] * 4)
    assert servo_section(replace(run, servo=nothing), ()) == []
