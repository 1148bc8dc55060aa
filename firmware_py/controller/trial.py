"""A robot file that is in force for a while: as long as the client that tries it is there.

When that client goes, however it ends, the file from before is in force again, and the robot has
to be homed by it. Meanwhile nobody else starts a job; a `home` of anybody else ends the trial.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from deltactl.firmware_py.controller.claim import Claim, Owner
from deltactl.firmware_py.controller.condition import Condition
from deltactl.firmware_py.controller.file_in_force import FileInForce
from deltactl.firmware_py.controller.states import Happening
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import NotReady
from deltactl.models.calibrated_inverse import CalibratedInverse


class Accepted(NamedTuple):
    """A robot file as the controller works with it."""

    robot: RobotFile
    file: FileInForce
    inverse: CalibratedInverse


class Trial:
    """At most one at a time. Every call comes with the controller's lock held."""

    def __init__(self, condition: Condition, accept: Callable[[Accepted], None]):
        """accept: puts a file into force."""
        self._condition, self._accept = condition, accept
        self._before: Accepted | None = None
        self._owner: Owner | None = None
        self._over = False

    def taken(self, before: Accepted, claim: Claim, on_trial: bool) -> None:
        """Whoever homes has taken a file: for good, or until the one before comes back."""
        self._before = (self._before or before) if on_trial else None
        self._owner, self._over = claim.owner, False

    def end_unless_of(self, claim: Claim) -> None:
        """Somebody homes without naming a file: by the one from before, if the trial is not his."""
        if self._before is not None and claim.owner is not self._owner:
            self._give_back(self._before)

    def must_be_of(self, claim: Claim) -> None:
        """Raise NotReady for a job of anybody else."""
        if self._before is not None and claim.owner is not self._owner:
            raise NotReady(
                "cannot run: another client tries a robot file; wait until it has ended, or"
                f" 'deltactl home' to go back to {self._before.file.path.name}"
            )

    def leave(self, owner: Owner) -> None:
        """A client has gone."""
        if self._before is not None and owner is self._owner:
            self._over = True
            self.settle()

    def settle(self) -> None:
        """Give the file from before back once nothing moves, where the trial is over."""
        rule = self._condition.rule(Happening.TRIED)
        if self._over and self._before is not None and rule is not None:
            before = self._before
            self._give_back(before)
            self._condition.turns += 1
            latched = self._condition.why
            self._condition.go(Happening.TRIED, why=latched)

    def _give_back(self, before: Accepted) -> None:
        self._before, self._owner, self._over = None, None, False
        self._accept(before)
