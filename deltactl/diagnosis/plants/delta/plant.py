"""A delta near a point, as a plant whose model error is a sum of columns.

All channels lie end to end. Named effects, tolerances and nuisances are columns: derivatives near
a point, which is a set of effects at sizes. Once a set is chosen there it is fitted to its end, and
columns are made anew.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from functools import cached_property

import numpy as np

from deltactl.diagnosis.evidence.laplace import Explanation
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, without_outliers
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.beside_point import BesidePoint, Starts
from deltactl.diagnosis.plants.delta.fitted_to_end import fitted_to_end
from deltactl.diagnosis.plants.delta.jumps import jumps
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.plants.delta.noise_of_channels import (
    ChannelsNoise,
    fast_noise,
    saturated_noise,
)
from deltactl.diagnosis.plants.delta.point import (
    Around,
    Near,
    end_to_end,
    is_straight,
    key_of,
    side_by_side,
)
from deltactl.diagnosis.plants.nuisance import Nuisance
from deltactl.diagnosis.plants.regression import Columns, RegressionPlant, Regressor, Sizes
from deltactl.diagnosis.priors.options import PENALTIES
from deltactl.diagnosis.priors.size_priors import odds_cost
from deltactl.diagnosis.score_tests.change_points import without_stale
from deltactl.models.effects import card_of


class Recorded:
    """What does not change with the point: the machine, its readings, columns of tolerances."""

    def __init__(self, model: DeltaModel):
        self.model, readings = model, model.readings
        self.observed = end_to_end(np.nan_to_num(readings.values))
        self.nominal = Around(model, ())
        left = side_by_side(self.observed - self.nominal.predicted, len(readings.names))
        kept, self.stale = without_stale(model)
        self.valid: BoolArray = without_outliers(left, kept)
        self.candidates: dict[str, Candidate] = {key_of(one): one for one in model.candidates}
        self.starts = Starts(self.nominal, model.candidates)

    @cached_property
    def free(self) -> tuple[FloatArray, FloatArray, list[str], int]:
        """Columns (n c, p) of nuisances and tolerances, their spreads and names, how many are
        nuisances.
        """
        model = self.model
        known = {n.term.candidate.key for n in model.nuisances}
        tolerances = [n for n in model.tolerances if n.term.candidate.key not in known]
        columns: list[FloatArray] = []
        spreads: list[float] = []
        names: list[str] = []
        for nuisance in (*model.nuisances, *tolerances):
            slopes = self._slopes(nuisance)
            columns.append(slopes)
            spreads += nuisance.spread
            one = nuisance.term.candidate
            names += [key_of(one)] * slopes.shape[1]
        first = sum(len(n.spread) for n in model.nuisances)
        return np.concatenate(columns, axis=1), np.array(spreads), names, first

    def _slopes(self, nuisance: Nuisance) -> FloatArray:
        around, term = self.nominal, nuisance.term
        if any(one.candidate is term.candidate for one in around.always):
            others = [one for one in around.always if one.candidate is not term.candidate]
            columns = []
            for i in term.candidate.moved:
                at, step = term.at.copy(), term.candidate.coordinates[i].step
                at[i] += step
                moved = self.model.predict([*others, Term(term.candidate, at)])
                columns.append((end_to_end(moved) - around.predicted) / step)
            return np.stack(columns, axis=1)
        return around.slopes(term, around.predicted)


class DeltaPlant(RegressionPlant):
    """A delta near a point."""

    averages = True
    messy = True

    def __init__(
        self,
        recorded: Recorded,
        terms: Sequence[Term] = (),
        noise: ChannelsNoise | None = None,
        beside: Mapping[str, Near] | None = None,
        careful: float = PENALTIES.most_careful,
    ):
        """noise: of an earlier point. beside: best fits there. careful: share of usual tolerances.
        """
        self.recorded, self.careful = recorded, careful
        model = recorded.model
        self.readings, self.observed = model.readings, recorded.observed
        self.channel, self.unit = self.readings.names[0], self.readings.units[0]
        self.count = len(self.readings.names)
        self.kinds = np.repeat(np.arange(self.count), len(self.readings.t_s))
        self.rows = np.flatnonzero(recorded.valid.T.ravel())
        self.around = Around(model, terms)
        self.at_work = {key_of(term.candidate): term for term in terms}
        left = self.observed - self.around.predicted
        self._first = noise or fast_noise(self.readings, recorded.valid, left)
        white = self._always(self._first)
        self.candidates = self._with_jumps(left, white)
        self.near = self._near(left, white, beside or {})
        self.noise = self._noise(left)
        self.regressors = tuple(self._regressor(key) for key in self.candidates)

    @cached_property
    def t_s(self) -> FloatArray:
        """(n c,) times of all channels."""
        return np.tile(self.readings.t_s, self.count)

    @cached_property
    def groups(self):  # type: ignore[no-untyped-def]
        """(n c,) stretches, each channel's its own."""
        own = np.cumsum(self.readings.fresh)
        return np.concatenate([own + k * (own[-1] + 1) for k in range(self.count)]).astype(np.intp)

    @cached_property
    def _acting(self) -> dict[str, Near]:
        """What is at work, in its derivatives."""
        around = self.around
        return {
            key: Near(term, around.slopes(term, around.predicted), None)
            for key, term in self.at_work.items()
        }

    def _always(self, noise: ChannelsNoise) -> FloatArray:
        """Whitened columns (m, p) of tolerances and of what is at work, in their spreads."""
        parts = [self._free, *(near.columns(True) for near in self._acting.values())]
        every = [part.values * part.spread for part in parts]
        return noise.whiten(np.concatenate(every, axis=1))

    def _with_jumps(self, left: FloatArray, white: FloatArray) -> dict[str, Candidate]:
        """All candidates, with a jump of each joint at its best moment, and those at work."""
        found = jumps(self.recorded.model, self._first, left, white)
        scanned = {key_of(one): one for one in found.values()}
        acting = {key: term.candidate for key, term in self.at_work.items()}
        return {**self.recorded.candidates, **scanned, **acting}

    def _near(
        self, left: FloatArray, white: FloatArray, before: Mapping[str, Near]
    ) -> dict[str, Near]:
        found = dict(self._acting)
        beside = BesidePoint(self.around, self._first, left, white)
        for key, candidate in self.candidates.items():
            if key not in found:
                found[key] = beside.near(candidate, self.recorded.starts, before)
        return found

    def _noise(self, left: FloatArray) -> ChannelsNoise:
        columns = [self.recorded.free[0]]
        columns += [near.columns(key in self.at_work).values for key, near in self.near.items()]
        every = np.concatenate(columns, axis=1)
        valid = self.recorded.valid
        return saturated_noise(self.readings, valid, left, every, self._first)

    def _regressor(self, key: str) -> Regressor:
        candidate = self.candidates[key]
        odds = -0.5 * odds_cost(candidate) + self.near[key].heavy_tail
        takes_over = key if card_of(candidate.effect).build_spread is not None else ""
        places = None if is_straight(candidate) else float(len(candidate.shapes))
        return Regressor(
            key, candidate.effect, odds, candidate.component,
            alone=False, takes_over=takes_over, places=places,
        )  # fmt: skip

    def free(self) -> Columns:
        """Nuisances, and what is off on any machine as built."""
        return self._free

    @cached_property
    def _free(self) -> Columns:
        values, spread, names, first = self.recorded.free
        share = np.where(np.arange(len(spread)) < first, 1.0, self.careful)
        return Columns(values, spread * share, tuple(names))

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """With those of a set that are at work at the point, as if they were linear from nothing.
        """
        acting = keys & frozenset(self.at_work)
        if acting not in self._bases:
            terms = [term for key, term in self.at_work.items() if key in acting]
            base = self.around.with_terms(terms)
            for key in acting:
                base = base - self.near[key].slopes @ self.near[key].away
            self._bases[acting] = base
        return self._bases[acting]

    @cached_property
    def _bases(self) -> dict[frozenset[str], FloatArray]:
        return {}

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Near the point, or from nothing to the best fit."""
        return self._columns[key]

    @cached_property
    def _columns(self) -> dict[str, Columns]:
        return {key: near.columns(key in self.at_work) for key, near in self.near.items()}

    def charged(self, gains: Mapping[str, float]) -> float:
        """Chi-square that messy effects of a set may leave in the shapes of smaller ones.

        gains: what each adds to the fit. A bearing, a spring or a stop is messier than any operator
        with two numbers (`Discrepancy`).
        """
        total = 0.0
        for key, gain in gains.items():
            new = self.candidates[key].kind
            left = 0.0
            for other, larger in gains.items():
                if larger > gain:
                    own = self.candidates[other].kind.discrepancy
                    usual = own.in_pose if new.pose_alone else own.elsewhere
                    left += own.leads_to.get(new.name, usual) * larger
            total += min(left, gain)
        return total

    def terms_of(self, explanation: Explanation) -> list[Term]:
        """A set with the sizes that a linear fit has found."""
        return [
            self.near[key].moved_by(explanation.linear[key], key in self.at_work)
            for key in sorted(explanation.keys)
        ]

    @property
    def point(self) -> frozenset[str]:
        """What is at work at the point."""
        return frozenset(self.at_work)

    def built(self) -> list[tuple[float, DeltaPlant]]:
        """The same as if it had been built with other care, each with its log prior odds."""
        found = []
        for care in PENALTIES.care:
            other = copy(self)
            other.careful = care
            other.__dict__.pop("_free", None)
            odds = 0.0 if care == PENALTIES.most_careful else PENALTIES.careless
            found.append((odds, self if care == self.careful else other))
        return found

    def moved_to(self, explanation: Explanation) -> DeltaPlant:
        """The same near a set that was fitted to its end from what was found here."""
        noise = self.noise
        free = self._free
        taken = {r.takes_over for r in self.regressors if r.key in explanation.keys} - {""}
        kept = np.array([name not in taken for name in free.names], dtype=bool)
        white = noise.whiten(free.values[:, kept] * free.spread[kept])
        terms = fitted_to_end(self.around, self.observed, noise, white, self.terms_of(explanation))
        return DeltaPlant(self.recorded, terms, noise, self.near, self.careful)
