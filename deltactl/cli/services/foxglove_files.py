"""What `deltactl foxglove` does: convert, write the layout, or serve."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from deltactl.cli.output import say, warn
from deltactl.cli.robot.which_robot import robot_or_here
from deltactl.firmware_py.named_files import find
from deltactl.foundation.errors import RecordingError
from deltactl.foundation.extras import needs
from deltactl.foundation.plain_file import write_whole


def show_in_foxglove(
    recording: Path | None,
    out: Path | None,
    layout: Path | None,
    robot: str | None,
    host: str,
    port: int,
    socket: Path | None,
) -> None:
    """Raises MissingExtra without foxglove-sdk, RecordingError, ServiceError."""
    with needs("web,foxglove", "deltactl foxglove"):
        from deltactl.web.foxglove.convert import convert
        from deltactl.web.foxglove.live import serve_live

    if layout is not None:
        if layout.exists():
            raise RecordingError(f"{layout}: exists already; name another file")
        write_whole(layout, (files("deltactl.web.foxglove") / "layout.json").read_bytes())
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
