"""Homing by switches that fail, arms that begin anywhere, and drives that do not follow."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from random import Random

import numpy as np
import pytest

from deltactl.drivers.fakes.mock_pins import exchange
from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.switch_search import MARGIN_RAD
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import NotReady
from tests.rigs.switch_homing import (
    SIGHTS,
    TROUBLES,
    Highest,
    arms_deg,
    begin_at,
    draw,
    home_and_judge,
    home_with,
    switch_of,
    switch_robot,
)

MARGIN_DEG = float(np.degrees(MARGIN_RAD))
TWO_AT_ONCE = (1, 3)
"""Draws of two troubles; benchmarks/endurance/home_switches.py makes thousands."""


@contextmanager
def switched_on(robot: Path) -> Iterator[Controller]:
    made = build_controller(robot, simulated=True, realtime=False, recordings=robot.parent)
    with closing(made):
        made.power_on()
        yield made


@pytest.mark.parametrize("name", TROUBLES)
def test_home_is_right_or_refused_with_the_culprit_named(name: str, tmp_path: Path) -> None:
    chance = Random(name)
    drawn, outcome = home_with([name], chance.choice(SIGHTS), chance, tmp_path)
    assert outcome.problems == [], drawn


@pytest.mark.study
@pytest.mark.parametrize("number", TWO_AT_ONCE)
def test_two_troubles_are_no_worse(number: int, tmp_path: Path) -> None:
    drawn, outcome = draw(number, tmp_path)
    assert " and " in drawn
    assert outcome.problems == [], drawn


@pytest.mark.parametrize("reading", [1, 110])
def test_one_false_reading_moves_nothing(reading: int, tmp_path: Path) -> None:
    with switched_on(switch_robot(tmp_path, 10.0, sensors=False)) as one:
        switch_of(one, 1).faults.false_at = frozenset({reading})
        outcome = home_and_judge(one)
    assert outcome.refused == ""
    assert outcome.problems == []


def test_false_readings_by_chance_are_outvoted(tmp_path: Path) -> None:
    with switched_on(switch_robot(tmp_path, 10.0, sensors=False)) as one:
        for motor in range(3):
            switch_of(one, motor).faults.false_rate = 0.05
            switch_of(one, motor).faults.seed = motor
        outcome = home_and_judge(one)
    assert outcome.refused == ""
    assert outcome.problems == []


@pytest.mark.parametrize(("part", "refused"), [(0.6, False), (1.5, True)])
@pytest.mark.parametrize("earlier", [False, True])
def test_two_approaches_must_agree_to_the_tolerance_of_the_file(
    part: float, refused: bool, earlier: bool, tmp_path: Path
) -> None:
    tolerance_deg = 0.4
    robot = switch_robot(tmp_path, sensors=False, switch_tolerance_deg=tolerance_deg)
    with switched_on(robot) as one:
        late_rad = float(np.radians(part * tolerance_deg))
        course = [0.0, late_rad, 0.0] if earlier else [0.0, 0.0, late_rad]
        switch_of(one, 2).faults.late_rad = course
        if not refused:
            one.home()
            assert one.status().state == "ready"
            return
        with pytest.raises(NotReady, match=r"arm 3 met its switch in two places"):
            one.home()
        assert one.status().state == "unhomed"


@pytest.mark.parametrize(("steps", "refused"), [(3, False), (12, True)])
def test_steps_lost_between_the_approaches_are_seen(
    steps: int, refused: bool, tmp_path: Path
) -> None:
    """With 0.1 degrees allowed, and 0.0225 a step."""
    with switched_on(switch_robot(tmp_path, sensors=False)) as one:
        bench, switch = one.machine.bench, switch_of(one, 0)
        assert bench is not None
        above_rad, closings = switch.above_rad, [False]

        def slips_after_the_slow_approach() -> float:
            if switch._closings == 2 and not closings[0]:
                closings[0] = True
                bench.slip(1, steps)
            return above_rad()

        switch.above_rad = slips_after_the_slow_approach
        if refused:
            with pytest.raises(NotReady, match=r"arm 1 .*loses steps"):
                one.home()
        else:
            assert home_and_judge(one).problems == []
        assert closings[0]


@pytest.mark.parametrize(
    ("sensors", "begin_deg"),
    [(True, 38.0), (False, None), (False, 12.0)],
)
def test_an_arm_whose_switch_never_closes_stays_within_the_limits(
    sensors: bool, begin_deg: float | None, tmp_path: Path
) -> None:
    with switched_on(switch_robot(tmp_path, 10.0, sensors)) as one:
        if begin_deg is not None:
            begin_at(one, 1, begin_deg)
        switch_of(one, 1).faults.stuck = False
        lowest_deg = -10.0 if sensors else one.robot.limits.arm_deg[0] - MARGIN_DEG
        outcome = home_and_judge(one, r"arm 2\b.*stuck open", lowest_deg)
    assert outcome.refused
    assert outcome.problems == []


@pytest.mark.parametrize("home_deg", [0.0, 30.0])
def test_an_arm_whose_switch_never_opens_sinks_no_further_than_the_limits(
    home_deg: float, tmp_path: Path
) -> None:
    """At 0 degrees the slopes of the ranges are singular: they say nothing of two directions."""
    with switched_on(switch_robot(tmp_path, home_deg)) as one:
        switch_of(one, 0).faults.stuck = True
        outcome = home_and_judge(one, r"arm 1\b.*stuck closed")
    assert outcome.refused
    assert outcome.problems == []


def test_an_unseen_arm_rises_no_further_however_often_it_is_homed(tmp_path: Path) -> None:
    with switched_on(switch_robot(tmp_path, 10.0, sensors=False)) as one:
        switch_of(one, 0).faults.stuck = False
        highest = Highest(one)
        for _ in range(3):
            with pytest.raises(NotReady, match=r"arm 1\b.*deltactl power off"):
                one.home()
        assert highest.angle_deg >= one.robot.limits.arm_deg[0] - MARGIN_DEG
        one.power_off()
        switch_of(one, 0).faults.clear()
        one.power_on()
        one.home()
        assert one.status().state == "ready"


def test_the_file_says_how_far_an_unseen_arm_may_hang(tmp_path: Path) -> None:
    for search_deg, found in ((None, False), (60.0, True)):
        robot = switch_robot(tmp_path, 10.0, sensors=False, search_deg=search_deg)
        with switched_on(robot) as one:
            begin_at(one, 2, 68.0)
            if found:
                one.home()
                np.testing.assert_allclose(arms_deg(one), 10.0, atol=0.15)
            else:
                with pytest.raises(NotReady, match=r"arm 3\b.*homing.search_deg"):
                    one.home()


@pytest.mark.study
@pytest.mark.parametrize("begin_deg", [25.0, 80.0])
def test_an_arm_that_the_sensors_see_is_found_wherever_it_is(
    begin_deg: float, tmp_path: Path
) -> None:
    with switched_on(switch_robot(tmp_path, 30.0)) as one:
        begin_at(one, 0, begin_deg)
        one.home()
        np.testing.assert_allclose(arms_deg(one), 30.0, atol=0.15)


@pytest.mark.parametrize("pair", [(0, 1), (0, 2)])
def test_exchanged_wires_stop_the_motion_at_the_switch(
    pair: tuple[int, int], tmp_path: Path
) -> None:
    with switched_on(switch_robot(tmp_path, 10.0, sensors=False)) as one:
        exchange(switch_of(one, pair[0]), switch_of(one, pair[1]))
        highest = Highest(one)
        named = rf"switch of arm {pair[1] + 1} became closed while only arm {pair[0] + 1} moved"
        with pytest.raises(NotReady, match=named):
            one.home()
        assert highest.angle_deg > 9.5


def test_a_motor_that_does_not_follow_is_seen_by_the_sensors_on_the_way(tmp_path: Path) -> None:
    with switched_on(switch_robot(tmp_path, 10.0)) as one:
        assert one.machine.bench is not None
        begin_at(one, 1, 60.0)
        one.machine.bench.stall(2)
        counts_before = one.status().counts[1]
        with pytest.raises(NotReady, match=r"arm 2 is \d+ degrees from where its steps"):
            one.home()
        moved_deg = abs(one.status().counts[1] - counts_before) * 0.0225
        assert moved_deg < 15.0


def test_a_switch_that_opens_while_the_sensors_are_heard_is_seen(tmp_path: Path) -> None:
    """The arm sinks after its last approach, before home is set."""
    with switched_on(switch_robot(tmp_path, 10.0, sensors=False)) as one:
        bench, switch = one.machine.bench, switch_of(one, 1)
        assert bench is not None
        above_rad, met = switch.above_rad, [0]

        def sinks() -> float:
            if switch._closings == 2 and switch._closed and not met[0]:
                met[0] = one.clock.now_ns()
            if met[0] and one.clock.now_ns() - met[0] > 300_000_000 and met[0] > 1:
                met[0] = 1
                bench.slip(2, -40)
            return above_rad()

        switch.above_rad = sinks
        with pytest.raises(NotReady, match=r"switch of arm 2 opened again"):
            one.home()
        sleep_s(one.clock, 0.1)
        assert one.status().state == "unhomed"
