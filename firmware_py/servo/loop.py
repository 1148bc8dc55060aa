"""The control loop: so many ticks of read, law, set, a block at a time.

A block is a millisecond, at whose end inputs, guard and controller have their look. On a virtual
clock the loop catches up in blocks; on a real one it would run in a real-time process, which the
simulated robot does not need. For the recording it leaves means over short stretches of its ticks.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, radians

from deltactl.drivers.current_drives import JOINTS, CurrentDrives, Three
from deltactl.firmware_py.servo.law import AccelerationControl, LawSettings
from deltactl.firmware_py.servo.setpoints import Setpoints
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.servo_drive import ServoDrive

AT_LIMIT = 0.999


class Guard:
    """Looks at every block of the loop; the first thing wrong is said, naming the joint."""

    def __init__(self, drive: ServoDrive):
        self._error_rad = radians(drive.following_error_deg)
        self._limit_a = AT_LIMIT * drive.current_limit_a
        self._overload_s = drive.overload_s
        self.reset()

    def reset(self) -> None:
        """Begin afresh."""
        self._limited_s = [0.0] * JOINTS

    def look(
        self, references_rad: Three, angles_rad: Three, currents_a: Three, block_s: float
    ) -> str:
        """What is wrong, in words; empty while nothing is."""
        for joint in range(JOINTS):
            behind_rad = references_rad[joint] - angles_rad[joint]
            if not abs(behind_rad) <= self._error_rad:  # also when it is NaN
                return (
                    f"following error of motor{joint + 1}: its arm is"
                    f" {abs(degrees(behind_rad)):.1f} degrees"
                    f" {'behind' if behind_rad > 0.0 else 'ahead of'} its reference; free the arm,"
                    " or slow the job down"
                )
            if abs(currents_a[joint]) < self._limit_a:
                self._limited_s[joint] = 0.0
                continue
            self._limited_s[joint] += block_s
            if self._limited_s[joint] > self._overload_s:
                return (
                    f"over-current of motor{joint + 1}: at its limit for more than"
                    f" {self._overload_s:g} s; free the arm, or slow the job down"
                )
        return ""


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


BLOCK_NS = 1_000_000


class ServoLoop:
    """Runs the law on three drives along set-points. Raises what the drives raise."""

    def __init__(self, drive: ServoDrive, drives: CurrentDrives, start_ns: int):
        self.drives = drives
        self._period_ns = NS_PER_S // drive.loop_rate_hz
        self.setpoints = Setpoints(drive.rad_per_step, self._period_ns)
        self.control = AccelerationControl(LawSettings.of(drive))
        self.due_ns = start_ns
        """When the next tick is due."""
        self._rad_per_count = drive.rad_per_count
        self._step_rad = drive.rad_per_step
        self._guard = Guard(drive)
        ticks = max(1, drive.loop_rate_hz // drive.record_rate_hz)
        self._sampler = Sampler(ticks, self._period_ns, drive.rad_per_count)

    def settle(self) -> None:
        """Take where the arms are for where they are asked to be, at rest.

        Set-points may be finer than the encoders: an arm within a count of its own stays there.
        """
        encoders, asked = self.drives.read_counts(), self.setpoints.counts
        ratio = self._rad_per_count / self._step_rad
        first, second, third = (
            count if abs(count - seen * ratio) <= ratio else round(seen * ratio)
            for count, seen in zip(asked, encoders, strict=True)
        )
        self.setpoints.restart((first, second, third), self.due_ns)
        self.control.reset(self.setpoints.references_now_rad(), encoders)
        self._guard.reset()
        self._sampler.drop()

    def idle(self, until_ns: int) -> None:
        """Let time pass for drives that give no current."""
        while self.due_ns <= until_ns:
            self.drives.set_currents_a(0.0, 0.0, 0.0)
            self.due_ns += self._period_ns

    def run(self, until_ns: int) -> str:
        """All ticks due up to a time; what the guard finds wrong, or nothing."""
        ticks = (until_ns - self.due_ns) // self._period_ns + 1
        if ticks <= 0:
            return ""
        references = self.setpoints.references_rad(self.due_ns, ticks)
        last_ns = self.due_ns + self._period_ns * (ticks - 1)
        self.due_ns = last_ns + self._period_ns
        first, second, third = self.control.joints
        one, two, three = first.tick, second.tick, third.tick
        read, give, note = self.drives.read_counts, self.drives.set_currents_a, self._sampler.rows
        for r1, r2, r3 in zip(*references, strict=True):
            c1, c2, c3 = read()
            i1, i2, i3 = one(r1, c1), two(r2, c2), three(r3, c3)
            give(i1, i2, i3)
            d1, d2, d3 = first.disturbance_a, second.disturbance_a, third.disturbance_a
            note.append((r1, r2, r3, c1, c2, c3, i1, i2, i3, d1, d2, d3))
        self._sampler.cut(last_ns)
        angles: Three = (
            c1 * self._rad_per_count,
            c2 * self._rad_per_count,
            c3 * self._rad_per_count,
        )
        return self._guard.look((r1, r2, r3), angles, (i1, i2, i3), ticks * self._period_ns * 1e-9)

    def take_samples(self) -> list[ServoSample]:
        """What happened since the last call, for the recording."""
        return self._sampler.take()
