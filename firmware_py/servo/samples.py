"""What the loop leaves behind for the recording: means over short stretches of its ticks."""

from __future__ import annotations

from dataclasses import dataclass

from deltactl.drivers.current_drives import JOINTS, Three

Row = tuple[float, ...]
"""Twelve numbers of one tick: references, counts, currents, disturbances of the three joints."""


@dataclass(frozen=True, slots=True)
class ServoSample:
    """Means over one stretch of the loop; `t_ns` is its middle.

    Means of all signals over the same ticks: what holds between them at every tick (that torque
    is inertia by acceleration and disturbance) holds between the means.
    """

    t_ns: int
    reference_rad: Three
    angle_rad: Three
    """By the encoders."""
    current_a: Three
    disturbance_a: Three


class Sampler:
    """Collects ticks into samples of `ticks` each."""

    def __init__(self, ticks: int, period_ns: int, rad_per_count: float):
        self.rows: list[Row] = []
        self._ticks, self._period_ns = ticks, period_ns
        self._rad_per_count = rad_per_count
        self._samples: list[ServoSample] = []

    def cut(self, last_ns: int) -> None:
        """The newest row is of `last_ns`: make samples of all that are full."""
        while len(self.rows) >= self._ticks:
            newest = len(self.rows) - self._ticks
            middle_ns = (
                last_ns - self._period_ns * newest - self._period_ns * (self._ticks - 1) // 2
            )
            self._samples.append(self._mean(self.rows[: self._ticks], middle_ns))
            del self.rows[: self._ticks]

    def drop(self) -> None:
        """Forget what makes no whole sample."""
        self.rows.clear()

    def take(self) -> list[ServoSample]:
        """Samples since the last call."""
        samples, self._samples = self._samples, []
        return samples

    def _mean(self, rows: list[Row], t_ns: int) -> ServoSample:
        means = [sum(column) / len(rows) for column in zip(*rows, strict=True)]
        angles = [self._rad_per_count * count for count in means[JOINTS : 2 * JOINTS]]
        return ServoSample(
            t_ns,
            (means[0], means[1], means[2]),
            (angles[0], angles[1], angles[2]),
            (means[6], means[7], means[8]),
            (means[9], means[10], means[11]),
        )
