"""Effects, components and what a mismatch follows, in a mechanic's words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from deltactl.diagnosis.answer.how_sure import after_its_effort
from deltactl.diagnosis.answer.picture import bare
from deltactl.diagnosis.answer.records import Finding
from deltactl.diagnosis.report.templates import numbered, say, templates
from deltactl.foundation.printable import count as count
from deltactl.models.effects import card_of
from deltactl.models.effects.kind import MOTORS
from deltactl.models.effects.lone_axis import COMPONENT


def part(component: str) -> str:
    """`motor2` -> 'motor 2', `range_x` -> 'the x sensor'; unknown names as they are."""
    name = component.rstrip("0123456789")
    plain = f"{name.replace('_', ' ').rstrip()} {component[len(name) :]}".strip()
    return numbered("part", component) or plain or say("part.unknown")


def part_of(effect: str, component: str, follows: Sequence[str] = ()) -> str:
    """A component as the place of an effect: a range sensor alone is no axis.

    follows: what an unknown error follows; the distance only where there is nothing but a sensor.
    """
    if component != COMPONENT:
        return part(component)
    own = card_of(effect).words.axis_part
    return own or part("sensor" if "distance" in follows else component)


def parts(components: Sequence[str]) -> str:
    """Several components: 'motors 1, 2 and 3', 'the x and y sensors'; all joints are all motors."""
    if {"joints", *MOTORS} <= set(components):
        components = [name for name in components if name not in MOTORS]
    if len(components) == 1:
        return part(components[0])
    lasts = listed([name[-1] for name in components])
    stems = {name[:-1] if name[-1:] in "123xyz" else name for name in components}
    together = templates().get(f"parts.{stems.pop()}") if len(stems) == 1 else None
    return together.format(lasts) if together else listed(_counting_on(components))


def _counting_on(components: Sequence[str]) -> list[str]:
    """Their names; of three and more with consecutive numbers the first and the last."""
    stem = components[0].rstrip("0123456789")
    ends = [name.removeprefix(stem) for name in components]
    if len(ends) > 2 and all(map(str.isdecimal, ends)):
        first, last = min(ends, key=int), max(ends, key=int)
        if int(last) - int(first) == len(ends) - 1:
            return [say("parts.from_to", first=part(stem + first), last=part(stem + last))]
    return [part(one) for one in components]


def effect(name: str, *components: str) -> str:
    """What is wrong and where, as a noun phrase: 'backlash in the gear or coupling of motor 2'."""
    return _phrase(name, components, _where(name, components))


def further(name: str, *components: str) -> str:
    """An effect on top of what the robot file has of it."""
    if own := card_of(name).words.further:
        return own.format(part=_where(name, components))
    return say("name.beyond", phrase=effect(name, *components))


def of_effort(name: str, component: str) -> str:
    """An effect of an axis that is driven by effort, and of which no command was recorded."""
    own = card_of(name).words.effort
    return own.format(part=part(component)) if own else effect(name, component)


def unknown(component: str, follows: Sequence[str]) -> str:
    """An error without a name: its place and what it follows."""
    name = _phrase("unknown", [component], part_of("unknown", component, follows))
    return say("name.follows", name=name, follows=all_followed(follows)) if follows else name


def called(finding: Finding) -> str:
    """A finding by the name of its effect."""
    phrase = of_effort if after_its_effort(finding) else effect
    return phrase(finding.effect, finding.component)


def _where(name: str, components: Sequence[str]) -> str:
    return part_of(name, components[0]) if len(components) == 1 else parts(components)


def _phrase(name: str, components: Sequence[str], where: str) -> str:
    words = card_of(name).words
    several = words.several if len(components) > 1 else ""
    return (several or words.of_one(name, list(components) == [COMPONENT])).format(part=where)


def other_cause(finding: str, other: str, component: str) -> str:
    """An alternative to an effect, called what it is when it looks like that effect."""
    phrase = effect(other, component)
    known = card_of(finding).confusion(other)
    own = known.called if known is not None else ""
    return own.format(phrase=phrase, part=part(component)) if own else phrase


def followed(covariate: str) -> str:
    """A quantity that a mismatch follows: 'theta_2' -> 'the angle of arm 2'."""
    name = bare(covariate)
    return numbered("follows", name) or name.replace("_", " ")


def all_followed(covariates: Sequence[str]) -> str:
    """Several of them; three directions or three arms of one quantity are that quantity."""
    stems = [name[:-1] for name in covariates]
    whole = {
        stem: templates().get(f"follows_all.{stem}")
        for stem in stems
        for ends in ("123", "xyz")
        if {f"{stem}{end}" for end in ends} <= set(covariates)
    }
    said = [whole.get(stem) or followed(name) for stem, name in zip(stems, covariates, strict=True)]
    return listed(list(dict.fromkeys(said)))


def spelled(name: str) -> str:
    """'gear_backlash motor2', as answers name an effect at a place, as people write it."""
    what, _, component = name.partition(" ")
    return effect(what, component) if card_of(what).words.noun else name


def channel(name: str) -> str:
    """An observation column: 'range_y' -> 'distance y', 'theta_1' -> 'measured angle 1'."""
    return numbered("channel", name) or name.replace("_", " ")


def listed(items: Sequence[str], word: str = "and") -> str:
    """'a', 'a and b', 'a, b and c'."""
    if len(items) < 2:
        return "".join(items)
    return f"{', '.join(items[:-1])} {word} {items[-1]}"


def numbers(named: Mapping[int, str], rows: float, noun: str = "") -> str:
    """Findings by number, as each is called; those without a row are counted. noun: goes before."""
    seen = [name for number, name in named.items() if number <= rows]
    unseen = len(named) - len(seen)
    if not seen:
        return say("screen.all_unseen", findings=count(unseen, "finding"))
    last = [say("screen.unseen", number=unseen)] * bool(unseen)
    return f"{noun}{'s' * (bool(noun) and len(named) > 1)} {listed([*seen, *last])}".lstrip()


def sentence(text: str) -> str:
    """With a capital first and a full stop last."""
    text = upper(text.strip())
    return text if not text or text[-1] in ".!?" else f"{text}."


def upper(text: str) -> str:
    """With a capital first."""
    return text[:1].upper() + text[1:]


def percent(probability: float) -> str:
    """A probability in percent, never 0 or 100: no engine knows its own mistakes better."""
    shown = f"{100.0 * min(probability, 1.0):.0f}"
    return say({"0": "percent.least", "100": "percent.most"}.get(shown, "percent.plain"), shown)


def by_noise(p: float) -> str:
    """A p value to one digit: 'p = 0.003'; no engine knows its own mistakes to the millionth."""
    shown = f"{round(p, 6):.1g}"
    return say("p.least") if shown == "0" else say("p.plain", p=shown)
