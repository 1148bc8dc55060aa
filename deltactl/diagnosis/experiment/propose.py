"""The next experiment of an answer, and the job that carries it out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from scipy.linalg import block_diag

from deltactl.diagnosis.answer.records import NextExperiment, OpenTie
from deltactl.diagnosis.evidence.autoregression import Whitener
from deltactl.diagnosis.evidence.explanation import Explanation as Explained
from deltactl.diagnosis.experiment.design import EXPERIMENT, Run, both_ways
from deltactl.diagnosis.experiment.ties import Explanation, Sides, Tie
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray
from deltactl.diagnosis.plants.delta.beside_point import Absorbed
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.plants.delta.next_runs import next_runs
from deltactl.diagnosis.plants.delta.plant import DeltaPlant
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits
from deltactl.foundation.plain_file import write_whole


def write_job(
    experiment: NextExperiment, path: Path, robot: Path, project: Path | None = None
) -> None:
    """Write the job for a robot file: in full, or by name beside the job or in `project`."""
    folder = robot.parent.resolve()
    known = [path.resolve().parent, *([project.resolve()] if project else [])]
    job = {**experiment.job, "robot": robot.name if folder in known else str(folder / robot.name)}
    head = (
        f"# Tells apart: {', '.join(experiment.tells_apart)}.\n"
        f"# {experiment.minutes:.1f} minutes, expected chi-square "
        f"{experiment.expected_delta_chi2:.0f}. Then diagnose both recordings together.\n"
    )
    body = yaml.safe_dump(job, sort_keys=False, allow_unicode=True, default_flow_style=None)
    write_whole(path, head + body)


@dataclass(frozen=True, slots=True)
class Proposal:
    """The job, if one helps, and what it does not settle for sure."""

    experiment: NextExperiment | None
    open: list[OpenTie] = field(default_factory=list)


@dataclass(frozen=True, slots=True, eq=False)
class _Rated:
    """A run with its evidence for every tie: (n, 2), first and second explanation true."""

    run: Run
    evidence: FloatArray

    @property
    def most_repeats(self) -> int:
        """How often it fits into the time there is."""
        return max(1, int(EXPERIMENT.longest_min / max(self.run.minutes, 1e-6)))

    @property
    def enough(self) -> BoolArray:
        """(n, 2): where the longest run gives enough evidence."""
        return self.evidence * self.most_repeats >= EXPERIMENT.settles

    def rank(self) -> tuple[int, int, float]:
        """Ties it settles whichever is true, ties it may settle, least evidence a minute."""
        both, one = self.enough.all(axis=1), self.enough.any(axis=1)
        low = self.least if one.any() else float(self.evidence.max())
        return int(both.sum()), int(one.sum()), low / self.run.minutes

    @property
    def least(self) -> float:
        """Smallest evidence among those that are enough."""
        return float(self.evidence[self.enough].min())


def next_run(
    plant: DeltaPlant, explanations: Sequence[Explained], limits: MotionLimits | None
) -> Proposal:
    """The run of a delta that distinguishes sets which one recording leaves open.

    explanations: of the posterior, the most probable first; limits: of the machine.
    """
    best, *others = explanations
    named = [one.keys & plant.fitted for one in (best, *others)]
    pairs = zip(others, named[1:], strict=True)
    open_ones = [one for one, keys in pairs if keys - named[0] and named[0] - keys]
    if not open_ones:
        return Proposal(None)
    first = fitted_set(plant, best)
    ties = [Tie.of(first, fitted_set(plant, one)) for one in open_ones[: EXPERIMENT.most_ties]]
    return next_experiment(plant.recorded.model, plant.own_noise.whitener, ties, limits)


def fitted_set(plant: DeltaPlant, explanation: Explained) -> Explanation:
    """A set at its end, with what the recording says of its sizes and of nuisances."""
    there, noise = plant.moved_to(explanation), plant.own_noise
    tolerances, nuisances = there.free(), there.recorded.free[3]
    slopes = [there.around.always_slopes(one) for one in there.around.always]
    slopes += [near.slopes for near in there.acting.values()]
    white = noise.whiten(np.concatenate([np.zeros((len(plant.observed), 0)), *slopes], axis=1))
    beside = noise.whiten((tolerances.values * tolerances.spread)[:, nuisances:])
    taken = Absorbed(beside)
    share = taken.share(white)
    gram = white.T @ white - share.T @ share
    known = [one.precision for one in there.recorded.model.nuisances]
    gram[:nuisances, :nuisances] += block_diag(*known)
    root = np.linalg.cholesky(gram + 1e-9 * np.diag(np.diag(gram) + 1e-300)).T
    left = noise.whiten(plant.observed - there.around.predicted)
    of_left = taken.share(left)
    cost = float(left @ left - of_left @ of_left)
    return Explanation(tuple(there.at_work.values()), tuple(there.around.always), root, cost)


def next_experiment(
    recorded: DeltaModel, noise: Whitener, ties: Sequence[Tie], limits: MotionLimits | None = None
) -> Proposal:
    """Design the run that tells the ties apart.

    recorded, noise: of the recording that left them tied. limits: of the machine. At most a few
    ties are looked at, the closest first.
    """
    ties = sorted(ties, key=lambda tie: tie.delta_chi2)[: EXPERIMENT.most_ties]
    if not ties:
        return Proposal(None)
    candidates = next_runs(recorded, limits, set().union(*(tie.components for tie in ties)))
    if candidates is None:
        return Proposal(None, [open_tie(tie.names, needs_drive=True) for tie in ties])
    rated = _rate([Run(one, recorded.readings, noise) for one in candidates], ties, 1.0, 1)
    rated.sort(key=_Rated.rank, reverse=True)
    better = _rate([one.run for one in rated[: EXPERIMENT.refined]], ties, 1.0, 3)
    best = max(better, key=_Rated.rank, default=None)
    if best is None or not best.enough.any():
        return Proposal(None, [open_tie(tie.names, EXPERIMENT.longest_min) for tie in ties])
    run = best.run
    aim = EXPERIMENT.holds_back * EXPERIMENT.settles
    needed = max(aim / best.least, EXPERIMENT.shortest_min / run.minutes)
    repeats = min(math.ceil(needed), best.most_repeats)
    (final,) = _rate([run], ties, float(repeats), 3)
    names = [tie.names for tie in ties]
    return proposal(names, final.evidence, run.candidate.job(repeats), repeats * run.minutes)


def proposal(
    ties: Sequence[Sides], evidence: FloatArray, job: dict[str, Any], minutes: float
) -> Proposal:
    """A job, if it settles a tie, and the ties that it settles only if one side is true, or never.

    evidence: chi-square that the job gives, (n, 2), with the first and the second side true.
    """
    good, longest_min = evidence >= EXPERIMENT.settles, EXPERIMENT.longest_min
    pairs = list(zip(ties, good.tolist(), strict=True))
    left = [
        open_tie(sides[::-1] if second else sides, None if first or second else longest_min)
        for sides, (first, second) in pairs
        if not (first and second)
    ]
    if not good.any():
        return Proposal(None, left)
    names = (name for sides, each in pairs if any(each) for side in sides for name in side)
    experiment = NextExperiment(
        job=job,
        tells_apart=list(dict.fromkeys(names)),
        expected_delta_chi2=round(float(evidence[good].min()), 1),
        minutes=round(minutes, 2),
    )
    return Proposal(experiment, left)


def open_tie(sides: Sides, minutes: float | None = None, needs_drive: bool = False) -> OpenTie:
    """A tie that stays open; minutes: of the longest run, where none helps."""
    return OpenTie(one=sides[0], other=sides[1], minutes=minutes, needs_drive=needs_drive)


def _rate(runs: Sequence[Run], ties: Sequence[Tie], repeats: float, steps: int) -> list[_Rated]:
    def rated(run: Run) -> _Rated:
        return _Rated(run, np.array([both_ways(run, tie, repeats, steps) for tie in ties]))

    return [rated(run) for run in runs]
