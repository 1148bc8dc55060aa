"""Homing: which counts the home angles are.

`placed`: the operator has put the arms against their stops. `switch`: each arm in turn rises
until its switch closes, backs off, and approaches again slowly. Either way the sensors must
agree with the home angles before the robot counts as homed (home_check.py).
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from deltactl.drivers.steps.contract import MOTORS, OutputState, Ticks
from deltactl.firmware_py.controller.condition import Condition
from deltactl.firmware_py.controller.contract import HomeSeen
from deltactl.firmware_py.controller.jobs.feeder import LEAD_S
from deltactl.firmware_py.controller.observer import Observer
from deltactl.firmware_py.controller.sensing.home_check import BY_HAND, check_plausible
from deltactl.firmware_py.controller.sensing.ranging_loop import RangingLoop
from deltactl.firmware_py.controller.states import Request, State
from deltactl.firmware_py.machine import Machine
from deltactl.firmware_py.planner.approach import approach
from deltactl.firmware_py.planner.check import home_counts
from deltactl.firmware_py.planner.step_gate import StepGate
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S, ns, sleep_s
from deltactl.foundation.errors import DeltactlError, NotReady, PulseFault
from deltactl.models.robot import AXES, FloatArray

LOOK_S = 0.4
"""How long the sensors are listened to: some 20 rounds at 50 Hz."""
LEAST_READINGS, LEAST_LOOKS = 5, 8
"""A sensor that refuses most of its samples is not believed for the rest."""
MARGIN_S = 0.02
ENDS_S = 2.0
"""Longer than a homing takes to see that it was stopped."""
BACK_OFF_RAD = 0.03
SLOWER = 5
"""The second approach to a switch is this many times slower than the first."""
WIDEST_SEARCH_RAD = 2.5
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
        push: Callable[[Ticks], None],
    ):
        """`push` hands ticks on, and refuses them once the homing was interrupted."""
        self._robot = robot
        self._machine = machine
        self._ranging = ranging
        self._push = push

    def home(self, already_homed: bool = False, accept_unseen_deg: float = 0.0) -> HomeSeen:
        """Bring the arms home and look; one that is homed already drives to its home angles first.

        Returns what the sensors said. Raises NotReady, or PulseFault when the output stopped.
        """
        if already_homed:
            self._go_home()
        elif self._robot.homing.method == "placed":
            self._place_simulated()
        if self._robot.homing.method == "switch":
            for motor in range(MOTORS):
                self._seek_switch(motor)
        simulated = self._machine.simulated
        then = BUILT_OTHERWISE if simulated else BY_HAND
        heard_m = self._listen()
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

    def _listen(self) -> FloatArray:
        """Median of the good readings of each axis taken from now on [m]; NaN for too few."""
        clock, period_s = self._machine.clock, 1.0 / self._robot.ranging.rate_hz
        since_ns = clock.now_ns()
        heard: dict[str, dict[int, float]] = {axis: {} for axis in AXES}
        until_ns = since_ns + ns(max(LOOK_S, LEAST_LOOKS * period_s))
        while clock.now_ns() < until_ns:
            sleep_s(clock, period_s)
            for reading in self._ranging.good_readings(since_ns):
                heard[reading.axis][reading.t_ns] = reading.distance_m
        enough = [list(one.values()) for one in heard.values()]
        return np.array(
            [np.median(one) if len(one) >= LEAST_READINGS else np.nan for one in enough]
        )

    def _seek_switch(self, motor: int) -> None:
        """Rise to the switch, back off, rise again slowly. It must be open where it should be."""
        pressed, speed = self._machine.home_switches[motor], self._robot.homing.speed_radps
        if pressed():  # an arm that was left at its switch
            self._walk(motor, +1, BACK_OFF_RAD, speed)
            self._must_be_open(motor, "before the arm rises")
        self._rise(motor, speed)
        self._walk(motor, +1, BACK_OFF_RAD, speed)
        self._must_be_open(motor, "after the arm has reached it")
        self._rise(motor, speed / SLOWER)

    def _must_be_open(self, motor: int, when: str) -> None:
        if self._machine.home_switches[motor]():
            raise NotReady(
                f"homing refused: the switch of arm {motor + 1} is closed {when} and has backed off"
                f" by {np.rad2deg(BACK_OFF_RAD):.1f} degrees: it is stuck closed, its wires touch,"
                " or the arm stands above it; let the arms hang below their switches"
            )

    def _rise(self, motor: int, speed_radps: float) -> None:
        pressed = self._machine.home_switches[motor]
        chunk_rad = speed_radps * MARGIN_S
        for _ in range(round(WIDEST_SEARCH_RAD / chunk_rad)):
            if pressed():
                return
            self._walk(motor, -1, chunk_rad, speed_radps)
        raise NotReady(
            f"homing refused: the switch of arm {motor + 1} did not close within"
            f" {np.rad2deg(WIDEST_SEARCH_RAD):.0f} degrees: it is stuck open, or its wire is"
            " broken; check its wiring and homing.switch_pins"
        )

    def _walk(self, motor: int, sign: int, angle_rad: float, speed_radps: float) -> None:
        """Move one arm at constant speed and wait until it is there."""
        per_step = self._robot.drive.rad_per_step
        count = max(1, round(angle_rad / per_step))
        period_ns = round(per_step / speed_radps * NS_PER_S)
        start_ns = self._machine.clock.now_ns() + period_ns
        steps = np.zeros((count, MOTORS), dtype=np.int8)
        steps[:, motor] = sign
        self._push(Ticks(start_ns + period_ns * np.arange(count, dtype=np.int64), steps))
        wait_until_still(self._machine, count * period_ns / NS_PER_S)


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


class Homing:
    """The request to home: one at a time, and none that outlives a stop."""

    def __init__(
        self, machine: Machine, ranging: RangingLoop, condition: Condition, observer: Observer
    ):
        self._machine = machine
        self._ranging = ranging
        self._condition = condition
        self._observer = observer
        self._busy = False

    def wait_for_end(self) -> None:
        """Return once no homing is under way; one that was stopped ends within a few looks."""
        give_up_s = time.monotonic() + ENDS_S
        while self._busy and time.monotonic() < give_up_s:
            time.sleep(MARGIN_S)

    def home(self, believed: Callable[[], RobotFile], accept_unseen_deg: float) -> HomeSeen:
        """UNHOMED or READY -> READY, blocking.

        believed: the robot file that is in force, asked for once homing is known to be allowed.
        Raises NotReady when a stop or another request came meanwhile, and what `Homer` raises.
        """
        condition = self._condition
        with condition.lock:
            condition.require(Request.HOME)
            if self._busy:
                raise NotReady("cannot home: the robot is homing already; wait, or stop it")
            robot = believed()
            was_ready, turn = condition.state is State.READY, condition.turns
            self._busy = True
            condition.enter(State.UNHOMED, "homing")

        def push(ticks: Ticks) -> None:
            with condition.lock:
                condition.same(turn, "home")
                self._machine.output.push(ticks)

        try:
            homer = Homer(robot, self._machine, self._ranging, push)
            seen = homer.home(was_ready, accept_unseen_deg)
            with condition.lock:
                condition.same(turn, "home")
                self._machine.output.set_counts(home_counts(robot))
                self._observer.restart(self._machine.clock.now_ns())
                condition.enter(State.READY)
        except DeltactlError:
            with condition.lock:
                condition.same(turn, "home")  # the stop is the reason, not what it led to
            raise
        finally:
            with condition.lock:
                self._busy = False
                if condition.state is State.UNHOMED:
                    condition.enter(State.UNHOMED)
        condition.note("home", seen.says())
        return seen
