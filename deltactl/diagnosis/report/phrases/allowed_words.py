"""Small errors that were fitted beside the findings and are none: which, and how large."""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.answer.records import AllowedFor, Diagnosis
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.sizes import quantity, scale_of
from deltactl.models.effects import Trait, has, with_trait

LOOSE = (
    "Beside the findings, small errors of {what} were allowed for, as every machine has them that "
    "was built with care: together they explain what no single finding does. They are in no "
    "corrected file, which therefore leaves a little more."
)
AGAIN = (
    "Small errors of {what} were allowed for, as in the answer that this robot file comes from: "
    "every machine has them that was built with care, and they are in no corrected file."
)
CLEAR = "Those that are more than noise in this fit: {sizes}."
LARGE = "More than careful building usually leaves, so to be checked by hand: {sizes}."
BESIDE_A_DELAY = (
    "Beside drives that follow late they may be no more than how these follow, which is not quite"
    " as one time constant and a dead time would have it: look first at where the arms stand at"
    " rest."
)


def allowed_line(diagnosis: Diagnosis) -> str:
    """What was allowed for, with the sizes that the recording shows; empty where nothing was."""
    if not diagnosis.loosely_built:
        return ""
    hidden = {one.effect for one in diagnosis.not_testable} >= {*with_trait(Trait.LENGTH)}
    text = LOOSE if diagnosis.findings else AGAIN
    said = [text.format(what="home angles and ratios" if hidden else "lengths and angles")]
    if diagnosis.allowed_for:
        said.append(CLEAR.format(sizes=_each(diagnosis.allowed_for)))
    if large := [one for one in diagnosis.allowed_for if one.times_usual > 1.0]:
        said.append(LARGE.format(sizes=_each(large, usual=True)))
    late = {one.component for one in diagnosis.findings if has(one.effect, Trait.DRIVE_DELAY)}
    if late & {one.component for one in diagnosis.allowed_for}:
        said.append(BESIDE_A_DELAY)
    return " ".join(said)


def _each(allowed: Sequence[AllowedFor], usual: bool = False) -> str:
    """By effect: 'wrong home angles of motors 1 and 2 (+0.031 and +0.43 degrees)'."""
    effects = dict.fromkeys(one.effect for one in allowed)
    same = [[one for one in allowed if one.effect == effect] for effect in effects]
    return "; ".join(_of_one_effect(some, usual) for some in same)


def _of_one_effect(same: Sequence[AllowedFor], usual: bool) -> str:
    same = sorted(same, key=lambda one: one.component)
    what = words.effect(same[0].effect, *(one.component for one in same))
    sizes = words.listed([_size(one) for one in same])
    (name, result), *_ = same[0].parameters.items()
    scale = scale_of(result.unit, name)
    sizes = sizes.replace(f" {scale.unit}", "", len(same) - 1)
    if not usual:
        return f"{what} ({sizes})"
    most = quantity(scale.zero + same[0].usual, result.unit, name).lstrip("+")
    return f"{what} ({sizes}, usually up to {most})"


def _size(one: AllowedFor) -> str:
    """Its first parameter; a vector's components with spaces between."""
    (name, result), *_ = one.parameters.items()
    sizes = [quantity(value, result.unit, name) for value, _, _ in result.components]
    return sizes[0] if len(sizes) == 1 else f"({', '.join(sizes)})"
