"""What is drawn of single axes: repeatable, readable as the contract says, and ties by physics."""

from __future__ import annotations

import json
import sys
from collections import Counter

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the command that writes cases needs the extra 'proof'")

from deltactl.models.robot_files import load_with_effects
from deltactl.proof import generate
from deltactl.proof.axis.cases import (
    HOLDOUT,
    MACHINES,
    RECORDING,
    ROBOT_FILE,
    ROUND,
    draw,
    write_blind,
)
from deltactl.proof.axis.catalogue import COMMANDED, FORCED, KINDS, UNKNOWN, Scale
from deltactl.proof.axis.commanded import CommandedAxis
from deltactl.proof.axis.forced import ForcedAxis
from deltactl.proof.axis.motions import Pace, move
from deltactl.proof.axis.observer import Observer, alternatives, bound, sized
from deltactl.proof.axis.sensing import Mess, Noise, Rows, whitened
from deltactl.recording.tables.flat_files import read_flat

ROWS_S = np.arange(1.0, 39.0, 0.02)
SCALE = Scale(length=1.0, time=2.0, speed=0.8, period=0.02, span=40.0, force=2.0, inertia=2.0)


def watched(style: str, machine: str, **more) -> Observer:
    """An observer of an axis in a motion, with noise of a thousandth."""
    motion = move(style, Pace(40.0, 0.002, 1.0, 2.0), np.random.default_rng(5))
    used = np.ones(len(ROWS_S), dtype=bool)
    if machine == "commanded":
        axis = CommandedAxis(motion, load=np.zeros_like(motion.t_s), start=-1.0)
        return Observer(axis, ROWS_S, Noise(1e-3), used, **more)
    forced = ForcedAxis(motion, 2.0, bandwidth=60.0).run({})
    return Observer(forced, ROWS_S, Noise(0.02), forced.informative(ROWS_S), every=5)


@pytest.mark.study
@pytest.mark.parametrize("seed", [0, 5, 13, 28])
def test_a_seed_is_one_case_and_its_files_are_those_of_the_contract(seed: int, tmp_path) -> None:
    case, again = draw(seed), draw(seed)
    assert case.truth() == again.truth()
    write_blind(case, tmp_path / "one")
    write_blind(again, tmp_path / "two")
    for name in (RECORDING, HOLDOUT):
        one, two = (read_flat(tmp_path / folder / name) for folder in ("one", "two"))
        assert np.all(np.diff(one.t_s) > 0.0)
        assert len(one) > 100
        for column, values in one.columns.items():
            np.testing.assert_array_equal(values, two.columns[column])
    robot = load_with_effects(tmp_path / "one" / ROBOT_FILE)
    kinds = {"commanded": ("servo_axis", "stepper_axis"), "effort": ("servo_axis",),
             "range": ("range_sensor",)}  # fmt: skip
    assert robot.kind in kinds[case.design.machine]
    text = (tmp_path / "one" / ROBOT_FILE).read_text()
    assert not any(one.kind.effect in text for one in case.hidden)


