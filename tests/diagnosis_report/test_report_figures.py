"""The figures behind the charts: means, regimes and maps of the mismatch."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from deltactl.charts.cells import CELLS, grid_of
from deltactl.charts.means import binned, explained_by, smoothed
from deltactl.diagnosis.answer.records import Channel, Picture
from deltactl.diagnosis.report.mismatch import (
    by_regime,
    mismatch_sections,
    mismatches,
    place_maps,
    ranked,
)
from deltactl.models.robot import ServoAxis


def channel(observed: Any, before: Any, after: Any) -> Channel:
    return Channel(
        name="range_x", unit="m", observed=observed, before=before, after=after, noise=0.001
    )


def picture_of_reversals(n: int = 4000) -> Picture:
    """A motor to and fro every 10 s, 0.5 s late by 2 mm after each reversal; noise 0.1 mm."""
    t_s = np.arange(n) * 0.02
    speed = np.where((t_s // 10) % 2 == 0, 1.0, -1.0)
    miss = np.where((t_s % 10 < 0.5) & (t_s >= 10), 0.002, 0.0)
    noise = 1e-4 * np.random.default_rng(3).standard_normal(n)
    return Picture(
        t_s=t_s,
        channels=[channel(miss + noise, np.zeros(n), miss)],
        covariates={"speed_1": speed, "theta_1": np.cumsum(speed)},
    )


def test_the_mismatch_after_reversals_is_told_from_the_rest() -> None:
    picture = picture_of_reversals()
    found = {one.name: one for one in by_regime(picture, mismatches(picture))}
    after = found["within 1 s after motor 1 reversed"]
    # Half of that second is 2 mm off: sqrt(0.5) * 2 mm.
    assert after.before == pytest.approx(np.sqrt(0.5) * 2.0, rel=0.02)
    assert after.after == pytest.approx(0.1, rel=0.1)
    assert found["motor 1 moves forward"].before < 0.5
    assert "motor 1 rests" not in found


def test_what_a_delta_was_doing_names_its_motors_and_its_platform_each_once() -> None:
    picture = picture_of_reversals()
    (way,) = (v for n, v in picture.covariates.items() if n == "speed_1")
    moving = {f"speed_range_{axis}": way * k for k, axis in enumerate("xyz", 1)}
    platform = picture.model_copy(update={"covariates": picture.covariates | moving})
    found = by_regime(platform, mismatches(picture))
    names = [one.name for one in found]
    assert len(names) == len(set(names))
    assert not [name for name in names if "the axis" in name]
    assert {"motor 1 moves forward", "the platform along z moves backward"} <= set(names)
    assert "within 1 s after the platform along y reversed" in names
    axis = picture.model_copy(update={"covariates": {"velocity": way}})
    assert "the axis moves forward" in [one.name for one in by_regime(axis, mismatches(picture))]


def test_what_the_robot_was_doing_is_weighted_as_the_figures_of_the_fit() -> None:
    n = 400
    miss = np.where(np.arange(n) % 2 == 0, 0.001, 0.005)
    share = np.where(np.arange(n) % 2 == 0, 1.0, 0.25)
    one = channel(miss, np.zeros(n), 0.5 * miss).model_copy(update={"counted": share})
    picture = Picture(t_s=0.02 * np.arange(n), channels=[one])
    (whole,) = by_regime(picture, mismatches(picture))
    assert whole.before == pytest.approx(np.sqrt((1.0 + 0.25 * 25.0) / 1.25))
    assert whole.after == pytest.approx(0.5 * whole.before)


def test_an_axis_stands_where_its_command_does_and_not_where_it_is_slow() -> None:
    picture = picture_of_reversals()
    (way,) = (v for n, v in picture.covariates.items() if n == "speed_1")
    rests = np.arange(len(way)) >= len(way) // 2
    picture = picture.model_copy(update={"covariates": {"velocity": way}, "rests": rests})
    found = {one.name: one for one in by_regime(picture, mismatches(picture))}
    observed, before = picture.channels[0].observed, picture.channels[0].before
    miss_mm = 1e3 * (observed - before)[rests]
    stands = found["the axis rests, or settles, at its command"]
    assert stands.before == pytest.approx(float(np.sqrt(np.mean(miss_mm**2))), rel=1e-6)


def test_far_outliers_are_left_out_and_counted() -> None:
    picture = picture_of_reversals()
    picture.channels[0].observed[[100, 200]] = 5.0
    (one,) = mismatches(picture)
    assert one.far_out >= 2
    assert np.nanmax(one.before) < 100.0


@pytest.mark.parametrize(("far_m", "left_out"), [(0.002, 0), (0.008, 2)])
def test_the_axis_reaches_to_readings_that_are_few_but_not_extreme(
    far_m: float, left_out: int
) -> None:
    """Beside noise of 0.1 mm, a jump of 2 mm was not drawn."""
    n = 4000
    noise = 1e-4 * np.random.default_rng(3).standard_normal(n)
    noise[[100, 200]] = far_m, -far_m
    one = channel(noise, np.zeros(n), np.zeros(n))
    picture = Picture(t_s=0.02 * np.arange(n), channels=[one])
    (drawn,) = mismatches(picture)
    assert drawn.far_out == left_out
    widest_mm = float(np.nanmax(np.abs(drawn.before)))
    assert widest_mm == pytest.approx(1e3 * far_m) if not left_out else widest_mm < 0.5


def test_outliers_of_the_fit_are_drawn_and_enter_no_mean() -> None:
    n = 4000
    noise = 1e-4 * np.random.default_rng(3).standard_normal(n)
    noise[[100, 200]] = 0.002
    one = channel(noise, np.zeros(n), np.zeros(n)).model_copy(update={"counted": noise < 0.001})
    (drawn,) = mismatches(Picture(t_s=0.02 * np.arange(n), channels=[one]))
    assert np.nanmax(drawn.readings) == pytest.approx(2.0)
    assert np.nanmax(drawn.before) < 0.5


def test_smoothing_keeps_gaps_and_means() -> None:
    t_s = np.concatenate([np.arange(0.0, 20.0, 0.02), np.arange(40.0, 60.0, 0.02)])
    n = len(t_s)
    picture = Picture(t_s=t_s, channels=[channel(np.full(n, 0.003), np.zeros(n), np.zeros(n))])
    curve = smoothed(t_s, mismatches(picture)[0])
    inside = (curve.x > 21.0) & (curve.x < 39.0)
    assert np.isnan(curve.before[inside]).all()
    assert curve.before[np.isfinite(curve.before)] == pytest.approx(3.0)


def test_a_channel_with_few_readings_is_a_curve_all_the_same() -> None:
    """Of an effort only every tenth sample counts, or so: a point between two gaps is not drawn."""
    t_s = 0.01 * np.arange(4000)
    seldom = np.where(np.arange(4000) % 16 == 0, 0.003, np.nan)
    picture = Picture(t_s=t_s, channels=[channel(seldom, np.zeros(4000), np.zeros(4000))])
    curve = smoothed(t_s, mismatches(picture)[0])
    assert len(curve.x) > 100
    assert np.isfinite(curve.before).mean() > 0.95


def test_times_of_a_clock_begin_near_zero_on_the_page(make: Any, parts: Any) -> None:
    early, robot = make("explained"), parts["delta"]()
    moved = early.picture.model_copy(update={"t_s": early.picture.t_s + 1.6e9})
    late = early.model_copy(update={"picture": moved})
    assert "time [s]" in "".join(mismatch_sections(early, robot))
    page = "".join(mismatch_sections(late, robot))
    assert "time - 1600000000 [s]" in page
    assert "time [s]" not in page


def test_smoothing_takes_noise_off_and_leaves_clear_curves_alone() -> None:
    n = 6000
    t_s = np.arange(n) * 0.02
    wave = 0.002 * np.sign(np.sin(2 * np.pi * t_s / 7.0))
    noise = np.random.default_rng(2).standard_normal(n)

    def drawn(sigma: float) -> Any:
        one = Channel(
            name="range_x", unit="m", observed=wave + sigma * noise, before=0 * wave, after=wave,
            noise=sigma,
        )  # fmt: skip
        return smoothed(t_s, mismatches(Picture(t_s=t_s, channels=[one]))[0])

    assert float(np.std(drawn(0.004).after)) < 0.3 * 4.0
    # A step falls into one cell, so that it takes two strides at most; smoothed it takes six.
    strides = np.abs(np.diff(drawn(1e-6).before))
    jumps = int(2 * 120.0 / 7.0)
    assert jumps <= np.count_nonzero(strides > 0.1) <= 2 * jumps


def test_a_dependence_stands_out_of_the_noise_band_and_chance_does_not() -> None:
    random = np.random.default_rng(5)
    covariate = random.uniform(-1.0, 1.0, 6000)
    other = random.uniform(-1.0, 1.0, 6000)
    noise = 1e-3 * random.standard_normal(6000)
    miss = 1e-3 * np.sign(covariate)
    picture = Picture(t_s=np.arange(6000.0), channels=[channel(miss + noise, np.zeros(6000), miss)])
    (one,) = mismatches(picture)
    curve = binned(covariate, one)
    assert curve.before[0] == pytest.approx(-1.0, abs=4 * curve.spread[0])
    assert np.mean(np.abs(curve.after) < 2 * curve.spread) > 0.8
    assert explained_by(curve) > 20 * explained_by(binned(other, one))
    assert explained_by(binned(other, one)) < 3.0


def test_a_driver_that_stands_still_draws_nothing() -> None:
    picture = picture_of_reversals()
    (one,) = mismatches(picture)
    assert len(binned(np.zeros(4000), one).x) == 0
    assert len(binned(np.full(4000, np.nan), one).x) == 0
    mostly = np.zeros(4000)
    mostly[:100] = np.linspace(0, 1, 100)
    assert len(binned(mostly, one).x) == 0
    mostly[:1000] = np.linspace(0, 1, 1000)
    assert 2 <= len(binned(mostly, one).x) <= 24
    assert len(binned(20.0 + 1e-9 * np.arange(4000), one).x) == 0


def test_noise_alone_stays_within_the_band_at_all_points_together() -> None:
    random = np.random.default_rng(8)
    covariate = np.tile(np.arange(24.0), 20)
    held = []
    for _ in range(200):
        noise = 1e-3 * random.standard_normal(len(covariate))
        t_s = np.arange(float(len(noise)))
        (one,) = mismatches(Picture(t_s=t_s, channels=[channel(noise, 0 * noise, 0 * noise)]))
        curve = binned(covariate, one)
        held.append(bool(np.all(np.abs(curve.before) < curve.band)))
    assert 0.9 < np.mean(held) < 0.99


def test_the_figures_of_regimes_count_readings_that_lie_too_far_out_to_be_drawn() -> None:
    t_s = np.arange(2000.0)
    miss = 1e-3 * np.sin(t_s)
    miss[::400] = 0.1
    picture = Picture(t_s=t_s, channels=[channel(miss, 0 * miss, 0 * miss)])
    channels = mismatches(picture)
    assert channels[0].far_out == 5
    (all_the_time,) = by_regime(picture, channels)
    assert all_the_time.before == pytest.approx(1e3 * np.sqrt(np.mean(miss**2)))


def test_the_figures_of_regimes_leave_out_what_the_fit_took_for_outliers() -> None:
    t_s = np.arange(2000.0)
    miss = 1e-3 * np.sin(t_s)
    miss[::400] = 0.1
    counted = np.abs(miss) < 0.05
    one = channel(miss, 0 * miss, 0 * miss).model_copy(update={"counted": counted})
    picture = Picture(t_s=t_s, channels=[one])
    (all_the_time,) = by_regime(picture, mismatches(picture))
    assert all_the_time.before == pytest.approx(1e3 * np.sqrt(np.mean(miss[counted] ** 2)))


def workspace() -> tuple[Any, Any, Any]:
    """Positions all over a square, a mismatch of 3 mm in its right half; noise 0.5 mm."""
    random = np.random.default_rng(11)
    x, y = random.uniform(-0.1, 0.1, (2, 30_000))
    miss = np.where(x > 0.0, 0.003, 0.0)
    observed = miss + 5e-4 * random.standard_normal(len(x))
    picture = Picture(t_s=np.arange(len(x)) * 0.02, channels=[channel(observed, 0 * x, miss)])
    return x, y, mismatches(picture)


def test_a_map_shows_where_the_mismatch_is() -> None:
    x, y, channels = workspace()
    grid = grid_of(x, y, channels)
    assert grid is not None
    assert grid.before.shape == (CELLS, CELLS)
    right, left = grid.before[:, CELLS // 2 + 1 :], grid.before[:, : CELLS // 2 - 1]
    assert np.nanmean(right) == pytest.approx(3.0, abs=0.05)
    assert np.nanmean(left) < 0.2
    assert np.nanmean(grid.after) < 0.2


def test_a_map_of_nothing_but_noise_is_not_red() -> None:
    x, y, channels = workspace()
    grid = grid_of(x, y, channels)
    assert grid is not None
    left = np.s_[:, : CELLS // 2 - 1]
    assert np.mean(grid.before[left] > grid.noise[left]) < 0.02
    assert np.all(grid.before[:, CELLS // 2 + 1 :] > grid.noise[:, CELLS // 2 + 1 :])
    assert "no more than noise" in place_maps({"range_x": x, "range_y": y}, channels)


def test_an_error_that_is_large_everywhere_still_shows_where_it_is_larger() -> None:
    """From zero on, all cells between 4 and 6 mm had the two darkest colours."""
    rng = np.random.default_rng(5)
    x, y = rng.uniform(-0.1, 0.1, (2, 20_000))
    miss = 0.005 + 0.01 * x
    t_s = np.arange(len(x)) * 0.02
    channels = mismatches(Picture(t_s=t_s, channels=[channel(miss, 0 * x, miss)]))
    drawn = place_maps({"range_x": x, "range_y": y}, channels).partition("<svg")[2]
    cells = {
        level: path.count("M")
        for level, path in re.findall(r'<path class="level(\d)" d="([^"]*)"', drawn)
    }
    assert min(cells.values()) > 0.05 * sum(cells.values())
    assert len(cells) > 3
    assert "4.0 mm and less" in drawn


def test_a_map_draws_all_of_a_path_that_was_passed_once() -> None:
    """Two readings in each cell on the way round a square, and a corner reached in one leap."""
    way = np.linspace(-0.03, 0.03, 2 * CELLS)
    end = np.full(len(way), 0.03)
    x = np.concatenate([way, end, -way, -end, [0.0]])
    y = np.concatenate([-end, way, end, -way, [0.0]])
    miss = 0.02 * x
    picture = Picture(t_s=np.arange(len(x)) * 0.02, channels=[channel(miss, 0 * x, miss)])
    grid = grid_of(x, y, mismatches(picture))
    assert grid is not None
    for side in (grid.before[0], grid.before[-1], grid.before[:, 0], grid.before[:, -1]):
        assert np.isfinite(side).all()
    assert grid.before[CELLS // 2, -1] == pytest.approx(0.6, abs=0.05)
    assert np.isnan(grid.before[4:-4, 4:-4]).all()
    assert grid.passed.sum() == 1


def test_maps_need_positions_that_change() -> None:
    x, y, channels = workspace()
    drawn = place_maps({"range_x": x, "range_y": y}, channels)
    assert drawn.count("<svg") == 2
    assert (
        place_maps({"range_x [m]": x, "range_y [m]": y, "range_z [m]": y}, channels).count("<svg")
        == 4
    )
    assert place_maps({"theta_1": x}, channels) == ""
    assert place_maps({"range_x": x, "range_y": np.zeros_like(x)}, channels) == ""
    assert place_maps({"range_x": np.full_like(x, np.nan), "range_y": y}, channels) == ""


def test_two_means_of_a_direction_are_no_chart() -> None:
    t_s = 0.02 * np.arange(4000)
    way = np.round(1.2 * np.sin(t_s))  # there, back, and standing
    seen = 0.01 * way + 0.001 * np.random.default_rng(0).standard_normal(len(t_s))
    channel = Channel(
        name="position", unit="rad", observed=seen, before=0.0 * seen, after=0.0 * seen, noise=1e-3
    )
    covariates = {"direction": way, "position": np.sin(t_s)}
    picture = Picture(t_s=t_s, channels=[channel], covariates=covariates)
    axis = ServoAxis(kind="servo_axis", name="a", motion="rotary")
    drawn = ranked(covariates, mismatches(picture), axis, banded=False)
    assert [chart.title for chart in drawn] == ["Against the commanded position"]
    assert [one.name for one in drawn[0].series] == ["error"]
    (banded,) = ranked(covariates, mismatches(picture), axis, banded=True)
    assert [one.name for one in banded.series] == ["noise alone", "error"]
