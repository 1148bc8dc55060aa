"""Effects, components and what a mismatch follows, in a mechanic's words."""

from __future__ import annotations

import re
from collections.abc import Sequence

from deltactl.foundation.printable import count as count
from deltactl.models.effects import CARDS, card_of

BEYOND = "{phrase} beyond what the robot file has"
"""Of what has no phrase of its own for being found again."""

PARTS: dict[str, str] = {
    "joints": "all joints",
    "arms": "the arms",
    "frame": "the frame",
    "platform": "the platform",
    "sensors": "the sensors",
    "sensor": "the sensor",
    "axis": "the axis",
    "time": "the time stamps",
}
"""Components that carry no number; the others are made by `part`."""

_MOTORS = ("motor1", "motor2", "motor3")

_FOLLOWED: tuple[tuple[str, str], ...] = (
    (r"theta_([123])", "the angle of arm {0}"),
    (r"(?:speed|velocity)_([123])", "the speed of motor {0}"),
    (r"(?:torque|load)_([123])", "the load on motor {0}"),
    (r"(?:acceleration|accel)_([123])", "the acceleration of motor {0}"),
    (r"direction_([123])", "the direction in which motor {0} turns"),
    (r"current_([123])", "the current of motor {0}"),
    (r"speed_range_([xyz])", "the speed of the platform along {0}"),
    (r"(?:range|pos|position)_([xyz])", "where the platform is along {0}"),
    (r"temp_c|temperature", "the temperature"),
    (r"range_x, range_y", "how far the platform is from the middle"),
    (r"t_pwm", "the step period"),
    (r"time|t", "the time since the start"),
    (r"position|angle", "the position"),
    (r"speed|velocity", "the speed"),
    (r"direction", "the direction of motion"),
    (r"acceleration", "the acceleration"),
    (r"effort|torque|force", "the effort"),
    (r"load", "the load"),
    (r"distance|range", "the distance"),
    (r"command", "the command"),
)


def part(component: str) -> str:
    """`motor2` -> 'motor 2', `range_x` -> 'the x sensor'; unknown names as they are."""
    if component in PARTS:
        return PARTS[component]
    if found := re.fullmatch(r"(motor|arm|joint)([123])", component):
        return f"{found[1]} {found[2]}"
    if found := re.fullmatch(r"range_([xyz])", component):
        return f"the {found[1]} sensor"
    return component.replace("_", " ") or "an unknown place"


def part_of(effect: str, component: str, follows: Sequence[str] = ()) -> str:
    """A component as the place of an effect: a range sensor alone is no axis.

    follows: what an unknown error follows; the distance only where there is nothing but a sensor.
    """
    if component != "axis":
        return part(component)
    own = card_of(effect).words.axis_part
    return own or (PARTS["sensor"] if "distance" in follows else part(component))


def parts(components: Sequence[str]) -> str:
    """Several components: 'motors 1, 2 and 3', 'the x and y sensors'; all joints are all motors."""
    if {"joints", *_MOTORS} <= set(components):
        components = [name for name in components if name not in _MOTORS]
    if len(components) == 1:
        return part(components[0])
    stems = {re.sub(r"[123xyz]$", "", name) for name in components}
    lasts = listed([name[-1] for name in components])
    if stems in ({"motor"}, {"arm"}):
        return f"{stems.pop()}s {lasts}"
    return f"the {lasts} sensors" if stems == {"range_"} else listed([part(c) for c in components])


def effect(name: str, *components: str) -> str:
    """What is wrong and where, as a noun phrase: 'free play in the gear or coupling of motor 2'."""
    where = part_of(name, components[0]) if len(components) == 1 else parts(components)
    return _phrase(name, components, where)


def further(name: str, *components: str) -> str:
    """An effect on top of what the robot file has of it."""
    if own := card_of(name).words.further:
        where = part_of(name, components[0]) if len(components) == 1 else parts(components)
        return own.format(part=where)
    return BEYOND.format(phrase=effect(name, *components))


def of_effort(name: str, component: str) -> str:
    """An effect of an axis that is driven by effort, and of which no command was recorded."""
    own = card_of(name).words.effort
    return own.format(part=part(component)) if own else effect(name, component)


def unknown(component: str, follows: Sequence[str]) -> str:
    """An error without a name, by its place and by what it follows."""
    name = _phrase("unknown", [component], part_of("unknown", component, follows))
    return f"{name} that follows {listed([followed(one) for one in follows])}" if follows else name


def _phrase(name: str, components: Sequence[str], where: str) -> str:
    of = card_of(name).words
    own = of.axis if list(components) == ["axis"] else of.several if len(components) > 1 else ""
    return (own or of.noun or f"{name.replace('_', ' ')} at {{part}}").format(part=where)


def rival(finding: str, other: str, component: str) -> str:
    """An alternative to an effect, said as what it is when it looks like that effect."""
    phrase = effect(other, component)
    known = card_of(finding).confusion(other)
    called = known.called if known is not None else ""
    return called.format(phrase=phrase, part=part(component)) if called else phrase


def followed(covariate: str) -> str:
    """A quantity that a mismatch follows: 'theta_2' -> 'the angle of arm 2'."""
    name = bare(covariate)
    for pattern, text in _FOLLOWED:
        if found := re.fullmatch(pattern, name):
            return text.format(*found.groups())
    return name.replace("_", " ")


def spelled(text: str) -> str:
    """A sentence with effects and components as people write them: 'motor2' -> 'motor 2'."""
    text = re.sub(_named_effect(), lambda found: effect(found[1], found[2]), text)
    text = re.sub(r"(?<=\bfollows )\w+|(?<=\bwith )\w+", _driver_in_text, text)
    text = re.sub(r"\b(motor|arm)([123])\b", r"\1 \2", text)
    return re.sub(r"\b(?:the )?range_([xyz])\b", r"the \1 sensor", text)


def _named_effect() -> str:
    """Pattern of 'gear_backlash motor2', 'gear_backlash at motor2', 'gear_backlash@motor2'."""
    effects = "|".join(name for name, card in CARDS.items() if card.words.noun)
    places = rf"(?:motor|arm)[123]|range_[xyz]|{'|'.join(PARTS)}"
    return rf"\b({effects})\b\s*(?:@|:|/|\bat\b|\bof\b|\()?\s*\b({places})\b\)?"


def _driver_in_text(found: re.Match[str]) -> str:
    word = found[0]
    return followed(word) if re.search(r"_[123xyz]$", word) or word == "time" else word


def channel(name: str) -> str:
    """An observation column: 'range_y' -> 'distance y', 'theta_1' -> 'measured angle 1'."""
    stem, _, which = name.partition("_")
    known = {"range": "distance", "pos": "position", "theta": "measured angle"}
    if stem in known and which:
        return f"{known[stem]} {which}"
    if name == "range":
        return "reported distance"
    return name.replace("_", " ")


def bare(covariate: str) -> str:
    """A covariate's name without its unit: 'theta_1 [rad]' -> 'theta_1'."""
    return re.sub(r"\s*[\[(][^\])]*[\])]\s*$", "", covariate).strip()


def listed(items: Sequence[str], word: str = "and") -> str:
    """'a', 'a and b', 'a, b and c'."""
    if len(items) < 2:
        return "".join(items)
    return f"{', '.join(items[:-1])} {word} {items[-1]}"


def sentence(text: str) -> str:
    """With a capital first and a full stop last."""
    text = text.strip()
    if not text:
        return ""
    text = text[0].upper() + text[1:]
    return text if text[-1] in ".!?" else f"{text}."
