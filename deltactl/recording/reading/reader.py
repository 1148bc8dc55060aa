"""Reads a recording, whole or cut off, into arrays."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.printable import printable
from deltactl.recording.format import configuration, messages
from deltactl.recording.format.channels import (
    CHANNELS,
    COMMANDED,
    CONFIGURATION,
    EDGES,
    EVENT,
    PACE,
    READINGS,
    SERVO,
    SETTINGS,
    TARGET,
    TRUTH,
)
from deltactl.recording.format.messages import OF_A_JOINT
from deltactl.recording.reading.run import (
    Columns,
    Commanded,
    Edges,
    Event,
    Int64Array,
    Paces,
    Readings,
    Run,
    Servo,
    Settings,
    Targets,
    Truth,
)
from deltactl.recording.reading.scan import Scan

_MOST_NS = 366 * 86400 * 10**9
"""Run time counts from the start of the run; more than a year is no run time."""
_OFTEN = 100
_LONGEST_GATE = 40
"""Characters; ours have six."""


def read_run(
    path: Path, most_bytes: int | None = None, progress: Callable[[str], None] = lambda _: None
) -> Run:
    """Read a recording up to its end, or up to where it was cut off.

    most_bytes: of a recording whose messages have more, stretches spread over all of it.
    Raises RecordingError (one line) when the file is empty, not MCAP, not a deltactl
    recording, or holds messages that contradict their schema.
    """
    scan = Scan(path, most_bytes=most_bytes)
    columns = {channel.topic: Columns(channel) for channel in CHANNELS}
    for number, chunk in enumerate(scan.chunks()):
        if number % _OFTEN == _OFTEN - 1:
            progress(f"reading {path.name}: {number + 1} chunks")
        for channel_id, payloads in chunk.items():
            channel = scan.channels.get(channel_id)
            if channel is not None and channel.topic in columns:
                _add(path, columns[channel.topic], payloads)
    return _build(scan, columns)


def configuration_in(path: Path) -> configuration.RunConfiguration:
    """What ran, from the first chunk alone. Raises RecordingError where it holds no such thing."""
    scan = Scan(path)
    for chunk in scan.chunks():
        for channel_id, payloads in chunk.items():
            if scan.channels[channel_id].topic == CONFIGURATION.topic:
                columns = Columns(CONFIGURATION)
                _add(path, columns, payloads)
                return configuration.from_message(columns.rows()[0])
        if chunk:
            break
    raise _not_ours(scan)


def _add(path: Path, columns: Columns, payloads: list[bytes]) -> None:
    try:
        columns.add(payloads)
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from error


def _build(scan: Scan, columns: dict[str, Columns]) -> Run:
    if not (known := columns[CONFIGURATION.topic].rows()):
        raise _not_ours(scan)
    try:
        return Run(
            path=scan.path,
            configuration=configuration.from_message(known[0]),
            complete=scan.complete,
            damage=tuple(scan.damage),
            targets=_targets(columns[TARGET.topic]),
            commanded=_commanded(columns[COMMANDED.topic]),
            edges=_edges(columns[EDGES.topic]),
            readings={axis: _readings(axis, columns[ch.topic]) for axis, ch in READINGS.items()},
            events=_events(columns[EVENT.topic]),
            truth=_truth(columns[TRUTH.topic]),
            servo=_servo(columns[SERVO.topic]),
            settings=_settings(columns[SETTINGS.topic]),
            paces=_paces(columns[PACE.topic]),
            share=scan.share,
        )
    except ValueError as error:
        raise RecordingError(f"{scan.path}: {error}") from error


def _not_ours(scan: Scan) -> RecordingError:
    topics = sorted(channel.topic for channel in scan.channels.values())
    if CONFIGURATION.topic in topics:
        what = "was cut off before anything was recorded"
    elif topics:
        what = f"is an MCAP file, but not a recording of deltactl (it has {', '.join(topics[:5])})"
    else:
        what = "is an MCAP file without channels"
    return RecordingError("; ".join([f"{scan.path}: {what}", *scan.damage]))


def _order(columns: Columns) -> tuple[Int64Array, Int64Array]:
    """Times in order, and how to bring the other columns into that order.

    Several threads record, so neighbours may be in the other order.
    """
    t_ns = columns.integers("t_ns")
    _check_times(t_ns)
    order = np.argsort(t_ns, kind="stable")
    return t_ns[order], order


def _check_times(t_ns: Int64Array) -> None:
    if len(t_ns) and (t_ns.min() < -_MOST_NS or t_ns.max() > _MOST_NS):
        raise ValueError("t_ns of a message is more than a year from the start of the run")


def _targets(columns: Columns) -> Targets:
    t_ns, order = _order(columns)
    position_m = columns.numbers("x_m", "y_m", "z_m")
    return Targets(
        t_ns, columns.integers("index")[order], position_m[order], columns.counts()[order]
    )


def _commanded(columns: Columns) -> Commanded:
    t_ns, order = _order(columns)
    return Commanded(t_ns, columns.counts()[order])


def _edges(columns: Columns) -> Edges:
    decoded = [messages.edges_from_message(row) for row in columns.rows()]
    # A block without edges marks counters that were set: one row in which nothing steps.
    times = [block.due_ns if len(block.due_ns) else np.array([block.start_ns]) for block in decoded]
    steps = [block.steps if len(block.steps) else np.zeros((1, 3), np.int8) for block in decoded]
    counts = [
        block.base + np.cumsum(part, axis=0, dtype=np.int64)
        for block, part in zip(decoded, steps, strict=True)
    ]
    if not decoded:
        empty = np.zeros((0, 3), dtype=np.int64)
        return Edges(np.zeros(0, dtype=np.int64), empty.astype(np.int8), empty)
    t_ns = np.concatenate(times)
    _check_times(t_ns)
    order = np.argsort(t_ns, kind="stable")
    return Edges(t_ns[order], np.concatenate(steps)[order], np.concatenate(counts)[order])


def _readings(axis: str, columns: Columns) -> Readings:
    t_ns, order = _order(columns)
    return Readings(
        axis=axis,
        t_ns=t_ns,
        distance_m=columns.numbers("distance_m")[order],
        status=columns.integers("status")[order],
        raw_status=columns.integers("raw_status")[order],
        signal_mcps=columns.numbers("signal_mcps")[order],
        ambient_mcps=columns.numbers("ambient_mcps")[order],
        sigma_m=columns.numbers("sigma_m")[order],
        stream_count=columns.integers("stream_count")[order],
        # As wide as the longest of them: one long text must not make all of them long.
        gate=np.array([gate[:_LONGEST_GATE] for gate in columns.texts("gate")], np.str_)[order],
    )


def _events(columns: Columns) -> tuple[Event, ...]:
    found = [Event(**_seen(row)) for row in columns.rows()]
    return tuple(sorted(found, key=lambda event: event.t_ns))


def _seen(row: dict[str, Any]) -> dict[str, Any]:
    """A row of somebody's recording, its texts fit to be shown."""
    return {name: printable(one) if isinstance(one, str) else one for name, one in row.items()}


def _truth(columns: Columns) -> Truth:
    t_ns, order = _order(columns)
    angles_rad = columns.numbers("theta_1_rad", "theta_2_rad", "theta_3_rad")
    return Truth(t_ns, columns.numbers("x_m", "y_m", "z_m")[order], angles_rad[order])


def _servo(columns: Columns) -> Servo:
    t_ns, order = _order(columns)
    parts = [
        columns.numbers(*(f"{stem}_{motor}_{unit}" for motor in (1, 2, 3)))[order]
        for stem, unit in OF_A_JOINT
    ]
    return Servo(t_ns, *parts)


def _settings(columns: Columns) -> Settings:
    t_ns, order = _order(columns)
    return Settings(t_ns, columns.numbers("t_pwm_s")[order])


def _paces(columns: Columns) -> Paces:
    t_ns, order = _order(columns)
    rate, goal, ramp_s = columns.numbers("rate", "goal", "ramp_s")[order].T
    return Paces(t_ns, rate, goal, ramp_s)
