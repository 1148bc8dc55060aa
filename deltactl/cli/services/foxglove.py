"""`deltactl foxglove`: recordings and the live robot for Foxglove."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from deltactl.cli.robot.jobs import SocketOption


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command()(foxglove)


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
    deltactl foxglove recordings/heart.mcap -o heart-foxglove.mcap
    deltactl foxglove --layout deltactl-layout.json
    deltactl foxglove                   then open ws://127.0.0.1:8765 in Foxglove
    ```
    """
    from deltactl.cli.services.foxglove_files import show_in_foxglove

    show_in_foxglove(recording, out, layout, robot, host, port, socket)
