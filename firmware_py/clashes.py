"""Where sections of a robot file contradict each other: the key at fault, and what is wrong.

In come sections each of which is valid by itself, not always all of them: a file's other
mistakes must not keep a contradiction for the next round.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from deltactl.foundation.yaml_tree import Location
from deltactl.models.gearing import LEAST_RATIO, too_small_ratio

if TYPE_CHECKING:
    from deltactl.drivers.settings import InputSettings
    from deltactl.firmware_py.robot_file import AsBuilt, Homing, Limits
    from deltactl.models.robot import AnyDrive, Masses

Clash = tuple[Location, str]
Sections = Mapping[str, Any]


def clashes(sections: Sections) -> Iterator[Clash]:
    """What can be told of these sections; a rule that needs one that is not there says nothing."""
    for needed, rule in RULES:
        if all(name in sections for name in needed):
            yield from rule(*(sections[name] for name in needed))


def _home_within_limits(limits: Limits, homing: Homing) -> Iterator[Clash]:
    low, high = limits.arm_deg
    for angle in homing.angle_deg:
        if not low <= angle <= high:
            says = f"{angle:g} is outside limits.arm_deg [{low:g}, {high:g}]"
            yield ("homing", "angle_deg"), says


def _inputs_named(built: AsBuilt, inputs: InputSettings) -> Iterator[Clash]:
    for name in built.inputs:
        if name not in inputs.named:
            yield ("as_built", "inputs", name), "is no input of inputs.named"


def _servo_masses(drive: AnyDrive, masses: Masses | None) -> Iterator[Clash]:
    if drive.kind == "servo" and masses is None:
        yield ("drive",), "kind servo needs a 'masses' section: the currents have to carry them"


def _servo_outputs(drive: AnyDrive, outputs: Mapping[str, object]) -> Iterator[Clash]:
    if drive.kind == "servo" and outputs:
        yield ("outputs",), "robots with drive.kind servo have none"


def _servo_as_built(drive: AnyDrive, built: AsBuilt) -> Iterator[Clash]:
    if drive.kind != "servo" and built.servo is not None:
        yield ("as_built", "servo"), "only robots with drive.kind servo have this section"


def _geared_down(drive: AnyDrive) -> Iterator[Clash]:
    if drive.gear_ratio < LEAST_RATIO:
        says = f"{drive.gear_ratio:g}: {too_small_ratio(drive.gear_ratio)}"
        yield ("drive", "gear_ratio"), says


RULES: tuple[tuple[tuple[str, ...], Callable[..., Iterator[Clash]]], ...] = (
    (("limits", "homing"), _home_within_limits),
    (("as_built", "inputs"), _inputs_named),
    (("drive",), _geared_down),
    (("drive", "masses"), _servo_masses),
    (("drive", "outputs"), _servo_outputs),
    (("drive", "as_built"), _servo_as_built),
)
"""The sections that a rule needs, and the rule."""
