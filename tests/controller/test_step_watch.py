"""Lost steps seen by the sensors while the robot runs, on a virtual clock."""

from __future__ import annotations

from collections import deque

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.drivers.fakes.vl53l1x_scene import RangeNoise
from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.drivers.steps.contract import Ticks
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.sensing.determined import range_slopes_m
from deltactl.firmware_py.controller.sensing.step_watch import (
    LOOK_S,
    NOW_S,
    Moved,
    StepLoss,
    StepWatch,
)
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.clock import sleep_s
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import AXES

ROBOT = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")
PERIOD_NS = 20_000_000
SWING_STEPS, LAP = 300, 400
"""The arms swing by so many steps in so many periods of 20 ms."""


def swing(
    seconds: float,
    lost_steps: int = 0,
    motor: int = 0,
    at_s: float = 6.0,
    seed: int = 0,
    held: bool = False,
    late_s: float = 0.0,
    laps: int = 1,
    middle: tuple[int, int, int] = (1800, 1800, 1800),
    swing_steps: int = SWING_STEPS,
):
    """What is found, and after how long: arms that swing, sensors with their usual noise."""
    watch = StepWatch(ROBOT)
    linkage, per_step = Linkage.of(ROBOT.geometry), ROBOT.drive.rad_per_step
    noise = [RangeNoise(seed=3 * seed + axis).source() for axis in range(3)]
    counts = np.array(middle)
    past = deque([counts], maxlen=1 + round(late_s * 1e9 / PERIOD_NS))
    watch.reset(tuple(counts.tolist()), 0)
    for tick in range(1, round(seconds * 1e9 / PERIOD_NS)):
        now_ns = tick * PERIOD_NS
        phase = 2.0 * np.pi * (laps * tick / LAP + np.arange(3) / 3.0)
        swung = swing_steps * np.sin(phase) * min(1.0, tick / LAP)
        wanted = np.rint(np.array(middle) + swung).astype(int)
        moves = wanted - counts
        made = int(np.abs(moves).max())
        steps = np.where(np.arange(made)[:, None] < np.abs(moves), np.sign(moves), 0)
        due_ns = now_ns - PERIOD_NS // 2 + 10_000 * np.arange(made)
        watch.sent(Ticks(due_ns.astype(np.int64), steps.astype(np.int8)))
        counts = wanted
        past.append(counts)
        true = past[0] - lost_steps * (np.arange(3) == motor) * (now_ns >= at_s * 1e9)
        if now_ns < at_s * 1e9:
            stuck = int(counts[motor])
        elif held:
            true[motor] = stuck
        position_m = forward(linkage, true * per_step).position_m
        ranges_m = ROBOT.sensors.offsets_m + ROBOT.sensors.axes @ position_m
        for axis in range(3):
            seen_m = round(float(ranges_m[axis]) + noise[axis].next_m(), 3)
            watch.reading(Reading(AXES[axis], now_ns, seen_m, 0, 9, 5.0, 1.0, 0.001, 0, Gate.GOOD))
        loss = watch.look(now_ns)
        if loss is not None:
            return loss, now_ns * 1e-9 - at_s
    return None, 0.0


@pytest.mark.study
def test_no_false_alarm_in_a_minute() -> None:
    assert swing(60.0) == (None, 0.0)


@pytest.mark.study
@settings(max_examples=6, deadline=None)
@given(
    st.integers(120, 500),
    st.sampled_from([-1, 1]),
    st.integers(0, 2),
    st.integers(0, 50),
)
def test_a_jump_is_seen_within_a_second(size: int, sign: int, motor: int, seed: int) -> None:
    loss, after_s = swing(9.0, sign * size, motor, at_s=4.0 + 0.05 * seed, seed=seed)
    assert loss is not None
    assert loss.motor == motor + 1
    assert 0.0 < after_s < 1.0
    assert loss.steps == pytest.approx(sign * size, abs=60)
    assert loss.late_s == 0.0


def test_a_single_look_makes_no_loss_however_often_somebody_asks() -> None:
    """Half of the readings of `NOW_S` must be new, and two looks `LOOK_S` apart agree on it."""
    watch, at_ns = StepWatch(ROBOT), 2_000_000_000
    home_m = forward(Linkage.of(ROBOT.geometry), np.full(3, 0.5)).position_m
    watch.reset((round(0.5 / ROBOT.drive.rad_per_step),) * 3, 0)
    for now_ns in range(0, at_ns + 1_000_000_000, 5_000_000):
        if now_ns % PERIOD_NS == 0:
            down_m = np.array([0.0, 0.0, -0.02 * (now_ns >= at_ns)])
            ranges_m = ROBOT.sensors.offsets_m + ROBOT.sensors.axes @ (home_m + down_m)
            for axis, seen_m in zip(AXES, ranges_m.tolist(), strict=True):
                watch.reading(Reading(axis, now_ns, seen_m, 0, 9, 5.0, 1.0, 0.001, 0, Gate.GOOD))
        loss = watch.look(now_ns)
        if loss is not None:
            break
    assert loss is not None
    assert loss.all_three
    assert now_ns - at_ns >= (NOW_S / 2.0 + LOOK_S - 0.02) * 1e9


