"""What a search knows of a recording, and what it has looked at: its moves are given this."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from deltactl.diagnosis.estimation.budget import Budget
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.evidence.detection import Detection, Progress
from deltactl.diagnosis.evidence.noise_estimation import Prepared
from deltactl.diagnosis.priors.options import OPTIONS, SearchOptions
from deltactl.diagnosis.score_tests.score_test import Calibration
from deltactl.diagnosis.search.criterion import Criterion


@dataclass(frozen=True, slots=True, eq=False)
class Without:
    """The rest of a solution without one of its terms, fitted again."""

    fit: Solution
    needed: bool
    """Whether the term earns its place beside the rest."""
    clearly: bool
    """Whether it does so many times over."""


@dataclass(slots=True, eq=False)
class SearchState:
    """What is searched, and what is known of it.

    `tests` holds what is known of the recording, `criterion` compares two sets.
    """

    prepared: Prepared
    rad_per_step: float
    progress: Progress = lambda _: None
    known: Calibration | None = None
    """Calibration of the same candidate library under nearly the same noise, where there is one."""
    options: SearchOptions = OPTIONS
    tests: Detection = field(init=False)
    criterion: Criterion = field(init=False)
    _last: tuple[Solution, list[Without]] | None = None
    """The solution that was last looked at without each of its terms; one, for it is large."""

    def __post_init__(self) -> None:
        self.tests = Detection(self.prepared, self.rad_per_step, self.progress, self.known)
        self.criterion = Criterion(self.tests, self.options)

    @property
    def fitter(self) -> Fitter:
        """The fitter of the prepared recording."""
        return self.prepared.fitter

    @property
    def budget(self) -> Budget:
        """How much more the search may be."""
        return self.fitter.budget

    def known_without(self, solution: Solution) -> list[Without] | None:
        """The rest without each term of a solution, where it was looked at last."""
        return self._last[1] if self._last is not None and self._last[0] is solution else None

    def remember(self, solution: Solution, found: Sequence[Without]) -> list[Without]:
        """Keep what was looked at, less what makes it large: a tangent is worked out again."""
        kept = [replace(one, fit=replace(one.fit)) for one in found]
        self._last = solution, kept
        return kept
