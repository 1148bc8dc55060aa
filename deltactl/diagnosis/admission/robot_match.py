"""Whether a recording belongs to a delta's robot file at all, asked before any search.

A machine of the file with something wrong agrees with the file for part of the time, or needs
other homes and sensor offsets than the file says, or is a little off everywhere. When none of
this holds, the lengths and the gear that would fit are found, or that none do: that is another
machine, and everything a search could name would be wrong. An arm that flips into its other
assembly mode, a rod that comes off or a motor that stops leaves the platform somewhere else for
good: no effect of the vocabulary describes it either.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.admission.refusal import Refusal, refusal, refuse
from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray
from deltactl.diagnosis.plants.delta.model import ANGLES, MOTOR, POSITIONS, DeltaModel
from deltactl.foundation.scatter import MAD_TO_SIGMA
from deltactl.models.effects.units_in_use import said
from deltactl.models.linkage import Linkage, forward
from deltactl.recording.column_measures import travel


def refuse_broken(model: DeltaModel, source: str, left: FloatArray, span: float) -> None:
    """Refuse a recording in which the machine broke. Raises RefusedRecording, one line.

    left: readings less prediction, (n, channels), NaN where nothing was read. span: how much the
    readings move.
    """
    rows = np.flatnonzero(np.isfinite(left).any(axis=1))
    apart = np.nanmax(np.abs(left[rows]), axis=1)
    last = int((1.0 - ADMISSION.least_after) * len(apart))
    if last <= ADMISSION.least_before:
        return
    moments = np.linspace(ADMISSION.least_before, last, ADMISSION.moments_tried)
    ratio, at = max(_contrast(apart, int(at)) for at in moments)
    after = float(np.quantile(apart[at:], 1.0 - ADMISSION.nearly_all))
    if (
        ratio < ADMISSION.worse
        or after < ADMISSION.broken_off * span
        or not _moves(model, rows[at:], span)
    ):
        return
    shift_rad, rest = _shifted(model, rows[at:], left)
    if rest < ADMISSION.offsets * after and shift_rad < ADMISSION.most_lost_rad:
        return
    t_s, off = model.readings.t_s[rows], float(np.median(apart[at:]))
    raise _broke(model, source, float(t_s[at] - t_s[0]), off).error()


def refuse_once_near(model: DeltaModel, source: str, left: FloatArray) -> None:
    """Refuse a machine that was the file's for a time, where no other machine would fit.

    The bars are lower than those of `refuse_broken`. Raises RefusedRecording, one line.
    """
    read = np.isfinite(left).any(axis=1)
    apart = np.nanmax(np.abs(left[read]), axis=1)
    after = float(np.median(apart[len(apart) // 2 :]))
    near = apart < ADMISSION.still_agrees * after
    before = np.cumsum(near)[:-1]
    count = np.arange(1, len(near))
    agreed = before / count
    later = (near.sum() - before) / (len(near) - count)
    at = int(np.argmax(agreed - later))
    if (
        count[at] >= ADMISSION.least_before
        and agreed[at] > 1.0 - ADMISSION.stray
        and later[at] < ADMISSION.stray
    ):
        t_s = model.readings.t_s[read]
        raise _broke(model, source, float(t_s[at] - t_s[0]), after).error()


def _broke(model: DeltaModel, source: str, when_s: float, off: float) -> Refusal:
    return refusal("broke", source, t_s=when_s, off=off, unit=model.readings.units[0])


def _contrast(apart: FloatArray, at: int) -> tuple[float, int]:
    """How many times farther off nearly all readings are from a moment on than before it."""
    before = float(np.quantile(apart[:at], ADMISSION.nearly_all))
    return float(np.quantile(apart[at:], 1.0 - ADMISSION.nearly_all)) / max(before, 1e-9), at


def _moves(model: DeltaModel, rows: IntArray, span: float) -> bool:
    return (
        float(np.nanmax(np.nanstd(model.position_m[rows], axis=0))) > ADMISSION.least_moving * span
    )


def _shifted(model: DeltaModel, rows: IntArray, left: FloatArray) -> tuple[float, float]:
    """The largest shift of a joint [rad] where each is shifted as fits best, and how far off the
    readings are then (median).
    """
    columns = [change for place, change in model.inputs().items() if place.startswith(MOTOR)]
    known = np.isfinite(left[rows])
    moved = np.stack([change[rows][known] for change in columns], axis=1)
    rest = left[rows][known]
    shift = np.linalg.lstsq(moved, rest, rcond=None)[0]
    return float(np.abs(shift).max()), float(np.median(np.abs(rest - moved @ shift)))


LENGTHS = ("base minus platform radius", "upper arm", "forearm")


def check_input(model: DeltaModel) -> None:
    """Refuse what cannot be right. Raises RefusedRecording."""
    readings = model.readings
    if not 1e-4 <= readings.period_s <= 5.0:
        refuse("no_seconds", column="t", period=readings.period_s)
    counts = readings.valid.sum(axis=0)
    most, of_one, of_all = int(counts.max()), OBSERVATIONS.fewest_samples, ADMISSION.fewest_in_all
    if most < of_one or counts.sum() < of_all:
        names = ", ".join(readings.names)
        refuse("few_valid", most=most, names=names, of_one=of_one, of_all=of_all)
    predicted = model.predict([n.term for n in model.nuisances])
    moved = np.ptp(predicted, axis=0)
    if moved.max() < ADMISSION.stands_still:
        refuse("nothing_moves")
    sizes = np.median(np.abs(predicted), axis=0)
    for column, name in enumerate(readings.names):
        good = readings.valid[:, column]
        if good.sum() < OBSERVATIONS.fewest_samples:
            continue
        seen, expected = readings.values[good, column], predicted[good, column]
        if np.ptp(seen) == 0.0 and np.ptp(expected) > 100 * ADMISSION.stands_still:
            refuse("dead_sensor", column=name, value=seen[0])
        unit, size = readings.units[column], float(np.median(np.abs(seen)))
        usual = float(np.median(np.abs(expected)))
        alike = float(sizes[[other == unit for other in readings.units]].max())
        if _another_unit(size, usual, alike):
            refuse("sensor_unit", column=name, times=size / max(usual, 1e-9), unit=unit)


def _another_unit(size: float, usual: float, alike: float) -> bool:
    """Whether readings are so much larger or smaller than is usual that their unit is another.

    alike: the largest of what is usually expected of channels in this unit. On a platform that
    only moves up and down, x and y are noise about 0: no size can be expected of them.
    """
    if size < usual / ADMISSION.unit_factor:
        return usual > ADMISSION.stands_still
    return size > ADMISSION.unit_factor * alike


@np.errstate(over="ignore", invalid="ignore")  # squares of readings beyond all bounds
def check_belongs(model: DeltaModel, source: str) -> None:
    """Refuse a recording of another machine. Raises RefusedRecording, one line."""
    check_input(model)
    readings = model.readings
    rows = np.flatnonzero(readings.valid.any(axis=1) & np.isfinite(model.position_m[:, 0]))
    if len(rows) < ADMISSION.fewest_looked_at:
        return
    seen = np.where(readings.valid, readings.values, np.nan)
    left = seen - model.predict([n.term for n in model.nuisances])
    scatter = _scatter(left)
    span = float(np.nanmax(np.nanstd(seen, axis=0)))
    refuse_broken(model, source, left, span)
    before = float(np.sqrt(np.nanmean(left**2)))
    if before < ADMISSION.far_off * span or _near(left, scatter) > ADMISSION.near_share:
        return
    nominal = left
    some = np.linspace(0, len(rows) - 1, min(len(rows), ADMISSION.looked_at))
    rows = rows[some.astype(int)]
    angles = _as_late_as_fits(model, rows, seen[rows])

    def belongs(size: FloatArray, left: FloatArray) -> bool:
        after = float(np.sqrt(np.nanmean(left**2)))
        return after <= ADMISSION.far_off * span and np.abs(size).max() <= ADMISSION.off

    size, left = _closest(model, angles, seen[rows], scatter, belongs)
    if belongs(size, left):
        return
    after = float(np.sqrt(np.nanmean(left**2)))
    unit, moved = readings.units[0], max(travel(column) for column in seen.T)
    apart = {"apart": said(before, unit), "moved": said(moved, unit)}
    refuse_once_near(model, source, nominal)
    if after > ADMISSION.far_off * span and _near(left, scatter) < ADMISSION.near_share:
        refuse("no_lengths", source, best=said(after, unit), **apart)
    if np.abs(size).max() > ADMISSION.off:
        refuse("other_lengths", source, lengths=_would_fit(model, size), **apart)


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
    model: DeltaModel,
    angles: FloatArray,
    seen: FloatArray,
    scatter: FloatArray,
    belongs: Callable[[FloatArray, FloatArray], bool],
) -> tuple[FloatArray, FloatArray]:
    """Shares by which lengths (3) and gear are off in the best fit, and what is left (n, c).

    Fitted to all samples; where that does not belong, to those that fit best, chosen anew a few
    times (least trimmed squares): a machine may be stopped by something for more than half of the
    time.
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
            cost,
            x,
            loss="soft_l1",
            f_scale=ADMISSION.soft_from,
            max_nfev=ADMISSION.match_evaluations,
        ).x
        return found

    nothing = np.zeros(len(usual))
    whole = fit(nothing, np.arange(len(seen)))
    if belongs(whole[:4] * usual[:4], left(whole)):
        return whole[:4] * usual[:4], left(whole)
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
    return ", ".join(told)


def _about_mm(length_m: float) -> int:
    """Two digits are known."""
    digits = 1 - int(np.floor(np.log10(1e3 * length_m)))
    return int(round(1e3 * length_m, digits))
