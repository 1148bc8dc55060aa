"""Single wild readings are left out, turning points are not; an effort that always brakes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.observations.outliers import begun_in_motion, gross_outliers
from deltactl.foundation.errors import RecordingError
from deltactl.models.robot import ServoAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns
from tests.axes.axis_rigs import ForcedRig

FORCED = ServoAxis(kind="servo_axis", name="forced", motion="linear", inertia=2.0)


def test_a_spike_of_a_tenth_of_the_travel_is_left_out() -> None:
    t_s = np.arange(0.0, 6.0, 0.01)
    seen = 80.0 * np.sin(0.4 * t_s) + 0.05 * np.random.default_rng(0).standard_normal(len(t_s))
    assert not gross_outliers(seen).any()
    seen[200] -= 8.0
    assert np.flatnonzero(gross_outliers(seen)).tolist() == [200]


@settings(max_examples=20, deadline=None)
@given(st.floats(0.05, 3.0), st.integers(0, 1000), st.sampled_from([0.0, 0.01, 0.1]))
def test_a_motion_that_turns_back_has_no_spikes(hz: float, seed: int, noise: float) -> None:
    t_s = np.arange(0.0, 20.0, 0.05)
    rng = np.random.default_rng(seed)
    seen = np.sin(2.0 * np.pi * hz * t_s + rng.uniform(0.0, 6.0))
    seen = seen + noise * rng.standard_normal(len(t_s))
    assert not gross_outliers(seen).any()


@pytest.mark.study
def test_an_effort_of_the_wrong_sign_is_refused_where_friction_rules_too() -> None:
    recording = ForcedRig(coulomb=20.0, viscous=6.0, mass=2.0).record(1, span_s=5.0)
    assert diagnose_recordings(FORCED, [recording]).findings
    turned = {**recording.columns, "effort": -recording.columns["effort"]}
    wrong = FlatRecording(recording.t_s, turned, {}, recording.source)
    with pytest.raises(RecordingError, match="sign of effort"):
        diagnose_recordings(FORCED, [wrong])


def test_a_stretch_that_begins_at_rest_counts_from_its_first_row() -> None:
    t_s = np.concatenate([np.arange(0.0, 5.0, 0.02), np.arange(10.0, 15.0, 0.02)])
    fresh = np.zeros(len(t_s), dtype=bool)
    fresh[[0, 250]] = True
    told = np.where(t_s < 1.0, 0.0, np.sin(t_s - 1.0))[:, None]  # the second begins in motion
    left_out = np.flatnonzero(begun_in_motion(t_s, told, fresh))
    assert left_out[0] == 250
    assert left_out[-1] == pytest.approx(265, abs=1)
    assert not begun_in_motion(t_s, np.zeros_like(told), fresh).any()
    few = from_columns({"t": t_s[:20], "command": told[:20, 0]}, "a.csv")
    assert not begun_in_motion(few.t_s, told[:20], fresh[:20]).any()
