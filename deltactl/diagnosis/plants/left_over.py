"""Unknown physics of a regression plant: a spline term a covariate, in what named effects leave."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.options import SPLINE_TERMS
from deltactl.diagnosis.plants.regression import Columns, Regressor
from deltactl.diagnosis.plants.spline_terms import KeepsBeside, spline_terms

UNKNOWN = "unknown "


class LeftOver(KeepsBeside):
    """A plant with one spline term for each of its covariates; regressors `unknown COVARIATE`."""

    rows: IntArray
    averages = False

    @cached_property
    def covariates(self) -> dict[str, FloatArray]:
        """What a model error may follow, name -> (n,)."""
        raise NotImplementedError

    def spanned(self, name: str) -> FloatArray:
        """Named shapes (n, j) that no spline term over this covariate may take the place of."""
        raise NotImplementedError

    def pieces(self, name: str) -> int:
        """Into how many pieces the range of a covariate is cut."""
        raise NotImplementedError

    @property
    def unknown_spread(self) -> float:
        """Prior spread of a spline term's coefficients, in the unit of `observed`."""
        raise NotImplementedError

    def along(self, name: str) -> FloatArray:
        """Where a spline term over this covariate has its pieces, (n,)."""
        return self.covariates[name]

    def spread_of(self, name: str, shapes: int) -> float:
        """Prior spread of each of the shapes of a spline term."""
        return self.unknown_spread

    def unknowns(self) -> list[Regressor]:
        """The regressors."""
        return [
            Regressor(
                UNKNOWN + name,
                "unknown",
                SPLINE_TERMS.unknown_log_odds,
                follows=(name,),
                left_over=True,
            )
            for name in self.covariates
        ]

    def followed(self, key: str) -> FloatArray:
        """Covariate (n,) of an unknown."""
        return self.along(key.removeprefix(UNKNOWN))

    def unknown(self, key: str) -> Columns:
        """Shapes (n, k) of an unknown."""
        return self._unknown[key.removeprefix(UNKNOWN)]

    @cached_property
    def _unknown(self) -> dict[str, Columns]:
        found = {}
        for name in self.covariates:
            named = np.concatenate([self.spanned(name), self.beside], axis=1)
            shapes = spline_terms(self.along(name), self.pieces(name), named, self.rows)
            count = shapes.shape[1]
            found[name] = Columns(shapes, np.full(count, self.spread_of(name, count)))
        return found
