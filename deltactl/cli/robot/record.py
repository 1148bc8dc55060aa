"""`deltactl record`: the sensors alone, while somebody or something else moves the platform."""

from __future__ import annotations

from pathlib import Path

from rich.progress import track as progress

from deltactl.cli.output import console, errors
from deltactl.cli.robot.sensors import open_machine
from deltactl.cli.robot.which_robot import robot_or_here
from deltactl.firmware_py.controller.jobs.active_job import software_version
from deltactl.firmware_py.controller.sensing.ranging_loop import RangingLoop
from deltactl.firmware_py.daemon.client import daemon_answers
from deltactl.firmware_py.named_files import ROBOT_KEY, find
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.clock import ns, sleep_s
from deltactl.foundation.errors import ConfigError, RecordingError, ServiceError
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.writing.writer import RunRecorder

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
                version=software_version(),
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
