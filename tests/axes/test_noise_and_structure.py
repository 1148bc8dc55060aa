"""What an answer leaves is compared with a noise that does not come from it."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.robot import ServoAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns

pytestmark = pytest.mark.study

pytest.importorskip("scipy", reason="the diagnosis needs the extra 'diagnosis'")

ARM = ServoAxis(kind="servo_axis", name="arm", motion="rotary", inertia=0.5)
FOLLOWS = ServoAxis(kind="servo_axis", name="follows", motion="rotary")


def swung(pull_nm: float, seed: int) -> FlatRecording:
    """An arm that swings under its inertia while a neighbour pulls at its own pace; noise 0.5."""
    t_s = np.arange(0.0, 20.0, 0.004)
    swings = ((0.9, 2.1, 0.0), (0.35, 5.3, 1.0))
    angle = sum(size * np.sin(rate * t_s + at) for size, rate, at in swings)
    accel = sum(-size * rate**2 * np.sin(rate * t_s + at) for size, rate, at in swings)
    neighbour = np.sin(3.3 * t_s + 0.4) + 0.6 * np.sin(1.27 * t_s)
    rng = np.random.default_rng(seed)
    effort = 0.5 * accel + pull_nm * neighbour + rng.normal(0.0, 0.5, len(t_s))
    position = angle + rng.normal(0.0, 1e-6, len(t_s))
    return from_columns({"t": t_s, "position": position, "effort": effort}, "swung")


def pulled_axis(size: float, rho: float, rigs: ModuleType, seed: int) -> FlatRecording:
    """An axis that follows its command; something else moves it at its own pace."""
    plain = rigs.FollowingRig(noise=2e-4, rho=rho).record(seed, span_s=40.0)
    own = size * np.sin(1.9 * plain.t_s) * np.sin(0.83 * plain.t_s + 1.0)
    columns = {**plain.columns, "position": plain.columns["position"] + own}
    return from_columns({"t": plain.t_s, **columns}, "pulled")


def test_a_pull_that_nothing_explains_is_not_the_noise_of_an_effort() -> None:
    answer = diagnose_recordings(ARM, [swung(3.0, 1)])
    assert answer.verdict != "nothing_missing"
    assert (answer.probability_nothing_missing or 0.0) < 0.1
    assert answer.fit.noise_floor_m < 0.5 * answer.fit.rms_after_m


def test_without_the_pull_the_same_effort_is_noise() -> None:
    answer = diagnose_recordings(ARM, [swung(0.0, 2)])
    assert answer.verdict == "nothing_missing"


def test_a_pull_that_nothing_explains_is_not_the_noise_of_a_reading(rigs: ModuleType) -> None:
    answer = diagnose_recordings(FOLLOWS, [pulled_axis(2e-3, 0.3, rigs, 3)])
    assert answer.verdict in ("unexplained", "partly_explained")
    assert answer.fit.noise_floor_m < 0.6 * answer.fit.rms_after_m


@pytest.mark.parametrize("rho", [0.0, 0.6, 0.85])
def test_a_noise_with_a_memory_is_no_structure(rigs: ModuleType, rho: float) -> None:
    answer = diagnose_recordings(FOLLOWS, [pulled_axis(0.0, rho, rigs, 4)])
    assert answer.verdict == "nothing_missing"
