"""Three equal lags are late sensors, whatever else is the matter; three unlike lags are lags."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from deltactl.diagnosis.evidence.noise_estimation import prepare
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.plants.delta.candidates import lost_steps
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.search.search import Search
from deltactl.diagnosis.selection.ambiguity import resolved
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]
LATE_S = 0.14
LATE = EffectEntry(effect="sensor_latency", component="sensors", parameters={"time": LATE_S})
LOST = EffectEntry(
    effect="lost_steps", component="motor2", parameters={"steps": 90.0, "time": 13.0}
)


@pytest.mark.study
def test_three_equal_lags_beside_a_loss_settle_as_one_latency(
    delta: DeltaRobot, record: Record
) -> None:
    """Though the search came out with three lags, and whatever stands beside them."""
    model = DeltaModel(delta, [record(LATE, LOST, seconds=24.0)])
    assert delta.drive is not None
    search = Search(prepare(model, model.readings.valid), delta.drive.rad_per_step)
    lags = [one for one in model.candidates if one.effect == "following_lag"]
    starts = [Term(one, np.array([0.0, LATE_S])) for one in lags]
    loss = Term(lost_steps("motor2", 13.0), np.array([90.0, 13.0]))
    settled, stands = resolved(search, search.fitter.solve((*starts, loss)))
    assert {t.candidate.effect for t in settled.terms} == {"sensor_latency", "lost_steps"}
    number = [t.candidate.effect for t in settled.terms].index("sensor_latency")
    offered = {(a.effect, a.component, a.together) for a in stands[number].alternatives}
    assert {("following_lag", f"motor{m}", True) for m in (1, 2, 3)} <= offered


@pytest.mark.study
def test_three_unlike_lags_stay_three(delta: DeltaRobot, record: Record) -> None:
    unlike = {"motor1": 0.05, "motor2": 0.10, "motor3": 0.16}
    entries = [
        EffectEntry(effect="following_lag", component=motor, parameters={"time": late_s})
        for motor, late_s in unlike.items()
    ]
    model = DeltaModel(delta, [record(*entries, seconds=24.0)])
    search = Search(prepare(model, model.readings.valid), 0.0)
    lags = [one for one in model.candidates if one.effect == "following_lag"]
    settled, _ = resolved(
        search, search.fitter.solve([Term(o, np.array([0.1, 0.0])) for o in lags])
    )
    assert [t.candidate.key for t in settled.terms] == [one.key for one in lags]
