"""Three simulated current drives with their encoders, on a plant.

Every `set_currents_a` lets one control period of the plant pass, so whoever runs the loop runs
the simulated time. Currents flow at once and are cut at the limit; encoders round to whole counts.

Does not model: the current loop's own lag and ripple, winding temperature, encoder noise, or
the fieldbus.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite
from typing import Literal

from deltactl.drivers.current_drives import JOINTS, Counts, Plant, Three
from deltactl.foundation.errors import DriveAlarm

FaultKind = Literal["encoder_lost", "over_current"]

SAYS: dict[str, str] = {
    "encoder_lost": "the encoder signal of motor{joint} is lost; check its cable",
    "over_current": "the drive of motor{joint} has tripped: over-current; check its cable",
}


@dataclass(frozen=True, slots=True)
class PlannedFault:
    """A fault that comes by itself, `at_s` after the simulated drives were made, for a while."""

    kind: FaultKind
    joint: int
    at_s: float
    lasts_s: float = inf


class FakeCurrentDrives:
    """Implements `CurrentDrives`. `fail` and `mend` are the hands of a test."""

    def __init__(
        self,
        plant: Plant,
        *,
        period_s: float,
        rad_per_count: float,
        current_limit_a: float,
        brakes: bool = True,
        faults: tuple[PlannedFault, ...] = (),
    ):
        self.plant = plant
        self.enabled = False
        self._per_rad = 1.0 / rad_per_count
        self._limit_a = current_limit_a
        self._brakes = brakes
        self._in_hand = True
        self._offset = [0] * JOINTS
        self._present: dict[int, FaultKind] = {}
        """Faults whose cause is there, by joint."""
        self._tripped = ""
        self._plan = _plan(faults, period_s)
        self._periods = 0
        self._next = self._plan[-1][0] if self._plan else -1

    def fail(self, kind: FaultKind, joint: int) -> None:
        """Cut an encoder's cable, or short a winding, of a joint (1 to 3)."""
        self._present[joint] = kind
        self._tripped = self._tripped or SAYS[kind].format(joint=joint)

    def mend(self, joint: int) -> None:
        """Take the cause at a joint away; the trip stays until it is cleared."""
        self._present.pop(joint, None)

    def put(self, angles_rad: Three) -> None:
        """Hands put the arms at these angles and hold them until the drives do."""
        self.plant.place(angles_rad)
        self._in_hand = True

    def enable(self) -> None:
        self._refuse_if_tripped()
        self.enabled, self._in_hand = True, False

    def make_safe(self) -> None:
        self.enabled = False

    def read_counts(self) -> Counts:
        if self._tripped:
            raise DriveAlarm(self._tripped)
        first, second, third = self.plant.angles_rad()
        per_rad, offset = self._per_rad, self._offset
        return (
            round(first * per_rad) + offset[0],
            round(second * per_rad) + offset[1],
            round(third * per_rad) + offset[2],
        )

    def set_currents_a(self, first: float, second: float, third: float) -> None:
        """See CurrentDrives; one period passes."""
        if self._periods == self._next:
            self._go_by_plan()
        self._periods += 1
        if not self.enabled:
            if self._brakes or self._in_hand:
                self.plant.hold()
            else:
                self.plant.advance(0.0, 0.0, 0.0)
            return
        limit = self._limit_a
        if not (
            -limit <= first <= limit and -limit <= second <= limit and -limit <= third <= limit
        ):
            first, second, third = self._limited(first), self._limited(second), self._limited(third)
        self.plant.advance(first, second, third)
        if self._tripped:
            raise DriveAlarm(self._tripped)

    def set_counts(self, counts: Counts) -> None:
        true_rad = self.plant.angles_rad()
        self._offset = [
            count - round(angle * self._per_rad)
            for count, angle in zip(counts, true_rad, strict=True)
        ]

    def clear(self) -> None:
        self._tripped = "; ".join(
            SAYS[kind].format(joint=joint) for joint, kind in sorted(self._present.items())
        )
        self._refuse_if_tripped()

    def close(self) -> None:
        self.make_safe()

    def _limited(self, current_a: float) -> float:
        if not isfinite(current_a):
            raise ValueError(f"a current must be a number, got {current_a}")
        return max(-self._limit_a, min(self._limit_a, current_a))

    def _refuse_if_tripped(self) -> None:
        if self._tripped:
            raise DriveAlarm(self._tripped)

    def _go_by_plan(self) -> None:
        while self._plan and self._plan[-1][0] <= self._periods:
            _, joint, kind = self._plan.pop()
            if kind is None:
                self.mend(joint)
            else:
                self.fail(kind, joint)
        self._next = self._plan[-1][0] if self._plan else -1


def _plan(
    faults: tuple[PlannedFault, ...], period_s: float
) -> list[tuple[int, int, FaultKind | None]]:
    """What happens in which period at which joint (None: mended), the last first."""
    plan: list[tuple[int, int, FaultKind | None]] = []
    for fault in faults:
        plan.append((round(fault.at_s / period_s), fault.joint, fault.kind))
        if isfinite(fault.lasts_s):
            plan.append((round((fault.at_s + fault.lasts_s) / period_s), fault.joint, None))
    return sorted(plan, key=lambda event: event[0], reverse=True)
