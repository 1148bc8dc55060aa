"""A step output under test, on its clock, with hands at the bench where there are any."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from deltactl.drivers.fakes.bench import FakeBench
from deltactl.drivers.settings import InputSettings, StepSettings, SwitchedPin
from deltactl.drivers.steps.contract import OutputState, StepOutput, Ticks
from deltactl.drivers.steps.lines import Switches
from deltactl.foundation.clock import Clock, ns, sleep_s

INPUTS = InputSettings()
STEPS = StepSettings()
SWITCHES = Switches(
    {
        "gripper": SwitchedPin(pin=12, safe=False),
        "valve": SwitchedPin(pin=16, active_high=False, safe=False),
        "brake": SwitchedPin(pin=18, safe=True),
    }
)
SAFE = {"gripper": False, "valve": False, "brake": True}


@dataclass
class Rig:
    """A step output on its clock; `bench` where the drives are simulated."""

    output: StepOutput
    clock: Clock
    period_ns: int
    bench: FakeBench | None = None

    @property
    def hands(self) -> FakeBench:
        """The bench, or skip: nobody presses buttons on real hardware."""
        if self.bench is None:
            pytest.skip("needs hands on the bench")
        return self.bench

    def ticks(self, steps: list[tuple[int, int, int]], lead_s: float = 0.02) -> Ticks:
        start_ns = self.clock.now_ns() + ns(lead_s)
        due_ns = start_ns + self.period_ns * np.arange(len(steps), dtype=np.int64)
        return Ticks(due_ns, np.array(steps, dtype=np.int8))

    def wait(self, until: Callable[[], bool], beat: bool = True, limit_s: float = 30.0) -> None:
        give_up_ns = self.clock.now_ns() + ns(limit_s)
        while not until():
            assert self.clock.now_ns() < give_up_ns, self.output.status()
            if beat:
                self.output.beat()
            sleep_s(self.clock, 0.005)

    def rest(self) -> None:
        self.wait(lambda: self.output.status().state is not OutputState.MOVING)

    def run(self, steps: list[tuple[int, int, int]]) -> Ticks:
        ticks = self.ticks(steps)
        self.output.push(ticks)
        self.wait(lambda: not self.output.status().queued)
        self.rest()
        return ticks

    def state(self) -> OutputState:
        return self.output.status().state


LONG = [(1, 1, 1)] * 500
MIXED = [(1, -1, 0), (1, 0, 0), (-1, 1, 1), (0, 0, 0), (-1, -1, -1), (1, 1, 1)] * 5


def on(rig: Rig) -> dict[str, bool]:
    """What hangs on the outputs, and what the output believes of it."""
    believed = SWITCHES.states(rig.output.status().switched)
    if rig.bench is not None:
        assert rig.bench.outputs() == believed
    return believed
