"""Commands carried out by the daemon."""

from __future__ import annotations

import time
from contextlib import suppress
from datetime import datetime
from pathlib import Path

from deltactl.cli.output import console, duration, facts, millimetres, print_json, say, warn
from deltactl.firmware_py.controller.contract import Status
from deltactl.firmware_py.controller.states import State, said, way_out
from deltactl.firmware_py.daemon.client import Client

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
    """The status for people."""
    rows = [("state", status.state + (f" ({status.why})" if status.why else ""))]
    if status.angles_rad is not None:
        angles = "  ".join(f"{angle * 57.29577951308232:8.3f}" for angle in status.angles_rad)
        rows.append(("arm angles", f"{angles}  degrees"))
    if status.position_m is not None:
        place = "  ".join(f"{value * 1e3:8.2f}" for value in status.position_m)
        rows.append(("platform", f"{place}  mm"))
    rows.append(("step counts", "  ".join(f"{count:8d}" for count in status.counts)))
    if status.job is not None:
        left = duration(status.seconds_left)
        rows.append(("job", f"{status.job}, {status.progress:.0%} done, {left} left"))
    if status.planning:
        rows.append(("planning", ", ".join(status.planning)))
    if status.queued:
        rows.append(("queue", ", ".join(status.queued)))
    if status.blind_s is not None:
        rows.append(("blind", f"for {status.blind_s:.1f} s: the sensors do not show the arms"))
    for what, lines in (("outputs", status.outputs), ("inputs", status.inputs)):
        if lines:
            each = (f"{name} {'on' if on else 'off'}" for name, on in lines.items())
            rows.append((what, ", ".join(each)))
    for sensor in status.sensors:
        far = "-" if sensor.distance_m is None else millimetres(sensor.distance_m)
        rows.append((f"sensor {sensor.axis}", f"{far} ({sensor.gate}, {sensor.health})"))
    if status.recording:
        rows.append(("recording", status.recording))
    if status.recording_error:
        rows.append(("not recorded", status.recording_error))
    if status.robot_file_changed:
        rows.append(("robot file", status.robot_file_changed))
    rows += [("new mismatch", text) for text in announced(status.robot)]
    name = f"{status.robot} (simulated)" if status.simulated else status.robot
    return facts(name, rows)


def announced(robot: str) -> list[str]:
    """What `deltactl check-runs` found in the recordings of this folder or of the service."""
    from deltactl.fleet.checks import read_announced

    places = (Path("recordings"), Path("/var/lib/deltactl/recordings"))
    found = [one for place in places for one in read_announced(place) if one.robot == robot]
    return [
        f"{one.says}, since {datetime.fromtimestamp(one.since_s):%Y-%m-%d %H:%M}"
        f" (probability {one.probability:.2f})"
        for one in found
    ]
