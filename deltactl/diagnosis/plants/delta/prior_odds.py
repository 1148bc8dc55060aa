"""How probable each effect of a delta is before anything was read, and what it may leave."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.point import Near, is_straight
from deltactl.diagnosis.plants.delta.unknown import Process
from deltactl.diagnosis.plants.options import SPLINE_TERMS
from deltactl.diagnosis.plants.regressor import Regressor
from deltactl.diagnosis.priors.options import PENALTIES
from deltactl.diagnosis.priors.size_priors import odds_cost
from deltactl.models.effects import card_of


def named_regressor(key: str, near: Near, tolerances: Sequence[str]) -> Regressor:
    """An effect at a component; what is so in name only costs like an unknown.

    tolerances: names of the columns that are always fitted.
    """
    candidate = near.term.candidate
    in_name_only = PENALTIES.in_name_only if _in_name_only(near.term) else 0.0
    odds = near.heavy_tail + near.usual - 0.5 * (odds_cost(candidate) + in_name_only)
    takes_over = key if key in tolerances else ""
    built = (card_of(candidate.effect).build_spread or 0.0) if takes_over else 0.0
    places = None if is_straight(candidate) else float(len(candidate.shapes))
    return Regressor(
        key, candidate.effect, odds, candidate.component, candidate.members,
        alone=False, built_so=PENALTIES.within * built, takes_over=takes_over, places=places,
    )  # fmt: skip


def left_by(known: Candidate, new: Candidate | None) -> float:
    """Share of what one effect explains that its operator may leave in the shape of another.

    new: None for what has no name.
    """
    own = known.kind.discrepancy
    if new is None:
        return own.elsewhere
    usual = own.in_pose if new.kind.pose_alone else own.elsewhere
    return own.leads_to.get(new.effect, usual)


def unknown_regressor(one: Process) -> Regressor:
    """A process; the choice of its length and size is paid for."""
    odds = SPLINE_TERMS.unknown_log_odds - one.paid
    return Regressor(
        one.key, "unknown", odds, one.component, follows=one.follows, alone=False, saturated=False
    )


def _in_name_only(term: Term) -> bool:
    """Outside the range in which it is itself; a wave of its whole travel, which is one bend."""
    for coordinate, at in zip(term.candidate.coordinates, term.at, strict=True):
        name = coordinate.parameter
        if name == "period" and at > coordinate.high + np.log(PENALTIES.whole_travel):
            return True
        low, high = term.candidate.kind.itself.get(name, (-np.inf, np.inf))
        if not low <= at <= high:
            return True
    return False
