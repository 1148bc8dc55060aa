"""`deltactl web`: the page of the robot."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from command_line.jobs import SocketOption


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    app.command()(web)


def web(
    simulate: Annotated[
        bool, typer.Option("--simulate", help="With a simulated robot and a daemon of its own.")
    ] = False,
    robot: Annotated[
        str, typer.Option(help="Robot file, to draw and to simulate.")
    ] = "zhao-2023.yaml",
    host: Annotated[str, typer.Option(help="Address to listen at.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port to listen at.")] = 8080,
    recordings: Annotated[Path, typer.Option(help="The daemon's folder of recordings.")] = Path(
        "recordings"
    ),
    socket: SocketOption = None,
) -> None:
    """A page of the robot for browsers: see it move, stop, run, jog, diagnose.

    ```
    deltactl web --simulate            then open http://127.0.0.1:8080
    deltactl web --recordings /var/lib/deltactl/recordings
    ```
    """
    from command_line.web_page import serve_page

    serve_page(simulate, robot, host, port, recordings, socket)
