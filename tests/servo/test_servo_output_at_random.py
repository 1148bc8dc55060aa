"""Whatever is asked of a servo output in whatever order: no current where it says there is none."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.drivers.steps.contract import OutputState, Ticks
from deltactl.firmware_py.controller.servo_machine import servo_machine
from deltactl.firmware_py.machine import Machine
from deltactl.foundation.clock import VirtualClock, sleep_s
from deltactl.foundation.errors import DeltactlError

POWERED = (OutputState.READY, OutputState.MOVING)


def push(machine: Machine) -> None:
    due_ns = machine.clock.now_ns() + 5_000_000 + 100_000 * np.arange(300, dtype=np.int64)
    machine.output.push(Ticks(due_ns, np.full((300, 3), (1, -1, 1), dtype=np.int8)))


ACTS: dict[str, Callable[[Machine], object]] = {
    "enable": lambda machine: machine.output.enable(),
    "disable": lambda machine: machine.output.disable(),
    "push": push,
    "beat": lambda machine: machine.output.beat(),
    "stop": lambda machine: machine.output.stop("test"),
    "acknowledge": lambda machine: machine.output.acknowledge(),
    "home": lambda machine: machine.output.set_counts((30_000, 30_000, 30_000)),
    "press": lambda machine: machine.bench.press_estop(),
    "release": lambda machine: machine.bench.release_estop(),
    "lose": lambda machine: machine.drives.fail("encoder_lost", 2),
    "trip": lambda machine: machine.drives.fail("over_current", 3),
    "mend": lambda machine: (machine.drives.mend(2), machine.drives.mend(3)),
    "wait": lambda machine: sleep_s(machine.clock, 0.02),
    "wait long": lambda machine: sleep_s(machine.clock, 0.3),
}


@given(st.lists(st.sampled_from(sorted(ACTS)), min_size=5, max_size=25))
@settings(max_examples=12, deadline=None)
def test_current_flows_only_where_the_state_says_so(micro, acts: list[str]) -> None:
    clock = VirtualClock()
    machine = servo_machine(micro, clock)
    assert machine.drives is not None
    for act in ("home", "enable", *acts):
        was, stood = machine.output.status(), machine.drives.plant.angles_rad()
        with suppress(DeltactlError):  # a refusal is an answer too
            ACTS[act](machine)
        status = machine.output.status()
        assert machine.drives.enabled == status.energised == (status.state in POWERED)
        assert (status.state is OutputState.MOVING) == (status.queued > 0)
        assert bool(status.reason) == (status.state is OutputState.STOPPED)
        if not was.energised and not status.energised:
            assert machine.drives.plant.angles_rad() == stood
    machine.close()
    sleep_s(clock, 0.01)
    assert not machine.drives.enabled
