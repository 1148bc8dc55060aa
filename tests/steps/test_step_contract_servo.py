"""A servo robot as a step output."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from deltactl.drivers.steps.contract import OutputState, Ticks
from deltactl.firmware_py.controller.servo_machine import servo_machine
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.clock import VirtualClock, sleep_s
from deltactl.foundation.errors import NotReady
from tests.steps.step_contract import StepOutputContract
from tests.steps.step_rig import LONG, Rig


class TestServoOnAVirtualClock(StepOutputContract):
    """A servo robot is a step output too, but for what its docstrings say."""

    @pytest.fixture
    def rig(self) -> Iterator[Rig]:
        robot, clock = load_robot(find("uzunovic-2013.yaml")), VirtualClock()
        machine = servo_machine(robot, clock)
        machine.output.set_counts((0, 0, 0))
        yield Rig(machine.output, clock, 20_000, machine.bench)
        machine.close()

    def test_outputs_are_safe_but_while_a_job_wants_otherwise(self, rig: Rig) -> None:
        """It has none, and says so."""
        with pytest.raises(NotReady, match="has none"):
            rig.output.switch(1 << 7, 1 << 7)

    @pytest.mark.skip(reason="it has none")
    def test_every_stop_makes_outputs_safe(self, rig: Rig) -> None: ...

    def test_the_drives_moved_as_far_as_the_counters_say(self, rig: Rig) -> None:
        pytest.skip("servo drives are told currents: tests/servo looks where the arms are")

    def test_a_tripped_drive_stops_all(self, rig: Rig) -> None:
        pytest.skip("these are other drives: tests/servo")

    def test_estop_latches_until_released_and_acknowledged(self, rig: Rig) -> None:
        pytest.skip("counts are of the reference, not of the arms: tests/servo")

    def test_a_run_longer_than_the_queue_is_fed_in_pieces(self, rig: Rig) -> None:
        """To and fro: its queue is longer than the way of its arms."""
        rig.output.enable()
        whole = rig.ticks(([(1, 0, -1)] * 3000 + [(-1, 0, 1)] * 3000) * 3)
        for done in range(0, len(whole), 100):
            piece = slice(done, done + 100)
            rig.output.push(Ticks(whole.due_ns[piece], whole.steps[piece]))
            sleep_s(rig.clock, 0.002)
        rig.wait(lambda: not rig.output.status().queued)
        assert rig.output.status().counts == (0, 0, 0)
        assert len(rig.output.take_sent()) == len(whole)

    def test_after_acknowledge_and_enable_it_goes_on_counting(self, rig: Rig) -> None:
        """A stop lets go of the arms: they are then where they are, not where they were sent."""
        rig.output.enable()
        rig.output.push(rig.ticks(LONG))
        rig.wait(lambda: rig.output.status().counts[0] > 3)
        rig.output.stop("test")
        stopped = rig.output.status().counts
        rig.output.acknowledge()
        status = rig.output.status()
        assert (status.state, status.energised) == (OutputState.DISABLED, False)
        rig.output.enable()
        counts = rig.output.status().counts
        assert max(abs(a - b) for a, b in zip(counts, stopped, strict=True)) < 200
        rig.run([(-1, -1, -1)] * 4)
        assert rig.output.status().counts == tuple(count - 4 for count in counts)

    def test_ticks_too_close_are_refused(self, rig: Rig) -> None:
        """Any distance will do, but backwards."""
        rig.output.enable()
        ticks = rig.ticks(LONG[:3])
        with pytest.raises(ValueError, match="strictly increasing"):
            rig.output.push(Ticks(ticks.due_ns[::-1], ticks.steps))
        with pytest.raises(ValueError, match="-1, 0 or"):
            rig.output.push(Ticks(ticks.due_ns, ticks.steps * 2))
        assert rig.output.status().queued == 0
