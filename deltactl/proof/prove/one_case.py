"""The function that runs for each case, and what an ideal observer could tell of it."""

from __future__ import annotations

import copy
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.foundation.errors import DeltactlError
from deltactl.proof.cases import HOLDOUT, RECORDING, ROBOT_FILE, Case, draw, draw_more, write_blind
from deltactl.proof.hidden.hidden import Parameters
from deltactl.proof.hidden.vocabulary import Planned, construct
from deltactl.proof.ranging import Noise, ideal_ranges
from deltactl.proof.recorded import Machine, sample_times
from deltactl.proof.robot.as_built import FloatArray
from deltactl.proof.robot.run import Truth, run

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


WITH_BOUND = ("single", "faint")


def run_case(seed: int, number: int) -> dict[str, Any]:
    """Draw, simulate, diagnose blind; returns the truth, the answer and what it took as JSON."""
    return _blind(draw(seed, number), seed)


def run_more(seed: int, number: int) -> dict[str, Any]:
    """The same for a case of the second set."""
    return _blind(draw_more(seed, number), seed)


def _blind(case: Case, seed: int) -> dict[str, Any]:
    begun = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="prove-") as folder:
        truth = write_blind(case, Path(folder), seed)
        simulated = time.monotonic()
        answer, failure = diagnose_blind(Path(folder))
        diagnosed = time.monotonic()
    still = as_recorded(case, truth) if case.group in WITH_BOUND else None
    return {
        "seed": seed,
        "truth": case.truth(),
        "diagnosis": answer,
        "failure": failure,
        "bound": bound(case, still) if case.group in WITH_BOUND else None,
        "distance": distance(case, still) if _has_distance(case) else None,
        "simulated_s": simulated - begun,
        "diagnosed_s": diagnosed - simulated,
    }


def _has_distance(case: Case) -> bool:
    """A repeated value is not in the noiseless readings."""
    return case.group in WITH_BOUND and case.answers[0].effect != "stale_reading"


def diagnose_blind(
    folder: Path, also: Sequence[str] = ()
) -> tuple[dict[str, Any] | None, str | None]:
    """Diagnose a folder that holds a recording and a robot file, and maybe one to hold out.

    On one core: the others have cases of their own. Returns the contract's JSON, or what went
    wrong: a failure counts as a wrong answer.
    """
    from deltactl.diagnosis.api import diagnose

    kept_back = folder / HOLDOUT
    try:
        answer = diagnose(
            [folder / RECORDING, *(folder / name for name in also)],
            robot=folder / ROBOT_FILE,
            holdout=[kept_back] if kept_back.exists() else [],
        )
    except DeltactlError as error:
        return None, str(error)
    except Exception as error:  # a crash of the engine is a result, not the end of the proof
        return None, f"{type(error).__name__}: {error}"
    return answer.to_json(), None
