"""One client: a thread that reads its requests, and one that answers.

The reader carries out nothing but a stop and an off, so these wait for nothing. Quick requests
are carried out by the writer, slow ones by the command worker. A client that hangs, floods or
sends rubbish costs its own two threads and nobody else's time. What it asked for ends with it.
"""

from __future__ import annotations

import contextlib
import logging
import queue
import select
import socket
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from deltactl.firmware_py import wire_errors
from deltactl.firmware_py.controller.claim import Claim, Owner
from deltactl.firmware_py.daemon import protocol
from deltactl.firmware_py.daemon.actions import Actions
from deltactl.firmware_py.daemon.address import Peer
from deltactl.firmware_py.daemon.command_worker import Command, CommandWorker
from deltactl.firmware_py.daemon.limits import Allowance, Limits, Lines
from deltactl.firmware_py.daemon.protocol import (
    MOVING,
    SLOW,
    BadRequest,
    Message,
    Request,
    RequestId,
)
from deltactl.foundation.errors import ServiceError

READ_BYTES = 16_384
LOOK_S = 0.25
"""How often a quiet connection looks at its clocks."""
USUAL_WATCH_HZ = 2.0

_log = logging.getLogger(__name__)


@dataclass(slots=True)
class Watch:
    """A status stream: under which id, how often, and when next."""

    id: RequestId
    period_s: float
    due_s: float


