"""The chip behind the Pi's header as its character device shows it (linux/gpio.h, ABI version 2).

Answers the ioctls that lgpio makes, so that the real lgpio drives simulated pins; see
syscall_trap.py for how its calls get here. Does not model: edge events, debounce, bias other
than pull-up and pull-down, open drain, or lines that two programs want.
"""

from __future__ import annotations

import errno
import struct
from collections import Counter
from collections.abc import Callable

from deltactl.drivers.fakes.syscall_trap import Device

GET_CHIPINFO, GET_LINEINFO, GET_LINE = 0x8044B401, 0xC100B405, 0xC250B407
SET_CONFIG, GET_VALUES, SET_VALUES = 0xC110B40D, 0xC010B40E, 0xC010B40F

_USED, _OUTPUT, _PULL_UP = 1, 1 << 3, 1 << 8
_OUTPUT_VALUES = 2
_OFFSETS = struct.Struct("=64I")
_CONFIG = struct.Struct("=QI20x")
_ATTRIBUTE = struct.Struct("=IxxxxQQ")  # id, flags or values, mask
_CONFIG_AT, _ATTRIBUTES_AT, _NUM_LINES_AT = 288, 320, 560
_INFO_AT, _INFO = 64, struct.Struct("=IIQ176x")  # offset, number of attributes, flags
_VALUES = struct.Struct("=QQ")


class GpioChip:
    """`/dev/gpiochipN` of a Raspberry Pi 4, with 58 lines."""

    def __init__(self, label: str = "pinctrl-bcm2711", lines: int = 58):
        self.label, self.lines = label, lines
        self.calls: Counter[int] = Counter()
        self.outputs: dict[int, bool] = {}
        self._driven: dict[int, bool] = {}
        self._flags: dict[int, int] = {}
        self._listeners: dict[int, Callable[[bool], None]] = {}

    def connect(self, pin: int, on_level: Callable[[bool], None]) -> None:
        """Call `on_level` when the level of this pin changes, whoever changes it."""
        self._listeners[pin] = on_level

    def drive(self, pin: int, level: bool | None) -> None:
        """A circuit puts a level on an input, or lets it go (None)."""
        before = self.read(pin)
        if level is None:
            self._driven.pop(pin, None)
        else:
            self._driven[pin] = level
        self._tell(pin, before)

    def read(self, pin: int) -> bool:
        """Level of a pin."""
        if pin in self.outputs:
            return self.outputs[pin]
        return self._driven.get(pin, bool(self._flags.get(pin, 0) & _PULL_UP))

    def write(self, pin: int, level: bool) -> None:
        """The program puts a level on a pin."""
        before = self.outputs.get(pin)
        self.outputs[pin] = level
        self._tell(pin, before)

    def _tell(self, pin: int, before: bool | None) -> None:
        level = self.read(pin)
        if before != level and pin in self._listeners:
            self._listeners[pin](level)

    def configure(self, pins: list[int], data: bytes) -> None:
        """Take over a gpio_v2_line_config for these pins."""
        flags, attributes = _CONFIG.unpack_from(data)
        self._flags.update(dict.fromkeys(pins, flags | _USED))
        if not flags & _OUTPUT:
            for pin in pins:
                before = self.outputs.pop(pin, None)
                if before is not None:
                    self._tell(pin, before)
            return
        for index in range(attributes):
            at = _ATTRIBUTES_AT - _CONFIG_AT + index * _ATTRIBUTE.size
            kind, values, mask = _ATTRIBUTE.unpack_from(data, at)
            if kind == _OUTPUT_VALUES:
                for bit, pin in enumerate(pins):
                    self.write(pin, bool(mask & values & 1 << bit))

    def ioctl(self, request: int, data: bytes) -> tuple[bytes, Device | None]:
        self.calls[request] += 1
        if request == GET_CHIPINFO:
            name, label = b"gpiochip0", self.label.encode()
            return struct.pack("=32s32sI", name, label, self.lines), None
        if request == GET_LINEINFO:
            pin = struct.unpack_from("=I", data, _INFO_AT)[0]
            return data[:_INFO_AT] + _INFO.pack(pin, 0, self._flags.get(pin, 0)), None
        if request == GET_LINE:
            count = struct.unpack_from("=I", data, _NUM_LINES_AT)[0]
            pins = list(_OFFSETS.unpack_from(data)[:count])
            if any(pin >= self.lines for pin in pins):
                raise OSError(errno.EINVAL, "no such line")
            self.configure(pins, data[_CONFIG_AT:_NUM_LINES_AT])
            return data, _Lines(self, pins)
        raise OSError(errno.ENOTTY, f"ioctl {request:#x}")


class _Lines:
    """The descriptor of lines that were asked for together."""

    def __init__(self, chip: GpioChip, pins: list[int]):
        self._chip, self._pins = chip, pins

    def ioctl(self, request: int, data: bytes) -> tuple[bytes, Device | None]:
        self._chip.calls[request] += 1
        if request == SET_CONFIG:
            self._chip.configure(self._pins, data)
            return data, None
        bits, mask = _VALUES.unpack(data)
        chosen = [(bit, pin) for bit, pin in enumerate(self._pins) if mask >> bit & 1]
        if request == SET_VALUES:
            for bit, pin in chosen:
                self._chip.write(pin, bool(bits >> bit & 1))
            return data, None
        if request == GET_VALUES:
            bits = sum(self._chip.read(pin) << bit for bit, pin in chosen)
            return _VALUES.pack(bits, mask), None
        raise OSError(errno.ENOTTY, f"ioctl {request:#x}")
