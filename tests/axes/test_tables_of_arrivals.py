"""Tables of places, read at rest: what they can tell, and what no such table can."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.plants.lone.commanded_axis import CommandedAxis
from deltactl.diagnosis.plants.lone.travel import arrivals, direction_of, turns
from deltactl.models.robot import ServoAxis
from deltactl.recording.tables.flat import FlatRecording, from_columns

SLIDE = ServoAxis(kind="servo_axis", name="slide", motion="linear", zero="absolute")
PLACES_M = np.linspace(0.015, 0.055, 5)


def _table(
    commanded_m: np.ndarray, error_m: np.ndarray, seed: int = 1, noise_m: float = 3e-7
) -> FlatRecording:
    t_s = 10.0 * np.arange(len(commanded_m))
    noise = noise_m * np.random.default_rng(seed).standard_normal(len(t_s))
    columns = {"t": t_s, "command": commanded_m, "position": commanded_m + error_m + noise}
    return from_columns(columns, "table")


def _up_and_down() -> tuple[np.ndarray, np.ndarray]:
    """Command (50,) [m] of five cycles over five places, and the way each was come from.

    Such tables leave the ends between two readings and come back to them from the other side.
    """
    cycle = np.concatenate([PLACES_M, PLACES_M[::-1]])
    way = np.repeat([1.0, -1.0], 5)
    return np.tile(cycle, 5), np.tile(way, 5)


def _named(answer: Diagnosis) -> set[str]:
    return {one.effect for one in answer.findings}


def _untold(answer: Diagnosis) -> dict[str, str]:
    return {one.effect: one.why for one in answer.not_testable}


def test_a_lead_one_way_is_unknown_physics_of_the_direction() -> None:
    """Play leaves an axis behind; one that stands ahead of its command has no name."""
    commanded_m, way = _up_and_down()
    answer = diagnose_recordings(SLIDE, [_table(commanded_m, 2e-6 * way)])
    assert _named(answer) == {"unknown"}
    assert answer.findings[0].depends_on == ["direction"]


def test_play_in_a_table_is_still_play() -> None:
    once = np.concatenate([PLACES_M, PLACES_M[-2:0:-1]])
    commanded_m = np.tile(once, 7)
    way = np.sign(np.diff(commanded_m, prepend=0.0))
    answer = diagnose_recordings(SLIDE, [_table(commanded_m, -2e-6 * way)])
    (found,) = answer.findings
    assert {found.effect, *(a.effect for a in found.alternatives)} >= {
        "gear_backlash",
        "joint_friction",
    }
    assert found.parameters["width"].value == pytest.approx(4e-6, rel=0.1)


def test_three_places_show_no_wave_no_play_and_no_lag() -> None:
    """Rows ten seconds apart that go one way: a bow of the guide is no gear's error.

    Beside an arbitrary zero; where the zero means something, play is a tie with it.
    """
    commanded_m = np.repeat([0.015, 0.035, 0.055], 16)
    slide = SLIDE.model_copy(update={"zero": "arbitrary"})
    plant = CommandedAxis(slide, [_table(commanded_m, 4e-5 * np.square(commanded_m / 0.055))])
    offered = {one.effect for one in plant.regressors}
    assert not offered & {
        "transmission_error", "gear_backlash", "joint_friction", "following_lag", "resonance",
    }  # fmt: skip
    untold = {one.effect: one.why for one in plant.not_testable()}
    assert "never turns back" in untold["gear_backlash"]
    assert "further apart" in untold["following_lag"]


def test_a_spring_is_no_alternative_where_no_load_is_known() -> None:
    commanded_m, _ = _up_and_down()
    answer = diagnose_recordings(SLIDE, [_table(commanded_m, np.full(50, 1e-5))])
    (found,) = answer.findings
    assert found.effect == "home_offset"
    assert not found.alternatives
    assert "load" in _untold(answer)["joint_compliance"]


@pytest.mark.study
def test_a_slip_of_a_servo_is_no_ratio() -> None:
    """It counts no steps that could be lost, but what stands elsewhere from one moment on does."""
    t_s = 0.5 * np.arange(300)
    commanded = 1e-3 * t_s
    slip = np.where(t_s > 70.0, -3e-4, 0.0)
    noise = 5e-5 * np.random.default_rng(4).standard_normal(len(t_s))
    columns = {"t": t_s, "command": commanded, "position": commanded + slip + noise}
    mount = ServoAxis(kind="servo_axis", name="mount", motion="rotary")
    answer = diagnose_recordings(mount, [from_columns(columns, "slip")])
    assert _named(answer) == {"unknown"}
    assert answer.findings[0].depends_on == ["time"]


def test_the_way_of_a_command_is_kept_while_it_stands() -> None:
    commanded = np.array([0.0, 0.0, 1.0, 2.0, 2.0, 1.9999, 1.0, 5.0, 5.0])
    fresh = np.zeros(9, dtype=bool)
    fresh[[0, 7]] = True
    way = direction_of(commanded, fresh, hair=0.01)
    assert way.tolist() == [0, 0, 1, 1, 1, 1, -1, 0, 0]
    assert turns(way, fresh)
    assert not turns(direction_of(np.arange(9.0), fresh, 0.01), fresh)


def test_a_table_comes_back_to_its_ends_from_beyond() -> None:
    commanded = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.0, 0.0, 1.0, 1.0, 2.0])
    way = direction_of(commanded, np.arange(10) == 0, hair=0.01)
    assert arrivals(commanded, way, 0.01).tolist() == [0, 1, 1, -1, -1, -1, 1, 1, 0, 1]


def test_what_foretells_blocks_left_out_is_claimed() -> None:
    """Rounding that repeats leaves six independent readings, of which no test sees anything."""
    places_m = np.repeat([0.015, 0.035, 0.055], 10)
    commanded_m = np.stack([places_m - 2e-3, places_m, places_m + 2e-3, places_m], 1).ravel()
    up_m, down_m = np.repeat([[5e-7, 8e-7, 1e-6], [-9e-7, -7e-7, -5e-7]], 10, axis=1)
    unread = np.full(30, np.nan)
    lead_m = np.stack([unread, up_m, unread, down_m], 1).ravel()
    t_s = 5.0 * np.arange(len(commanded_m))
    position_m = np.round(commanded_m + lead_m, 7)
    columns = {"t": t_s, "command": commanded_m, "position": position_m}
    answer = diagnose_recordings(SLIDE, [from_columns(columns, "arrivals")])
    assert [one.depends_on for one in answer.findings] == [["direction"]]
