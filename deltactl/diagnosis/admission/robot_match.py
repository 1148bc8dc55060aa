"""Whether a recording belongs to the robot file at all, asked before any search.

A machine of the file with something wrong agrees with the file for part of the time, or needs
other homes and sensor offsets than the file says, or is a little off everywhere. When none of
this holds, the lengths and the gear that would fit are found, or that none do: that is another
machine, and everything a search could name would be wrong.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.admission.plausibility import check_input
from deltactl.diagnosis.admission.structural_break import refuse_broken, refuse_once_near
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray
from deltactl.diagnosis.plants.delta.model import ANGLES, POSITIONS, DeltaModel
from deltactl.foundation.errors import RecordingError
from deltactl.foundation.scatter import MAD_TO_SIGMA
from deltactl.models.effects.lone_axis import said
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import DeltaRobot
from deltactl.recording.column_measures import travel
from deltactl.recording.tables.flat import FlatRecording

LENGTHS = ("base minus platform radius", "upper arm", "forearm")


def check_belongs(robot: DeltaRobot, recording: FlatRecording) -> None:
    """Refuse a recording of another machine. Raises RecordingError, one line."""
    model = DeltaModel(robot, [recording])
    check_input(model)
    readings = model.readings
    rows = np.flatnonzero(readings.valid.any(axis=1) & np.isfinite(model.position_m[:, 0]))
    if len(rows) < ADMISSION.fewest_looked_at:
        return
    seen = np.where(readings.valid, readings.values, np.nan)
    left = seen - model.predict([n.term for n in model.nuisances])
    scatter = _scatter(left)
    span = float(np.nanmax(np.nanstd(seen, axis=0)))
    refuse_broken(model, recording.source, left, span)
    before = float(np.sqrt(np.nanmean(left**2)))
    if before < ADMISSION.far_off * span or _near(left, scatter) > ADMISSION.near_share:
        return
    nominal = left
    some = np.linspace(0, len(rows) - 1, min(len(rows), ADMISSION.looked_at))
    rows = rows[some.astype(int)]
    angles = _as_late_as_fits(model, rows, seen[rows])
    size, left = _closest(model, angles, seen[rows], scatter)
    after = float(np.sqrt(np.nanmean(left**2)))
    far = f"{recording.source}: recording and robot file do not belong together: "
    unit, moved = readings.units[0], max(travel(column) for column in seen.T)
    apart = f"{said(before, unit)} apart (root mean square) in a motion over {said(moved, unit)}"
    if after > ADMISSION.far_off * span or np.abs(size).max() > ADMISSION.off:
        refuse_once_near(model, recording.source, nominal)
    if after > ADMISSION.far_off * span and _near(left, scatter) < ADMISSION.near_share:
        raise RecordingError(
            f"{far}{apart}, and no lengths, homes, gear or sensor offsets bring them together (at"
            f" best {said(after, unit)}); is this another robot's file, or another run's commands?"
        )
    if np.abs(size).max() > ADMISSION.off:
        fits = _would_fit(model, size)
        raise RecordingError(f"{far}{apart}; {fits}; is this another robot's file?")


def _scatter(left: FloatArray) -> FloatArray:
    """Scatter from sample to sample, per channel."""
    scatter = np.ones(left.shape[1])
    for column, x in enumerate(left.T):
        known = x[np.isfinite(x)]
        if len(known) > 1:
            scatter[column] = MAD_TO_SIGMA * np.median(np.abs(np.diff(known))) / np.sqrt(2.0)
    return np.maximum(scatter, 1e-9)


def _near(left: FloatArray, scatter: FloatArray) -> float:
    """Share of the samples in which every channel that was read is where it should be."""
    read: BoolArray = np.isfinite(left)
    off = read & ~(np.abs(left) < ADMISSION.near_scatters * scatter)
    some = read.any(axis=1)
    return float(np.mean(~off.any(axis=1)[some])) if some.any() else 0.0


def _as_late_as_fits(model: DeltaModel, rows: IntArray, seen: FloatArray) -> FloatArray:
    """Commanded angles (n, 3), each motor's as late as brings it closest, one after another."""
    t_s = model.readings.t_s
    nothing = np.zeros(4), np.zeros(3), np.zeros(len(model.readings.names))

    def late(joint: int, lag_s: float) -> FloatArray:
        shifted: FloatArray = np.interp(t_s[rows] - lag_s, t_s, model.commanded_rad[:, joint])
        return shifted

    def apart(angles: FloatArray) -> float:
        left = seen - _predicted(model, angles, *nothing)
        return float(np.nanmean(np.abs(left - np.nanmedian(left, axis=0))))

    angles = model.commanded_rad[rows]
    for joint in (*range(3), *range(3)):
        tried = []
        for lag_s in ADMISSION.late_s:
            other = angles.copy()
            other[:, joint] = late(joint, lag_s)
            tried.append(other)
        angles = min(tried, key=apart)
    return angles