def test_small_losses_are_below_its_limit() -> None:
    """Less than play and sensor errors make: left to 'deltactl job verify' and the diagnosis."""
    assert swing(12.0, 40) == (None, 0.0)


@pytest.mark.study
def test_less_is_seen_once_it_is_known_what_is_usual() -> None:
    """60 steps, 6 mm at the elbow, are too few in the first minutes and enough later."""
    assert swing(8.0, 60, 1, at_s=6.0) == (None, 0.0)
    loss, after_s = swing(103.0, 60, 1, at_s=101.0)
    assert loss is not None
    assert loss.motor == 2
    assert 0.0 < after_s < 1.0


def test_a_motor_that_stands_still_is_seen_within_a_second() -> None:
    """At 23 mm a second at the elbow; slower ones later, see benchmarks/endurance/step_watch.py."""
    loss, after_s = swing(10.2, 0, 1, at_s=8.0, held=True, seed=3)
    assert loss is not None
    assert loss.motor == 2
    assert 0.0 < after_s < 1.0


def test_late_readings_are_named_as_what_it_may_be() -> None:
    late_s = 0.2
    loss, _ = swing(12.0, at_s=12.0, late_s=late_s, laps=6)
    assert loss is not None
    assert loss.late_s == pytest.approx(late_s, abs=0.03)
    assert f"{loss.late_s:.2f} s late" in loss.says()


def test_it_says_which_motor_and_how_far() -> None:
    assert StepLoss(2, 120, -0.0118).says() == (
        "lost steps: the sensors see motor2 about 120 steps (12 mm at the elbow) behind its counts"
    )
    assert "ahead of its counts" in StepLoss(2, -120, 0.0118).says()


@pytest.mark.study
def test_noise_is_no_loss_where_the_arms_lie_level() -> None:
    """There the sensors hardly see an arm turn: a healthy survey ended with "67 steps lost"."""
    assert swing(40.0, middle=(-133, 400, 800), swing_steps=20)[0] is None


@pytest.mark.study
@pytest.mark.parametrize("on_step_loss", ["stop", "warn"])
def test_the_job_says_what_happens(homed: Controller, write_job, finish, on_step_loss) -> None:
    job = write_job("long", radius_m=0.06, t_pwm_s=0.004)
    job.write_text(job.read_text() + f"on_step_loss: {on_step_loss}\n")
    number = homed.submit(job)
    sleep_s(homed.clock, 6.0)
    assert homed.status().state == "running"
    assert homed.machine.bench is not None
    homed.machine.bench.slip(3, 200)
    sleep_s(homed.clock, 1.0)
    if on_step_loss == "stop":
        status = homed.status()
        assert status.state == "fault"
        assert status.why.startswith("lost steps: the sensors see motor3 about")
        result = homed.result(number)
        assert (result.outcome, result.why) == ("fault", status.why)
    else:
        assert homed.status().state == "running"
        result = finish(homed, number)
        assert result.outcome == "done"
        assert "motor3" in result.warning or "drive 3" in result.warning


def test_what_is_usual_is_learnt_and_slowly_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    """6 mm at an elbow: not enough at first, a loss after a quiet minute, usual where it recurs."""
    watch, elbow_m = StepWatch(ROBOT), float(np.max(ROBOT.geometry.upper_arm_m))
    moved_m = [0.0]
    slopes_m = range_slopes_m(ROBOT, np.full(3, 0.5))

    def moved(_: int) -> Moved:
        angles_rad = np.array([0.0, moved_m[0] / elbow_m, 0.0])
        return Moved(angles_rad, np.zeros(3), slopes_m @ angles_rad, np.zeros(3), slopes_m)

    monkeypatch.setattr(watch, "_moved", moved)
    looks = iter(range(10_000))

    def found(of_m: float, times: int = 1) -> list[bool]:
        moved_m[0] = of_m
        return [watch._compare(round(LOOK_S * 1e9) * next(looks)) is not None for _ in range(times)]

    assert found(0.006) == [False]
    assert not any(found(0.0005, times=1500))
    assert found(0.006) == [True]
    assert not any(found(0.004, times=40))
    assert found(0.006) == [False]
