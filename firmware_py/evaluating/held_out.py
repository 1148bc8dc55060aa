"""Errors on held-out samples: per joint, and what they mean for the platform per axis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.models.linkage import Linkage, forward
from deltactl.models.network.metadata import NetworkMetadata
from deltactl.models.robot import DeltaRobot, FloatArray
from deltactl.models.training.dataset import DataSet
from deltactl.models.training.samples import IntArray, split

Angles = Callable[[FloatArray], FloatArray]
"""Positions (n, 3) [m] to commanded angles (n, 3) [rad], NaN where there are none."""


@dataclass(frozen=True)
class HeldOut:
    """Rows of a data set: `judged` were not trained on, `trained` were (or may have been)."""

    judged: IntArray
    trained: IntArray
    words: str


@dataclass(frozen=True)
class Errors:
    """Sizes per joint [deg] and per axis [m], (3,); unanswered: samples without an answer.

    The median beside the RMS: past an arm's dead point one position has two answers, and the few
    poses there make most of the RMS.
    """

    joint_median_deg: FloatArray
    joint_rms_deg: FloatArray
    joint_max_deg: FloatArray
    axis_rms_m: FloatArray
    axis_max_m: FloatArray
    samples: int
    unanswered: int

    def as_json(self) -> dict[str, Any]:
        """Plain types."""
        return {
            "joint_median_deg": self.joint_median_deg.tolist(),
            "joint_rms_deg": self.joint_rms_deg.tolist(),
            "joint_max_deg": self.joint_max_deg.tolist(),
            "axis_rms_m": self.axis_rms_m.tolist(),
            "axis_max_m": self.axis_max_m.tolist(),
            "samples": self.samples,
            "unanswered": self.unanswered,
        }


def held_out(data: DataSet, metadata: NetworkMetadata) -> HeldOut:
    """Which samples a network has not seen, by what its file says it learned from."""
    training = metadata.training
    used = training.samples + training.held_out
    everything = np.arange(len(data))
    if training.data and used <= len(data) and data.first(used).digest == training.data:
        trained, judged = split(used, training.seed)
        judged = np.concatenate([judged, everything[used:]])
        return HeldOut(judged, trained, f"{len(judged)} samples it was not trained on")
    trained, _ = split(len(data), 0)
    words = f"all {len(data)} samples: it was trained on other data ({training.source})"
    return HeldOut(everything, trained, words)


def errors(angles: Angles, data: DataSet, robot: DeltaRobot, rows: IntArray) -> Errors:
    """Answers at measured positions against the counts that led there.

    Per axis: how far the robot file's linkage moves for the error in the angles.
    """
    wanted_rad = data.angles_rad[rows]
    error_rad = angles(data.position_m[rows]) - wanted_rad
    linkage = Linkage.of(robot.geometry)
    moved_m = (
        forward(linkage, wanted_rad + error_rad).position_m
        - forward(linkage, wanted_rad).position_m
    )
    known = np.isfinite(error_rad).all(axis=1) & np.isfinite(moved_m).all(axis=1)
    error_deg, moved_m = np.rad2deg(error_rad[known]), moved_m[known]
    if not known.any():
        nothing = np.full(3, np.nan)
        return Errors(nothing, nothing, nothing, nothing, nothing, 0, len(rows))
    return Errors(
        np.median(np.abs(error_deg), axis=0),
        np.sqrt(np.mean(error_deg**2, axis=0)),
        np.abs(error_deg).max(axis=0, initial=0.0),
        np.sqrt(np.mean(moved_m**2, axis=0)),
        np.abs(moved_m).max(axis=0, initial=0.0),
        int(known.sum()),
        int((~known).sum()),
    )
