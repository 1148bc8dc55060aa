"""The Cramer-Rao bound of a case with one cause: how well its size could be known at all.

From this robot's own noiseless answer to a small change of each size, whitened by the noise that
was really put in (first-order correlated, rounded to millimetres, some readings missing).
"""

from __future__ import annotations

import copy

import numpy as np

from deltactl.proof.cases import Case
from deltactl.proof.hidden.build_in import Planned, construct
from deltactl.proof.hidden.hidden import Parameters
from deltactl.proof.recorded import Machine, sample_times
from deltactl.proof.robot.as_built import FloatArray
from deltactl.proof.robot.run import Truth, run
from deltactl.proof.sensors.noise import Noise
from deltactl.proof.sensors.ranging import ideal_ranges

ROUNDING_M = 1e-3
CHANGE = 0.04
NOT_FREE = ("time", "duration", "friction", "drag", "depth", "torque")
"""Moments of events, and what no finding reports."""


def bound(case: Case, still: FloatArray | None = None) -> dict[str, list[float]] | None:
    """Standard deviation of each size, its others free; None where it is not defined.

    Not for events (a moment is found on a grid), and only for cases with one cause.
    still: the case's noiseless readings, if they are known already.
    """
    if len(case.planned) != 1 or case.answers[0].effect == "unknown":
        return None
    part = case.planned[0]
    if part.kind.event or case.group == "tolerance":
        return None
    free = _free(part)
    if still is None:
        still = clean(case, part.parameters)
    slopes = []
    for name, place, step in free:
        moved = copy.deepcopy(part.parameters)
        value = moved[name]
        if isinstance(value, list):
            value[place] += step
        else:
            moved[name] = value + step
        slopes.append((clean(case, moved) - still) / step)
    spread = np.sqrt(np.diag(np.linalg.pinv(information(slopes, case.machine.noise))))
    deviations: dict[str, list[float]] = {}
    for (name, _, _), deviation in zip(free, spread, strict=True):
        deviations.setdefault(name, []).append(float(deviation))
    return deviations


def distance(case: Case, still: FloatArray | None = None) -> float:
    """How far a case's noiseless readings are from those of a robot with nothing wrong, in
    standard deviations of the noise: below about 5 nobody could be sure that anything is there."""
    if still is None:
        still = _readings(case, case.machine)
    off = still - _readings(case, Machine(noise=case.machine.noise))
    return float(np.sqrt(information([off], case.machine.noise)[0, 0]))


def information(slopes: list[FloatArray], noise: Noise) -> FloatArray:
    """Fisher information (k, k) of slopes (n, 3) each."""
    sigma = np.sqrt(noise.sigma_m**2 + ROUNDING_M**2 / 12.0)
    innovation = sigma * np.sqrt(1.0 - noise.rho**2)
    white = [(s[1:] - noise.rho * s[:-1]).ravel() / innovation for s in slopes]
    kept = 1.0 - noise.dropouts - noise.outliers
    gathered: FloatArray = kept * (np.array(white) @ np.array(white).T)
    return gathered


def clean(case: Case, parameters: Parameters) -> FloatArray:
    """Noiseless readings of the case's motion with other sizes, (n, 3) [m]."""
    part = case.planned[0]
    machine = Machine(noise=case.machine.noise)
    construct(machine, [Planned(part.kind, part.index, dict(parameters))], with_events=True)
    return _readings(case, machine)


def as_recorded(case: Case, truth: Truth) -> FloatArray | None:
    """Noiseless readings (n, 3) [m] of the run that was recorded; None where they depend on
    where in its play an arm began, which the bound's own runs do not share."""
    joints = case.machine.robot.joints
    if joints.play_rad.any() or joints.play_shape is not None:
        return None
    return ideal_ranges(case.machine.sensors, truth, sample_times(case.train))


def _readings(case: Case, machine: Machine) -> FloatArray:
    truth = run(machine.robot, case.train)
    return ideal_ranges(machine.sensors, truth, sample_times(case.train))


def _free(part: Planned) -> list[tuple[str, int, float]]:
    """Name, place in a vector, and step of every size that is not known."""
    free: list[tuple[str, int, float]] = []
    for name, value in part.parameters.items():
        lag = part.kind.effect in ("following_lag", "sensor_latency") and name == "time"
        if name in NOT_FREE and not lag:
            continue
        if isinstance(value, list):
            free += [(name, place, 1e-3) for place in range(len(value))]
        else:
            free.append((name, 0, _step(name, value)))
    return free


def _step(name: str, value: float) -> float:
    """A small change, in proportion where the size has a zero of its own."""
    fixed = {"phase": 0.05, "height": 5e-4, "dead_time": 2e-3}
    if name in fixed:
        return fixed[name]
    return CHANGE * (value - 1.0 if name == "scale" else value)
