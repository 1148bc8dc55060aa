"""The search for home switches: each arm in turn rises until its own closes, then all approach.

An arm moves a little and rests before its switch is read, so that a reading belongs to one
place. A reading that says something new is confirmed by `VOTES` more while the arm rests:
one false reading is outvoted, and a switch whose readings disagree too much is named.

Each arm finds its switch quickly, backs off, approaches slowly and backs off again; then all
three approach slowly together. Both slow approaches must end at the same step to
`homing.switch_tolerance_deg`. So home is off by one slow move at most (a quarter of that
tolerance, or a step where that is more), and by what the switch itself repeats to.

No arm rises further than where it may be asks for (`_furthest_up`). What the sensors see, and the
switches of the other arms, are looked at on the way.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from typing import NoReturn

import numpy as np

from deltactl.drivers.steps.contract import MOTORS, OutputState, Ticks
from deltactl.firmware_py.controller.sensing.determined import unseen_rad
from deltactl.firmware_py.controller.sensing.on_the_way import OnTheWay
from deltactl.firmware_py.machine import Machine
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S, sleep_s
from deltactl.foundation.errors import NotReady, PulseFault

MOVE_S = 0.02
"""So long an arm moves between two looks on the fast approach."""
BACK_OFF_RAD = 0.03
"""More than a switch needs to open again, and than play in a gear."""
SLOWER = 5
"""The slow approaches are this many times slower than the fast one."""
MARGIN_RAD = math.radians(5.0)
"""An arm that began below its switch is never moved further than this past its limits."""
VOTES, VOTE_S = 9, 0.002
"""Readings while an arm rests: longer than contacts bounce, shorter than a patient wait."""
STRAY = 1
"""So many votes may differ from the others."""
ROUNDS = 5
"""So often it is voted again before a switch counts as unsure."""


class Contact(enum.Enum):
    """Reading of a switch while its arm rests."""

    OPEN = "open"
    CLOSED = "closed"
    UNSURE = "unsure"


Push = Callable[[Ticks], None]


class SwitchSearch:
    """One search; every call blocks on the machine's clock."""

    def __init__(
        self, robot: RobotFile, machine: Machine, seen: OnTheWay, push: Push, highest: list[int]
    ):
        """`highest`: counts above which (smaller is higher) no arm goes unseen; filled in here,
        and kept by the caller until the drives are released, however often it is searched."""
        self._robot = robot
        self._machine = machine
        self._seen = seen
        self._push = push
        self._highest = highest
        step_rad = robot.drive.rad_per_step
        self._step_rad = step_rad
        self._speed_radps = robot.homing.speed_radps
        self._tolerance_rad = math.radians(robot.homing.switch_tolerance_deg)
        self._slow_steps = max(1, int(self._tolerance_rad / 4.0 / step_rad))
        self._fast_steps = max(1, round(self._speed_radps * MOVE_S / step_rad))
        back_off_steps = math.ceil(BACK_OFF_RAD / step_rad) + self._fast_steps
        self._back_off_steps = back_off_steps
        self._sight_rad = unseen_rad(robot, np.ones(MOTORS, dtype=np.bool_), robot.homing.warning_m)
        """How far an arm may be from home while the ranges are off by `homing.warning_m`."""
        self._again_steps = back_off_steps + self._fast_steps + 3 * self._tolerance_steps

    @property
    def _tolerance_steps(self) -> int:
        """Steps of the tolerance, or of two slow moves where steps are coarse."""
        return max(int(self._tolerance_rad / self._step_rad), 2 * self._slow_steps)

    def find(self) -> None:
        """Leave every arm at its switch. Raises NotReady, naming what is wrong, and PulseFault."""
        self._now = [self._contact(motor) for motor in range(MOTORS)]
        for motor, contact in enumerate(self._now):
            if contact is Contact.UNSURE:
                self._unsure(motor)
        first = [self._approach_alone(motor) for motor in range(MOTORS)]
        again = self._approach_together()
        for motor, (one, two) in enumerate(zip(first, again, strict=True)):
            if abs(one - two) > self._tolerance_steps:
                self._refuse(
                    f"arm {motor + 1} met its switch in two places,"
                    f" {math.degrees(abs(one - two) * self._step_rad):.2f} degrees apart"
                    f" (homing.switch_tolerance_deg: {self._robot.homing.switch_tolerance_deg:g}):"
                    " the switch is loose or worn, or its drive loses steps; fasten or replace"
                    " the switch, look whether the arm moves freely, and home again"
                )

    def confirm(self) -> None:
        """The arms are still at their switches. Raises NotReady."""
        for motor in range(MOTORS):
            if self._contact(motor) is Contact.OPEN:
                self._refuse(
                    f"the switch of arm {motor + 1} opened again while the arm should rest:"
                    " the arm sinks, or its drive loses steps; look at its drive and home again"
                )

    def _approach_alone(self, motor: int) -> int:
        """Count at which an arm meets its switch slowly; the arm is left below it."""
        angles_rad = self._seen.begin()
        seen_rad = None if angles_rad is None else float(angles_rad[motor])
        if self._now[motor] is Contact.CLOSED:
            self._leave(motor, seen_rad)
        self._rise(motor, seen_rad)
        self._back_off(motor, "after the arm has reached it")
        met = self._creep([motor])[motor]
        self._back_off(motor, "after the arm has reached it slowly")
        return met

    def _approach_together(self) -> list[int]:
        met = self._creep(list(range(MOTORS)))
        return [met[motor] for motor in range(MOTORS)]

    # What moves.

    def _leave(self, motor: int, seen_rad: float | None) -> None:
        """Sink until the switch is open: an arm that was left at its switch, or above it."""
        steps = self._back_off_steps
        if seen_rad is not None:
            above_rad = self._home_rad(motor) - seen_rad + self._sight_rad
            lowest_rad = math.radians(self._robot.limits.arm_deg[1]) - seen_rad
            steps += max(0, math.ceil(min(above_rad, lowest_rad) / self._step_rad))
        for _ in range(math.ceil(steps / self._fast_steps)):
            self._move([motor], +1, self._fast_steps, self._speed_radps)
            self._look_around(motor)
            if not self._closed(motor):
                break
        self._back_off(motor, "before the arm rises")

    def _back_off(self, motor: int, when: str) -> None:
        self._move([motor], +1, self._back_off_steps, self._speed_radps)
        self._look_around(motor)
        contact = self._contact(motor)
        if contact is Contact.UNSURE:
            self._unsure(motor)
        if contact is Contact.CLOSED:
            self._refuse(
                f"the switch of arm {motor + 1} is closed {when}, though the arm backed off by"
                f" {math.degrees(self._back_off_steps * self._step_rad):.1f} degrees: it is stuck"
                " closed, its wires touch, it is another arm's, or the arm is above it; check its"
                " wiring, and let the arms hang below their switches"
            )
        self._now[motor] = Contact.OPEN

    def _rise(self, motor: int, seen_rad: float | None) -> None:
        """Up to the switch, quickly."""
        highest = self._furthest_up(motor, seen_rad)
        start = self._count(motor)
        while self._count(motor) - self._fast_steps >= highest:
            self._move([motor], -1, self._fast_steps, self._speed_radps)
            self._look_around(motor)
            if self._closed(motor):
                return
        risen_rad = (start - self._count(motor)) * self._step_rad
        self._refuse(self._not_closed(motor, math.degrees(risen_rad), seen_rad is not None))

    def _creep(self, motors: list[int]) -> dict[int, int]:
        """Up to the switches of arms that have backed off; the count at which each closes."""
        met: dict[int, int] = {}
        unsure: set[int] = set()
        for _ in range(math.ceil(self._again_steps / self._slow_steps)):
            up = [motor for motor in motors if motor not in met]
            if not up:
                break
            self._move(up, -1, self._slow_steps, self._speed_radps / SLOWER)
            if len(motors) == 1:
                self._look_around(motors[0])
            self._look_at_arms(motors)
            for motor in up:
                if self._machine.home_switches[motor]():
                    contact = self._contact(motor)
                    if contact is Contact.CLOSED:
                        met[motor] = self._count(motor)
                    if contact is Contact.UNSURE:
                        unsure.add(motor)
        for motor in motors:
            if motor not in met and motor in unsure:
                self._unsure(motor)
            if motor not in met:
                self._refuse(
                    f"the switch of arm {motor + 1} closed once and did not close there again:"
                    " the switch is loose, its cable picks up the motors' pulses, or the drive"
                    " loses steps; check switch, shield and drive, and home again"
                )
        return met

    def _move(self, motors: list[int], sign: int, count: int, speed_radps: float) -> None:
        """Move arms at constant speed and wait until they are there."""
        period_ns = round(self._step_rad / speed_radps * NS_PER_S)
        start_ns = self._machine.clock.now_ns() + period_ns
        steps = np.zeros((count, MOTORS), dtype=np.int8)
        steps[:, motors] = sign
        ticks = Ticks(start_ns + period_ns * np.arange(count, dtype=np.int64), steps)
        self._push(ticks)
        wait_until_still(self._machine, count * period_ns / NS_PER_S)
        self._seen.sent(ticks)

    # How far.

    def _furthest_up(self, motor: int, seen_rad: float | None) -> int:
        """The count above which an arm does not rise.

        Seen by the sensors: to its home and what they may be wrong by, but not past
        `limits.arm_deg`. Unseen: by `homing.search_deg`; where the file does not say that, by
        the way from its switch to the lower limit, so that an arm that hangs anywhere below its
        switch stays within the limits; `MARGIN_RAD` more in both cases.
        """
        low_rad = math.radians(self._robot.limits.arm_deg[0])
        home_rad, now = self._home_rad(motor), self._count(motor)
        if seen_rad is not None:
            up_rad = min(
                seen_rad - home_rad + 3.0 * self._sight_rad, seen_rad - low_rad + MARGIN_RAD
            )
            return now - math.floor(max(0.0, up_rad) / self._step_rad)
        search_deg = self._robot.homing.search_deg
        up_rad = MARGIN_RAD + (
            max(0.0, home_rad - low_rad) if search_deg is None else math.radians(search_deg)
        )
        highest = now - math.floor(up_rad / self._step_rad)
        self._highest[motor] = max(highest, self._highest[motor])
        return self._highest[motor]

    def _home_rad(self, motor: int) -> float:
        return math.radians(self._robot.homing.angle_deg[motor])

    def _count(self, motor: int) -> int:
        return self._machine.output.status().counts[motor]

    # What is read.

    def _closed(self, motor: int) -> bool:
        """Whether the switch of an arm that rises or sinks quickly is closed, or may be."""
        return self._machine.home_switches[motor]() and self._contact(motor) is not Contact.OPEN

    def _contact(self, motor: int) -> Contact:
        """Reading by vote, while the arm rests."""
        pressed, clock = self._machine.home_switches[motor], self._machine.clock
        for _ in range(ROUNDS):
            closed = 0
            for _ in range(VOTES):
                sleep_s(clock, VOTE_S)
                closed += pressed()
            if closed <= STRAY:
                return Contact.OPEN
            if closed >= VOTES - STRAY:
                return Contact.CLOSED
        return Contact.UNSURE

    def _look_around(self, motor: int) -> None:
        """The switches of resting arms must not change, nor the ranges."""
        for other in range(MOTORS):
            if other == motor:
                continue
            was = self._now[other]
            if self._machine.home_switches[other]() == (was is Contact.CLOSED):
                continue
            contact = self._contact(other)
            if contact is Contact.UNSURE:
                self._unsure(other)
            if contact is not was:
                self._refuse(
                    f"the switch of arm {other + 1} became {contact.value} while only arm"
                    f" {motor + 1} moved: the wires of two switches (homing.switch_pins) or of two"
                    " motors are exchanged, or an arm sinks; check them in this order"
                )
        self._look_at_arms([motor])

    def _look_at_arms(self, motors: list[int]) -> None:
        """The arms that move must not be seen past their switches, nor off their steps."""
        angles_rad, says = self._seen.look()
        if says:
            self._refuse(
                f"while arm {' and '.join(str(one + 1) for one in motors)} moved, {says}; check"
                " motor, gear and sensors ('deltactl status sensors'), and home again"
            )
        if angles_rad is None:
            return
        for motor in motors:
            past_rad = self._home_rad(motor) - float(angles_rad[motor])
            if past_rad > self._sight_rad and self._now[motor] is Contact.OPEN:
                self._refuse(
                    f"the switch of arm {motor + 1} is open though the sensors see the arm"
                    f" {math.degrees(past_rad):.0f} degrees past it: it is stuck open, its wire is"
                    " broken, or the sensors are off by more than homing.warning_m; check the"
                    " wiring, homing.switch_pins and 'deltactl status sensors'"
                )

    def _not_closed(self, motor: int, risen_deg: float, seen: bool) -> str:
        where = "further than the sensors saw it hang" if seen else "as far as it may unseen"
        far = (
            ""
            if seen
            else ", or the arm hangs further below: 'deltactl power off', bring the arms nearer"
            " to their switches (homing.search_deg says how far they may hang), and home again"
        )
        return (
            f"the switch of arm {motor + 1} did not close within {risen_deg:.0f} degrees, {where}:"
            " it is stuck open, its wire is broken, or the arm does not move; check its wiring,"
            f" homing.switch_pins and the drive{far}"
        )

    def _unsure(self, motor: int) -> NoReturn:
        self._refuse(
            f"the switch of arm {motor + 1} flickers while nothing moves: its contact bounces or"
            " its cable picks up pulses; check the contact, the shield and the pull-up, or replace"
            " the switch"
        )

    def _refuse(self, why: str) -> NoReturn:
        raise NotReady(f"homing refused: {why}")


def wait_until_still(machine: Machine, expected_s: float) -> None:
    """Wait until the output has played its queue.

    Raises PulseFault when it stopped, or took twice as long as `expected_s` and a second.
    """
    deadline_ns = machine.clock.now_ns() + round((2.0 * expected_s + 1.0) * NS_PER_S)
    while True:
        seen = machine.output.status()
        if seen.state is OutputState.STOPPED:
            raise PulseFault(f"the step output stopped: {seen.reason}; see 'deltactl status'")
        if seen.state is OutputState.READY and seen.queued == 0:
            return
        if machine.clock.now_ns() > deadline_ns:
            raise PulseFault("the step output does not finish its queue; restart the daemon")
        sleep_s(machine.clock, 0.005)
