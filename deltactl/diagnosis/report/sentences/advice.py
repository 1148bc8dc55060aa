"""What to do about each effect, by the kind of machine: by the layers of its card.

A machine's own lines come before those that hold for all. `{part}` is the component in words,
`{size}` the main size without its sign, `{factor}` a scale as it is, `{true}` what the robot file's
own value becomes, `{follows}` what an unknown follows; `{sign:a|b}` is a where the main size is
above nothing and b where it is below.
Rows are `small` (below the card's `small`), the name of the main parameter, of an unknown what it
follows (and `.force` where it is one); `beside` where friction or play is found too that may be the
cause.
"""

from __future__ import annotations

from deltactl.models.effects import Trait, card_of, has
from deltactl.models.robot import DeltaRobot, RobotModel, ServoAxis, kind

LAYERS: dict[str, tuple[str, ...]] = {
    "delta": (),
    "servo_delta": ("servo_drive",),
    "stepper_axis": ("axis",),
    "servo_axis": ("servo_axis", "axis", "servo_drive"),
    "slide": ("slide", "axis", "servo_drive"),
    "range_sensor": ("sensor",),
}
"""Layers of remedies by machine and drive, the nearest first. Belts and screws are a slide's,
whatever motor turns them: the file of an axis does not say which."""


def machine_of(robot: RobotModel | None, component: str, effect: str) -> str:
    """The key of LAYERS for a robot; without one by what the finding is at."""
    if isinstance(robot, DeltaRobot):
        return (
            "servo_delta" if robot.drive is not None and kind(robot.drive) == "servo" else "delta"
        )
    if isinstance(robot, ServoAxis) and robot.motion == "linear":
        return "slide"
    if robot is not None:
        return robot.kind
    if component != "axis":
        return "delta"
    return "range_sensor" if has(effect, Trait.READING) else "servo_axis"


def advice(machine: str, effect: str, parameter: str, departure: float) -> str | None:
    """The line of a machine for an effect of which the main parameter is so far from nothing."""
    card = card_of(effect)
    rows: tuple[str, ...] = (parameter, "")
    if abs(departure) < card.small:
        rows = ("small", *rows)
    return card.remedy(LAYERS[machine], rows)
