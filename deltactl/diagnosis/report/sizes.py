"""Sizes in the units people use: degrees, mm, ms, %, with their intervals; units of covariates."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar, cast

from deltactl.diagnosis.answer.finding import IN_ALL
from deltactl.diagnosis.answer.picture import unit_of
from deltactl.diagnosis.answer.records import Diagnosis, Finding, ParameterResult
from deltactl.diagnosis.report.templates import numbered, say, templates
from deltactl.models.effects import card_of
from deltactl.models.effects.units_in_use import in_use, said_in
from deltactl.models.robot import DeltaRobot, RangeSensor, RobotModel, ServoAxis

Say = TypeVar("Say", bound=Callable[..., Any])
NOT_REPORTED = frozenset(
    {"phase", "amplitude_2", "phase_2", "start", "drag", "friction", "stiffness", IN_ALL}
)
"""Second parameters that mean nothing to a mechanic; the table of all numbers has them."""
FINEST_S = 2
"""Decimals of a time in s: sampling periods are hardly ever shorter than 10 ms."""
MOST_DECIMALS = 9
MOST_DIGITS = 6
"""Digits of a size: a longer number widens a table, and nothing is measured or set more finely."""
EVERYDAY = range(-5, 6)
"""Powers of ten that a person writes without an exponent."""
VECTOR_PARTS = ("x", "y", "z")


@dataclass(frozen=True, slots=True)
class Scale:
    """A value v of the contract is shown as (v - zero) * factor in `unit`."""

    factor: float
    unit: str
    zero: float = 0.0
    signed: bool = False

    def __call__(self, value: float) -> float:
        """The number shown."""
        return (value - self.zero) * self.factor


@dataclass(frozen=True, slots=True)
class Size:
    """A number with its interval as shown; low and high are NaN where no interval is known."""

    name: str
    value: float
    low: float
    high: float
    unit: str
    signed: bool = False

    @property
    def text(self) -> str:
        """'0.50 degrees (95 % interval 0.48 to 0.52)'."""
        interval = self.interval
        return f"{self.shown}{say('size.interval', interval=interval) if interval else ''}"

    @property
    def shown(self) -> str:
        """'0.50 degrees'; 'above 3000 N m/rad' where only a least size is known."""
        if math.isfinite(self.value):
            return f"{self._of(self.value)} {self.unit}".strip()
        if math.isnan(self.value):
            return say("size.not_known")
        if not math.isfinite(self.low):
            return say("size.any")
        low = number(self.low, significant(self.low), self.signed)
        return f"{say('size.above', low=low)} {self.unit}".strip()

    @property
    def interval(self) -> str:
        """'0.48 to 0.52'; empty where none is known."""
        if not math.isfinite(self.value) or math.isnan(self.low) or math.isnan(self.high):
            return ""
        low, high = self._of(self.low), self._of(self.high)
        return say("size.above", low=low) if math.isinf(self.high) else f"{low} to {high}"

    def _of(self, value: float) -> str:
        """One of its numbers, with as many decimals as the interval bears."""
        digits = decimals(self.value, self.low, self.high)
        return number(value, min(digits, FINEST_S) if self.unit == "s" else digits, self.signed)


_RATIOS: dict[str, Scale] = {
    "scale": Scale(100.0, "%", zero=1.0, signed=True),
    "strain": Scale(1e3, "mm per m"),
    "asymmetry": Scale(100.0, "%"),
    "damping": Scale(100.0, "% of critical"),
    "share": Scale(100.0, "%"),
    "build_up": Scale(100.0, "%"),
    "unloaded": Scale(100.0, "%"),
}
MOMENT = "at"
"""What a point in time is called, which is no duration."""
_SIGNED = frozenset(
    {"angle", "offset", "length_error", "rotation", "steps", "curvature", "strain", "mass"}
)


def in_its_units(say: Say) -> Say:
    """The same texts of an answer, its first argument, in the units of its recordings."""

    @functools.wraps(say)
    def said(answer: Diagnosis, *args: Any, **options: Any) -> Any:
        with said_in(answer.units.values()):
            return say(answer, *args, **options)

    return cast(Say, said)


def forced(unit: str) -> bool:
    """Whether the mismatch is one of efforts."""
    return unit in ("N", "N m")


def scale_of(unit: str, parameter: str = "", value: float = math.nan) -> Scale:
    """How a parameter of a unit of the contract is shown."""
    if unit in ("1", "") and parameter in _RATIOS:
        return _RATIOS[parameter]
    word, many = in_use(unit, value)
    return Scale(many, word, signed=parameter in _SIGNED)


def sizes(effect: str, parameter: str, result: ParameterResult) -> list[Size]:
    """A parameter as shown; a vector gives one size a component."""
    values = result.components
    name = _name(effect, parameter, result.unit)
    parts = VECTOR_PARTS if len(values) == len(VECTOR_PARTS) else ()
    found = []
    for k, (value, low, high) in enumerate(values):
        scale = Scale(1.0, "s") if name == MOMENT else scale_of(result.unit, parameter, value)
        low, high = sorted((scale(low), scale(high)))
        which = f" about {parts[k]}" if parts else f" ({k + 1})" if len(values) > 1 else ""
        found.append(Size(f"{name}{which}", scale(value), low, high, scale.unit, scale.signed))
    return found


def _name(effect: str, parameter: str, unit: str) -> str:
    """A parameter's name for people; on an axis that slides another."""
    own = card_of(effect).words.sizes.get(parameter, templates().get(f"parameter.{parameter}"))
    name = parameter.replace("_", " ") if own is None else own
    return templates().get(f"parameter_in.{parameter} {unit}", name)


