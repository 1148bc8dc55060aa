"""A recorded run with everything it had, and Foxglove's messages beside it, as a new file."""

from __future__ import annotations

from pathlib import Path

import foxglove
import numpy as np

from deltactl.firmware_py.run_report.tracking import robot_of
from deltactl.foundation.errors import RecordingError
from deltactl.models.linkage import Linkage
from deltactl.models.robot import AXES
from deltactl.recording.reading.reader import read_run
from deltactl.recording.reading.run import Run
from deltactl.web.behind.belief import Belief
from deltactl.web.foxglove.channels import RobotChannels

SCENE_HZ = 25.0
NS = 1e9


def convert(recording: Path, out: Path) -> int:
    """Write `out` (.mcap) for Foxglove; returns how many scenes it holds.

    Raises RecordingError when the recording cannot be read, or `out` exists.
    """
    run = read_run(recording)
    robot = robot_of(run)
    belief = Belief(f"{robot.name}.yaml", robot, Linkage.of(robot.geometry))
    context = foxglove.Context()
    channels = RobotChannels(belief, context)
    try:
        with foxglove.open_mcap(out, context=context):
            return _write(run, belief, channels)
    except FileExistsError:
        raise RecordingError(f"{out}: exists already; name another file") from None
    except OSError as error:
        raise RecordingError(f"{out}: cannot be written ({error.strerror or error})") from error


def _write(run: Run, belief: Belief, channels: RobotChannels) -> int:
    start_ns = run.configuration.start_epoch_ns
    times_ns = np.arange(0, run.end_ns + 1, int(NS / SCENE_HZ), dtype=np.int64)
    every = run.edges.counts_at(times_ns)
    for t_ns, counts in zip(times_ns.tolist(), every.tolist(), strict=True):
        channels.counts(start_ns + t_ns, counts)
    for t_ns, point in zip(run.targets.t_ns.tolist(), run.targets.position_m.tolist(), strict=True):
        if np.isfinite(point).all():
            channels.pose(start_ns + t_ns, "target", (point[0], point[1], point[2]))
    for axis, readings in run.readings.items():
        good = readings.where(readings.good)
        for t_ns, far_m in zip(good.t_ns.tolist(), good.distance_m.tolist(), strict=True):
            channels.range(start_ns + t_ns, axis, far_m)
    _measured(run, belief, channels, start_ns)
    for event in run.events:
        channels.event(start_ns + event.t_ns, event.kind, event.text)
    return len(times_ns)


def _measured(run: Run, belief: Belief, channels: RobotChannels, start_ns: int) -> None:
    """Positions from three good ranges, brought to the times of the first sensor."""
    sensors = belief.robot.sensors
    if sensors is None or any(axis not in run.readings for axis in AXES):
        return
    good = {axis: run.readings[axis].where(run.readings[axis].good) for axis in AXES}
    if any(len(readings.t_ns) < 2 for readings in good.values()):
        return
    t_ns = good[AXES[0]].t_ns
    ranges = np.stack([np.interp(t_ns, good[axis].t_ns, good[axis].distance_m) for axis in AXES])
    places = np.linalg.solve(sensors.axes, ranges - sensors.offsets_m[:, None]).T
    for when_ns, place in zip(t_ns.tolist(), places.tolist(), strict=True):
        channels.measured(start_ns + when_ns, (place[0], place[1], place[2]))
