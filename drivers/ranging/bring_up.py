"""The steps that bring one sensor from reset to ranging, each ending with when to go on.

The same generators serve the blocking start and the restart of one sensor in the middle of a
run, where each poll takes one short step.
"""

from __future__ import annotations

from collections.abc import Callable

from deltactl.drivers.i2c import I2cBus, Registers
from deltactl.drivers.ranging.registers import DEFAULT_ADDRESS
from deltactl.drivers.ranging.timing import RangeTiming
from deltactl.drivers.ranging.vl53l1x import BOOT_NS, Vl53l1x
from deltactl.drivers.ranging.xshut import XshutLine
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import NS_PER_S, Clock, Task, ns
from deltactl.foundation.errors import SensorFault

RESET_HOLD_NS = ns(0.005)
SILENCE_TIMEOUT_NS = ns(0.5)
SILENCE_STEP_NS = ns(0.01)


def somebody_at_default(bus: I2cBus, clock: Clock) -> bool:
    """Whether a sensor answers at 0x29: it is fresh out of a reset (brown-out)."""
    return Registers(bus, clock, DEFAULT_ADDRESS, 0).answers()


def take_address(sensor: Vl53l1x, line: XshutLine, address: int, bus: I2cBus, clock: Clock) -> Task:
    """XSHUT pulse, boot, identity, new address. Nobody else may be at 0x29 meanwhile.

    Raises SensorFault when it does not boot, is something else, or ignores its XSHUT.
    """
    line.off()
    sensor.was_reset()
    yield clock.now_ns() + RESET_HOLD_NS
    give_up_ns = clock.now_ns() + SILENCE_TIMEOUT_NS
    # Another sensor that browned out answers there too, until its own restart holds it in reset.
    while somebody_at_default(bus, clock):
        if clock.now_ns() >= give_up_ns:
            raise SensorFault(
                f"is held in reset but somebody answers at 0x{DEFAULT_ADDRESS:02X}"
                " (is the XSHUT wire connected?)"
            )
        yield clock.now_ns() + SILENCE_STEP_NS
    line.on()
    yield clock.now_ns() + BOOT_NS
    yield from sensor.wait_booted()
    sensor.check_identity()
    sensor.change_address(address)


def configure(
    sensor: Vl53l1x,
    settings: RangingSettings,
    clock: Clock,
    on_timing: Callable[[RangeTiming], None],
    start_at_ns: Callable[[], int],
) -> Task:
    """Default settings, VHV, mode, budget and period; then start at the instant asked for.

    Raises SensorFault when the chip makes no first sample or lacks its calibration.
    """
    sensor.write_defaults(settings.io_2v8)
    yield clock.now_ns()
    yield from sensor.calibrate_vhv()
    yield clock.now_ns()
    timing = sensor.set_mode(settings.mode, settings.timing_budget_ms)
    sensor.set_inter_measurement(round(NS_PER_S / settings.rate_hz))
    on_timing(timing)
    yield start_at_ns()
    sensor.start()
