"""The TCP port of the job server and its clients, in one asyncio loop.

A connection from an address that is no peer is ended before a byte of it is read. If a client does
not read its lines, or does not log in, its connection is ended; other clients are not affected.
"""
from __future__ import annotations

import asyncio
import ipaddress
import logging
from typing import Callable, List, Optional, Sequence, Set, Tuple, Union, cast

from browser_guard import is_http_request
from omron_jobs.core.client_session import MOST_UNREAD, ClientPhase, ClientSession, JobServer

MOST_CLIENTS = 100
LOGIN_TIME = 30.0       # s in which a client must log in
Network = Union[ipaddress.IPv4Network, ipaddress.IPv6Network]
_log = logging.getLogger(__name__)


class WrongPeer(ValueError):
    """A word is neither an address nor a network. The text is a clause that says so."""


def read_peers(text: str) -> Tuple[Network, ...]:
    """Returns addresses and networks, separated by commas or blanks. Raises WrongPeer."""
    found: List[Network] = []
    for word in text.replace(',', ' ').split():
        try:
            found.append(ipaddress.ip_network(word))
        except ValueError as error:
            raise WrongPeer(f'"{word}" is neither an address nor a network: {error}') from None
    return tuple(found)


def is_peer(address: str, peers: Sequence[Network]) -> bool:
    """Returns whether an address is in one of the networks. Loopback is always a peer."""
    found = ipaddress.ip_address(address.partition('%')[0])
    plain = getattr(found, 'ipv4_mapped', None) or found
    return plain.is_loopback or any(plain in network for network in peers)


class JobPort:
    """Listens, and connects clients to a server, in the loop in which `open` was called.

    on_input -- called after each input of a client was handled, in the loop
    """

    def __init__(self, server: JobServer, peers: Sequence[Network],
                 on_input: Callable[[], None]) -> None:
        self.server, self.peers, self.on_input = server, peers, on_input
        self._clients: Set[_Client] = set()
        self._listening: Optional[asyncio.AbstractServer] = None

    async def open(self, host: str, port: int) -> int:
        """Begins to listen, and returns the port. `port` 0: any. Raises OSError."""
        self._listening = await asyncio.get_running_loop().create_server(
            lambda: _Client(self), host, port)
        return int(self._listening.sockets[0].getsockname()[1])

    def dialled(self, ended: asyncio.Future[None]) -> DialledClient:
        """Returns the protocol for a connection that this server opens.

        When the connection ends, the protocol sets `ended`.
        """
        return DialledClient(self, ended)

    def flush(self) -> None:
        """Sends the queued bytes of all sessions."""
        for client in list(self._clients):
            client.flush()

    def close(self) -> None:
        """Sends a farewell to all clients, and ends their connections and the port."""
        if self._listening is not None:
            self._listening.close()
        self.server.shut_down()
        self.flush()

    def joins(self, client: _Client, address: str) -> bool:
        """Adds a new connection. Returns False if it is refused."""
        if not is_peer(address, self.peers):
            _log.warning('A connection from %s is refused: it is none of the peers.', address)
            return False
        if len(self._clients) >= MOST_CLIENTS:
            _log.warning('A connection from %s is refused: %d clients are connected.', address,
                         MOST_CLIENTS)
            return False
        self.join(client)
        return True

    def join(self, client: _Client) -> None:
        """Adds a connection."""
        self._clients.add(client)

    def leaves(self, client: _Client) -> None:
        """Removes a connection that has ended."""
        self._clients.discard(client)


class _Client(asyncio.Protocol):
    """One connection."""

    def __init__(self, port: JobPort) -> None:
        self._port = port
        self._session: Optional[ClientSession] = None
        self._transport: Optional[asyncio.Transport] = None
        self._deadline: Optional[asyncio.TimerHandle] = None
        self._is_first = True

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begins a session if the port accepts the connection."""
        self._transport = cast(asyncio.Transport, transport)
        peer = transport.get_extra_info('peername')
        if not peer or not self._port.joins(self, peer[0]):
            self._transport.abort()
            return
        self._session = self._port.server.connect()
        self._deadline = asyncio.get_running_loop().call_later(LOGIN_TIME, self._end_login)
        self.flush()

    def data_received(self, data: bytes) -> None:
        """Hands bytes to the session."""
        if self._session is None or self._transport is None:
            return
        if self._is_first and is_http_request(data.partition(b'\n')[0]):
            self._transport.abort()
            return
        self._is_first = False
        self._session.receive(data)
        self._port.on_input()
        self._port.flush()

    def connection_lost(self, exc: Optional[Exception]) -> None:
        """Ends the session."""
        self._port.leaves(self)
        if self._deadline is not None:
            self._deadline.cancel()
        if self._session is not None:
            self._session.close()

    def flush(self) -> None:
        """Sends the queued bytes of the session; ends it if too many bytes are unread."""
        session, transport = self._session, self._transport
        if session is None or transport is None or transport.is_closing():
            return
        if session.output:
            transport.write(bytes(session.output))
            session.output.clear()
        if transport.get_write_buffer_size() > MOST_UNREAD:
            _log.warning('A client does not read what it is sent: its connection is ended.')
            session.close()
            transport.abort()
        elif session.phase is ClientPhase.CLOSED:
            transport.close()

    def _end_login(self) -> None:
        if self._session is not None and self._session.phase is ClientPhase.LOGIN:
            self._session.close()
            self.flush()


class DialledClient(_Client):
    """A connection that this server has opened. The program at its other end need not log in."""

    def __init__(self, port: JobPort, ended: asyncio.Future[None]) -> None:
        super().__init__(port)
        self._ended = ended

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begins a session."""
        self._transport = cast(asyncio.Transport, transport)
        self._port.join(self)
        self._session = self._port.server.connect(ClientPhase.OPEN)

    def connection_lost(self, exc: Optional[Exception]) -> None:
        """Ends the session."""
        super().connection_lost(exc)
        if not self._ended.done():
            self._ended.set_result(None)

    def carry_out(self, line: str) -> None:
        """Carries out a line as if the program had sent it."""
        if self._session is not None and self._session.phase is ClientPhase.OPEN:
            self._port.server.carry_out(self._session, line)
            self._port.on_input()
            self._port.flush()
