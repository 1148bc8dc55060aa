"""A delta near a point, as a plant whose model error is a sum of columns.

All channels lie end to end. Named effects, tolerances and nuisances are columns: derivatives near
a point, which is a set of effects at sizes. Once a set is chosen there it is fitted to its end, and
columns are made anew.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property

import numpy as np

from deltactl.diagnosis.evidence.explanation import Explanation
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.answer_near_point import AnswerNearPoint
from deltactl.diagnosis.plants.delta.beside_point import Absorbed, BesidePoint
from deltactl.diagnosis.plants.delta.fitted_to_end import fitted_to_end
from deltactl.diagnosis.plants.delta.jumps import jumps, late_of
from deltactl.diagnosis.plants.delta.noise_of_channels import (
    ChannelsNoise,
    fast_noise,
    in_figures,
    saturated_noise,
)
from deltactl.diagnosis.plants.delta.options import DELTA_FITS, PROCESSES
from deltactl.diagnosis.plants.delta.point import (
    Around,
    Near,
    is_straight,
    key_of,
    side_by_side,
)
from deltactl.diagnosis.plants.delta.prior_odds import named_regressor, unknown_regressor
from deltactl.diagnosis.plants.delta.recorded import Recorded
from deltactl.diagnosis.plants.delta.unknown import Process
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.plants.regressor import Columns, Regressor, Sizes
from deltactl.diagnosis.plants.shared_parameters import apart
from deltactl.diagnosis.priors.options import PENALTIES


class DeltaPlant(AnswerNearPoint):
    """A delta near a point."""

    averages = True
    at_once = DELTA_FITS.at_once

    def __init__(
        self,
        recorded: Recorded,
        terms: Sequence[Term] = (),
        before: DeltaPlant | None = None,
        careful: float = PENALTIES.most_careful,
        unknown: Sequence[Process] = (),
        always: Sequence[Term] | None = None,
    ):
        """terms, always: at work at the point, nuisances too. before: the same near an earlier one.

        careful: share of usual tolerances that building has left. unknown: processes that compete
        with the names.
        """
        self.unknown = {one.key: one for one in unknown}
        self.recorded, self.careful, self._before = recorded, careful, before
        model = recorded.model
        self.readings, self.observed = model.readings, recorded.observed
        self.channel = self.readings.names[0]
        self.unit = self.readings.units[int(np.argmax(in_figures(self.readings)))]
        self.count = len(self.readings.names)
        self.kinds = np.repeat(np.arange(self.count), len(self.readings.t_s))
        self.rows = np.flatnonzero(recorded.valid.T.ravel())
        self.stale = recorded.stale
        self.around = Around(model, terms, always)
        self.nuisances = recorded.free[3]
        self.at_work = {key_of(term.candidate): term for term in terms}

    @cached_property
    def _left(self) -> FloatArray:
        return self.observed - self.around.predicted

    @cached_property
    def _first(self) -> ChannelsNoise:
        """The noise of an earlier point, or what is not smooth in the model error."""
        if self._before is not None:
            return self._with_discrepancy(self._before.plain_noise)
        return fast_noise(self.readings, self.recorded.valid, self._left)

    @cached_property
    def own_noise(self) -> ChannelsNoise:
        """With what effects leave that act now and then only, and are messy where they do."""
        return self._with_discrepancy(self.plain_noise)

    def noise_over(self, plants: Sequence[RegressionPlant]) -> ChannelsNoise:
        """With what local effects at work near any of these points leave."""
        noise, deltas = self.plain_noise, [one for one in plants if isinstance(one, DeltaPlant)]
        scales = [one._with_discrepancy(noise).scale for one in deltas]
        return replace(noise, scale=np.min(scales, axis=0))

    def _with_discrepancy(self, noise: ChannelsNoise) -> ChannelsNoise:
        scale = noise.scale
        for term in self.at_work.values():
            kind = term.candidate.kind
            if kind.local:
                change = self.around.done_by(term)
                white = noise.whiten(change)
                left = kind.discrepancy.elsewhere * float(white @ white)
                acts = np.any(side_by_side(change, self.count) != 0.0, axis=1)
                where = np.tile(acts, self.count)[noise.rows]
                scale = np.where(where, scale / np.sqrt(1.0 + left), scale)
        return replace(noise, scale=scale)

    def _like(self, other: DeltaPlant | None) -> bool:
        """Whether another point has the same processes among its columns."""
        return other is not None and other.unknown.keys() == self.unknown.keys()

    @cached_property
    def plain_noise(self) -> ChannelsNoise:
        """Noise that all columns leave; that of an earlier point once it was made at two."""
        before = self._before
        if before is not None and self._like(before) and before._like(before._before):
            return before.plain_noise
        columns = [self.recorded.free[0]]
        columns += [near.columns(key in self.at_work).values for key, near in self.near.items()]
        columns += [self._columns[key].values for key in self.unknown]
        every = np.concatenate(columns, axis=1)
        valid, first = self.recorded.valid, self._first
        rounds = EVIDENCE.noise_rounds if self._before is None else 1
        return saturated_noise(self.readings, valid, self._left, every, first, rounds)

    @cached_property
    def regressors(self) -> tuple[Regressor, ...]:  # type: ignore[override]
        """One for each effect at each component."""
        named = [named_regressor(key, near, self._free.names) for key, near in self.near.items()]
        return (*named, *(unknown_regressor(one) for one in self.unknown.values()))

    @cached_property
    def t_s(self) -> FloatArray:
        """(n c,) times of all channels."""
        return np.tile(self.readings.t_s, self.count)

    @cached_property
    def counts(self) -> FloatArray:
        """(n c,) 1 in the channels that figures are of."""
        return np.repeat(in_figures(self.readings), len(self.readings.t_s))

    @cached_property
    def groups(self) -> IntArray:
        """(n c,) stretches, each channel's its own."""
        own = np.cumsum(self.readings.fresh)
        laid = [own + k * (own[-1] + 1) for k in range(self.count)]
        numbers: IntArray = np.concatenate(laid).astype(np.intp)
        return numbers

    @cached_property
    def acting(self) -> dict[str, Near]:
        """What is at work, in its derivatives."""
        around = self.around
        return {
            key: Near(term, around.slopes(term, around.predicted), None)
            for key, term in self.at_work.items()
        }

    def _always(self, noise: ChannelsNoise) -> FloatArray:
        """Whitened columns (m, p) of tolerances and of what is at work, in their spreads."""
        parts = [self._free, *(near.columns(True) for near in self.acting.values())]
        every = [part.values * part.spread for part in parts]
        return noise.whiten(np.concatenate(every, axis=1))

    @cached_property
    def _white(self) -> FloatArray:
        return self._always(self._first)

    @cached_property
    def candidates(self) -> dict[str, Candidate]:
        """All of them, with a jump of each joint at its best moment, and those at work, which no
        group has as well.
        """
        late_s = late_of(self.at_work.values())
        found = jumps(self.recorded.model, self._first, self._left, self._white, late_s)
        scanned = {key_of(one.candidate): one.candidate for one in found.values()}
        acting = {key: term.candidate for key, term in self.at_work.items()}
        single = {(one.effect, one.component) for one in acting.values()}
        every = self.recorded.candidates
        others = {key: one for key, one in every.items() if single.isdisjoint(one.in_group)}
        return {**others, **scanned, **acting}

    @cached_property
    def near(self) -> dict[str, Near]:
        """Each regressor near the point."""
        found, known = dict(self.acting), self._before.near if self._before else {}
        names = self._free.names
        beside = BesidePoint(self.around, self._first, self._left, self._white, names)
        for key, candidate in self.candidates.items():
            if key not in found:
                found[key] = beside.near(candidate, self.recorded.starts, known)
        return found

    def free(self) -> Columns:
        """Nuisances, and what is off on any machine as built."""
        return self._free

    @cached_property
    def _free(self) -> Columns:
        values, spread, names, first = self.recorded.free
        if self._before is not None and first:
            pairs = zip(self.around.always, self.recorded.model.nuisances, strict=True)
            own = [self.around.always_slopes(one) @ known.directions for one, known in pairs]
            values = np.concatenate([*own, values[:, first:]], axis=1)
        share = np.where(np.arange(len(spread)) < first, 1.0, self.careful)
        return Columns(values, spread * share, tuple(names))

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """With those of a set that are at work at the point, each as if linear from nothing, and
        nuisances as if linear from where they usually are.
        """
        acting = keys & frozenset(self.at_work)
        if acting not in self._bases:
            terms = [term for key, term in self.at_work.items() if key in acting]
            base = self.around.with_terms(terms) - self._beyond_usual
            for key in sorted(acting):
                base = base - self.acting[key].slopes @ self.acting[key].away
            self._bases[acting] = base
        return self._bases[acting]

    @cached_property
    def _beyond_usual(self) -> FloatArray:
        """What nuisances do at the point beyond where they usually are, (n c,)."""
        whole = self._sizes_of_nuisances
        change: FloatArray = self._free.values[:, : len(whole)] @ whole
        return change

    @cached_property
    def _sizes_of_nuisances(self) -> FloatArray:
        """(p,) at the point, from where they usually are."""
        pairs = zip(self.recorded.model.nuisances, self.around.always, strict=True)
        return np.concatenate([np.zeros(0), *(one.sizes(term.at) for one, term in pairs)])

    @cached_property
    def _bases(self) -> dict[frozenset[str], FloatArray]:
        return {}

    def columns(self, key: str, base: FloatArray, sizes: Sizes) -> Columns:
        """Near the point, or from nothing to the best fit."""
        return self._columns[key]

    @cached_property
    def _columns(self) -> dict[str, Columns]:
        model = self.recorded.model
        named = {key: near.columns(key in self.at_work) for key, near in self.near.items()}
        return {**named, **{key: one.columns(model) for key, one in self.unknown.items()}}

    def impossible(
        self, keys: frozenset[str], sizes: Sizes, linear: Mapping[str, FloatArray]
    ) -> bool:
        """Whether a size that cannot be below nothing is, or one at work is none of a machine."""
        named, acting = keys & self.near.keys(), keys & self.acting.keys()
        return any(self.near[key].below_nothing(linear[key]) for key in named) or any(
            self.acting[key].no_machine_has(linear[key]) for key in acting
        )

    def terms_of(self, explanation: Explanation) -> list[Term]:
        """A set with the sizes that a linear fit has found."""
        return [
            self.near[key].moved_by(explanation.linear[key], key in self.at_work)
            for key in sorted(explanation.keys)
            if key in self.near
        ]

    @property
    def point(self) -> frozenset[str]:
        """What is at work at the point."""
        return frozenset(self.at_work)

    def built(self) -> list[tuple[float, DeltaPlant]]:
        """The same as if it had been built with other care, each with its log prior odds."""
        _ = self.own_noise, self._columns  # once, before copies are made
        every = [self if care == self.careful else self._with_care(care) for care in PENALTIES.care]
        return [(one.odds_of_care, one) for one in every]

    def _with_care(self, care: float) -> DeltaPlant:
        other = copy(self)
        other.careful = care
        other.__dict__.pop("_free", None)
        return other

    @property
    def odds_of_care(self) -> float:
        """See `RegressionPlant`."""
        return 0.0 if self.careful == PENALTIES.most_careful else PENALTIES.careless

    def moved_to(self, explanation: Explanation) -> DeltaPlant:
        """The same near a set that was fitted to its end from what was found here."""
        noise = self.own_noise
        free = self._free
        taken = {r.takes_over for r in self.regressors if r.key in explanation.keys} - {""}
        kept = np.array([name not in taken for name in free.names], dtype=bool)
        parts = [free.values[:, kept] * free.spread[kept]]
        parts += [
            self._columns[key].values for key in sorted(explanation.keys & self.unknown.keys())
        ]
        white = noise.whiten(np.concatenate(parts, axis=1))
        start = apart(self.terms_of(explanation), self.recorded.model.candidates)
        others = self._other_starts(start, white)
        always = self._nuisances(explanation)
        around = Around(self.recorded.model, (), always)
        terms = fitted_to_end(around, self.observed, noise, white, start, others)
        kept_open = [self.unknown[key] for key in self.unknown]
        return DeltaPlant(self.recorded, terms, self, self.careful, kept_open, always)

    def is_far(self, before: float, after: float) -> bool:
        """See `RegressionPlant`."""
        return before > DELTA_FITS.far and after < DELTA_FITS.far_share * before

    def holds_at(self, best: Explanation) -> bool:
        """Whether all is linear as far as nuisances were moved."""
        always, whole = self._nuisances(best), self._sizes_of_nuisances
        slopes = self._free.values[:, : len(whole)]
        linear = self.around.predicted + slopes @ (best.linear[""][: len(whole)] - whole)
        there = Around(self.recorded.model, self.around.terms, always).predicted
        white = self.own_noise.whiten(there - linear)
        return float(white @ white) < DELTA_FITS.little_beside

    def _nuisances(self, explanation: Explanation) -> list[Term]:
        """Nuisances where they were fitted."""
        model, first = self.recorded.model, 0
        moved = []
        for nuisance in model.nuisances:
            size = explanation.linear[""][first : first + len(nuisance.spread)]
            first += len(nuisance.spread)
            moved.append(nuisance.at_sizes(size))
        return moved

    def _other_starts(
        self, terms: Sequence[Term], white: FloatArray
    ) -> dict[int, list[FloatArray]]:
        """Places of the cards from which effects that are not linear may start as well."""
        found: dict[int, list[FloatArray]] = {}
        for number, term in enumerate(terms):
            candidate = term.candidate
            if is_straight(candidate):
                continue
            rest = self.around.with_terms([*terms[:number], *terms[number + 1 :]])
            left, taken = self.own_noise.whiten(self.observed - rest), Absorbed(white)
            ranked = self.recorded.starts.best(candidate, self.own_noise, left, taken)
            found[number] = [at for _, at in ranked[: DELTA_FITS.starts_beside]]
        return found

    def opened(self) -> DeltaPlant | None:
        """The same with processes among the regressors, where any gains enough; None where not.

        Those are most probable beside what is at work at the point.
        """
        every = self.recorded.processes.probable(self.own_noise, self._left, self._white)
        least = PROCESSES.opened + 0.5 * self.left_by_names()
        worth = [one for one in every if one.gain - one.paid > least]
        if not worth:
            return None
        at_work, chosen = list(self.at_work.values()), worth[: PROCESSES.most]
        beside = DeltaPlant(self.recorded, at_work, self, self.careful, chosen)
        beside.around, beside.candidates, beside.near = self.around, self.candidates, self.near
        return beside

    def adopt(self, trained: DeltaPlant) -> None:
        """Near the point of another recording, less what happened there once."""
        lasting = {k: t for k, t in trained.at_work.items() if not t.candidate.kind.event}
        self.at_work, self.careful = lasting, trained.careful
        pairs = zip(self.around.always, trained.around.always, strict=True)
        always = [one.moved_to(known.at) for one, known in pairs]
        self.around = Around(self.recorded.model, list(lasting.values()), always)
        self.regressors = trained.regressors
        nothing_of_it = Columns(np.zeros((len(self.observed), 0)), np.zeros(0), lasts=False)
        self._columns = dict.fromkeys(trained.near, nothing_of_it)
        self._columns |= {key: near.columns(True) for key, near in self.acting.items()}
        model = self.recorded.model
        self._columns |= {key: one.columns(model) for key, one in trained.unknown.items()}
