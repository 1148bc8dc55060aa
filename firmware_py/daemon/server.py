"""The server: lets clients in, a bounded number of them, and never waits for one."""

from __future__ import annotations

import errno
import logging
import select
import socket
import threading
import time
from pathlib import Path

from deltactl.firmware_py import wire_errors
from deltactl.firmware_py.controller.contract import OwnedController
from deltactl.firmware_py.daemon import protocol
from deltactl.firmware_py.daemon.actions import Actions, Note
from deltactl.firmware_py.daemon.address import Peer
from deltactl.firmware_py.daemon.command_worker import CommandWorker
from deltactl.firmware_py.daemon.connection import Connection
from deltactl.firmware_py.daemon.job_store import JobStore
from deltactl.firmware_py.daemon.limits import Limits
from deltactl.firmware_py.daemon.listener import Listener
from deltactl.firmware_py.daemon.protocol import MAX_LINE_BYTES
from deltactl.foundation.errors import ServiceError

LOOK_S = 0.2
ACCEPT_PAUSE_S = 0.002
"""At most 500 new clients a second, whoever they are."""
NO_FILES = frozenset({errno.EMFILE, errno.ENFILE})
NO_FILES_PAUSE_S = 0.05
"""After a client that could not be let in for want of file descriptors."""
STOP_COMES_S = 0.05
"""A client sends its request as soon as it is connected."""

_log = logging.getLogger(__name__)


class Server:
    """Serves a controller on a listening Unix socket, which it closes in the end.

    `jobs` is a folder for jobs that clients send as text; recordings they ask for lie in
    `recordings`; `note` writes into the event log.
    """

    def __init__(
        self,
        controller: OwnedController,
        listener: Listener,
        jobs: Path,
        recordings: Path,
        note: Note | None = None,
        limits: Limits | None = None,
    ):
        self._limits = limits or Limits()
        self._actions = Actions(
            controller, JobStore(jobs), recordings, note, self._limits.waiting_commands
        )
        self._worker = CommandWorker(self._actions, self._limits.waiting_commands)
        self._clients: set[Connection] = set()
        self._changed = threading.Lock()
        self._closing = threading.Event()
        self._listener = listener
        self._without_files = False
        """Whether clients cannot be let in for want of file descriptors; logged once each time."""
        self._accepting = threading.Thread(target=self._accept, name="accept", daemon=True)

    @property
    def path(self) -> Path:
        """Where the socket is."""
        return self._listener.path

    @property
    def alive(self) -> bool:
        """Whether clients are let in and their commands carried out."""
        return self._accepting.is_alive() and self._worker.alive

    def start(self) -> None:
        """Let clients in from now on."""
        logging.getLogger("deltactl").addHandler(self._actions.log)
        self._worker.start()
        self._accepting.start()

    def end_commands(self) -> None:
        """Start nothing any more; stop, cancel and status go on until `close`."""
        self._actions.end()

    def close(self, timeout_s: float = 2.0) -> None:
        """Cut all clients off and take the socket away."""
        self.end_commands()
        self._closing.set()
        self._listener.wake()
        if self._accepting.is_alive():
            self._accepting.join(timeout_s)
            self._worker.close(timeout_s)
        self._listener.close()
        logging.getLogger("deltactl").removeHandler(self._actions.log)
        with self._changed:
            clients = list(self._clients)
        for client in clients:
            client.close()

    def __enter__(self) -> Server:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _accept(self) -> None:
        poll = select.poll()
        poll.register(self._listener.socket, select.POLLIN)
        self._listener.socket.setblocking(False)
        while not self._closing.is_set():
            if poll.poll(LOOK_S * 1e3) and not self._closing.is_set():
                try:
                    self._let_in(self._listener.accept())
                except OSError as error:
                    self._not_let_in(error)
                else:
                    self._without_files = False
                time.sleep(ACCEPT_PAUSE_S)

    def _not_let_in(self, error: OSError) -> None:
        """Gone again already; or no file descriptors are left, which takes a while to change."""
        if error.errno not in NO_FILES:
            _log.warning("a client could not be let in: %s", error)
            return
        if not self._without_files:
            _log.error(
                "no file descriptors are left (%s); until some are, a client that connects may"
                " only stop the robot",
                error.strerror,
            )
        self._without_files = True
        try:
            with self._listener.in_reserve() as peer_socket:
                self._hear_stop(peer_socket)
        except OSError as again:
            _log.debug("nor with the one in reserve: %s", again)
        self._closing.wait(NO_FILES_PAUSE_S)

    def _hear_stop(self, peer_socket: socket.socket) -> None:
        """Carry out a stop that comes at once; whatever else is asked is refused."""
        peer = Peer.of(peer_socket)
        if not peer.may_use(self._listener.owner, self._listener.group):
            return
        peer_socket.settimeout(STOP_COMES_S)
        line = peer_socket.recv(MAX_LINE_BYTES).partition(b"\n")[0]
        try:
            request = protocol.parse(line)
        except protocol.BadRequest as error:
            answer = error.answer
        else:
            if request.do == "stop":
                self._worker.call_off(f"{peer} stopped the robot")
                answer = self._actions.perform(request, peer)
            else:
                says = ServiceError("the daemon has no file descriptors left; only 'stop' is taken")
                answer = self._actions.refuse(request, says)
        peer_socket.send(protocol.encode(answer))

    def _let_in(self, peer_socket: socket.socket) -> None:
        limits, peer = self._limits, Peer.of(peer_socket)
        if not peer.may_use(self._listener.owner, self._listener.group):
            _log.warning("%s is not in the group of the socket, and is turned away", peer)
            _turn_away(peer_socket, "you are not in the group that may use this robot")
            return
        with self._changed:
            stop_only = sum(client.stop_only for client in self._clients)
            full = len(self._clients) - stop_only >= limits.clients
            if full and stop_only >= limits.stop_only_clients:
                _turn_away(peer_socket, "too many clients are connected; close some, and try again")
                return
            client = Connection(
                peer_socket, self._actions, self._worker, limits, self._forget, stop_only=full
            )
            self._clients.add(client)
        client.start()

    def _forget(self, client: Connection) -> None:
        with self._changed:
            self._clients.discard(client)


def _turn_away(peer_socket: socket.socket, why: str) -> None:
    answer = protocol.refusal(None, wire_errors.as_message(ServiceError(why)))
    with peer_socket:
        peer_socket.setblocking(False)
        peer_socket.send(protocol.encode(answer))
