"""What goes wrong in the field, one fault at a time, and what the driver makes of it."""

from __future__ import annotations

import pytest

from deltactl.drivers.fakes.ranging_bench import RangingBench
from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.drivers.ranging.vl53l1x import RawSample, Vl53l1x
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import ns, sleep_s


def _axes(readings: list[Reading]) -> set[str]:
    return {reading.axis for reading in readings}


def _comes_back(bench: RangingBench, axis: str = "y") -> float:
    """Seconds until a sensor has been restarted and says ok; the others must not stop."""
    others = sorted({"x", "y", "z"} - {axis})
    start_ns = bench.clock.now_ns()
    bench.run_until(lambda: bench.bank.health()[axis].startswith("restarting"))
    readings: list[Reading] = []
    while bench.bank.health()[axis] != "ok":
        readings += bench.run(0.02)
        assert bench.clock.now_ns() - start_ns < ns(5.0)
    took_s = (bench.clock.now_ns() - start_ns) * 1e-9
    for other in others:
        assert sum(reading.axis == other for reading in readings) >= 0.8 * took_s * 50 - 15
    assert _axes(bench.run(0.2)) == {"x", "y", "z"}
    return took_s


# Disturbed transfers.


@pytest.mark.parametrize("knob", ["nack_transfers", "timeout_transfers", "io_error_transfers"])
def test_a_few_lost_transfers_are_not_noticed(bench: RangingBench, knob: str) -> None:
    setattr(bench.chips["y"].faults, knob, 3)
    assert [r.axis for r in bench.run(0.1)].count("y") >= 4
    assert bench.well()


def test_more_lost_transfers_than_retries_cost_a_poll_not_a_restart(bench: RangingBench) -> None:
    bench.chips["y"].faults.nack_transfers = 10
    bench.run(0.02)
    assert "no answer at 0x31 (errno 121" in bench.bank.health()["y"]
    bench.run(0.1)
    assert bench.well()
    assert not any("held" in event for event in bench.bank.take_events())


def test_a_sensor_that_stays_silent_is_restarted(bench: RangingBench) -> None:
    bench.run(0.1)
    bench.chips["y"].faults.nack_transfers = 60
    assert _comes_back(bench) < 1.0


def test_a_lost_clear_loses_no_sample(bench: RangingBench) -> None:
    seen = bench.run(0.1)
    real = bench.rig.bus.i2c_rdwr

    def clears_get_lost(*messages: object) -> None:
        if bytes(messages[0])[:2] == b"\x00\x86":  # type: ignore[call-overload]
            raise OSError(121, "Remote I/O error")
        real(*messages)  # type: ignore[arg-type]

    bench.rig.bus.i2c_rdwr = clears_get_lost
    after = bench.run(0.5)
    assert len(after) == pytest.approx(75, abs=3)
    assert {reading.gate for reading in seen + after} == {Gate.GOOD}


def test_a_bit_flipped_in_the_stream_count_neither_repeats_nor_loses_a_sample(
    bench: RangingBench,
) -> None:
    bench.run(0.5)
    counts = []
    for poll in range(40):
        faults = bench.chips["y"].faults
        faults.flip, faults.flip_reads = (2, 0x40), int(poll % 4 == 0)
        counts += [r.stream_count for r in bench.run(0.02) if r.axis == "y"]
    assert counts == list(range(counts[0], counts[0] + 40))


def test_a_bit_flipped_in_the_distance_is_a_jump(bench: RangingBench) -> None:
    bench.run(0.1)
    faults = bench.chips["y"].faults
    faults.flip, faults.flip_reads = (13, 0x04), 1
    flipped, after = ([r for r in bench.run(0.02) if r.axis == "y"] for _ in range(2))
    assert flipped[0].gate is Gate.JUMP
    assert after[0].gate is Gate.GOOD


# Sensors that stop, lie, or restart by themselves.


def test_a_brown_out_is_recognised_and_mended_at_once(bench: RangingBench) -> None:
    bench.run(0.1)
    bench.bank.take_events()
    bench.chips["y"].brown_out()
    assert _comes_back(bench) < 0.5
    events = bench.bank.take_events()
    assert "sensor y (address 0x31, XSHUT on GPIO 20) held in reset: brown-out" in events[0]
    assert events[-1].endswith("ranges")


@pytest.mark.parametrize("axes", ["xy", "yz", "xyz"])
def test_several_brown_outs_at_once_are_mended_one_by_one(bench: RangingBench, axes: str) -> None:
    bench.run(0.1)
    for axis in axes:
        bench.chips[axis].brown_out()
    bench.run(0.06)
    assert not bench.well()
    assert bench.run_until(bench.well) < 1.0
    for axis, true_m in bench.true_m.items():
        mine = [reading for reading in bench.run(0.1) if reading.axis == axis]
        assert {reading.distance_m for reading in mine} == {true_m}


