"""The 40-pin header of every Raspberry Pi since the B+.

Source: Raspberry Pi documentation, "GPIO and the 40-pin header" (and `pinout` of gpiozero).
"""

from __future__ import annotations

from typing import Final

PIN_OF_GPIO: Final[dict[int, int]] = {
    0: 27, 1: 28, 2: 3, 3: 5, 4: 7, 5: 29, 6: 31, 7: 26, 8: 24, 9: 21,
    10: 19, 11: 23, 12: 32, 13: 33, 14: 8, 15: 10, 16: 36, 17: 11, 18: 12, 19: 35,
    20: 38, 21: 40, 22: 15, 23: 16, 24: 18, 25: 22, 26: 37, 27: 13,
}  # fmt: skip
"""Header pin of each GPIO (BCM number)."""

POWER_3V3: Final = (1, 17)
POWER_5V: Final = (2, 4)
GROUND: Final = (6, 9, 14, 20, 25, 30, 34, 39)

I2C_GPIO: Final[dict[int, tuple[int, int]]] = {0: (0, 1), 1: (2, 3)}
"""SDA and SCL of the buses that stand on the header by themselves; others need an overlay."""

PULLED_UP_AT_BOOT: Final = range(9)
"""GPIO 0 to 8 are pulled up until a program claims them, the others down (BCM2835 ARM
Peripherals, table 6-31; the same on BCM2711 and RP1)."""
