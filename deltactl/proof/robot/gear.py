"""From commanded counts to what the flanks of each gear ask of its arm, on the simulation's grid.

Order: counts, lost steps, dead time, lag, gear ratio, periodic error, unnamed bends, home, play.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from deltactl.proof.robot.as_built import FloatArray, Joints
from deltactl.proof.robot.bodies import damping_of


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
