"""What makes a servo robot stop by itself: an arm that does not follow, or a drive at its limit."""

from __future__ import annotations

from math import degrees, radians

from deltactl.drivers.current_drives import JOINTS, Three
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
