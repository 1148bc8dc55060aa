"""Where on the chain an effect acts, in the order in which a command passes."""

from __future__ import annotations

from enum import IntEnum


class Port(IntEnum):
    """counts -> motor -> gear -> arm -> linkage -> platform -> sensor -> clock."""

    MOTOR = 1
    GEAR = 2
    ARM = 3
    LINKAGE = 4
    PLATFORM = 5
    SENSOR = 6
    CLOCK = 7
    ENCODER = 8
    """Beside the chain: what an angle encoder on the arm makes of the true angle."""


PORT_TEXT: dict[Port, str] = {
    Port.MOTOR: "motor and drive",
    Port.GEAR: "gearbox and shaft",
    Port.ARM: "arm angle",
    Port.LINKAGE: "linkage",
    Port.PLATFORM: "platform",
    Port.SENSOR: "ranging sensor",
    Port.CLOCK: "time stamps",
    Port.ENCODER: "angle encoder",
}
