"""What belongs to the size of a finding beside its figures, for terminal and report alike."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.answer.picture import Channel, FloatArray, Picture
from deltactl.diagnosis.answer.records import Diagnosis, Finding
from deltactl.diagnosis.answer.verdict import NAMELESS
from deltactl.diagnosis.report.phrases import sureness, words
from deltactl.diagnosis.report.phrases.percent import percent
from deltactl.diagnosis.report.phrases.sizes import quantity
from deltactl.diagnosis.report.sentences.beside_others import (
    lags_by_itself,
    mean_over_speeds,
    where_it_moved,
    wider_in_motion,
    zero_of_play,
)
from deltactl.diagnosis.report.sentences.telling_apart import LONE

UNLOADED_ALIKE = 0.9
"""Share of friction that is there without a load, from which on nothing is said of the load."""
SECOND = 0.1
"""Of a periodic error's first harmonic, from which on the second is told."""
LEAST_WAVES, FEWEST_NAMED = 1.2, 3.1
"""Waves over the travel of a periodic error that is told though it is not named: of fewer a bend
looks the same."""
MOST_OF_IT = 0.7
"""Share of the power from which on."""
FEWEST_ROWS = 20
PARTS = 5
"""Of a recording, in which its motion is compared,"""
OTHER_PACE = 2.0
"""and times as fast as another from which on it is another motion."""
NOTHING_TO_NAME = "nothing that this recording can name"
MOVES_ON = (
    "The motion itself changes over this time (how fast it goes), so that what comes with the speed"
    " would look the same."
)


def notes(finding: Finding, diagnosis: Diagnosis) -> list[str]:
    """Sentences that go with its size."""
    findings = diagnosis.findings
    said = (
        grows_with_load(finding),
        where_it_moved(finding, findings, diagnosis.picture) or zero_of_play(finding, findings),
        wider_in_motion(finding, findings),
        lags_by_itself(finding, findings),
        mean_over_speeds(finding, findings),
        second_harmonic(finding),
        too_few_periods(finding, diagnosis.picture),
        MOVES_ON if changes_its_pace(finding, diagnosis.picture) else "",
    )
    return [line for line in said if line]


def how_it_hangs_on_priors(finding: Finding, diagnosis: Diagnosis) -> list[str]:
    """That its probability does, where it does."""
    return [
        sureness.by_priors_here(one)
        for one in diagnosis.prior_sensitivity
        if sureness.is_about(one, finding)
    ]


def how_sure(finding: Finding, diagnosis: Diagnosis) -> list[str]:
    """How sure it is, and what that hangs on."""
    few = too_few_periods(finding, diagnosis.picture)
    said = sureness.evidence(finding, NOTHING_TO_NAME) if few else sureness.evidence(finding)
    return [said, *how_it_hangs_on_priors(finding, diagnosis)]


def grows_with_load(finding: Finding) -> str:
    """Of friction that a load makes larger: how much of it is there without one; else empty."""
    share = finding.parameters.get("unloaded")
    if share is None or share.components[0][0] > UNLOADED_ALIKE:
        return ""
    width = finding.parameters["width"]
    alone, least, most = (
        quantity(part * width.components[0][0], width.unit, digits=2).lstrip("+")
        for part in share.components[0]
    )
    unit = f" {most.partition(' ')[2]}"
    between = f"between {least.removesuffix(unit)} and {most}"
    return (
        "It grows with the load: this is at the usual load, and without one it is"
        f" {alone} (95 % sure {between})."
    )


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


def too_few_periods(finding: Finding, picture: Picture | None) -> str:
    """That one wave over the travel takes away most of what an unknown of a lone axis does.

    A periodic error of which fewer than three periods were recorded is not named: a bend, or a
    drift, looks like one.
    """
    follows = [words.bare(name) for name in finding.depends_on[:1]]
    place = {} if picture is None else {words.bare(n): v for n, v in picture.covariates.items()}
    wanted = finding.effect == NAMELESS and finding.component == LONE
    if not wanted or picture is None or follows not in (["time"], ["position"]):
        return ""
    if "position" not in place or picture.channels[0].unit not in ("m", "rad"):
        return ""
    found = _one_wave(place["position"], picture.channels[0])
    if found is None:
        return ""
    waves, share, period = found
    return (
        f"One wave every {quantity(period, picture.channels[0].unit, digits=3).lstrip('+')}, of"
        f" which this recording holds {waves:.1f}, would take away {percent(share)} of its power: a"
        " periodic error of a gear or an encoder takes three to be named. Record more of them."
    )


def _one_wave(at: FloatArray, channel: Channel) -> tuple[float, float, float] | None:
    """How many waves over the travel, the share of power that they take, and their period.

    Of what was found by name at first, a constant and a line over the travel are no wave. None
    where no such wave takes most of it.
    """
    left = channel.observed - channel.before
    known = np.isfinite(left) & np.isfinite(at)
    if np.count_nonzero(known) < FEWEST_ROWS or not np.ptp(at[known]) > 0.0:
        return None
    span = float(np.ptp(at[known]))
    along, left = (at[known] - at[known].min()) / span, left[known]
    plain = np.stack([np.ones_like(along), along], axis=1)

    def power(waves: float) -> float:
        turn = 2.0 * np.pi * waves * along
        shapes = np.concatenate([plain, np.stack([np.sin(turn), np.cos(turn)], axis=1)], axis=1)
        return float(np.sum((left - shapes @ np.linalg.lstsq(shapes, left, rcond=None)[0]) ** 2))

    whole = float(np.sum((left - plain @ np.linalg.lstsq(plain, left, rcond=None)[0]) ** 2))
    tried = np.arange(LEAST_WAVES, FEWEST_NAMED, 0.05)
    powers = [power(float(waves)) for waves in tried]
    best = int(np.argmin(powers))
    share = 1.0 - powers[best] / max(whole, 1e-300)
    inside = 0 < best < len(tried) - 1
    return (
        (float(tried[best]), share, span / float(tried[best]))
        if inside and share > MOST_OF_IT
        else None
    )


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
