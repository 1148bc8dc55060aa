"""What to do about all that was found, for the person with the spanner, in the order to do it."""

from __future__ import annotations

import re
from collections.abc import Sequence

from deltactl.diagnosis.answer.corrected_robot import sure
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.verdict import NAMELESS, claimed, differs_with_speed, fits_worse
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.left_words import moves_at_rest
from deltactl.diagnosis.report.phrases.sizes import quantity
from deltactl.diagnosis.report.sentences.advice import advice, machine_of
from deltactl.diagnosis.report.sentences.beside_others import (
    beside_play,
    slowed_by_its_loop,
)
from deltactl.diagnosis.report.sentences.notes import changes_its_pace, too_few_periods
from deltactl.diagnosis.report.sentences.remedy import remedy, tied
from deltactl.diagnosis.report.sentences.telling_apart import LONE, beside_friction
from deltactl.diagnosis.report.sentences.ways import TERMINAL, Ways
from deltactl.models.effects import Trait, has
from deltactl.models.effects.lone_axis import forms_of
from deltactl.models.robot import RobotModel

CHANGE_NOTHING = (
    "Change nothing yet: with what was found the mismatch as a whole is no smaller. Record a longer"
    " run, with more reversals and places, and diagnose both together."
)

GIVE_THE_UNIT = "Give the right unit, as said above, and diagnose again."
UNIT_FIRST = f"{GIVE_THE_UNIT} All that follows is for the case that the unit is right."
RECORD_THE_LOAD = (
    "Find out what moves the axis while its command stands. Record what pulls at it as well (read"
    " as `load`), or record again with nothing that pulls, and diagnose that."
)

TOGETHER = (
    "Make these corrections together: each was found beside the others, and one alone makes some"
    " distances worse."
)
ALONG = (
    "Make the corrections of its zero and of its ratio together (where both are made to its"
    " commands, the zero first): each was found beside the other, and one alone makes some places"
    " worse."
)
CORRECT_FIRST = (
    " Make the corrections above first and diagnose a new recording: the table to subtract is the"
    " one that is found then."
)
LEAST_FOR_A_TABLE = 0.02
"""Share of the mismatch below which, beside named causes, nobody is asked to enter a table."""

LEAST_HELP = 1.1
"""Times the mismatch that is left, below which without a table it would be as good."""
MAPPED = {
    "axis": (
        "Find out whose the error is that follows the position: move what measures the axis a"
        " little (or the surface it looks at) and record again. What moves along is the measuring"
        " device's. What stays is the axis': have its controller subtract a table of {points}"
        " points, one every {step} of the commanded position ({way}), and hold it against a"
        " further recording."
    ),
    "sensor": (
        "Subtract a table of {points} points from what the sensor reads, one every {step} of"
        " distance ({way}), and hold it against a further recording: reflections of another room"
        " are others."
    ),
}
"""By component, of an unknown with a table."""

_DRIVERS = {
    "theta": "position", "pos": "position", "range": "position", "angle": "position",
    "distance": "position", "velocity": "speed", "t": "time", "torque": "effort",
    "force": "effort", "current": "effort",
}  # fmt: skip
"""Names of what an unknown follows, as the rows of `advice` call them."""

MINOR_SHARE = 0.01
"""Of the mismatch: what does less is told last, as `finding_words` calls its part small."""


def remedies(
    diagnosis: Diagnosis, robot: RobotModel | None = None, ways: Ways = TERMINAL
) -> list[str]:
    """One sentence for each finding that can be remedied, the surest and largest first, what does
    hardly anything last, a zero that play may have moved after the play.

    Before them a unit that is in doubt and, where causes are tied, the run that would tell them
    apart. None where the fit as a
    whole is no better for what was found.
    """
    named = [one for one in diagnosis.findings if claimed(one)]
    if named and fits_worse(diagnosis.fit):
        return [CHANGE_NOTHING]
    late = [one for one in named if has(one.effect, Trait.DRIVE_DELAY) and not tied(one)]
    late = late if len(late) > 1 else []
    named = _in_order(named, diagnosis)
    found = (
        remedy(one, robot, sure(one, diagnosis), ways, _beside(one, diagnosis))
        for one in named
        if one not in late
    )
    lines = [_all_late(late, robot)] if late else []
    lines += [one.line for one in found if one is not None]
    lone = [one for one in named if one.component == LONE and _has_an_entry(one)]
    certain = all(sure(one, diagnosis) for one in lone)
    if lone and ways.keep and (certain or ways.unsure_too):
        lines.append(ways.keep.format(all="" if certain else " --all"))
    nameless = [one for one in diagnosis.findings if one.effect == NAMELESS]
    nameless = [one for one in nameless if not (named and _needs_no_table(one))]
    nameless = [one for one in nameless if not _hardly_helps(one, diagnosis)]
    beside = CORRECT_FIRST if named else ""
    for one in nameless:
        table = mapped(one, ways)
        lines += filter(None, [f"{table}{beside}" if table else unnamed(one, robot, diagnosis)])
    if moves_at_rest(diagnosis.fit) and not any(one.component != LONE for one in named):
        lines.append(RECORD_THE_LOAD)
    if sum(map(_of_distance, diagnosis.findings)) > 1:
        lines.append(TOGETHER)
    of_axis = [one.effect for one in named if one.component == LONE]
    if all(any(has(one, trait) for one in of_axis) for trait in (Trait.ZERO, Trait.RATIO)):
        lines.append(ALONG)
    plan = diagnosis.next_experiment
    if lines and plan is not None and any(tied(one) for one in named):
        lines.insert(0, ways.run_first)
    if diagnosis.doubts:
        lines.insert(0, UNIT_FIRST if lines else GIVE_THE_UNIT)
    return list(dict.fromkeys(lines))


