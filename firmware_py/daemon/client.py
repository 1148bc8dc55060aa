"""The client: the calls of a controller, carried out by the daemon."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Generator
from pathlib import Path

from deltactl.firmware_py import wire_errors
from deltactl.firmware_py.controller.contract import HomeSeen, JobResult, SensorStatus, Status
from deltactl.firmware_py.daemon import protocol
from deltactl.firmware_py.daemon.line import Line, find_daemon
from deltactl.firmware_py.daemon.protocol import SLOW, Message
from deltactl.foundation.errors import MissingFile, ServiceError

QUICK_S = 5.0
SLOW_S = 600.0
"""Homing by switches and checking a long survey take minutes. A daemon that hangs is ended
by its watchdog, which ends the connection too."""


PLANNED_LOOK_S = 0.1
"""How often a job that is being planned is looked at."""


class Client:
    """Speaks to the daemon over one connection; implements RobotController.

    Any thread may call; calls wait for one another, but `stop` never waits (it takes a
    connection of its own). Raises ServiceError when no daemon answers, and whatever error
    the daemon answered with.
    """

    def __init__(
        self, path: Path | None = None, *, quick_s: float = QUICK_S, slow_s: float = SLOW_S
    ):
        self._quick_s, self._slow_s = quick_s, slow_s
        self._line = Line(path, quick_s)
        self._turn = threading.Lock()

    @property
    def path(self) -> Path:
        """The socket of the daemon that answers."""
        return self._line.path

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def power_on(self) -> None:
        """See RobotController."""
        self._ask("on")

    def power_off(self) -> None:
        """See RobotController."""
        self._ask("off")

    def home(
        self, accept_unseen_deg: float = 0.0, robot: Path | None = None, trial: bool = False
    ) -> HomeSeen:
        """See RobotController; the text of a file that the daemon cannot read is sent.

        trial: `robot` is in force until this connection ends, or until the next `home` by a file.
        """
        extra: Message = {"accept_unseen_deg": accept_unseen_deg} if accept_unseen_deg else {}
        extra |= {"trial": True} if trial else {}
        if robot is None:
            return _home_seen(self._ask("home", **extra))
        robot = robot.absolute()
        try:
            return _home_seen(self._ask("home", robot=str(robot), **extra))
        except MissingFile as error:
            if not str(error).startswith(f"{robot}:") or (text := _text_of(robot)) is None:
                raise
            return _home_seen(self._ask("home", robot_text=text, name=robot.name, **extra))

    def home_by_text(self, text: str, name: str) -> HomeSeen:
        """Home by another robot file that is no file; `name` is its name in messages."""
        return _home_seen(self._ask("home", robot_text=text, name=name))

    def submit(self, job: Path, record: Path | None = None, detach: bool = False) -> int:
        """Check and queue a job; its text is sent when the daemon cannot read the file.

        `record` is a name in the daemon's folder of recordings. The job ends with this
        connection, unless it is to `detach` from it.
        """
        job = job.absolute()
        extra: Message = {} if record is None else {"record": str(record)}
        extra |= {"detach": True} if detach else {}
        try:
            return self._submitted(job=str(job), **extra)
        except MissingFile as error:
            if not str(error).startswith(f"{job}:") or (text := _text_of(job)) is None:
                raise
            return self._submitted(job_text=text, name=str(job), **extra)

    def submit_text(self, text: str, name: str) -> int:
        """Check and queue a job that is no file; `name` is its name in messages."""
        return self._submitted(job_text=text, name=name)

    def _submitted(self, **arguments: object) -> int:
        """The job's number, once it is checked. Raises what its check refuses it with."""
        answer = self._ask("run", **arguments)
        number = _number(answer.get("job_id"))
        while answer.get("planning"):
            time.sleep(PLANNED_LOOK_S)
            answer = self._ask("result", job_id=number)
            if "error" in answer:
                raise wire_errors.as_exception(answer["error"])
        return number

    def pause(self) -> None:
        """See RobotController."""
        self._ask("pause")

    def resume(self) -> None:
        """See RobotController."""
        self._ask("resume")

    def cancel(self, job_id: int | None = None) -> None:
        """See RobotController."""
        self._ask("cancel", **({} if job_id is None else {"job_id": job_id}))

    def move(self, job_id: int, place: int) -> None:
        """See RobotController."""
        self._ask("move", job_id=job_id, place=place)

    def rename_recording(self, recording: str, name: str) -> str:
        """Give a recording in the daemon's folder another name; returns it as it is now.

        Raises RecordingError where it is being recorded, or that name is taken.
        """
        return str(self._ask("rename", recording=recording, name=name).get("recording", ""))

    def delete_recording(self, recording: str) -> None:
        """Delete one in the daemon's folder. Raises RecordingError while it is being recorded."""
        self._ask("delete", recording=recording)

    def stop(self, reason: str = "stop requested") -> None:
        """Emergency stop, past everything that is under way."""
        with contextlib.closing(Line(self.path, self._quick_s)) as line:
            line.ask({"do": "stop", "reason": reason[:200] or "stop requested"}, self._quick_s)

    def acknowledge(self) -> None:
        """See RobotController."""
        self._ask("acknowledge")

    def status(self) -> Status:
        """See RobotController."""
        return protocol.status_from(self._ask("status").get("status"))

    def sensors(self) -> tuple[SensorStatus, ...]:
        """The newest reading of each sensor."""
        return self.status().sensors

    def watch(self, rate_hz: float) -> Generator[Status, None, None]:
        """The status again and again, until the caller stops or the daemon ends."""
        with contextlib.closing(Line(self.path, self._quick_s)) as line:
            line.ask({"do": "watch", "rate_hz": rate_hz}, self._quick_s)
            while True:
                message = line.receive(time.monotonic() + self._quick_s + 1.0 / rate_hz)
                yield protocol.status_from(message.get("status"))

    def result(self, job_id: int) -> JobResult | None:
        """How a job ended; None while it waits or runs. ServiceError for one never submitted."""
        found = self._ask("result", job_id=job_id).get("result")
        return None if found is None else protocol.result_from(found)

    def log(self, after: int = 0) -> list[Message]:
        """Lines of the daemon's log behind that number: number, time_s, level, text."""
        lines = self._ask("log", after=after).get("lines")
        return list(lines) if isinstance(lines, list) else []

    def version(self) -> Message:
        """Versions of the daemon: deltactl, python, protocol."""
        answer = self._ask("version")
        return {name: value for name, value in answer.items() if name not in ("id", "ok")}

    def progress_count(self) -> int:
        """See RobotController."""
        return _number(self._ask("ping").get("progress"))

    def close(self) -> None:
        """End the connection, and with it every job that was not detached."""
        self._line.close()

    def _ask(self, do: str, **arguments: object) -> Message:
        patience_s = self._slow_s if do in SLOW else self._quick_s
        with self._turn:
            return self._line.ask({"do": do, **arguments}, patience_s)


def daemon_answers(path: Path | None = None, timeout_s: float = 1.0) -> bool:
    """Whether a daemon is there. Raises ServiceError when one is but may not be used, or hangs."""
    found = find_daemon(path, timeout_s)
    if found is None:
        return False
    place, connection = found
    connection.close()
    with Client(place, quick_s=timeout_s) as client:
        client.progress_count()
    return True


def _home_seen(answer: Message) -> HomeSeen:
    return HomeSeen(str(answer.get("seen", "")), str(answer.get("warning", "")))


def _text_of(file: Path) -> str | None:
    """The text of the file, if we can read it."""
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return None


def _number(value: object) -> int:
    if not isinstance(value, int):
        raise ServiceError("the daemon's answer holds no number; are both one version?")
    return value
