"""`deltactl job verify`: home, run, home, compare, on the simulated robot."""

from __future__ import annotations

import pytest

from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.sensing.verify import Verification, verify
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import MotionError, NotReady


def verified(controller: Controller, write_job, finish, slipped: int = 0) -> Verification:
    def follow(number: int) -> JobResult:
        sleep_s(controller.clock, 2.0)
        if slipped:
            assert controller.machine.bench is not None
            controller.machine.bench.slip(2, slipped)
        return finish(controller, number)

    return verify(
        controller,
        controller.robot,
        write_job(),
        follow,
        lambda seconds: sleep_s(controller.clock, seconds),
    )


@pytest.mark.study
def test_a_good_run(controller: Controller, write_job, finish) -> None:
    controller.power_on()
    found = verified(controller, write_job, finish)
    assert found.lost == ()
    assert max(map(abs, found.steps)) < 10.0
    assert 0.3 < max(found.sigma_steps) < 3.0
    assert found.says().startswith("no steps lost (steps behind the counters: motor1 ")


@pytest.mark.study
@pytest.mark.parametrize("slipped", [40, -40])
def test_fewer_lost_steps_than_are_seen_while_running(
    controller: Controller, write_job, finish, slipped: int
) -> None:
    controller.power_on()
    found = verified(controller, write_job, finish, slipped)
    assert found.lost == (2,)
    assert found.steps[1] == pytest.approx(slipped, abs=8.0)
    assert "steps lost by motor2" in found.says()


def test_a_run_that_ends_otherwise_says_nothing(controller: Controller, write_job, finish) -> None:
    controller.power_on()
    with pytest.raises(MotionError, match=r"the job ended as fault: .*motor2"):
        verified(controller, write_job, finish, 300)


def test_a_sensor_that_is_silent(controller: Controller, write_job, finish) -> None:
    controller.power_on()
    controller.home()
    assert controller.machine.rig is not None
    controller.machine.rig.chips["y"].faults.raw_status = 4
    with pytest.raises(NotReady, match="no good reading from sensor y"):
        verified(controller, write_job, finish)
