"""Where the platform was asked to be at any time of a run: what errors are measured from.

Targets are recorded where they lie on the path and when they are due, and once more when a rest at
one of them is over. Between two of them the platform is asked to go straight: at an even speed, or
from and to a rest with the speed growing evenly, as it is planned. A pause stretches both alike.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from deltactl.models.robot import FloatArray
from deltactl.recording.reading.run import BoolArray, Int64Array, Run

_NS = 1e-9


def planned_s(run: Run, t_s: FloatArray) -> FloatArray:
    """Times of the plan, (n,) [s], at times of the run; the two run alike but for pauses.

    Every motion begins at the planned pace, and its settings are recorded as it begins. A recording
    of an earlier version has no paces, and its pauses are not known.
    """
    if not len(run.paces.t_ns):
        return t_s
    afresh, changes = np.ones(len(run.settings.t_ns)), run.paces
    times_s = np.concatenate([run.settings.t_ns, changes.t_ns]) * _NS
    order = np.argsort(times_s, kind="stable")
    begins_s = times_s[order]
    rate = np.concatenate([afresh, changes.rate])[order]
    goal = np.concatenate([afresh, changes.goal])[order]
    ramp_s = np.concatenate([0.0 * afresh, changes.ramp_s])[order]

    def gone_s(row: Int64Array, since_s: FloatArray) -> FloatArray:
        """Planned time that passes after a change of pace."""
        on_ramp_s = np.minimum(since_s, ramp_s[row])
        growth = (goal - rate)[row] / np.maximum(ramp_s[row], _NS)
        gone: FloatArray = on_ramp_s * (rate[row] + growth * on_ramp_s / 2.0)
        gone += goal[row] * (since_s - on_ramp_s)
        return gone

    every = np.arange(len(begins_s))
    passed_s = gone_s(every[:-1], np.diff(begins_s))
    reached_s = begins_s[0] + np.concatenate([[0.0], np.cumsum(passed_s)])
    row = np.searchsorted(begins_s, t_s, side="right") - 1
    known = np.maximum(row, 0)
    return np.where(row < 0, t_s, reached_s[known] + gone_s(known, t_s - begins_s[known]))


PATH_EVENTS = ("path_start", "path_end")
DONE = "done"
RAMP_KNOTS = 8
"""Places worked out between a rest and the target beside it: they err by 1/256 of the way."""
LATE_NS = 20_000_000
"""A path that is begun is noted up to a round of the control loop away from its first target."""
Knots = tuple[FloatArray, FloatArray]


@dataclass(frozen=True, slots=True)
class Window:
    """From a `path_start` to its `path_end`, or to the end of the recording, in run time.

    A path of one place ends as it begins: there it is as long as the platform stays at the place.
    """

    start_ns: int
    end_ns: int
    done: bool
    """Whether the path was run to its end."""


def windows(run: Run) -> tuple[Window, ...]:
    """The stretches in which a path was followed."""
    found: list[Window] = []
    start_ns: int | None = None
    for event in run.events:
        if event.kind == "path_start":
            start_ns = event.t_ns
        elif event.kind == "path_end" and start_ns is not None:
            done = event.text == DONE
            stays = done and _one_place(run, start_ns, event.t_ns)
            end_ns = _leaves_ns(run, event.t_ns) if stays else event.t_ns
            found.append(Window(start_ns, end_ns, done))
            start_ns = None
    if start_ns is not None:
        found.append(Window(start_ns, max(start_ns, run.end_ns), False))
    return tuple(found)


def _one_place(run: Run, start_ns: int, end_ns: int) -> bool:
    t_ns = run.targets.t_ns
    places_m = run.targets.position_m[(t_ns >= start_ns - LATE_NS) & (t_ns <= end_ns)]
    return len(places_m) > 0 and bool((places_m == places_m[0]).all())


def _leaves_ns(run: Run, after_ns: int) -> int:
    """When the way to the next path begins, or the recording ends."""
    ways = (
        event.t_ns for event in run.events if event.kind == "approach" and event.t_ns >= after_ns
    )
    return max(after_ns, next(ways, run.end_ns))


def path_windows(run: Run) -> tuple[tuple[int, int], ...]:
    """Run times [ns] from every `path_start` to its `path_end` (or the end of the recording)."""
    return tuple((window.start_ns, window.end_ns) for window in windows(run))


def ran_to_its_end(run: Run) -> bool:
    """Whether the last path that was begun was also done; one not begun is no partial one."""
    last = next((event for event in reversed(run.events) if event.kind in PATH_EVENTS), None)
    return last is None or (last.kind == "path_end" and last.text == DONE)


def seconds(t_ns: Int64Array) -> FloatArray:
    """Nanoseconds as seconds."""
    return t_ns.astype(np.float64) * _NS


def arrivals(run: Run) -> BoolArray:
    """Which targets, (n,), are not the one before once more, as when a rest there is over."""
    position_m = run.targets.position_m
    return np.concatenate([np.ones(len(position_m[:1]), dtype=np.bool_), ~_resting(position_m)])


def targets_at(run: Run, t_s: FloatArray) -> FloatArray:
    """The point asked for at each time, (n, 3) [m]; NaN off the path, and on the way back to its
    start, which is no part of it. After the last target of a path that is done it stays there.
    """
    asked_m = np.full((len(t_s), 3), np.nan)
    found = windows(run)
    begun_ns = [window.start_ns - LATE_NS for window in found] + [np.iinfo(np.int64).max]
    for number, window in enumerate(found):
        inside = (t_s >= window.start_ns * _NS) & (t_s <= window.end_ns * _NS)
        # The last target may be due after the last step to it, and so after the noted end.
        t_ns = run.targets.t_ns
        rows = np.flatnonzero((t_ns >= begun_ns[number]) & (t_ns < begun_ns[number + 1]))
        known_s, known_m = _knots(run, rows, window.done)
        if not len(known_s) or not inside.any():
            continue
        right = {} if window.done else {"right": np.nan}
        along_s = planned_s(run, t_s[inside])
        columns = [np.interp(along_s, known_s, column, **right) for column in known_m.T]
        asked_m[inside] = np.stack(columns, axis=1)
    return asked_m


def _resting(position_m: FloatArray) -> BoolArray:
    """Whether each target but the first is where the one before it is, (n - 1,)."""
    return np.asarray((position_m[1:] == position_m[:-1]).all(axis=1), dtype=np.bool_)


def _knots(run: Run, rows: Int64Array, done: bool) -> Knots:
    """Planned times [s] and places [m], (k,) and (k, 3): a line between them is the path.

    done: whether the last of them is where the path ends.
    """
    t_ns = run.targets.t_ns[rows]
    t_s, position_m = planned_s(run, seconds(t_ns)), run.targets.position_m[rows]
    number = run.targets.index[rows]
    resting = _resting(position_m)
    back = (number[1:] == 0) & (number[:-1] > 0) & ~resting
    more = [(t_s, position_m), *_gaps(t_s, back)]
    if not np.isfinite(run.settings.t_pwm_at(t_ns[:1])).any():
        more += _ramps(t_s, position_m, resting, back, done)
    times = np.concatenate([times_s for times_s, _ in more])
    order = np.argsort(times, kind="stable")
    return times[order], np.concatenate([places_m for _, places_m in more])[order]


def _gaps(t_s: FloatArray, back: BoolArray) -> Iterator[Knots]:
    """Nothing is asked for between the end of a path and its next beginning."""
    for row in np.flatnonzero(back):
        yield np.array([t_s[row] + _NS, t_s[row + 1] - _NS]), np.full((2, 3), np.nan)


def _ramps(
    t_s: FloatArray, position_m: FloatArray, resting: BoolArray, back: BoolArray, done: bool
) -> Iterator[Knots]:
    """Places on the way from a rest to the next target, and from the last one before it."""
    takes_s = np.diff(t_s)
    moves = ~resting & ~back & (takes_s > 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        speed_mps = np.linalg.norm(np.diff(position_m, axis=0), axis=1) / takes_s
    speed_mps = np.append(speed_mps, speed_mps[-1:])  # the path continues, unrecorded
    # For the way after each target: whether it begins at a rest, and whether it ends at one.
    begins = np.concatenate([[True], ~moves[:-1]])
    ends = np.concatenate([~moves[1:], [done]])
    for row in np.flatnonzero(moves & (begins | ends)):
        part = np.arange(1, RAMP_KNOTS) / RAMP_KNOTS
        if begins[row] and ends[row]:
            way = np.where(part < 0.5, 2.0 * part**2, 1.0 - 2.0 * (1.0 - part) ** 2)
        elif begins[row]:
            way = _from_rest(part, speed_mps[row + 1] / speed_mps[row])
        else:
            way = 1.0 - _from_rest(1.0 - part, speed_mps[row - 1] / speed_mps[row])
        places_m = position_m[row] + way[:, None] * (position_m[row + 1] - position_m[row])
        yield t_s[row] + part * takes_s[row], places_m


def _from_rest(part: FloatArray, faster: float) -> FloatArray:
    """Part of a way that is done after parts of its time, from a rest to an even speed.

    faster: the mean speed of the way that follows, by that of this one.
    """
    end = min(max(faster, 1.0), 2.0)  # 1: as fast at once; 2: faster all the way
    ramp = 2.0 * (1.0 - 1.0 / end)
    if ramp == 0.0:
        return part
    done: FloatArray = np.where(part < ramp, end * part**2 / (2.0 * ramp), 1.0 - end * (1.0 - part))
    return done