def _closest(
    model: DeltaModel, angles: FloatArray, seen: FloatArray, scatter: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Shares by which lengths (3) and gear are off in the best fit, and what is left (n, c).

    Fitted to all samples, and to those that fit best, chosen anew a few times (least trimmed
    squares): a machine may be stopped by something for more than half of the time.
    """
    # Three lengths and the gear, three homes, and what looks at the machine.
    usual = np.repeat(
        [ADMISSION.usual_share, ADMISSION.usual_home_rad, ADMISSION.usual_offset_m],
        [4, 3, len(model.readings.names)],
    )

    def left(x: FloatArray) -> FloatArray:
        at = x * usual
        predicted = _predicted(model, angles, at[:4], at[4:7], at[7:])
        off = np.where(np.isfinite(predicted), seen - predicted, ADMISSION.nowhere_m)
        return np.where(np.isfinite(seen), off, np.nan)

    def fit(x: FloatArray, chosen: IntArray) -> FloatArray:
        def cost(x: FloatArray) -> FloatArray:
            kept = left(x)[chosen] / scatter
            return np.concatenate([kept[np.isfinite(kept)], x])

        found: FloatArray = least_squares(
            cost, x, loss="soft_l1",
            f_scale=ADMISSION.soft_from, max_nfev=ADMISSION.match_evaluations,
        ).x  # fmt: skip
        return found

    nothing = np.zeros(len(usual))
    whole = fit(nothing, np.arange(len(seen)))
    ends = [whole, nothing]
    for _ in range(ADMISSION.trimmed_fits):
        off = [np.nanmax(np.abs(left(x)) / scatter, axis=1) for x in ends]
        best = [np.argsort(x)[: int(ADMISSION.trusted * len(seen))] for x in off]
        ends = [fit(x, chosen) for x, chosen in zip(ends, best, strict=True)]
    x = max([whole, *ends], key=lambda x: _near(left(x), scatter))
    return x[:4] * usual[:4], left(x)


def _predicted(
    model: DeltaModel, angles: FloatArray, size: FloatArray, home: FloatArray, offset: FloatArray
) -> FloatArray:
    """Channels of a machine with other lengths, gear, homes and offsets of what looks at it."""
    believed = model.chain.linkage
    radius, upper, forearm, gear = np.exp(size)
    other = Linkage(
        believed.radius_m * radius,
        believed.upper_arm_m * upper,
        believed.forearm_m * forearm,
        believed.azimuth_rad,
        believed.home_offset_rad,
    )
    angles = angles * gear + home
    position = forward(other, angles).position_m
    columns = []
    for column, name in enumerate(model.readings.names):
        axis = "xyz".find(name[-1])
        if name in ANGLES:
            columns.append(angles[:, ANGLES.index(name)])
        elif name in POSITIONS:
            columns.append(position[:, axis] + offset[column])
        else:
            assert model.robot.sensors is not None
            sensors = model.robot.sensors
            zero = sensors.offsets_m[axis] + offset[column]
            columns.append(position @ sensors.axes[axis] + zero)
    return np.stack(columns, axis=1)


def _would_fit(model: DeltaModel, size: FloatArray) -> str:
    """What the nearest machine is like, for a hint of which file belongs to the recording."""
    believed = model.chain.linkage
    lengths = (believed.radius_m, believed.upper_arm_m, believed.forearm_m)
    told = [
        f"{name} {_about_mm(float(np.mean(length * np.exp(share))))} mm"
        for name, length, share in zip(LENGTHS, lengths, size[:3], strict=True)
    ]
    if abs(size[3]) > ADMISSION.off:
        told.append(f"arms turning {np.exp(size[3]):.2g} times as far")
    return f"what comes nearest, and need not be yours, has about {', '.join(told)}"


def _about_mm(length_m: float) -> int:
    """Two digits are known."""
    digits = 1 - int(np.floor(np.log10(1e3 * length_m)))
    return int(round(1e3 * length_m, digits))
