"""A corrected robot file against the recordings of its machine: nothing more is found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.proofs.contradictions import contradictions
from deltactl.diagnosis.answer.corrected_robot import save_corrected
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.plants.delta.measured_before import measured_before
from deltactl.diagnosis.report.fit import unexplained
from deltactl.diagnosis.report.screen import sentences
from deltactl.models.robot import DeltaRobot, EffectEntry, FloatArray, FoundBy
from deltactl.models.robot_files import load_delta
from tests.rigs.picker import HERTZ, ROBOT, SLOWED, STEP_S, followed, nominal, places, recorded

pytestmark = pytest.mark.study


@pytest.fixture(scope="module")
def first() -> Diagnosis:
    return diagnose_recordings(nominal(), [recorded(1)], [])


@pytest.fixture(scope="module")
def corrected(first: Diagnosis, tmp_path_factory: pytest.TempPathFactory) -> DeltaRobot:
    folder = tmp_path_factory.mktemp("again")
    (folder / "old.yaml").write_text(ROBOT)
    save_corrected(folder / "old.yaml", first, folder / "new.yaml")
    return load_delta(folder / "new.yaml")


def test_the_drives_are_found_late(first: Diagnosis) -> None:
    lags = {one.component for one in first.findings if one.effect == "following_lag"}
    assert lags == {"motor1", "motor2", "motor3"}


@pytest.mark.parametrize("seed", [1, 2])
def test_then_nothing_more_is_missing(corrected: DeltaRobot, seed: int) -> None:
    """In the recording they were found in, and in one of another day."""
    answer = diagnose_recordings(corrected, [recorded(seed)], [])
    assert not answer.findings
    assert answer.verdict == "nothing_missing"
    assert "usually leave beyond their simple models" in unexplained(answer)


def test_what_is_new_is_found(corrected: DeltaRobot) -> None:
    answer = diagnose_recordings(corrected, [recorded(2, warm_rad=0.02)], [])
    assert [(one.effect, one.component) for one in answer.findings] == [("home_offset", "motor1")]


def later_s(commanded: FloatArray) -> float:
    """By how much the slower drive follows the other, as the shift that makes them most alike."""
    t_s = np.arange(len(commanded)) * STEP_S
    usual, slower = followed(commanded, HERTZ), followed(commanded, SLOWED * HERTZ)
    shifts_s = np.arange(0.0, 0.03, 1e-4)
    apart = [float(np.std(np.interp(t_s + s, t_s, slower) - usual)) for s in shifts_s]
    return float(shifts_s[np.argmin(apart)])


def test_a_drive_that_has_become_slower_is_found(corrected: DeltaRobot) -> None:
    answer = diagnose_recordings(corrected, [recorded(2, first_hertz=SLOWED * HERTZ)], [])
    assert [(one.effect, one.component) for one in answer.findings] == [("following_lag", "motor1")]
    sizes = [one.components[0] for one in answer.findings[0].parameters.values()]
    low_s, high_s = (sum(one[end] for one in sizes) for end in (1, 2))
    assert low_s < later_s(places(2)[:, 0]) < high_s
    assert any("top of what the robot file has" in x for x in sentences(answer, corrected))


PARAMETERS = {
    "following_lag": ("time", {"dead_time": 0.01}),
    "viscous_friction": ("coefficient", {}),
    "transmission_error": ("amplitude", {"period": 0.3, "phase": 2.0}),
    "joint_compliance": ("stiffness", {}),
}


@given(
    effect=st.sampled_from(sorted(PARAMETERS)),
    size=st.floats(0.01, 0.1),
    share=st.floats(0.01, 0.5),
)
def test_what_is_known_is_fitted_around_its_size(effect: str, size: float, share: float) -> None:
    """Coordinates at their centre are the entry's parameters."""
    main, others = PARAMETERS[effect]
    size = size * (1e4 if effect == "joint_compliance" else 1.0)
    found = FoundBy(
        recordings=("a.csv",),
        on="2026-01-31",
        ci95={main: ((1.0 - share) * size, (1.0 + share) * size)},
    )
    entry = EffectEntry(
        effect=effect, component="joints" if effect == "joint_compliance" else "motor2",
        parameters={main: size, **others}, found=found,
    )  # fmt: skip
    robot = nominal().model_copy(update={"effects": (entry,)})
    bare, (nuisance,) = measured_before(robot, 1.0, 60.0)
    assert not bare.effects
    values = nuisance.term.candidate.values(nuisance.term.at)
    for name, value in entry.parameters.items():
        assert values[name] == pytest.approx(value)
    assert all(spread > 0.0 for spread in nuisance.spread)


@pytest.mark.parametrize("by_hand", [True, False])
def test_lengths_and_what_is_written_by_hand_stay(by_hand: bool) -> None:
    found = FoundBy(recordings=("a.csv",), on="2026-01-31", ci95={"time": (0.01, 0.03)})
    lag = EffectEntry(
        effect="following_lag", component="motor1", parameters={"time": 0.02},
        found=None if by_hand else found,
    )  # fmt: skip
    home = EffectEntry(
        effect="home_offset", component="motor1", parameters={"angle": 0.01},
        found=found.model_copy(update={"ci95": {"angle": (0.009, 0.011)}}),
    )  # fmt: skip
    robot = nominal().model_copy(update={"effects": (lag, home)})
    bare, measured = measured_before(robot, 1.0, 60.0)
    assert bare.effects == ((lag, home) if by_hand else (home,))
    assert len(measured) == (0 if by_hand else 1)


@pytest.mark.parametrize("all_rad", [0.0006, 0.002, 0.004])
def test_what_is_named_is_more_probable_than_nothing(corrected: DeltaRobot, all_rad: float) -> None:
    """Together the joints show more than their drives may leave; each by itself does not."""
    answer = diagnose_recordings(corrected, [recorded(1, all_rad=all_rad)], [])
    assert contradictions(answer) == []


def test_a_delay_whose_parts_are_open_is_known_in_all() -> None:
    """Rows 44 ms apart leave its division open; both intervals are no room for a later drive."""
    ends = {"time": (0.0009, 0.0596), "dead_time": (0.0688, 0.1274)}
    spread = {"time": (0.015,), "dead_time": (-0.015, 0.0005)}
    found = FoundBy(recordings=("a.csv",), on="2026-01-31", ci95=ends, spread=spread)
    lag = EffectEntry(
        effect="following_lag", component="motor1",
        parameters={"time": 0.0215, "dead_time": 0.1069}, found=found,
    )  # fmt: skip
    _, (nuisance,) = measured_before(nominal().model_copy(update={"effects": (lag,)}), 1.0, 60.0)
    assert min(nuisance.spread) > 0.015
    assert nuisance.together is not None
    assert nuisance.together < 0.005


def test_small_errors_are_allowed_for_again(first: Diagnosis, tmp_path: Path) -> None:
    """Of a machine whose first diagnosis needed them; the file says so."""
    (tmp_path / "old.yaml").write_text(ROBOT)
    loose = first.model_copy(update={"loosely_built": True})
    save_corrected(tmp_path / "old.yaml", loose, tmp_path / "new.yaml")
    robot = load_delta(tmp_path / "new.yaml")
    found = [entry.found for entry in robot.effects]
    assert all(one is not None and one.loosely_built for one in found)
    again = diagnose_recordings(robot, [recorded(1)], [])
    assert again.loosely_built
    assert any("were allowed for" in line for line in sentences(again))