class Connection:
    """Serves one client until it goes away, breaks a limit, or `close` is called."""

    def __init__(
        self,
        peer_socket: socket.socket,
        actions: Actions,
        worker: CommandWorker,
        limits: Limits,
        on_end: Callable[[Connection], None],
        stop_only: bool = False,
    ):
        self.peer = Peer.of(peer_socket)
        self.owner = Owner()
        self.stop_only = stop_only
        self._socket = peer_socket
        self._actions, self._worker, self._limits = actions, worker, limits
        self._on_end = on_end
        self._outbox: queue.Queue[Request | Message | None] = queue.Queue(limits.waiting_answers)
        self._lines = Lines()
        self._allowance = Allowance(limits.requests_hz, limits.burst)
        self._over = 0
        """Requests over the rate so far."""
        self._pending = 0
        """Commands of this client that the worker has not answered."""
        self._count = threading.Lock()
        self._cut = threading.Event()
        self._heard_s = time.monotonic()
        self._watch: Watch | None = None
        self._reader = threading.Thread(target=self._read, name="client-read", daemon=True)
        self._writer = threading.Thread(target=self._write, name="client-write", daemon=True)
        peer_socket.setblocking(False)

    def start(self) -> None:
        """Begin to serve."""
        self._reader.start()
        self._writer.start()

    def close(self) -> None:
        """Cut the connection; both threads end."""
        self._cut.set()
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)

    # The reading thread

    def _read(self) -> None:
        with self._logged():
            while (chunk := self._receive()) is not None:
                before = self._over
                lines = self._lines.feed(chunk)
                for line in lines:
                    self._take(line)
                if not lines:
                    self._charge()
                if self._over > self._limits.refusals:
                    self._say("too many requests over the limit; the connection is closed")
                    break
                if self._over > before:
                    time.sleep(self._limits.slow_down_s)
        if self._is_gone():
            self._actions.leave(self.owner)
        self._put(None)

    def _receive(self) -> bytes | None:
        """What has come; None at the end of the connection or of patience."""
        while True:
            if self._wait(select.POLLIN, LOOK_S):
                self._heard_s = time.monotonic()
                return self._socket.recv(READ_BYTES) or None
            if (why := self._overdue()) is not None:
                self._say(why)
                return None

    def _overdue(self) -> str | None:
        quiet_s = time.monotonic() - self._heard_s
        if self._lines.half and quiet_s > self._limits.half_line_s:
            return "the end of a request did not come; a request is one whole line"
        idle_s = self._limits.stop_only_idle_s if self.stop_only else self._limits.idle_s
        if quiet_s > idle_s and self._watch is None and not self._waited_for():
            return f"nothing was asked for {idle_s:g} s; the connection is closed"
        return None

    def _take(self, line: bytes | None) -> None:
        try:
            request = protocol.parse(line)
        except BadRequest as error:
            if self._allowed(error.id):
                self._put(error.answer)
            return
        if request.do == "stop":
            self._charge()
            self._worker.call_off(f"{self.peer} stopped the robot")
            self._put(self._actions.perform(request, self.peer))
        elif self._allowed(request.id):
            if request.do == "off":
                self._put(self._switch_off(request))
            else:
                self._pass_on(request)

    def _switch_off(self, request: Request) -> Message:
        """At once, and nothing that came before it goes on, where it is taken."""
        if self._actions.takes(request):
            self._worker.call_off(f"{self.peer} switched the robot off")
        return self._actions.perform(request, self.peer)

    def _allowed(self, request_id: RequestId) -> bool:
        """Whether one more request is within the limits; refuses it otherwise."""
        if not self._charge():
            self._say(f"more than {self._limits.requests_hz:g} requests a second", request_id)
            return False
        if self.stop_only:
            self._say("too many clients; only 'stop' is taken on this connection", request_id)
            return False
        return True

    def _charge(self) -> bool:
        """Count one request; False when the client is over its rate."""
        within = self._allowance.take()
        self._over += not within
        return within

    def _pass_on(self, request: Request) -> None:
        if request.do not in SLOW:
            self._put(request)
            return
        with self._count:
            self._pending += 1
        claim = Claim(self.owner, bool(request.arguments.get("detach")))
        due_s = time.monotonic() + self._limits.answer_s
        self._worker.put(
            Command(request, self.peer, claim, due_s, self._is_gone, self._answer_slow)
        )

    # Called by the worker: must not block

    def _is_gone(self) -> bool:
        """Whether the peer has closed altogether; one that only ended its requests is there."""
        with contextlib.suppress(OSError, ValueError):
            return self._wait(0, 0.0)
        return True

    def _answer_slow(self, answer: Message) -> None:
        with self._count:
            self._pending -= 1
        self._put(answer, patience_s=0.0)

    def _say(self, text: str, request_id: RequestId = None) -> None:
        self._put(protocol.refusal(request_id, wire_errors.as_message(ServiceError(text))))

    def _put(self, item: Request | Message | None, patience_s: float | None = None) -> None:
        """Hand to the writer; a client that sends on without reading answers waits here."""
        if self._cut.is_set():  # nobody is left to answer; a stop among the rest still counts
            return
        wait_s = self._limits.send_s if patience_s is None else patience_s
        try:
            self._outbox.put(item, block=wait_s > 0.0, timeout=wait_s)
        except queue.Full:
            _log.warning("%s does not read its answers; cut off", self.peer)
            self.close()

    # The writing thread

    def _write(self) -> None:
        with self._logged():
            ended = False
            while not (self._cut.is_set() or (ended and (self._is_gone() or self._is_done()))):
                with contextlib.suppress(queue.Empty):
                    item = self._outbox.get(timeout=self._patience_s())
                    ended = ended or item is None
                    if item is not None:
                        self._send(self._answer(item))
                if not ended:
                    self._stream()
        self.close()
        self._actions.leave(self.owner)
        self._reader.join()
        self._socket.close()
        self._on_end(self)

    def _is_done(self) -> bool:
        return self._outbox.empty() and not self._waited_for()

    def _waited_for(self) -> bool:
        """Whether the client waits for an answer, or for the end of a job."""
        return bool(self._pending) or self._actions.owes(self.owner)

    def _patience_s(self) -> float:
        if self._watch is None:
            return LOOK_S
        return min(LOOK_S, max(0.001, self._watch.due_s - time.monotonic()))

    def _answer(self, item: Request | Message) -> Message:
        if isinstance(item, dict):
            return item
        if item.do == "cancel":
            return self._cancel(item)
        if item.do != "watch":
            return self._actions.perform(item, self.peer)
        rate_hz = float(item.arguments.get("rate_hz", USUAL_WATCH_HZ))
        self._watch = Watch(item.id, 1.0 / rate_hz, time.monotonic())
        return protocol.success(item.id)

    def _cancel(self, request: Request) -> Message:
        """Without a number, what came before it and has not begun is called off too."""
        every = "job_id" not in request.arguments
        why = f"{self.peer} cancelled"
        dropped = self._worker.call_off(why, MOVING) if every else 0
        answer = self._actions.perform(request, self.peer)
        return protocol.success(request.id) if dropped else answer

    def _stream(self) -> None:
        """Send the status when it is due; a late one is not made up for."""
        watch, now_s = self._watch, time.monotonic()
        if watch is not None and now_s >= watch.due_s:
            watch.due_s = max(watch.due_s + watch.period_s, now_s)
            self._send({"id": watch.id, "status": self._actions.status().as_json()})

    def _send(self, message: Message) -> None:
        """Raises TimeoutError when the client does not read."""
        left = memoryview(protocol.encode(message))
        give_up_s = time.monotonic() + self._limits.send_s
        while left:
            if not self._wait(select.POLLOUT, give_up_s - time.monotonic()):
                _log.warning("%s does not read its answers; cut off", self.peer)
                raise TimeoutError
            left = left[self._socket.send(left) :]

    # Both

    def _wait(self, events: int, timeout_s: float) -> bool:
        """Wait until the socket is ready, or broken (which reading or writing then tells)."""
        poll = select.poll()
        poll.register(self._socket, events)
        return bool(poll.poll(max(0.0, timeout_s) * 1e3))

    @contextlib.contextmanager
    def _logged(self) -> Iterator[None]:
        """A connection that breaks is everyday; anything else is a mistake of ours."""
        try:
            yield
        except OSError:
            pass
        except Exception:
            _log.exception("the connection of %s failed", self.peer)
