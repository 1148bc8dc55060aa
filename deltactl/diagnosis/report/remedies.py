"""What to do about all that was found, for the person with the spanner, in the order to do it.

The lines are those of the effects' cards, by the kind of machine. A machine's own lines come before
those that hold for all. `{part}` is the component in words, `{size}` the main size without its
sign, `{factor}` a scale as it is, `{true}` what the robot file's own value becomes, `{follows}`
what an unknown follows; `{sign:a|b}` is a where the main size is above nothing and b where it is
below. Rows are `small` (below the card's `small`), the name of the main parameter, of an unknown
what it follows (and `.force` where it is one); `beside` where friction or play is found too that
may be the cause.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from deltactl.diagnosis.answer.corrected_robot import sure
from deltactl.diagnosis.answer.how_sure import (
    act_on,
    after_its_effort,
    late_in_all,
    minor,
    mostly_dead,
    sized,
    tied,
    times_s,
    worth_a_table,
)
from deltactl.diagnosis.answer.picture import bare
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.verdict import NAMELESS, claimed, fits_worse
from deltactl.diagnosis.answer.what_is_left import moves_at_rest
from deltactl.diagnosis.report.names import all_followed, listed, numbers, part_of, parts, sentence
from deltactl.diagnosis.report.next_run import measured
from deltactl.diagnosis.report.pairs import (
    late_drives,
    other_remedy,
    play_that_moved,
    together,
    uneven,
)
from deltactl.diagnosis.report.sizes import (
    forced,
    number,
    of_larger_wave,
    quantity,
    scale_of,
    significant,
    unsigned,
)
from deltactl.diagnosis.report.templates import TERMINAL, Signed, Ways, say, templates
from deltactl.models.effects import VOCABULARY, Trait, card_of, has
from deltactl.models.effects.lone_axis import COMPONENT, forms_of
from deltactl.models.robot import DeltaRobot, RobotModel, ServoAxis, kind, per_arm

LAYERS: dict[str, tuple[str, ...]] = {
    "delta": (),
    "servo_delta": ("servo_drive",),
    "stepper_axis": ("axis",),
    "servo_axis": ("servo_axis", "axis", "servo_drive"),
    "slide": ("slide", "axis", "servo_drive"),
    "range_sensor": ("sensor",),
    "chain": ("chain", "servo_axis", "servo_drive"),
}
"""Layers of remedies by machine and drive, the nearest first. Belts and screws are a slide's,
whatever motor turns them: the file of an axis does not say which."""


def remedies(
    diagnosis: Diagnosis, robot: RobotModel | None = None, ways: Ways = TERMINAL
) -> list[str]:
    """One sentence for each finding that can be remedied, the surest and largest first, what does
    hardly anything last, a zero that play may have moved after the play.

    Before them a unit that is in doubt and, where causes are tied, what distinguishes them: steps
    are in the order in which to take them. One line where the fit as a whole is no better for what
    was found.
    """
    named = [one for one in diagnosis.findings if claimed(one)]
    if named and fits_worse(diagnosis.fit):
        return [say("do.change_nothing")]
    unconfirmed = [one for one in named if act_on(one, sure(one, diagnosis)) == "if_confirmed"]
    lines = [
        *_named(named, unconfirmed, diagnosis, robot, ways),
        *_kept(named, diagnosis, ways),
        *_unnamed(named, diagnosis, robot, ways),
    ]
    lines[:0] = together(diagnosis.findings) if any(lines) else ()
    if moves_at_rest(diagnosis.fit) and all(one.component == COMPONENT for one in named):
        lines.append(say("do.record_the_load"))
    if lines and diagnosis.next_experiment is not None and any(map(tied, named)):
        lines.insert(0, say("do.run_first", job=ways.job))
    elif lines:
        lines[:0] = _distinguished(unconfirmed, diagnosis, ways)
    if diagnosis.doubts:
        lines.insert(0, say("do.give_the_unit"))
    return list(dict.fromkeys(filter(None, lines)))


def _named(
    named: Sequence[Finding],
    unconfirmed: Sequence[Finding],
    diagnosis: Diagnosis,
    robot: RobotModel | None,
    ways: Ways,
) -> Iterator[str]:
    """A line for each of those with a name, and one for all drives that follow late."""
    if late := late_drives(named):
        times = [quantity(sum(times_s(one).values()), "s", digits=3) for one in late]
        yield _filled(late, robot, "several", size=listed(times))
    known = [one for one in named if one not in late and sized(one)]
    for finding in _in_order(known, diagnosis):
        beside = other_remedy(finding, diagnosis)
        line = remedy(finding, robot, sure(finding, diagnosis), beside)
        if line and finding in unconfirmed:
            number = diagnosis.findings.index(finding) + 1
            case = "do.if_confirmed" if number <= ways.rows else "do.if_confirmed_there"
            line = say(case, number=number, do=f"{line[:1].lower()}{line[1:]}")
        yield line


def _distinguished(
    unconfirmed: Sequence[Finding], diagnosis: Diagnosis, ways: Ways
) -> Iterator[str]:
    """A line for each measurement that distinguishes causes of findings to confirm."""
    by_way: dict[str, dict[int, str]] = {}
    for k, finding in enumerate(diagnosis.findings, 1):
        if finding in unconfirmed and (way := measured(finding, diagnosis, ways)):
            by_way.setdefault(way, {})[k] = f"{k}"
    for way, named in by_way.items():
        yield say("do.tell_apart", which=numbers(named, ways.rows, "finding"), way=way)


def _kept(named: Sequence[Finding], diagnosis: Diagnosis, ways: Ways) -> Iterator[str]:
    """How what is not repaired is entered in the robot file."""
    kept = [one for one in named if _has_an_entry(one)]
    save = ways.save if all(sure(one, diagnosis) for one in kept) else ways.save_all
    if kept and ways.save and save:
        yield say("do.keep", save=save)


def _has_an_entry(finding: Finding) -> bool:
    """Whether a robot file can hold it where it is not repaired."""
    if finding.component != COMPONENT:
        return has(finding.effect, Trait.ENTERED)
    return any(not kind.event for kind in forms_of(finding.effect))


def _unnamed(
    named: Sequence[Finding], diagnosis: Diagnosis, robot: RobotModel | None, ways: Ways
) -> Iterator[str]:
    """A line for each of those without a name of which something is worth doing."""
    for finding in diagnosis.findings:
        if finding.effect == NAMELESS and worth_a_table(finding, diagnosis, bool(named)):
            table = _mapped(finding, ways)
            first = say("do.correct_first") if table and named else ""
            yield f"{table}{first}" or _unknown(finding, robot, diagnosis)


def _in_order(named: Sequence[Finding], diagnosis: Diagnosis) -> list[Finding]:
    """What scales others first, what hardly matters last; a zero behind the play that moved it."""

    def last(one: Finding) -> tuple[bool, ...]:
        unsure = tied(one) and not sure(one, diagnosis)
        return minor(one), unsure, not has(one.effect, Trait.SCALES_FORCES)

    ordered = sorted(named, key=last)
    for zero in tuple(ordered):
        play = play_that_moved(zero, ordered)
        if play is not None and ordered.index(zero) < ordered.index(play):
            ordered.remove(zero)
            ordered.insert(ordered.index(play) + 1, zero)
    return ordered


def machine_of(robot: RobotModel | None, component: str, name: str) -> str:
    """The key of LAYERS for a robot; without one, the place of the finding."""
    if isinstance(robot, DeltaRobot):
        servo = robot.drive is not None and kind(robot.drive) == "servo"
        return "servo_delta" if servo else "delta"
    if isinstance(robot, ServoAxis) and robot.motion == "linear":
        return "slide"
    if robot is not None:
        return robot.kind
    if component != COMPONENT:
        return "delta"
    return "range_sensor" if has(name, Trait.READING) else "servo_axis"


def advice(machine: str, name: str, parameter: str, size: float) -> str | None:
    """The line of a machine for an effect of which the main parameter is so far from nothing."""
    card = card_of(name)
    small = ("small",) if abs(size) < card.small else ()
    return card.remedy(LAYERS[machine], (*small, parameter, ""))


def _filled(
    findings: Sequence[Finding],
    robot: RobotModel | None,
    row: str,
    share: float = 0.0,
    **values: object,
) -> str:
    """The line of their card in this row, filled in; empty where there is none."""
    first = findings[0]
    text = advice(machine_of(robot, first.component, first.effect), first.effect, row, share)
    where = part_of(first.effect, first.component, first.depends_on)
    where = where if len(findings) == 1 else parts([one.component for one in findings])
    follows = all_followed(first.depends_on)
    return sentence((text or "").format(part=where, follows=follows, **values))


def remedy(
    finding: Finding,
    robot: RobotModel | None,
    certain: bool = True,
    beside: bool = False,
) -> str:
    """What to do about one finding; empty where nobody can say.

    certain: it is written into a robot file without being asked for. beside: what was found
    with it asks for another remedy, as play does that may have moved a zero.
    """
    if not finding.parameters or finding.effect == NAMELESS:
        return ""
    name = main_of(finding)
    result = of_larger_wave(finding.parameters)[name]
    largest = max((value for value, _, _ in result.components), key=abs)
    row = "beside" if beside else "dead" if mostly_dead(finding) else name
    shown = _late(finding) or quantity(largest, result.unit, name, 3).lstrip("+-")
    line = _filled(
        [finding],
        robot,
        "effort" if after_its_effort(finding) else row,
        largest - 1.0 if name == "scale" else largest,
        size=shown,
        true=_true(finding, robot, largest) or say("do.otherwise", size=shown),
        factor=number(largest, max(significant(largest - 1.0, 3), 0)),
        sign=Signed(scale_of(result.unit, name, largest)(largest)),
    )
    either = line and act_on(finding, certain) == "whichever"
    return f"{line} {say('do.right_for_either')}" if either else line


def main_of(finding: Finding) -> str:
    """The parameter that is its size: of a wave the amplitude, whichever comes first."""
    known = VOCABULARY.get(finding.effect)
    if known is not None and known.main.name in finding.parameters:
        return known.main.name
    return next(iter(finding.parameters))


def _late(finding: Finding) -> str:
    """Dead time and time constant, those that there are; empty where nothing is late.

    Their sum alone where nothing more is known.
    """
    if not has(finding.effect, Trait.DRIVE_DELAY):
        return ""
    if (late := late_in_all(finding)) is not None:
        return say("late.in_all", size=quantity(late.components[0][0], "s", digits=3))
    times = times_s(finding)
    return " and ".join(
        say(f"late.{name}", size=quantity(times[name], "s", name, 3))
        for name in ("dead_time", "time")
        if round(1e6 * times.get(name, 0.0))
    )


def _true(finding: Finding, robot: RobotModel | None, error: float) -> str:
    """The robot file's length with what was found added; empty where it has none."""
    card, component = card_of(finding.effect), finding.component
    if not isinstance(robot, DeltaRobot) or not card.length:
        return ""
    arm = component[:-1] in ("arm", "motor")
    if not arm and card.kind is not None and len(card.kind.components) > 1:
        return ""
    lengths = per_arm(getattr(robot.geometry, card.length))
    nominal_m = float(lengths[int(component[-1]) - 1 if arm else 0])
    return say("do.true_length", true=1e3 * (nominal_m + error), nominal=1e3 * nominal_m)


