"""The library of candidates: columns of every candidate at every shape, and of spline terms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from mmap import mmap
from typing import Any

import numpy as np
from scipy.linalg.blas import sgemm, ssyrk

from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.side_by_side import side_by_side
from deltactl.diagnosis.estimation.splines import SplineTerm, spline_terms
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.contract import Model
from deltactl.diagnosis.score_tests.options import SCORE_TESTS
from deltactl.models.effects.card import Shape

PARTS = 8
"""In which the columns are whitened side by side."""


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """One test: a candidate at a shape (or a spline term) and its columns in the library."""

    candidate: Candidate | None
    shape: Shape | None
    free: SplineTerm | None
    columns: slice

    @property
    def df(self) -> int:
        """Degrees of freedom of the test."""
        return int(self.columns.stop - self.columns.start)

    @property
    def numbers(self) -> range:
        """Numbers of its columns."""
        return range(self.columns.start, self.columns.stop)

    @property
    def key(self) -> tuple[str, ...]:
        """Candidate it belongs to."""
        if self.candidate is not None:
            return self.candidate.key
        assert self.free is not None
        return ("unknown", self.free.location, self.free.covariate)


@dataclass(slots=True, eq=False)
class Library:
    """Entries, and their columns under a noise model; the raw ones of spline terms, of which each
    sample meets a few, are made where they are needed.
    """

    entries: list[Entry] = field(default_factory=list)
    regressors: dict[int, FloatArray] = field(default_factory=dict)
    """Raw columns (k, channels, n) of candidates, by the number of the entry."""
    inputs: Mapping[str, FloatArray] = field(default_factory=dict)
    """How each location changes the channels, (n, channels)."""
    white: FloatArray = field(default_factory=lambda: np.empty((0, 0)))
    not_identifiable: list[Candidate] = field(default_factory=list)
    """Candidates that change nothing in this recording."""

    def add(self, raw: FloatArray, candidate: Candidate, shape: Shape) -> None:
        """Append a candidate at a shape, with columns (k, channels, n)."""
        self.regressors[len(self.entries)] = raw
        self.entries.append(Entry(candidate, shape, None, self._next(len(raw))))

    def add_free(self, free: SplineTerm) -> None:
        """Append a spline term."""
        self.entries.append(Entry(None, None, free, self._next(free.size)))

    def _next(self, count: int) -> slice:
        first = self.entries[-1].columns.stop if self.entries else 0
        return slice(first, first + count)

    def raw(self) -> FloatArray:
        """All columns as they are in the channels, (c, channels, n)."""
        return np.concatenate(
            [
                self.regressors[number]
                if entry.free is None
                else _laid_out(entry.free.columns(self.inputs[entry.free.location]))
                for number, entry in enumerate(self.entries)
            ]
        )

    def explained(self, weights: FloatArray) -> FloatArray:
        """What all entries change together, with weights (c,) or (c, d): (n, channels, ...)."""
        more = weights.shape[1:]
        samples, channels = next(iter(self.inputs.values())).shape
        changed = np.zeros((samples, channels, *more))
        shapes = {location: np.zeros((samples, 1, *more)) for location in self.inputs}
        for number, entry in enumerate(self.entries):
            part = weights[entry.columns]
            if entry.free is None:
                own = np.tensordot(self.regressors[number], part.astype(np.float32), axes=(0, 0))
                changed += own.swapaxes(0, 1)
            else:
                shapes[entry.free.location][:, 0] += entry.free.basis @ part
        for location, shape in shapes.items():
            changed += self.inputs[location].reshape(samples, channels, *(1 for _ in more)) * shape
        return changed

    def whiten(self, fitter: Fitter) -> None:
        """Bring all columns under the fitter's noise model."""
        total = self.entries[-1].columns.stop
        self.white = np.empty((0, 0))  # room for the new ones
        white = _shared(total, fitter.rows)
        inputs = fitter.inputs

        def part(numbers: range) -> None:
            for number in numbers:
                entry = self.entries[number]
                if entry.free is None:
                    white[entry.columns] = fitter.whiten.each(self.regressors[number])
                else:
                    white[entry.columns] = (
                        inputs[entry.free.location] @ entry.free.basis
                    ).T.toarray()

        count = len(self.entries)
        side_by_side([partial(part, range(k, count, PARTS)) for k in range(PARTS)])
        self.white = white.T

    def forget_raw(self) -> None:
        """Make room: the columns have been whitened for the last time."""
        self.regressors.clear()

    def forget_white(self) -> None:
        """Make room: no solution is scored any more."""
        self.white = np.empty((0, 0))

    def gram(self) -> FloatArray:
        """Products of all whitened columns with each other, (c, c)."""
        white, middle = self.white, self.white.shape[1] // 2
        parts = slice(0, middle), slice(middle, white.shape[1])
        products = np.zeros((white.shape[1], white.shape[1]), dtype=np.float32)
        beside, *own = side_by_side(
            [
                partial(sgemm, 1.0, white[:, parts[0]], white[:, parts[1]], trans_a=1),
                *(partial(ssyrk, 1.0, white[:, part], trans=1) for part in parts),
            ]
        )
        products[parts] = beside
        for part, half in zip(parts, own, strict=True):
            products[part, part] = half
        half = products.astype(np.float64)
        whole: FloatArray = half + half.T - np.diag(np.diag(half))
        return whole


def _shared(rows: int, columns: int) -> Any:
    """Memory for numbers (rows, columns) of four bytes that forked processes write into, too."""
    room = mmap(-1, 4 * rows * columns)
    return np.frombuffer(room, dtype=np.float32).reshape(rows, columns)


def build(model: Model) -> Library:
    """Columns around the nominal machine."""
    library = Library()
    always = [nuisance.term for nuisance in model.nuisances]
    nominal = model.predict(always)
    candidates = [*model.candidates, *model.groups]
    tasks = [partial(_columns_of, model, one, nominal) for one in candidates]
    for candidate, columns in zip(candidates, side_by_side(tasks), strict=True):
        for number, raw in columns.items():
            library.add(raw, candidate, candidate.shapes[number])
        if not columns:
            library.not_identifiable.append(candidate)
    library.inputs = model.inputs()
    for free in spline_terms(model):
        library.add_free(free)
    return library


def _columns_of(model: Model, candidate: Candidate, nominal: FloatArray) -> dict[int, FloatArray]:
    """Columns (k, channels, n) of a candidate, by the number of the shape that shows any."""
    columns = {}
    for number, shape in enumerate(candidate.shapes):
        raw = regressors(model, candidate, shape, nominal)
        if np.abs(raw).max(initial=0.0) * shape.reach > SCORE_TESTS.least_change:
            columns[number] = _laid_out(raw)
    return columns


def _laid_out(raw: FloatArray) -> FloatArray:
    """Columns (n, channels, k) one after another, (k, channels, n)."""
    return np.ascontiguousarray(raw.T, dtype=np.float32)


def regressors(model: Model, candidate: Candidate, shape: Shape, nominal: FloatArray) -> FloatArray:
    """Change of the channels per unit of each linear coordinate, (n, channels, k)."""
    always = [nuisance.term for nuisance in model.nuisances]
    origin = np.array(shape.origin)
    if not shape.linear:
        changed = model.predict([*always, Term(candidate, origin)])
        return (changed - nominal)[:, :, None]
    columns = []
    for i in shape.linear:
        at = origin.copy()
        at[i] += shape.reach
        changed = model.predict([*always, Term(candidate, at)])
        columns.append((changed - nominal) / shape.reach)
    return np.stack(columns, axis=2)
