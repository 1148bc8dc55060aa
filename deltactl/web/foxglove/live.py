"""A server for Foxglove: the daemon's status as it comes, on the usual port."""

from __future__ import annotations

import time
from pathlib import Path

import foxglove

from deltactl.firmware_py.controller.contract import Status
from deltactl.foundation.errors import ServiceError
from deltactl.web.behind.belief import Beliefs
from deltactl.web.behind.link import DaemonLink
from deltactl.web.foxglove.channels import RobotChannels

PORT = 8765
LOOK_S = 0.02
TITLE = "deltactl"


class LiveServer:
    """Hands every new status on. Raises ServiceError when the port is taken."""

    def __init__(self, link: DaemonLink, beliefs: Beliefs, host: str, port: int):
        self._link, self._beliefs = link, beliefs
        self._context = foxglove.Context()
        self._channels: dict[str, RobotChannels] = {}
        self._last, self._state = -1, ""
        try:
            self._server = foxglove.start_server(
                name=TITLE, host=host, port=port, context=self._context
            )
        except (OSError, RuntimeError) as error:
            raise ServiceError(f"cannot listen at {host}:{port}: {error}") from error

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._server.port)

    def look(self) -> bool:
        """Hand on what is new; whether there was anything."""
        seen = self._link.seen
        if seen.serial == self._last or seen.status is None:
            return False
        self._last = seen.serial
        self._send(seen.status)
        return True

    def close(self) -> None:
        """End the server."""
        self._server.stop()

    def _send(self, status: Status) -> None:
        belief = self._beliefs.of(status.robot)
        if belief is None:
            return
        if status.robot not in self._channels:
            self._channels[status.robot] = RobotChannels(belief, self._context)
        channels, now_ns = self._channels[status.robot], time.time_ns()
        channels.counts(now_ns, status.counts)
        for sensor in status.sensors:
            if sensor.distance_m is not None and sensor.gate == "good":
                channels.range(now_ns, sensor.axis, sensor.distance_m)
        if status.target_m is not None:
            channels.pose(now_ns, "target", status.target_m)
        if (measured := belief.measured(status.sensors)) is not None:
            channels.measured(now_ns, measured)
        if status.state != self._state:
            self._state = status.state
            channels.event(now_ns, status.state, f"{status.state} {status.why}".strip())


def serve_live(socket: Path | None, robot: Path, host: str, port: int) -> None:
    """Serve until Ctrl-C."""
    link = DaemonLink(socket)
    link.start()
    server = LiveServer(link, Beliefs(robot), host, port)
    try:
        while True:
            if not server.look():
                time.sleep(LOOK_S)
    except KeyboardInterrupt:
        return
    finally:
        server.close()
        link.close()
