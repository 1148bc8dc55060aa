"""Free shapes: a spline of one driver that enters at one port, the rival of every named effect."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array, diags_array

from diagnosis.observations.readings import FloatArray
from diagnosis.plants.contract import Model
from diagnosis.plants.traits import traits_of

PIECES = 4
FINE_PIECES = 28
DEGREE = 3
LEAST_TRAVEL = 0.005
LEAST_MOVE = 0.02
"""Share of the driver's range that it must move before it counts as having come another way."""


@dataclass(frozen=True, slots=True, eq=False)
class FreeShape:
    """A port, what the shape depends on, and its columns (n, k), few of which a sample meets.

    driver: a name, or two with a comma for a quantity made of both. kind: a spline of the driver,
    a spline that changes sign with the way the driver came (play that is wider at some places
    than at others), or sine and cosine of time `rate_hz` times a second.
    """

    port: str
    driver: str
    basis: csr_array
    knots: FloatArray
    kind: Literal["spline", "way", "sinusoid"] = "spline"
    rate_hz: float = 0.0

    @property
    def depends_on(self) -> list[str]:
        """The names in the driver."""
        return self.driver.split(", ")

    @property
    def size(self) -> int:
        """How many coefficients it has."""
        return int(self.basis.shape[1])

    def columns(self, change: FloatArray) -> FloatArray:
        """Change of the channels per coefficient, (n, channels, k)."""
        basis: FloatArray = self.basis.toarray()
        return change[:, :, None] * basis[:, None, :]

    def basis_for(self, driver: FloatArray) -> csr_array:
        """The same shape over another run of its driver, (n, k)."""
        if self.kind == "sinusoid":
            return waves(driver, self.rate_hz)
        basis = spline_basis(driver, self.knots)
        return basis if self.kind == "spline" else two_way(driver, basis)


Score = tuple[FreeShape, float, float]
"""A shape, the chi-square it would gain beside a solution, and log p of that."""


def knots_for(driver: FloatArray, pieces: int = PIECES) -> FloatArray:
    """Knots half-way between quantiles and equal steps, so that none spans an empty range."""
    share = np.linspace(0.0, 1.0, pieces + 1)
    inner = 0.5 * (np.quantile(driver, share) + driver.min() + np.ptp(driver) * share)
    inner = np.maximum.accumulate(inner + 1e-12 * np.arange(len(inner)))
    return np.concatenate([[inner[0]] * DEGREE, inner, [inner[-1]] * DEGREE])


def spline_basis(driver: FloatArray, knots: FloatArray) -> csr_array:
    """Cubic B-splines of a driver, constant beyond the outer knots; (n, pieces + DEGREE)."""
    return csr_array(
        BSpline.design_matrix(np.clip(driver, knots[0], knots[-1] - 1e-12), knots, DEGREE)
    )


def waves(t_s: FloatArray, rate_hz: float) -> csr_array:
    """Sine and cosine of time, (n, 2)."""
    turn = 2.0 * np.pi * rate_hz * t_s
    return csr_array(np.stack([np.sin(turn), np.cos(turn)], axis=1))


def two_way(driver: FloatArray, basis: csr_array) -> csr_array:
    """A basis that changes sign with the way its driver came."""
    return csr_array(diags_array(way(driver)) @ basis)


def way(driver: FloatArray) -> FloatArray:
    """+1 or -1: which way the driver last moved by more than a little; 0 before it did."""
    reach = LEAST_MOVE * float(np.ptp(driver))
    ways = np.zeros(len(driver))
    anchor, last = float(driver[0]), 0.0
    for k, value in enumerate(driver.tolist()):
        if abs(value - anchor) > reach:
            last = 1.0 if value > anchor else -1.0
            anchor = value - last * reach
        ways[k] = last
    return ways


def _varies(driver: FloatArray) -> bool:
    """Whether a driver takes different values, not one with a ripple on it."""
    return bool(np.ptp(driver) > LEAST_TRAVEL * np.abs(driver).max())


def free_shapes(model: Model, pieces: int = PIECES) -> list[FreeShape]:
    """Every port with every driver that makes sense there: a joint's own motion, a sensor's all."""
    shapes = []
    drivers, sensible = model.drivers(), traits_of(model).sensible
    knots = {name: knots_for(x, pieces) for name, x in drivers.items() if _varies(x)}
    bases = {name: spline_basis(drivers[name], k) for name, k in knots.items()}
    for port in model.ports():
        for name, basis in bases.items():
            if sensible(port, name, pieces == PIECES):
                shapes.append(FreeShape(port, name, basis, knots[name]))
    return shapes


def way_shapes(model: Model) -> list[FreeShape]:
    """Each port over its own place and the way it was come to."""
    drivers, shapes = model.drivers(), []
    own_place = traits_of(model).own_place
    for port in model.ports():
        name = own_place.get(port, "")
        if name in drivers and _varies(drivers[name]):
            knots = knots_for(drivers[name])
            free = FreeShape(port, name, csr_array((0, 0)), knots, "way")
            shapes.append(replace(free, basis=free.basis_for(drivers[name])))
    return shapes
