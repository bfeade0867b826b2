"""The HTTP port of the REST server, its clients and their limits, in one asyncio loop.

A connection from an address that is no peer is ended before a request is read. No request is
answered without the password. If a client sends too slowly, or does not read its stream, its
connection is ended; other clients are not affected.
"""
from __future__ import annotations

import asyncio
import base64
import binascii
import hmac
import json
import logging
import ssl
from typing import Any, Callable, Dict, List, Optional, Sequence, Set, cast

from aiohttp import web

from browser_guard import is_from_browser
from omron_jobs.core.rest_api import RestAnswer, RestApi, error, stream_of
from omron_jobs.core.rest_records import Record, RestRecords
from omron_jobs.core.rest_words import USER, RestType
from omron_jobs.network.job_port import Network, is_peer

LARGEST_REQUEST = 65_536    # bytes
MOST_CLIENTS = 100
MOST_STREAMS = 50
MOST_UNREAD = 2 ** 21       # bytes that may wait for a stream
REQUEST_TIME = 30.0         # s within which a request must be complete
SIGN_OF_LIFE = 10.0         # s between two comments on a stream without events
STALLED = 30.0              # s after which a client that reads nothing is disconnected
HELD_BACK = 1.0             # s of delay before the answer to a wrong password
_log = logging.getLogger(__name__)


class RestPort:
    """Listens, and connects clients to the REST server, in the loop in which `open` was called.

    on_input -- called after each request that may have changed jobs, in the loop
    """

    def __init__(self, api: RestApi, records: RestRecords, password: bytes,
                 peers: Sequence[Network], on_input: Callable[[], None]) -> None:
        self.peers = peers
        self._api, self._records, self._on_input = api, records, on_input
        self._login = USER.encode() + b':' + password
        self._connections: Dict[Any, _Connection] = {}
        self._streams: Set[_Stream] = set()
        self._listening: Optional[asyncio.AbstractServer] = None
        app = web.Application(client_max_size=LARGEST_REQUEST)
        app.router.add_route('*', '/{path:.*}', self._answer)
        self._runner = web.AppRunner(app, access_log=None, handle_signals=False)
        records.listeners.append(self._on_record)

    async def open(self, host: str, port: int, certificates: Optional[ssl.SSLContext]) -> int:
        """Begins to listen, and returns the port. `port` 0: any. Raises OSError."""
        await self._runner.setup()
        make = self._runner.server
        assert make is not None  # since its setup
        self._listening = await asyncio.get_event_loop().create_server(
            lambda: _Connection(self, cast(Any, make)()), host, port, ssl=certificates)
        return int(self._listening.sockets[0].getsockname()[1])

    def close(self) -> None:
        """Ends the port and all connections."""
        if self._listening is not None:
            self._listening.close()
        for connection in list(self._connections.values()):
            connection.end()

    # -- connections -----------------------------------------------------------------------------

    def joins(self, connection: _Connection, address: str) -> bool:
        """Adds a new connection. Returns False if it is refused."""
        if not is_peer(address, self.peers):
            _log.warning('A connection from %s is refused: it is none of the peers.', address)
            return False
        if len(self._connections) >= MOST_CLIENTS:
            _log.warning('A connection from %s is refused: %d clients are connected.', address,
                         MOST_CLIENTS)
            return False
        self._connections[connection.inner] = connection
        return True

    def leaves(self, connection: _Connection) -> None:
        """Removes a connection that has ended."""
        self._connections.pop(connection.inner, None)

    # -- requests --------------------------------------------------------------------------------

    async def _answer(self, request: web.Request) -> web.StreamResponse:
        connection = self._connections.get(request.protocol)
        if connection is None:
            raise asyncio.CancelledError  # the connection ended before its request was read
        if is_from_browser(request.headers):
            return _response(error(403, 'Web browsers are refused.'))
        if not self._is_known(request.headers.get('Authorization', '')):
            await asyncio.sleep(HELD_BACK)
            answer = _response(error(401, f'The user is {USER}, with the password of the REST '
                                          'interface (basic authentication).'))
            answer.headers['WWW-Authenticate'] = 'Basic realm="jobs"'
            return answer
        path = request.rel_url.raw_path
        if request.headers.get('Content-Encoding'):
            return _response(error(415, 'Compressed requests are not accepted.'))
        try:
            body = await request.read()
        except web.HTTPRequestEntityTooLarge:
            return _response(error(413, f'A request has at most {LARGEST_REQUEST} bytes.'))
        connection.pause_deadline()
        try:
            kind = stream_of(path) if request.method == 'GET' else None
            if kind is not None:
                return await self._stream(request, kind)
            answer = _response(self._api.answer(request.method, path, request.query, body))
            self._on_input()
            return answer
        finally:
            connection.set_deadline()

    def _is_known(self, header: str) -> bool:
        scheme, _, value = header.partition(' ')
        try:
            login = base64.b64decode(value.strip().encode('ascii'), validate=True)
        except (binascii.Error, ValueError):
            return False
        return scheme.lower() == 'basic' and hmac.compare_digest(login, self._login)

    # -- streams ---------------------------------------------------------------------------------

    async def _stream(self, request: web.Request, kind: RestType) -> web.StreamResponse:
        if len(self._streams) >= MOST_STREAMS:
            return _response(error(500, f'{MOST_STREAMS} streams are open.'))
        response = web.StreamResponse(headers={'Content-Type': 'text/event-stream',
                                               'Cache-Control': 'no-store'})
        stream = _Stream(kind)
        self._streams.add(stream)
        try:
            await response.prepare(request)
            while True:
                data = await stream.next()
                await asyncio.wait_for(response.write(data), STALLED)
        except ConnectionError:
            pass  # the client has ended it
        except (asyncio.TimeoutError, _TooSlow):
            _log.warning('A client does not read its stream: its connection is ended.')
            if request.transport is not None:
                request.transport.abort()
        finally:
            self._streams.discard(stream)
        return response

    def _on_record(self, kind: RestType, record: Record) -> None:
        for stream in self._streams:
            if stream.kind is kind:
                stream.put(b'data: ' + json.dumps(record).encode() + b'\n\n')


