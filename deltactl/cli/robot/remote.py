"""What the daemon is asked, and jobs followed to their end, also those of this process."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path

from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

from deltactl.cli.output import console, duration, errors, facts, millimetres, print_json, say, warn
from deltactl.firmware_py.controller.contract import JobResult, RobotController, Status
from deltactl.firmware_py.controller.states import State, said, way_out
from deltactl.firmware_py.daemon.client import Client
from deltactl.foundation.clock import Clock, sleep_s
from deltactl.foundation.errors import MotionError, NotReady, RecordingError

WATCH_EVERY_S = 0.5


def do(name: str, socket: Path | None) -> None:
    """One request without arguments; prints the state that followed."""
    with Client(socket) as client:
        method = {"on": client.power_on, "off": client.power_off}.get(name)
        (method or getattr(client, name))()
        status = client.status()
        state = State(status.state)
        say(f"{name}: the robot is {said(state)}; next: {way_out(state, status.simulated)}")


def home_robot(accept_unseen_deg: float, robot: Path | None, socket: Path | None) -> None:
    """Home, and say what the sensors saw."""
    with Client(socket) as client:
        seen = client.home(accept_unseen_deg, robot)
        say(f"home: the robot is {said(State(client.status().state))}; {seen.text}")
        if seen.warning:
            warn(f"warning: {seen.warning}")


def stop_robot(reason: str, socket: Path | None) -> None:
    """Emergency stop."""
    with Client(socket) as client:
        client.stop(reason)
        say(f"stopped; {way_out(State.STOPPED, client.status().simulated)}")


def show_status(watch: bool, json_out: bool, socket: Path | None) -> None:
    """Print the status once, or again and again until Ctrl-C."""
    with Client(socket) as client, suppress(KeyboardInterrupt):
        while True:
            status = client.status()
            if json_out:
                print_json(status.as_json())
            else:
                console.print(status_table(status))
            if not watch:
                return
            time.sleep(WATCH_EVERY_S)


def status_table(status: Status) -> object:
    """The status for people; lines that have nothing to say are left out."""
    job = f"{status.job}, {status.progress:.0%} done, {duration(status.seconds_left)} left"
    blind = f"for {status.blind_s or 0.0:.1f} s: the sensors do not show the arms"
    rows = [
        ("state", status.state + (f" ({status.why})" if status.why else "")),
        ("arm angles", _numbers(status.angles_rad, 57.29577951308232, "8.3f", "degrees")),
        ("platform", _numbers(status.position_m, 1e3, "8.2f", "mm")),
        ("step counts", "  ".join(f"{count:8d}" for count in status.counts)),
        ("job", job if status.job is not None else ""),
        ("planning", ", ".join(status.planning)),
        ("queue", ", ".join(status.queued)),
        ("blind", blind if status.blind_s is not None else ""),
        ("outputs", _switched(status.outputs)),
        ("inputs", _switched(status.inputs)),
        *(
            (f"sensor {one.axis}", f"{_far(one.distance_m)} ({one.gate}, {one.health})")
            for one in status.sensors
        ),
        ("recording", status.recording or ""),
        ("not recorded", status.recording_error),
        ("robot file", status.robot_file_changed),
        *(("new finding", text) for text in announced(status.robot)),
    ]
    name = f"{status.robot} (simulated)" if status.simulated else status.robot
    return facts(name, [(what, text) for what, text in rows if text])


def _numbers(values: Sequence[float] | None, scale: float, form: str, unit: str) -> str:
    return "  ".join([*(f"{value * scale:{form}}" for value in values), unit]) if values else ""


def _switched(lines: dict[str, bool]) -> str:
    return ", ".join(f"{name} {'on' if on else 'off'}" for name, on in lines.items())


def _far(distance_m: float | None) -> str:
    return "-" if distance_m is None else millimetres(distance_m)


def announced(robot: str) -> list[str]:
    """What `deltactl service check-runs` found in recordings of this folder or of the service."""
    from deltactl.fleet.checks import read_announced

    places = (Path("recordings"), Path("/var/lib/deltactl/recordings"))
    found = (mismatch for place in places for mismatch in read_announced(place))
    return [mismatch.told() for mismatch in found if mismatch.robot == robot]


Sleep = Callable[[float], None]

WATCH_S = 0.1
SHOW_AFTER_S = 0.05
"""Shortest time between two redraws of the progress [s]."""


def follow(
    controller: RobotController, job_id: int, sleep: Sleep, every_s: float, quiet: bool
) -> JobResult:
    """Wait for a job. Ctrl-C decelerates and cancels it; what was recorded is kept.

    A second Ctrl-C no longer waits for its end.
    """
    asked = False
    with _bar(quiet) as draw:
        while (result := controller.result(job_id)) is None:
            try:
                sleep(every_s)
                draw(controller.status())
            except KeyboardInterrupt:
                if asked:
                    raise
                asked = True
                warn("cancelling: the robot decelerates on the path")
                with suppress(NotReady):  # it has just ended
                    controller.cancel(job_id)
    return result


def follow_job(job_id: int | None, json_out: bool, socket: Path | None) -> None:
    """Watch a job of the daemon to its end, whoever sent it. Ctrl-C only ends the watching.

    Without a number, the one that runs, or else is next. Raises NotReady where there is none.
    """
    with Client(socket) as client:
        number = _next_job(client.status()) if job_id is None else job_id
        result = _watched(client, number, json_out)
    if json_out:
        print_json(asdict(result))
    else:
        say(f"job {number} '{result.name}': {result.outcome}")
        if result.recording:
            say(f"recording: {result.recording}")
    refuse_unless_done(result)


def _watched(client: Client, number: int, quiet: bool) -> JobResult:
    with _bar(quiet) as draw:
        try:
            while (result := client.result(number)) is None:
                time.sleep(WATCH_S)
                draw(client.status())
        except KeyboardInterrupt:
            warn(f"job {number} goes on; 'deltactl job cancel' ends it")
            raise
    return result


def _next_job(status: Status) -> int:
    for number in (status.job_id, *status.queued_ids, *status.planning_ids):
        if number is not None:
            return number
    raise NotReady("cannot follow: no job runs, waits or is planned; start one with 'deltactl run'")


def refuse_unless_done(result: JobResult) -> None:
    """Raise MotionError, or RecordingError, when a job did not end as it should."""
    if result.outcome != "done":
        why = f": {result.why}" if result.why else ""
        asked = "no heartbeat" in why and "too busy" not in why
        why += " (was this computer too busy?)" if asked else ""
        raise MotionError(f"job '{result.name}' ended as {result.outcome}{why}")
    if result.recording_error:
        raise RecordingError(f"the job ran, but not all was recorded: {result.recording_error}")


@contextmanager
def _bar(quiet: bool) -> Iterator[Callable[[Status], None]]:
    """A progress bar, and what draws a status into it."""
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}"),
        console=errors,
        disable=quiet or not errors.is_terminal,
        transient=True,
    ) as progress:
        bar = progress.add_task("starting", total=1.0, left="")
        drawn_s, paused = 0.0, ""

        def draw(status: Status) -> None:
            nonlocal drawn_s, paused
            if time.monotonic() - drawn_s > SHOW_AFTER_S:
                drawn_s = time.monotonic()
                _draw(progress, bar, status)
                why = status.why if status.state == State.PAUSED.value else ""
                if why and why != paused:
                    warn(f"the job pauses ({why}); 'deltactl job resume' goes on")
                paused = why

        yield draw


def _draw(progress: Progress, bar: object, status: Status) -> None:
    left = "" if status.seconds_left is None else f"{status.seconds_left:.0f} s of robot time left"
    job = status.job or ", ".join(status.planning)
    name = f"{status.state}: {job}" if job else status.state
    progress.update(bar, completed=status.progress, description=name, left=left)  # type: ignore[arg-type]


@contextmanager
def interrupted_between_sleeps(clock: Clock) -> Iterator[Sleep]:
    """A sleep after which Ctrl-C or SIGTERM is raised as KeyboardInterrupt, and never within it.

    On a virtual clock the robot's own loops run while the caller sleeps: an exception in one of
    them would end it, and the robot could not decelerate.
    """
    asked: list[int] = []

    def sleep(duration_s: float) -> None:
        sleep_s(clock, duration_s)
        if asked:
            asked.clear()
            raise KeyboardInterrupt

    signals = (signal.SIGINT, signal.SIGTERM)
    before = {sent: signal.signal(sent, lambda number, _: asked.append(number)) for sent in signals}
    try:
        yield sleep
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
