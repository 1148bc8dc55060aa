"""The corrected robot file: the previous one with the effects that were found."""

from __future__ import annotations

import math
import os
from datetime import date
from pathlib import Path
from typing import Any

from deltactl.diagnosis.answer.finding import IN_ALL
from deltactl.diagnosis.answer.how_sure import sized
from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.answer.records import Alternative, Diagnosis, Finding
from deltactl.diagnosis.answer.tables import Tables, table_of
from deltactl.diagnosis.answer.verdict import differs_with_speed
from deltactl.foundation.plain_file import said_of_output, write_whole
from deltactl.foundation.strict_yaml import Document
from deltactl.models.effects import VOCABULARY, Port, Trait, has
from deltactl.models.effects.chain_joints import chain_effects
from deltactl.models.effects.kind import MOTORS
from deltactl.models.effects.lone_axis import COMPONENT, forms_of
from deltactl.models.effects_section import with_effects, with_model
from deltactl.models.merged_effects import merged
from deltactl.models.robot import DeltaRobot, EffectEntry, FoundBy, ServoAxis
from deltactl.models.robot_files import with_effects_in

MOVED = (Port.MOTOR, Port.GEAR, Port.ARM, Port.LINKAGE)
"""Where an effect is in the robot, and not in what sees it."""


def corrected_text(
    robot_file: Path | Document,
    diagnosis: Diagnosis,
    all_of_them: bool = False,
    tables: Tables = Tables.NONE,
) -> str:
    """The robot file with every lasting, sure finding of a known size in its `effects` section.

    What is found again is one entry with the size that both amount to, and says where it comes
    from. Comments outside the section are kept. One-off events (lost steps, stale readings) and
    unknown model errors are no property of the robot: left out. all_of_them: ties and improbable
    findings as well. tables: what has no name as well, as the table it is.
    """
    document = robot_file if isinstance(robot_file, Document) else Document.read(robot_file)
    robot = with_effects_in(document)
    found = [_entry(finding, diagnosis) for finding in kept(diagnosis, all_of_them)]
    if isinstance(robot, DeltaRobot):
        found += _tables(robot, diagnosis, tables)
    if not found:
        return document.text
    slides = isinstance(robot, ServoAxis) and robot.motion == "linear"
    return with_effects(document.text, merged(robot.effects, found), slides)


def _tables(robot: DeltaRobot, diagnosis: Diagnosis, asked: Tables) -> list[EffectEntry]:
    entries = []
    for finding in diagnosis.findings:
        if finding.effect == "unknown":
            entry = table_of(finding, robot, asked)
            if isinstance(entry, EffectEntry):
                found = _origin(finding, diagnosis, {})
                entries.append(entry.model_copy(update={"found": found}))
    return entries


def save_corrected(
    robot_file: Path,
    diagnosis: Diagnosis,
    out: Path,
    all_of_them: bool = False,
    replace: bool = False,
) -> None:
    """Write the corrected robot file; `replace`: over one that is there.

    Raises RecordingError when it exists or cannot be written.
    """
    text = corrected_text(robot_file, diagnosis, all_of_them)
    model = Document.read(robot_file).data.get("model")
    if isinstance(model, str) and out.resolve().parent != robot_file.resolve().parent:
        there = os.path.relpath(robot_file.resolve().parent / model, out.resolve().parent)
        text = with_model(text, Path(there).as_posix())
    with said_of_output(out, fresh=True):
        write_whole(out, text, fresh=not replace)


def kept(diagnosis: Diagnosis, all_of_them: bool) -> list[Finding]:
    """The findings that a corrected robot file holds."""
    lasting = (one for one in diagnosis.findings if lasts(one) and sized(one))
    return [one for one in lasting if all_of_them or sure(one, diagnosis)]


def lasts(finding: Finding) -> bool:
    """Whether a robot file can describe it, and it will last until the next run."""
    names, known = finding.parameters.keys() - {IN_ALL}, VOCABULARY.get(finding.effect)
    forms = [known] if known is not None else []
    if finding.component == COMPONENT:
        forms = forms_of(finding.effect)
    elif known is None or finding.component not in known.components:  # a joint of a chain
        kinds = chain_effects({finding.component: False}, finding.component)
        forms = [kinds[finding.effect]] if finding.effect in kinds else []
    # A servo delta's friction is a torque here and a width there: only what the file can say.
    return any(
        not kind.event and names <= {parameter.name for parameter in kind.parameters}
        for kind in forms
    )


