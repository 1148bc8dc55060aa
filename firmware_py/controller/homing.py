"""Homing: which counts the home angles are, and whether the sensors believe it.

`placed`: the operator has put the arms against their stops. `switch`: each arm in turn rises
until its switch closes, backs off, and approaches again slowly. Either way the sensors must
agree with the home angles before the robot counts as homed.
"""

from __future__ import annotations

import numpy as np

from drivers.steps.contract import MOTORS, OutputState, Ticks
from firmware_py.controller.feeder import LEAD_S
from firmware_py.controller.ranging_loop import RangingLoop
from firmware_py.machine import Machine
from firmware_py.planner.approach import approach
from firmware_py.planner.check import home_counts
from firmware_py.planner.step_gate import StepGate
from firmware_py.robot_file import RobotFile
from foundation.clock import NS_PER_S, ns, sleep_s
from foundation.errors import NotReady, PulseFault
from models.chain import Chain, Commands
from models.robot import AXES, FloatArray


def expected_ranges_m(robot: RobotFile) -> FloatArray | None:
    """What the sensors should say at the home angles; None when the robot has no sensors.

    Raises NotReady when the linkage cannot be assembled there.
    """
    if robot.sensors is None:
        return None
    home = Commands.of_angles(np.zeros(1), np.deg2rad([robot.homing.angle_deg]))
    ranges_m: FloatArray = Chain(robot).simulate(home).ranges[0]
    if not np.all(np.isfinite(ranges_m)):
        raise NotReady(
            "homing refused: the linkage cannot be assembled at homing.angle_deg"
            f" {robot.homing.angle_deg}; correct the robot file"
        )
    return ranges_m


def check_plausible(robot: RobotFile, measured_m: FloatArray) -> str:
    """Compare good readings (NaN = none) with the home pose; returns what was seen, in words.

    Raises NotReady when a sensor disagrees by more than `homing.tolerance_m`, or when fewer
    than two sensors have a good reading.
    """
    expected_m = expected_ranges_m(robot)
    if expected_m is None:
        return "no sensors in the robot file: home angles taken on trust"
    good = np.isfinite(measured_m)
    if good.sum() < 2:
        missing = ", ".join(axis for axis, ok in zip(AXES, good, strict=True) if not ok)
        raise NotReady(
            f"homing refused: no good reading from sensor {missing}; see 'deltactl sensors'"
        )
    error_m = np.where(good, measured_m - expected_m, 0.0)
    worst = int(np.argmax(np.abs(error_m)))
    if abs(error_m[worst]) > robot.homing.tolerance_m:
        raise NotReady(
            f"homing refused: sensor {AXES[worst]} reads {measured_m[worst]:.3f} m but"
            f" {expected_m[worst]:.3f} m is expected with the arms at"
            f" {robot.homing.angle_deg} degrees; put the arms against their stops and try again"
        )
    return f"sensors agree with the home angles to {abs(error_m[worst]) * 1e3:.1f} mm"


LOOK_S = 0.4
"""How long the sensors are listened to: some 20 rounds at 50 Hz."""
MARGIN_S = 0.02
BACK_OFF_RAD = 0.03
SLOWER = 5
"""The second approach to a switch is this many times slower than the first."""
WIDEST_SEARCH_RAD = 2.5


class Homer:
    """Finds home and checks it; every call blocks on the machine's clock."""

    def __init__(self, robot: RobotFile, machine: Machine, ranging: RangingLoop):
        self._robot = robot
        self._machine = machine
        self._ranging = ranging

    def home(self, already_homed: bool = False) -> str:
        """Home the robot; one that is homed already is brought back to its home angles first.

        Returns what the sensors said. Raises NotReady, or PulseFault when the output stopped.
        """
        if self._robot.homing.method == "switch":
            for motor in range(MOTORS):
                self._seek_switch(motor)
        elif already_homed:
            self._go_home()
        try:
            seen = check_plausible(self._robot, self._listen())
        except NotReady as error:
            if not self._machine.simulated:
                raise
            # There are no hands at the simulated robot: it drops to its stops when released.
            raise NotReady(f"{error} (simulated: 'deltactl off', then 'deltactl on')") from error
        self._machine.output.set_counts(home_counts(self._robot))
        return seen

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
            output.push(ticks)
        wait_until_still(self._machine, schedule.duration_ns / NS_PER_S)

    def _listen(self) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """Median of the good readings of each axis over `LOOK_S` [m]."""
        clock = self._machine.clock
        since_ns = clock.now_ns()
        rounds = []
        while clock.now_ns() < since_ns + round(LOOK_S * NS_PER_S):
            sleep_s(clock, 1.0 / self._robot.ranging.rate_hz)
            rounds.append(self._ranging.good_ranges_m(since_ns))
        seen = np.array(rounds)
        heard = np.isfinite(seen).any(axis=0)
        median = np.full(seen.shape[1], np.nan)
        median[heard] = np.nanmedian(seen[:, heard], axis=0)
        return median

    def _seek_switch(self, motor: int) -> None:
        """Rise to the switch, back off, rise again slowly."""
        speed = self._robot.homing.speed_radps
        self._rise(motor, speed)
        self._walk(motor, +1, BACK_OFF_RAD, speed)
        self._rise(motor, speed / SLOWER)

    def _rise(self, motor: int, speed_radps: float) -> None:
        pressed = self._machine.home_switches[motor]
        chunk_rad = speed_radps * MARGIN_S
        for _ in range(round(WIDEST_SEARCH_RAD / chunk_rad)):
            if pressed():
                return
            self._walk(motor, -1, chunk_rad, speed_radps)
        raise NotReady(
            f"homing refused: the switch of arm {motor + 1} did not close within"
            f" {np.rad2deg(WIDEST_SEARCH_RAD):.0f} degrees; check its wiring and homing.switch_pins"
        )

    def _walk(self, motor: int, sign: int, angle_rad: float, speed_radps: float) -> None:
        """Move one arm at constant speed and wait until it is there."""
        per_step = self._robot.drive.rad_per_step
        count = max(1, round(angle_rad / per_step))
        period_ns = round(per_step / speed_radps * NS_PER_S)
        start_ns = self._machine.clock.now_ns() + period_ns
        steps = np.zeros((count, MOTORS), dtype=np.int8)
        steps[:, motor] = sign
        output = self._machine.output
        output.push(Ticks(start_ns + period_ns * np.arange(count, dtype=np.int64), steps))
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