def test_any_case_can_be_written_to_files(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.setattr(sys, "argv", ["generate", "--axis", "15", "--out", str(tmp_path)])
    generate.main()
    truth = json.loads((tmp_path / "answers.json").read_text())
    assert truth["case"] == "axis_000015"
    assert truth["answers"][0]["effect"] in capsys.readouterr().out
    assert len(read_flat(tmp_path / RECORDING)) == truth["rows"]


@pytest.mark.study
def test_even_and_odd_seeds_hold_the_same_mixture() -> None:
    drawn = [draw(seed) for seed in range(40, 48)]
    mixture = [Counter((c.tier, c.design.machine) for c in drawn[half::2]) for half in (0, 1)]
    assert mixture[0] == mixture[1]
    assert len({c.design.noise.sigma for c in drawn}) == 8
    assert len(set(ROUND)) == 9
    assert set(MACHINES) == set(KINDS) == set(UNKNOWN)


@pytest.mark.study
def test_every_tier_is_what_it_promises() -> None:
    # Seeds whose turn in the round is the tier, each with a machine of its own.
    for turn, tier in enumerate(ROUND[:15]):
        if tier in ROUND[:turn]:
            continue
        case = draw(2 * turn + 1)
        truth = case.truth()
        count = {"none": 0, "pair": 2, "three": 3}.get(tier, 1)
        assert (truth["tier"], len(truth["answers"])) == (tier, count)
        for answer in truth["answers"]:
            ratio = answer["rms"] / truth["noise_rms"]
            assert ratio < 0.5 if tier == "faint" else answer["chi2"] > 200.0
            assert answer["effect"] in answer["names"]
            if tier == "gross":
                assert ratio > 12.0
            if tier == "ambiguous":
                assert len(answer["names"]) + len(answer["ties"]) > 1
        assert (tier == "unknown") == ("unknown" in [a["effect"] for a in truth["answers"]])
        assert (tier == "tolerance") <= (len(truth["also"]) >= 2)


def test_a_one_way_run_ties_friction_and_a_constant_effort_and_a_sweep_does_not() -> None:
    for style, tied in (("oneway", True), ("sweep", False)):
        observer = watched(style, "effort")
        for effect, values in (
            ("effort_offset", {"offset": 1.0}), ("joint_friction", {"torque": 1.0}),
        ):  # fmt: skip
            alike = alternatives(observer, FORCED, SCALE, {effect: values}, effect)
            other = {"effort_offset": "joint_friction", "joint_friction": "effort_offset"}[effect]
            assert (other in alike.same) == tied


def test_mass_and_gain_without_a_known_force_are_one() -> None:
    observer = watched("random", "effort")
    alike = alternatives(observer, FORCED, SCALE, {"effort_gain": {"scale": 1.2}}, "effort_gain")
    assert "inertia" in alike.same


def test_play_that_never_turns_back_is_an_offset_and_a_delay_is_a_late_reading() -> None:
    one_way, back = (watched(style, "commanded") for style in ("oneway", "sweep"))
    play = {"gear_backlash": {"width": 0.05}}
    # It lies on the flank behind it from the start: nothing but a constant is left.
    assert one_way.rms(one_way.signal(play, True) - one_way.signal({}, True)) == pytest.approx(
        0.025
    )
    assert "home_offset" in alternatives(one_way, COMMANDED, SCALE, play, "gear_backlash").same
    turned = alternatives(back, COMMANDED, SCALE, play, "gear_backlash")
    assert "home_offset" not in [*turned.same, *turned.ties]
    assert "joint_friction" in turned.same
    late = {"following_lag": {"time": 0.0, "dead_time": 0.05}}
    assert alternatives(back, COMMANDED, SCALE, late, "following_lag").same == ["sensor_latency"]


def test_a_free_zero_leaves_nothing_of_an_offset() -> None:
    known, free = watched("sweep", "commanded"), watched("sweep", "commanded", free_zero=True)
    offset = {"home_offset": {"angle": 0.01}}
    signal = known.parts(offset, "home_offset")
    assert known.chi2(signal) == pytest.approx(len(ROWS_S) * 100.0, rel=1e-6)
    assert free.chi2(signal) == pytest.approx(0.0, abs=1e-9)


def test_the_bound_of_a_constant_is_that_of_a_mean() -> None:
    observer = watched("sweep", "commanded")
    found = bound(observer, {"home_offset": {"angle": 0.01}})
    assert found["home_offset"]["angle"] == pytest.approx(1e-3 / np.sqrt(len(ROWS_S)), rel=1e-6)


def test_the_bound_is_what_an_efficient_estimate_reaches() -> None:
    observer = watched("sweep", "commanded")
    truth = {"gear_ratio": {"scale": 1.02}, "home_offset": {"angle": 0.01}}
    found = bound(observer, truth)
    clean, place = observer.signal(truth), observer.machine.motion.at(ROWS_S)
    columns = np.column_stack([place, np.ones_like(place)])
    rng = np.random.default_rng(3)
    fitted = np.array([
        np.linalg.lstsq(columns, clean + 1e-3 * rng.standard_normal(len(clean)), rcond=None)[0]
        for _ in range(400)
    ])  # fmt: skip
    spread = fitted.std(axis=0)
    assert found["gear_ratio"]["scale"] == pytest.approx(spread[0], rel=0.12)
    assert found["home_offset"]["angle"] == pytest.approx(spread[1], rel=0.12)


@pytest.mark.parametrize("ratio", [0.2, 5.0, 30.0])
def test_an_effect_is_drawn_as_large_as_its_tier_says(ratio: float) -> None:
    observer = watched("random", "commanded")
    for effect in ("gear_backlash", "gear_ratio", "transmission_error", "following_lag"):
        kind = next(one for one in COMMANDED if one.effect == effect)
        drawn = kind.extras(np.random.default_rng(1), SCALE)
        values = sized(observer, kind, drawn, SCALE, ratio)
        signal = observer.signal({effect: values}, True) - observer.signal({}, True)
        assert observer.rms(signal) == pytest.approx(ratio * 1e-3, rel=0.1)


def test_noise_is_as_large_and_as_correlated_as_it_says() -> None:
    noise = Noise(0.5, rho=0.6)
    drawn = noise.read(np.zeros(40_000), np.random.default_rng(1))
    assert drawn.std() == pytest.approx(0.5, rel=0.03)
    assert np.corrcoef(drawn[1:], drawn[:-1])[0, 1] == pytest.approx(0.6, abs=0.02)
    white = whitened(drawn[:, None], noise)[:, 0]
    assert white.std() == pytest.approx(1.0, rel=0.03)
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.02
    counted = Noise(0.0, count=0.25).read(np.linspace(0.0, 3.0, 500), np.random.default_rng(1))
    np.testing.assert_allclose(counted % 0.25, 0.0, atol=1e-12)
    wild = Noise(0.01, outliers=0.02).read(np.zeros(20_000), np.random.default_rng(1))
    assert np.mean(np.abs(wild) > 0.06) == pytest.approx(0.02, abs=0.004)


def test_a_log_has_gaps_held_rows_and_a_coarse_clock() -> None:
    mess = Mess(jitter=0.4, stamp=0.1, drop=0.05, gaps=2, held=0.03, clock_s=0.001)
    rows = Rows.drawn(60.0, 200.0, mess, np.random.default_rng(4))
    steps = np.diff(rows.stamp_s)
    assert steps.min() > 0.0
    assert np.sum(steps > 20 * 0.005) >= 1
    np.testing.assert_allclose(rows.stamp_s, np.round(rows.stamp_s, 3), atol=1e-9)
    held = rows.shown != np.arange(len(rows.shown))
    assert np.mean(held) == pytest.approx(0.03, abs=0.006)
    assert np.all(rows.shown[held] < np.flatnonzero(held))
    tidy = Rows.drawn(60.0, 200.0, Mess(), np.random.default_rng(4))
    np.testing.assert_allclose(np.diff(tidy.stamp_s), 0.005)
