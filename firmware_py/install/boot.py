"""Boot options of a Raspberry Pi: what config.txt must say, added without touching the rest."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

BOOT_FILES: Final = ("boot/firmware/config.txt", "boot/config.txt")
"""Raspberry Pi OS 12 and later, and before; relative to the root."""

WANTED: Final[dict[str, str]] = {
    "i2c_arm": "on",
    "i2c_arm_baudrate": "400000",  # VL53L1X: three readings of 17 bytes take 2 ms, not 7
}
"""dtparam names and values (firmware documentation, overlays/README)."""

MARK: Final = "# deltactl: the I2C bus of the ranging sensors"


def boot_file(root: Path) -> Path | None:
    """The config.txt of this Pi; None when there is none."""
    return next((root / name for name in BOOT_FILES if (root / name).is_file()), None)


def with_options(text: str) -> str:
    """config.txt with what is missing added at its end; unchanged when nothing is."""
    found = active_parameters(text)
    missing = [
        f"dtparam={name}={value}" for name, value in WANTED.items() if found.get(name) != value
    ]
    if not missing:
        return text
    head = text if text.endswith("\n") or not text else text + "\n"
    # [all] ends whatever section ([pi4], [cm5], ...) the file ends in; later lines win.
    return head + "\n".join(["", "[all]", MARK, *missing, ""])


def active_parameters(text: str) -> dict[str, str]:
    """dtparam settings that hold for every model, as the firmware reads them: the last one wins."""
    return {
        name: value
        for line in _lines_for_all(text)
        if line.startswith("dtparam=")
        for name, value in _settings(line.removeprefix("dtparam="))
    }


def _lines_for_all(text: str) -> Iterator[str]:
    everywhere = True
    for raw in text.splitlines():
        line = raw.split("#", 1)[0].strip()
        if line.startswith("[") and line.endswith("]"):
            everywhere = line == "[all]"
        elif everywhere:
            yield line


def _settings(text: str) -> Iterator[tuple[str, str]]:
    """`i2c_arm=on,i2c_arm_baudrate=400000` holds two; a bare name means on."""
    for part in text.split(","):
        name, _, value = part.partition("=")
        name = {"i2c": "i2c_arm", "i2c_baudrate": "i2c_arm_baudrate"}.get(
            name.strip(), name.strip()
        )
        yield name, value.strip() or "on"
