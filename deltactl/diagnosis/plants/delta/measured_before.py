"""What a robot file knows from earlier diagnoses: sizes that were measured are known only about.

A drive is not of first order and friction has no single width: such an effect of the file is fitted
within its interval, and what its operator leaves is no second effect (`EffectKind.discrepancy`).
Lengths, offsets and what somebody wrote by hand stay as the file has them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import zip_longest
from typing import Any

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.candidates import candidates_of
from deltactl.diagnosis.plants.nuisance import Nuisance
from deltactl.models.effects import VOCABULARY
from deltactl.models.effects.card import Coordinate
from deltactl.models.effects.kind import EXACT, EffectKind
from deltactl.models.robot import DeltaRobot, EffectEntry, FoundBy

NARROWEST = 1e-3
"""Share of the step of a derivative: what is known more exactly is no more exact in a fit."""
BESIDE_MEASURED = 2.0
"""Times its usual spread that a small error has beside effects simpler than the machine: a drive of
second order that became slower looks like half a percent of its ratio as well."""
WIDTH = 2.0 * 1.96
"""Width of an interval of 95 %, in standard deviations."""


def measured_before(
    robot: DeltaRobot, travel_rad: float, span_s: float
) -> tuple[DeltaRobot, list[Nuisance]]:
    """The robot without the effects that are fitted again, and these around their sizes."""
    stays: list[EffectEntry] = []
    measured: list[Nuisance] = []
    for entry in robot.effects:
        nuisance = _nuisance(entry, travel_rad, span_s)
        if nuisance is None:
            stays.append(entry)
        else:
            measured.append(nuisance)
    return robot.model_copy(update={"effects": tuple(stays)}), measured


def changes(candidates: list[Candidate], measured: Sequence[Nuisance]) -> list[Candidate]:
    """Candidates, of which those that were measured act as a change of what is known of them."""
    known = {n.term.candidate.key: n.term for n in measured}
    return [_change(one, known.get(one.key)) for one in candidates]


def _change(candidate: Candidate, known: Term | None) -> Candidate:
    if known is None or not _adds_up(candidate, known):
        return candidate
    coordinates = tuple(
        replace(one, low=one.low - at, high=one.high - at)
        for one, at in zip(candidate.coordinates, known.at, strict=True)
    )
    return replace(candidate, coordinates=coordinates)


def _adds_up(candidate: Candidate, known: Term) -> bool:
    """Whether a change has the coordinates of what changes, to be added; logarithms are not."""
    pairs = [(one.parameter, one.how) for one in candidate.coordinates]
    return pairs == [(one.parameter, one.how) for one in known.candidate.coordinates]


def joined(terms: Sequence[Term], measured: Sequence[Nuisance]) -> list[Term]:
    """Terms, of which a change and what changes are one."""
    known = {n.term.candidate.key for n in measured}
    found: dict[int | tuple[str, ...], Term] = {}
    for number, term in enumerate(terms):
        key = term.candidate.key
        if key in known and key in found and _adds_up(term.candidate, found[key]):
            term = Term(found[key].candidate, found[key].at + term.at)
            found[key] = term
        else:
            found[key if key in known and key not in found else number] = term
    return list(found.values())


def beside(measured: Sequence[Nuisance], tolerances: Sequence[Nuisance]) -> list[Nuisance]:
    """Small errors that are fitted beside measured effects, which move them a little as well."""
    taken = {one.term.candidate.key for one in measured}
    return [
        replace(one, spread=tuple(BESIDE_MEASURED * spread for spread in one.spread), held=True)
        for one in tolerances
        if one.term.candidate.key not in taken
    ]


def _nuisance(entry: EffectEntry, travel_rad: float, span_s: float) -> Nuisance | None:
    kind = VOCABULARY.get(entry.effect)
    if entry.found is None or kind is None or kind.discrepancy.elsewhere <= EXACT:
        return None
    every = candidates_of(entry.effect, travel_rad, span_s)
    row = next((one for one in every if one.component == entry.component), None)
    if row is None or kind.main.name not in entry.found.ci95:
        return None
    moved = tuple(one for one in row.coordinates if one.how != "log")
    values: dict[str, Any] = {p.name: p.default for p in kind.parameters if p.default is not None}
    values |= entry.parameters
    candidate = Candidate(kind, entry.component, moved, (), _fixed(values, moved))
    at = np.array([_coordinate(one, values[one.parameter], values) for one in moved])
    total = _alike(kind, moved, at)
    read = [_spread(one, entry.found.ci95.get(one.parameter), values) for one in moved]
    spread = np.hypot(read, np.sqrt(kind.discrepancy.elsewhere) * total)
    together = _together(entry.found, kind, moved, total)
    return Nuisance(Term(candidate, at), tuple(spread.tolist()), True, True, together)


def _together(
    found: FoundBy, kind: EffectKind, moved: Sequence[Coordinate], total: FloatArray
) -> float | None:
    """Standard deviation of the sum of coordinates of one unit; None where they have no sum."""
    if len(total) < 2 or np.ptp(total) > 0.0:
        return None
    own = {one.parameter for one in moved}
    parts = zip_longest(*(found.spread.get(name, ()) for name in own), fillvalue=0.0)
    read = np.linalg.norm([sum(part) for part in parts])
    return float(np.hypot(read, np.sqrt(kind.discrepancy.in_pose) * total[0]))


def _alike(kind: EffectKind, moved: Sequence[Coordinate], at: FloatArray) -> FloatArray:
    """For each coordinate, the size of all of its unit together, (k,); none of a logarithm.

    What an operator leaves moves sizes with the motion: a drive of second order is late by another
    dead time and another time constant in each, whose sum hardly changes.
    """
    units = {one.name: one.unit for one in kind.parameters}
    own = [(units[one.parameter], one.how == "log") for one in moved]
    total = [
        0.0 if log else sum(abs(at[k]) for k, other in enumerate(own) if other == (unit, log))
        for unit, log in own
    ]
    return np.array(total)


def _fixed(values: dict[str, Any], moved: tuple[Coordinate, ...]) -> dict[str, Any]:
    """Values of the parameters that stay; a wave's two coordinates have its phase."""
    waves = any(one.how in ("sine", "cosine") for one in moved)
    own = {one.parameter for one in moved} | ({"phase"} if waves else set())
    return {name: value for name, value in values.items() if name not in own}


def _coordinate(coordinate: Coordinate, value: Any, values: Mapping[str, Any]) -> float:
    """A parameter in the coordinate that the fit moves, see `Candidate.values`."""
    size = float(np.asarray(value))
    phase_rad = float(np.asarray(values.get("phase", 0.0)))
    match coordinate.how:
        case "reciprocal":
            return 1.0 / size if size else np.inf
        case "log":
            return float(np.log(size))
        case "sine":
            return size * float(np.cos(phase_rad))
        case "cosine":
            return size * float(np.sin(phase_rad))
        case _:
            return size


def _spread(coordinate: Coordinate, interval: Any, values: Mapping[str, Any]) -> float:
    least = NARROWEST * coordinate.step
    if interval is None:
        return least
    low, high = (float(np.asarray(end)) for end in interval)
    if coordinate.how in ("sine", "cosine"):
        return max((high - low) / WIDTH, least)
    ends: FloatArray = np.array([_coordinate(coordinate, end, values) for end in (low, high)])
    return max(float(np.ptp(ends)) / WIDTH, least)
