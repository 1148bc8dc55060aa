"""The MuJoCo robot moved from rest to rest, without the seconds in between.

A survey of 20 000 poses takes this robot four days; step by step in time that is many hours here.
Only the end of a move is read, at rest. So the arms are carried through the move at a few poses
by the balance of forces on each of them, and what friction and play keep is kept:

- MuJoCo puts the linkage together at the arms' angles and says what gravity asks of each arm;
- the flanks of a gear push back with its stiffness, beyond its play;
- an arm moves only when both together beat its friction, and then no further than needed.

Left out: speed, and so inertia, drag and ringing. `tests/reproduction` compares it with the same
robot simulated in time.

The limit of every model that trusts its sensors is found with it. A model that learns counts from
measured positions can at best learn the exact inverse of the expected measured map: noise averaged
away, friction at the middle of its band, but offsets, scale and cross talk of the sensors copied.
What is left of its tracking error is the limit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from deltactl.foundation.errors import UnreachablePoint
from deltactl.models.robot import Sensors
from deltactl.models.training.dataset import IntArray
from deltactl.proof.ranging import ideal_ranges
from deltactl.proof.recorded import Machine
from deltactl.proof.robot.as_built import AsBuilt, FloatArray
from deltactl.proof.robot.bodies import Assembly, build
from deltactl.proof.robot.run import TIMESTEP_S, Truth, asked_angles

LOOP_ROWS = 18
"""Three for each of the six rods' ends; MuJoCo puts equality constraints first."""
STRIDES_STEPS = (600, 150, 40)
"""Poses along a move are at most this far apart: 13.5 degrees, or less where that goes wrong."""
CLOSED_M = 1e-9
ROUNDS = 40
STEEPEST_M_PER_RAD = 1.2
"""Where the platform moves faster than this for an arm's turn (0.2 to 0.6 m/rad in the middle of
the workspace) the linkage is about to fold: a real robot jams there."""


class SettlingRobot:
    """A robot at rest. Raises UnreachablePoint where it cannot be put together or jams."""

    def __init__(self, robot: AsBuilt, counts: IntArray):
        self.joints = robot.joints
        self.model = build(robot.body, robot.joints, TIMESTEP_S)
        self.data = mujoco.MjData(self.model)
        self._assembly = Assembly(self.model)
        self._arm_q = self._assembly.arms_q
        self._arm_v = [int(self.model.joint(f"arm_{arm}").dofadr[0]) for arm in (1, 2, 3)]
        self._free = self._assembly.free
        self._platform_q = int(self.model.joint("platform").qposadr[0])
        self._platform_v = int(self.model.joint("platform").dofadr[0])
        self.counts = np.array(counts, dtype=np.float64)
        asked = self._asked(self.counts[None])[0]
        self.data.qpos[:] = self._assembly.at(asked)
        self.arm_rad = asked
        self._side = 0.0
        self._torque_nm = self._close(asked)
        self._rest(asked)

    @property
    def position_m(self) -> FloatArray:
        """Where the platform is, shape (3,)."""
        start = self._platform_q
        return np.array(self.data.qpos[start : start + 3])

    def state(self) -> list[float]:
        """What `restore` needs to go on exactly from here."""
        return [
            *self.counts.tolist(),
            *self.arm_rad.tolist(),
            *self._torque_nm.tolist(),
            *self.data.qpos.tolist(),
        ]

    def restore(self, state: list[float]) -> None:
        """Be where `state` was taken."""
        self.counts = np.array(state[:3])
        self.arm_rad, self._torque_nm = np.array(state[3:6]), np.array(state[6:9])
        self.data.qpos[:] = state[9:]

    def move(self, counts: IntArray | FloatArray) -> FloatArray:
        """Go to counts (3,), all motors stepping together, and rest; the platform there, (3,) [m].

        Counts need not be whole.

        After UnreachablePoint the robot is where it was before.
        """
        before = self.state()
        for stride_steps in STRIDES_STEPS:
            try:
                for asked in self._asked(_along(self.counts, counts, stride_steps)):
                    self._yield_to(asked)
                    self._torque_nm = self._close(self.arm_rad)
                self._rest(asked)
                break
            except UnreachablePoint as error:
                # A long stride may make the solver miss the way that the linkage goes.
                self.restore(before)
                jam = error
        else:
            raise jam
        self.counts = np.array(counts, dtype=np.float64)
        return self.position_m

    def _asked(self, counts: FloatArray) -> FloatArray:
        return asked_angles(
            np.asarray(counts, dtype=np.float64), np.zeros(len(counts)), self.joints
        )

    def _rest(self, asked: FloatArray) -> None:
        """Let angles and torques agree."""
        for _ in range(6):
            before = self.arm_rad
            self._yield_to(asked)
            self._torque_nm = self._close(self.arm_rad)
            if np.abs(self.arm_rad - before).max() < 1e-8:
                return

    def _yield_to(self, asked: FloatArray) -> None:
        """Each arm to the nearest angle at which friction holds it."""
        low = self._balance(asked, self._torque_nm - self.joints.friction_nm)
        high = self._balance(asked, self._torque_nm + self.joints.friction_nm)
        self.arm_rad = np.clip(self.arm_rad, low, high)

    def _balance(self, asked: FloatArray, torque_nm: FloatArray) -> FloatArray:
        """Angles at which the flanks alone bear a torque that pulls the arms down."""
        play = 0.5 * self.joints.play_rad * np.sign(torque_nm)
        angle: FloatArray = asked + play + torque_nm / self.joints.stiffness_nm_per_rad
        return angle

    def _close(self, arm_rad: FloatArray) -> FloatArray:
        """Put the linkage together from where it is; gravity's torque on the arms, (3,) [N m]."""
        model, data, free, arms = self.model, self.data, self._free, self._arm_v
        data.qpos[self._arm_q] = arm_rad
        data.qvel[:] = 0.0
        step = np.zeros(model.nv)
        for _ in range(ROUNDS):
            mujoco.mj_fwdPosition(model, data)
            slope = data.efc_J.reshape(-1, model.nv)[:LOOP_ROWS]
            gap = data.efc_pos[:LOOP_ROWS]
            try:
                if np.abs(gap).max() < CLOSED_M:
                    self._stays_on_its_side(slope[:, free])
                    follow = -np.linalg.solve(slope[:, free], slope[:, arms])
                    return self._torque(follow)
                change = np.linalg.solve(slope[:, free], -gap)
            except np.linalg.LinAlgError:
                break
            step[free] = change * min(1.0, 0.3 / max(float(np.abs(change).max()), 1e-12))
            mujoco.mj_integratePos(model, data.qpos, step, 1.0)
        raise self._jams(arm_rad)

    def _stays_on_its_side(self, slope: FloatArray) -> None:
        """The platform cannot pass through the plane of its elbows, though a solver can jump."""
        side = float(np.linalg.slogdet(slope)[0])
        if self._side == 0.0:
            self._side = side
        if side != self._side:
            raise self._jams(self.arm_rad)

    def _torque(self, follow: FloatArray) -> FloatArray:
        model, data = self.model, self.data
        whole = np.zeros((model.nv, 3))
        whole[self._free], whole[self._arm_v] = follow, np.eye(3)
        steepest = np.linalg.norm(whole[self._platform_v : self._platform_v + 3], axis=0).max()
        if steepest > STEEPEST_M_PER_RAD:
            raise self._jams(self.arm_rad)
        mujoco.mj_fwdVelocity(model, data)
        torque: FloatArray = -whole.T @ data.qfrc_bias
        return torque

    def _jams(self, arm_rad: FloatArray) -> UnreachablePoint:
        angles = ", ".join(f"{angle:.1f}" for angle in np.degrees(arm_rad))
        return UnreachablePoint(f"the robot as it was built jams with its arms at {angles} deg")


