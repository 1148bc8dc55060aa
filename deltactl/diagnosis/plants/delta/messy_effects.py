"""What effects that are messier than their operators may leave in the shapes of others.

A bearing, a spring or a stop is messier than any operator with two numbers (`Discrepancy`): what it
leaves is no evidence for anything that does less.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.noise_of_channels import ChannelsNoise
from deltactl.diagnosis.plants.delta.point import Around, Near, key_of
from deltactl.diagnosis.plants.delta.prior_odds import left_by
from deltactl.diagnosis.plants.delta.recorded import Recorded
from deltactl.diagnosis.plants.delta.unknown import Process
from deltactl.diagnosis.plants.regression import RegressionPlant
from deltactl.diagnosis.priors.options import PENALTIES
from deltactl.models.effects.kind import EXACT


class MessyEffects(RegressionPlant):
    """The part of a delta's plant that says what is no evidence."""

    messy = True
    recorded: Recorded
    unknown: Mapping[str, Process]
    around: Around
    at_work: dict[str, Term]
    careful: float

    @cached_property
    def own_noise(self) -> ChannelsNoise:
        """With what effects leave that act now and then only, and are messy where they do."""
        raise NotImplementedError

    @cached_property
    def near(self) -> dict[str, Near]:
        """Each effect near the point."""
        raise NotImplementedError

    @cached_property
    def candidates(self) -> dict[str, Candidate]:
        """All effects that are looked for."""
        raise NotImplementedError

    def left_by_names(self) -> float:
        """Chi-square that what is at work at the point, and what the file has from an earlier
        diagnosis, may leave of any shape.
        """
        named = {key: self.candidates[key] for key in self.at_work}
        known = [(one, self.power(key)) for key, one in named.items() if left_by(one, None) > EXACT]
        known += self._measured.values()
        return sum(PENALTIES.spline_factor * left_by(one, None) * power for one, power in known)

    def is_messy(self, keys: frozenset[str]) -> bool:
        """Whether any of a set may leave more than its geometry does."""
        if self._measured:
            return True
        named = [self.candidates[key].kind.discrepancy for key in keys if key in self.candidates]
        return any(one.elsewhere > EXACT or one.leads_to for one in named)

    @cached_property
    def _of_file(self) -> list[tuple[Candidate, FloatArray]]:
        """Effects that the file has from an earlier diagnosis, and what each does (n c,)."""
        pairs = zip(self.recorded.model.nuisances, self.around.always, strict=True)
        known = [term for nuisance, term in pairs if nuisance.measured]
        return [(term.candidate, self.around.without_always(term)) for term in known]

    @cached_property
    def _measured(self) -> dict[str, tuple[Candidate, float]]:
        """The same, and the chi-square each explains."""
        white = [(one, self.own_noise.whiten(own)) for one, own in self._of_file]
        return {key_of(one): (one, float(own @ own)) for one, own in white}

    @property
    def sizeless(self) -> frozenset[str]:
        """See `RegressionPlant`: a resonance is there, or is not."""
        return frozenset(key for key in self.at_work if not self.near[key].prior.sizes)

    def power(self, key: str) -> float:
        """See `RegressionPlant`: of an effect at the point, or where it would fit best; of what is
        always fitted, that of the file's effects.
        """
        if not key:
            return sum(power for _, power in self._measured.values())
        if key not in self.near:
            return 0.0
        if key not in self._powers:
            near = self.near[key]
            own = near.slopes @ near.away if near.whole is None else near.whole
            white = self.own_noise.whiten(
                self.around.done_by(near.term) if key in self.at_work else own
            )
            self._powers[key] = float(white @ white)
        return self._powers[key]

    @cached_property
    def _powers(self) -> dict[str, float]:
        return {}

    def charged(self, gains: Mapping[str, float]) -> float:
        """Chi-square that messy effects of a set may leave in the shapes of smaller ones, and those
        of the file in all names but their own.

        gains: what each adds to those that do more. What the most careful building leaves any
        machine has: it is no explanation.
        """
        total, careful = 0.0, self.careful == PENALTIES.most_careful
        for key, gain in gains.items():
            if not key and careful:
                continue
            own = self.power(key)
            larger = [
                (self.candidates[other], self.power(other))
                for other in gains
                if other in self.candidates and (self.power(other) > own or key in self.unknown)
            ]
            larger += self._measured.values() if key and key not in self._measured else ()
            left = sum(self._left_by(one, key) * power for one, power in larger)
            far = 1.0 if key in self.unknown else min(left / max(gain, 1e-300), 1.0)
            total += min(left, gain) * far
        return total

    def _left_by(self, known: Candidate, new: str) -> float:
        """Share of what an effect does that it may leave in the shape of a regressor."""
        share = left_by(known, self.candidates.get(new))
        return PENALTIES.spline_factor * share if new in self.unknown else share