def reported(parameters: Mapping[str, ParameterResult]) -> dict[str, ParameterResult]:
    """The first (the main one), and what is neither NOT_REPORTED nor shown as nothing."""
    first = next(iter(parameters), "")
    return {
        name: p
        for name, p in of_larger_wave(parameters).items()
        if name == first or (name not in NOT_REPORTED and not _is_nothing(p))
    }


def of_larger_wave(parameters: Mapping[str, ParameterResult]) -> Mapping[str, ParameterResult]:
    """With amplitude and period of the second harmonic, where that is the larger."""
    first, second = parameters.get("amplitude"), parameters.get("amplitude_2")
    if first is None or second is None or first.components[0][0] >= second.components[0][0]:
        return parameters
    period = parameters["period"]
    half, low, high = (0.5 * end for end in period.components[0])
    own = period.model_copy(update={"value": half, "ci95": [low, high]})
    return {**parameters, "amplitude": second, "period": own}


def _is_nothing(result: ParameterResult) -> bool:
    """A time that is shown as 0.000 ms."""
    return result.unit == "s" and all(round(1e3 * v, 3) == 0.0 for v, _, _ in result.components)


def quantity(value: float, unit: str, parameter: str = "", digits: int = 2) -> str:
    """A single value without interval, to `digits` significant digits."""
    if not math.isfinite(value):
        return say("size.not_known" if math.isnan(value) else "size.any")
    scale = scale_of(unit, parameter, value)
    shown = scale(value)
    return f"{number(shown, significant(shown, digits), scale.signed)} {scale.unit}".strip()


def unsigned(value: float, unit: str, parameter: str = "", digits: int = 2) -> str:
    """`quantity` without the plus sign."""
    return quantity(value, unit, parameter, digits).lstrip("+")


def number(value: float, digits: int, signed: bool = False) -> str:
    """With so many decimals (negative: rounded to tens), and + where asked."""
    if not math.isfinite(value):
        return "\u2013"
    text = f"{round(value, digits):.{max(digits, 0)}f}"
    small = round(value, digits) == 0.0 and digits < MOST_DECIMALS  # beside its interval
    if value and not small and math.floor(math.log10(abs(value))) not in EVERYDAY:
        text = f"{value:.3g}"
    if float(text) == 0.0:
        return text.lstrip("-")
    return f"+{text}" if signed and value > 0 else text


def significant(value: float, digits: int = 3) -> int:
    """Decimals that show so many significant digits."""
    if not math.isfinite(value) or value == 0.0:
        return digits
    return min(MOST_DECIMALS, digits - 1 - math.floor(math.log10(abs(value))))


def decimals(value: float, low: float, high: float) -> int:
    """Decimals at which the interval has two significant digits; three of the value without one."""
    half = (high - low) / 2.0
    known = math.isfinite(half) and half > 0.0
    wanted = significant(half, 2) if known else significant(value, 3)
    return max(min(wanted, significant(value, MOST_DIGITS)) if value else wanted, 0)


def covariate_unit(name: str, robot: RobotModel) -> str:
    """The unit in the name's brackets, or what the contract says of such a machine; empty for a
    covariate that the contract does not know.
    """
    if own := unit_of(name):
        return own
    if isinstance(robot, DeltaRobot):
        return numbered("unit.delta", name)
    linear = isinstance(robot, ServoAxis) and robot.motion == "linear"
    length = "m" if linear or isinstance(robot, RangeSensor) else "rad"
    text = templates().get(f"unit.axis.{name}", "")
    return text.format(length=length, load="N" if linear else "N m")


def with_units(answer: Diagnosis, robot: RobotModel) -> Diagnosis:
    """The same answer, whose tables say what their places and sizes are in."""
    findings = [_with_units(one, robot) for one in answer.findings]
    return answer.model_copy(update={"findings": findings})


def _with_units(finding: Finding, robot: RobotModel) -> Finding:
    table, size = finding.table, next(iter(finding.parameters.values()), None)
    if table is None or size is None:
        return finding
    follows = "s" if table.follows == "time" else covariate_unit(table.follows, robot)
    units = {"follows_unit": follows, "unit": size.unit}
    return finding.model_copy(update={"table": table.model_copy(update=units)})
