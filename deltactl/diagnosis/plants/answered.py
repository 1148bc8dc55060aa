"""What the answer says of a machine beyond the sizes of its regressors."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from deltactl.diagnosis.answer.finding import Finding, ParameterResult
from deltactl.diagnosis.answer.picture import Picture
from deltactl.diagnosis.answer.records import NotTestable
from deltactl.diagnosis.answer.verdict import Rest
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.observations.stale_readings import Stale
from deltactl.diagnosis.plants.as_read import AsRead


class Answered(AsRead):
    """The part of a plant that says so; by default there is one channel and nothing to add."""

    channel: str
    """Name of what was observed, for drawings."""
    stale: Sequence[Stale] = ()
    """Stretches in which a sensor repeated an old value."""

    @cached_property
    def drawn_on(self) -> FloatArray:
        """(n,) what drawings add to `observed` and to every prediction of it."""
        return np.zeros(len(self.t_s))

    def not_testable(self) -> list[NotTestable]:
        """Effects of which such a recording can tell nothing, and why."""
        return []

    def shown_on(self, change: FloatArray) -> list[str]:
        """Channels on which a change of the readings (n,) shows."""
        return [self.channel]

    def parameters(
        self, key: str, sizes: FloatArray, covariance: FloatArray
    ) -> dict[str, ParameterResult] | None:
        """Parameters of the answer by all sizes (k,); None where `shown` has them."""
        return None

    def spread(self, key: str, sizes: FloatArray, covariance: FloatArray) -> dict[str, list[float]]:
        """See `Finding.spread`, by all sizes of a regressor (k,)."""
        return {}

    def described(
        self, finding: Finding, keys: Sequence[str], best: Any, without: Any
    ) -> dict[str, Any]:
        """Fields of the finding of these regressors that their columns do not tell.

        without: the explanation less all of them.
        """
        return {}

    def drawn(self, picture: Picture) -> Picture:
        """A picture with a channel for each that was laid end to end."""
        return picture

    def rest(self, best: Any, charged: float) -> Rest | None:
        """What an explanation leaves, by shapes of no spline term; None where there are none.

        charged: chi-square that effects of the file may leave.
        """
        return None

    def remarks(self, best: Any, covariance: FloatArray) -> dict[str, Any]:
        """Further fields of the answer, by the best explanation and the covariance of its sizes."""
        return {}
