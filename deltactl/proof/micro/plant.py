"""The simulated micro delta as a loop drives it: currents in, encoder counts out, tick by tick."""

from __future__ import annotations

from math import floor

import mujoco
import numpy as np

from deltactl.foundation.errors import UnreachablePoint
from deltactl.proof.micro.as_built import FloatArray, MicroDelta, Three
from deltactl.proof.micro.bodies import PERIOD_S, Rods, build

PRECISE_M = 1e-12
ROUNDS = 60


def assembled(model: mujoco.MjModel, robot: MicroDelta, angles_rad: Three) -> FloatArray:
    """qpos with the arms at these angles and all loops closed, platform below the arms.

    Raises UnreachablePoint when the forearms do not meet the platform.
    """
    data = mujoco.MjData(model)
    for number, angle in enumerate(angles_rad):
        data.qpos[model.joint(f"arm_{number}").qposadr[0]] = angle
    elbows = _sites(model, data, "elbow")
    start = int(model.joint("slide_x").qposadr[0])
    data.qpos[start : start + 3] = (0.0, 0.0, -1.2 * robot.body.forearm_m)
    for _ in range(ROUNDS):
        gap = _sites(model, data, "anchor") - elbows
        lengths_m = np.linalg.norm(gap, axis=1)
        miss = lengths_m - robot.body.forearm_m
        if np.abs(miss).max() < PRECISE_M:
            return _with_rods(model, data, elbows)
        change = np.linalg.lstsq(gap / lengths_m[:, None], -miss, rcond=None)[0]
        most = float(np.abs(change).max())
        data.qpos[start : start + 3] += change * min(1.0, 0.02 / max(most, 1e-12))
    raise UnreachablePoint(
        f"the micro delta cannot be assembled at {np.degrees(angles_rad).round(2).tolist()} degrees"
    )


def _sites(model: mujoco.MjModel, data: mujoco.MjData, stem: str) -> FloatArray:
    mujoco.mj_kinematics(model, data)
    ids = [model.site(f"{stem}_{number}").id for number in range(3)]
    return np.array(data.site_xpos[ids])


def _with_rods(model: mujoco.MjModel, data: mujoco.MjData, elbows: FloatArray) -> FloatArray:
    """Turn the rods' universal joints so that they end at the platform; nothing without rods."""
    if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "rod_0") < 0:
        return np.array(data.qpos)
    anchors = _sites(model, data, "anchor")
    for number in range(3):
        turn = data.xmat[model.body(f"arm_{number}").id].reshape(3, 3)
        x, y, z = turn.T @ (anchors[number] - elbows[number])
        # A rod hangs along -z; about y by `swing`, then about its own x by `lean`:
        # (-cos(lean) sin(swing), sin(lean), -cos(lean) cos(swing)) times its length.
        lean = np.arctan2(y, np.hypot(x, z))
        data.qpos[model.joint(f"swing_{number}").qposadr[0]] = np.arctan2(-x, -z)
        data.qpos[model.joint(f"lean_{number}").qposadr[0]] = lean
    return np.array(data.qpos)


Counts = tuple[int, int, int]


class MicroPlant:
    """One robot and its state. Has the members of `deltactl.drivers.current_drives.Plant`.

    Does not model: play and compliance of the gears, torque ripple, the current loop's own lag
    (electrical time constants are some 50 us), ball joints' friction.
    """

    def __init__(
        self,
        robot: MicroDelta,
        angles_rad: Three,
        rods: Rods = Rods.BODIES,
        period_s: float = PERIOD_S,
        dry: bool = True,
    ):
        self.robot, self.model = robot, build(robot, rods, period_s, dry)
        self.data = mujoco.MjData(self.model)
        drives = robot.drives
        first, second, third = (drives.gear_ratio * k for k in drives.torque_constant_nmpa)
        self._torques = (first, second, third)
        self._limit_a, self._per_count = drives.current_limit_a, 1.0 / drives.encoder_rad
        self._weighed = any(robot.body.counterweight_nm)
        # Views into MuJoCo's memory, made once: an attribute of `data` makes a new one each time.
        self._ctrl, self._qpos = self.data.ctrl, self.data.qpos
        self._rows = [int(self.model.joint(f"arm_{n}").qposadr[0]) for n in range(3)]
        self._step = mujoco.mj_step
        self.place(angles_rad)

    def place(self, angles_rad: Three) -> None:
        """Put the arms at these angles, at rest. Raises UnreachablePoint if they do not meet."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = assembled(self.model, self.robot, angles_rad)
        mujoco.mj_forward(self.model, self.data)

    def advance(self, first: float, second: float, third: float) -> None:
        """One period with these motor currents [A], within the drives' limit."""
        limit, ctrl = self._limit_a, self._ctrl
        k1, k2, k3 = self._torques
        ctrl[0] = k1 * (limit if first > limit else -limit if first < -limit else first)
        ctrl[1] = k2 * (limit if second > limit else -limit if second < -limit else second)
        ctrl[2] = k3 * (limit if third > limit else -limit if third < -limit else third)
        if self._weighed:
            self._weigh()
        self._step(self.model, self.data)

    def hold(self) -> None:
        """One period with the arms held: nothing moves."""
        self.data.qvel[:] = 0.0

    def angles_rad(self) -> Three:
        """True arm angles [rad]."""
        q, (a, b, c) = self._qpos, self._rows
        return float(q[a]), float(q[b]), float(q[c])

    def counts(self) -> Counts:
        """What the encoders say: whole counts, count 0 at angle 0, an edge between two counts."""
        q, (a, b, c), per = self._qpos, self._rows, self._per_count
        return floor(q[a] * per + 0.5), floor(q[b] * per + 0.5), floor(q[c] * per + 0.5)

    def counts_at(self, angles_rad: Three) -> Counts:
        """What the encoders would say of these angles."""
        first, second, third = (floor(angle * self._per_count + 0.5) for angle in angles_rad)
        return first, second, third

    def speeds_radps(self) -> FloatArray:
        """True arm speeds, (3,)."""
        return np.array([self.data.qvel[self.model.joint(f"arm_{n}").dofadr[0]] for n in range(3)])

    def platform_m(self) -> FloatArray:
        """Where the platform's middle is, (3,)."""
        place = int(self.model.joint("slide_x").qposadr[0])
        return np.array(self.data.qpos[place : place + 3])

    def gap_m(self) -> float:
        """How far the closed loops have come apart: the simulation's own constraint error."""
        mujoco.mj_kinematics(self.model, self.data)
        sites = self.data.site_xpos
        gaps = []
        for n in range(3):
            elbow = sites[self.model.site(f"elbow_{n}").id]
            anchor = sites[self.model.site(f"anchor_{n}").id]
            gaps.append(abs(float(np.linalg.norm(anchor - elbow)) - self.robot.body.forearm_m))
        return max(gaps)

    def _weigh(self) -> None:
        for n, (row, torque) in enumerate(
            zip(self._rows, self.robot.body.counterweight_nm, strict=True)
        ):
            self.data.qfrc_applied[self.model.joint(f"arm_{n}").dofadr[0]] = torque * np.cos(
                self._qpos[row]
            )
