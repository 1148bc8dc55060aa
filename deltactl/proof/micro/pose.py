"""Whole poses of the micro delta for given arm angles: MuJoCo's own forward pass, and a root."""

from __future__ import annotations

import mujoco
import numpy as np

from deltactl.foundation.errors import UnreachablePoint
from deltactl.proof.micro.as_built import FloatArray, MicroDelta, Three

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
