"""Homing: which counts the home angles are.

`placed`: the operator has put the arms against their stops. `switch`: each arm in turn rises
until its switch closes, and approaches it again (switch_search.py). Either way the sensors must
agree with the home angles before the robot counts as homed (home_check.py).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from deltactl.drivers.steps.contract import MOTORS, Ticks
from deltactl.firmware_py.controller.claim import Claim, Owner
from deltactl.firmware_py.controller.condition import Condition
from deltactl.firmware_py.controller.contract import HomeSeen
from deltactl.firmware_py.controller.jobs.feeder import LEAD_S
from deltactl.firmware_py.controller.observer import Observer
from deltactl.firmware_py.controller.sensing.home_check import BY_HAND, check_plausible
from deltactl.firmware_py.controller.sensing.on_the_way import OnTheWay, listen
from deltactl.firmware_py.controller.sensing.ranging_loop import RangingLoop
from deltactl.firmware_py.controller.states import (
    LAST_OF_HOMING_S,
    Happening,
    Request,
    State,
)
from deltactl.firmware_py.controller.switch_search import Push, SwitchSearch, wait_until_still
from deltactl.firmware_py.machine import Machine
from deltactl.firmware_py.planner.approach import approach
from deltactl.firmware_py.planner.motion import StepGate
from deltactl.firmware_py.planner.plan import home_counts
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S, ns, sleep_s
from deltactl.foundation.errors import DeltactlError, NotReady
from deltactl.models.robot import AXES

ENDS_S = 2.0
"""Longer than a homing takes to see that it was stopped."""
LOOK_AGAIN_S = 0.02
NOWHERE = -(10**9)
"""A count that no arm rises to."""
BUILT_OTHERWISE = (
    "the simulated arms are against their stops, so the robot is simulated otherwise than its file"
    " describes it: look at as_built"
)


class Homer:
    """Finds home and checks it; every call blocks on the machine's clock."""

    def __init__(
        self,
        robot: RobotFile,
        machine: Machine,
        ranging: RangingLoop,
        push: Push,
        highest: list[int],
    ):
        """`push` hands ticks on, and refuses them once the homing was interrupted.

        highest: see `SwitchSearch`.
        """
        self._robot = robot
        self._machine = machine
        self._ranging = ranging
        self._push = push
        self._highest = highest
        self.heard_m = np.full(len(AXES), np.nan)
        """What each sensor said at home [m]; NaN where it said too little."""

    def home(self, already_homed: bool = False, accept_unseen_deg: float = 0.0) -> HomeSeen:
        """Bring the arms home and look; one that is homed already drives to its home angles first.

        Returns what the sensors said. Raises NotReady, or PulseFault when the output stopped.
        """
        if already_homed:
            self._go_home()
        elif self._robot.homing.method == "placed":
            self._place_simulated()
        clock, search = self._machine.clock, None
        if self._robot.homing.method == "switch":
            seen = OnTheWay(self._robot, self._ranging, clock)
            search = SwitchSearch(self._robot, self._machine, seen, self._push, self._highest)
            search.find()
        simulated = self._machine.simulated
        then = BUILT_OTHERWISE if simulated else BY_HAND
        heard_m = self.heard_m = listen(self._robot, self._ranging, clock)
        if search is not None:
            search.confirm()
        return check_plausible(self._robot, heard_m, accept_unseen_deg, then, simulated)

    def _place_simulated(self) -> None:
        """Release the drives and put the arms against their stops, which a person does on a robot.

        Otherwise the simulated robot would count as homed wherever a stop has left it.
        """
        world, output, clock = self._machine.world, self._machine.output, self._machine.clock
        if world is None or world.rests(clock.now_ns()):
            return
        output.disable()
        world.put_to_stops(clock.now_ns())
        output.enable()

    def _go_home(self) -> None:
        """Bring a homed robot back to its home angles, and wait."""
        output, clock = self._machine.output, self._machine.clock
        step_rad = self._robot.drive.rad_per_step
        goal_rad = np.deg2rad(self._robot.homing.angle_deg)
        schedule = approach(self._robot, np.array(output.status().counts) * step_rad, goal_rad)
        start_ns = clock.now_ns() + ns(LEAD_S)
        gate = StepGate()
        gate.rules(*schedule.gate_ns)
        for ticks in schedule.play(0, len(schedule.reached_ns) - 1, start_ns, gate):
            while output.room() < len(ticks):
                sleep_s(clock, LEAD_S)
            self._push(ticks)
        wait_until_still(self._machine, schedule.duration_ns / NS_PER_S)


