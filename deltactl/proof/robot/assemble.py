"""Put the robot together at given arm angles, with nothing but MuJoCo's own forward pass."""

from __future__ import annotations

import mujoco
import numpy as np

from deltactl.foundation.errors import UnreachablePoint
from deltactl.proof.robot.as_built import FloatArray

LOOPS = tuple(f"{arm}{side}" for arm in (1, 2, 3) for side in ("a", "b"))
PRECISE_M = 1e-10
ROUNDS = 60


class Assembly:
    """Closes the loops for fixed arm angles by Gauss-Newton on the rods' ends.

    MuJoCo says where the rods end and how that changes with each joint; the arms stay put.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        self.ends = [model.site(f"rod_end_{loop}").id for loop in LOOPS]
        self.anchors = [model.site(f"anchor_{loop}").id for loop in LOOPS]
        arms = [int(model.joint(f"arm_{arm}").dofadr[0]) for arm in (1, 2, 3)]
        self.arms_q = [int(model.joint(f"arm_{arm}").qposadr[0]) for arm in (1, 2, 3)]
        self.free = np.setdiff1d(np.arange(model.nv), arms)

    def at(self, arm_rad: FloatArray, guess: FloatArray | None = None) -> FloatArray:
        """The whole pose for arm angles (3,). Raises UnreachablePoint when it will not close."""
        model, data = self.model, self.data
        data.qpos[:] = model.qpos0 if guess is None else guess
        data.qpos[self.arms_q] = arm_rad
        for _ in range(ROUNDS):
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            gap = (data.site_xpos[self.ends] - data.site_xpos[self.anchors]).ravel()
            if np.abs(gap).max() < PRECISE_M:
                return np.array(data.qpos)
            change = np.linalg.lstsq(self._slope()[:, self.free], -gap, rcond=None)[0]
            step = np.zeros(model.nv)
            step[self.free] = change * min(1.0, 0.3 / max(float(np.abs(change).max()), 1e-12))
            mujoco.mj_integratePos(model, data.qpos, step, 1.0)
        raise UnreachablePoint(
            f"the robot cannot be assembled at arm angles {np.degrees(arm_rad).round(2).tolist()}"
            " degrees; its lengths or the angles are too far from possible"
        )

    def platform_m(self, arm_rad: FloatArray, guess: FloatArray | None = None) -> FloatArray:
        """Position of the platform's middle for rigid joints, shape (3,)."""
        pose = self.at(arm_rad, guess)
        start = int(self.model.joint("platform").qposadr[0])
        return pose[start : start + 3]

    def _slope(self) -> FloatArray:
        model, data = self.model, self.data
        rows = np.zeros((3 * len(LOOPS), model.nv))
        one, other = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        for row, (end, anchor) in enumerate(zip(self.ends, self.anchors, strict=True)):
            mujoco.mj_jacSite(model, data, one, None, end)
            mujoco.mj_jacSite(model, data, other, None, anchor)
            rows[3 * row : 3 * row + 3] = one - other
        return rows
