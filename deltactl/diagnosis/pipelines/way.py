"""The one way from what a search settled to the answer, the same for every kind of machine.

In: a `Settled`, from `nonlinear` (effects fitted together: deltas) or `regression` (a model error
that is a sum of columns: axes, servo joints, range sensors). Out: a `Diagnosis`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

from deltactl.diagnosis.answer.assembly import assembled
from deltactl.diagnosis.answer.records import (
    Diagnosis,
    Finding,
    Fit,
    NotTestable,
    Picture,
    PriorSensitivity,
    SmallestDetectable,
)
from deltactl.diagnosis.answer.verdict import Rest
from deltactl.diagnosis.assessment.persistence import persistence
from deltactl.diagnosis.experiment.propose import Proposal
from deltactl.diagnosis.progress import Progress


class Figures(NamedTuple):
    """The findings with their sizes, the fit with what was held out, and what is left."""

    findings: Sequence[Finding]
    fit: Fit
    rest: Rest


class Limits(NamedTuple):
    """What the recording could not show at all, and from which size on it shows the others."""

    not_testable: Sequence[NotTestable]
    smallest_detectable: Sequence[SmallestDetectable]


class Settled(Protocol):
    """The accepted explanation of a recording, and all that an answer says of it."""

    def figures(self) -> Figures:
        """Sizes, held-out fit and what is left, of the explanation and of no other."""

    def chance(self, found: Sequence[Finding]) -> float:
        """Calibrated p of 'nothing is missing', before any finding."""

    def nothing_missing(self, found: Sequence[Finding]) -> float:
        """Posterior probability that nothing is missing."""

    def by_priors(self, found: Sequence[Finding]) -> list[PriorSensitivity]:
        """Findings whose probability hangs on how wide the priors of sizes are."""

    def limits(self) -> Limits:
        """What was not to be seen in this recording."""

    def next_run(self) -> Proposal:
        """The motion that would tell more, and what it would leave open."""

    def picture(self) -> Picture:
        """Arrays for drawings."""

    def remarks(self) -> dict[str, Any]:
        """Further fields of `Diagnosis`."""


def answered(settled: Settled, progress: Progress) -> Diagnosis:
    """Stage by stage: figures, limits, the next run, probabilities; put together in one place."""
    found, fit, rest = settled.figures()
    untested, smallest = settled.limits()
    progress("what run would tell more")
    proposal = settled.next_run()
    picture = settled.picture()
    return assembled(
        found,
        _with_persistence(fit, picture),
        settled.chance(found),
        rest,
        probability_nothing_missing=settled.nothing_missing(found),
        prior_sensitivity=settled.by_priors(found),
        next_experiment=proposal.experiment,
        open_ties=proposal.open,
        not_testable=untested,
        smallest_detectable=smallest,
        picture=picture,
        **settled.remarks(),
    )


def _with_persistence(fit: Fit, picture: Picture) -> Fit:
    """The figures with how long what is left goes on."""
    found = persistence(picture)
    if found is None:
        return fit
    return fit.model_copy(update={f"left_{name}": value for name, value in found._asdict().items()})