def _along(start: FloatArray, end: IntArray | FloatArray, stride_steps: int) -> FloatArray:
    """Counts along a move with all motors stepping together, its end last, (n, 3)."""
    left = np.abs(end - start)
    stops = {float(stop) for stop in left}
    strides = {
        float(tick) for tick in np.linspace(0, left.max(), int(left.max()) // stride_steps + 2)
    }
    ticks = np.array(sorted((stops | strides) - {0.0}) or [0.0])
    passed: FloatArray = start + np.sign(end - start) * np.minimum(ticks[:, None], left)
    return passed


MAP_ROUNDS = 8
CLOSE_M = 2e-5
"""A fifth of what one microstep moves."""
PROBE_STEPS = 40


@dataclass
class ExpectedMap:
    """Counts to expected measured position, in both directions."""

    machine: Machine
    sensors: Sensors

    def __post_init__(self) -> None:
        joints = replace(self.machine.robot.joints, friction_nm=np.full(3, 1e-6))
        self._robot = replace(self.machine.robot, joints=joints)

    def measured_m(self, position_m: FloatArray) -> FloatArray:
        """What the sensors say on average of platforms at rest (n, 3) [m], same shape."""
        apart_s = 1e6 * np.arange(len(position_m), dtype=np.float64)
        still = Truth(apart_s, position_m, np.zeros_like(position_m), 0.0)
        if len(position_m) == 1:
            still = Truth(np.array([0.0, 1e6]), np.repeat(position_m, 2, 0), np.zeros((2, 3)), 0.0)
        ranges_m = ideal_ranges(self.machine.sensors, still, apart_s)
        measured: FloatArray = np.linalg.solve(
            self.sensors.axes, (ranges_m - self.sensors.offsets_m).T
        ).T
        return measured

    def counts_of(self, target_m: FloatArray, start: IntArray) -> IntArray:
        """Counts (n, 3) at which the targets would be measured, one after another.

        start: counts (3,) not far from the first. Raises UnreachablePoint.
        """
        robot = SettlingRobot(self._robot, start)
        counts = start.astype(np.float64)
        slope = self._slope(robot, counts)
        found = np.empty(target_m.shape, dtype=np.int64)
        for row, target in enumerate(target_m):
            for attempt in range(MAP_ROUNDS):
                missing = target - self._at(robot, counts)
                if np.abs(missing).max() < CLOSE_M:
                    break
                if attempt:
                    slope = self._slope(robot, counts)
                counts = counts + np.linalg.solve(slope, missing)
            else:
                at = ", ".join(f"{value:.4f}" for value in target)
                raise UnreachablePoint(f"({at}) m is not measured at any counts")
            found[row] = np.rint(counts)
        return found

    def _at(self, robot: SettlingRobot, counts: FloatArray) -> FloatArray:
        # Between two whole steps nothing is lost: a motor is carried there all the same.
        here: FloatArray = self.measured_m(robot.move(counts)[None])[0]
        return here

    def _slope(self, robot: SettlingRobot, counts: FloatArray) -> FloatArray:
        columns = []
        for motor in range(3):
            step = np.zeros(3)
            step[motor] = PROBE_STEPS
            ahead, behind = self._at(robot, counts + step), self._at(robot, counts - step)
            columns.append((ahead - behind) / (2.0 * PROBE_STEPS))
        self._at(robot, counts)
        return np.stack(columns, axis=1)
