"""What to do about one finding: a line of `advice` with its sizes, and what to rule out first."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Finding
from deltactl.diagnosis.answer.verdict import NAMELESS
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.percent import percent
from deltactl.diagnosis.report.phrases.sizes import LEAST_S, number, quantity, scale_of, significant
from deltactl.diagnosis.report.phrases.sureness import (
    after_its_effort,
    late_in_all_s,
    likelier,
    settled,
)
from deltactl.diagnosis.report.sentences.advice import advice, machine_of
from deltactl.diagnosis.report.sentences.telling_apart import LONE
from deltactl.diagnosis.report.sentences.ways import TERMINAL, Ways
from deltactl.models.effects import VOCABULARY, Trait, card_of, has
from deltactl.models.robot import DeltaRobot, RobotModel, per_arm

_ARM = re.compile(r"(?:arm|motor)([123])")


@dataclass(frozen=True, slots=True)
class Remedy:
    """What to do, and whether something else should be ruled out first."""

    says: str
    unsure: str

    @property
    def line(self) -> str:
        """As one sentence."""
        return words.sentence(self.says + self.unsure)


def tied(finding: Finding) -> bool:
    """Whether it could as well be something else, by this recording."""
    return bool(finding.alternatives) and not settled(finding)


def remedy(
    finding: Finding,
    robot: RobotModel | None,
    certain: bool = True,
    ways: Ways = TERMINAL,
    beside: bool = False,
) -> Remedy | None:
    """What to do about one finding; None where nobody can say.

    certain: it is written into a robot file without being asked for. beside: what was found
    with it asks for another remedy, as play does that may have moved a zero.
    """
    if not finding.parameters or finding.effect == NAMELESS:
        return None
    name = _main(finding)
    result = finding.parameters[name]
    largest = max((value for value, _, _ in result.components), key=abs)
    departure = scale_of(result.unit, name, largest)(largest)
    machine = machine_of(robot, finding.component, finding.effect)
    row = "beside" if beside else "dead" if _mostly_dead(finding) else name
    row = "effort" if after_its_effort(finding) else row
    text = advice(machine, finding.effect, row, _as_share(name, largest))
    if text is None:
        return None
    shown = _late(finding) or quantity(largest, result.unit, name, 3).lstrip("+-")
    says = text.format(
        part=words.part_of(finding.effect, finding.component),
        size=shown,
        true=_true(finding, robot, largest) or f"{shown} otherwise",
        factor=_factor(largest),
        sign=_Sign(departure),
    )
    if (
        has(finding.effect, Trait.ENTERED)
        and finding.component != LONE
        and (certain or ways.unsure_too)
    ):
        says += ways.describe.format(all="" if certain else " --all")
    return Remedy(says, _first_rule_out(finding, certain))


def _first_rule_out(finding: Finding, certain: bool) -> str:
    """What else it could be, to be ruled out before anything is done; empty where nothing.

    certain: the corrected file holds it, whichever of them it is.
    """
    likely = finding.alternatives if tied(finding) else []
    nameless = [one for one in likely if one.effect == NAMELESS]
    likely = [one for one in likely if one.effect != NAMELESS]
    others = [words.rival(finding.effect, o.effect, o.component) for o in likely]
    sure_of = finding.probability
    only = "" if sure_of is None else f"this is only {percent(sure_of)} sure, so "
    if (rival := likelier(finding)) is not None:
        name = words.rival(finding.effect, rival.effect, rival.component)
        return (
            f"; but {only}first rule out {name}, which looks the same here and is more probable"
            f" ({percent(rival.probability or 0.0)})"
        )
    if others and sure_of is not None and certain:
        return _though(finding, others)
    if others and nameless:
        many = len(others) + len(nameless)
        return f"; but {only}first rule out {many} others that look the same here (below)"
    if len(likely) == 1 and has(likely[0].effect, Trait.UNDER_LOAD) and sure_of is not None:
        return (
            f"; this is only {percent(sure_of)} sure: if it changes with the load, the cause is"
            f" {others[0]}"
        )
    if len(others) > 1:
        return f"; but {only}first rule out {len(others)} others that look the same here (below)"
    if others:
        return f"; but {only}first rule out {others[0]}, which looks the same here"
    if nameless:
        what = words.rival(finding.effect, NAMELESS, nameless[0].component)
        if what != words.effect(NAMELESS, nameless[0].component):
            return f"; but {only}first rule out {what}, which looks the same here"
        return f"; but {only}it may as well be a part of something that no list has"
    return ""


def _though(finding: Finding, others: Sequence[str]) -> str:
    """What looks the same beside a finding that is corrected in the file all the same."""
    same = others[0] if len(others) == 1 else f"{len(others)} others (below)"
    own = finding.probability or 0.0
    if own < VERDICT.sure_enough:
        return (
            f"; a corrected robot file is right for either, but rule out {same} before you change"
            " the machine"
        )
    return f"; this is {percent(own)} sure: {same} would look the same here"


class _Sign(float):
    """A number whose format is two words: for above nothing, and for below."""

    def __format__(self, words: str) -> str:
        above, below = words.split("|")
        return below if self < 0.0 else above


def _main(finding: Finding) -> str:
    """The parameter that is its size: of a wave the amplitude, whichever comes first."""
    known = VOCABULARY.get(finding.effect)
    if known is not None and known.main.name in finding.parameters:
        return known.main.name
    return next(iter(finding.parameters))


def _as_share(name: str, value: float) -> float:
    """How far a size is from nothing, in the contract's unit."""
    return value - 1.0 if name == "scale" else value


def _factor(scale: float) -> str:
    """A scale with three digits of its departure from one."""
    return number(scale, max(significant(scale - 1.0, 3), 0))


def _mostly_dead(finding: Finding) -> bool:
    """Whether most of a delay is a dead time, which no gain shortens, and both are known."""
    if not has(finding.effect, Trait.DRIVE_DELAY) or late_in_all_s(finding) is not None:
        return False
    times = _times_s(finding)
    return times.get("dead_time", 0.0) > times.get("time", 0.0)


def _times_s(finding: Finding) -> dict[str, float]:
    """Its times, by parameter."""
    return {n: p.components[0][0] for n, p in finding.parameters.items() if p.unit == "s"}


def _late(finding: Finding) -> str:
    """Dead time and time constant, those that there are; empty where nothing is late.

    Their sum alone where nothing more is known.
    """
    if not has(finding.effect, Trait.DRIVE_DELAY):
        return ""
    if (late_s := late_in_all_s(finding)) is not None:
        return f"{quantity(late_s, 's', digits=3)} in all"
    times = _times_s(finding)
    said = {"dead_time": "a dead time of {}", "time": "a time constant of {}"}
    parts = [
        text.format(quantity(times[name], "s", name, 3))
        for name, text in said.items()
        if abs(times.get(name, 0.0)) >= LEAST_S
    ]
    return " and ".join(parts)


def _true(finding: Finding, robot: RobotModel | None, error: float) -> str:
    """The robot file's length with what was found added; empty where it has none."""
    card, arm = card_of(finding.effect), _ARM.fullmatch(finding.component)
    if not isinstance(robot, DeltaRobot) or not card.length:
        return ""
    if arm is None and card.kind is not None and len(card.kind.components) > 1:
        return ""
    lengths = per_arm(getattr(robot.geometry, card.length))
    nominal_m = float(lengths[int(arm[1]) - 1 if arm is not None else 0])
    return f"{1e3 * (nominal_m + error):.1f} mm (not {1e3 * nominal_m:.1f} mm)"
