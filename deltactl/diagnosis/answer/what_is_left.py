"""What the figures of a fit amount to: whether the remaining error is noise, and how much is gone.

In: the fit, or the answer that has it. Out: facts that the report renders.
"""

from __future__ import annotations

import math
from typing import Literal

from deltactl.diagnosis.answer.options import SAYING, VERDICT
from deltactl.diagnosis.answer.records import Agreement, Diagnosis, Fit
from deltactl.diagnosis.answer.verdict import NAMELESS, claimed, fits_worse, goes_on, seen
from deltactl.models.effects import VOCABULARY

Headline = Literal[
    "nothing", "none_known", "explained", "fits_worse", "partly", "unnamed", "too_faint",
    "no_effect",
]  # fmt: skip


def doubtful_floor(fit: Fit) -> bool:
    """Whether what the tests take for noise may well be something else."""
    return not fit.sensor_noise or goes_on(fit) or beyond_rest(fit) or moves_at_rest(fit)


def beyond_rest(fit: Fit) -> bool:
    """Whether the remaining error is much more than readings scatter at one place."""
    within = fit.scatter_within_m
    return within is not None and fit.rms_after_m > VERDICT.beyond_rest * within


def moves_at_rest(fit: Fit) -> bool:
    """Whether the axis moves beyond noise, and in many rests, while its command is constant."""
    found = fit.at_rest
    if found is None or found.rests == 0 or found.moved < SAYING.fewest_moved * found.rests:
        return False
    return found.moved_by_m > SAYING.moved_of_left * fit.rms_after_m


def left_by_file(fit: Fit) -> bool:
    """Whether the remaining error is no more than effects of the robot file leave."""
    return goes_on(fit) and fit.left_by_known_m > VERDICT.half_of_power * fit.rms_after_m


def once(answer: Diagnosis) -> bool:
    """Whether all findings are events, which do not come back in another run."""
    kinds = [VOCABULARY.get(one.effect) for one in answer.findings]
    return all(kind is not None and kind.event for kind in kinds)


def gone(answer: Diagnosis) -> float:
    """Share of the held-out error above the noise floor that the findings take away; of all of it
    where that floor is doubtful. NaN where nothing is held out, or above the floor.
    """
    fit = answer.fit
    above_m = fit.holdout_rms_before_m - (0.0 if doubtful_floor(fit) else fit.noise_floor_m)
    taken_m = fit.holdout_rms_before_m - fit.holdout_rms_after_m
    return max(taken_m / above_m, 0.0) if above_m > 0.0 else math.nan


def mostly_left(answer: Diagnosis) -> bool:
    """Whether most of the error is left, so that the columns are to be checked first."""
    return answer.unexplained.share_of_mismatch >= SAYING.mostly_left


def headline_case(answer: Diagnosis) -> Headline:
    """Which sentence the verdict is put in."""
    if answer.verdict == "nothing_missing":
        return "nothing"
    if any(map(claimed, answer.findings)):
        if answer.verdict == "partly_explained":
            return "fits_worse" if fits_worse(answer.fit) else "partly"
        return "explained"
    if any(one.effect == NAMELESS for one in answer.findings):
        return "unnamed"
    nothing = answer.probability_nothing_missing
    if nothing is None or seen(answer.false_alarm_p):
        return "no_effect"
    return "none_known" if nothing >= VERDICT.even else "too_faint"


def surely_nothing(answer: Diagnosis) -> bool:
    """Whether the posterior of the empty set leaves no doubt, or was not computed."""
    nothing = answer.probability_nothing_missing
    return nothing is None or nothing >= SAYING.settled_p


def apart(answer: Diagnosis) -> list[Agreement]:
    """Sizes on which several recordings do not agree."""
    return [one for one in answer.agreement if one.p < SAYING.disagrees]
