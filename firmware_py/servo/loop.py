"""The control loop: so many ticks of read, law, set, a block at a time.

A block is a millisecond, at whose end inputs, guard and controller have their look. On a virtual
clock the loop catches up in blocks; on a real one it would run in a real-time process, which the
simulated robot does not need. For the recording it leaves means over short stretches of its ticks.

Set-points that were asked for are a smooth reference of the arms. A tick says that an arm's angle
passes half a count at that instant (see planner/timing_accelerated.py), so the angle is known
exactly then; in between it is taken as straight. Nothing is invented ahead of the newest set-point:
there the reference rests.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, radians

import numpy as np

from deltactl.drivers.current_drives import JOINTS, CurrentDrives, Three
from deltactl.drivers.steps.contract import NO_TICKS, Counts, Ticks
from deltactl.firmware_py.servo.law import AccelerationControl, LawSettings
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.robot import FloatArray
from deltactl.models.servo_drive import ServoDrive

AHEAD = 100
"""References are worked out for so many ticks at once: an array costs little more than a number."""


class Setpoints:
    """A queue of ticks; `references_rad` walks along it."""

    def __init__(self, rad_per_step: float, period_ns: int):
        self._step_rad = rad_per_step
        self._period_ns = period_ns
        self._sent: list[Ticks] = []
        self.restart((0, 0, 0), 0)

    def restart(self, counts: Counts, now_ns: int) -> None:
        """Forget what is queued: the arms are asked to be where the counts say."""
        self.counts = counts
        self._ticks = NO_TICKS
        self._after = np.empty((0, JOINTS), dtype=np.int64)
        self._passed = 0
        self._known = [(np.array([float(now_ns)]), np.array([float(count)])) for count in counts]
        self._ready: list[list[float]] = [[], [], []]
        self._ready_ns = now_ns

    def __len__(self) -> int:
        return len(self._ticks) - self._passed

    def push(self, ticks: Ticks, now_ns: int) -> None:
        """Queue ticks, all due after `now_ns`."""
        last = self._after[-1] if len(self._after) else np.array(self.counts)
        after = last + np.cumsum(ticks.steps, axis=0, dtype=np.int64)
        for motor in range(JOINTS):
            stepped = ticks.steps[:, motor] != 0
            half = after[stepped, motor] - 0.5 * ticks.steps[stepped, motor]
            times, places = self._known[motor]
            if times[-1] < now_ns:  # it stood still since
                times, places = np.append(times[-1:], now_ns), places[[-1, -1]]
            self._known[motor] = (
                np.concatenate([times, ticks.due_ns[stepped]]),
                np.concatenate([places, half]),
            )
        passed, self._passed = self._passed, 0
        self._ticks = Ticks.joined([self._ticks.part(slice(passed, None)), ticks])
        self._after = np.concatenate([self._after[passed:], after])
        self._ready = [[], [], []]

    def references_rad(self, start_ns: int, ticks: int) -> list[list[float]]:
        """The arms' references at so many ticks of the loop: three lists.

        Calls go forwards in time; what is due by the last tick counts as passed.
        """
        self._pass(start_ns + self._period_ns * (ticks - 1))
        if self._ready_ns != start_ns or len(self._ready[0]) < ticks:
            self._make_ready(start_ns, max(ticks, AHEAD))
        found = [ready[:ticks] for ready in self._ready]
        self._ready = [ready[ticks:] for ready in self._ready]
        self._ready_ns = start_ns + self._period_ns * ticks
        return found

    def take_sent(self) -> Ticks:
        """Ticks that were passed since the last call, without those that ask for no step."""
        sent, self._sent = Ticks.joined(self._sent), []
        return sent.part((sent.steps != 0).any(axis=1))

    def references_now_rad(self) -> Three:
        """Where the counts put the arms."""
        first, second, third = self.counts
        return first * self._step_rad, second * self._step_rad, third * self._step_rad

    def _make_ready(self, start_ns: int, ticks: int) -> None:
        times_ns: FloatArray = start_ns + self._period_ns * np.arange(ticks, dtype=np.float64)
        self._ready = []
        for motor, (times, places) in enumerate(self._known):
            if len(times) == 1:
                self._ready.append([float(places[0]) * self._step_rad] * ticks)
                continue
            angles = np.interp(times_ns, times, places) * self._step_rad
            self._ready.append(angles.tolist())
            keep = int(np.searchsorted(times, start_ns, side="right")) - 1
            if keep > 0:
                self._known[motor] = (times[keep:], places[keep:])

    def _pass(self, until_ns: int) -> None:
        due_ns, before = self._ticks.due_ns, self._passed
        if before == len(due_ns) or due_ns[before] > until_ns:
            return
        self._passed = int(np.searchsorted(due_ns, until_ns, side="right"))
        first, second, third = self._after[self._passed - 1].tolist()
        self.counts = (first, second, third)
        self._sent.append(self._ticks.part(slice(before, self._passed)))


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