def _mapped(finding: Finding, ways: Ways) -> str:
    """What to do about an unknown that follows the place of an axis, or the distance of a target.

    Empty where no table of it can be subtracted: of a delta, whose file takes tables; of a force.
    """
    table, size = finding.table, next(iter(finding.parameters.values()), None)
    if finding.component not in (COMPONENT, "sensor") or table is None or size is None:
        return ""
    if size.unit not in ("m", "rad"):
        return ""
    where = "sensor" if table.follows == "distance" else finding.component
    points = len(table.size)
    step = unsigned((table.highest - table.lowest) / (points - 1), size.unit)
    return say(f"table.{where}", points=points, step=step, way=ways.table, unit=size.unit)


def _unknown(finding: Finding, robot: RobotModel | None, diagnosis: Diagnosis) -> str:
    """What would explain an unknown, or makes it smaller; empty where no row says."""
    size = next(iter(finding.parameters.values()), None)
    if not finding.depends_on or size is None:
        return ""
    driver = _driver(bare(finding.depends_on[0]))
    if driver == "position" and forced(size.unit):
        driver = "position.force"
    if uneven(finding, diagnosis.findings, () if robot is None else robot.effects):
        driver = "direction.beside"
    shown = quantity(size.components[0][0], size.unit, digits=2)
    return _filled([finding], robot, driver, size=shown)


def _driver(follows: str) -> str:
    """What an unknown follows, as the rows of the cards call it: 'speed_range_x' is a speed."""
    stem, _, last = follows.rpartition("_")
    name = stem.removesuffix("_range") if stem and last in (*"123", *"xyz") else follows
    return templates().get(f"driver.{name}", name)
