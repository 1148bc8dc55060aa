"""`deltactl status sensors` and `status record`: readings, a sensor's offset, sensors alone."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from rich.live import Live
from rich.progress import track as progress
from rich.table import Table

from deltactl.cli.file_arguments import robot_or_here
from deltactl.cli.output import console, errors, millimetres, print_json, say, warn
from deltactl.drivers.ranging.calibration import calibrate_offset
from deltactl.firmware_py.controller.contract import SensorStatus
from deltactl.firmware_py.controller.sensing.ranging_loop import RangingLoop
from deltactl.firmware_py.daemon.client import Client, daemon_answers
from deltactl.firmware_py.machine import Machine, is_raspberry_pi
from deltactl.firmware_py.named_files import ROBOT_KEY, find
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.clock import ns, sleep_s
from deltactl.foundation.errors import ConfigError, RecordingError, ServiceError
from deltactl.foundation.release import own_version
from deltactl.models.robot import AXES
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.writing.writer import RunRecorder

NO_SENSORS = "its file describes no distance sensors (section 'sensors'); there is nothing to read"
EVERY_S = 0.5
WARM_UP_S = 0.5


def show_sensors(
    robot: str | None, watch: bool, calibrate: str | None, json_out: bool, socket: Path | None
) -> None:
    """Print readings once or until Ctrl-C, or calibrate one sensor (a dry run)."""
    if calibrate is not None:
        _calibrate(calibrate, robot_or_here(robot), json_out)
        return
    if robot is None and daemon_answers(socket):
        with Client(socket) as client:
            if not json_out and not client.sensors():
                raise ConfigError(f"robot '{client.status().robot}': {NO_SENSORS}")
            _show(lambda: client.sensors(), time.sleep, watch, json_out)
        return
    settings = load_robot(find(robot_or_here(robot), key=ROBOT_KEY))
    with open_machine(settings, watch) as machine:
        loop = RangingLoop(
            machine.sensors, machine.clock, settings.ranging.rate_hz, lambda reading: None
        )
        machine.sensors.start()
        machine.clock.start("ranging", loop.task())
        sleep_s(machine.clock, WARM_UP_S)
        _show(loop.status, lambda s: sleep_s(machine.clock, s), watch, json_out)


def _show(read, sleep, watch: bool, json_out: bool) -> None:  # type: ignore[no-untyped-def]
    if json_out:
        names = SensorStatus.__slots__
        print_json([{name: getattr(sensor, name) for name in names} for sensor in read()])
        return
    if not watch:
        console.print(_table(read()))
        return
    with suppress(KeyboardInterrupt), Live(_table(read()), console=console) as live:
        while True:
            sleep(EVERY_S)
            live.update(_table(read()))


def _table(sensors: tuple[SensorStatus, ...]) -> Table:
    table = Table("sensor", "distance", "age", "signal", "reading", "sensor is", box=None)
    for sensor in sensors:
        table.add_row(
            sensor.axis,
            "-" if sensor.distance_m is None else millimetres(sensor.distance_m),
            "-" if sensor.age_s is None else f"{sensor.age_s * 1e3:.0f} ms",
            "-" if sensor.signal_mcps is None else f"{sensor.signal_mcps:.1f} MCPS",
            sensor.gate,
            sensor.health,
        )
    return table


@contextmanager
def open_machine(robot: RobotFile, realtime: bool) -> Iterator[Machine]:
    """The robot on a Raspberry Pi, the simulated one elsewhere; closed afterwards.

    Raises ConfigError for a robot without sensors.
    """
    from deltactl.firmware_py.controller.build import real_machine, simulated_machine

    if robot.sensors is None:
        raise ConfigError(f"robot '{robot.name}': {NO_SENSORS}")
    if is_raspberry_pi():
        machine = real_machine(robot)
    else:
        warn("This is not a Raspberry Pi: these are simulated sensors.")
        machine = simulated_machine(robot, realtime)
    try:
        yield machine
    finally:
        machine.close()


def _calibrate(text: str, robot: str, json_out: bool) -> None:
    axis, true_distance_m = _parse(text)
    settings = load_robot(find(robot, key=ROBOT_KEY))
    before_mm = settings.ranging.offsets_mm[AXES.index(axis)]
    with open_machine(settings, realtime=False) as machine:
        machine.sensors.start()
        found = calibrate_offset(
            machine.sensors,
            machine.clock,
            axis,
            true_distance_m,
            before_mm,
            settings.ranging.rate_hz,
        )
    if json_out:
        print_json({name: getattr(found, name) for name in found.__slots__})
        return
    say(found.says())
    if found.warning:
        say(f"not to be used: {found.warning}")
        return
    place = AXES.index(axis) + 1
    value = f"{found.offset_after_mm:.2f}"
    say(f"enter {value} as number {place} of ranging.offsets_mm in {robot}")


def _parse(text: str) -> tuple[str, float]:
    """Axis and distance from text like z=0.412. Raises ConfigError."""
    match = re.fullmatch(r"([xyz])=([0-9]*\.?[0-9]+)", text.strip())
    if match is None or not 0.03 <= float(match[2]) <= 4.0:
        raise ConfigError(
            f"--calibrate {text}: must be an axis and its true distance in metres (0.03 to 4),"
            " for example z=0.412"
        )
    return match[1], float(match[2])


SLICE_S = 0.1
LONGEST_S = 24 * 3600.0


def record_sensors(out: Path, seconds: float, robot: str | None, realtime: bool) -> None:
    """Record readings for some seconds. Raises RecordingError, HardwareError, ServiceError."""
    if not 0.0 < seconds <= LONGEST_S:
        raise ConfigError(f"--seconds {seconds:g}: must lie above 0 and up to {LONGEST_S:g}")
    if daemon_answers():
        raise ServiceError(
            "the daemon owns the sensors and records every run; stop it to record sensors alone"
        )
    robot_file = find(robot_or_here(robot), key=ROBOT_KEY)
    settings = load_robot(robot_file)
    with open_machine(settings, realtime) as machine:
        machine.sensors.start()
        recorder = RunRecorder(
            out,
            RunConfiguration(
                robot_text=robot_file.read_text(encoding="utf-8"),
                job_text="",
                robot_name=settings.name,
                job_name="sensors alone",
                version=own_version(),
                simulated=machine.simulated,
            ),
            start_ns=machine.clock.now_ns(),
        )
        loop = RangingLoop(
            machine.sensors,
            machine.clock,
            settings.ranging.rate_hz,
            recorder.reading,
            lambda text: recorder.event(machine.clock.now_ns(), "sensor", text),
        )
        task = machine.clock.start("ranging", loop.task())
        end_ns = machine.clock.now_ns() + ns(seconds)
        try:
            for _ in progress(range(round(seconds / SLICE_S)), "recording", console=errors):
                sleep_s(machine.clock, SLICE_S)
            machine.clock.sleep_until_ns(end_ns)
        except KeyboardInterrupt:
            errors.print("stopped early; what was recorded is kept")
        finally:
            task.stop()
            recorder.close()
    if recorder.failed:
        raise RecordingError(f"{out}: {recorder.failed}")
    console.print(f"recording: {out}")
