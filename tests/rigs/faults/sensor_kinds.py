"""Faults of the sensors and their bus."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from random import Random
from typing import Any

from deltactl.drivers.fakes.vl53l1x_chip import Vl53l1xChip
from deltactl.firmware_py.controller.sensing.sight import BLIND_S
from tests.rigs.faults.kind import Kind, Undo, nothing
from tests.rigs.faults.stand import Stand

BAD_RAW_STATUS = (4, 5, 6, 7, 8, 12, 13, 18, 22)
"""Raw codes of single bad samples (VL53L1X ULD, status_rtn)."""
SICK_RAW_STATUS = (1, 2, 3, 17)
"""Raw codes of a broken sensor."""
RESULT_BYTES = 17
HANG_S = 8.0


def each(*values: int) -> Iterator[int]:
    """One after the other, so that every one is tried."""
    return itertools.cycle(values)


def on_a_chip(**knobs: Any) -> Callable[[Stand, Random], Undo]:
    """Turn knobs of one of the three chips."""

    def inject(stand: Stand, chance: Random) -> Undo:
        chip = _any_chip(stand, chance)
        for name, value in knobs.items():
            setattr(chip.faults, name, next(value) if isinstance(value, itertools.cycle) else value)
        return chip.faults.clear

    return inject


def on_all_chips(**knobs: Any) -> Callable[[Stand, Random], Undo]:
    """Turn knobs of all three chips."""

    def inject(stand: Stand, chance: Random) -> Undo:
        chips = stand.rig.chips.values()
        for chip in chips:
            for name, value in knobs.items():
                setattr(chip.faults, name, value)

        def undo() -> None:
            for chip in chips:
                chip.faults.clear()

        return undo

    return inject


def hang_bus(stand: Stand, chance: Random) -> Undo:
    """One transfer does not come back for eight seconds; nothing else fails."""
    stand.rig.bus.hang_s = HANG_S
    return nothing


def tear_data(stand: Stand, chance: Random) -> Undo:
    """A bit of a result is read wrongly, some times in a row."""
    chip = _any_chip(stand, chance)
    chip.faults.flip = (chance.randrange(RESULT_BYTES), 1 << chance.randrange(8))
    chip.faults.flip_reads = chance.randint(1, 5)
    return chip.faults.clear


def brown_out(stand: Stand, chance: Random) -> Undo:
    """Back at 0x29 with reset values."""
    _any_chip(stand, chance).brown_out()
    return nothing


def stick_bus(stand: Stand, chance: Random) -> Undo:
    """Every transfer times out, whatever is reset."""
    stand.rig.bus.stuck = True
    return lambda: setattr(stand.rig.bus, "stuck", False)


def take_adapter(stand: Stand, chance: Random) -> Undo:
    """The adapter itself is gone (ENODEV)."""
    stand.rig.bus.gone = True
    return lambda: setattr(stand.rig.bus, "gone", False)


def _any_chip(stand: Stand, chance: Random) -> Vl53l1xChip:
    return stand.rig.chips[chance.choice("xyz")]


def lie(**knobs: Any) -> Callable[[Stand, Random], Undo]:
    """A sensor of the plane says what is not, with a good status.

    Not z: what it says wrong looks like three arms that sink alike, and both are said.
    """

    def inject(stand: Stand, chance: Random) -> Undo:
        faults = stand.rig.chips[chance.choice("xy")].faults
        for name, value in knobs.items():
            setattr(faults, name, value)
        return faults.clear

    return inject


LIAR = r"^sensor [xy] reads \d+ mm too (much|little), which the two other sensors"
BLIND_END_S = BLIND_S + 0.2
RESTARTED = r"sensor [xyz].*held in reset"

SENSOR_KINDS = (
    Kind("NACK burst (errno 121)", on_a_chip(nack_transfers=each(1, 2, 3, 6, 12)), within_s=2.0),
    Kind("time-outs (errno 110)", on_a_chip(timeout_transfers=each(1, 2, 3, 6)), within_s=2.0),
    Kind("I/O errors (errno 5)", on_a_chip(io_error_transfers=each(1, 2, 3, 6)), within_s=2.0),
    Kind("SDA held low by a sensor", on_a_chip(sda_stuck=True), within_s=4.0, culprit=RESTARTED),
    Kind("brown-out to 0x29", brown_out, within_s=3.0, culprit="brown-out.*0x29"),
    Kind(
        "frozen stream count",
        on_a_chip(frozen=True),
        within_s=3.0,
        culprit=RESTARTED,
        hold_s=0.3,
    ),
    Kind("bad status", on_a_chip(raw_status=each(*BAD_RAW_STATUS)), within_s=1.0),
    Kind(
        "status of a broken sensor",
        on_a_chip(raw_status=each(*SICK_RAW_STATUS)),
        within_s=3.0,
        culprit=RESTARTED,
    ),
    Kind("torn data (bits flipped)", tear_data, within_s=2.0),
    Kind(
        "sensor dead",
        on_a_chip(unpowered=True),
        "fault",
        BLIND_END_S,
        BLIND_END_S,
        r"blind: no good reading of sensor [xyz] \(restarting",
        r"sensor [xyz]|no sensor answers",
    ),
    Kind(
        "bus held low",
        stick_bus,
        "fault",
        BLIND_END_S,
        BLIND_END_S,
        "blind: .*errno 110",
        "I2C bus|blind",
    ),
    Kind(
        "a sensor blind (status)",
        on_a_chip(raw_status=4),
        "fault",
        BLIND_END_S,
        BLIND_END_S,
        r"blind: no good reading of sensor [xyz] \(refused: status\)",
        "blind",
    ),
    Kind(
        "three sensors blind",
        on_all_chips(raw_status=4),
        "fault",
        BLIND_END_S,
        BLIND_END_S,
        r"blind: .* x .* y .* z \(refused",
        "blind",
    ),
    Kind(
        "sensor frozen for good",
        on_a_chip(frozen=True),
        "fault",
        BLIND_END_S,
        BLIND_END_S,
        "blind: no good reading of sensor [xyz]",
        "blind|sensor [xyz]",
    ),
    Kind(
        "I2C call hangs 8 s",
        hang_bus,
        "fault",
        BLIND_END_S,
        BLIND_END_S,
        "blind: .* x .* y .* z",
        "blind",
        restart=True,
    ),
    Kind("sensor lies: stuck", lie(stuck_m=1.0), "fault", 1.0, 1.2, LIAR),
    Kind("sensor lies: offset", lie(offset_m=0.04), "fault", 1.0, 1.2, LIAR),
    Kind("sensor lies: scaled", lie(scale=1.15), "fault", 1.0, 1.2, LIAR),
    Kind("sensor lies: spikes", lie(spike_rate=0.2), within_s=2.0, hold_s=1.0),
    Kind("I2C adapter gone", take_adapter, "fault", 0.2, 0.4, "I2C adapter fails", "I2C adapter"),
)
