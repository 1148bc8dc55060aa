"""Before and after by the sensors: the interval holds the truth, a worse drawing is called so."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import plan_of
from deltactl.firmware_py.robot_file import load_robot
from deltactl.models.chain import Chain, Commands
from deltactl.models.robot import EffectEntry, FloatArray
from deltactl.recording.tables.flat import from_columns
from deltactl.repair.compared import Seen, distance, gain
from deltactl.repair.heal_answer import lines_of
from deltactl.repair.played import played
from deltactl.repair.worth import in_readings

JOB = CONFIG_FOLDER / "demo-heart.yaml"
NOMINAL = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")
FAULT = EffectEntry(effect="home_offset", component="motor2", parameters={"angle": 0.002})
BLIND = EffectEntry(effect="sensor_offset", component="range_y", parameters={"offset": 0.02})
BENT = EffectEntry(
    effect="sensor_table",
    component="range_x",
    parameters={"error": (0.0, 0.004, 0.0), "lowest": -0.1, "highest": 0.1, "follows": 1.0},
)
NOISE_M = 0.0015


@cache
def silent(correct: bool, blind: int) -> tuple[dict[str, FloatArray], FloatArray, FloatArray]:
    """A robot with the fault draws the heart: columns without noise, targets, and where it was."""
    robot = NOMINAL.model_copy(update={"effects": (FAULT,)}) if correct else NOMINAL
    motion = played(plan_of(JOB, robot))
    t_s = np.arange(0.03, motion.seconds, 0.02)
    commands = Commands.of_counts(t_s, motion.smooth(t_s), NOMINAL.drive)
    real = Chain(NOMINAL).simulate(commands, (FAULT, *(BLIND, BENT)[:blind]))
    counts = motion.at(t_s)
    columns = {"t": t_s}
    columns |= {f"steps_{motor + 1}": counts[:, motor] for motor in range(3)}
    columns |= {f"range_{axis}": real.ranges[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"status_{axis}": np.zeros(len(t_s)) for axis in "xyz"}
    target_m = np.stack(
        [np.interp(t_s, motion.target_s, c, np.nan, np.nan) for c in motion.target_m.T], axis=1
    )
    return columns, target_m, real.position


def drawn(correct: bool, blind: int, seed: int) -> tuple[Seen, FloatArray]:
    """What its sensors see of that, and how far off it truly is."""
    columns, target_m, position_m = silent(correct, blind)
    noise_m = NOISE_M * np.random.default_rng(seed).standard_normal(target_m.shape)
    ranges = {f"range_{axis}": columns[f"range_{axis}"] + noise_m[:, i]
              for i, axis in enumerate("xyz")}  # fmt: skip
    seen = Seen(from_columns(columns | ranges, "test"), np.repeat(target_m[:, None], 3, axis=1))
    return seen, np.nanmean(np.sum((position_m - target_m) ** 2, axis=1))


@pytest.mark.study
@pytest.mark.parametrize("blind", [False, True])
def test_the_gain_is_measured_though_a_sensor_reads_long(blind: bool) -> None:
    """0.24 mm are shown by sensors that scatter by 1.5 mm, in two drawings."""
    robot = NOMINAL.model_copy(update={"effects": (FAULT, BLIND) if blind else (FAULT,)})
    inside = 0
    for seed in range(6):
        (before, was), (after, now) = (drawn(c, blind, 2 * seed + c) for c in (False, True))
        better = gain([before], [after], robot)
        low, high = better.ci95_m2
        inside += low < was - now < high
        assert better.sign == 1
        assert gain([after], [before], robot).sign == -1
        low_m, high_m = distance([before], robot).ci95_m
        assert low_m < 1.3 * np.sqrt(was)
        assert high_m > 0.8 * np.sqrt(was)
    assert inside >= 4


def test_the_same_drawing_twice_is_neither_better_nor_worse() -> None:
    robot = NOMINAL.model_copy(update={"effects": (FAULT,)})
    one, two = (drawn(True, False, seed)[0] for seed in (1, 2))
    assert gain([one], [two], robot).sign == 0


@pytest.mark.study
def test_an_error_of_a_sensor_shows_what_expecting_it_is_worth() -> None:
    """A table over the position, and an offset: each by itself, in the readings of a drawing."""
    corrected = NOMINAL.model_copy(update={"effects": (FAULT, BLIND, BENT)})
    offset_only = NOMINAL.model_copy(update={"effects": (BLIND,)})
    _, target_m, _ = silent(True, 2)
    on_path = np.isfinite(target_m[:, 0])
    left_m = np.interp(target_m[on_path, 0], [-0.1, 0.0, 0.1], [0.0, 0.004, 0.0])
    expected_m = np.sqrt(np.mean(left_m**2))
    inside = 0
    for seed in range(6):
        seen = drawn(True, 2, seed)[0]
        offset, table = in_readings([seen], NOMINAL, corrected)
        assert [offset.effect, table.effect] == ["sensor_offset", "sensor_table"]
        assert offset.now_m == table.now_m > 0.02
        assert table.alone_m == pytest.approx(0.02, rel=0.03)
        assert offset.share > 0.8 > table.share
        inside += offset.ci95_m[0] < expected_m < offset.ci95_m[1]
        (rest,) = in_readings([seen], offset_only, corrected)
        assert rest.effect == "sensor_table"
        assert rest.now_m == offset.alone_m
        assert rest.alone_m < 0.3 * rest.now_m
    assert inside >= 4


def test_the_answer_says_what_a_sensors_table_is_worth() -> None:
    (rest,) = in_readings(
        [drawn(True, 2, 7)[0]],
        NOMINAL.model_copy(update={"effects": (BLIND,)}),
        NOMINAL.model_copy(update={"effects": (FAULT, BLIND, BENT)}),
    )
    answer = {"outcome": "rolled_back", "found": [], "by_hand": [], "done_by_hand": []}
    answer |= {"robot_s": 1.0, "took_s": 2.0, "readings": [rest.as_json()]}
    (shown,) = [line for line in lines_of(answer, "go on", "undo") if "sensor_table" in line]
    assert f"range_x: {rest.alone_m * 1e3:.2f} mm [" in shown
    assert f"{rest.share:.0%} less" in shown