def test_a_brown_out_during_the_restart_of_another_is_mended_too(bench: RangingBench) -> None:
    bench.run(0.1)
    bench.chips["y"].brown_out()
    bench.run(0.04)
    bench.chips["z"].brown_out()
    assert bench.run_until(bench.well, limit_s=3.0) < 2.0
    distances = {r.axis: r.distance_m for r in bench.run(0.1)}
    assert distances == bench.true_m


def test_a_frozen_sensor_is_found_by_its_age_and_restarted(bench: RangingBench) -> None:
    bench.run(0.1)
    bench.chips["y"].faults.frozen = True
    start_ns = bench.clock.now_ns()
    readings = []
    while bench.bank.health()["y"] == "ok":
        readings += bench.run(0.02)
    assert not [r for r in readings if r.axis == "y"]
    assert 0.2 <= (bench.clock.now_ns() - start_ns) * 1e-9 <= 0.25
    assert "no new sample for 0.2" in bench.bank.health()["y"]
    bench.chips["y"].faults.clear()
    assert bench.run_until(bench.well) < 0.6


def test_a_pause_of_the_computer_is_none_of_the_sensor(
    bench: RangingBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A poll finds nothing new, and the program is held up before it can judge that."""
    read_sample, pauses_s = Vl53l1x.read_sample, [0.0] * 4 + [0.3, 0.6]

    def held_up(sensor: Vl53l1x) -> RawSample:
        sample = read_sample(sensor)
        sleep_s(bench.clock, pauses_s.pop() if pauses_s else 0.0)
        return sample

    bench.run(0.1)
    monkeypatch.setattr(Vl53l1x, "read_sample", held_up)
    bench.run(0.001, 0.001)
    bench.run(0.5)
    assert not pauses_s
    assert bench.well()
    assert not [one for one in bench.bank.take_events() if "held in reset" in one]


def test_a_slow_rate_stretches_the_age_limit() -> None:
    bench = RangingBench(RangingSettings(rate_hz=2.0, timing_budget_ms=20))
    bench.bank.start()
    assert len(bench.run(10.0)) == pytest.approx(60, abs=3)
    assert bench.well()


@pytest.mark.parametrize("code", range(32))
def test_every_status_code_is_passed_on_and_gated(bench: RangingBench, code: int) -> None:
    bench.run(0.1)
    bench.chips["y"].faults.raw_status = code
    readings = [r for r in bench.run(0.06) if r.axis == "y"]
    assert {r.raw_status for r in readings} == {code}
    assert {r.gate for r in readings} == {Gate.GOOD if code == 9 else Gate.STATUS}


@pytest.mark.parametrize("code", [1, 2, 3, 17])
def test_a_hardware_fault_that_stays_restarts_the_sensor(bench: RangingBench, code: int) -> None:
    bench.run(0.1)
    bench.chips["y"].faults.raw_status = code
    bench.run(0.02)
    assert "fault" in bench.bank.health()["y"]
    bench.run_until(lambda: bench.bank.health()["y"].startswith("restarting"), limit_s=0.2)
    bench.chips["y"].faults.clear()
    assert bench.run_until(bench.well) < 0.6


def test_losing_the_target_is_no_fault(bench: RangingBench) -> None:
    bench.run(0.1)
    bench.true_m["y"] = float("inf")
    readings = [r for r in bench.run(2.0) if r.axis == "y"]
    assert {(r.status, r.gate) for r in readings} == {(2, Gate.STATUS)}
    assert bench.well()


def test_a_wrapped_target_is_a_jump_although_its_status_is_valid(bench: RangingBench) -> None:
    bench.true_m["y"] = 1.0
    bench.run(0.3)
    bench.chips["y"].scene.wrap_m = 0.47
    (wrapped,) = [r for r in bench.run(0.02) if r.axis == "y"]
    assert (wrapped.status, wrapped.gate) == (0, Gate.JUMP)


def test_sunlight_is_gated_by_sigma_and_a_dark_target_by_signal(bench: RangingBench) -> None:
    bench.true_m["y"] = 1.2
    bench.run(0.3)
    bench.chips["y"].scene.ambient_mcps = 200.0
    assert [r.gate for r in bench.run(0.02) if r.axis == "y"] == [Gate.SIGMA]
    bench.chips["y"].scene.ambient_mcps = 0.1
    bench.run(0.02)
    # The chip's own limit is 1 MCPS; a stricter one of ours is another matter (next test).
    bench.chips["y"].scene.reflectance = 0.3
    assert [r.status for r in bench.run(0.02) if r.axis == "y"] == [2]


def test_the_signal_gate_of_the_settings_is_applied() -> None:
    bench = RangingBench(RangingSettings(minimum_signal_mcps=30.0))
    bench.bank.start()
    gates = {(r.axis, r.gate) for r in bench.run(0.1)}
    assert gates == {("x", Gate.GOOD), ("y", Gate.SIGNAL), ("z", Gate.SIGNAL)}
