"""The control loop: so many ticks of read, law, set, a block at a time.

A block is a millisecond, at whose end inputs, guard and controller have their look. On a virtual
clock the loop catches up in blocks; on a real one it would run in a real-time process, which the
simulated robot does not need.
"""

from __future__ import annotations

from deltactl.drivers.current_drives import CurrentDrives, Three
from deltactl.firmware_py.servo.guard import Guard
from deltactl.firmware_py.servo.law import AccelerationControl, LawSettings
from deltactl.firmware_py.servo.samples import Sampler, ServoSample
from deltactl.firmware_py.servo.setpoints import Setpoints
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.servo_drive import ServoDrive

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
