"""What the figures of a fit amount to: what is left, whether it is noise, and how much is gone.

In: the fit, or the answer that has it. Out: the cases that the report has sentences for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from deltactl.diagnosis.answer.options import SAYING, VERDICT
from deltactl.diagnosis.answer.records import Agreement, Diagnosis, Finding, Fit
from deltactl.diagnosis.answer.verdict import (
    NAMELESS,
    claimed,
    fits_worse,
    goes_on,
    seen,
    too_little,
)
from deltactl.models.effects import VOCABULARY

ONE_OFF = frozenset(kind.name for kind in VOCABULARY.values() if kind.event)

Part = Literal["nearly_all", "most", "part", "little"]
Found = Literal["explained", "explained_but", "fits_worse", "partly", "unnamed"]
Sound = Literal["nothing_missing", "probably_nothing", "none_known", "too_faint", "no_effect"]


def doubtful_floor(fit: Fit) -> bool:
    """Whether what the tests take for noise may well be something else."""
    return not fit.sensor_noise or goes_on(fit) or said_of_rest(fit) or moves_at_rest(fit)


def said_of_rest(fit: Fit) -> bool:
    """Whether what is left is so much more than readings scatter at rest that it is said of it."""
    within = fit.scatter_within_m
    return within is not None and fit.rms_after_m > VERDICT.beyond_rest * within


def mostly_by_place(fit: Fit) -> bool:
    """Whether most of what counts as noise does not show in readings at one place."""
    within = fit.scatter_within_m
    return within is not None and within <= SAYING.mostly_by_place * fit.noise_floor_m


def by_place_beside(answer: Diagnosis) -> bool:
    """Whether that is to be said of the noise, as it is not said of what is left."""
    fit, rest = answer.fit, answer.unexplained
    if not mostly_by_place(fit) or moves_at_rest(fit):
        return False
    return not said_of_rest(fit) or bool(rest.depends_on) or rest.share_of_mismatch > 0.0


def moves_at_rest(fit: Fit) -> bool:
    """Whether the axis moves beyond noise, and in many rests, while its command is constant."""
    found = fit.at_rest
    if found is None or found.rests == 0 or found.moved < SAYING.fewest_moved * found.rests:
        return False
    return found.moved_by_m > SAYING.moved_of_left * fit.rms_after_m


def least_scatter_m(fit: Fit) -> float | None:
    """What readings at one place scatter less than, where they scatter next to nothing."""
    least_m = SAYING.next_to_nothing * fit.rms_after_m
    return least_m if (fit.scatter_within_m or 0.0) < least_m else None


def where_left(fit: Fit) -> Literal["unknown", "in_motion", "by_place"]:
    """Where most of what is left shows."""
    if fit.at_rest is None:
        return "unknown"
    moving_m, still_m = fit.at_rest.left_in_motion_m, fit.at_rest.left_m
    return "in_motion" if moving_m > SAYING.mostly_in_motion * still_m else "by_place"


def kind_of_rest(
    answer: Diagnosis,
) -> Literal["more", "moves", "by_file", "goes_on", "noise", "no_test", "beyond_rest"]:
    """What is left: more than noise by a test, or what no test sees, as the readings show it."""
    fit, rest = answer.fit, answer.unexplained
    if rest.depends_on or rest.share_of_mismatch > 0.0:
        return "more"
    if moves_at_rest(fit):
        return "moves"
    by_file = goes_on(fit) and fit.left_by_known_m > VERDICT.most_of_rest * fit.rms_after_m
    if said_of_rest(fit) and not by_file:
        return "beyond_rest"
    if goes_on(fit):
        return "by_file" if by_file else "goes_on"
    return "noise" if fit.sensor_noise else "no_test"


def times_floor(fit: Fit) -> float | None:
    """How many times the noise floor is left; None where it is at it, or where it is doubtful."""
    times = fit.rms_after_m / fit.noise_floor_m if fit.noise_floor_m > 0.0 else math.inf
    return times if times > VERDICT.at_floor and not doubtful_floor(fit) else None


def beyond_noise_m(size_m: float, noise_m: float) -> float:
    """What of a root mean square is not noise."""
    return math.sqrt(max(size_m**2 - noise_m**2, 0.0))


def told_of_rest(answer: Diagnosis) -> Literal["beside_known", "too_little", "sized", "unsized"]:
    """How the size of the unexplained part is reported."""
    share, found = answer.unexplained.share_of_mismatch, bool(answer.findings)
    little = share > 0.0 and too_little(answer.fit, share, found)
    if little and not found:
        return "beside_known"
    if little and any(map(claimed, answer.findings)):
        return "too_little"
    return "sized" if found and share > 0.0 else "unsized"


def held_out_gain(answer: Diagnosis) -> tuple[str, float]:
    """What the findings take away on held-out data, and its share of what is above the noise floor;
    of all of it where that floor is doubtful.
    """
    fit = answer.fit
    if fit.holdout == "run" and all(one.effect in ONE_OFF for one in answer.findings):
        return "one_off", math.nan
    floor_m = 0.0 if doubtful_floor(fit) else fit.noise_floor_m
    above_m = fit.holdout_rms_before_m - floor_m
    if not math.isfinite(above_m) or above_m <= SAYING.above_floor * fit.noise_floor_m:
        return "untold", math.nan
    gain = (fit.holdout_rms_before_m - fit.holdout_rms_after_m) / above_m
    if gain <= 0.0:
        return "none", gain
    return ("nearly_all" if gain > SAYING.nearly_all_gone else "share"), gain


@dataclass(frozen=True, slots=True)
class Without:
    """The model error without a finding beside that with it.

    part: how much of it comes back. case: what that compares to. without_m, with_m: sizes, less the
    noise where `beyond`. about: not computed by itself, but from the share.
    """

    part: Literal["much", "some", "little", "little_but_seen"]
    without_m: float
    with_m: float
    beyond: bool
    about: bool

    @property
    def smaller(self) -> bool:
        """Whether the model error as a whole would be no larger without it."""
        return self.without_m < self.with_m

    @property
    def next_to_none(self) -> bool:
        """Whether with it next to nothing is left beyond the noise."""
        return self.beyond and self.with_m < SAYING.next_to_none * self.without_m


def without(finding: Finding, fit: Fit) -> Without:
    """What the other findings cannot take over of one; by its share where no more is known."""
    share, own = finding.share_of_mismatch, finding.own_share or 0.0
    part: Literal["much", "some", "little", "little_but_seen"] = "little"
    if share >= SAYING.much_returns:
        part = "much"
    elif share >= SAYING.hardly_returns or own >= SAYING.hardly_returns:
        part = "some"
    elif finding.evidence.p < SAYING.sure_p:
        part = "little_but_seen"
    after_m, without_m = fit.rms_after_m, finding.left_without_m
    about = without_m is None
    if without_m is None:
        gone = max(fit.rms_before_m**2 - after_m**2, 0.0)
        without_m = math.sqrt(after_m**2 + share * gone)
    beyond = not doubtful_floor(fit) and fit.noise_floor_m > SAYING.mostly_noise * after_m
    if beyond:
        after_m, without_m = (beyond_noise_m(m, fit.noise_floor_m) for m in (after_m, without_m))
    return Without(part, without_m, after_m, beyond, about)


def part_explained(answer: Diagnosis) -> Part:
    """How much of the model error is gone, as a reader reckons it from the figures of the fit."""
    left = answer.fit.rms_after_m / max(answer.fit.rms_before_m, 1e-300)
    share = answer.unexplained.share_of_mismatch
    if left < SAYING.little_left and share < VERDICT.faint_rest:
        return "nearly_all"
    return "most" if left < SAYING.half_left else "part"


def partly(answer: Diagnosis) -> tuple[Part, Literal["", "left", "other", "small"]]:
    """How much of a model error is explained in part, and what is said of the rest."""
    part, shares = (
        part_explained(answer),
        [one.share_of_mismatch for one in answer.findings if one.effect == NAMELESS],
    )
    if answer.unexplained.share_of_mismatch >= SAYING.mostly_left:
        return "little", "left"
    if not shares:
        return part, ""
    if not sum(shares) < VERDICT.faint_rest:
        return "part", "other"
    return part, "small" if part == "nearly_all" else "other"


def headline_case(answer: Diagnosis) -> Found | Sound:
    """Which sentence the verdict is put in."""
    if answer.verdict == "nothing_missing":
        sure = answer.probability_nothing_missing
        doubtful = sure is not None and sure < SAYING.settled_p
        return "probably_nothing" if doubtful else "nothing_missing"
    named = any(map(claimed, answer.findings))
    if answer.verdict == "explained" and named:
        whole = part_explained(answer) == "nearly_all" or not doubtful_floor(answer.fit)
        return "explained" if whole else "explained_but"
    if answer.verdict == "partly_explained" and named:
        return "fits_worse" if fits_worse(answer.fit) else "partly"
    if any(one.effect == NAMELESS for one in answer.findings):
        return "unnamed"
    nothing = answer.probability_nothing_missing
    if nothing is None or seen(answer.false_alarm_p):
        return "no_effect"
    return "none_known" if nothing >= VERDICT.even else "too_faint"


def alarm_case(answer: Diagnosis) -> str:
    """What the p of 'nothing is missing' and its posterior amount to together; empty where the
    headline says as much. Where what is left is not surely noise, nothing is said of what noise
    would look like.
    """
    p, nothing = answer.false_alarm_p, answer.probability_nothing_missing
    if not math.isfinite(p):
        return "not_computed"
    if nothing is None:
        return "by_noise"
    if nothing < VERDICT.even:
        few = p >= SAYING.likely_p and nothing < 1.0 - SAYING.settled_p
        return "incomplete_few" if few else "incomplete"
    if seen(p):
        return "complete_but_seen"
    if not answer.findings:
        if answer.verdict != "nothing_missing":
            return ""
        if nothing < SAYING.settled_p:
            return _what_would_tell(answer.fit)
        if doubtful_floor(answer.fit):
            # What effects of the file may leave hides what has no name.
            return "no_further" if answer.known else "complete_no_noise"
    return "complete"


def _what_would_tell(fit: Fit) -> str:
    if not (mostly_by_place(fit) or said_of_rest(fit)):
        return "longer"
    return "more_places" if fit.at_rest is None else "more_moves"


def surely_nothing(nothing: float) -> bool:
    """Whether the posterior of the empty set leaves no doubt."""
    return nothing >= SAYING.settled_p


def apart(answer: Diagnosis) -> list[Agreement]:
    """Sizes on which several recordings do not agree."""
    return [one for one in answer.agreement if one.p < SAYING.disagrees]
