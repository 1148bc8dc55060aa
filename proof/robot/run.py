"""Run the robot through a motion; where its platform really was."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from proof.motion.stepping import StepTrain
from proof.robot.as_built import AsBuilt, FloatArray
from proof.robot.assemble import LOOPS, Assembly
from proof.robot.bodies import build
from proof.robot.gear import asked_angles, flanks

TIMESTEP_S = 0.001
KEEP_EVERY = 5
"""Positions are kept every 5 ms: the platform moves less than 1 mm in that time."""
SETTLE_S = 0.4
GROW_EVERY = 200
CHECK_EVERY = 20
"""The loops are checked every 20 ms, at the sensors' rate."""


@dataclass(frozen=True)
class Truth:
    """What really happened: times (n,) [s], target position (n, 3) [m], arm angles (n, 3) [rad].

    gap_m: how far the closed loops ever came apart (the simulation's own constraint error).
    """

    t_s: FloatArray
    position_m: FloatArray
    arm_rad: FloatArray
    gap_m: float


def run(robot: AsBuilt, train: StepTrain, start_in_play: FloatArray | None = None) -> Truth:
    """Simulate a whole motion. Raises UnreachablePoint when the robot cannot be assembled.

    start_in_play: where in its play each arm begins, -1 to 1, shape (3,).
    """
    grid_s = np.arange(round(train.seconds / TIMESTEP_S)) * TIMESTEP_S
    asked = asked_angles(train.smooth(grid_s), grid_s, robot.joints)
    controls = flanks(asked, grid_s, robot.joints)
    model = build(robot.body, robot.joints, TIMESTEP_S)
    assembly = Assembly(model)
    data = mujoco.MjData(model)
    width = controls[0, 1::2] - controls[0, 0::2]
    inside = np.zeros(3) if start_in_play is None else start_in_play
    data.qpos[:] = assembly.at(asked[0] + 0.5 * width * inside)
    data.ctrl[:] = controls[0]
    mujoco.mj_step(model, data, round(SETTLE_S / TIMESTEP_S))
    return _follow(robot, model, data, assembly, controls, grid_s)


def _follow(
    robot: AsBuilt,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    assembly: Assembly,
    controls: FloatArray,
    grid_s: FloatArray,
) -> Truth:
    seen = model.body("platform" if robot.body.ringing_hz is None else "target").id
    rods = [model.body(f"rod_{loop}").id for loop in LOOPS]
    lengths_m = np.repeat(robot.body.upper_arm_m, 2)
    positions = np.empty((len(grid_s) // KEEP_EVERY + 1, 3))
    angles = np.empty_like(positions)
    step, ctrl, gap_m, grows = mujoco.mj_step, data.ctrl, 0.0, robot.body.growth != 0.0
    place, arms = data.xpos, assembly.arms_q
    kept = 0
    for k, control in enumerate(controls):
        if k % KEEP_EVERY == 0:
            # Positions belong to the state before the step: bring them up to date with it.
            mujoco.mj_kinematics(model, data)
            positions[kept], angles[kept] = place[seen], data.qpos[arms]
            kept += 1
        if k % CHECK_EVERY == 0:
            ends = data.site_xpos[assembly.ends] - data.site_xpos[assembly.anchors]
            gap_m = max(gap_m, float(np.abs(ends).max()))
        if grows and k % GROW_EVERY == 0:
            warm = -np.expm1(-grid_s[k] / robot.body.growth_time_s)
            model.body_pos[rods, 0] = lengths_m * (1.0 + robot.body.growth * warm)
        ctrl[:] = control
        step(model, data)
    return Truth(grid_s[::KEEP_EVERY], positions[:kept], angles[:kept], gap_m)
