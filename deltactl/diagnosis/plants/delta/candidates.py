"""The candidates of a delta: each effect at each component, bounded by what a recording shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.options import DELTA_FITS
from deltactl.diagnosis.plants.nuisance import Nuisance
from deltactl.models.effects import VOCABULARY, EffectKind, Search, card_of, found_by
from deltactl.models.effects.card import Coordinate, Fit, Shape

TURN_RAD = 2.0 * np.pi


def _fit(kind: EffectKind) -> Fit:
    """How a fit moves in an effect: as its card says, or in one number, in which it is linear."""
    fit = card_of(kind.name).fit
    if fit is not None:
        return fit
    main = kind.main
    return Fit(
        coordinates=(Coordinate(main.name, step=main.step, low=main.low, high=main.high),),
        shapes=(Shape((kind.nothing,), (0,), main.step),),
        fixed={p.name: p.default for p in kind.parameters if p.default is not None},
    )


def _bounded(
    coordinates: tuple[Coordinate, ...], number: int, low: float, high: float
) -> tuple[Coordinate, ...]:
    changed = replace(coordinates[number], low=float(low), high=float(high))
    return (*coordinates[:number], changed, *coordinates[number + 1 :])


def tolerances(candidates: list[Candidate]) -> list[Nuisance]:
    """The static effects as nuisances, each held near nothing by its usual spread."""
    spreads = ((one, card_of(one.effect).build_spread) for one in candidates)
    return [
        Nuisance(Term(one, np.array(one.shapes[0].origin)), (spread,) * len(one.moved))
        for one, spread in spreads
        if spread is not None
    ]


def runout(gear_ratio: float) -> list[Nuisance]:
    """A periodic error once a turn of each motor, as a tolerance."""
    period = float(np.exp(float(np.log(TURN_RAD / gear_ratio))))
    found = []
    for kind in VOCABULARY.values():
        spread = card_of(kind.name).runout_rad
        waves = tuple(one for one in _fit(kind).coordinates if one.how in ("sine", "cosine"))
        for component in kind.components if spread is not None else ():
            candidate = Candidate(kind, component, waves, (), {"period": period})
            found.append(Nuisance(Term(candidate, np.zeros(2)), (spread or 0.0,) * 2))
    return found


def candidates_of(name: str, travel_rad: float, span_s: float) -> list[Candidate]:
    """All candidates of one effect, a component each; none of one that a search finds.

    A period longer than the travel looks like an offset, a warming that is over at once like a
    wrong length: they are left to those.
    """
    kind = VOCABULARY[name]
    fit = _fit(kind)
    coordinates, shapes, fixed = fit.coordinates, fit.shapes, fit.fixed
    if fit.searched is not None:
        return []
    for number, c in enumerate(coordinates):
        if c.parameter == "period":
            high = float(np.log(max(min(travel_rad, TURN_RAD), DELTA_FITS.shortest_period_rad)))
            coordinates = _bounded(coordinates, number, c.low, high)
            shapes = tuple(s for s in shapes if s.origin[number] <= high)
        if c.parameter == "time_constant":
            soonest_s = min(DELTA_FITS.soonest_warm_s, DELTA_FITS.soonest_warm_share * span_s)
            low_s = max(span_s / DELTA_FITS.most_warm_ups, soonest_s)
            high_s = DELTA_FITS.slowest_warm_times * span_s
            coordinates = _bounded(coordinates, number, np.log(low_s), np.log(high_s))
            shapes = tuple(
                Shape((0.0, float(np.log(share * span_s))), (0,), 1e-4)
                for share in DELTA_FITS.warm_up_shares
            )
    return [Candidate(kind, component, coordinates, shapes, fixed) for component in kind.components]


def _searched(search: Search) -> tuple[EffectKind, Fit]:
    kind = found_by(search)
    return kind, _fit(kind)


def late_readings() -> Candidate:
    """Readings of all sensors that come late."""
    kind, fit = _searched(Search.CLOCK)
    return Candidate(kind, kind.components[0], fit.coordinates, fit.shapes, {})


def contact(lowest_m: float, highest_m: float) -> Candidate:
    """Contact at heights within those that the platform was sent to."""
    kind, fit = _searched(Search.HEIGHTS)
    span = highest_m - lowest_m
    shapes = tuple(
        Shape((lowest_m + share * span, grip), ()) for share, grip in (s.origin for s in fit.shapes)
    )
    coordinates = _bounded(fit.coordinates, 0, lowest_m - 1.0, highest_m)
    return Candidate(kind, kind.components[0], coordinates, shapes, {})


def lost_steps(component: str, time_s: float) -> Candidate:
    """A loss at a time that was found by a scan."""
    kind, fit = _searched(Search.MOMENT)
    shapes = (Shape((0.0, time_s), (0,), fit.coordinates[0].step),)
    return Candidate(kind, component, fit.coordinates, shapes, {})
