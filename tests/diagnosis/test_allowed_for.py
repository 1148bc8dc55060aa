"""Small errors that are no findings are told with their sizes where a recording shows them."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.models.chain import Chain, Commands
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

HOME_RAD = 0.0026
"""0.15 degrees: within what careful building leaves, and 60 times the noise of an encoder."""


def _angles(delta: DeltaRobot, effects: list[EffectEntry]) -> FlatRecording:
    """40 s of commanded and measured angles: moves between random places, noise of 0.0025 deg."""
    rng = np.random.default_rng(3)
    t_s = 0.02 * np.arange(2000)
    places = rng.uniform(0.1, 0.8, (41, 3))
    along = np.clip(t_s % 1.0 / 0.7, 0.0, 1.0)
    moved = (along**2 * (3.0 - 2.0 * along))[:, None]
    number = t_s.astype(int)
    asked = places[number] + moved * (places[number + 1] - places[number])
    seen = Chain(delta).simulate(Commands.of_angles(t_s, asked), effects).measured
    seen = seen + 4.4e-5 * rng.standard_normal(seen.shape)
    columns = {f"command_{j + 1}": asked[:, j] for j in range(3)}
    columns |= {f"theta_{j + 1}": seen[:, j] for j in range(3)}
    return FlatRecording(t_s, columns, {}, "synthetic")


@pytest.mark.study
def test_a_home_angle_that_is_allowed_for_is_told_with_its_size(delta: DeltaRobot) -> None:
    """A joint that read 0.4 degrees too much was allowed for, and nothing told how much it was."""
    late = EffectEntry(effect="following_lag", component="motor1", parameters={"time": 0.1})
    off = EffectEntry(effect="home_offset", component="motor2", parameters={"angle": HOME_RAD})
    answer = diagnose_recordings(delta, [_angles(delta, [late, off])])
    assert {one.component for one in answer.findings} == {"motor1"}
    (home,) = [one for one in answer.allowed_for if one.effect == "home_offset"]
    assert home.component == "motor2"
    assert home.parameters["angle"].value == pytest.approx(HOME_RAD, rel=0.1)
    (said,) = [line for line in answer.says if "were allowed for" in line]
    assert "a wrong home angle of motor 2 (+0.15 degrees, usually up to " in said
    assert "More than careful building" not in said
