"""The vocabulary of single axes and sensors: the same operators on a component `axis`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal

from deltactl.models.effects import CARDS, card_of
from deltactl.models.effects.kind import EffectKind, Parameter
from deltactl.models.effects.units_in_use import said

Motion = Literal["linear", "rotary"]
COMPONENT, COMMAND = "axis", "command"
LINEAR_UNIT = {
    "rad": "m",
    "N m": "N",
    "kg m2": "kg",
    "N m s/rad": "N s/m",
    "N m/rad": "N/m",
    "rad/s": "m/s",
}
"""Linear axes use m, N, kg in place of rad, N m, kg m2 (contract)."""

FINEST = 1e-6
"""Shortest period [rad, m]: of a scale's grating, or of a motor's turns behind a high reduction."""


def _unit(unit: str, motion: Motion) -> str:
    return LINEAR_UNIT.get(unit, unit) if motion == "linear" else unit


def of_axis(kind: EffectKind, motion: Motion, machine: str = COMMAND) -> EffectKind:
    """A kind on the component `axis`, with the units of its motion and the machine's sentence."""
    texts = card_of(kind.name).says
    slides = texts.get("slide", "") if motion == "linear" else ""
    text = texts.get(machine) or slides or texts.get("", "")
    parameters = tuple(
        replace(p, unit=_unit(p.unit, motion), low=FINEST if p.name == "period" else p.low)
        for p in kind.parameters
    )
    return replace(
        kind,
        components=(COMPONENT,),
        parameters=parameters,
        says=lambda component, values: _sentence(kind, parameters, values, text),
    )


def _effects(machine: str, motion: Motion) -> dict[str, EffectKind]:
    own = ((name, card.on.get(machine)) for name, card in CARDS.items())
    return {name: of_axis(kind, motion, machine) for name, kind in own if kind is not None}


def command_effects(motion: Motion) -> dict[str, EffectKind]:
    """What can be wrong with an axis that follows a command."""
    return _effects(COMMAND, motion)


def effort_effects(motion: Motion) -> dict[str, EffectKind]:
    """What can be wrong with an axis that is driven by effort."""
    return _effects("effort", motion)


def sensor_effects() -> dict[str, EffectKind]:
    """What can be wrong with a range sensor by itself."""
    return _effects("range", "linear")


def forms_of(effect: str) -> list[EffectKind]:
    """What an effect can be on a single axis: friction is a torque beside effort, else a width."""
    return list(card_of(effect).on.values())


class _Sign(float):
    """A number whose format is two words: for above nothing, and for the rest."""

    def __format__(self, words: str) -> str:
        above, below = words.split("|")
        return above if self > 0.0 else below


def _sentence(
    kind: EffectKind, parameters: tuple[Parameter, ...], values: Mapping[str, Any], text: str
) -> str:
    """A card's text with its sizes: {size} is the main one without its sign, {sign:a|b} a or b."""
    if not text:
        return kind.says(card_of(kind.name).words.axis_part or COMPONENT, values)
    shown: dict[str, Any] = {
        p.name: said(float(values.get(p.name, p.default or 0.0)), p.unit) for p in parameters
    }
    main = parameters[0]
    if main.name in values:
        size = float(values[main.name])
        shown |= {"size": said(abs(size), main.unit), "sign": _Sign(size)}
    made = text.format(**shown)
    if "{dead_time}" not in text and float(values.get("dead_time", 0.0)):
        dead = f"a dead time of {shown['dead_time']}"
        made = f"{made} after {dead}" if float(values["time"]) else f"the axis follows after {dead}"
    if float(values.get("asymmetry", 0.0)):
        made += f", with an asymmetry of {values['asymmetry']:+.2f}"
    return made
