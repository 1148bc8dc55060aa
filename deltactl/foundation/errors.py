"""The one exception tree. Every leaf is also a builtin, so callers need not know the tree.

DeltactlError
├── ConfigError (ValueError)            a file says something it may not
│   ├── MissingFile (FileNotFoundError)
│   └── ForbiddenPath (PermissionError)  outside the folder that may be read
├── MissingExtra (ImportError)          a package that the small install leaves out
├── MotionError                         a motion that must not be started or go on
│   ├── UnreachablePoint (ValueError)   outside the workspace, or singular
│   ├── LimitExceeded (ValueError)      an arm, box or step-rate limit
│   └── NotReady (RuntimeError)         unhomed, stopped, faulted
├── HardwareError (OSError)
│   ├── BusDead                         nobody answers on the I2C bus
│   ├── SensorFault                     one sensor is missing, stuck or lying
│   ├── DriveAlarm                      a stepper drive tripped
│   ├── EmergencyStop                   the e-stop chain is open
│   └── PulseFault                      the pulse player stopped by itself
├── NetworkError (ValueError)           a network file is broken or for another robot
├── RecordingError (ValueError)         a recording cannot be read or written
│   └── RefusedRecording                it does not fit the robot file
└── ServiceError (ConnectionError)      the daemon is absent or refuses

A message says what was wrong, where, and what to do. The command line prints it as
one line and exits with status 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self


class DeltactlError(Exception):
    """Root of all errors this program raises on purpose.

    typed: how the message ends, where that is what to type in a terminal; a page has buttons.
    """

    typed: str = ""

    def with_typed(self, typed: str) -> Self:
        """The same error, whose message ends in what to type."""
        error = self.worded(f"{self}{typed}")
        error.typed = typed
        return error

    def worded(self, text: str) -> Self:
        """The same error, with what it carries, in other words."""
        error = type(self)(text)
        error.__dict__.update(self.__dict__)
        return error


class ConfigError(DeltactlError, ValueError):
    """A configuration file says something it may not: wrong type, bound or key.

    With several arguments: all mistakes of a file, a line each.
    """

    def __str__(self) -> str:
        return "\n".join(str(mistake) for mistake in self.args)


class MissingFile(ConfigError, FileNotFoundError):
    """A named file does not exist or cannot be read."""


class ForbiddenPath(ConfigError, PermissionError):
    """A file lies outside the folder that somebody else may have read."""


class MissingExtra(DeltactlError, ImportError):
    """Something was asked for that needs a package which is not installed."""


ELSEWHERE = "move the path or make it smaller"
"""What to do about a point where the robot cannot be."""


@dataclass(frozen=True, slots=True)
class Refusal:
    """What is wrong with one point of a path, without saying which; a remedy that fits a path."""

    why: str
    remedy: str = ELSEWHERE
    on_the_way: bool = False
    """Between the point before and this one."""
    point: int | None = None
    """Its number in the path; None on the way back to its start, and where there is no path."""

    def says(self) -> str:
        """What is wrong, and what to do."""
        return f"{self.why}; {self.remedy}" if self.remedy else self.why


class MotionError(DeltactlError):
    """A motion that must not be started, or must not go on.

    `at_point`: where it is one point of a path, what is wrong there in itself, for those who name
    the point in their own way.
    """

    at_point: Refusal | None = None

    @classmethod
    def at(cls, where: str, refusal: Refusal) -> Self:
        """The error of a point that `where` names: 'heart: point 3 at ... m: '."""
        error = cls(where + refusal.says())
        error.at_point = refusal
        return error


class UnreachablePoint(MotionError, ValueError):
    """The linkage cannot be assembled at a point, or is singular there."""


class LimitExceeded(MotionError, ValueError):
    """A path breaks an arm-angle, box or step-rate limit."""


class NotReady(MotionError, RuntimeError):
    """The robot is in a state from which the request is refused."""


class HardwareError(DeltactlError, OSError):
    """Something outside the program does not do what it should."""


class BusDead(HardwareError):
    """No sensor answers on the I2C bus: wiring, power, or a stuck SDA line."""


class SensorFault(HardwareError):
    """One distance sensor is missing, has the wrong identity, or stopped measuring."""


class DriveAlarm(HardwareError):
    """A stepper drive raised its alarm line."""


class EmergencyStop(HardwareError):
    """The emergency stop was pressed or its wire is open."""


class PulseFault(HardwareError):
    """The pulse player stopped by itself: no heartbeat, lost process, full queue."""


class NetworkError(DeltactlError, ValueError):
    """A network file is broken, or was trained for another robot."""


class RecordingError(DeltactlError, ValueError):
    """A recording cannot be written or read."""


class RefusedRecording(RecordingError):
    """A recording does not fit the robot file; `refusal` has the parts (`diagnosis.admission`)."""

    refusal: Any = None


class ServiceError(DeltactlError, ConnectionError):
    """The daemon is absent, refuses the request, or answered nonsense."""
