"""Whoever stops the output first is the reason, however many stop it after that."""

from __future__ import annotations

from drivers.fakes.steps import simulated_step_output
from drivers.settings import InputSettings, StepSettings
from foundation.clock import VirtualClock, sleep_s


def test_the_reason_is_that_of_the_first_stop() -> None:
    clock = VirtualClock()
    made = simulated_step_output(StepSettings(), InputSettings(), clock, realtime=False)
    made.output.enable()
    made.output.stop("first")
    made.output.stop("second")
    assert made.output.status().reason == "first"
    made.bench.press_estop()
    sleep_s(clock, 0.05)
    assert made.output.status().reason == "first"
    made.bench.release_estop()
    made.output.acknowledge()
    made.output.stop("third")
    assert made.output.status().reason == "third"
    made.close()
