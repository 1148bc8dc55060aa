"""Section 5 on the MuJoCo robot: tracking, what the observer buys, and how it is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the micro delta needs the extra 'proof' (MuJoCo)")

from deltactl.drivers.fakes.current_drives import FakeCurrentDrives
from deltactl.firmware_py.servo.law import LawSettings
from deltactl.firmware_py.servo.loop import ServoLoop
from deltactl.proof.micro.as_built import MicroDelta
from deltactl.proof.micro.plant import MicroPlant
from deltactl.reproduction.uzunovic_2013.control import ControlPart
from deltactl.reproduction.uzunovic_2013.control_loop import (
    CONTROL_ON_S,
    EXPERIMENTS,
    START_RAD,
    References,
    micro_delta,
    references,
    run,
    shipped_network,
)
from deltactl.reproduction.uzunovic_2013.control_results import (
    Result,
    observer_table,
    reference_figure,
    response_figures,
    speed_table,
    tracking_table,
)
from deltactl.reproduction.uzunovic_2013.control_variants import (
    NOTHING,
    OURS,
    PAPER,
    TROUBLES,
    friction_current_a,
    simulate,
)

_, DRIVE = micro_delta()
SECONDS = 3.5
"""Until after the first reversals."""


@pytest.fixture(scope="module")
def asked() -> References:
    return references(EXPERIMENTS[1], shipped_network(), DRIVE.period_s, SECONDS)


@pytest.fixture(scope="module")
def result(asked: References) -> Result:
    return Result(asked, PAPER, NOTHING, True, simulate(DRIVE, asked, PAPER))


def test_references_are_those_of_section_5() -> None:
    first, second = EXPERIMENTS
    t_s = np.array([0.0, 1.25])
    expected = [[0.0, 0.003, -0.075], [0.0045, 0.0, -0.073]]
    assert first.position_m(t_s) == pytest.approx(np.array(expected), abs=1e-12)
    expected = [[0.0, 0.003, -0.075], [0.003, -0.003, -0.075]]
    assert second.position_m(t_s) == pytest.approx(np.array(expected), abs=1e-12)


@pytest.mark.study
def test_tracking_error_is_at_most_half_of_the_paper_s(asked: References, result: Result) -> None:
    for tracking in (result.tracking, simulate(DRIVE, asked, OURS)):
        assert tracking.most_percent.max() <= 0.5 * asked.experiment.paper_percent
        assert tracking.overshoot_percent.max() < 2.0


@pytest.mark.study
def test_arms_stand_until_control_is_on(result: Result) -> None:
    ran = result.tracking.run
    assert ran.t_s[ran.on] == pytest.approx(CONTROL_ON_S)
    assert np.ptp(ran.true_rad[: ran.on], axis=0).max() == 0.0
    assert not ran.current_a[: ran.on].any()


@pytest.mark.study
def test_without_the_observer_gravity_pulls_the_arms_off(asked: References) -> None:
    tracking = simulate(DRIVE, asked, PAPER.without_observer())
    assert tracking.most_percent.min() > 30.0


def test_the_estimate_is_gravity_and_friction(result: Result) -> None:
    """Mean current over whole motion is what the estimate says; the arms are held up: negative."""
    ran = result.tracking.run
    late = slice(ran.on + 5000, None)
    assert ran.disturbance_a[late].mean(axis=0) == pytest.approx(
        ran.current_a[late].mean(axis=0), abs=2e-3
    )
    assert ran.disturbance_a[late].mean(axis=0).max() < -0.005


@pytest.mark.study
def test_friction_is_given_in_the_reference_s_direction(asked: References) -> None:
    current_a = friction_current_a(DRIVE, asked.angle_rad)
    whole_a = DRIVE.coulomb_nm / DRIVE.torque_constant_nmpa
    fast = np.abs(np.gradient(asked.angle_rad, DRIVE.period_s, axis=0)) > 0.01
    going = np.sign(np.gradient(asked.angle_rad, axis=0))
    assert current_a[fast] == pytest.approx((whole_a * going)[fast])
    assert np.abs(current_a).max() == pytest.approx(whole_a)


def test_a_law_of_another_pace_is_refused(asked: References) -> None:
    slow = replace(LawSettings.of(DRIVE), period_s=2e-4)
    with pytest.raises(ValueError, match=r"runs every 0\.0002 s"):
        run(slow, MicroDelta(), asked.t_s, asked.angle_rad)


def test_it_stands_in_for_our_own_plant_behind_the_drives() -> None:
    """The loop of `deltactl run` holds the MuJoCo robot against gravity."""
    plant = MicroPlant(MicroDelta(), START_RAD)
    drives = FakeCurrentDrives(
        plant,
        period_s=DRIVE.period_s,
        rad_per_count=DRIVE.rad_per_count,
        current_limit_a=DRIVE.current_limit_a,
    )
    loop = ServoLoop(DRIVE, drives, 0)
    drives.enable()
    loop.settle()
    assert loop.run(300_000_000) == ""
    moved = np.array(plant.angles_rad()) - START_RAD
    assert np.abs(moved).max() < 2.0 * DRIVE.rad_per_count


def test_every_trouble_changes_robot_or_law() -> None:
    for trouble in TROUBLES[1:]:
        settings = LawSettings.of(DRIVE)
        changed = (
            trouble.robot(MicroDelta()) != MicroDelta() or trouble.change(settings) != settings
        )
        assert changed, trouble.name


def test_tables_and_figures(result: Result) -> None:
    tracking, observer = tracking_table([result], DRIVE), observer_table([result])
    assert tracking.rows[0][6] == "yes"
    assert "half an encoder count" in tracking.note
    assert observer.rows[0][3:] == ("-", "-", "-")
    part = ControlPart(
        [result],
        [tracking, observer, speed_table([result])],
        [reference_figure(result.asked), *response_figures(result)],
    )
    page = "".join(part.html())
    assert "Figure 9: reference" in page
    assert page.count("Figure 10: joint") >= 3
    assert page.count("<table") == 3
