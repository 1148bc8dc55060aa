"""What a recording could not show, and the detection limits, in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from deltactl.diagnosis.answer.records import Diagnosis, NotTestable, SmallestDetectable
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.sizes import departure, quantity, scale_of
from deltactl.models.robot import RobotModel

LIMITS = (
    "Detection limits (sizes at which 4 of 5 recordings show that something is missing; naming it "
    "may take more)"
)
MOST_NAMED = 4
"""Effects that a sentence names; the rest are counted."""


def untested_lines(diagnosis: Diagnosis) -> Iterator[str]:
    """What could not have been seen, and what could be only in place of a finding."""
    named = {
        (one.effect, one.component) for found in diagnosis.findings for one in found.alternatives
    }
    rivals = [one for one in diagnosis.not_testable if (one.effect, one.component) in named]
    others = [one for one in diagnosis.not_testable if (one.effect, one.component) not in named]
    if others:
        yield _not_shown(others, "")
    if rivals:
        yield _not_shown(rivals, " other than in place of what was found")


def _not_shown(untested: Sequence[NotTestable], but: str) -> str:
    grouped: dict[str, list[str]] = {}
    for one in untested:
        grouped.setdefault(one.effect, []).append(one.component)
    names = [words.effect(effect, *components) for effect, components in grouped.items()]
    reasons = {one.why for one in untested}
    why = f": {reasons.pop()}" if len(reasons) == 1 else ""
    return words.sentence(f"this recording could not show {_some(names)}{but}{why}")


def faintest_line(diagnosis: Diagnosis, robot: RobotModel | None = None) -> str:
    """A few of the detection limits: those of the findings first.

    robot: of whose effects more is meant.
    """
    wanted = [finding.effect for finding in diagnosis.findings]
    order = sorted(diagnosis.smallest_detectable, key=lambda one: one.effect not in wanted)
    alike: dict[tuple[str, str], list[SmallestDetectable]] = {}
    for one in order:
        alike.setdefault((one.effect, one.parameter), []).append(one)
    forced = by_effort(diagnosis)
    shown = [
        _largest(same, robot, forced)
        for same in alike.values()
        if not _found_below(same, diagnosis)
    ]
    return f"{LIMITS}: {words.listed(shown[:MOST_NAMED])}." if shown else ""


def by_effort(diagnosis: Diagnosis) -> bool:
    """Whether what was recorded is an effort, and no command."""
    return diagnosis.fit.unit in ("N", "N m")


def _largest(same: Sequence[SmallestDetectable], robot: RobotModel | None, forced: bool) -> str:
    """One effect at all its components, with the largest of their limits."""
    most = max(same, key=_above_nothing)
    one = limit_name(most.effect, [other.component for other in same], robot, forced)
    return f"{one} ({'at most ' if len(same) > 1 else ''}{limit_size(most, robot)})"


def limit_name(
    effect: str, components: Sequence[str], robot: RobotModel | None, forced: bool
) -> str:
    """What has a detection limit; on top of what the robot file has of it.

    forced: of a machine whose efforts were recorded.
    """
    known = all(_has(robot, effect, one) for one in components)
    if known:
        return words.further(effect, *components)
    if forced and list(components) == ["axis"]:
        return words.of_effort(effect, "axis")
    return words.effect(effect, *components)


def limit_size(one: SmallestDetectable, robot: RobotModel | None) -> str:
    """A detection limit as a size; what yields beyond the file is a second spring behind it."""
    size = smallest_text(one.value, one.unit, one.parameter)
    second = one.parameter == "stiffness" and _has(robot, one.effect, one.component)
    return f"as a second spring {size} would" if second else size


def _has(robot: RobotModel | None, effect: str, component: str) -> bool:
    known = robot.effects if robot is not None else ()
    return any((one.effect, one.component) == (effect, component) for one in known)


def _above_nothing(one: SmallestDetectable) -> float:
    return departure(one.value, one.unit, one.parameter)


def _found_below(same: Sequence[SmallestDetectable], diagnosis: Diagnosis) -> bool:
    """Whether less of it was found already, by several joints that err together."""
    limits = {(one.effect, one.component, one.parameter): _above_nothing(one) for one in same}
    return any(
        departure(result.value, result.unit, name)
        < limits.get((finding.effect, finding.component, name), 0.0)
        for finding in diagnosis.findings
        for name, result in finding.parameters.items()
        if isinstance(result.value, float)
    )


def smallest_text(value: float, unit: str, parameter: str) -> str:
    """A detection limit; for a scale the departure from 1, whichever of both is given."""
    zero = scale_of(unit, parameter).zero
    size = quantity(zero + departure(value, unit, parameter), unit, parameter).lstrip("+-")
    if parameter == "scale":
        return f"{size} off what the robot file says"
    return f"softer than {size}" if parameter == "stiffness" else size


def _some(names: Sequence[str]) -> str:
    shown = list(names[:MOST_NAMED])
    if len(names) > len(shown):
        more = len(names) - len(shown)
        kinds = "kind" if more == 1 else "kinds"
        shown.append(f"{more} more {kinds} of effect (see the report)")
    return words.listed(shown, "or")
