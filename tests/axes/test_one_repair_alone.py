"""What each repair of an axis alone would do to the recorded motion."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import ServoAxis
from deltactl.recording.tables.flat import from_columns

AXIS = ServoAxis(kind="servo_axis", name="joint", motion="rotary", zero="absolute")
OFFSET_RAD, SCALE, NOISE_RAD = 0.004, 1.03, 1e-4


def test_the_error_that_one_repair_leaves_is_that_of_the_other_cause() -> None:
    rng = np.random.default_rng(4)
    t_s = np.arange(0.0, 40.0, 0.02)
    asked = 0.3 * np.sin(0.9 * t_s) + 0.1 * np.sin(2.3 * t_s)
    read = SCALE * asked + OFFSET_RAD + NOISE_RAD * rng.standard_normal(len(t_s))
    columns = {"t": t_s, "command": asked, "position": read}
    answer = diagnose_recordings(AXIS, [from_columns(columns, "a.csv")])
    left_rad = {one.effect: one.alone_m for one in answer.findings}
    stretched = float(np.sqrt(np.mean(((SCALE - 1.0) * asked) ** 2)))
    assert left_rad["home_offset"] == pytest.approx(stretched, rel=0.02)
    assert left_rad["gear_ratio"] == pytest.approx(OFFSET_RAD, rel=0.02)
    for one in answer.findings:
        assert one.alone_m is not None
        assert one.alone_ci95_m is not None
        low, high = one.alone_ci95_m
        assert low <= one.alone_m <= high < answer.fit.rms_before_m