def _beside(finding: Finding, diagnosis: Diagnosis) -> bool:
    """Whether what was found beside it asks for another remedy."""
    findings = diagnosis.findings
    if beside_play(finding, findings) is not None:
        return True
    if has(finding.effect, Trait.DRIVE_DELAY):
        return slowed_by_its_loop(finding, findings)
    return has(finding.effect, Trait.CONSTANT_FORCE) and differs_with_speed(finding, findings) > 0


def _in_order(named: Sequence[Finding], diagnosis: Diagnosis) -> list[Finding]:
    """What hardly matters last, before it what is unsure; a zero behind the play that moved it."""
    ordered = sorted(named, key=lambda one: (_minor(one), tied(one) and not sure(one, diagnosis)))
    for home in tuple(ordered):
        play = beside_play(home, ordered)
        if play is not None and ordered.index(home) < ordered.index(play):
            ordered.remove(home)
            ordered.insert(ordered.index(play) + 1, home)
    return ordered


def _minor(finding: Finding) -> bool:
    """Whether the mismatch would hardly change without it, nor is much of it its doing."""
    own = finding.own_share
    return own is not None and max(own, finding.share_of_mismatch) < MINOR_SHARE


def _has_an_entry(finding: Finding) -> bool:
    """Whether the robot file of a lone machine can hold it."""
    return any(not kind.event for kind in forms_of(finding.effect))


def _all_late(late: Sequence[Finding], robot: RobotModel | None) -> str:
    """One line for drives that all follow late: how much each is late in all."""
    totals = [
        sum(p.components[0][0] for p in one.parameters.values() if p.unit == "s") for one in late
    ]
    *first, last = (quantity(total, "s", digits=3) for total in totals)
    unit = last.partition(" ")[2]
    size = words.listed([*(one.removesuffix(f" {unit}") for one in first), last])
    machine = machine_of(robot, late[0].component, late[0].effect)
    text = advice(machine, late[0].effect, "several", 0.0) or ""
    part = words.parts([one.component for one in late])
    return words.sentence(text.format(part=part, size=size))


def _of_distance(finding: Finding) -> bool:
    """Whether it corrects what a lone sensor reads, by its distance."""
    if finding.component not in MAPPED:
        return False
    return has(finding.effect, Trait.BY_DISTANCE) or finding.depends_on == ["distance"]


def _needs_no_table(finding: Finding) -> bool:
    """Whether all that is known of it is a table of next to nothing."""
    return finding.table is not None and finding.share_of_mismatch < LEAST_FOR_A_TABLE


def _hardly_helps(finding: Finding, diagnosis: Diagnosis) -> bool:
    """Whether what a table of it would take away is hardly any of what is left."""
    without_m = finding.left_without_m
    if finding.table is None or without_m is None:
        return False
    return without_m < LEAST_HELP * diagnosis.fit.rms_after_m


def mapped(finding: Finding, ways: Ways = TERMINAL) -> str | None:
    """What to do about an unknown that follows the place of an axis, or the distance of a target.

    None where no table of it can be subtracted: of a delta, whose file takes tables; of a force.
    """
    table, size = finding.table, next(iter(finding.parameters.values()), None)
    if finding.component not in MAPPED or table is None or size is None:
        return None
    if finding.effect != "unknown" or size.unit not in ("m", "rad"):
        return None
    where = "sensor" if table.follows == "distance" else finding.component
    points = len(table.size)
    step = quantity((table.highest - table.lowest) / (points - 1), size.unit, digits=2)
    return MAPPED[where].format(
        points=points, step=step.lstrip("+"), way=ways.table.format(unit=size.unit)
    )


def unnamed(finding: Finding, robot: RobotModel | None, diagnosis: Diagnosis) -> str:
    """What tells more of an unknown, or makes it smaller; empty where no row says."""
    if not finding.depends_on:
        return ""
    stem = re.sub(r"_(?:range_)?[123xyz]$", "", words.bare(finding.depends_on[0]))
    driver = _DRIVERS.get(stem, stem)
    driver = "few_periods" if too_few_periods(finding, diagnosis.picture) else driver
    driver = "time.pace" if changes_its_pace(finding, diagnosis.picture) else driver
    sizes = list(finding.parameters.values())
    if driver == "position" and sizes and sizes[0].unit in ("N", "N m"):
        driver = "position.force"
    known = () if robot is None else robot.effects
    if beside_friction(finding, diagnosis.findings, known):
        driver = "direction.beside"
    machine = machine_of(robot, finding.component, finding.effect)
    text = advice(machine, finding.effect, driver, 0.0)
    follows = words.listed([words.followed(name) for name in finding.depends_on])
    part = words.part_of(finding.effect, finding.component, finding.depends_on)
    size = quantity(sizes[0].components[0][0], sizes[0].unit, digits=2) if sizes else ""
    return words.sentence(text.format(part=part, follows=follows, size=size)) if text else ""
