"""How the fit moves in each effect of a delta, and from which points it starts.

One row an effect: coordinates, then shapes (starting points with the reach of their secant).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np

from deltactl.diagnosis.plants.candidate import Candidate, Coordinate, Shape, Term
from deltactl.diagnosis.plants.delta.options import DELTA_FITS, RUNOUT, TOLERANCES
from deltactl.diagnosis.plants.nuisance import Nuisance
from deltactl.models.effects import VOCABULARY, EffectKind

Rows = tuple[tuple[Coordinate, ...], tuple[Shape, ...], dict[str, float]]

TURN_RAD = 2.0 * np.pi


def _simple(kind: EffectKind, step: float | None = None) -> Rows:
    """One number in which the effect is nearly linear."""
    main = kind.main
    step = step or main.step
    coordinate = Coordinate(main.name, step=step, low=main.low, high=main.high)
    return (coordinate,), (Shape((kind.nothing,), (0,), step),), _defaults(kind)


def _defaults(kind: EffectKind) -> dict[str, float]:
    return {p.name: p.default for p in kind.parameters if p.default is not None}


def _lag(kind: EffectKind) -> Rows:
    coordinates = (
        Coordinate("time", step=2e-3, low=0.0, high=2.0),
        Coordinate("dead_time", step=2e-3, low=0.0, high=2.0),
    )
    shapes = [Shape((0.0, 0.0), (i,), reach) for i, reach in product((0, 1), DELTA_FITS.lags_s)]
    return coordinates, tuple(shapes), {}


def _viscous(kind: EffectKind) -> Rows:
    coordinate = Coordinate("coefficient", step=2.0, low=0.0, high=1e4)
    return (coordinate,), (Shape((0.0,), (0,), 20.0),), _defaults(kind)


def _backlash(kind: EffectKind) -> Rows:
    coordinates = (
        Coordinate("width", step=3e-4, low=0.0, high=0.2),
        Coordinate("drag", "log", step=0.05, low=np.log(0.1), high=np.log(DELTA_FITS.sticks)),
        Coordinate("stiffness", "reciprocal", step=2e-5, low=0.0, high=1e-3),
    )
    shapes = [
        Shape((0.0, float(np.log(drag)), 0.0), (0,), width)
        for drag, width in product((*DELTA_FITS.drags, DELTA_FITS.sticks), DELTA_FITS.plays_rad)
    ]
    return coordinates, tuple(shapes), {"friction": 0.0}


def _friction(kind: EffectKind) -> Rows:
    coordinates = (
        Coordinate("width", step=3e-4, low=0.0, high=0.2),
        Coordinate("stiffness", "reciprocal", step=2e-5, low=0.0, high=1e-3),
        Coordinate("overshoot", step=5e-4, low=0.0, high=0.02),
    )
    shapes = tuple(Shape((0.0, 0.0, 0.0), (0,), width) for width in DELTA_FITS.plays_rad)
    moved = {coordinate.parameter for coordinate in coordinates}
    defaults = {name: value for name, value in _defaults(kind).items() if name not in moved}
    return coordinates, shapes, defaults


def _compliance(kind: EffectKind) -> Rows:
    coordinate = Coordinate("stiffness", "reciprocal", step=1e-4, low=0.0, high=1.0)
    return (coordinate,), (Shape((0.0,), (0,), 1e-4),), {}


def _periodic(kind: EffectKind) -> Rows:
    coordinates = (
        Coordinate("amplitude", "sine", step=2e-4, low=-0.2, high=0.2),
        Coordinate("amplitude", "cosine", step=2e-4, low=-0.2, high=0.2),
        Coordinate("period", "log", step=1e-3, low=np.log(1e-3), high=np.log(TURN_RAD)),
    )
    shapes = [
        Shape((0.0, 0.0, float(np.log(TURN_RAD / n))), (0, 1), 2e-4)
        for n in DELTA_FITS.gear_periods
    ]
    return coordinates, tuple(shapes), {}


def _warming(kind: EffectKind) -> Rows:
    main = kind.main
    coordinates = (
        Coordinate(main.name, step=1e-4, low=main.low, high=main.high),
        Coordinate("time_constant", "log", step=0.05, low=0.0, high=np.log(1e5)),
    )
    return coordinates, (), {}


def _tilt(kind: EffectKind) -> Rows:
    coordinates = tuple(Coordinate("rotation", step=1e-4, part=part) for part in range(3))
    return coordinates, (Shape((0.0, 0.0, 0.0), (0, 1, 2), 1e-4),), {}


def _ringing(kind: EffectKind) -> Rows:
    coordinates = (
        Coordinate("frequency", "log", step=0.01, low=np.log(0.3), high=np.log(40.0)),
        Coordinate("damping", step=0.01, low=0.005, high=0.95),
    )
    shapes = [
        Shape((float(np.log(hertz)), damping), ())
        for hertz, damping in product(DELTA_FITS.ringing_hz, DELTA_FITS.ringing_damping)
    ]
    return coordinates, tuple(shapes), {}


_SPECIAL: dict[str, Callable[[EffectKind], Rows]] = {
    "following_lag": _lag,
    "viscous_friction": _viscous,
    "gear_backlash": _backlash,
    "joint_friction": _friction,
    "joint_compliance": _compliance,
    "transmission_error": _periodic,
    "encoder_error": _periodic,
    "thermal_expansion": _warming,
    "sensor_drift": _warming,
    "frame_tilt": _tilt,
    "resonance": _ringing,
}


def _bounded(
    coordinates: tuple[Coordinate, ...], number: int, low: float, high: float
) -> tuple[Coordinate, ...]:
    changed = replace(coordinates[number], low=float(low), high=float(high))
    return (*coordinates[:number], changed, *coordinates[number + 1 :])


def tolerances(candidates: list[Candidate]) -> list[Nuisance]:
    """The static effects as nuisances, each held near nothing by its usual spread."""
    return [
        Nuisance(
            Term(candidate, np.array(candidate.shapes[0].origin)),
            (TOLERANCES[candidate.effect],) * len(candidate.moved),
        )
        for candidate in candidates
        if candidate.effect in TOLERANCES
    ]


def runout(gear_ratio: float) -> list[Nuisance]:
    """A periodic error once a turn of each motor, as a tolerance."""
    kind = VOCABULARY["transmission_error"]
    period = float(np.log(TURN_RAD / gear_ratio))
    coordinates = (
        Coordinate("amplitude", "sine", step=2e-4, low=-0.2, high=0.2),
        Coordinate("amplitude", "cosine", step=2e-4, low=-0.2, high=0.2),
    )
    fixed = {"period": float(np.exp(period))}
    return [
        Nuisance(
            Term(Candidate(kind, component, coordinates, (), fixed), np.zeros(2)),
            (RUNOUT.once_a_motor_turn_rad,) * 2,
        )
        for component in kind.components
    ]


EVENTS = ("lost_steps", "stale_reading")
"""Found by their own searches, not from the table."""


def candidates_of(name: str, travel_rad: float, span_s: float) -> list[Candidate]:
    """All candidates of one effect, a component each.

    A period longer than the travel looks like an offset, a warming that is over at once like a
    wrong length: they are left to those.
    """
    kind = VOCABULARY[name]
    coordinates, shapes, fixed = _SPECIAL.get(name, _simple)(kind)
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


def contact(lowest_m: float, highest_m: float) -> Candidate:
    """Contact at heights within those that the platform was sent to."""
    span = highest_m - lowest_m
    shapes = tuple(
        Shape((lowest_m + share * span, grip), ())
        for share, grip in product(DELTA_FITS.contact_shares, DELTA_FITS.grips)
    )
    coordinates = (
        Coordinate("height", step=5e-4, low=lowest_m - 1.0, high=highest_m),
        Coordinate("grip", step=0.05, low=0.0, high=20.0),
    )
    return Candidate(VOCABULARY["contact"], "platform", coordinates, shapes, {})


def lost_steps(component: str, time_s: float) -> Candidate:
    """A loss at a time that was found by a scan."""
    coordinates = (
        Coordinate("steps", step=2.0, low=-2e4, high=2e4),
        Coordinate("time", "frozen"),
    )
    shapes = (Shape((0.0, time_s), (0,), 2.0),)
    return Candidate(VOCABULARY["lost_steps"], component, coordinates, shapes, {})


def stale(component: str, time_s: float, duration_s: float) -> Candidate:
    """A stretch of repeated readings that was found in the data."""
    coordinates = (Coordinate("duration", "frozen"), Coordinate("time", "frozen"))
    return Candidate(
        VOCABULARY["stale_reading"], component, coordinates, (Shape((duration_s, time_s), ()),), {}
    )