class Homing:
    """The request to home: one at a time, and none that outlives a stop."""

    def __init__(
        self, machine: Machine, ranging: RangingLoop, condition: Condition, observer: Observer
    ):
        self._machine = machine
        self._ranging = ranging
        self._condition = condition
        self._observer = observer
        self._claim: Claim | None = None
        """Claim of the homing in progress."""
        self._highest = [NOWHERE] * MOTORS

    def released(self) -> None:
        """The drives let the arms go: where they have risen to says nothing any more."""
        self._highest = [NOWHERE] * MOTORS

    def call_off(self, why: str, owner: Owner | None = None) -> bool:
        """Push nothing more; with an owner, only where the homing is theirs. Whether it was.

        Comes with the controller's lock held.
        """
        claim = self._claim
        if claim is None or (owner is not None and claim.owner is not owner):
            return False
        claim.call_off(why)
        return True

    def wait_for_end(self) -> None:
        """Return once no homing is under way; one that was stopped ends within a few looks."""
        give_up_s = time.monotonic() + ENDS_S
        while self._claim is not None and time.monotonic() < give_up_s:
            time.sleep(LOOK_AGAIN_S)

    def home(
        self, accepted: Callable[[], RobotFile], accept_unseen_deg: float, claim: Claim
    ) -> HomeSeen:
        """UNHOMED or READY -> READY, blocking.

        accepted: the robot file that is in force, asked for once homing is known to be allowed.
        Raises NotReady when a stop or another request came meanwhile, and what `Homer` raises.
        """
        condition = self._condition
        with condition.lock:
            condition.require(Request.HOME)
            claim.must_hold("home")
            if self._claim is not None:
                raise NotReady("cannot home: another homing is about to end; ask again")
            robot = accepted()
            was_ready, turn = condition.state is State.READY, condition.turns
            self._claim = claim
            condition.go(Request.HOME)

        def still_wanted() -> None:
            claim.must_hold("home")
            condition.same(turn, "home")

        def push(ticks: Ticks) -> None:
            for piece in self._in_time(ticks):
                with condition.lock:
                    still_wanted()
                    self._machine.output.push(piece)

        try:
            homer = Homer(robot, self._machine, self._ranging, push, self._highest)
            seen = homer.home(was_ready, accept_unseen_deg)
            with condition.lock:
                still_wanted()
                self._machine.output.set_counts(home_counts(robot))
                self.released()
                self._observer.homed(self._machine.clock.now_ns(), homer.heard_m)
                condition.go(Happening.HOMED)
        except DeltactlError:
            with condition.lock:
                still_wanted()  # the stop is the reason, not what it led to
            raise
        finally:
            with condition.lock:
                self._claim = None
                if condition.state is State.OFF:  # it came while drives were energised again
                    self._machine.output.disable()
                if condition.state is State.HOMING:
                    condition.go(Happening.NOT_HOMED)
        condition.note("home", seen.says())
        return seen

    def _in_time(self, ticks: Ticks) -> Iterator[Ticks]:
        """Pieces of a motion, each when it is due soon: what is pushed is not called back."""
        ahead_ns, clock = ns(LAST_OF_HOMING_S), self._machine.clock
        first = 0
        while first < len(ticks):
            last = int(np.searchsorted(ticks.due_ns, ticks.due_ns[first] + ahead_ns // 2, "right"))
            clock.sleep_until_ns(int(ticks.due_ns[last - 1]) - ahead_ns)
            yield Ticks(ticks.due_ns[first:last], ticks.steps[first:last])
            first = last
