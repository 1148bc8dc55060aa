"""Shortened trainings of all three recipes, and what each must be able to do."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from deltactl.foundation.errors import NetworkError
from deltactl.models.linkage import Linkage
from deltactl.models.robot import DeltaRobot, FloatArray
from deltactl.models.training.calibrate import Plausible, calibrate
from deltactl.models.training.calibrated_physics import CalibratedSettings, train_calibrated
from deltactl.models.training.recipe import Settings, plain
from deltactl.models.training.samples import random_poses, split
from deltactl.models.training.train_shipped import SHIPPED
from deltactl.models.training.uzunovic import UzunovicSettings, train_uzunovic
from deltactl.models.training.zhao import (
    AS_KERAS,
    AS_PRINTED,
    ZhaoSettings,
    starting_weights,
    train_zhao,
)

Samples = tuple[FloatArray, FloatArray]

ZHAO = ZhaoSettings(layers=3, width=20, epochs=400, rate=3e-3)
UZUNOVIC = UzunovicSettings(iterations=40, rounds=((2, 5), (1, 5)))
OURS = CalibratedSettings(poses=250, effort=Settings(hidden=(6,), iterations=30, rounds=0))


def held_rmse_deg(trained, samples: Samples) -> float:
    _, held = split(len(samples[0]), trained.seed)
    return trained.rmse_deg(samples[0][held], samples[1][held])


@pytest.mark.study
def test_zhao_s_network_learns_and_tells_how_far_it_is(exact: Samples) -> None:
    told: list[tuple[int, int, str]] = []
    trained = train_zhao(*exact, ZHAO, 0, lambda *state: told.append(state))
    assert trained.samples == 300
    assert held_rmse_deg(trained, exact) < 1.0
    assert trained.course[-1][0] == ZHAO.epochs
    assert trained.course[-1][1] == pytest.approx(held_rmse_deg(trained, exact), rel=1e-3)
    assert trained.course[-1][1] < 0.3 * trained.course[0][1]
    assert told[-1][:2] == (400, 400)
    assert "held-out RMS" in told[-1][2]


def test_the_full_network_is_that_of_the_paper(exact: Samples) -> None:
    trained = train_zhao(*exact, ZhaoSettings(epochs=1))
    assert trained.parameters == 18_203
    assert trained.architecture == "3-50-50-50-50-50-50-50-50-3 sigmoid"
    assert trained.samples == 300


def test_as_printed_it_answers_the_mean(exact: Samples) -> None:
    position_m, angles_rad = exact
    spread_deg = np.rad2deg(angles_rad.std())
    printed = train_zhao(*exact, replace(AS_PRINTED, epochs=60))
    assert held_rmse_deg(printed, exact) > 0.8 * spread_deg
    answers_deg = np.rad2deg(printed.angles_rad_many(position_m))
    assert answers_deg.std(axis=0).max() < 0.1 * spread_deg


def test_a_wide_centred_start_passes_on_what_a_narrow_one_loses(exact: Samples) -> None:
    """After eight layers of sigmoids the samples must still differ."""
    inputs = (exact[0] - exact[0].mean(axis=0)) / exact[0].std(axis=0)
    left = {}
    for start in ("glorot", "wide"):
        sizes, at, values = AS_KERAS.sizes, 0, inputs
        weights = starting_weights(sizes, start, np.random.default_rng(0))
        for before, after in pairwise(sizes[:-1]):
            matrix = weights[at : at + before * after].reshape(after, before)
            bias = weights[at + before * after : at + (before + 1) * after]
            values = 1.0 / (1.0 + np.exp(-(values @ matrix.T + bias)))
            at += (before + 1) * after
        left[start] = values.std(axis=0).mean()
    assert left["glorot"] < 1e-3
    assert left["wide"] > 0.05


@pytest.mark.parametrize("train", [train_zhao, train_uzunovic])
def test_the_same_seed_repeats_the_same_network(train, exact: Samples) -> None:
    settings = ZHAO if train is train_zhao else UZUNOVIC
    settings = replace(settings, **({"epochs": 5} if train is train_zhao else {"iterations": 5}))
    first, again, other = (train(*exact, settings, seed) for seed in (1, 1, 2))
    answers = [trained.angles_rad_many(exact[0][:20]) for trained in (first, again, other)]
    np.testing.assert_array_equal(answers[0], answers[1])
    assert np.abs(answers[0] - answers[2]).max() > 1e-6


def test_uzunovic_s_network_learns(exact: Samples) -> None:
    trained = train_uzunovic(*exact, UZUNOVIC)
    assert trained.parameters == 178
    assert trained.architecture == "3-25-3 tanh"
    assert held_rmse_deg(trained, exact) < 0.5


def test_uzunovic_s_own_way_judges_by_all_samples(exact: Samples) -> None:
    trained = train_uzunovic(*exact, replace(UZUNOVIC, hold_out=False))
    assert trained.samples == 400
    assert trained.course[-1][1] == pytest.approx(trained.rmse_deg(*exact), rel=1e-3)


def test_sifting_goes_on_with_the_deepest_start(exact: Samples) -> None:
    position_m, angles_rad = exact
    better = 0
    for seed in range(3):
        costs = []
        for starts in (1, 4):
            sifting = replace(UZUNOVIC, rounds=((starts, 8),), iterations=0, hold_out=False)
            answers_rad = train_uzunovic(*exact, sifting, seed).angles_rad_many(position_m)
            costs.append(np.sum(((answers_rad - angles_rad) / angles_rad.std(axis=0)) ** 2))
        # The first of the four is the one start of before.
        assert costs[1] <= costs[0] * (1.0 + 1e-9)
        better += costs[1] < 0.9 * costs[0]
    assert better


def test_a_shorter_training_sifts_for_less() -> None:
    whole = UzunovicSettings()
    tenth = whole.lasting(15)
    assert (tenth.iterations, tenth.rounds) == (15, ((16, 6), (8, 15), (3, 30)))
    assert whole.lasting(1).rounds == ((16, 1), (8, 1), (3, 2))
    assert whole.lasting(600) == replace(whole, iterations=600)


def test_settings_are_plain_in_a_file() -> None:
    told = plain(UzunovicSettings())
    assert told["hold_out"] == "yes"
    assert told["rounds"] == "((16, 60), (8, 150), (3, 300))"
    assert (told["width"], told["enough"]) == (25, 1e-5)


@pytest.mark.parametrize("train", [train_zhao, train_uzunovic])
def test_a_constant_column_cannot_be_learned_from(train, exact: Samples) -> None:
    flat_m = exact[0].copy()
    flat_m[:, 1] = 0.1
    with pytest.raises(NetworkError, match="column 1 is constant"):
        train(flat_m, exact[1])


def test_a_training_that_runs_away_is_said(exact: Samples) -> None:
    with pytest.raises(NetworkError, match="ran away in epoch"):
        train_zhao(*exact, replace(ZHAO, rate=1e30, schedule="constant"))


def wrong_robot(robot: DeltaRobot) -> DeltaRobot:
    """The robot file's robot with homes and a few lengths off."""
    geometry = robot.geometry.model_copy(
        update={
            "home_offset_deg": (8.0, 11.0, 9.0),
            "forearm_m": (0.496, 0.502, 0.499),
            "upper_arm_m": (0.249, 0.25, 0.252),
        }
    )
    return robot.model_copy(update={"geometry": geometry})


