"""What a plant offers so that the next run can be designed: safe motions, and how it would go."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.delta.model import DeltaModel


class CandidateRun(Protocol):
    """One repeat of a motion that the machine may safely do."""

    @property
    def model(self) -> DeltaModel:
        """The machine in this motion, nothing read yet (all readings 0)."""
        ...

    @property
    def period_s(self) -> float:
        """At which it would be sampled."""
        ...

    @property
    def minutes(self) -> float:
        """How long one repeat takes."""
        ...

    def holds_together(self, predicted: FloatArray) -> bool:
        """Whether the machine can be assembled all along what an explanation predicts, (n, c)."""
        ...

    def job(self, repeats: int) -> dict[str, Any]:
        """What `deltactl run` takes, as plain data."""
        ...


NextRuns = Callable[[Iterable[str]], Sequence[CandidateRun] | None]
"""The runs there are to choose from when it is about these components; None where the robot file
does not say how the machine is driven."""
