"""What an answer rests on: the robot file, small errors allowed for, and what could not be seen."""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.answer.how_sure import unsure
from deltactl.diagnosis.answer.records import (
    AllowedFor,
    Diagnosis,
    Known,
    NotTestable,
    SmallestDetectable,
)
from deltactl.diagnosis.answer.what_is_left import alarm_case
from deltactl.diagnosis.report.names import (
    by_noise,
    effect,
    further,
    listed,
    of_effort,
    percent,
    upper,
)
from deltactl.diagnosis.report.pairs import allowed_beside_a_delay
from deltactl.diagnosis.report.sizes import departure, quantity, scale_of, unsigned
from deltactl.diagnosis.report.templates import say
from deltactl.models.effects import Trait, with_trait
from deltactl.models.effects.lone_axis import COMPONENT
from deltactl.models.robot import RobotModel


def false_alarm(diagnosis: Diagnosis) -> str:
    """How surely the robot file is complete; empty where the headline says as much."""
    case, nothing = alarm_case(diagnosis), diagnosis.probability_nothing_missing
    if not case:
        return ""
    if case == "not_computed":
        return say("alarm.not_computed")
    return say(
        f"alarm.{case}",
        by_noise=by_noise(diagnosis.false_alarm_p),
        complete=upper(percent(nothing or 0.0)),
        incomplete=upper(percent(1.0 - (nothing or 0.0))),
        few=say("evidence.few_readings"),
    )


def of_the_file(diagnosis: Diagnosis) -> list[str]:
    """How surely the robot file is complete, and what is taken as known from it."""
    return [line for line in (false_alarm(diagnosis), known_line(diagnosis)) if line]


def known_line(diagnosis: Diagnosis) -> str:
    """What was found before, how sure it was, and whether in the same recordings; else empty."""
    known = diagnosis.known
    if not known:
        return ""
    delta = any(one.component != COMPONENT for one in known)
    small = delta and not diagnosis.loosely_built and diagnosis.verdict == "nothing_missing"
    lines = [
        say("known.taken", names=_named(known)),
        _no_proof(known, len(diagnosis.recordings)),
        _not_sure(known),
        say("known.small_errors") if small else "",
    ]
    return " ".join(filter(None, lines))


def _no_proof(known: Sequence[Known], recordings: int) -> str:
    """Of what was found in these very recordings: that it proves nothing here; else empty."""
    here = [one for one in known if one.from_these_recordings]
    if not here:
        return ""
    which = "some_" if len(here) < len(known) else ""
    many = len(here) > 1
    return say(
        "known.no_proof",
        start=say(f"known.{which}{'were' if many else 'was'}", names=_named(here)),
        this=say("known.these" if recordings > 1 else "known.this"),
        fits=say("known.they_fit" if many else "known.it_fits"),
    )


def _not_sure(known: Sequence[Known]) -> str:
    """Of what was not certain when it was found: how sure it was; else empty."""
    each = [
        say("known.each", sure=percent(one.probability or 0.0), name=_named([one]))
        for one in known
        if unsure(one.probability)
    ]
    case = "known.not_sure" if len(known) == 1 else "known.not_sure_several"
    return say(case, each=listed(each)) if each else ""


def _named(known: Sequence[Known | NotTestable]) -> str:
    """By effect, its places together."""
    return listed([effect(name, *dict.fromkeys(places)) for name, places in _places(known).items()])


def _places(several: Sequence[Known | NotTestable]) -> dict[str, list[str]]:
    """Effect -> components, in the order in which they come."""
    places: dict[str, list[str]] = {}
    for one in several:
        places.setdefault(one.effect, []).append(one.component)
    return places


def allowed_line(diagnosis: Diagnosis) -> str:
    """What was allowed for, with the sizes that the recording shows; empty where nothing was."""
    if not diagnosis.loosely_built:
        return ""
    hidden = {one.effect for one in diagnosis.not_testable} >= {*with_trait(Trait.LENGTH)}
    what = say("allowed.angles" if hidden else "allowed.lengths")
    lines = [say("allowed.beside" if diagnosis.findings else "allowed.again", what=what)]
    if diagnosis.allowed_for:
        lines.append(say("allowed.clear", sizes=_each(diagnosis.allowed_for)))
    if large := [one for one in diagnosis.allowed_for if one.times_usual > 1.0]:
        lines.append(say("allowed.large", sizes=_each(large, usual=True)))
    if allowed_beside_a_delay(diagnosis):
        lines.append(say("allowed.beside_a_delay"))
    return " ".join(lines)


def _each(allowed: Sequence[AllowedFor], usual: bool = False) -> str:
    """By effect: 'wrong home angles of motors 1 and 2 (+0.031 and +0.43 degrees)'."""
    effects = dict.fromkeys(one.effect for one in allowed)
    same = [[one for one in allowed if one.effect == name] for name in effects]
    return "; ".join(_of_one_effect(some, usual) for some in same)


def _of_one_effect(same: Sequence[AllowedFor], usual: bool) -> str:
    same = sorted(same, key=lambda one: one.component)
    what = effect(same[0].effect, *(one.component for one in same))
    (name, result), *_ = same[0].parameters.items()
    scale = scale_of(result.unit, name)
    sizes = listed([_size(one) for one in same]).replace(f" {scale.unit}", "", len(same) - 1)
    most = unsigned(scale.zero + same[0].usual, result.unit, name)
    return say("allowed.usual" if usual else "allowed.each", what=what, sizes=sizes, most=most)


def _size(one: AllowedFor) -> str:
    """Its first parameter; a vector's components with spaces between."""
    (name, result), *_ = one.parameters.items()
    sizes = [quantity(value, result.unit, name) for value, _, _ in result.components]
    return sizes[0] if len(sizes) == 1 else f"({', '.join(sizes)})"


def limit_name(name: str, components: Sequence[str], robot: RobotModel | None, force: bool) -> str:
    """What has a detection limit; on top of what the robot file has of it.

    force: of a machine whose efforts were recorded.
    """
    if all(in_file(robot, name, one) for one in components):
        return further(name, *components)
    if force and list(components) == [COMPONENT]:
        return of_effort(name, COMPONENT)
    return effect(name, *components)


def limit_size(one: SmallestDetectable, robot: RobotModel | None) -> str:
    """A detection limit as a size; for a scale the departure from 1, whichever of both is given;
    what yields beyond the file is a second spring behind it.
    """
    size = limit_alone(one)
    second = in_file(robot, one.effect, one.component)
    case = {"scale": "scale", "stiffness": "second_spring" if second else "softer"}
    return say(f"limits.size_{case.get(one.parameter, 'plain')}", size=size)


def limit_alone(one: SmallestDetectable) -> str:
    """The number and unit of a detection limit."""
    zero = scale_of(one.unit, one.parameter).zero
    return quantity(zero + above_nothing(one), one.unit, one.parameter).lstrip("+-")


def in_file(robot: RobotModel | None, name: str, component: str) -> bool:
    """Whether the robot file has this effect already."""
    known = robot.effects if robot is not None else ()
    return any((one.effect, one.component) == (name, component) for one in known)


def above_nothing(one: SmallestDetectable) -> float:
    """How far a detection limit is from nothing."""
    return departure(one.value, one.unit, one.parameter)
