"""Run the robot through a motion, behind its drives and gears; where its platform really was."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco.rollout import Rollout
from scipy.signal import lfilter

from deltactl.proof.robot.as_built import AsBuilt, FloatArray, Joints, StepTrain
from deltactl.proof.robot.bodies import LOOPS, Assembly, build, damping_of


def asked_angles(counts: FloatArray, t_s: FloatArray, joints: Joints) -> FloatArray:
    """Angle each arm would have with a stiff gear without play, (n, 3) [rad].

    counts: (n, 3) at the evenly spaced times t_s (n,), as `StepTrain.smooth` gives them.
    """
    asked = np.empty_like(counts)
    for m in range(3):
        lost = np.where(t_s >= joints.lost_at_s[m], joints.lost_steps[m], 0.0)
        motor = joints.rad_per_step * (counts[:, m] - lost)
        if joints.dead_time_s[m] > 0.0:
            motor = np.interp(t_s - joints.dead_time_s[m], t_s, motor)
        if joints.lag_s[m] > 0.0:
            motor = _lagged(motor, float(t_s[1] - t_s[0]), joints.lag_s[m])
        angle = joints.scale[m] * motor
        turns = joints.waves_per_turn * angle + joints.wave_phase_rad[m]
        asked[:, m] = angle + joints.wave_rad[m] * np.sin(turns)
    bent = asked.copy()
    for bend in joints.bends:
        bent += bend(asked, t_s)
    return bent + joints.home_rad


def _lagged(signal: FloatArray, step_s: float, lag_s: float) -> FloatArray:
    keep = np.exp(-step_s / lag_s)
    # Trapezoid: the input is a straight line between grid points, so no half step is added.
    share = lag_s / step_s * (1.0 - keep)
    before, now = share - keep, 1.0 - share
    start = [signal[0] * (1.0 - now)]
    late: FloatArray = lfilter([now, before], [1.0, -keep], signal, zi=start)[0]
    return late


def flanks(asked: FloatArray, t_s: FloatArray, joints: Joints) -> FloatArray:
    """Controls of the half-springs, (n, 6): lower and upper flank of each arm in turn.

    Where gears may give way, (n, 12): once more for what goes on pushing then.
    """
    width = np.broadcast_to(joints.play_rad, asked.shape)
    if joints.play_shape is not None:
        width = width + joints.play_shape(asked, t_s)
    speed = np.gradient(asked, t_s, axis=0)
    k = joints.stiffness_nm_per_rad
    ahead = np.array([damping_of(float(x), joints.hub_kgm2) / float(x) for x in k]) * speed
    controls = np.empty((len(asked), 6))
    controls[:, 0::2] = asked - 0.5 * width + ahead
    controls[:, 1::2] = asked + 0.5 * width + ahead
    if joints.yields_at_nm is None:
        return controls
    beyond = controls - np.repeat(ahead, 2, axis=1)
    return np.concatenate([controls, beyond], axis=1)


TIMESTEP_S = 0.001
KEEP_EVERY = 5
"""Positions are kept every 5 ms: the platform moves less than 1 mm in that time."""
SETTLE_S = 0.4
GROW_EVERY = 200
AT_ONCE = 4000
"""Steps in one call of MuJoCo's own loop; they bound what is remembered of the states."""
STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
TIME = 1
"""A state is the time, then the coordinates, then their speeds."""
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
    A force on the platform is that of the motion without it: what it bends changes it by some
    per cent, which no case depends on.
    """
    grid_s = np.arange(round(train.seconds / TIMESTEP_S)) * TIMESTEP_S
    asked = asked_angles(train.smooth(grid_s), grid_s, robot.joints)
    controls = flanks(asked, grid_s, robot.joints)
    inside = np.zeros(3) if start_in_play is None else start_in_play
    if not robot.body.pulls:
        return _simulate(robot, asked[0], controls, grid_s, inside)
    still = np.zeros((len(grid_s), 3))
    free = _simulate(robot, asked[0], np.hstack([controls, still]), grid_s, inside)
    forces = np.hstack([controls, pulled_n(robot, free, grid_s)])
    return _simulate(robot, asked[0], forces, grid_s, inside)


def pulled_n(robot: AsBuilt, truth: Truth, t_s: FloatArray) -> FloatArray:
    """Sum of the forces on the platform along a motion, at other times, (n, 3) [N]."""
    speed = np.gradient(truth.position_m, truth.t_s, axis=0)
    total = np.zeros_like(speed)
    for pull in robot.body.pulls:
        total += pull(truth.t_s, truth.position_m, speed)
    return np.stack([np.interp(t_s, truth.t_s, total[:, axis]) for axis in range(3)], axis=1)


def _simulate(
    robot: AsBuilt,
    start_rad: FloatArray,
    controls: FloatArray,
    grid_s: FloatArray,
    inside: FloatArray,
) -> Truth:
    """Let it come to rest at the start, then follow the controls."""
    model = build(robot.body, robot.joints, TIMESTEP_S)
    assembly = Assembly(model)
    data = mujoco.MjData(model)
    width = controls[0, 1:6:2] - controls[0, 0:6:2]
    data.qpos[:] = assembly.at(start_rad + 0.5 * width * inside)
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
    """The whole motion in pieces; while arms grow the model changes between them."""
    rods = [model.body(f"rod_{loop}").id for loop in LOOPS]
    lengths_m = np.repeat(robot.body.upper_arm_m, 2)
    grows = robot.body.growth != 0.0
    at_once = GROW_EVERY if grows else AT_ONCE
    state = np.empty(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    poses, gap_m = [], 0.0
    with Rollout(nthread=0) as rollout:
        for first in range(0, len(controls), at_once):
            if grows:
                warm = -np.expm1(-grid_s[first] / robot.body.growth_time_s)
                model.body_pos[rods, 0] = lengths_m * (1.0 + robot.body.growth * warm)
            piece = controls[first : first + at_once]
            states, _ = rollout.rollout(
                model, data, state, piece, initial_warmstart=data.qacc_warmstart.copy()
            )
            # Positions belong to the state before a step.
            before = np.vstack([state, states[0, :-1]])[::KEEP_EVERY, TIME : TIME + model.nq]
            gap_m = max(gap_m, _gap_m(assembly, before[:: CHECK_EVERY // KEEP_EVERY]))
            poses.append(before.copy())
            state = states[0, -1].copy()
    pose = np.concatenate(poses)
    return Truth(grid_s[::KEEP_EVERY], _target_m(model, pose), pose[:, assembly.arms_q], gap_m)


def _target_m(model: mujoco.MjModel, pose: FloatArray) -> FloatArray:
    """What the sensors look at, (n, 3) [m]: the platform's middle, or what rings on top of it."""
    start = int(model.joint("platform").qposadr[0])
    middle: FloatArray = pose[:, start : start + 3]
    if model.nq == start + 7:
        return middle
    w, turn = pose[:, start + 3 : start + 4], pose[:, start + 4 : start + 7]
    shift = pose[:, start + 7 : start + 10]
    # A vector turned by a quaternion (w, v): s + 2 w (v x s) + 2 v x (v x s).
    across = np.asarray(2.0 * np.cross(turn, shift), dtype=np.float64)
    swung = np.asarray(np.cross(turn, across), dtype=np.float64)
    moved: FloatArray = middle + shift + w * across + swung
    return moved


def _gap_m(assembly: Assembly, pose: FloatArray) -> float:
    """Largest gap in a closed loop at some poses (n, nq) [m]."""
    model, data, gap_m = assembly.model, assembly.data, 0.0
    for joints in pose:
        data.qpos[:] = joints
        mujoco.mj_kinematics(model, data)
        ends = data.site_xpos[assembly.ends] - data.site_xpos[assembly.anchors]
        gap_m = max(gap_m, float(np.abs(ends).max()))
    return gap_m
