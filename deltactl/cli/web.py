"""`deltactl web`, `web user`, `web foxglove`, `mcp`: the robot in a browser, and for assistants."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deltactl.cli.output import say, warn
from deltactl.cli.robot.jobs import SocketOption
from deltactl.foundation.errors import MissingFile, ServiceError
from deltactl.foundation.extras import needs
from deltactl.foundation.plain_file import check_fresh, write_whole

if TYPE_CHECKING:
    import subprocess

READY_S = 60.0
LOOK_S = 0.1
END_S = 10.0


def web(
    ctx: typer.Context,
    simulate: Annotated[
        bool, typer.Option("--simulate", help="With a simulated robot and a daemon of its own.")
    ] = False,
    robot: Annotated[
        str | None,
        typer.Option(
            help="Robot file, to draw and to simulate; without it, the one in this folder."
        ),
    ] = None,
    host: Annotated[str, typer.Option(help="Address to listen at.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port to listen at.")] = 8080,
    recordings: Annotated[Path, typer.Option(help="The daemon's folder of recordings.")] = Path(
        "recordings"
    ),
    users: Annotated[
        Path | None, typer.Option(help="Who may sign in; needed on a network (deltactl web user).")
    ] = None,
    certificate: Annotated[Path | None, typer.Option(help="For https: certificate (PEM).")] = None,
    key: Annotated[Path | None, typer.Option(help="For https: its private key (PEM).")] = None,
    socket: SocketOption = None,
) -> None:
    """A page of the robot for browsers: see it move, stop, run, jog, diagnose.

    ```
    deltactl web --simulate            then open http://127.0.0.1:8080
    deltactl web --recordings /var/lib/deltactl/recordings
    deltactl web --host 0.0.0.0 --users users.yaml
    ```
    """
    if ctx.invoked_subcommand is not None:
        return
    import os
    from contextlib import nullcontext

    from deltactl.cli.file_arguments import robot_or_here
    from deltactl.firmware_py.daemon.client import daemon_answers
    from deltactl.firmware_py.named_files import find

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
        state = os.environ.get("STATE_DIRECTORY", "").split(":")[0]
        work = Path(state) if state else recordings.absolute() / "web"
        serve(Where(host, port, where, recordings, work, file, users, certificate, key, as_built))


def user(
    name: Annotated[str, typer.Argument(help="Letters, digits, dots, dashes.")],
    file: Annotated[Path, typer.Option(help="File of those who may sign in.")],
    viewer: Annotated[
        bool, typer.Option("--viewer", help="May look and stop, and nothing else.")
    ] = False,
    token: Annotated[
        bool, typer.Option("--token", help="Make up a long password, and print it once.")
    ] = False,
) -> None:
    """Let somebody sign in on the page, or change their password.

    ```
    deltactl web user ada --file users.yaml
    deltactl web user hall-screen --file users.yaml --viewer --token
    ```
    """
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


def foxglove(
    recording: Annotated[
        Path | None, typer.Argument(help="A recorded run (.mcap); none to serve the live robot.")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="File to write (.mcap).")] = None,
    layout: Annotated[
        Path | None, typer.Option(help="Write the layout for Foxglove here (.json).")
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option(help="Live: robot file to draw; without it, the one in this folder."),
    ] = None,
    host: Annotated[str, typer.Option(help="Live: address to listen at.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Live: port.")] = 8765,
    socket: SocketOption = None,
) -> None:
    """The robot in Foxglove's 3D panel: a converted recording, or the live robot.

    ```
    deltactl web foxglove recordings/heart.mcap -o heart-foxglove.mcap
    deltactl web foxglove --layout deltactl-layout.json
    deltactl web foxglove    then open ws://127.0.0.1:8765 in Foxglove
    ```
    """
    from importlib.resources import files

    from deltactl.cli.file_arguments import robot_or_here
    from deltactl.firmware_py.named_files import find

    with needs("web,foxglove", "deltactl web foxglove"):
        from deltactl.web.foxglove import convert, serve_live

    if layout is not None:
        check_fresh(layout)
        write_whole(layout, (files("deltactl.web") / "foxglove_layout.json").read_bytes())
        say(f"layout: {layout} (in Foxglove: Layouts, Import from file)")
    if recording is not None:
        target = out or recording.with_suffix(".foxglove.mcap")
        scenes = convert(recording, target)
        say(f"{target}: {scenes} scenes; open it in Foxglove")
    elif layout is None:
        file = find(robot_or_here(robot))
        if host not in ("127.0.0.1", "localhost", "::1"):
            warn("Foxglove's protocol asks for no password: whoever reaches this port may look.")
        say(f"ws://{host}:{port}  (Foxglove: Open connection; Ctrl-C ends)")
        serve_live(socket, file, host, port)


@contextmanager
def _simulated(
    robot: Path, recordings: Path, given: Path | None
) -> Iterator[tuple[Path, Path | None]]:
    """A simulated daemon in a process of its own: its socket, and the file of its hidden faults."""
    import signal
    import subprocess
    import tempfile
    from functools import partial

    from deltactl.drivers.steps.pulse_main import die_with_parent
    from deltactl.firmware_py.robot_file import load_robot

    with tempfile.TemporaryDirectory(prefix="deltactl-web-") as folder:
        socket = given or Path(folder) / "d.sock"
        call = ["service", "daemon", str(robot), "--simulate", "--socket", str(socket)]
        call += ["--recordings", str(recordings)]
        servo = load_robot(robot).drive.kind == "servo"
        as_built = None if servo else Path(folder) / "as-built.yaml"
        call += [] if as_built is None else ["--as-built", str(as_built)]
        with (Path(folder) / "daemon.log").open("wb") as log:
            daemon = subprocess.Popen(
                [sys.executable, "-P", "-m", "deltactl.cli.main", *call],
                stderr=log,
                start_new_session=True,
                # It ends with the page, also where that is killed and cannot end it.
                preexec_fn=partial(die_with_parent, signal.SIGTERM),
            )
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
    import time

    give_up_s = time.monotonic() + READY_S
    while not _answers(socket):
        if daemon.poll() is not None or time.monotonic() > give_up_s:
            last = log.read_text(errors="replace").strip().splitlines()[-1:]
            raise ServiceError(f"the simulated daemon did not start: {''.join(last)}")
        time.sleep(LOOK_S)


def _answers(socket: Path) -> bool:
    from deltactl.firmware_py.daemon.client import daemon_answers

    try:
        return socket.exists() and daemon_answers(socket)
    except ServiceError:  # it is there, and still too busy to answer
        return False


BY_HAND = (
    "deltactl: mcp waits for an assistant on standard input, and is started by one; its command is"
    " 'deltactl mcp --root FOLDER' (Ctrl-C ends it)"
)


def mcp(
    root: Annotated[
        Path, typer.Option(help="The one folder whose files may be read, with those below it.")
    ] = Path(),
) -> None:
    """Let an assistant inspect and diagnose recordings (Model Context Protocol).

    It speaks over standard input and output, reads files below one folder alone, and writes and
    moves nothing.

    ```
    deltactl mcp
    deltactl mcp --root ~/recordings
    ```
    """
    with needs("mcp", "mcp"):
        from deltactl.assistants.server import serve

    if not root.is_dir():
        raise MissingFile(f"--root {root}: no such folder; give the one that holds the recordings")
    if sys.stdin.isatty():
        print(BY_HAND, file=sys.stderr)
    serve(root)
