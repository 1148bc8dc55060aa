"""A motion in which the efforts of a chain should be recorded: the one that shows its errors best.

Each joint follows a Fourier series of a few harmonics, which begins and ends at rest (Swevers,
Ganseman, Tükel, De Schutter and Van Brussel 1997, IEEE Transactions on Robotics and Automation 13,
730-740). Series are drawn within the limits of the joints. The one is taken whose information on
all effects has the largest determinant, as for `calibration_poses`; then each joint's is exchanged.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.diagnosis.experiment.calibration_poses import WITHIN
from deltactl.diagnosis.plants.chain.joint_motions import MEASURED
from deltactl.diagnosis.plants.chain.plant import ChainPlant
from deltactl.models.rigid_chain import RigidChain
from deltactl.models.robot import ChainRobot, FloatArray
from deltactl.recording.tables.flat import FlatRecording

SERIES_S = 20.0
"""Length of one series: the slowest wave has 0.05 Hz, the fastest of five 0.25 Hz."""
REPEATS = 3
"""A minute: what comes back in each is no noise."""
DESIGNED = 2
"""Series by which motions are compared."""
RATE_HZ = 50.0
HARMONICS = 5
OF_TOP_SPEED = 0.5
"""Share of the velocity limits that is used."""
UNLIMITED = 1.0
"""Top speed [rad/s or m/s] where the model states none."""
DRAWN = 12
"""Series that are drawn for all joints; then one more for each."""


@dataclass(frozen=True, eq=False)
class Series:
    """middle: (joints,) [rad or m]; sine, cosine: (harmonics, joints) of the positions."""

    middle: FloatArray
    sine: FloatArray
    cosine: FloatArray

    def at(self, t_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions and velocities (n, joints)."""
        w = 2.0 * np.pi / SERIES_S * np.arange(1, len(self.sine) + 1)
        sines, cosines = np.sin(np.outer(t_s, w)), np.cos(np.outer(t_s, w))
        return (
            self.middle + sines @ self.sine + cosines @ self.cosine,
            (cosines * w) @ self.sine - (sines * w) @ self.cosine,
        )

    def table(self) -> FloatArray:
        """Times and positions (n, 1 + joints) of all repeats."""
        t_s = np.arange(0.0, REPEATS * SERIES_S + 0.5 / RATE_HZ, 1.0 / RATE_HZ)
        return np.column_stack([t_s, self.at(t_s)[0]])

    def job(self, robot: str) -> dict[str, Any]:
        """As plain data, for any controller."""
        path: dict[str, Any] = {"shape": "fourier", "period_s": SERIES_S}
        parts = (("middle", self.middle), ("sine", self.sine), ("cosine", self.cosine))
        path |= {name: np.round(each, 6).tolist() for name, each in parts}
        return {"name": "exciting-motion", "robot": robot, "repeats": REPEATS, "path": path}


def exciting_motion(robot: ChainRobot, chain: RigidChain) -> Series:
    """The best of the series that were drawn, and once exchanged joint by joint.

    Whether the arm meets itself or anything else on its way is not looked at.
    """
    rng = np.random.default_rng(0)
    each = [drawn_blindly(rng, chain) for _ in range(DRAWN)]
    gains = [information(robot, chain, one) for one in each]
    series, most = each[int(np.argmax(gains))], max(gains)
    for joint in range(len(chain.joints)):
        other = _exchanged(series, drawn_blindly(rng, chain), joint)
        if (gained := information(robot, chain, other)) > most:
            series, most = other, gained
    return series


def information(robot: ChainRobot, chain: RigidChain, series: Series) -> float:
    """Log determinant of the information of a series on all effects, each in its usual size."""
    plant = moved_so(robot, chain, series)
    keys = [r.key for r in plant.regressors if not (r.left_over or r.sizes)]
    named = [plant.columns(key, plant.observed, {}) for key in keys]
    white = plant.whitened([plant.free(), *named])
    return float(np.linalg.slogdet(np.eye(white.shape[1]) + white.T @ white)[1])


def moved_so(robot: ChainRobot, chain: RigidChain, series: Series) -> ChainPlant:
    """The chain in some series, with efforts as its model has them."""
    return ChainPlant(robot, [recording(chain, series)], chain)


def recording(chain: RigidChain, series: Series) -> FlatRecording:
    """Positions, velocities and efforts of the chain as its model has them."""
    t_s = np.arange(0.0, DESIGNED * SERIES_S, 1.0 / RATE_HZ)
    at, speed = series.at(t_s)
    effort = chain.efforts(at, speed, np.gradient(speed, t_s, axis=0))
    columns = {
        f"{stem}_{j + 1}": values[:, j]
        for stem, values in zip(MEASURED, (at, effort, speed), strict=True)
        for j in range(len(chain.joints))
    }
    return FlatRecording(t_s, columns, {}, "exciting motion")


def drawn_blindly(rng: np.random.Generator, chain: RigidChain) -> Series:
    """A series that begins at rest, as large as positions and velocities may be."""
    low, high = chain.limits
    number = np.arange(1, HARMONICS + 1)[:, None]
    sine, cosine = rng.standard_normal((2, HARMONICS, len(low))) / number
    sine -= number * np.sum(number * sine, axis=0) / np.sum(number**2)
    cosine -= number**2 * np.sum(number**2 * cosine, axis=0) / np.sum(number**4)
    at, speed = Series(0.0 * low, sine, cosine).at(np.linspace(0.0, SERIES_S, 400))
    top = np.where(np.isfinite(chain.top_speeds), OF_TOP_SPEED * chain.top_speeds, UNLIMITED)
    size = np.minimum(WITHIN * (high - low) / np.ptp(at, axis=0), top / np.abs(speed).max(axis=0))
    middle = 0.5 * (low + high) - 0.5 * size * (at.max(axis=0) + at.min(axis=0))
    return Series(middle, size * sine, size * cosine)


def _exchanged(one: Series, other: Series, joint: int) -> Series:
    """A series with that of one joint from another."""
    mixed = [np.array(part) for part in (one.middle, one.sine, one.cosine)]
    for own, new in zip(mixed, (other.middle, other.sine, other.cosine), strict=True):
        own[..., joint] = new[..., joint]
    return Series(*mixed)
