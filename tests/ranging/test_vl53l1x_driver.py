"""One sensor: what the driver writes and reads, seen from the chip."""

from __future__ import annotations

import pytest

from deltactl.drivers.fakes.i2c_bus import FakeI2cBus
from deltactl.drivers.fakes.vl53l1x_chip import Vl53l1xChip
from deltactl.drivers.fakes.vl53l1x_scene import RangeNoise
from deltactl.drivers.i2c import Registers
from deltactl.drivers.ranging.registers import BUDGET_TIMEOUTS
from deltactl.drivers.ranging.vl53l1x import Vl53l1x
from deltactl.foundation.clock import Task, VirtualClock, ns
from deltactl.foundation.errors import SensorFault


class CommandWorker:
    """One chip and its driver."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.chip = Vl53l1xChip(self.clock, lambda start, end: 0.5, RangeNoise(sigma_m=0.0))
        self.bus = FakeI2cBus(self.clock, [self.chip])
        self.sensor = Vl53l1x(self.bus, self.clock)

    def finish(self, task: Task) -> float:
        """Run a waiting method to its end; the seconds it took."""
        start_ns = self.clock.now_ns()
        for wake_ns in task:
            self.clock.sleep_until_ns(wake_ns)
        return (self.clock.now_ns() - start_ns) * 1e-9

    def register(self, index: int, size: int) -> int:
        return Registers(self.bus, self.clock, self.chip.address, 0).read_int(index, size)


@pytest.fixture
def desk() -> CommandWorker:
    return CommandWorker()


@pytest.fixture
def ready(desk: CommandWorker) -> CommandWorker:
    """Booted and with its defaults."""
    desk.finish(desk.sensor.wait_booted())
    desk.sensor.write_defaults(pads_2v8=True)
    return desk


def test_boot_is_waited_for_through_silence(desk: CommandWorker) -> None:
    assert 0.0012 <= desk.finish(desk.sensor.wait_booted()) < 0.003
    desk.sensor.check_identity()


def test_a_slow_boot_is_waited_for_and_a_firmware_that_says_no(desk: CommandWorker) -> None:
    desk.chip.faults.extra_boot_ns, desk.chip.faults.deaf_firmware_ns = ns(0.2), ns(0.1)
    desk.chip.brown_out()
    assert 0.3 <= desk.finish(desk.sensor.wait_booted()) < 0.31


@pytest.mark.parametrize(
    ("knob", "message"),
    [("extra_boot_ns", "does not answer at 0x29"), ("deaf_firmware_ns", "does not finish booting")],
)
def test_boot_is_not_waited_for_longer_than_half_a_second(
    desk: CommandWorker, knob: str, message: str
) -> None:
    setattr(desk.chip.faults, knob, ns(10.0))
    desk.chip.brown_out()
    with pytest.raises(SensorFault, match=message):
        desk.finish(desk.sensor.wait_booted())
    assert desk.clock.now_ns() == pytest.approx(ns(0.5), rel=0.01)


def test_another_chip_is_not_taken_for_this_one(desk: CommandWorker) -> None:
    desk.chip.faults.model_id = 0xEEAA
    desk.finish(desk.sensor.wait_booted())
    with pytest.raises(SensorFault, match=r"id 0xEEAA instead of 0xEACC"):
        desk.sensor.check_identity()


def answers(ready: CommandWorker) -> bool:
    return Registers(ready.bus, ready.clock, ready.sensor.address, 0).answers()


def test_an_address_is_moved_to_and_lost_with_a_reset(ready: CommandWorker) -> None:
    ready.sensor.change_address(0x33)
    assert ready.chip.address == 0x33
    assert answers(ready)
    ready.chip.brown_out()
    ready.clock.sleep_until_ns(ready.clock.now_ns() + ns(0.002))
    assert not answers(ready)
    ready.sensor.was_reset()
    assert answers(ready)


def test_an_address_change_whose_acknowledgement_was_lost_is_found_out(
    ready: CommandWorker,
) -> None:
    def lossy(*messages: object) -> None:
        original(*messages)
        ready.bus.i2c_rdwr = original  # type: ignore[method-assign]
        raise OSError(121, "Remote I/O error")

    original = ready.bus.i2c_rdwr
    ready.bus.i2c_rdwr = lossy  # type: ignore[method-assign]
    ready.sensor.change_address(0x33)
    assert ready.sensor.address == 0x33


def test_defaults_arrive_as_the_sheet_lists_them(ready: CommandWorker) -> None:
    assert ready.register(0x002E, 1) == 0x01
    assert ready.register(0x0030, 1) == 0x01
    assert ready.register(0x0064, 4) == 0x01680080
    assert ready.register(0x007F, 2) == 0xC7FF
    assert not ready.chip.ranging


@pytest.mark.parametrize(
    ("mode", "budget_ms"), [(mode, ms) for mode, table in BUDGET_TIMEOUTS.items() for ms in table]
)
def test_chip_and_driver_agree_on_how_long_a_range_takes(
    ready: CommandWorker, mode: str, budget_ms: int
) -> None:
    timing = ready.sensor.set_mode(mode, budget_ms)  # type: ignore[arg-type]
    ready.sensor.set_inter_measurement(ns(1.0))
    ready.sensor.start()
    start_ns = ready.clock.now_ns()
    ready.clock.sleep_until_ns(start_ns + timing.range_ns - 20_000)
    assert not ready.sensor.data_ready()
    ready.clock.sleep_until_ns(start_ns + timing.range_ns + 20_000)
    assert ready.sensor.data_ready()


@pytest.mark.parametrize("period_ms", [20, 33.3, 100, 2000])
def test_the_period_asked_for_is_the_period_got(ready: CommandWorker, period_ms: float) -> None:
    ready.sensor.set_mode("short", 20)
    ready.sensor.set_inter_measurement(ns(period_ms * 1e-3))
    ready.sensor.start()
    ready.clock.sleep_until_ns(ready.clock.now_ns() + ns(10.0))
    ready.sensor.read_sample()
    assert ready.chip.samples == pytest.approx(10_000 / period_ms, abs=1, rel=1e-3)


def test_vhv_is_calibrated_once_and_left_not_ranging(ready: CommandWorker) -> None:
    assert ready.finish(ready.sensor.calibrate_vhv()) < 0.15
    assert ready.chip.samples == 1
    assert not ready.chip.ranging
    assert ready.register(0x0008, 1) == 0x09
    assert ready.register(0x000B, 1) == 0x00


def test_a_sensor_that_never_has_a_first_sample_is_a_fault_in_two_seconds(
    ready: CommandWorker,
) -> None:
    ready.chip.faults.silent_flag = True
    start_ns = ready.clock.now_ns()
    with pytest.raises(SensorFault, match="no first sample within 2 s"):
        ready.finish(ready.sensor.calibrate_vhv())
    assert ready.clock.now_ns() - start_ns == pytest.approx(ns(2.0), rel=0.01)


def test_an_oscillator_that_stands_is_a_fault(
    ready: CommandWorker, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ready.sensor, "_read", lambda register: 0)
    with pytest.raises(SensorFault, match="reports a fast oscillator of 0 MHz"):
        ready.sensor.set_mode("short", 20)


def test_a_missing_oscillator_calibration_is_a_fault(desk: CommandWorker) -> None:
    desk.chip.faults.no_osc_calibration = True
    desk.finish(desk.sensor.wait_booted())
    with pytest.raises(SensorFault, match="no oscillator calibration"):
        desk.sensor.set_inter_measurement(ns(0.02))


def test_a_sample_is_read_in_one_transaction(ready: CommandWorker) -> None:
    ready.sensor.set_mode("short", 20)
    ready.sensor.set_inter_measurement(ns(0.02))
    ready.sensor.start()
    ready.clock.sleep_until_ns(ready.clock.now_ns() + ns(0.05))
    before = ready.bus.transfers
    sample = ready.sensor.read_sample()
    assert ready.bus.transfers == before + 1
    assert (sample.raw_status, sample.stream_count, sample.distance_mm) == (9, 1, 500)
    assert sample.signal_mcps == pytest.approx(16.0, abs=0.01)
    assert sample.ambient_mcps == pytest.approx(0.1, abs=0.01)
    ready.sensor.clear_interrupt()
    assert not ready.sensor.data_ready()
