"""What each request does: one small function each, errors turned into answers."""

from __future__ import annotations

import logging
import math
import platform
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Final

from deltactl.firmware_py import wire_errors
from deltactl.firmware_py.controller.claim import Claim, Owner
from deltactl.firmware_py.controller.contract import OwnedController, Status
from deltactl.firmware_py.controller.states import ALLOWED, State
from deltactl.firmware_py.controller.states import Request as Asked
from deltactl.firmware_py.daemon import protocol
from deltactl.firmware_py.daemon.address import Peer
from deltactl.firmware_py.daemon.job_checks import JobChecks
from deltactl.firmware_py.daemon.job_store import JobStore, check_job
from deltactl.firmware_py.daemon.log_lines import LogLines
from deltactl.firmware_py.daemon.protocol import SLOW, Message, Request
from deltactl.foundation.errors import ConfigError, DeltactlError, NotReady, ServiceError
from deltactl.foundation.release import own_version
from deltactl.recording.writing import retention
from deltactl.recording.writing.retention import confined

NOTED: Final = SLOW | {"off", "pause", "resume", "cancel", "stop", "move", "rename", "delete"}
"""These are noted with who asked."""

Note = Callable[[str], None]
_log = logging.getLogger(__name__)


class Actions:
    """Carries out requests on a controller. Any thread may call."""

    def __init__(
        self,
        controller: OwnedController,
        jobs: JobStore,
        recordings: Path,
        note: Note | None = None,
        most_waiting: int = 16,
    ):
        """most_waiting: so many accepted jobs may wait for their check."""
        self._controller = controller
        self._jobs = jobs
        self._robots = jobs.within("robots")
        self._recordings = recordings
        self._note = note or (lambda text: None)
        self._ending = threading.Event()
        self.log = LogLines()
        """What this program has logged of late."""
        self.checks = JobChecks(most_waiting)
        """Those of the jobs that `run` has accepted."""
        self._table: dict[str, Callable[[Request], Message]] = {
            "ping": self._ping,
            "version": self._version,
            "on": self._plain(controller.power_on),
            "off": self._plain(controller.power_off),
            "pause": self._plain(controller.pause),
            "resume": self._plain(controller.resume),
            "cancel": self._cancel,
            "acknowledge": self._plain(controller.acknowledge),
            "status": lambda request: {"status": self.status().as_json()},
            "sensors": self._sensors,
            "result": self._result,
            "move": self._move,
            "rename": self._rename,
            "delete": self._delete,
            "log": lambda request: {"lines": self.log.after(request.arguments.get("after", 0))},
        }

    def perform(
        self, request: Request, peer: Peer, claim: Claim | None = None, due_s: float = math.inf
    ) -> Message:
        """Carry out one request; returns its answer, whatever happens.

        `claim`: of a request that moves. `due_s`: from that moment on, of the monotonic clock, the
        check of a job is no longer waited for.
        """
        try:
            if request.do == "stop":
                return self._stop(request, peer)
            if request.do in NOTED:
                self._write_down(request, peer)
            if request.do in SLOW and self._ending.is_set():
                raise NotReady(f"cannot {request.do}: the daemon is ending; start it again first")
            claim = claim or Claim()
            claim.must_hold(request.do)
            if request.do == "home":
                answer = self._home(request, claim)
            elif request.do == "run":
                answer = self._run(request, claim, due_s)
            else:
                answer = self._table[request.do](request)
            return protocol.success(request.id, **answer)
        except DeltactlError as error:
            if request.do in NOTED:
                _log.info("%s refused: %s", request.do, str(error).partition("\n")[0][:300])
            return self.refuse(request, error)
        except Exception as error:
            _log.exception("request %s of %s failed", request.do, peer)
            return self.refuse(request, error)

    def refuse(self, request: Request, error: BaseException) -> Message:
        """The answer that a request was not carried out."""
        return protocol.refusal(request.id, wire_errors.as_message(error))

    def takes(self, request: Request) -> bool:
        """Whether the table takes a request in the state of this moment."""
        return State(self._controller.status().state) in ALLOWED[Asked(request.do)]

    def leave(self, owner: Owner) -> None:
        """A client has gone."""
        self._controller.leave(owner)

    def owes(self, owner: Owner) -> bool:
        """Whether a job of that client has not ended."""
        return self._controller.owes(owner)

    def status(self) -> Status:
        """A snapshot for streams."""
        return self._controller.status()

    def end(self) -> None:
        """From now on nothing is started; stop and status go on."""
        self._ending.set()

    def _write_down(self, request: Request, peer: Peer) -> None:
        given = (request.text(name) for name in ("job", "robot", "recording", "name", "reason"))
        named = next((text for text in given if text), "")
        text = f"{request.do}{' ' + named[:200] if named else ''} asked for by {peer}"
        _log.info("%s", text)
        self._note(text)

    def _plain(self, call: Callable[[], None]) -> Callable[[Request], Message]:
        def act(request: Request) -> Message:
            call()
            return {}

        return act

    def _stop(self, request: Request, peer: Peer) -> Message:
        """Stop first, write it down afterwards: a log may be slow."""
        self._controller.stop(request.text("reason") or "stop requested")
        self._write_down(request, peer)
        return protocol.success(request.id)

    def _home(self, request: Request, claim: Claim) -> Message:
        accepted_deg = float(request.arguments.get("accept_unseen_deg", 0.0))
        named, text = request.text("robot"), request.text("robot_text")
        trial = bool(request.arguments.get("trial"))
        if named is not None and text is not None:
            raise ConfigError("'home' takes either 'robot', a path, or 'robot_text' with a 'name'")
        if text is not None:
            name = request.text("name") or "robot.yaml"
            robot = self._robots.keep(text, name)
            with _worded(robot, name):
                seen = self._controller.home(accepted_deg, robot, claim, trial)
        else:
            file = None if named is None else check_job(named)
            seen = self._controller.home(accepted_deg, file, claim, trial)
        return {"seen": seen.text, "warning": seen.warning}

    def _run(self, request: Request, claim: Claim, due_s: float) -> Message:
        """Accept a job; its check is waited for until the answer is due."""
        record = request.text("record")
        target = confined(self._recordings, record) if record else None
        named, text = request.text("job"), request.text("job_text")
        if (named is None) == (text is None):
            raise ConfigError("'run' needs either 'job', a path, or 'job_text' with a 'name'")
        self.checks.must_have_room()
        if named is not None:
            path = check_job(named)
        else:
            named = request.text("name") or "job.yaml"
            path = self._jobs.keep(text or "", named)
            claim.name = Path(named).stem
        check = partial(self._check, path, named, target, claim)
        self._controller.accept(path, claim)
        found = self.checks.put(claim, check)
        answer: Message = {"job_id": claim.number}
        if not found.wait(due_s - time.monotonic()):
            return answer | {"planning": True}
        if found.refusal is not None:
            raise found.refusal
        return answer

    def _check(self, path: Path, name: str, record: Path | None, claim: Claim) -> None:
        """Refusals name the file as its sender does."""
        with _worded(path, name):
            self._controller.check(path, record, claim)

    def _cancel(self, request: Request) -> Message:
        self._controller.cancel(request.arguments.get("job_id"))
        return {}

    def _move(self, request: Request) -> Message:
        number, place = (request.arguments.get(name) for name in ("job_id", "place"))
        if number is None or place is None:
            raise ServiceError("'move' needs a 'job_id' and a 'place'; 1 is the next to run")
        self._controller.move(number, place)
        return {}

    def _rename(self, request: Request) -> Message:
        recording, name = request.text("recording"), request.text("name")
        if recording is None or name is None:
            raise ServiceError("'rename' needs a 'recording' and its new 'name'")
        return {"recording": retention.rename(self._recordings, recording, name).name}

    def _delete(self, request: Request) -> Message:
        if (recording := request.text("recording")) is None:
            raise ServiceError("'delete' needs a 'recording'")
        retention.delete(self._recordings, recording)
        return {}

    def _result(self, request: Request) -> Message:
        number = request.arguments.get("job_id")
        if number is None:
            raise ServiceError("the daemon knows no job None; give a 'job_id', as 'run' answered")
        check, result = self.checks.of(number), self._controller.result(number)
        answer: Message = {"result": None if result is None else asdict(result)}
        if check is not None and check.going_on:
            answer["planning"] = True
        elif check is not None and check.refusal is not None:
            answer["error"] = wire_errors.as_message(check.refusal)
        return answer

    def _sensors(self, request: Request) -> Message:
        return {"sensors": [asdict(sensor) for sensor in self.status().sensors]}

    def _ping(self, request: Request) -> Message:
        return {"progress": self._controller.progress_count()}

    def _version(self, request: Request) -> Message:
        return {
            "protocol": protocol.VERSION,
            "deltactl": own_version(),
            "python": platform.python_version(),
        }


@contextmanager
def _worded(path: Path, name: str) -> Iterator[None]:
    """Refusals speak of a text that was sent by the name that its sender gave it."""
    try:
        yield
    except DeltactlError as error:
        raise error.worded(str(error).replace(str(path), name)) from error
