"""What every step output does, simulated or real."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from deltactl.drivers.steps.contract import OutputState, Ticks
from deltactl.foundation.clock import ns, sleep_s
from deltactl.foundation.errors import (
    DriveAlarm,
    EmergencyStop,
    LimitExceeded,
    NotReady,
    PulseFault,
)
from tests.steps.step_rig import LONG, MIXED, SAFE, STEPS, SWITCHES, Rig, on


class StepOutputContract:
    """What every step output does. Subclasses give the rig."""

    def test_begins_released_and_refuses_ticks(self, rig: Rig) -> None:
        status = rig.output.status()
        assert (status.state, status.energised) == (OutputState.DISABLED, False)
        with pytest.raises(NotReady, match="not enabled"):
            rig.output.push(rig.ticks(LONG))

    def test_every_tick_is_sent_once_and_counted(self, rig: Rig) -> None:
        rig.output.enable()
        asked = rig.run(MIXED)
        moving = (asked.steps != 0).any(axis=1)
        sent = rig.output.take_sent()
        assert np.array_equal(sent.steps, asked.steps[moving])
        assert (np.diff(sent.due_ns) > 0).all()
        assert (sent.due_ns >= asked.due_ns[moving]).all()
        assert rig.output.status().counts == tuple(asked.steps.sum(axis=0))
        assert rig.output.status().state is OutputState.READY
        assert len(rig.output.take_sent()) == 0

    def test_the_drives_moved_as_far_as_the_counters_say(self, rig: Rig) -> None:
        rig.output.enable()
        rig.run(MIXED)
        assert rig.hands.counts() == rig.output.status().counts
        assert rig.hands.memory.lost() == (0, 0, 0)

    def test_a_run_longer_than_the_queue_is_fed_in_pieces(self, rig: Rig) -> None:
        rig.output.enable()
        whole = rig.ticks([(1, 0, -1)] * (rig.output.room() // 8 + 50))
        done = 0
        while done < len(whole):
            some = min(rig.output.room(), 100, len(whole) - done)
            piece = slice(done, done + some)
            rig.output.push(Ticks(whole.due_ns[piece], whole.steps[piece]))
            done += some
            if rig.output.status().queued > 300:
                sleep_s(rig.clock, 0.01)
        rig.wait(lambda: not rig.output.status().queued)
        assert rig.output.status().counts == (len(whole), 0, -len(whole))
        assert len(rig.output.take_sent()) == len(whole)

    def test_late_ticks_push_the_schedule_back(self, rig: Rig) -> None:
        rig.output.enable()
        late = rig.ticks(LONG[:20], lead_s=-0.5)
        rig.output.push(late)
        rig.wait(lambda: not rig.output.status().queued)
        gaps_ns = np.diff(rig.output.take_sent().due_ns)
        assert len(gaps_ns) == 19
        assert gaps_ns.min() >= 0.9 * rig.period_ns - 1
        assert rig.output.status().slip_ns > 0.4e9

    def test_stop_drops_the_queue_and_latches(self, rig: Rig) -> None:
        rig.output.enable()
        rig.output.push(rig.ticks(LONG))
        rig.wait(lambda: rig.output.status().counts[0] > 3)
        rig.output.stop("test")
        counts = rig.output.status().counts
        sleep_s(rig.clock, 0.05)
        status = rig.output.status()
        assert (status.state, status.reason) == (OutputState.STOPPED, "test")
        assert (status.counts, status.queued) == (counts, 0)
        assert 3 < counts[0] < len(LONG)
        assert len(rig.output.take_sent()) == counts[0]
        with pytest.raises(NotReady, match=r"stopped \(test\); acknowledge"):
            rig.output.push(rig.ticks(LONG))
        with pytest.raises(NotReady, match="acknowledge"):
            rig.output.enable()

    def test_after_acknowledge_and_enable_it_goes_on_counting(self, rig: Rig) -> None:
        rig.output.enable()
        rig.output.push(rig.ticks(LONG))
        rig.wait(lambda: rig.output.status().counts[0] > 3)
        rig.output.stop("test")
        counts = rig.output.status().counts
        rig.output.acknowledge()
        status = rig.output.status()
        assert (status.state, status.energised) == (OutputState.DISABLED, True)
        rig.output.enable()
        rig.run([(-1, -1, -1)] * 4)
        assert rig.output.status().counts == tuple(count - 4 for count in counts)

    def test_estop_latches_until_released_and_acknowledged(self, rig: Rig) -> None:
        hands = rig.hands
        rig.output.enable()
        rig.output.push(rig.ticks(LONG))
        rig.wait(lambda: rig.output.status().counts[0] > 3)
        hands.press_estop()
        rig.wait(lambda: rig.state() is OutputState.STOPPED)
        assert rig.output.status().reason == "e-stop"
        assert rig.output.status().counts == hands.counts()
        with pytest.raises(EmergencyStop, match="release the button"):
            rig.output.acknowledge()
        with pytest.raises(EmergencyStop):
            rig.output.enable()
        hands.release_estop()
        assert rig.state() is OutputState.STOPPED
        rig.output.acknowledge()
        rig.output.enable()
        assert rig.state() is OutputState.READY

    def test_estop_is_noticed_while_nothing_moves(self, rig: Rig) -> None:
        rig.hands.press_estop()
        rig.wait(lambda: rig.state() is OutputState.STOPPED)
        rig.hands.release_estop()
        sleep_s(rig.clock, 0.03)
        assert rig.output.status().reason == "e-stop"

    def test_a_tripped_drive_stops_all(self, rig: Rig) -> None:
        hands = rig.hands
        rig.output.enable()
        rig.output.push(rig.ticks(LONG))
        rig.wait(lambda: rig.output.status().counts[0] > 3)
        hands.trip(2)
        rig.wait(lambda: rig.state() is OutputState.STOPPED)
        assert rig.output.status().reason == "alarm motor2"
        with pytest.raises(DriveAlarm, match="motor2"):
            rig.output.acknowledge()
        rig.output.disable()  # which is how this drive is reset
        rig.output.acknowledge()
        assert rig.state() is OutputState.DISABLED

    def test_without_a_heartbeat_motion_stops(self, rig: Rig) -> None:
        rig.output.enable()
        rig.output.push(rig.ticks([(1, 0, -1)] * (ns(2 * STEPS.heartbeat_s) // rig.period_ns)))
        beat_ns = rig.clock.now_ns()  # a push is a beat; the last one was not after this
        rig.wait(lambda: rig.state() is OutputState.STOPPED, beat=False)
        assert rig.output.status().reason == "no heartbeat"
        sent = rig.output.take_sent()
        # Noticed within a tick and obeyed before the next: as long as ticks really took here,
        # where a modelled chip on a busy machine may need milliseconds for one.
        tick_ns = max(rig.period_ns, int(np.diff(sent.due_ns).max()))
        assert sent.due_ns[-1] - beat_ns <= ns(STEPS.heartbeat_s) + 2 * tick_ns

    def test_at_rest_nobody_needs_a_heartbeat(self, rig: Rig) -> None:
        rig.output.enable()
        sleep_s(rig.clock, 2 * STEPS.heartbeat_s)
        rig.run(MIXED)
        assert rig.state() is OutputState.READY

    def test_counters_are_set_at_rest_only(self, rig: Rig) -> None:
        rig.output.set_counts((-5, 7, 2**40))
        assert rig.output.status().counts == (-5, 7, 2**40)
        rig.output.enable()
        rig.output.push(rig.ticks(LONG))
        with pytest.raises(NotReady, match="moving"):
            rig.output.set_counts((0, 0, 0))
        rig.output.stop("test")
        assert rig.output.status().counts[1] - 7 == rig.output.status().counts[0] + 5

    def test_disable_drops_queue_and_drives(self, rig: Rig) -> None:
        rig.output.enable()
        rig.output.push(rig.ticks(LONG))
        rig.output.disable()
        status = rig.output.status()
        assert (status.state, status.queued, status.energised) == (OutputState.DISABLED, 0, False)

    def test_what_does_not_fit_is_refused_whole(self, rig: Rig) -> None:
        rig.output.enable()
        room = rig.output.room()
        with pytest.raises(PulseFault, match=f"room for {room}"):
            rig.output.push(rig.ticks([(1, 1, 1)] * (room + 1)))
        assert rig.output.room() == room
        assert rig.output.status().queued == 0

    def test_ticks_too_close_are_refused(self, rig: Rig) -> None:
        rig.output.enable()
        close = rig.ticks(LONG[:3])
        due_ns = close.due_ns[0] + np.arange(3) * (rig.output.minimum_period_ns - 1000)
        with pytest.raises(LimitExceeded, match="longer step period"):
            rig.output.push(Ticks(due_ns, close.steps))
        with pytest.raises(ValueError, match="strictly increasing"):
            rig.output.push(Ticks(close.due_ns[::-1], close.steps))
        with pytest.raises(ValueError, match="-1, 0 or"):
            rig.output.push(Ticks(close.due_ns, close.steps * 2))
        assert rig.output.status().queued == 0

    def test_outputs_are_safe_but_while_a_job_wants_otherwise(self, rig: Rig) -> None:
        assert on(rig) == SAFE
        with pytest.raises(NotReady, match="not enabled"):
            rig.output.switch(*SWITCHES.levels({"gripper": True}))
        rig.output.enable()
        assert on(rig) == SAFE
        rig.output.switch(*SWITCHES.levels({"gripper": True, "valve": True}))
        assert on(rig) == {"gripper": True, "valve": True, "brake": True}
        rig.output.switch(*SWITCHES.levels({"valve": False, "brake": False}))
        assert on(rig) == {"gripper": True, "valve": False, "brake": False}
        rig.run(MIXED)
        assert on(rig) == {"gripper": True, "valve": False, "brake": False}
        rig.output.disable()
        assert on(rig) == SAFE

    def test_every_stop_makes_outputs_safe(self, rig: Rig) -> None:
        rig.output.enable()
        wanted = {"gripper": True, "valve": True, "brake": False}
        ways: dict[str, tuple[Callable[[], None], Callable[[], None]]] = {
            "stop": (lambda: rig.output.stop("test"), lambda: None),
            "e-stop": (lambda: rig.hands.press_estop(), lambda: rig.hands.release_estop()),
            "alarm": (lambda: rig.hands.trip(2), rig.output.disable),
            "no heartbeat": (lambda: None, lambda: None),
            "close": (rig.output.close, lambda: None),
        }
        for way, (stops, mends) in ways.items():
            begun = rig.output.status().counts[0]
            rig.output.switch(*SWITCHES.levels(wanted))
            rig.output.push(rig.ticks([(1, 0, -1)] * (ns(2 * STEPS.heartbeat_s) // rig.period_ns)))
            rig.wait(lambda begun=begun: rig.output.status().counts[0] > begun + 3)
            assert on(rig) == wanted, way
            stops()
            rig.wait(lambda: rig.state() is OutputState.STOPPED, beat=way != "no heartbeat")
            assert on(rig) == SAFE, way
            if way != "close":
                with pytest.raises(NotReady, match="stopped"):
                    rig.output.switch(*SWITCHES.levels(wanted))
                assert on(rig) == SAFE, way
                mends()
                rig.output.acknowledge()
                rig.output.enable()

    def test_close_is_final_and_may_be_repeated(self, rig: Rig) -> None:
        rig.output.enable()
        rig.output.push(rig.ticks(LONG))
        rig.output.close()
        rig.output.close()
        rig.output.stop("too late")
        rig.output.beat()
        assert rig.output.status().state is OutputState.STOPPED
        assert rig.output.status().counts[0] == len(rig.output.take_sent())
        with pytest.raises(PulseFault, match="closed"):
            rig.output.enable()
