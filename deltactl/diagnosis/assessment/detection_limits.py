"""From which size on an effect would have been seen in a recording."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy.special import chdtri, chndtrinc, ndtri

from deltactl.diagnosis.answer.records import NotTestable, SmallestDetectable
from deltactl.diagnosis.answer.verdict import ALARM
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.assessment.regression_holdout import scaled_covariance
from deltactl.diagnosis.assessment.significance import charge
from deltactl.diagnosis.evidence.detection import Detection
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Candidate
from deltactl.diagnosis.plants.regression import Regressor, Shown, Size
from deltactl.diagnosis.score_tests.library import Entry
from deltactl.diagnosis.selection.named_first import Selected

NORMAL_FROM = 1e5
"""Chi-square from which on the normal approximation is as good as the exact distribution."""


def limits(tests: Detection) -> tuple[list[NotTestable], list[SmallestDetectable]]:
    """Both lists, by effect and component."""
    library = tests.prepared.library
    why = "nothing that was observed depends on it in this recording"
    unseen = [one for one in library.not_identifiable if not one.members]
    untested = [NotTestable.of(one.effect, one.component, why) for one in unseen]
    independent = tests.calibration.tests + tests.event_tests
    held = _absorbed(tests)
    smallest: dict[tuple[str, ...], SmallestDetectable] = {}
    for number, entry in enumerate(library.entries):
        one = entry.candidate
        if one is None or one.members or entry.shape is None or not entry.shape.linear:
            continue
        size = _smallest(tests, number, one, independent, held.get(number))
        if size is None:
            why = "what it would do cannot be distinguished from what is always fitted"
            untested.append(NotTestable.of(one.effect, one.component, why))
        elif entry.key not in smallest or _better(entry, size, smallest[entry.key].value):
            smallest[entry.key] = SmallestDetectable(
                effect=one.effect,
                component=one.component,
                parameter=one.kind.main.name,
                value=size,
                unit=one.kind.main.unit,
            )
    seen = {(s.effect, s.component) for s in smallest.values()}
    unique = {(h.effect, h.component): h for h in untested if (h.effect, h.component) not in seen}
    return list(unique.values()), list(smallest.values())


def _smallest(
    tests: Detection,
    number: int,
    one: Candidate,
    independent: float,
    held: tuple[float, float] | None,
) -> float | None:
    """From which size on the test of an entry raises the alarm; held: as `_absorbed` has it."""
    entry, scorer = tests.prepared.library.entries[number], tests.prepared.scorer
    scatter = float(scorer.variance_inflation[number])
    factor = scatter * float(scorer.tolerance_factor[number])
    left = scatter * float(scorer.left_by_measured[number])
    needed = _needed(independent, entry.df, scatter, factor, left)
    size = _size(entry, tests.scores_of_empty.information[number], needed)
    if (spread := tests.left_by_measured.spread_of(one)) is not None:
        away = spread * math.sqrt(_needed(independent, entry.df, 1.0, 1.0, 0.0))
        return 1.0 / away if one.kind.main.reciprocal else away
    return size if size is None or held is None else _beyond(entry, size, *held)


def _needed(tests: float, df: int, scatter: float, factor: float, left: float) -> float:
    """Chi-square that an effect must bring, for the alarm to be raised with the power wanted.

    tests: independent ones. scatter: how much more the score varies than by white noise. factor: by
    how much it must exceed what chance makes, with what no robot file promises. left: what
    effects that were measured before may leave of it.
    """
    threshold = float(chdtri(df, ALARM / tests)) * factor + left
    # Noise makes `scatter` times a chi-square of its own; the effect is what lies beyond it.
    return scatter * noncentrality(threshold / scatter, df, ASSESSMENT.power)


def noncentrality(threshold: float, df: int, power: float) -> float:
    """Noncentrality of a chi-square variable that exceeds a threshold with that probability.

    Far out its distribution is normal, with mean df + n and variance 2 df + 4 n (Johnson, Kotz and
    Balakrishnan 1995, section 29.5); the series for the exact one takes minutes there. Readings
    without noise lead so far.
    """
    if threshold < NORMAL_FROM:
        return float(chndtrinc(threshold, df, 1.0 - power))
    z, above = float(ndtri(power)), threshold - df
    return above + 2.0 * z * z + float(np.sqrt(4.0 * z * z * (above + z * z + 0.5 * df)))


def _size(entry: Entry, information: FloatArray, needed: float) -> float | None:
    """The size that brings so much; in a direction of average information among the columns."""
    assert entry.candidate is not None
    assert entry.shape is not None
    number = entry.shape.linear[0]
    coordinate = entry.candidate.coordinates[number]
    mean = float(np.trace(information)) / len(information)
    if mean <= 0.0:
        return None
    size = float(np.sqrt(needed / mean))
    if size > coordinate.high - coordinate.low:
        return None
    return 1.0 / size if coordinate.how == "reciprocal" else size


def _absorbed(tests: Detection) -> dict[int, tuple[float, float]]:
    """Entries whose effect a nuisance at an end of its range takes up before a test sees any of it.

    Such a nuisance was not free to give way when nothing was there, and its information counts; it
    is free to take what comes from the other side. By number of the entry: how much of a nuisance
    one unit of the effect is, and how far the nuisance can go.
    """
    empty, white = tests.empty, tests.prepared.library.white
    found: dict[int, tuple[float, float]] = {}
    place = 0
    for term in empty.nuisances:
        for i in term.candidate.moved:
            coordinate, at = term.candidate.coordinates[i], float(term.at[i])
            if at in (coordinate.low, coordinate.high):
                column = empty.tangent[: len(white), place]
                if not column.any():  # what it changes is not in this recording
                    place += 1
                    continue
                shared = white.T @ column.astype(np.float32) / float(column @ column)
                room = coordinate.high - coordinate.low
                way = 1.0 if at == coordinate.low else -1.0
                for number, entry in enumerate(tests.prepared.library.entries):
                    own = white[:, entry.columns.start].astype(np.float64)
                    alike = float(shared[entry.columns.start])
                    least = ASSESSMENT.taken_up * np.linalg.norm(own)
                    if way * alike * np.linalg.norm(column) > least:
                        found[number] = abs(alike), room
            place += 1
    return found


def _beyond(entry: Entry, size: float, alike: float, room: float) -> float | None:
    """A size with what a nuisance takes of it first; None where the effect ends before that."""
    assert entry.candidate is not None
    assert entry.shape is not None
    coordinate = entry.candidate.coordinates[entry.shape.linear[0]]
    more = size + room / alike
    return None if more > coordinate.high - coordinate.low else more


def _better(entry: Entry, size: float, than: float) -> bool:
    assert entry.candidate is not None
    reciprocal = entry.candidate.kind.main.reciprocal
    return size > than if reciprocal else size < than


def detection_limits(selected: Selected) -> list[SmallestDetectable]:
    """Size of each absent effect that raises the alarm with 80 % power.

    It must gain what effects of the file may leave as well: so much is not held against a file.
    """
    best = selected.best
    charged = charge(selected.plant, selected.noise, best)
    at_sigma = math.hypot(ASSESSMENT.found_at_sigma, math.sqrt(charged))
    found: dict[tuple[str, str], SmallestDetectable] = {}
    for regressor in selected.plant.regressors:
        if regressor.key in best.keys or regressor.left_over or regressor.beside:
            continue
        for one in _limits(selected, regressor, at_sigma):
            found.setdefault((one.effect, one.component), one)
    named = {(r.effect, r.component) for r in selected.plant.regressors if r.key in best.keys}
    return [one for name, one in found.items() if name not in named]


def _limits(
    selected: Selected, regressor: Regressor, at_sigma: float
) -> Iterator[SmallestDetectable]:
    """Detection limits of one regressor, under every name that it may go by."""
    shown = selected.plant.shown(regressor.key)
    if not shown:
        return
    names = [regressor.effect]
    if regressor.sizes:
        more = ASSESSMENT.of_a_second_size if len(regressor.sizes) > 1 else 0.0
        value = _by_secant(selected, regressor, shown[0], math.hypot(at_sigma, more))
        names += [same.effect for same in regressor.equivalents if not same.only_if_zero]
    else:
        value = _by_covariance(selected, regressor, shown[0], at_sigma)
    if value is None:
        return
    for effect in names:
        yield SmallestDetectable(
            effect=effect,
            component=regressor.component,
            parameter=shown[0].name,
            value=value,
            unit=shown[0].unit,
        )


def _by_covariance(
    selected: Selected, regressor: Regressor, shown: Shown, at_sigma: float
) -> float | None:
    best, with_it = selected.best, selected.best.keys | {regressor.key}
    if with_it not in selected.evidence:
        return None
    beside = {one.key for one in selected.plant.regressors if one.key in regressor.apart_from}
    more = selected.evidence(with_it | beside, [best])
    at = [i for i, name in enumerate(more.names) if name.startswith(f"{regressor.key}.")]
    if len(at) != 1:
        return None
    spread = at_sigma * float(np.sqrt(scaled_covariance(more, beside)[at[0], at[0]]))
    name = more.names[at[0]][len(regressor.key) + 1 :]
    return abs(float(shown.of({name: np.asarray(spread)})) - shown.nothing)


def _by_secant(
    selected: Selected, regressor: Regressor, shown: Shown, at_sigma: float
) -> float | None:
    """None where no size that was looked for would show."""
    size = next((one for one in regressor.sizes if one.name == shown.name), None)
    if size is None or size.prior != "half":
        return None
    resolution = selected.plant.rounding * math.sqrt(12.0)
    at = size.spread
    for _ in range(ASSESSMENT.secant_rounds):
        information = _information(selected, regressor, size, at)
        if not information > 0.0:
            return None
        at = min(at_sigma / math.sqrt(information), size.high)
    return max(at, resolution) if at < size.high else None


def _information(selected: Selected, regressor: Regressor, size: Size, at: float) -> float:
    """Information on a size, from its secant, less what the chosen set would take over."""
    plant, best, key = selected.plant, selected.best, regressor.key
    own = {f"{key}.{one.name}": max(one.low, 0.0) for one in regressor.sizes}
    own[f"{key}.{size.name}"] = at
    bent = plant.base(best.keys | {key}, {**best.sizes, **own})
    change = selected.noise.whiten(bent - plant.base(best.keys, best.sizes)) / at
    left = change - best.tangent @ _most_probable(change, best.tangent)
    return float(change @ left)


def _most_probable(white: FloatArray, shapes: FloatArray) -> FloatArray:
    """Sizes (p,) of whitened shapes (m, p), each times its prior spread, given values (m,)."""
    gram = shapes.T @ shapes
    return np.linalg.solve(gram + np.eye(len(gram)), shapes.T @ white)
