"""How much of what recordings can tell the diagnosis says, group by group.

    python benchmarks/proofs/ceiling.py OUT [--minutes M] [--missed]

OUT is the folder of a proof (`deltactl demo prove --out OUT`). Each of its cases with one to five
effects that was not named exactly is simulated again and shown to an observer that is told what
was built in: has the true set more evidence than what the engine compares with it (each of its
effects left out, another in its place, one more, two for one) and than the set that was answered?
It knows the noise that the true set leaves, it need not search, and it has no limit of work. Where
it would prefer another set, no diagnosis can be expected to name the true one. What the diagnosis
named exactly counts as told, so the observer is not asked there. What it saw is kept beside the
case's result (`ceiling.json`). Five to ten seconds of one core a case, and the simulation.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from deltactl.diagnosis.estimation.budget import Budget
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.evidence.noise_estimation import once_more, prepare
from deltactl.diagnosis.score_tests.change_points import without_stale
from deltactl.diagnosis.search.addition import add
from deltactl.diagnosis.search.exchange import best_of, pairs_for_one
from deltactl.diagnosis.search.search import Search
from deltactl.diagnosis.selection.ambiguity import stands_of
from deltactl.diagnosis.selection.credible_set import credible

from deltactl.diagnosis.estimation.side_by_side import alone
from deltactl.diagnosis.plants.candidate import Candidate
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.priors.size_priors import odds_cost, size_cost
from deltactl.foundation.errors import DeltactlError
from deltactl.models.effects import found_by
from deltactl.models.effects.card import Search as Searched
from deltactl.models.robot import DeltaRobot
from deltactl.models.robot_files import load_robot_model
from deltactl.proof.cases import MORE, RECORDING, ROBOT_FILE, draw, draw_more, write_blind
from deltactl.proof.prove.reliability import wilson
from deltactl.proof.prove.score import Score, score
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
    """Probability of the least certain of the true effects."""


def ceiling(recording: Path, robot: Path, truth: Sequence[Name], said: Sequence[Name]) -> Ceiling:
    """Compare the true set with its neighbours and with the answer, on one recording.

    said: the names of the findings of the answer. Raises RecordingError and ConfigError like the
    diagnosis does.
    """
    model_file = load_robot_model(robot)
    assert isinstance(model_file, DeltaRobot)
    assert model_file.drive is not None
    model = DeltaModel(model_file, [read_flat(recording)])
    valid, _ = without_stale(model)
    rad_per_step = model_file.drive.rad_per_step
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
        rival = max(chances.alternatives[number].items(), key=lambda item: item[1], default=None)
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


GROUPS = ("single", "faint", "two", "three", "four", "five")
"""Groups of cases in which effects of the vocabulary were hidden, and nothing else."""
KEPT = "ceiling.json"


def observed(result: dict[str, Any], marks: Score, kept: Path) -> Ceiling:
    """What the observer sees of one case, from its file where it has looked before."""
    if kept.exists():
        return Ceiling(**json.loads(kept.read_text(encoding="utf-8")))
    seed, number = int(result["seed"]), int(marks.case.rpartition("_")[2])
    case = (draw_more if marks.case.startswith(MORE) else draw)(seed, number)
    with tempfile.TemporaryDirectory(prefix="ceiling-") as name, alone():
        folder = Path(name)
        write_blind(case, folder, seed)
        seen = ceiling(folder / RECORDING, folder / ROBOT_FILE, marks.truth, marks.said)
    kept.write_text(json.dumps(asdict(seen)) + "\n", encoding="utf-8")
    return seen


def cases(out: Path) -> Iterator[tuple[dict[str, Any], Score, Path]]:
    """Results of a proof that were answered, of the groups above."""
    for file in sorted(out.glob("*/result.json")):
        result = json.loads(file.read_text(encoding="utf-8"))
        if "diagnosis" not in result:  # a tie
            continue
        marks = score(result)
        if marks.group in GROUPS and marks.failure is None:
            yield result, marks, file.with_name(KEPT)


def share(of: list[Score]) -> str:
    """How many are exact, with its 95 % limits."""
    if not of:
        return "-"
    right = sum(marks.exact for marks in of)
    low, high = wilson(right, len(of))
    limits = f"[{100 * low:.0f}, {100 * high:.0f}]"
    return f"{right} of {len(of)}, {100 * right / len(of):.1f} % {limits}"


def looked_at(out: Path, minutes: float) -> Iterator[tuple[Score, str]]:
    """What was answered, and what speaks against the truth: empty where the recording tells it."""
    until = time.monotonic() + 60.0 * minutes
    for result, marks, kept in cases(out):
        if marks.exact:
            yield marks, ""
            continue
        if time.monotonic() > until:
            print(f"stopped after {minutes:g} minutes; the same command goes on")
            break
        try:
            yield marks, observed(result, marks, kept).against
        except DeltactlError as error:
            print(f"{marks.case}: {error}", file=sys.stderr)


def _print_row(group: str, seen: Sequence[tuple[Score, str]]) -> None:
    told = [marks for marks, why in seen if not why]
    if seen:
        all_ = share([marks for marks, _ in seen])
        print(f"| {group} | {all_} | {len(told)} | {share(told)} |")


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("out", type=Path)
    parser.add_argument("--minutes", type=float, default=float("inf"))
    parser.add_argument("--missed", action="store_true", help="list what the observer would tell")
    options = parser.parse_args()
    seen = list(looked_at(options.out, options.minutes))
    print("| group | named exactly, of all | the recording tells | named exactly, of these |")
    print("|---|---|---|---|")
    for group in GROUPS:
        _print_row(group, [pair for pair in seen if pair[0].group == group])
    _print_row("all", seen)
    reasons = Counter(_kind(why) for _, why in seen if why)
    print("\n".join(f"{count} x {reason}" for reason, count in reasons.most_common()))
    if options.missed:
        for marks, why in seen:
            if not marks.exact:
                print(f"{marks.case}: {marks.truth} said {marks.said}: {why or 'tells'}")
    return 0


def _kind(why: str) -> str:
    """A reason without its names."""
    for kind in ("too faint", "is like", "beside it"):
        if kind in why:
            return kind
    return why


if __name__ == "__main__":
    sys.exit(main())
