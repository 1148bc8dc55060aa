"""How much of what recordings can tell the diagnosis says, group by group.

    python benchmarks/proofs/ceiling.py OUT [--minutes M] [--missed]

OUT is the folder of a proof (`deltactl demo prove --out OUT`). Each of its cases with one to five
effects that was not named exactly is simulated again and shown to an observer that is told what
was built in: has the true set more evidence than what the engine compares with it (each of its
effects left out, another in its place, one more) and than the set that was answered? It knows the
noise that the true set leaves, and need not search. Where
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

from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.plants.delta.plant import DeltaPlant
from deltactl.diagnosis.plants.delta.recorded import Recorded
from deltactl.diagnosis.selection.model_posterior import HillClimb
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
POINTS = 2
"""So often are the columns made anew, each near the last fit."""
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
    plant = DeltaPlant(Recorded(DeltaModel(model_file, [read_flat(recording)])))
    keys = _keys(plant, truth)
    if not keys <= plant.fitted:
        return Ceiling("not seen", 0.0)
    there = _fitted(plant, keys)
    evidence = Laplace(there, there.own_noise)
    if not keys <= evidence(keys).found:
        return Ceiling("not seen", 0.0)
    climb = HillClimb(evidence, among=sorted(there.fitted))
    climb.climbed(keys)
    weighed = climb.posterior()
    least = min((weighed.probability(key) for key in keys), default=1.0)
    gone, more = sorted(keys - weighed.best.keys), sorted(weighed.best.keys - keys)
    if gone:
        why = f"is like {', '.join(more)}" if more else "is too faint"
        return Ceiling(f"{', '.join(gone)} {why}", least)
    if more:
        return Ceiling(f"{', '.join(more)} beside it", least)
    answered = _fitted(plant, _keys(plant, said) & plant.fitted)
    rival = Laplace(answered, there.own_noise)(answered.point)
    behind = rival.log_evidence - evidence(keys).log_evidence
    return Ceiling("other names have more evidence" if behind > 0.0 else "", least)


def _keys(plant: DeltaPlant, names: Sequence[Name]) -> frozenset[str]:
    """Names as the engine's keys, less those that no observer looks for by evidence."""
    return frozenset(" ".join(name) for name in names if name[0] not in (NO_TERM, "unknown"))


def _fitted(plant: DeltaPlant, keys: frozenset[str]) -> DeltaPlant:
    """The plant with these effects at work, each at its best size."""
    for _ in range(POINTS):
        plant = plant.moved_to(Laplace(plant, plant.own_noise)(keys))
    return plant


GROUPS = ("single", "faint", "two", "three", "four", "five")
"""Groups of cases in which effects of the vocabulary were hidden, and nothing else."""
KEPT = "ceiling.json"


def observed(result: dict[str, Any], marks: Score, kept: Path) -> Ceiling:
    """What the observer sees of one case, from its file where it has looked before."""
    if kept.exists():
        return Ceiling(**json.loads(kept.read_text(encoding="utf-8")))
    seed, number = int(result["seed"]), int(marks.case.rpartition("_")[2])
    case = (draw_more if marks.case.startswith(MORE) else draw)(seed, number)
    with tempfile.TemporaryDirectory(prefix="ceiling-") as name:
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
