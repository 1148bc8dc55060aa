"""How far each arm is from where its counts say, beyond what it was when the job began.

Each good range is h . d - v L off, with d the errors of the three arms [rad], h its slopes, v the
speed at which it was meant to change, and L by how much the readings are late [s]. Two least
squares run beside each other: a fast one over the last second, and a slow one that remembers for a
minute. The slow one is precise, the fast one sees a jump; where they disagree beyond doubt for
more than a second, the slow one begins anew from the fast one. Residuals are weighed by Huber's
rule, so that outliers do not count for much. The errors are reported with their covariance.

Since what is expected is worked out from the edges really sent, corrections are expected too: the
estimate does not depend on them, and there is no loop that could be unstable.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.firmware_py.feedback.residuals import Residuals
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.robot import ARMS, AXES, FloatArray

BoolArray = np.ndarray[Any, np.dtype[np.bool_]]

FAST_S = 1.0
SLOW_S = 60.0
JUMP_CHI2 = 30.0
"""Chi-square of three numbers that chance exceeds once in a million looks."""
LOOKS_IN_A_ROW = 12
"""A tenth of a second each: the fast one then knows only what came after the jump."""
LEAST_ROWS = 40
HUBER = 2.0
LEAST_NOISE_M = 1e-3
LATE_S = 0.1
"""Readings are late by this much, give or take, before anything is known."""
RIDGE = 1e-9
DOUBT_CHI2 = 16.0
"""A single sensor that explains the rows as well as three arms to within this may be the liar."""


@dataclass(frozen=True)
class Estimate:
    """Errors of the arms (3,) [rad], true minus modelled, and their covariance (3, 3).

    late_s: by how much readings seem late beyond the robot file. suspect: a sensor that explains
    what is seen as well as the arms do; empty when there is none.
    """

    error_rad: FloatArray
    covariance_rad2: FloatArray
    late_s: float = 0.0
    suspect: str = ""

    @property
    def sigma_rad(self) -> FloatArray:
        """Standard deviations, (3,)."""
        sigma: FloatArray = np.sqrt(np.diag(self.covariance_rad2))
        return sigma


class SlowErrors:
    """Fed with residuals, look by look."""

    def __init__(self, noise_m: float = 0.002):
        self._noise_m = max(noise_m, LEAST_NOISE_M)
        self._rows = Residuals.none()
        self._information = np.zeros((ARMS + 1, ARMS + 1))
        self._weighted = np.zeros(ARMS + 1)
        self._looked_ns: int | None = None
        self._jumps = 0

    def look(self, new: Residuals, now_ns: int) -> Estimate | None:
        """Take new rows in; None until enough is known."""
        self._rows = self._rows.and_then(new).since(now_ns - round(FAST_S * NS_PER_S))
        before = self._slow()
        fast = self._fit(self._rows, before)
        suspect = "" if fast is None else self._suspect(fast) or self._contradicted(fast, before)
        if not suspect:  # what a liar says is not to be remembered
            self._remember(new, now_ns)
        slow = self._slow()
        if fast is None or slow is None:
            return None
        apart = (fast.at - slow.at)[:ARMS]
        spread = (fast.covariance + slow.covariance)[:ARMS, :ARMS]
        jumped = not suspect and float(apart @ np.linalg.solve(spread, apart)) > JUMP_CHI2
        self._jumps = self._jumps + 1 if jumped else 0
        if self._jumps >= LOOKS_IN_A_ROW:
            slow = self._begin_anew(fast, slow)
        return Estimate(
            slow.at[:ARMS], slow.covariance[:ARMS, :ARMS], float(slow.at[ARMS]), suspect
        )

    def _begin_anew(self, fast: _Fit, slow: _Fit) -> _Fit:
        """From the last second; how late readings are has not changed."""
        self._jumps = 0
        kept = np.zeros((ARMS + 1, ARMS + 1))
        kept[ARMS, ARMS] = 1.0 / slow.covariance[ARMS, ARMS]
        late = np.zeros(ARMS + 1)
        late[ARMS] = slow.at[ARMS]
        seen = np.linalg.inv(fast.covariance)
        self._information = seen + kept
        self._weighted = seen @ fast.at + kept @ late
        return self._slow() or slow

    def _remember(self, new: Residuals, now_ns: int) -> None:
        if self._looked_ns is not None:
            faded = float(np.exp(-(now_ns - self._looked_ns) / (SLOW_S * NS_PER_S)))
            self._information *= faded
            self._weighted *= faded
        self._looked_ns = now_ns
        if not len(new.t_ns):
            return
        slow, columns = self._slow(), _columns(new)
        weight = self._weights(new, np.zeros(ARMS + 1) if slow is None else slow.at)
        self._information += (columns * weight[:, None]).T @ columns
        self._weighted += (columns * weight[:, None]).T @ new.excess_m

    def _slow(self) -> _Fit | None:
        return _solved(self._information, self._weighted)

    def _fit(self, rows: Residuals, slow: _Fit | None) -> _Fit | None:
        """Robust least squares over some rows; how late readings are is known from before."""
        if len(rows.t_ns) < LEAST_ROWS:
            return None
        late_s = 0.0 if slow is None else float(slow.at[ARMS])
        sure = LATE_S**-2 if slow is None else 1.0 / float(slow.covariance[ARMS, ARMS])
        columns, found = _columns(rows), None
        weight = np.full(len(rows.t_ns), self._noise_m**-2)
        for _ in range(4):
            information = (columns * weight[:, None]).T @ columns
            information[ARMS, ARMS] += sure
            weighted = (columns.T * weight) @ rows.excess_m
            weighted[ARMS] += sure * late_s
            found = _solved(information, weighted)
            if found is None:
                return None
            weight = self._weights(rows, found.at)
        return found

    def _weights(self, rows: Residuals, at: FloatArray) -> FloatArray:
        left = np.abs(rows.excess_m - _columns(rows) @ at) / self._noise_m
        weight: FloatArray = np.minimum(1.0, HUBER / np.maximum(left, HUBER)) / self._noise_m**2
        return weight

    def _suspect(self, fast: _Fit) -> str:
        """A sensor whose offset explains the last second as well as errors of the arms."""
        rows, weight = self._rows, self._weights(self._rows, fast.at)
        seen_m = rows.excess_m + rows.rate_mps * fast.at[ARMS]
        best = _cost(seen_m - rows.slope_m @ fast.at[:ARMS], weight)
        if _cost(seen_m, weight) - best < JUMP_CHI2:
            return ""
        one_arm = min(_cost_of_arm(rows, seen_m, weight, arm) for arm in range(ARMS))
        sensors = [_cost_of_sensor(rows, seen_m, weight, axis) for axis in range(ARMS)]
        worst = int(np.argmin(sensors))
        lies = sensors[worst] < best + DOUBT_CHI2 and sensors[worst] < one_arm
        return AXES[worst] if lies else ""

    def _contradicted(self, fast: _Fit, slow: _Fit | None) -> str:
        """A sensor that alone saw a change: the others are as they were, whatever it says.

        An arm that is off is seen by more than one sensor; one that hangs, or wanders in whatever
        way, is not borne out by the others.
        """
        if slow is None:
            return ""
        rows = self._rows
        left_m = rows.excess_m - _columns(rows) @ slow.at
        everyone = np.ones(len(left_m), dtype=np.bool_)
        weight = self._weights(rows, fast.at)
        if _gain_of_arms(rows, left_m, weight, everyone) < JUMP_CHI2:
            return ""
        weight = self._weights(rows, slow.at)
        without = [_gain_of_arms(rows, left_m, weight, rows.axis != axis) for axis in range(ARMS)]
        alone = int(np.argmin(without))
        return AXES[alone] if without[alone] < DOUBT_CHI2 else ""


@dataclass(frozen=True)
class _Fit:
    """Errors of the arms and lateness, (4,), with covariance (4, 4)."""

    at: FloatArray
    covariance: FloatArray


def _solved(information: FloatArray, weighted: FloatArray) -> _Fit | None:
    """With what is known of lateness beforehand; None where the arms are not all seen."""
    if np.linalg.matrix_rank(information[:ARMS, :ARMS], tol=1.0) < ARMS:
        return None
    whole = information.copy()
    whole[ARMS, ARMS] += LATE_S**-2
    covariance = np.linalg.inv(whole)
    return _Fit(covariance @ weighted, covariance)


def _columns(rows: Residuals) -> FloatArray:
    """What each row changes by with the four unknowns, (n, 4)."""
    return np.column_stack([rows.slope_m, -rows.rate_mps])


def _cost(left_m: FloatArray, weight: FloatArray) -> float:
    return float(np.sum(weight * left_m**2))


def _gain_of_arms(
    rows: Residuals, left_m: FloatArray, weight: FloatArray, mine: BoolArray
) -> float:
    """What errors of the arms explain of some rows, in chi-square."""
    root = np.sqrt(weight[mine])
    columns, seen = rows.slope_m[mine] * root[:, None], left_m[mine] * root
    error_rad = np.linalg.lstsq(columns, seen, rcond=1e-6)[0]
    return float(np.sum(seen**2) - np.sum((seen - columns @ error_rad) ** 2))


def _cost_of_arm(rows: Residuals, seen_m: FloatArray, weight: FloatArray, arm: int) -> float:
    slope = rows.slope_m[:, arm]
    size = np.sum(weight * slope * seen_m) / max(np.sum(weight * slope**2), RIDGE)
    return _cost(seen_m - slope * size, weight)


def _cost_of_sensor(rows: Residuals, seen_m: FloatArray, weight: FloatArray, axis: int) -> float:
    mine = rows.axis == axis
    size = np.sum(weight[mine] * seen_m[mine]) / max(np.sum(weight[mine]), RIDGE)
    return _cost(seen_m - size * mine, weight)
