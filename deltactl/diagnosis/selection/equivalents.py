"""Effects that do exactly the same to everything that is observed, and how to convert one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.plants.candidate import Candidate, Term

LAG, VISCOUS, LATE = "following_lag", "viscous_friction", "sensor_latency"
PLAY, HOME = "gear_backlash", "home_offset"


def equivalents_of(terms: Sequence[Term], candidates: Sequence[Candidate]) -> list[Term]:
    """The candidates where they do what the terms do together, as far as they are equivalents_of.

    Viscous friction c behind a shaft of stiffness k is a first-order lag of c / k. A dead time of
    all drives is a sensor latency unless the joints are seen. Play that always hangs on the same
    flank is a home offset of half its width.
    """
    effects = {term.candidate.effect for term in terms}
    if len(effects) != 1:
        return []
    effect = effects.pop()
    if effect == PLAY and len(terms) == 1:
        return _hanging(terms[0], candidates)
    late_s = float(np.mean([_late_s(term) for term in terms]))
    if late_s <= 0.0:
        return []
    found = []
    for other in candidates:
        names = [coordinate.parameter for coordinate in other.coordinates]
        same = len(terms) == 1 and other.component == terms[0].candidate.component
        if same and (effect, other.effect) == (VISCOUS, LAG):
            found.append(Term(other, np.array([late_s, 0.0])))
        elif same and (effect, other.effect) == (LAG, VISCOUS) and names == ["coefficient"]:
            found.append(Term(other, np.array([late_s * float(other.fixed["stiffness"])])))
        elif effect == LATE and other.effect == LAG and other.members:
            found.append(Term(other, np.array([0.0, late_s])))
        elif effect == LAG and other.effect == LATE and len(terms) > 1:
            found.append(Term(other, np.array([late_s])))
    return found


def _hanging(play: Term, candidates: Sequence[Candidate]) -> list[Term]:
    half_rad = 0.5 * float(play.candidate.values(play.at)["width"])
    homes = [c for c in candidates if (c.effect, c.component) == (HOME, play.candidate.component)]
    return [Term(home, np.array([side * half_rad])) for home in homes for side in (1.0, -1.0)]


def _late_s(term: Term) -> float:
    """How late a lag, a viscous shaft or a sensor makes things [s]; 0 for other effects."""
    values = {name: float(x) for name, x in term.candidate.values(term.at).items() if x.ndim == 0}
    if term.candidate.effect == VISCOUS:
        return values["coefficient"] / values["stiffness"]
    return values.get("time", 0.0) + values.get("dead_time", 0.0)
