"""Who gets a connection: so many from one address, so many in all, and none that stays silent.

A connection counts from the moment the kernel hands it over, before TLS and before uvicorn knows
of it. Where there are too many, the oldest that has asked for nothing yet makes room: silent
connections cannot keep the page, and its stop button, from somebody who opens it.
"""

from __future__ import annotations

import asyncio
import ipaddress
import socket
from collections import Counter
from typing import Any, Final

from uvicorn.protocols.http.auto import AutoHTTPProtocol

from deltactl.foundation.errors import ConfigError

MOST: Final = 400
MOST_EACH: Final = 120
"""Connections of one address. A browser keeps six and one for each open page."""
REQUEST_S: Final = 10.0
"""For the handshake of TLS and the head of the first request together, and for later heads."""
BACKLOG: Final = 128

Key = tuple[Any, ...]


class Connection(socket.socket):
    """One that was accepted. It tells the door when it is closed, whoever closes it."""

    peer: Key = ()
    door: Door | None = None

    def close(self) -> None:
        """Close it, and make its place free."""
        self._leave()
        super().close()

    def _leave(self) -> None:
        door, self.door = self.door, None
        if door is not None:
            door.left(self.peer)

    def give_up(self) -> None:
        """End it: its place is free at once, and whoever reads from it sees the end."""
        self._leave()
        try:
            self.shutdown(socket.SHUT_RDWR)
        except OSError:
            self.close()


class Door:
    """Counts connections. All of it runs in the thread of the event loop."""

    def __init__(self, most: int = MOST, each: int = MOST_EACH, request_s: float = REQUEST_S):
        self._most, self._each, self.request_s = most, each, request_s
        self._open: Counter[str] = Counter()
        self._silent: dict[Key, tuple[Connection, asyncio.TimerHandle]] = {}

    def __len__(self) -> int:
        return self._open.total()

    def enter(self, connection: Connection) -> bool:
        """Count a new connection; False where there is no place, and none can be made."""
        address = network_of(str(connection.peer[0]))
        if self._open[address] >= self._each and not self._make_room(address):
            return False
        if len(self) >= self._most and not self._make_room(None):
            return False
        timer = asyncio.get_running_loop().call_later(self.request_s, connection.give_up)
        self._silent[connection.peer] = (connection, timer)
        self._open[address] += 1
        connection.door = self
        return True

    def heard(self, peer: Key) -> None:
        """Note that a whole request has come by a connection."""
        if peer in self._silent:
            self._silent.pop(peer)[1].cancel()

    def left(self, peer: Key) -> None:
        """Note that a connection is closed."""
        self.heard(peer)
        address = network_of(str(peer[0]))
        self._open[address] -= 1
        if self._open[address] <= 0:
            del self._open[address]

    def _make_room(self, address: str | None) -> bool:
        """End the oldest that is silent, of one address or of all."""
        for peer, (connection, _) in list(self._silent.items()):
            if address in (None, network_of(str(peer[0]))):
                connection.give_up()
                return True
        return False


class Listening(socket.socket):
    """A listening socket of which every connection passes the door."""

    door: Door

    def accept(self) -> tuple[socket.socket, Any]:
        """The next connection. Raises ConnectionAbortedError, which the loop passes over."""
        accepted, peer = super().accept()
        connection = Connection(self.family, self.type, self.proto, fileno=accepted.detach())
        connection.peer = peer
        if not self.door.enter(connection):
            connection.close()
            raise ConnectionAbortedError("too many connections")
        return connection, peer


def network_of(peer: str) -> str:
    """What one computer has for certain: of IPv6 it chooses its address among 2**64."""
    try:
        address = ipaddress.ip_address(peer.split("%")[0])
    except ValueError:
        return peer
    if isinstance(address, ipaddress.IPv6Address):
        if address.ipv4_mapped is not None:
            return str(address.ipv4_mapped)
        return str(ipaddress.ip_network((address, 64), strict=False))
    return str(address)


def listen(host: str, port: int, door: Door) -> list[socket.socket]:
    """Sockets on all addresses of a name. Raises ConfigError where there can be none."""
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        each_once = dict.fromkeys((address[0], address[4]) for address in found)
        return [_listening(family, address, door) for family, address in each_once]
    except OSError as error:
        raise ConfigError(
            f"cannot serve on {host}, port {port}: {error.strerror or error}; choose others with"
            " --host and --port"
        ) from error


def _listening(family: socket.AddressFamily, address: Key, door: Door) -> Listening:
    listening = Listening(family, socket.SOCK_STREAM)
    listening.door = door
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    if family == socket.AF_INET6:
        listening.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
    try:
        listening.bind(address)
        listening.listen(BACKLOG)
    except OSError:
        listening.close()
        raise
    return listening


def protocol_of(door: Door) -> type[asyncio.Protocol]:
    """Uvicorn's protocol, which tells the door of requests, and waits only so long for each."""

    class Protocol(AutoHTTPProtocol):  # type: ignore[misc, valid-type]
        _waits: asyncio.TimerHandle | None = None
        _peer: Key = ()
        _upgraded = False

        def connection_made(self, transport: asyncio.Transport) -> None:
            self._peer = transport.get_extra_info("peername") or ("?",)
            super().connection_made(transport)

        def data_received(self, data: bytes) -> None:
            super().data_received(data)
            if self._upgraded or (self.cycle is not None and not self.cycle.response_complete):
                self._whole()
            elif self._waits is None:
                self._waits = self.loop.call_later(door.request_s, self.transport.close)

        def handle_websocket_upgrade(self, *event: Any) -> None:
            self._upgraded = True
            super().handle_websocket_upgrade(*event)

        def connection_lost(self, exc: Exception | None) -> None:
            self._whole()
            super().connection_lost(exc)

        def on_response_complete(self) -> None:
            self._whole()
            super().on_response_complete()

        def _whole(self) -> None:
            door.heard(self._peer)
            if self._waits is not None:
                self._waits.cancel()
                self._waits = None

    return Protocol