def sure_of_correction(finding: Finding) -> float:
    """Probability of it or of what calls for the same correction."""
    alike = corrected_alike(finding)
    return (finding.probability or 0.0) + sum(one.probability or 0.0 for one in alike)


def corrected_alike(finding: Finding) -> list[Alternative]:
    """What may be the cause instead and calls for the same correction."""
    moves = finding.component != COMPONENT and _moves(finding.effect)
    return [one for one in finding.alternatives if moves and _moves(one.effect)]


def sure(finding: Finding, diagnosis: Diagnosis) -> bool:
    """Whether it is clear what to correct.

    An alternative that moves the robot as well as the finding does, as far as the recording goes,
    asks for the same correction there: play that hangs on one flank and another home, a late drive
    and viscous friction, soft joints and a load. So its probability counts for the finding, and it
    alone does not keep it out. One in the sensors would have nothing corrected. A single axis or
    sensor is not moved by its file, which says what the next diagnosis takes for known: there the
    cause itself must be sure.
    """
    if not sized(finding):
        return False
    constant = has(finding.effect, Trait.CONSTANT_FORCE)
    if constant and differs_with_speed(finding, diagnosis.findings):
        return False
    others = [one for one in finding.alternatives if one.effect != "unknown"]
    alike = corrected_alike(finding)
    if len(alike) == len(others) and _stands_beside_unknowns(finding, diagnosis):
        return True
    if finding.probability is None:
        return len(alike) == len(others)
    return sure_of_correction(finding) >= VERDICT.sure_enough


def _stands_beside_unknowns(finding: Finding, diagnosis: Diagnosis) -> bool:
    """Whether what is unknown, which lowers its probability, cannot be what imitates it.

    And what was left out of the fit is foretold better.
    """
    unknown = [one for one in diagnosis.findings if one.effect == "unknown"]
    fit = diagnosis.fit
    return (
        bool(unknown)
        and _moves(finding.effect)
        and not any(_may_imitate(one, finding) for one in unknown)
        and fit.holdout_rms_after_m < fit.holdout_rms_before_m
    )


def _may_imitate(unknown: Finding, finding: Finding) -> bool:
    """One at a joint moves the arms too, and asks for the same correction unless it is the larger.

    One in a sensor moves nothing: the finding must show most in another sensor.
    """
    if unknown.component in MOTORS:
        return finding.evidence.delta_chi2 <= unknown.evidence.delta_chi2
    if unknown.component in unknown.where.axes:
        return unknown.component in finding.where.axes[:1]
    return True


def _moves(effect: str) -> bool:
    kind = VOCABULARY.get(effect)
    return kind is not None and kind.port in MOVED


def _entry(finding: Finding, diagnosis: Diagnosis) -> EffectEntry:
    given = finding.parameters.items()
    sizes = {n: one for n, one in given if one.value is not None and n != IN_ALL}
    values: dict[str, Any] = {n: _fixed(one.value) for n, one in sizes.items()}
    intervals: dict[str, Any] = {
        n: _fixed(one.ci95)
        for n, one in sizes.items()
        if all(math.isfinite(low) and math.isfinite(high) for _, low, high in one.components)
    }
    return EffectEntry(
        effect=finding.effect,
        component=finding.component,
        parameters=values,
        found=_origin(finding, diagnosis, intervals),
    )


def _origin(finding: Finding, diagnosis: Diagnosis, intervals: dict[str, Any]) -> FoundBy:
    return FoundBy(
        recordings=tuple(Path(name).name for name in diagnosis.recordings),
        on=date.today().isoformat(),
        ci95=intervals,
        spread={n: tuple(row) for n, row in finding.spread.items() if n in intervals},
        probability=finding.probability,
        loosely_built=diagnosis.loosely_built,
    )


def _fixed(value: Any) -> Any:
    """Lists as tuples, for frozen records."""
    return tuple(_fixed(one) for one in value) if isinstance(value, list) else value
