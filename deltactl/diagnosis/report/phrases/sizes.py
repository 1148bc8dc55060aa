"""Sizes in the units people use: degrees, mm, ms, %, with their intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from deltactl.diagnosis.answer.records import ParameterResult
from deltactl.models.effects import card_of

NOT_KNOWN = "not known"
NO_LIMIT = "any size"
DEG = math.degrees(1.0)
SMALL_S = 1.0
"""Times under a second are given in ms."""

UNTOLD = frozenset(
    {"phase", "amplitude_2", "phase_2", "start", "drag", "friction", "stiffness", "unloaded"}
)
"""Second parameters that mean nothing to a mechanic; the table of all numbers has them."""

FINEST_S = 2
"""Decimals of a time in s: sampling periods are hardly ever shorter than 10 ms."""

LEAST_S = 5e-7
"""A second parameter below it is not told: half a microsecond."""

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
        """'0.50 degrees (95 % sure between 0.48 and 0.52)'."""
        if math.isnan(self.value):
            return NOT_KNOWN
        digits = decimals(self.value, self.low, self.high)
        if self.unit == "s":
            digits = min(digits, FINEST_S)
        if math.isinf(self.value):
            above = number(self.low, significant(self.low), self.signed)
            return f"above {above} {self.unit}" if math.isfinite(self.low) else NO_LIMIT
        shown = f"{number(self.value, digits, self.signed)} {self.unit}".strip()
        if math.isnan(self.low) or math.isnan(self.high):
            return f"{shown} (no interval known)"
        low, high = (number(x, digits, self.signed) for x in (self.low, self.high))
        if math.isinf(self.high):
            return f"{shown} (95 % sure above {low})"
        return f"{shown} (95 % sure between {low} and {high})"


_PLAIN: dict[str, Scale] = {
    "rad": Scale(DEG, "degrees"),
    "rad/s": Scale(DEG, "degrees/s"),
    "m": Scale(1e3, "mm"),
    "m/s": Scale(1e3, "mm/s"),
    "kg m2": Scale(1.0, "kg m\u00b2"),
    "1/m": Scale(1e3, "mm per m\u00b2"),
    "": Scale(1.0, ""),
    "1": Scale(1.0, ""),
}
_RATIOS: dict[str, Scale] = {
    "scale": Scale(100.0, "%", zero=1.0, signed=True),
    "strain": Scale(1e3, "mm per m"),
    "asymmetry": Scale(100.0, "%"),
    "damping": Scale(100.0, "% of critical"),
    "share": Scale(100.0, "%"),
}
_NAMES: dict[str, str] = {
    "width": "whole play",
    "scale": "departure from the robot file",
    "dead_time": "dead time",
    "time_constant": "time constant",
    "length_error": "length, true minus robot file",
    "rotation": "turned",
    "steps": "steps short",
    "size_rms": "size, root mean square",
}
MOMENT = "at"
"""What a point in time is called, which is no duration."""
_SLIDING: dict[tuple[str, str], str] = {("angle", "m"): "offset", ("torque", "N"): "force"}
"""By parameter and unit, on an axis that slides."""
_SIGNED = frozenset({"angle", "offset", "length_error", "rotation", "steps", "curvature", "strain"})


def scale_of(unit: str, parameter: str = "", value: float = math.nan) -> Scale:
    """How a parameter of a unit of the contract is shown; small times become ms, small masses g."""
    if unit in ("1", "") and parameter in _RATIOS:
        return _RATIOS[parameter]
    small = math.isfinite(value) and abs(value) < SMALL_S
    if unit == "s":
        return Scale(1e3, "ms") if small else Scale(1.0, "s")
    if unit == "kg" and parameter == "mass":
        return Scale(1e3, "g", signed=True) if small else Scale(1.0, "kg", signed=True)
    plain = _PLAIN.get(unit, Scale(1.0, unit))
    return Scale(plain.factor, plain.unit, signed=parameter in _SIGNED)


def departure(value: float, unit: str, parameter: str) -> float:
    """How far a size is from nothing; the limit of a scale may be given as 1.003 or as 0.003."""
    zero = scale_of(unit, parameter).zero
    return abs(value - zero if value > 0.5 * zero else value)


def shown_name(effect: str, parameter: str) -> str:
    """A parameter's name for people."""
    own = card_of(effect).words.sizes.get(parameter)
    if own is not None:
        return own
    return _NAMES.get(parameter, parameter.replace("_", " "))


def sizes(effect: str, parameter: str, result: ParameterResult) -> list[Size]:
    """A parameter as shown; a vector gives one size a component."""
    values = result.components
    name = shown_name(effect, parameter)
    name = _SLIDING.get((parameter, result.unit), name)
    names = [name]
    if len(values) > 1:
        names = [f"{name} {_component(k, len(values))}" for k in range(len(values))]
    found = []
    for k, (value, low, high) in enumerate(values):
        moment = name == MOMENT
        scale = Scale(1.0, "s") if moment else scale_of(result.unit, parameter, value)
        low, high = sorted((scale(low), scale(high)))
        found.append(Size(names[k], scale(value), low, high, scale.unit, scale.signed))
    return found


def quantity(value: float, unit: str, parameter: str = "", digits: int = 2) -> str:
    """A single value without interval, to `digits` significant digits."""
    if math.isnan(value):
        return NOT_KNOWN
    if math.isinf(value):
        return NO_LIMIT
    scale = scale_of(unit, parameter, value)
    shown = scale(value)
    return f"{number(shown, significant(shown, digits), scale.signed)} {scale.unit}".strip()


def number(value: float, digits: int, signed: bool = False) -> str:
    """With so many decimals (negative: rounded to tens), and + where asked."""
    if not math.isfinite(value):
        return "\u2013"
    if abs(value) >= 1e6 or (value and abs(value) < 1e-5):
        text = f"{value:.3g}"
    else:
        text = f"{round(value, digits):.{max(digits, 0)}f}"
    if float(text) == 0.0:
        return text.lstrip("-")
    sign = "+" if signed and value > 0 else ""
    return sign + text


def significant(value: float, digits: int = 3) -> int:
    """Decimals that show so many significant digits."""
    if not math.isfinite(value) or value == 0.0:
        return digits
    return min(9, digits - 1 - math.floor(math.log10(abs(value))))


def decimals(value: float, low: float, high: float) -> int:
    """Decimals at which the interval has two significant digits; three of the value without one."""
    half = (high - low) / 2.0
    if math.isfinite(half) and half > 0.0:
        return min(9, max(significant(half, 2), 0))
    return max(significant(value, 3), 0)


def told(parameters: Mapping[str, ParameterResult]) -> dict[str, ParameterResult]:
    """The parameters to tell: the first (the main one), and what is not UNTOLD."""
    first = next(iter(parameters), "")
    return {
        name: p
        for name, p in parameters.items()
        if name == first or (name not in UNTOLD and not _is_nothing(p))
    }


def _is_nothing(result: ParameterResult) -> bool:
    """A time that would be shown as 0.000 ms."""
    return result.unit == "s" and all(abs(value) < LEAST_S for value, _, _ in result.components)


def _component(k: int, of: int) -> str:
    return f"about {VECTOR_PARTS[k]}" if of == len(VECTOR_PARTS) else f"({k + 1})"
