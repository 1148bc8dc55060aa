"""The summary of the diagnosis of a lone axis, in plain sentences."""

from __future__ import annotations

from collections.abc import Sequence

from diagnosis.answer.records import Finding, Fit, Unexplained
from diagnosis.lone_axes.axis_measure import telling_apart
from models.effects.lone_axis import said

MISSING = 0.01
ASYMMETRY = "joint_friction that is stronger one way"


def summary(findings: Sequence[Finding], fit: Fit, rest: Unexplained, p: float) -> list[str]:
    """Most important first."""
    if not findings and p > MISSING:
        lines = [f"Nothing is missing in the model (p = {p:.2g})."]
    elif not findings:
        lines = [f"Something is missing (p = {p:.2g}), and nothing could be proven. {rest.says}"]
    else:
        lines = [f"{number}. {_upper(f.says)}." for number, f in enumerate(findings, start=1)]
        lines += [_cannot_tell(f) for f in findings if f.alternatives]
        lines += telling_apart(findings)
    unit = fit.unit
    data = "on another recording" if fit.holdout == "run" else "on blocks that were held out"
    lines.append(
        f"Mismatch {said(fit.rms_before_m, unit)} before, {said(fit.rms_after_m, unit)} after, "
        f"noise floor {said(fit.noise_floor_m, unit)}; {data} "
        f"{said(fit.holdout_rms_before_m, unit)} before and "
        f"{said(fit.holdout_rms_after_m, unit)} after."
    )
    if findings and rest.depends_on:
        lines.append(rest.says)
    return lines


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]


def _cannot_tell(finding: Finding) -> str:
    others = [
        ASYMMETRY if (finding.effect, a.effect) == ("effort_offset", "joint_friction") else a.effect
        for a in finding.alternatives
    ]
    return f"This recording cannot tell {finding.effect} from {', '.join(others)}."
