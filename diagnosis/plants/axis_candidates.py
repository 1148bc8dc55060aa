"""How the fit moves in each effect of a lone axis or sensor, and from which points it starts."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from diagnosis.observations.readings import FloatArray
from diagnosis.plants.candidate import Candidate, Coordinate, Shape
from models.effects.kind import EffectKind
from models.effects.lone_axis import COMPONENT

LAGS_S = (0.02, 0.1)
FINEST_WAVES = 60
"""Half periods over the whole travel up to which periodic errors are looked for, halved."""
RINGING_HZ = (0.7, 1.2, 2.0, 3.2, 5.0, 8.0)
WARM_UP_S = (20.0, 100.0, 500.0, 2500.0)


def simple(kind: EffectKind, reach: float, fixed: dict[str, float] | None = None) -> Candidate:
    """One number in which the effect is nearly linear; `reach` is a small step of it."""
    main = kind.main
    coordinate = Coordinate(main.name, step=reach, low=main.low, high=main.high)
    given = {p.name: p.default for p in kind.parameters if p.default is not None}
    given.update(fixed or {})
    return Candidate(kind, COMPONENT, (coordinate,), (Shape((kind.nothing,), (0,), reach),), given)


def lag(kind: EffectKind, period_s: float) -> Candidate:
    """A dead time, a first-order lag, or both."""
    step = 0.1 * period_s
    coordinates = (
        Coordinate("time", step=step, low=0.0, high=2.0),
        Coordinate("dead_time", step=step, low=0.0, high=2.0),
    )
    shapes = [Shape((0.0, 0.0), (i,), reach) for i, reach in product((0, 1), LAGS_S)]
    return Candidate(kind, COMPONENT, coordinates, tuple(shapes), {})


def part_of_lag(kind: EffectKind, period_s: float, part: str) -> Candidate:
    """Only a first-order lag (`time`) or only a dead time; the other is none."""
    coordinate = Coordinate(part, step=0.1 * period_s, low=0.0, high=2.0)
    shapes = tuple(Shape((0.0,), (0,), reach) for reach in LAGS_S)
    other = {"time": "dead_time", "dead_time": "time"}[part]
    return Candidate(kind, COMPONENT, (coordinate,), shapes, {other: 0.0})


def latency(kind: EffectKind, period_s: float) -> Candidate:
    """Readings that are late."""
    coordinate = Coordinate("time", step=0.1 * period_s, low=0.0, high=2.0)
    shapes = tuple(Shape((0.0,), (0,), reach) for reach in LAGS_S)
    return Candidate(kind, COMPONENT, (coordinate,), shapes, {})


def play(kind: EffectKind, widths: Sequence[float]) -> Candidate:
    """Play with a side to start on; several widths, for the operator is not smooth."""
    coordinates = (
        Coordinate("width", step=0.02 * min(widths), low=0.0, high=50.0 * max(widths)),
        Coordinate("start", step=0.05, low=-1.0, high=1.0),
    )
    shapes = tuple(Shape((0.0, start), (0,), w) for w, start in product(widths, (-1.0, 0.0, 1.0)))
    return Candidate(kind, COMPONENT, coordinates, shapes, {})


def compliance(kind: EffectKind, reach: float) -> Candidate:
    """Yields under a known load: linear in one over the stiffness."""
    coordinate = Coordinate("stiffness", "reciprocal", step=reach, low=0.0, high=1e6 * reach)
    return Candidate(kind, COMPONENT, (coordinate,), (Shape((0.0,), (0,), reach),), {})


def periodic(kind: EffectKind, travel: FloatArray, step: float) -> Candidate:
    """Periods from half the travel down to what the samples can follow."""
    span = float(np.ptp(travel))
    pace = float(np.quantile(np.abs(np.diff(travel)), 0.9))
    finest = max(4.0 * pace, 2.0 * span / FINEST_WAVES)
    periods = [2.0 * span / k for k in range(4, FINEST_WAVES + 1) if 2.0 * span / k >= finest]
    coordinates = (
        Coordinate("amplitude", "sine", step=step, low=-span, high=span),
        Coordinate("amplitude", "cosine", step=step, low=-span, high=span),
        Coordinate("period", "log", step=2e-3, low=np.log(0.8 * finest), high=np.log(0.6 * span)),
    )
    shapes = tuple(Shape((0.0, 0.0, float(np.log(p))), (0, 1), step) for p in periods)
    return Candidate(kind, COMPONENT, coordinates, shapes, {})


def ringing(kind: EffectKind, period_s: float) -> Candidate:
    """Ringing at frequencies that the samples can show."""
    coordinates = (
        Coordinate("frequency", "log", step=0.01, low=np.log(0.3), high=np.log(40.0)),
        Coordinate("damping", step=0.01, low=0.005, high=0.5),
    )
    shapes = tuple(
        Shape((float(np.log(hertz)), damping), ())
        for hertz, damping in product(RINGING_HZ, (0.05, 0.2))
        if hertz * period_s < 0.25
    )
    return Candidate(kind, COMPONENT, coordinates, shapes, {})


def drift(kind: EffectKind, span_s: float) -> Candidate:
    """Drift towards an offset since the start."""
    coordinates = (
        Coordinate("offset", step=1e-4, low=-0.5, high=0.5),
        Coordinate("time_constant", "log", step=0.05, low=0.0, high=np.log(1e5)),
    )
    times = [time for time in WARM_UP_S if time < span_s] or [span_s / 4.0]
    shapes = tuple(Shape((0.0, float(np.log(time))), (0,), 1e-4) for time in times)
    return Candidate(kind, COMPONENT, coordinates, shapes, {})


def falling(kind: EffectKind, torque: float, speeds: Sequence[float]) -> Candidate:
    """Stribeck friction: a size and the speed within which it falls off."""
    coordinates = (
        Coordinate("torque", step=torque, low=0.0, high=1e6 * torque),
        Coordinate(
            "speed", "log", step=0.02,
            low=float(np.log(0.5 * min(speeds))), high=float(np.log(2.0 * max(speeds))),
        ),
    )  # fmt: skip
    shapes = tuple(Shape((0.0, float(np.log(speed))), (0,), torque) for speed in speeds)
    return Candidate(kind, COMPONENT, coordinates, shapes, {})


def jump(kind: EffectKind, time_s: float, steps: float) -> Candidate:
    """A loss of steps at a time that a scan found."""
    coordinates = (Coordinate("steps", step=steps), Coordinate("time", "frozen"))
    return Candidate(kind, COMPONENT, coordinates, (Shape((0.0, time_s), (0,), steps),), {})