def measured(robot: DeltaRobot, count: int, noise_m: float, seed: int = 4) -> Samples:
    """Noisy samples of a robot that is not the file's."""
    true_m, angles_rad = random_poses(
        Linkage.of(wrong_robot(robot).geometry), count, (0.0, 70.0), seed
    )
    return true_m + np.random.default_rng(9).normal(0.0, noise_m, true_m.shape), angles_rad


def test_a_calibration_finds_what_is_wrong(zhao_robot: DeltaRobot) -> None:
    found = calibrate(zhao_robot, *measured(zhao_robot, 300, 1e-3))
    assert found.noise_m == pytest.approx(1e-3, rel=0.15)
    true_m, angles_rad = measured(zhao_robot, 200, 0.0, seed=8)
    error_m = found.measured_m(angles_rad) - true_m
    # 39 numbers from 900 readings: a fifth of the noise is left, not its whole.
    assert np.sqrt(np.mean(error_m**2)) < 0.3e-3
    nominal_m = np.sqrt(
        np.mean((calibrate_nothing(zhao_robot).position_m(angles_rad) - true_m) ** 2)
    )
    assert nominal_m > 0.02


def calibrate_nothing(robot: DeltaRobot):
    """The robot file's own robot."""
    from deltactl.models.training.calibrate import _Layout

    return _Layout(robot, Plausible()).nominal()


def test_a_calibrated_robot_s_inverse_undoes_its_forward(zhao_robot: DeltaRobot) -> None:
    found = calibrate(zhao_robot, *measured(zhao_robot, 300, 1e-3))
    _, angles_rad = measured(zhao_robot, 100, 0.0, seed=8)
    back_rad = found.angles_rad_many(found.position_m(angles_rad))
    np.testing.assert_allclose(back_rad, angles_rad, atol=2e-6)


def test_wild_samples_do_not_spoil_a_calibration(zhao_robot: DeltaRobot) -> None:
    position_m, angles_rad = measured(zhao_robot, 300, 1e-3)
    position_m[::50] += 0.3
    found = calibrate(zhao_robot, position_m, angles_rad)
    true_m, other_rad = measured(zhao_robot, 200, 0.0, seed=8)
    assert np.sqrt(np.mean((found.measured_m(other_rad) - true_m) ** 2)) < 0.5e-3


def test_data_of_quite_another_robot_are_refused(exact: Samples) -> None:
    zhao = SHIPPED[0]
    assert zhao.robot == "zhao-2023"
    from deltactl.models.training.train_shipped import CONFIG_FOLDER, load_delta

    printed = load_delta(CONFIG_FOLDER / "zhao-2023-as-printed.yaml")
    with pytest.raises(NetworkError, match="is this the robot the data are of"):
        calibrate(printed, *exact)


def test_our_network_sees_through_sensors_that_are_off(zhao_robot: DeltaRobot) -> None:
    position_m, angles_rad = measured(zhao_robot, 300, 2e-3)
    samples = position_m + np.array([0.015, -0.02, 0.02]), angles_rad
    truth = measured(zhao_robot, 200, 0.0, seed=8)
    ours = train_calibrated(zhao_robot, *samples, OURS)
    uzunovic = train_uzunovic(*samples, UZUNOVIC)
    assert ours.parameters < 18_203
    assert ours.rmse_deg(*truth) < 0.5 * uzunovic.rmse_deg(*truth)
    assert "held-out positions to" in ours.remarks[0][1]
