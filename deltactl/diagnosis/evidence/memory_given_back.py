"""What fitted shapes take out of correlated noise is given back to its variance and its memory.

A spline over time fits slow noise, and what it leaves looks smaller and quicker than the noise is:
a test of that spline against its own residual finds something in every tenth healthy sensor whose
noise has a memory of half a second. So noise with a known memory (autoregressive of first order) is
passed through the same fit, and the noise is taken to be the one whose residual has the memory that
is seen (indirect inference: Gourieroux, Monfort and Renault 1993, J. Appl. Econometrics 8, S85).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_banded

from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class GivenBack:
    """Factors by which variance and memory of the noise exceed those of a fit's residual."""

    variance: float
    memory: float


def given_back(shapes: FloatArray, groups: IntArray, memory: float) -> GivenBack:
    """Correction of a fit of shapes (m, p), in standard deviations of the noise and of their prior
    spreads.

    groups: (m,) stretches, each with a noise of its own. memory: integrated autocorrelation time
    that the residual has, in rows.
    """
    count, fitted = shapes.shape
    if count < 8 or not fitted:
        return GivenBack(1.0, 1.0)
    white = np.random.default_rng(0).standard_normal((count, EVIDENCE.simulated_noises))
    gram = np.linalg.inv(np.eye(fitted) + shapes.T @ shapes)
    seen: list[float] = []
    variance: list[float] = []
    longer: list[float] = []
    for rho in EVIDENCE.correlations:
        noise = _correlated(white, rho, groups)
        left = noise - shapes @ (gram @ (shapes.T @ noise))
        own = float(np.mean(autocorrelation_times(left, groups)))
        seen.append(max(own, seen[-1] if seen else 1.0))
        variance.append(float(np.mean(noise**2) / max(float(np.mean(left**2)), 1e-12)))
        longer.append(float(np.mean(autocorrelation_times(noise, groups))) / seen[-1])
        if seen[-1] > memory:  # what follows is beyond what is asked for
            break
    return GivenBack(
        float(np.interp(memory, seen, variance)), max(float(np.interp(memory, seen, longer)), 1.0)
    )


def _correlated(white: FloatArray, rho: float, groups: IntArray) -> FloatArray:
    """Noise (m, d) of unit variance, begun afresh in each stretch."""
    fresh = np.diff(groups, prepend=groups[0] - 1) != 0
    driven = np.where(fresh, 1.0, np.sqrt(1.0 - rho**2))[:, None] * white
    remembered = np.append(np.where(fresh[1:], 0.0, -rho), 0.0)
    noise: FloatArray = solve_banded((1, 0), np.stack([np.ones(len(white)), remembered]), driven)
    return noise


def autocorrelation_times(values: FloatArray, groups: IntArray) -> FloatArray:
    """Autocorrelation times of columns (m, d): 1 + 2 sum of the autocorrelation up to where it
    vanishes, (d,).

    No pair across groups (m,).
    """
    count = len(values)
    total = np.ones(values.shape[1])
    if count < 8:
        return total
    x = np.ascontiguousarray((values - values.mean(axis=0)).T)
    power, going = np.sum(x**2, axis=1) + 1e-300, np.arange(len(x))
    for lag in range(1, count // 3):
        near = groups[lag:] == groups[:-lag]
        pairs = int(near.sum())
        if not pairs or not len(going):
            break
        ahead = x[:, lag:] if pairs == len(near) else x[:, lag:] * near
        paired = np.einsum("ji,ji->j", ahead, x[:, :-lag]) / power
        on = paired * count / pairs >= EVIDENCE.uncorrelated
        if not on.all():
            x, power, paired, going = x[on], power[on], paired[on], going[on]
        total[going] += 2.0 * paired
    return np.maximum(total, 1.0)
