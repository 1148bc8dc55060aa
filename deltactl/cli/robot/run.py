"""`deltactl run` and `verify`: through the daemon, or on a simulated robot in this process."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

from deltactl.cli.output import NO_ROBOT, errors, print_json, say, tell, waiting, warn
from deltactl.cli.robot.check import say_covered
from deltactl.cli.robot.remote import follow, interrupted_between_sleeps, refuse_unless_done
from deltactl.cli.robot.show import show_tracking, write_report
from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.contract import JobResult, RobotController, Status
from deltactl.firmware_py.controller.sensing.verify import Verification, verify
from deltactl.firmware_py.controller.states import State
from deltactl.firmware_py.daemon.client import Client, daemon_answers
from deltactl.firmware_py.file_access import FileAccess
from deltactl.firmware_py.job_file import load_job
from deltactl.firmware_py.machine import is_raspberry_pi
from deltactl.firmware_py.named_files import JOB_KEY, ROBOT_KEY, find
from deltactl.firmware_py.program.coverage import coverage_of
from deltactl.firmware_py.program.includes import job_of, read_whole
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.errors import (
    ConfigError,
    DeltactlError,
    MotionError,
    RecordingError,
    ServiceError,
)

POLL_S = 0.1
VIRTUAL_POLL_S = 0.5
ANY_DEG = 360.0
"""Nobody can look at simulated arms, and homing puts them exactly where they count as homed."""


@dataclass(frozen=True, slots=True)
class Asked:
    """How a job is to be run, as the options of the command say."""

    robot: str | None = None
    simulate: bool = False
    realtime: bool = False
    record: Path | None = None
    report: Path | None = None
    json_out: bool = False
    socket: Path | None = None
    accept_unseen_deg: float = 0.0
    one_place: bool = False
    """The job is a single move, without a path along which errors could be shown."""
    seed: int | None = None
    """Seed of the simulated sensors' noise, instead of the robot's own."""
    detach: bool = False
    """The daemon goes on alone with it."""


def run_job(job: Path, asked: Asked) -> None:
    """Run one job and show what came of it. Raises any DeltactlError."""
    path = find(str(job), key=JOB_KEY)
    files = FileAccess()
    try:
        job_of(path, files)
    except ConfigError:
        read_whole(path, files)  # tells the mistakes of what it includes beside its own
        raise
    if asked.record is not None and asked.record.suffix != ".mcap":
        raise ConfigError(
            f"--record {asked.record}: a recording's name ends in .mcap;"
            " 'deltactl export' makes other files of it afterwards"
        )
    robot_file = None if asked.robot is None else find(asked.robot, key=ROBOT_KEY)
    if not asked.simulate and daemon_answers(asked.socket):
        _refuse_beside_daemon(asked)
        if asked.detach:
            _hand_over(path, asked.record, asked.socket, asked.json_out)
            return
        result = _through_daemon(path, asked, files)
    else:
        _say_where(asked)
        if not asked.json_out:
            say_covered(coverage_of(path, robot_file, files))
        result = _in_this_process(path, robot_file, asked, files)
    try:
        _show(result, asked)
    except (RecordingError, ConfigError) as error:
        if result.outcome == "done":
            raise
        warn(f"what was recorded cannot be shown: {error}")
    refuse_unless_done(result)


def _refuse_beside_daemon(asked: Asked) -> None:
    """Raise ConfigError for what only a robot in this process could do."""
    if asked.robot is not None:
        raise ConfigError(
            f"--robot {asked.robot}: the daemon runs a robot file of its own; 'deltactl home"
            f" --robot {asked.robot}' puts this one in its place, or use --simulate"
        )
    refuse_unseen(asked.accept_unseen_deg)
    if asked.seed is not None:
        raise ConfigError("--seed: the noise of a simulated robot; add --simulate")
    if asked.detach and asked.report is not None:
        raise ConfigError("--detach: nobody waits to write --report; use 'deltactl report'")


def refuse_unseen(accept_unseen_deg: float) -> None:
    """Raise ConfigError where arms are to be accepted unseen by a command that does not home."""
    if accept_unseen_deg:
        raise ConfigError(
            "--accept-unseen: the robot of a daemon is homed before it moves; say 'deltactl home"
            f" --accept-unseen {accept_unseen_deg:g}', then this command without"
        )


def _say_where(asked: Asked) -> None:
    """Say that the robot is simulated. Raises what a job without a daemon is refused with."""
    if asked.detach:
        raise ConfigError("--detach: needs a daemon that goes on with the job; none answers")
    if asked.simulate:
        return
    if asked.socket is not None:
        raise ServiceError(f"no daemon answers at {asked.socket}; start it, or leave --socket out")
    if is_raspberry_pi():
        raise ServiceError(
            "no daemon answers; start it with 'sudo systemctl start deltactl',"
            " or use --simulate to run the simulated robot"
        )
    if not asked.json_out:
        tell(NO_ROBOT.format("running"), errors)


def _through_daemon(path: Path, asked: Asked, files: FileAccess) -> JobResult:
    quiet = asked.json_out
    with Client(asked.socket) as client:
        with dropped_when_interrupted(), waiting("planning the job", quiet):
            number = client.submit(path.resolve(), asked.record)
        if not quiet:
            _say_what_it_accepts(path, client.status(), files)
        return follow(client, number, time.sleep, POLL_S, quiet)


def _hand_over(path: Path, record: Path | None, socket: Path | None, json_out: bool) -> None:
    with (
        Client(socket) as client,
        dropped_when_interrupted("; 'deltactl status' says whether"),
        waiting("planning the job", json_out),
    ):
        number = client.submit(path.resolve(), record, detach=True)
    if json_out:
        print_json({"job_id": number})
        return
    say(
        f"job {number} goes on alone: 'deltactl job follow {number}' watches it, 'deltactl job"
        " cancel' ends it"
    )


@contextmanager
def dropped_when_interrupted(unsure: str = "") -> Iterator[None]:
    """Ctrl-C while the daemon checks a job: it drops the job, as this connection ends."""
    try:
        yield
    except KeyboardInterrupt:
        warn(f"the daemon drops the job, as nobody waits for it{unsure}")
        raise


def _say_what_it_accepts(path: Path, status: Status, files: FileAccess) -> None:
    """What the daemon compensates, by its robot file."""
    if status.robot_file_changed:
        warn(f"what the daemon compensates cannot be said: {status.robot_file_changed}")
        return
    try:
        covered = coverage_of(path, Path(status.robot_path), files)
    except DeltactlError as error:
        warn(f"what the daemon compensates cannot be said: {error}")
        return
    say_covered(covered)


def _in_this_process(
    path: Path, robot_file: Path | None, asked: Asked, files: FileAccess
) -> JobResult:
    quiet, realtime = asked.json_out, asked.realtime
    robot = robot_file or find(job_of(path, files).robot, beside=path, key=ROBOT_KEY)
    with waiting("building the simulated robot", quiet):
        from deltactl.firmware_py.planning.prepared import Readers

        controller = build_controller(
            robot,
            simulated=True,
            realtime=realtime,
            recordings=Path("recordings"),
            seed=asked.seed,
            readers=Readers(before=files),
        )
    try:
        with waiting("homing", quiet):
            controller.power_on()
            controller.home(ANY_DEG)
        number = controller.submit(path, asked.record)
        every_s = POLL_S if realtime else VIRTUAL_POLL_S
        with interrupted_between_sleeps(controller.clock) as sleep:

            def resumed(duration_s: float) -> None:
                sleep(duration_s)
                now = controller.status()
                if now.state == State.PAUSED.value:  # nobody could say `resume` to this process
                    warn(f"the job pauses ({now.why}); the simulated robot goes on at once")
                    controller.resume()

            return follow(controller, number, resumed, every_s, quiet)
    finally:
        controller.close()


def _show(result: JobResult, asked: Asked) -> None:
    report, json_out = asked.report, asked.json_out
    recording = Path(result.recording) if result.recording else None
    tracking = show_tracking(recording, quiet=json_out or asked.one_place) if recording else {}
    if recording and report:
        write_report(recording, report)
    if json_out:
        print_json(asdict(result) | {"tracking": tracking, "report": report})
        return
    if recording:
        say(f"recording: {recording}")
    if report:
        say(f"report:    {report}")
    if result.slower:
        warn(f"warning: {result.slower}")
    if result.warning:
        warn(result.warning)


def verify_job(job: Path, simulate: bool, json_out: bool, socket: Path | None) -> None:
    """Print what was found. Raises MotionError when steps were lost."""
    path = find(str(job), key=JOB_KEY).resolve()
    robot_file = find(load_job(path).robot, beside=path, key=ROBOT_KEY)
    robot = load_robot(robot_file)
    if not simulate and daemon_answers(socket):
        with Client(socket) as client:
            if client.status().state == "off":
                client.power_on()
            found = _verify(client, robot, path, time.sleep, json_out)
    elif not simulate and is_raspberry_pi():
        raise ServiceError("no daemon answers; start it with 'sudo systemctl start deltactl'")
    else:
        if not simulate:
            tell(NO_ROBOT.format("running"), errors)
        found = _verify_simulated(robot_file, robot, path, json_out)
    if json_out:
        print_json(asdict(found) | {"lost": list(found.lost)})
    elif not found.lost:
        say(found.says())
    if found.lost:
        raise MotionError(found.says())


def _verify_simulated(robot_file: Path, robot: RobotFile, job: Path, quiet: bool) -> Verification:
    controller = build_controller(
        robot_file, simulated=True, realtime=False, recordings=Path("recordings")
    )
    try:
        with interrupted_between_sleeps(controller.clock) as sleep:
            controller.power_on()
            return _verify(controller, robot, job, sleep, quiet)
    finally:
        controller.close()


def _verify(  # type: ignore[no-untyped-def]
    controller: RobotController, robot: RobotFile, job: Path, sleep, quiet: bool
) -> Verification:
    def run(number: int) -> JobResult:
        return follow(controller, number, sleep, POLL_S, quiet)

    return verify(controller, robot, job, run, sleep)
