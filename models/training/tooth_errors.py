"""Errors that repeat with an arm's angle, such as those of gear teeth: found in what is left.

A calibrated geometry leaves what is finer than any length can explain. An error of a gear repeats a
fixed number of times a turn; the number shows as a peak when what is left is held against sines of
the arm's angle (Lomb 1976). The errors of worn teeth are no sines: harmonics go with it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.models.robot import ARMS, FloatArray

MOST_PER_TURN = 400.0
"""Finer than the teeth of any small gear."""
_LEAST_PERIODS = 3.0
"""An error that repeats fewer times over the measured angles could be anything smooth."""
_PER_PERIOD = 8
"""Trial frequencies for each that the measured range can tell apart."""
_HARMONICS = 4


@dataclass(frozen=True, eq=False)
class ToothErrors:
    """Errors of the three gears as sums of sines of the arm's angle."""

    per_turn: FloatArray
    """How often each repeats in a turn of its arm, (3,)."""
    parts_rad: FloatArray
    """(3 arms, 1 + 2 * harmonics): constant, then sine and cosine of each harmonic."""

    def error_rad(self, angles_rad: FloatArray) -> FloatArray:
        """Errors (n, 3) at angles (n, 3)."""
        columns = [
            _columns(angles_rad[:, arm], self.per_turn[arm]) @ self.parts_rad[arm]
            for arm in range(ARMS)
        ]
        return np.stack(columns, axis=1)

    @property
    def numbers(self) -> int:
        """How many numbers were fitted."""
        return self.per_turn.size + self.parts_rad.size


def find_tooth_errors(angles_rad: FloatArray, left_rad: FloatArray) -> ToothErrors:
    """From what a calibration leaves (n, 3) at angles (n, 3), for each arm by itself."""
    found = [_find(angles_rad[:, arm], left_rad[:, arm]) for arm in range(ARMS)]
    per_turn, parts = zip(*found, strict=True)
    return ToothErrors(np.array(per_turn), np.stack(parts))


def _find(angle_rad: FloatArray, left_rad: FloatArray) -> tuple[float, FloatArray]:
    turns = float(np.ptp(angle_rad)) / (2.0 * np.pi)
    trials = np.arange(_LEAST_PERIODS / turns, MOST_PER_TURN, 1.0 / (turns * _PER_PERIOD))
    centred = left_rad - left_rad.mean()
    powers = [abs(np.exp(-1j * trial * angle_rad) @ centred) for trial in trials]
    best = float(trials[int(np.argmax(powers))])
    nearby = np.linspace(best - 0.5 / turns, best + 0.5 / turns, 41)
    fits = [_fit(angle_rad, left_rad, per_turn) for per_turn in nearby]
    chosen = int(np.argmin([cost for cost, _ in fits]))
    return float(nearby[chosen]), fits[chosen][1]


def _fit(angle_rad: FloatArray, left_rad: FloatArray, per_turn: float) -> tuple[float, FloatArray]:
    columns = _columns(angle_rad, per_turn)
    parts: FloatArray = np.linalg.lstsq(columns, left_rad, rcond=None)[0]
    return float(np.sum((columns @ parts - left_rad) ** 2)), parts


def _columns(angle_rad: FloatArray, per_turn: float) -> FloatArray:
    """(n, 1 + 2 * harmonics)."""
    phases = [k * per_turn * angle_rad for k in range(1, _HARMONICS + 1)]
    waves = [wave(phase) for phase in phases for wave in (np.sin, np.cos)]
    return np.stack([np.ones_like(angle_rad), *waves], axis=1)
