"""Starts the page, and with --simulate a simulated daemon beside it."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import typer

from deltactl.cli.output import say, warn
from deltactl.cli.robot.which_robot import robot_or_here
from deltactl.firmware_py.daemon.client import daemon_answers
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import ServiceError
from deltactl.foundation.extras import needs

READY_S = 60.0
LOOK_S = 0.1
END_S = 10.0


def serve_page(
    simulate: bool,
    robot: str | None,
    host: str,
    port: int,
    recordings: Path,
    socket: Path | None,
    users: Path | None,
    certificate: Path | None,
    key: Path | None,
) -> None:
    """Serve until Ctrl-C. Raises MissingExtra without NiceGUI, ServiceError without a daemon."""
    file = find(robot_or_here(robot))
    with needs("web", "the page"):
        from deltactl.web.serve import Where, serve
    here = _simulated(file, recordings, socket) if simulate else nullcontext((socket, None))
    with here as (where, as_built):
        if not simulate and not daemon_answers(where):
            warn("No daemon answers yet; the page will look for one until it comes.")
        scheme = "http" if certificate is None else "https"
        what = "the page and the robot" if simulate else "the page"
        say(f"{scheme}://{host}:{port}  (Ctrl-C ends {what})")
        work = _work(recordings)
        serve(Where(host, port, where, recordings, work, file, users, certificate, key, as_built))


def add_web_user(name: str, file: Path, viewer: bool, token: bool) -> None:
    """Ask for a password twice, or make one up, and write its hash. Raises ConfigError."""
    with needs("web", "the page"):
        from deltactl.web.access.users import add_user, new_token

    if token:
        password = new_token()
    else:
        password = typer.prompt("password", hide_input=True, confirmation_prompt=True)
    add_user(file, name, "viewer" if viewer else "operator", password)
    say(f"{name} may sign in as {'viewer' if viewer else 'operator'}; {file} holds only a hash")
    if token:
        say(f"token (shown this once): {password}")


def _work(recordings: Path) -> Path:
    """The unit's state directory, or beside the recordings."""
    state = os.environ.get("STATE_DIRECTORY", "").split(":")[0]
    return Path(state) if state else recordings.absolute() / "web"


@contextmanager
def _simulated(
    robot: Path, recordings: Path, given: Path | None
) -> Iterator[tuple[Path, Path | None]]:
    """A simulated daemon in a process of its own: its socket, and the file of what is concealed."""
    with tempfile.TemporaryDirectory(prefix="deltactl-web-") as folder:
        socket = given or Path(folder) / "d.sock"
        call = ["daemon", str(robot), "--simulate", "--socket", str(socket)]
        call += ["--recordings", str(recordings)]
        servo = load_robot(robot).drive.kind == "servo"
        as_built = None if servo else Path(folder) / "as-built.yaml"
        call += [] if as_built is None else ["--as-built", str(as_built)]
        with (Path(folder) / "daemon.log").open("wb") as log:
            daemon = subprocess.Popen(
                [sys.executable, "-P", "-m", "deltactl.cli.main", *call], stderr=log,
                start_new_session=True,
            )  # fmt: skip
        try:
            _wait_for(socket, daemon, Path(folder) / "daemon.log")
            yield socket, as_built
        finally:
            daemon.terminate()
            try:
                daemon.wait(END_S)
            except subprocess.TimeoutExpired:
                daemon.kill()


def _wait_for(socket: Path, daemon: subprocess.Popen[bytes], log: Path) -> None:
    give_up_s = time.monotonic() + READY_S
    while not _answers(socket):
        if daemon.poll() is not None or time.monotonic() > give_up_s:
            last = log.read_text(errors="replace").strip().splitlines()[-1:]
            raise ServiceError(f"the simulated daemon did not start: {''.join(last)}")
        time.sleep(LOOK_S)


def _answers(socket: Path) -> bool:
    try:
        return socket.exists() and daemon_answers(socket)
    except ServiceError:  # it is there, and still too busy to answer
        return False
