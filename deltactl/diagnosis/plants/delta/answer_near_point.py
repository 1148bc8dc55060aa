"""What the answer says of a delta near a point: parameters, channels, limits, tolerances."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from deltactl.diagnosis.answer.finding import ParameterResult
from deltactl.diagnosis.answer.records import NotTestable
from deltactl.diagnosis.assessment.intervals import parameters, spreads
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.evidence.laplace import Explanation
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.built_loosely import allowed_for
from deltactl.diagnosis.plants.delta.point import (
    Around,
    Near,
    coordinate_name,
    side_by_side,
)
from deltactl.diagnosis.plants.delta.recorded import Recorded
from deltactl.diagnosis.plants.regression import (
    Draws,
    RegressionPlant,
    Shown,
)
from deltactl.diagnosis.priors.options import PENALTIES


class AnswerNearPoint(RegressionPlant):
    """The part of a delta's plant that the answer is made of."""

    recorded: Recorded
    around: Around
    at_work: dict[str, Term]
    careful: float
    count: int

    @cached_property
    def acting(self) -> dict[str, Near]:
        """What is at work, in its derivatives."""
        raise NotImplementedError

    @cached_property
    def near(self) -> dict[str, Near]:
        """Each effect near the point."""
        raise NotImplementedError

    @cached_property
    def candidates(self) -> dict[str, Candidate]:
        """All effects that are looked for."""
        raise NotImplementedError

    @cached_property
    def _known(self) -> list[tuple[float, FloatArray]]:
        """Of effects of the robot file that were measured, what each may leave and does (n c,)."""
        found = []
        for nuisance, term in zip(self.recorded.model.nuisances, self.around.always, strict=True):
            if nuisance.measured:
                share = term.candidate.kind.discrepancy.elsewhere
                found.append((share, self.around.without_always(term)))
        return found

    @property
    def held(self) -> IntArray:  # type: ignore[override]
        """See `RegressionPlant`."""
        return self.recorded.held

    @property
    def left_by_known(self) -> Sequence[tuple[float, FloatArray]]:  # type: ignore[override]
        """See `RegressionPlant`."""
        return self._known

    @property
    def done_by_known(self) -> FloatArray | None:  # type: ignore[override]
        """What all of them do (n c,)."""
        each = [own for _, own in self._known]
        return np.sum(each, axis=0) if each else None

    @cached_property
    def covariates(self) -> dict[str, FloatArray]:
        """What a model error may follow, the same for all channels."""
        every = self.recorded.model.covariates()
        return {name: np.tile(values, self.count) for name, values in every.items()}

    def shown_on(self, change: FloatArray) -> list[str]:
        """Channels that show a change (n c,), in standard deviations of their noise."""
        spread = np.array([one.spread for one in self.own_noise.whitener.channels])
        power = np.mean((side_by_side(change, self.count) / spread) ** 2, axis=0)
        order = np.argsort(-power)
        return [
            self.readings.names[i]
            for i in order
            if power[i] >= ASSESSMENT.share_of_axis * power.sum()
        ]

    def parameters(
        self, key: str, sizes: FloatArray, covariance: FloatArray
    ) -> dict[str, ParameterResult] | None:
        """Parameters of an effect at work by its coordinates."""
        if key not in self.at_work:
            return None
        near = self.acting[key]
        return parameters(near.moved_by(sizes, True), covariance + near.discrepancy(sizes))

    def spread(self, key: str, sizes: FloatArray, covariance: FloatArray) -> dict[str, list[float]]:
        """How far the parameters of an effect at work are off together."""
        if key not in self.at_work:
            return {}
        near = self.acting[key]
        return spreads(near.moved_by(sizes, True), covariance + near.discrepancy(sizes))

    def shown(self, key: str) -> Sequence[Shown]:
        """The main parameter, for limits of detection."""
        if key not in self.candidates:
            return ()
        candidate = self.candidates[key]
        main, first = candidate.kind.main, candidate.coordinates[candidate.moved[0]]
        name = coordinate_name(candidate, candidate.moved[0])
        if first.parameter != main.name or first.how == "log":
            return ()
        at = 0.0 if first.how == "reciprocal" else candidate.kind.nothing

        def of(values: Draws) -> FloatArray:
            size = values[name] + at
            return np.asarray(1.0 / size if first.how == "reciprocal" else size)

        return [Shown(main.name, main.unit, of, at)]

    def remarks(self, best: Explanation, covariance: FloatArray) -> dict[str, Any]:
        """Whether it was built with less care than usual, and what is off then."""
        loose = self.careful > PENALTIES.most_careful
        names = np.array(self.free().names)
        places = {name: np.flatnonzero(names == name) for name in self.free().names}
        sizes = {name: best.linear[""][at] for name, at in places.items()}
        known = {name: covariance[np.ix_(at, at)] for name, at in places.items()}
        tolerances = self.recorded.model.tolerances
        allowed = allowed_for(tolerances, sizes, known) if loose else []
        return {
            "loosely_built": loose or self.recorded.model.loosely_built, "allowed_for": allowed,
        }  # fmt: skip

    def not_testable(self) -> list[NotTestable]:
        """Effects that change nothing in this recording."""
        why = "nothing that was observed depends on it in this recording"
        return [
            NotTestable.of(one.effect, one.component, why)
            for key, one in self.candidates.items()
            if not np.any(self.near[key].slopes)
        ]
