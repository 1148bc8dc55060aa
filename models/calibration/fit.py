"""Least squares for the robot that would have given a data set's positions.

Bayes' way with normal tolerances: the sum of squared misfits (in units of the samples' own
spread, large ones counted less) and of squared departures from the robot file (in units of what
is likely) is smallest. The chain of `models.chain` is the model, so what is found is a robot file.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from foundation.errors import ConfigError
from models.calibration.unknowns import Unknown, entries, unknowns
from models.chain.commands import Commands
from models.chain.delta import Chain
from models.robot import DeltaRobot, FloatArray
from models.training.dataset import DataSet

CAPABLE = 1500
"""Samples looked at in the first rounds; all of them in the last."""
STEP = 1e-3
SIGMA_M = 0.010
"""Spread of the samples before anything is known."""
FARTHEST = 3.4
"""Nothing departs by more than so many times what is likely."""
ROUNDS = 5
OUTLIER = 3.0
"""Misfits beyond so many spreads are counted less."""


@dataclass(frozen=True)
class Calibration:
    """robot: with the effects that were found. misfit_m: (n, 3) measured less expected."""

    robot: DeltaRobot
    looked_for: tuple[Unknown, ...]
    values: FloatArray
    """In units of `likely`, shape (unknowns,)."""
    sigma: FloatArray
    """How sure each is, in the same units; 1 is: the samples say nothing about it."""
    misfit_m: FloatArray
    spread_m: float


def calibrate(data: DataSet, robot: DeltaRobot) -> Calibration:
    """Fit. Raises RecordingError for a data set that is no use, ConfigError without masses."""
    from scipy.optimize import least_squares

    data.check(robot)
    if robot.masses is None or robot.drive is None:
        raise ConfigError(f"robot '{robot.name}': its file needs masses and drive to be calibrated")
    waves = robot.drive.gear_ratio
    looked_for = unknowns(waves)
    values, spread_m = np.zeros(len(looked_for)), SIGMA_M
    fitted = None
    for count in sorted({min(CAPABLE, len(data)), len(data)}):
        model = _Model(data.first(count), robot, looked_for, waves)
        for _ in range(ROUNDS):
            scale = spread_m

            def cost(trial: FloatArray, model: _Model = model, scale: float = scale) -> FloatArray:
                return _weighed(model.misfit_m(trial) / scale, trial)

            def slope(trial: FloatArray, model: _Model = model, scale: float = scale) -> FloatArray:
                return _slope(cost, trial)

            fitted = least_squares(
                cost, values, jac=slope, bounds=(-FARTHEST, FARTHEST), xtol=1e-7, ftol=1e-7
            )
            values = fitted.x
            spread_m = _spread(model.misfit_m(values))
            if abs(spread_m / scale - 1.0) < 0.02:
                break
    assert fitted is not None
    normal = fitted.jac.T @ fitted.jac
    sigma = np.sqrt(np.diag(np.linalg.inv(normal)))
    found = robot.model_copy(update={"effects": entries(looked_for, values, waves)})
    return Calibration(found, looked_for, values, sigma, model.misfit_m(values), spread_m)


class _Model:
    """Where samples should have been seen, for values of the unknowns."""

    def __init__(
        self, data: DataSet, robot: DeltaRobot, looked_for: tuple[Unknown, ...], waves: float
    ):
        assert robot.drive is not None
        assert robot.sensors is not None
        self.looked_for, self.waves = looked_for, waves
        self.chain = Chain(robot.model_copy(update={"effects": ()}))
        t_s = np.arange(len(data), dtype=np.float64)
        self.course = self.chain.course(Commands.of_angles(t_s, data.angles_rad))
        self.axes, self.offsets_m = robot.sensors.axes, robot.sensors.offsets_m
        self.seen_m = data.position_m

    def misfit_m(self, values: FloatArray) -> FloatArray:
        """Measured less expected, (n, 3); large where the linkage cannot be put together."""
        effects = entries(self.looked_for, values, self.waves)
        ranges_m = self.chain.simulate(self.course, effects).ranges
        expected_m = np.linalg.solve(self.axes, (ranges_m - self.offsets_m).T).T
        return np.nan_to_num(self.seen_m - expected_m, nan=1.0)


def _weighed(misfit: FloatArray, values: FloatArray) -> FloatArray:
    """Huber's loss written as residuals, and the tolerances behind them."""
    size = np.abs(misfit)
    softened = np.where(
        size > OUTLIER, np.sqrt(np.maximum(2 * OUTLIER * size - OUTLIER**2, 0)), size
    )
    return np.concatenate([(np.sign(misfit) * softened).ravel(), values])


def _slope(cost, at: FloatArray) -> FloatArray:  # type: ignore[no-untyped-def]
    columns = []
    for k in range(len(at)):
        step = np.zeros_like(at)
        step[k] = STEP
        columns.append((cost(at + step) - cost(at - step)) / (2.0 * STEP))
    return np.stack(columns, axis=1)


def _spread(misfit_m: FloatArray) -> float:
    """Standard deviation that a few wild misfits do not spoil."""
    return float(1.4826 * np.median(np.abs(misfit_m - np.median(misfit_m, axis=0))))
