"""Short moves between rests: what stands out while the machine moves is mismatch, no outlier."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.observations.readings import without_outliers
from tests.rigs.picker import nominal, recorded

pytestmark = pytest.mark.study

ROWS = 2000
SPIKES = 20
LONG_REST = 75


@pytest.fixture(scope="module")
def rested() -> Diagnosis:
    """Of a machine that moves a quarter of the time."""
    return diagnose_recordings(nominal(), [recorded(3, stays=LONG_REST)], [])


def test_a_few_wild_readings_are_outliers_and_moves_are_none() -> None:
    rng = np.random.default_rng(1)
    noise = 1e-4 * rng.standard_normal((ROWS, 2))
    wild = rng.choice(ROWS, SPIKES, replace=False)
    noise[wild, 0] += 0.01
    moves = (np.arange(ROWS) % 40) < 8
    noise[:, 1] += 0.02 * moves * np.sin(np.arange(ROWS))
    kept = without_outliers(noise, np.ones((ROWS, 2), dtype=bool))
    assert not kept[wild, 0].any()
    assert kept[:, 0].sum() > ROWS - 2 * SPIKES
    assert kept[:, 1].all()


def test_the_mismatch_is_that_of_all_readings(rested: Diagnosis) -> None:
    """Once 15 to 45 % of real recordings were left out, all of them taken in motion."""
    columns = recorded(3, stays=LONG_REST).columns
    apart = [columns[f"theta_{arm}"] - columns[f"command_{arm}"] for arm in (1, 2, 3)]
    assert rested.fit.rms_before_m == pytest.approx(float(np.sqrt(np.mean(np.square(apart)))), 0.01)


def test_what_late_drives_leave_is_no_second_cause(rested: Diagnosis) -> None:
    assert {finding.effect for finding in rested.findings} == {"following_lag"}
    assert {finding.component for finding in rested.findings} == {"motor1", "motor2", "motor3"}
