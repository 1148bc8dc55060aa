"""Unknown physics of a regression plant: a spline term a covariate, in what named effects leave."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.evidence.repeats import Repeats, repeats
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray
from deltactl.diagnosis.plants.options import SPLINE_TERMS
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.plants.regressor import Columns, Regressor, Sizes
from deltactl.diagnosis.plants.spline_terms import less_spanned, spline_over

UNKNOWN = "unknown "


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """What an error without a name may follow, (n,), and into how many pieces its range is cut."""

    along: FloatArray
    pieces: int
    follows: tuple[str, ...]
    component: str = "axis"
    times: FloatArray | None = None
    """What it grows with besides, (n,)."""
    given: FloatArray | None = None
    """Its shapes (n, k), where they are no splines."""
    gives_way: bool = True
    """Whether it gives way to the shapes of a chosen set too."""
    acts: BoolArray | None = None
    """Rows (n,) on which it acts; all where None."""
    as_built: float = 0.0
    """Size up to which any machine has it."""
    named: FloatArray | None = None
    """Named shapes (n, j) that it may not take the place of; those of the plant where None."""

    def shapes(self, named: FloatArray, rows: IntArray) -> FloatArray:
        """Shapes (n, k) less what named ones (n, j) span, by some rows where it acts."""
        own = rows if self.acts is None else rows[self.acts[rows]]
        basis = spline_over(self.along, self.pieces, own) if self.given is None else self.given
        basis = basis if self.times is None else basis * self.times[:, None]
        left = less_spanned(basis, named, own)
        return left if self.acts is None else left * self.acts[:, None]


@dataclass(frozen=True, slots=True)
class FineMap:
    """A spline term over position in as much detail as the residual of a set repeats."""

    keys: frozenset[str]
    sizes: Sizes
    repeats: Repeats


class LeftOver(RegressionPlant):
    """A plant with spline terms; regressors `unknown NAME`."""

    unknown_log_odds = SPLINE_TERMS.unknown_log_odds
    maps_places = False
    """Whether a model error over position may be mapped in detail."""
    _map: FineMap | None = None

    def pieces(self, name: str) -> int:
        """Into how many pieces the range of a covariate is cut."""
        raise NotImplementedError

    def ways(self) -> dict[str, Way]:
        """One for each covariate, by its name."""
        return {
            name: Way(values, self.pieces(name), (name,))
            for name, values in self.covariates.items()
        }

    def spanned(self, name: str) -> FloatArray:
        """Named shapes (n, j) that this spline term may not take the place of."""
        raise NotImplementedError

    def spread_of(self, name: str, shapes: int) -> float:
        """Prior spread of each of the shapes of a spline term, in the unit of `observed`."""
        raise NotImplementedError

    @property
    def between(self) -> float:
        """Root mean square of what happens between two samples: a periodic motion repeats it."""
        if self.unsampled is None:
            return 0.0
        return float(np.sqrt(np.mean(self.unsampled[self.rows] ** 2)))

    def unknowns(self) -> list[Regressor]:
        """The regressors."""
        return [
            Regressor(
                UNKNOWN + name, "unknown", self.unknown_log_odds, way.component,
                follows=way.follows, left_over=True, as_built=way.as_built,
            )
            for name, way in self.ways().items()
        ]  # fmt: skip

    def places(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """Places (n,) over which a model error is mapped in detail."""
        return self.covariates["position"]

    def map_finely(self, keys: frozenset[str], sizes: Sizes, left: FloatArray) -> bool:
        """Over the places that the axis comes to, see `RegressionPlant`."""
        if self._map is not None or not self.maps_places:
            return False
        rows, at = self.rows, self.places(keys, sizes)
        found = repeats(left[rows], at[rows], self.groups[rows], len(rows) / EVIDENCE.rows_a_cell)
        if found is None or found.size <= self.between:
            return False
        self._map = FineMap(keys, dict(sizes), found)
        self.__dict__.pop("_unknown", None)
        return True

    def detail(self, key: str) -> int:
        """Detail of a map, see `RegressionPlant`."""
        return self._map.repeats.cells if self._map and key == UNKNOWN + "position" else 0

    def adopt(self, trained: Any) -> None:
        """Map in detail of the recording that sizes were found on."""
        self._map = trained._map

    def followed(self, key: str) -> FloatArray:
        """What an unknown follows, (n,); NaN where it does not act."""
        way = self.ways()[key.removeprefix(UNKNOWN)]
        return way.along if way.acts is None else np.where(way.acts, way.along, np.nan)

    def unknown(self, key: str) -> Columns:
        """Shapes (n, k) of an unknown."""
        return self._unknown[key.removeprefix(UNKNOWN)]

    @cached_property
    def _unknown(self) -> Mapping[str, Columns]:
        found = {}
        for name, way in self.ways().items():
            mapped = self._map if name == "position" else None
            if mapped:
                at = self.places(mapped.keys, mapped.sizes)
                way = replace(way, along=at, pieces=mapped.repeats.cells)
            beside = [self.beside] if way.gives_way else []
            own = self.spanned(name) if way.named is None else way.named
            named = np.concatenate([own, *beside], axis=1)
            shapes = way.shapes(named, self.rows)
            count = shapes.shape[1]
            size = self.spread_of(name, count)
            if mapped:  # what repeats is shared among all shapes
                even = mapped.repeats.size / math.sqrt(max(count, 1))
                size = max(SPLINE_TERMS.uneven_map * even, 1e-300)
            found[name] = Columns(shapes, np.full(count, size))
        return found
