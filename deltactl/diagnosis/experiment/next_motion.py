"""The next run of a chain by its efforts: the exciting motion, where that settles a tie."""

from __future__ import annotations

import math

import numpy as np

from deltactl.diagnosis.evidence.explanation import Explanation
from deltactl.diagnosis.experiment.design import EXPERIMENT
from deltactl.diagnosis.experiment.exciting_motion import (
    DESIGNED,
    REPEATS,
    SERIES_S,
    exciting_motion,
    moved_so,
)
from deltactl.diagnosis.experiment.propose import Proposal, open_tie, proposal
from deltactl.diagnosis.experiment.ties import Sides
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.chain.plant import ChainPlant
from deltactl.diagnosis.selection.named_first import Selected


def next_motion(plant: ChainPlant, selected: Selected) -> Proposal:
    """The motion that `init chain --motion` writes, where sets of effects that count differ by more
    than one of them being left out.
    """
    ties = _ties(selected)[: EXPERIMENT.most_ties]
    if not ties:
        return Proposal(None)
    series = exciting_motion(plant.robot, plant.chain)
    run = moved_so(plant.robot, plant.chain, series)
    run.adopt(plant)
    scale = _scale(plant, selected)[run.kinds[run.rows]]
    best = selected.best
    both = [(_separates(run, scale, best, e), _separates(run, scale, e, best)) for e, _ in ties]
    a_series = np.array(both) / DESIGNED
    most = int(60.0 * EXPERIMENT.longest_min / SERIES_S)
    able = a_series[a_series * most >= EXPERIMENT.settles]
    if not len(able):
        return Proposal(None, [open_tie(sides, EXPERIMENT.longest_min) for _, sides in ties])
    needed = math.ceil(EXPERIMENT.holds_back * EXPERIMENT.settles / float(able.min()))
    repeats = min(max(needed, REPEATS), most)
    job = series.job(plant.robot.name) | {"repeats": repeats}
    sides = [names for _, names in ties]
    return proposal(sides, a_series * repeats, job, repeats * SERIES_S / 60.0)


def _ties(selected: Selected) -> list[tuple[Explanation, Sides]]:
    """Sets that count, with a named effect that the best lacks, and the other way round."""
    of = {r.key: f"{r.effect} {r.component}" for r in selected.plant.regressors if not r.left_over}
    own, found = selected.best.found & of.keys(), []
    for one in selected.posterior.explanations[1:]:
        other = one.found & of.keys()
        sides = sorted(of[key] for key in own - other), sorted(of[key] for key in other - own)
        if all(sides):
            found.append((one, sides))
    return found


def _scale(plant: ChainPlant, selected: Selected) -> FloatArray:
    """How much a row of each joint counted in the recording, (joints,) [1/unit]."""
    joint, noise = plant.kinds[selected.noise.rows], selected.noise.scale
    each = [noise[joint == j] for j in range(len(plant.joints))]
    return np.array([float(np.median(one)) if len(one) else 0.0 for one in each])


def _separates(run: ChainPlant, scale: FloatArray, truth: Explanation, other: Explanation) -> float:
    """Chi-square that separates another set from the true one in a run, all of it refitted."""
    base = run.base(truth.keys, truth.sizes)
    acting = [(run.columns(key, base, truth.sizes), truth.linear[key]) for key in _named(truth)]
    seen = base + sum(columns.values @ size for columns, size in acting)
    begun = run.base(other.keys, other.sizes)
    shapes = [run.free(), *(run.columns(key, begun, other.sizes) for key in _named(other))]
    white = np.concatenate([one.values[run.rows] * one.spread for one in shapes], axis=1)
    white *= scale[:, None]
    left = (seen - begun)[run.rows] * scale
    theta = np.linalg.solve(np.eye(white.shape[1]) + white.T @ white, white.T @ left)
    return float(left @ (left - white @ theta))


def _named(one: Explanation) -> list[str]:
    return sorted(key for key in one.keys if not key.startswith("unknown "))
