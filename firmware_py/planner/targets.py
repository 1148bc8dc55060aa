"""Laps: the targets of a path in the order they are driven, with their angles and counts.

A lap begins where the arms already are (its target 0) and ends at rest. The first lap is
the path itself; every further one begins with the way back, unless the path is closed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from deltactl.drivers.steps.contract import Int64Array
from deltactl.firmware_py.paths.path import BoolArray, Path, Space
from deltactl.foundation.errors import LimitExceeded, MotionError
from deltactl.models.inverse_kinematics import InverseKinematics
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import FloatArray

_BLOCK = 8192

WILD_RAD = 1e3
"""No arm angle, whatever the limits: not a number, or a number from nowhere."""


@dataclass(frozen=True, slots=True, eq=False)
class Lap:
    """Targets of one lap; arrays of n rows, target 0 being where the arms are already.

    targets: (n, 3), m or rad. number: (n,), number in the path, -1 on the way back.
    dwell_s: (n,), rest[n]: as in a Path, target 0 without dwell.
    angles_rad, counts, position_m: (n, 3), commanded angles, whole steps, platform.
    """

    space: Space
    targets: FloatArray
    number: Int64Array
    dwell_s: FloatArray
    rest: BoolArray
    angles_rad: FloatArray
    counts: Int64Array
    position_m: FloatArray
    speed_mps: FloatArray | None = None
    """As in a Path, (n,)."""
    mapped: Int64Array | None = None
    """Counts (n, 3) that the inverse kinematics gave, where others are commanded."""

    def __len__(self) -> int:
        return len(self.targets)

    @property
    def length_m(self) -> float:
        """From target to target in straight lines [m]."""
        return float(np.linalg.norm(np.diff(self.position_m, axis=0), axis=1).sum())

    @property
    def mapped_counts(self) -> Int64Array:
        """What the inverse kinematics must answer again."""
        return self.counts if self.mapped is None else self.mapped

    def says(self, row: int) -> str:
        """A target in words."""
        number = int(self.number[row])
        name = f"point {number}" if number > 0 else "the start"
        if number < 0:
            name = f"point {row} of the way back to the start"
        if self.space is Space.CARTESIAN:
            x, y, z = self.targets[row]
            return f"{name} at ({x:.4f}, {y:.4f}, {z:.4f}) m"
        first, second, third = np.rad2deg(self.targets[row])
        return f"{name} at arm angles ({first:.2f}, {second:.2f}, {third:.2f}) deg"


def in_repeat(repeat: int, repeats: int) -> str:
    """' (repeat 2)' behind a target; empty for a job without repeats."""
    return f" (repeat {repeat})" if repeats > 1 else ""


@dataclass(frozen=True, slots=True)
class MappingFailed:
    """Why the targets after the last mapped one have no angles."""

    error: MotionError


class LapBuilder:
    """Maps the targets of a path for one robot, target by target as the stream will."""

    def __init__(self, kinematics: InverseKinematics, linkage: Linkage, rad_per_step: float):
        self._kinematics = kinematics
        self._linkage = linkage
        self._rad_per_step = rad_per_step

    def first(self, path: Path) -> tuple[Lap, MappingFailed | None]:
        """The path once. The lap ends before the first target that cannot be mapped."""
        return self._build(path, path.targets, path.dwell_s, path.rest, np.arange(len(path)))

    def again(self, path: Path) -> tuple[Lap, MappingFailed | None]:
        """From the end of an open path back to its start and along it once more."""
        back = len(path.way_back)
        still = np.zeros(back, dtype=np.bool_)
        return self._build(
            path,
            np.concatenate([path.targets[-1:], path.way_back, path.targets]),
            np.concatenate([[0.0], np.zeros(back), path.dwell_s]),
            np.concatenate([[True], still, [True], path.rest[1:]]),
            np.concatenate([[len(path) - 1], np.full(back, -1), np.arange(len(path))]),
        )

    def _build(
        self,
        path: Path,
        targets: FloatArray,
        dwell_s: FloatArray,
        rest: BoolArray,
        number: Int64Array,
    ) -> tuple[Lap, MappingFailed | None]:
        if path.space is Space.JOINT:
            angles_rad, failed = targets, None
            position_m = forward(self._linkage, targets).position_m
        else:
            angles_rad, failed = self._map(targets)
            position_m = targets[: len(angles_rad)]
        good = len(angles_rad)
        # The rest at target 0 belongs to the motion that led there.
        dwell_s = np.concatenate([[0.0], dwell_s[1:good]])
        counts = np.rint(angles_rad / self._rad_per_step).astype(np.int64)
        lap = Lap(
            path.space,
            targets[:good],
            number[:good],
            dwell_s[:good],
            rest[:good],
            angles_rad,
            counts,
            position_m,
            None if path.speed_mps is None else _speeds(path.speed_mps, number[:good]),
        )
        return lap, failed

    def _map(self, targets_m: FloatArray) -> tuple[FloatArray, MappingFailed | None]:
        angles_rad = np.empty_like(targets_m)
        for row, (x_m, y_m, z_m) in enumerate(_rows(targets_m)):
            try:
                arms = self._kinematics.angles_rad(x_m, y_m, z_m)
            except MotionError as error:
                return angles_rad[:row], MappingFailed(error)
            if not all(abs(angle) < WILD_RAD for angle in arms):  # also when one is NaN
                wild = LimitExceeded(
                    f"target ({x_m:.4f}, {y_m:.4f}, {z_m:.4f}) m: the inverse kinematics"
                    f" answers {arms}; the network file must be broken"
                )
                return angles_rad[:row], MappingFailed(wild)
            angles_rad[row] = arms
        return angles_rad, None


def _speeds(speed_mps: FloatArray, number: Int64Array) -> FloatArray:
    """Speeds by numbers in the path; the way back has the job's."""
    speeds: FloatArray = np.where(number >= 0, speed_mps[number], np.inf)
    return speeds


def _rows(targets_m: FloatArray) -> Iterator[list[float]]:
    """Rows as plain floats, a block at a time to save memory."""
    for first in range(0, len(targets_m), _BLOCK):
        yield from targets_m[first : first + _BLOCK].tolist()
