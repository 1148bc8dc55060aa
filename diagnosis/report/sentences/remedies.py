"""What to do about a finding, for the person with the spanner: a line of `advice`, filled in."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from diagnosis.answer.corrected_robot import sure
from diagnosis.answer.options import VERDICT
from diagnosis.answer.records import Diagnosis, Finding
from diagnosis.answer.verdict import NAMELESS, claimed, fits_worse
from diagnosis.report.phrases import words
from diagnosis.report.phrases.percent import percent
from diagnosis.report.phrases.sizes import LEAST_S, number, quantity, scale_of, significant
from diagnosis.report.phrases.sureness import late_in_all_s, likelier, settled
from diagnosis.report.sentences.advice import advice, machine_of
from diagnosis.report.sentences.telling_apart import LONE, beside_friction
from diagnosis.report.sentences.ways import TERMINAL, Ways
from models.effects import VOCABULARY
from models.effects.lone_axis import forms_of
from models.robot import DeltaRobot, RobotModel, per_arm

CHANGE_NOTHING = (
    "Change nothing yet: with what was found the mismatch as a whole is no smaller. Record a longer"
    " run, with more reversals and places, and diagnose both together."
)

TOGETHER = (
    "Make these corrections together: each was found beside the others, and one alone makes some"
    " distances worse."
)
ALONG = (
    "Make the corrections of its zero and of its ratio together: each was found beside the other,"
    " and one alone makes some places worse."
)
OF_DISTANCE = frozenset({"sensor_offset", "sensor_scale", "sensor_crosstalk"})
LEAST_FOR_A_TABLE = 0.02
"""Share of the mismatch below which, beside named causes, nobody is asked to enter a table."""

MAPPED = {
    "axis": (
        "Find out whose the error is that follows the position: move what measures the axis a"
        " little (or the surface it looks at) and record again. What moves along is the measuring"
        " device's. What stays is the axis': have its controller subtract a table of {points}"
        " points, one every {step} ({way}), and hold it against a further recording."
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

WRITABLE = frozenset({
    "home_offset", "transmission_error", "upper_arm_length", "forearm_length", "motor_azimuth",
    "base_radius", "frame_tilt", "inertia", "joint_friction", "viscous_friction", "gear_ratio",
})  # fmt: skip
MINOR_SHARE = 0.01
"""Of the mismatch: what does less is told last, as `finding_words` calls its part small."""
YIELDS = "joint_compliance"
"""A cause that a look at the same place with another load rules out."""
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


def remedies(
    diagnosis: Diagnosis, robot: RobotModel | None = None, ways: Ways = TERMINAL
) -> list[str]:
    """One sentence for each finding that can be remedied, the surest and largest first, what does
    hardly anything last.

    Before them, where causes are tied, the run that would tell them apart. None where the fit as a
    whole is no better for what was found.
    """
    named = [one for one in diagnosis.findings if claimed(one)]
    if named and fits_worse(diagnosis.fit):
        return [CHANGE_NOTHING]
    late = [one for one in named if one.effect == "following_lag" and not tied(one)]
    late = late if len(late) > 1 else []
    named = sorted(named, key=lambda one: (_minor(one), tied(one) and not sure(one, diagnosis)))
    found = (remedy(one, robot, sure(one, diagnosis), ways) for one in named if one not in late)
    lines = [_all_late(late, robot)] if late else []
    lines += [one.line for one in found if one is not None]
    lone = [one for one in named if one.component == LONE and _has_an_entry(one)]
    certain = all(sure(one, diagnosis) for one in lone)
    if lone and ways.keep and (certain or ways.unsure_too):
        lines.append(ways.keep.format(all="" if certain else " --all"))
    nameless = [one for one in diagnosis.findings if one.effect == NAMELESS]
    nameless = [one for one in nameless if not (named and _needs_no_table(one))]
    lines += [
        line for one in nameless if (line := mapped(one, ways) or unnamed(one, robot, diagnosis))
    ]
    if sum(map(_of_distance, diagnosis.findings)) > 1:
        lines.append(TOGETHER)
    if {"home_offset", "gear_ratio"} <= {one.effect for one in named if one.component == LONE}:
        lines.append(ALONG)
    plan = diagnosis.next_experiment
    if lines and plan is not None and any(tied(one) for one in named):
        lines.insert(0, ways.run_first)
    return list(dict.fromkeys(lines))


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
    machine = machine_of(robot, late[0].component, "following_lag")
    text = advice(machine, "following_lag.several", "", 0.0) or ""
    part = words.parts([one.component for one in late])
    return words.sentence(text.format(part=part, size=size))


def _of_distance(finding: Finding) -> bool:
    """Whether it corrects what a lone sensor reads, by its distance."""
    if finding.component not in MAPPED:
        return False
    return finding.effect in OF_DISTANCE or finding.depends_on == ["distance"]


def _needs_no_table(finding: Finding) -> bool:
    """Whether all that is known of it is a table of next to nothing."""
    return finding.table is not None and finding.share_of_mismatch < LEAST_FOR_A_TABLE


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
    sizes = list(finding.parameters.values())
    if driver == "position" and sizes and sizes[0].unit in ("N", "N m"):
        driver = "position.force"
    if beside_friction(finding, diagnosis.findings):
        driver = "direction.beside"
    machine = machine_of(robot, finding.component, finding.effect)
    text = advice(machine, finding.effect, driver, 0.0)
    follows = words.listed([words.followed(name) for name in finding.depends_on])
    part = words.part_of(finding.effect, finding.component, finding.depends_on)
    size = quantity(sizes[0].components[0][0], sizes[0].unit, digits=2) if sizes else ""
    return words.sentence(text.format(part=part, follows=follows, size=size)) if text else ""


def tied(finding: Finding) -> bool:
    """Whether it could as well be something else, by this recording."""
    return bool(finding.alternatives) and not settled(finding)


def remedy(
    finding: Finding, robot: RobotModel | None, certain: bool = True, ways: Ways = TERMINAL
) -> Remedy | None:
    """What to do about one finding; None where nobody can say.

    certain: it is written into a robot file without being asked for.
    """
    if not finding.parameters or finding.effect == NAMELESS:
        return None
    name = _main(finding)
    result = finding.parameters[name]
    largest = max((value for value, _, _ in result.components), key=abs)
    departure = scale_of(result.unit, name, largest)(largest)
    machine = machine_of(robot, finding.component, finding.effect)
    text = advice(machine, finding.effect, name, _as_share(name, largest))
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
    if finding.effect in WRITABLE and finding.component != LONE and (certain or ways.unsure_too):
        says += ways.describe.format(all="" if certain else " --all")
    return Remedy(says, _first_rule_out(finding, certain))


def _first_rule_out(finding: Finding, certain: bool) -> str:
    """What else it could be, to be ruled out before anything is done; empty where nothing.

    certain: the corrected file holds it, whichever of them it is.
    """
    likely = finding.alternatives if tied(finding) else []
    nameless = any(one.effect == NAMELESS for one in likely)
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
    if len(likely) == 1 and likely[0].effect == YIELDS and sure_of is not None:
        return (
            f"; this is only {percent(sure_of)} sure: if it changes with the load, the cause is"
            f" {others[0]}"
        )
    if len(others) > 1:
        return f"; but {only}first rule out {len(others)} others that look the same here (below)"
    if others:
        return f"; but {only}first rule out {others[0]}, which looks the same here"
    if nameless:
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


def _late(finding: Finding) -> str:
    """Dead time and time constant, those that there are; empty where nothing is late.

    Their sum alone where nothing more is known.
    """
    if finding.effect != "following_lag":
        return ""
    if (late_s := late_in_all_s(finding)) is not None:
        return f"{quantity(late_s, 's', digits=3)} in all"
    times = {n: p.components[0][0] for n, p in finding.parameters.items() if p.unit == "s"}
    said = {"dead_time": "a dead time of {}", "time": "a time constant of {}"}
    parts = [
        text.format(quantity(times[name], "s", name, 3))
        for name, text in said.items()
        if abs(times.get(name, 0.0)) >= LEAST_S
    ]
    return " and ".join(parts)


def _true(finding: Finding, robot: RobotModel | None, error: float) -> str:
    """The robot file's length with what was found added; empty where it has none."""
    if not isinstance(robot, DeltaRobot):
        return ""
    geometry = robot.geometry
    arm = _ARM.fullmatch(finding.component)
    lengths = {
        "upper_arm_length": per_arm(geometry.upper_arm_m),
        "forearm_length": per_arm(geometry.forearm_m),
        "base_radius": geometry.radius_m,
    }.get(finding.effect)
    if lengths is None or (arm is None and finding.effect != "base_radius"):
        return ""
    nominal_m = float(lengths[int(arm[1]) - 1 if arm is not None else 0])
    return f"{1e3 * (nominal_m + error):.1f} mm (not {1e3 * nominal_m:.1f} mm)"