def _response(answer: RestAnswer) -> web.Response:
    return web.Response(status=answer.status, body=json.dumps(answer.body).encode(),
                        content_type='application/json', headers={'Cache-Control': 'no-store'})


class _TooSlow(Exception):
    """A client reads its stream more slowly than records change."""


class _Stream:
    """The events that wait to be sent on one stream."""

    def __init__(self, kind: RestType) -> None:
        self.kind = kind
        self._waiting: List[bytes] = [b': begins\n\n']
        self._size = 0
        self._has_data = asyncio.Event()
        self._has_data.set()

    def put(self, data: bytes) -> None:
        """Queues an event. If too many bytes wait, the event is dropped, and the stream ends."""
        self._size += len(data)
        if self._size <= MOST_UNREAD:
            self._waiting.append(data)
        self._has_data.set()

    async def next(self) -> bytes:
        """Waits for events and returns them; returns a comment if none comes. Raises _TooSlow."""
        try:
            await asyncio.wait_for(self._has_data.wait(), SIGN_OF_LIFE)
        except asyncio.TimeoutError:
            return b':\n\n'
        if self._size > MOST_UNREAD:
            raise _TooSlow
        data = b''.join(self._waiting)
        self._waiting, self._size = [], 0
        self._has_data.clear()
        return data


class _Connection(asyncio.Protocol):
    """One connection: passes its bytes to aiohttp's protocol; ends if no request comes in time."""

    def __init__(self, port: RestPort, inner: Any) -> None:
        self.inner = inner
        self._port = port
        self._transport: Optional[asyncio.Transport] = None
        self._deadline: Optional[asyncio.TimerHandle] = None
        self._is_let_in = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Accepts the connection if its address is one of the `peers` and there is room for one
        more client. Otherwise aborts the connection.
        """
        self._transport = cast(asyncio.Transport, transport)
        peer = transport.get_extra_info('peername')
        self._is_let_in = bool(peer) and self._port.joins(self, peer[0])
        if not self._is_let_in:
            self._transport.abort()
            return
        self.set_deadline()
        self.inner.connection_made(transport)

    def data_received(self, data: bytes) -> None:
        """Passes bytes of a request."""
        if self._is_let_in:
            self.inner.data_received(data)

    def eof_received(self) -> None:
        """Notes that the other side sends no more data, so that the connection ends."""
        if self._is_let_in:
            self.inner.eof_received()

    def connection_lost(self, exc: Optional[Exception]) -> None:
        """Notes that the connection has ended."""
        self.pause_deadline()
        self._port.leaves(self)
        if self._is_let_in:
            self.inner.connection_lost(exc)

    def pause_writing(self) -> None:
        """Notes that the other side reads slowly."""
        self.inner.pause_writing()

    def resume_writing(self) -> None:
        """Notes that the other side has read."""
        self.inner.resume_writing()

    def set_deadline(self) -> None:
        """Starts the time limit for the next request. After this time the connection ends."""
        self.pause_deadline()
        self._deadline = asyncio.get_event_loop().call_later(REQUEST_TIME, self.end)

    def pause_deadline(self) -> None:
        """Stops the time limit, because a request is there."""
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def end(self) -> None:
        """Ends the connection at once."""
        if self._transport is not None:
            self._transport.abort()
