"""What belongs to the size of a finding beside its figures, for terminal and report alike."""

from __future__ import annotations

import numpy as np

from diagnosis.answer.picture import FloatArray, Picture
from diagnosis.answer.records import Diagnosis, Finding
from diagnosis.answer.verdict import NAMELESS
from diagnosis.report.phrases import words
from diagnosis.report.phrases.sizes import quantity
from diagnosis.report.phrases.sureness import by_priors_here
from diagnosis.report.sentences.beside_others import (
    lags_by_itself,
    mean_over_speeds,
    wider_in_motion,
    zero_of_play,
)
from diagnosis.report.sentences.telling_apart import LONE

UNLOADED_ALIKE = 0.9
"""Share of friction that is there without a load, from which on nothing is said of the load."""
SECOND = 0.1
"""Of a periodic error's first harmonic, from which on the second is told."""
PARTS = 5
"""Of a recording, in which its motion is compared,"""
OTHER_PACE = 2.0
"""and times as fast as another from which on it is another motion."""
MOVES_ON = (
    "The motion itself changes over this time (how fast it goes), so that what comes with the speed"
    " would look the same."
)


def notes(finding: Finding, diagnosis: Diagnosis) -> list[str]:
    """Sentences that go with its size."""
    findings = diagnosis.findings
    said = (
        grows_with_load(finding),
        zero_of_play(finding, findings),
        wider_in_motion(finding, findings),
        lags_by_itself(finding, findings),
        mean_over_speeds(finding, findings),
        second_harmonic(finding),
        MOVES_ON if changes_its_pace(finding, diagnosis.picture) else "",
    )
    return [line for line in said if line]


def how_it_hangs_on_priors(finding: Finding, diagnosis: Diagnosis) -> list[str]:
    """That its probability does, where it does."""
    return [
        by_priors_here(one)
        for one in diagnosis.prior_sensitivity
        if (one.effect, one.component) == (finding.effect, finding.component)
    ]


def grows_with_load(finding: Finding) -> str:
    """Of friction that a load makes larger: how much of it is there without one; else empty."""
    share = finding.parameters.get("unloaded")
    if share is None or share.components[0][0] > UNLOADED_ALIKE:
        return ""
    width = finding.parameters["width"]
    alone = quantity(share.components[0][0] * width.components[0][0], width.unit, digits=2)
    return f"It grows with the load: this is at the usual load, and without one it is {alone}."


def second_harmonic(finding: Finding) -> str:
    """Of a periodic error of an axis that is no plain sine: its second wave, and both together."""
    sizes = {name: one.components[0][0] for name, one in finding.parameters.items()}
    first, second = sizes.get("amplitude", 0.0), sizes.get("amplitude_2", 0.0)
    if finding.component != LONE or second <= SECOND * first:
        return ""
    turn = np.linspace(0.0, 2.0 * np.pi, 721)
    both = first * np.sin(turn + sizes.get("phase", 0.0))
    both += second * np.sin(2.0 * turn + sizes.get("phase_2", 0.0))
    unit = finding.parameters["amplitude"].unit
    twice, across = (
        quantity(size, unit, digits=3).lstrip("+") for size in (second, float(np.ptp(both)))
    )
    return f"Twice in each period another {twice} are added; both together span {across}."


def changes_its_pace(finding: Finding, picture: Picture | None) -> bool:
    """Whether an unknown follows the time of a motion that is faster in one part than in another.

    Parts in which the machine stands do not count.
    """
    follows = [words.bare(name) for name in finding.depends_on[:1]]
    if finding.effect != NAMELESS or follows not in (["time"], ["t"]) or picture is None:
        return False
    return any(
        _paces(values) > OTHER_PACE
        for name, values in picture.covariates.items()
        if words.bare(name).startswith(("velocity", "speed")) and len(values) == len(picture.t_s)
    )


def _paces(speed: FloatArray) -> float:
    """How many times as fast the fastest part of a motion (n,) is as the slowest."""
    moves = np.nan_to_num(speed)[np.nan_to_num(speed) != 0.0]
    if len(moves) < PARTS:
        return 1.0
    each = [float(np.sqrt(np.mean(part**2))) for part in np.array_split(moves, PARTS)]
    return max(each) / max(min(each), 1e-300)
