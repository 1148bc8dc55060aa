"""`deltactl web`: the page of the robot."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from deltactl.cli.robot.jobs import SocketOption


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    app.command()(web)
    app.command()(web_user)


def web(
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
        Path | None, typer.Option(help="Who may sign in; needed on a network (deltactl web-user).")
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
    from deltactl.cli.services.web_page import serve_page

    serve_page(
        simulate, robot, host, port, recordings, socket, users, certificate, key
    )  # fmt: skip


def web_user(
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
    deltactl web-user ada --file users.yaml
    deltactl web-user hall-screen --file users.yaml --viewer --token
    ```
    """
    from deltactl.cli.services.web_page import add_web_user

    add_web_user(name, file, viewer, token)
