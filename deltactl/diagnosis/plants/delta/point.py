"""A delta with effects at sizes, and how its prediction changes near there.

Near a point everything is linear: effects at work there in all their moved coordinates, effects
that are not in one direction each, from nothing to where they would fit best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.plants.regressor import Columns
from deltactl.diagnosis.priors.options import PENALTIES
from deltactl.diagnosis.priors.size_priors import SizePrior, prior_of
from deltactl.models.effects import Trait, card_of, has
from deltactl.models.effects.kind import EXACT


def end_to_end(channels: FloatArray) -> FloatArray:
    """Channels (n, c) or (n, c, k) one after another, (n c,) or (n c, k)."""
    laid: FloatArray = np.ascontiguousarray(channels.swapaxes(0, 1))
    return laid.reshape(-1, *channels.shape[2:])


def side_by_side(laid: FloatArray, channels: int) -> FloatArray:
    """The other way round: (n c, ...) as (n, c, ...)."""
    return laid.reshape(channels, -1, *laid.shape[1:]).swapaxes(0, 1)


def key_of(candidate: Candidate) -> str:
    """What a candidate is called among regressors."""
    return " ".join(candidate.key)


@dataclass(frozen=True, eq=False)
class Near:
    """A term near a point: where it was linearised, and what one unit of each direction does.

    slopes: (n c, k) derivatives by the moved coordinates at `term.at`. whole: (n c,) what the term
    as a whole does; None where it is the sum of slopes times sizes.
    """

    term: Term
    slopes: FloatArray
    whole: FloatArray | None

    @cached_property
    def prior(self) -> SizePrior:
        """Prior of the moved coordinates."""
        return prior_of(self.term.candidate)

    @cached_property
    def away(self) -> FloatArray:
        """Sizes (k,) from where the effect does nothing; 0 of what is no size."""
        candidate = self.term.candidate
        moved, sizes = candidate.moved, self.prior.sizes
        off = np.zeros(len(moved))
        off[sizes] = (self.term.at - nothing(candidate))[moved][sizes]
        return off

    def columns(self, at_work: bool) -> Columns:
        """Directions with heavy-tailed spreads. at_work: whether it acts at the point."""
        candidate, prior, away = self.term.candidate, self.prior, self.away
        names = tuple(coordinate_name(candidate, i) for i in candidate.moved)
        length = float(np.linalg.norm(away))
        spread = np.array(prior.spread)
        spread[prior.sizes] = max(prior.typical, length)
        if at_work or self.whole is None:
            return Columns(self.slopes, spread, names)
        if not prior.sizes:
            values = np.concatenate([self.whole[:, None], self.slopes], axis=1)
            return Columns(values, np.concatenate([[1.0], spread]), ("present", *names))
        main = prior.sizes[int(np.argmax(np.abs(away[prior.sizes])))]
        values = self.slopes.copy()
        values[:, main] = self.whole / away[main]
        return Columns(values, spread, names)

    def below_nothing(self, linear: FloatArray) -> bool:
        """Whether sizes (k,) of a linear fit are such as no machine has: of one sign only, and of
        the other together.
        """
        prior = self.prior
        if not prior.sizes or not all(prior.one_sided):
            return False
        return float(np.sum(linear[prior.sizes])) <= 0.0

    def no_machine_has(self, linear: FloatArray) -> bool:
        """Whether the main size, by sizes (k,) of a linear fit at work, is at its bound, more than
        such a thing has, or less than one step.
        """
        candidate, at = self.term.candidate, self.term.at.copy()
        at[candidate.moved] += linear - self.away
        kind = candidate.kind
        main = np.abs(candidate.values(at)[kind.main.name])
        if main.max() > kind.physical:
            return True
        if has(kind.name, Trait.WHOLE_STEPS):
            return bool(main.max() < VERDICT.least_steps)
        own = ((candidate.coordinates[i], at[i]) for i in candidate.moved)
        return any(
            (size <= one.low != kind.nothing) or size >= one.high
            for one, size in own
            if one.parameter == kind.main.name and one.how != "reciprocal"
        )

    def discrepancy(self, sizes: FloatArray) -> FloatArray:
        """Covariance (k, k) of fitted sizes (k,) by what the operator is not: a bearing, a spring
        or a stop is messier than any with two numbers, and the best machine is built to something.
        """
        kind, prior = self.term.candidate.kind, self.prior
        built = PENALTIES.most_careful * (card_of(kind.name).build_spread or 0.0)
        variance = np.full(len(sizes), built**2)
        if kind.discrepancy.elsewhere > EXACT:
            variance[prior.sizes] = kind.discrepancy.elsewhere * np.sum(sizes[prior.sizes] ** 2)
        moved = [self.term.candidate.coordinates[i].parameter for i in self.term.candidate.moved]
        own = [kind.discrepancy.gives_way.get(name, 0.0) for name in moved]
        return np.diag(variance + np.square(own))

    @property
    def heavy_tail(self) -> float:
        """Log density of a Cauchy prior at this size, against the Gaussian of its own width."""
        length = float(np.linalg.norm(self.away))
        return -float(np.log(max(length / self.prior.typical, 1.0)))

    @property
    def usual(self) -> float:
        """Log density of the other numbers at the point, against that at what they usually are."""
        candidate = self.term.candidate
        known = {p.name: p for p in candidate.kind.parameters}
        total = 0.0
        for number in self.prior.others:
            one = candidate.coordinates[candidate.moved[number]]
            default = known[one.parameter].default
            if one.how == "log" and default is not None and np.isfinite(default):
                off = self.term.at[candidate.moved[number]] - np.log(default)
                total -= 0.5 * float(off / self.prior.spread[number]) ** 2
        return total

    def moved_by(self, linear: FloatArray, at_work: bool) -> Term:
        """The term with the sizes that a linear fit has found, (k,)."""
        candidate, prior, away = self.term.candidate, self.prior, self.away
        if not at_work and self.whole is not None:
            if not prior.sizes:
                return self.term
            main = prior.sizes[int(np.argmax(np.abs(away[prior.sizes])))]
            share = float(np.clip(linear[main] / away[main], 0.2, 3.0))
            at = self.term.at.copy()
            for number in prior.sizes:
                at[candidate.moved[number]] += (share - 1.0) * away[number]
            return self.term.moved_to(at)
        at = self.term.at.copy()
        at[candidate.moved] += linear - away
        return self.term.moved_to(at)


def coordinate_name(candidate: Candidate, number: int) -> str:
    one = candidate.coordinates[number]
    size = {p.name: p.size for p in candidate.kind.parameters}[one.parameter]
    if one.how in ("sine", "cosine"):
        return one.how
    return f"{one.parameter}_{one.part}" if size > 1 else one.parameter


def nothing(candidate: Candidate) -> FloatArray:
    """Coordinates (k,) of the first shape, at which the effect does nothing."""
    if not candidate.shapes:
        return np.zeros(len(candidate.coordinates))
    return np.array(candidate.shapes[0].origin)


def is_straight(candidate: Candidate) -> bool:
    """Whether one start is as good as any other: a single shape, linear in all that is moved."""
    (first, *more) = candidate.shapes
    return not more and list(first.linear) == candidate.moved and len(candidate.moved) > 0


class Around:
    """Predictions around terms at work."""

    def __init__(
        self, model: DeltaModel, terms: Sequence[Term], always: Sequence[Term] | None = None
    ):
        """always: nuisances; where none are given, as they usually are."""
        self.model, self.terms = model, tuple(terms)
        usual = [nuisance.term for nuisance in model.nuisances]
        self.always = usual if always is None else list(always)
        self.predicted = self.with_terms(self.terms)

    def with_terms(self, terms: Sequence[Term]) -> FloatArray:
        """All channels (n c,) with these terms."""
        return end_to_end(self.model.predict([*self.always, *terms]))

    def beside(self, term: Term) -> FloatArray:
        """With one more, or another size of one that is at work."""
        others = [one for one in self.terms if one.candidate is not term.candidate]
        return self.with_terms([*others, term])

    def done_by(self, term: Term) -> FloatArray:
        """What a term at work does, (n c,)."""
        return self.predicted - self.with_terms([one for one in self.terms if one is not term])

    def without_always(self, term: Term) -> FloatArray:
        """What one of the terms that always act does, (n c,)."""
        others = [one for one in self.always if one is not term]
        return self.predicted - end_to_end(self.model.predict([*others, *self.terms]))

    def always_slopes(self, term: Term) -> FloatArray:
        """Derivatives (n c, k) by the moved coordinates of one of the terms that always act."""
        columns = []
        for i in term.candidate.moved:
            at, step = term.at.copy(), term.candidate.coordinates[i].step
            at[i] += step
            moved = [Term(term.candidate, at) if one is term else one for one in self.always]
            changed = end_to_end(self.model.predict([*moved, *self.terms]))
            columns.append((changed - self.predicted) / step)
        return np.stack(columns, axis=1)

    def slopes(self, term: Term, predicted: FloatArray) -> FloatArray:
        """Derivatives (n c, k) by the moved coordinates of a term; predicted: with it."""
        columns = []
        for i in term.candidate.moved:
            one, at = term.candidate.coordinates[i], term.at.copy()
            step = one.step if at[i] + one.step <= one.high else -one.step
            at[i] += step
            columns.append((self.beside(Term(term.candidate, at)) - predicted) / step)
        if not columns:
            return np.zeros((len(predicted), 0))
        return np.stack(columns, axis=1)
