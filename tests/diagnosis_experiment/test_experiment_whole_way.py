"""Diagnose, run what is proposed, diagnose both: the right name stands alone."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.plants.delta.motions import Motion
from deltactl.models.robot import DeltaRobot, EffectEntry

pytestmark = pytest.mark.study

if TYPE_CHECKING:
    from collections.abc import Callable

HIDDEN = [
    EffectEntry(effect="forearm_length", component="arm2", parameters={"length_error": 0.004}),
    EffectEntry(effect="sensor_offset", component="range_z", parameters={"offset": 0.006}),
]


@pytest.mark.parametrize("hidden", HIDDEN, ids=[c.effect for c in HIDDEN])
def test_the_second_recording_leaves_one_name(
    bench: Any, delta: DeltaRobot, circle: Callable[..., Motion], hidden: EffectEntry
) -> None:
    # Of six draws of the noise five have the right name in their answer; the first has not.
    first = bench.record(circle(turns=2), hidden, seed=4)
    answer = diagnose_recordings(delta, [first])
    names = [(a.effect, a.component) for f in answer.findings for a in (f, *f.alternatives)]
    assert (hidden.effect, hidden.component) in names
    plan = answer.next_experiment
    assert plan is not None

    path = plan.job["path"]
    lap = np.array(path["angles_deg"])
    laps = np.concatenate([lap, *[lap[1:]] * (plan.job["repeats"] - 1)])
    motion = Motion("next", "", laps, path["dwell_s"], plan.job["timing"]["t_pwm_s"])
    second = bench.record(motion, hidden, seed=2)
    settled = diagnose_recordings(delta, [first, second])
    (finding,) = settled.findings
    assert (finding.effect, finding.component) == (hidden.effect, hidden.component)
    assert finding.alternatives == []
    assert settled.next_experiment is None
