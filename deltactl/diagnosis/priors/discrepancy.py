"""What an effect may leave for a further one to be tempted by (`EffectKind.discrepancy`)."""

from __future__ import annotations

from deltactl.diagnosis.plants.candidate import Candidate, Term


def left_by(term: Term, new: Candidate | None = None) -> float:
    """Share of what a term explains that it may leave in the shape of a new effect.

    Without one: of a spline term, which may have any.
    """
    own = term.candidate.kind.discrepancy
    if new is None:
        return own.elsewhere
    usual = own.in_pose if new.kind.pose_alone else own.elsewhere
    return own.leads_to.get(new.effect, usual)
