"""What one recording can tell at all: an observer that is told the truth and compares it.

In: a folder with a recording and its robot file, and what was built in. Out: whether the set of
effects that was built in has more evidence than what the engine compares with it: each of its
effects left out, another in its place, one more, two for one, and the set that was answered. It
knows the noise that the true set leaves, it need not search, and it has no limit of work.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from deltactl.diagnosis.estimation.budget import Budget
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.evidence.noise_estimation import once_more, prepare
from deltactl.diagnosis.plants.candidate import Candidate
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.priors.size_priors import odds_cost, size_cost
from deltactl.diagnosis.score_tests.change_points import without_stale
from deltactl.diagnosis.search.addition import add
from deltactl.diagnosis.search.exchange import best_of, pairs_for_one
from deltactl.diagnosis.search.search import Search
from deltactl.diagnosis.selection.ambiguity import stands_of
from deltactl.diagnosis.selection.credible_set import credible
from deltactl.models.effects import found_by
from deltactl.models.effects.fit import Search as Searched
from deltactl.models.robot import DeltaRobot
from deltactl.models.robot_files import load_robot_model
from deltactl.recording.tables.flat_files import read_flat

Name = tuple[str, str]
"""Effect and component."""
NO_TERM = found_by(Searched.REPEATS).name
"""Found reading by reading, not by evidence: every observer is told it."""


@dataclass(frozen=True, slots=True)
class Ceiling:
    """What the observer saw. `against` is why the recording does not tell; empty where it does."""

    against: str
    probability: float
    """Of the least certain of the true effects."""

    @property
    def tells(self) -> bool:
        """Whether the true set is the best of all that were compared."""
        return not self.against


def ceiling(recording: Path, robot: Path, truth: Sequence[Name], said: Sequence[Name]) -> Ceiling:
    """Compare the true set with its neighbours and with the answer, on one recording.

    said: the names of the findings of the answer. Raises RecordingError and ConfigError like the
    diagnosis does.
    """
    belief = load_robot_model(robot)
    assert isinstance(belief, DeltaRobot)
    assert belief.drive is not None
    model = DeltaModel(belief, [read_flat(recording)])
    valid, _ = without_stale(model)
    rad_per_step = belief.drive.rad_per_step
    search = Search(prepare(model, valid, Budget()), rad_per_step)
    names = [name for name in truth if name[0] != NO_TERM]
    first = _fitted(search, names)
    if first is None:
        return Ceiling("not seen", 0.0)
    told = Search(once_more(search.prepared, first.predicted), rad_per_step)
    best = _fitted(told, names)
    if best is None:
        return Ceiling("not seen", 0.0)
    return _compared(told, best, [name for name in said if name[0] not in (NO_TERM, "unknown")])


def _fitted(search: Search, names: Sequence[Name]) -> Solution | None:
    """The best fit of these names, each begun with in turn; None where one shows nothing."""
    fits = [_fitted_from(search, names, [first]) for first in names] if names else []
    found = [fit for fit in fits if fit is not None]
    return min(found, key=lambda fit: fit.cost, default=None if names else search.tests.empty)


def _fitted_from(search: Search, names: Sequence[Name], first: list[Name]) -> Solution | None:
    """What is named first, then what explains most of the rest."""
    solution, left = search.tests.empty, set(names)
    while left:
        asked = first if first[0] in left else left
        trials = [t for t in search.tests.trials(solution) if _name(t.start.candidate) in asked]
        if not trials:
            return None
        start = max(trials, key=lambda trial: trial.gain).start
        solution = search.fitter.solve((*solution.terms, start), (), solution.nuisances)
        left.discard(_name(start.candidate))
    return solution


def _name(candidate: Candidate) -> Name:
    return candidate.effect, candidate.component


def _compared(search: Search, truth: Solution, said: Sequence[Name]) -> Ceiling:
    chances = credible(search, truth, stands_of(search, truth))
    least = min(chances.terms, default=1.0)
    if least < 0.5:
        number = chances.terms.index(least)
        name = " ".join(_name(truth.terms[number].candidate))
        rival = max(chances.rivals[number].items(), key=lambda item: item[1], default=None)
        if rival is not None and rival[1] > 1.0 - least - rival[1]:
            return Ceiling(f"{name} is like {' '.join(rival[0])}", least)
        return Ceiling(f"{name} is too faint", least)
    more = add(search, truth)
    if more is not None:
        return Ceiling(f"{' '.join(_name(more.terms[-1].candidate))} beside it", least)
    rivals = [best_of(search, truth, [pair() for pair in pairs_for_one(search, truth)])]
    answered = _fitted(search, said)
    if answered is not None and set(said) != {_name(term.candidate) for term in truth.terms}:
        rivals.append(answered)
    behind = min(_cost(rival) for rival in rivals) - _cost(truth)
    return Ceiling("other names have more evidence" if behind < 0.0 else "", least)


def _cost(solution: Solution) -> float:
    """-2 log evidence, but for a constant."""
    numbers = range(len(solution.terms))
    sizes = sum(size_cost(solution, number) for number in numbers)
    return solution.cost + sizes + sum(odds_cost(t.candidate) for t in solution.terms)
