"""Our own recipe for measured data: calibrate the physics, then teach its inverse to a network.

A calibration needs 39 numbers from the data, Zhao's network 18 203; so it does with hundreds of
samples what the network does not do with thousands, and the sensors' noise and bias stay out of
the answer. The network that is written learns the calibrated robot's exact inverse
(distillation): it is a tenth of the size of Zhao's and needs no data of its own.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace

import numpy as np

from deltactl.foundation.process import one_thread
from deltactl.models.robot import DeltaRobot, FloatArray
from deltactl.models.training.arm_networks import train_arms
from deltactl.models.training.calibrate import Calibrated, Plausible, calibrate
from deltactl.models.training.recipe import Follow, Settings, Trained, unseen
from deltactl.models.training.samples import SMALLEST_MARGIN, random_poses, split

RECIPE = "ours"
_BEYOND_DEG = 3.0
"""Poses a little beyond the data's angles are learned too, so that its edges are not the net's."""
_EFFORT = Settings(hidden=(16, 16), iterations=250, rounds=1, iterations_a_round=50)


@dataclass(frozen=True)
class CalibratedSettings:
    """What is plausible, and the effort of teaching the network."""

    plausible: Plausible = field(default_factory=Plausible)
    poses: int = 3000
    """Exact poses the network learns."""
    effort: Settings = _EFFORT

    def as_metadata(self) -> dict[str, float | int | str]:
        """Plain values for the file's metadata."""
        effort = self.effort.as_metadata()
        used = ("hidden", "iterations", "rounds", "iterations_a_round")
        return {
            "poses": self.poses,
            **{name: effort[name] for name in used},
            **{f"plausible_{name}": value for name, value in asdict(self.plausible).items()},
        }


@one_thread
def train_calibrated(
    robot: DeltaRobot,
    position_m: FloatArray,
    angles_rad: FloatArray,
    settings: CalibratedSettings | None = None,
    seed: int = 0,
    follow: Follow = unseen,
) -> Trained:
    """Train on measured positions (n, 3) [m] and commanded arm angles (n, 3) [rad].

    `robot` is the robot file's. Positions asked of the network are true ones, as far as the data
    tell true from measured. Raises NetworkError when the data cannot be this robot's.
    """
    settings = settings or CalibratedSettings()
    total = 3 * settings.effort.total
    rows, held = split(len(position_m), seed)
    follow(0, total, "calibrating")
    found = calibrate(robot, position_m[rows], angles_rad[rows], settings.plausible)
    left_mm = 1e3 * rms_left_m(found, position_m[held], angles_rad[held])
    follow(0, total, f"calibrated: held-out positions to {left_mm:.2f} mm")
    trained = teach(found, angles_rad, settings, seed, follow)
    error_deg = trained.rmse_deg(position_m[held], angles_rad[held])
    remark = f"held-out positions to {left_mm:.2f} mm RMS; noise {1e3 * found.noise_m:.2f} mm"
    return replace(
        trained,
        samples=len(rows),
        course=((total, error_deg),),
        remarks=(
            ("calibrated robot", remark),
            ("answers for", "true positions: errors above hold what the sensors get wrong, too"),
        ),
    )


def teach(
    found: Calibrated,
    angles_rad: FloatArray,
    settings: CalibratedSettings,
    seed: int,
    follow: Follow,
) -> Trained:
    """A network with the inverse of a calibrated robot, over the range of `angles_rad` (n, 3)."""
    exact_m, exact_rad = exact_poses(found, angles_rad, settings.poses, seed)
    graph, source, result, parameters = train_arms(
        found.linkage, exact_m, exact_rad, settings.effort, seed, follow
    )
    sizes = "-".join(map(str, (3, *settings.effort.hidden, 1)))
    return Trained(
        graph=graph,
        source=source,
        result=result,
        recipe=RECIPE,
        architecture=f"{sizes} tanh, one an arm, of a calibrated robot",
        parameters=parameters,
        samples=len(angles_rad),
        settings=settings.as_metadata(),
        seed=seed,
    )


def exact_poses(
    found: Calibrated, angles_rad: FloatArray, count: int, seed: int
) -> tuple[FloatArray, FloatArray]:
    """Positions [m] and commanded angles [rad] of the calibrated robot, both (at most count, 3)."""
    low, high = np.rad2deg(angles_rad.min()), np.rad2deg(angles_rad.max())
    reach_deg = (float(low) - _BEYOND_DEG, float(high) + _BEYOND_DEG)
    _, drawn_rad = random_poses(found.linkage, count, reach_deg, seed, SMALLEST_MARGIN / 2)
    exact_m = found.position_m(drawn_rad)
    known = np.isfinite(exact_m).all(axis=1)
    return exact_m[known], drawn_rad[known]


def rms_left_m(found: Calibrated, position_m: FloatArray, angles_rad: FloatArray) -> float:
    """Root mean square of measured less predicted positions [m], samples off the linkage aside."""
    left_m = found.measured_m(angles_rad) - position_m
    return float(np.sqrt(np.nanmean(left_m**2)))
