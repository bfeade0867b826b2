"""The requests that the door itself answers: login, session, stop, and the files of the page."""
from __future__ import annotations

import asyncio
import json
import logging
import ssl
import time
from collections import Counter
from dataclasses import dataclass
from typing import Any, Awaitable, Callable, Dict, Optional

from aiohttp import web

from fleet_page.core.acts import RULES, ActKind, ActOutcome, WrongAct, act_of
from fleet_page.core.admissions import place_of
from fleet_page.core.rate_limits import RateLimit
from fleet_page.core.roles import LOCAL, Person, Sessions, TokenFile, TokenFileError
from fleet_page.door.connections import HEAD_WITHIN, Connection, DoorListener
from fleet_page.door.files import PageFiles
from fleet_page.door.security import HEADERS, TRANSPORT, Addresses
from fleet_page.door.stops import Stops
from fleet_page.door.worker import Worker

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

COOKIE = 'fleet_page'
LARGEST_REQUEST = 20_000
MOST_RELAYED = 150       # requests that the page's process answers at the same time, at most
MOST_OF_PERSON = 60      # the largest number of such requests of one person
HELD_BACK = 1.0          # s after which a request beyond the limits is refused
TOKENS_PERIOD = 1.0      # s between two checks of the token file
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Access:
    """The access to the page. Without tokens each user may do everything."""

    addresses: Addresses
    tokens: Optional[TokenFile] = None
    secure: bool = False


class Door:
    """The routes and sessions in front of the page's process. One event loop uses them.

    It connects many parts, so it has many attributes.
    """

    def __init__(self, access: Access, files: PageFiles, stop: Callable[[str], ActOutcome],
                 worker: Worker) -> None:
        self._access, self._files, self._worker = access, files, worker
        self._stops = Stops(stop)
        self._sessions = Sessions()
        self._headers = {**HEADERS, **(TRANSPORT if access.secure else {})}
        self._of_strangers = RateLimit(200.0, 50.0)
        self._of_persons = RateLimit(600.0, 100.0)
        self._stop_requests = RateLimit(20.0, 5.0)
        self._failures = RateLimit(5.0, 0.1)
        self._relayed: Counter[Person] = Counter()
        self._listener: Optional[DoorListener] = None
        self._watching: Optional[asyncio.Future[None]] = None
        app = web.Application(middlewares=[self._guard], client_max_size=LARGEST_REQUEST)
        app.add_routes([
            web.get('/', self._index), web.get('/page/{name}', self._file),
            web.get('/chart.js', self._chart), web.get('/api/me', self._me),
            web.post('/api/login', self._login), web.post('/api/logout', self._logout),
            web.post('/api/act', self._act), web.get('/api/{name}', self._relay),
            web.get('/metrics', self._relay)])
        self._runner = web.AppRunner(app, access_log=None, handle_signals=False)

    async def listen(self, host: str, port: int,
                     certificates: Optional[ssl.SSLContext]) -> int:
        """Begins to listen. Returns the port. Raises OSError."""
        await self._runner.setup()
        assert self._runner.server is not None  # since its setup
        self._listener = DoorListener(self._runner.server, certificates)
        port = self._listener.listen(host, port)
        if self._access.tokens is not None:
            self._watching = asyncio.ensure_future(self._watch(self._access.tokens))
        return port

    async def close(self) -> None:
        """Ends all connections."""
        if self._watching is not None:
            self._watching.cancel()
        if self._listener is not None:
            self._listener.close()
        self._stops.close()
        await self._worker.close()
        await self._runner.cleanup()

    async def _watch(self, tokens: TokenFile) -> None:
        """Checks the token file for changes, so that a person can revoke a token at once."""
        while True:
            await asyncio.sleep(TOKENS_PERIOD)
            try:
                if await asyncio.get_event_loop().run_in_executor(None, tokens.refresh):
                    _LOG.info('The tokens of the page were read again.')
            except TokenFileError as error:
                _LOG.error('The tokens of the page stay as they were: %s', error)

    # -- permission --------------------------------------------------------------------------------

    @property
    def _guard(self) -> Any:
        @web.middleware
        async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
            connection = self._connection(request)
            if connection is None:
                raise asyncio.CancelledError  # the connection ended before its request was read
            person = self._person(request)
            if self._may_ask(request, person):
                with connection.serving(person is not None):
                    answer = await self._guarded(request, handler)
            else:
                with connection.serving(False):
                    # A client with too many requests must wait: it would send even more otherwise.
                    await asyncio.sleep(HELD_BACK)
                    answer = refused(429, 'Too many requests.')
            if not answer.prepared:
                answer.headers.update({name: value for name, value in self._headers.items()
                                       if name not in answer.headers})
            return answer
        return guard

    def _connection(self, request: web.Request) -> Optional[Connection]:
        return None if self._listener is None else self._listener.by_protocol.get(request.protocol)

    def _may_ask(self, request: web.Request, person: Optional[Person]) -> bool:
        """Returns whether a request to see something is within the limits. Acts and logins (POST)
        have limits of their own.
        """
        now = time.monotonic()
        if request.method == 'POST':
            return True
        if person is None:
            return self._of_strangers.allows(_place(request), now)
        return self._of_persons.allows(person, now)

    async def _guarded(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        hosts = request.headers.getall('Host', [])
        if len(hosts) != 1 or not self._access.addresses.allow_host(hosts[0]):
            return refused(421, 'This host name is not one of the page: add it to ~names.')
        if request.method == 'POST':
            origins = request.headers.getall('Origin', [])
            if len(origins) != 1 or not self._access.addresses.allow_origin(origins[0], hosts[0]):
                return refused(403, 'The request does not come from this page.')
            if request.content_type != 'application/json':
                return refused(415, 'The request must be JSON.')
        elif request.method not in ('GET', 'HEAD'):
            return refused(405, 'GET and POST only.')
        try:
            return await handler(request)
        except web.HTTPException as error:
            return refused(error.status, error.reason or '')

    def _person(self, request: web.Request) -> Optional[Person]:
        """Returns the person of a request, found by its cookie, or by the token of a monitor."""
        if self._access.tokens is None:
            return LOCAL
        tokens = self._access.tokens.tokens
        session = request.cookies.get(COOKIE, '')
        if session:
            return self._sessions.person(session, tokens, time.time())
        kind, _, token = request.headers.get('Authorization', '').partition(' ')
        if kind == 'Bearer' and request.path == '/metrics':
            return tokens.person(token)
        return None

    async def _login(self, request: web.Request) -> web.StreamResponse:
        values = await _json_of(request)
        token = values.get('token') if isinstance(values, dict) else None
        person = None
        if self._access.tokens is not None and isinstance(token, str):
            person = self._access.tokens.tokens.person(token)
        if person is None or not isinstance(token, str):
            # Only failures count, so other people's guesses cannot block a valid token.
            if not self._failures.allows(_place(request), time.monotonic()):
                return refused(429, 'Too many attempts: wait a minute.')
            _LOG.warning('A login from %s was refused.', request.remote)
            return refused(401, 'This token is not valid.')
        _LOG.info('%s logged in from %s.', person.name, request.remote)
        answer = web.json_response(_me_values(person, True))
        answer.set_cookie(COOKIE, self._sessions.open(token, time.time()), httponly=True,
                          secure=self._access.secure, path='/')
        answer.cookies[COOKIE]['samesite'] = 'Strict'  # set_cookie of aiohttp 3.6 lacks it
        return answer

    async def _logout(self, request: web.Request) -> web.StreamResponse:
        self._sessions.close(request.cookies.get(COOKIE, ''))
        answer = web.json_response({})
        answer.del_cookie(COOKIE, path='/')
        return answer

    async def _me(self, request: web.Request) -> web.StreamResponse:
        return web.json_response(
            _me_values(self._person(request), self._access.tokens is not None))

    # -- files ------------------------------------------------------------------------------------

    async def _index(self, request: web.Request) -> web.StreamResponse:
        return self._files.answer(request, 'index.html')

    async def _file(self, request: web.Request) -> web.StreamResponse:
        return self._files.answer(request, request.match_info['name'])

    async def _chart(self, request: web.Request) -> web.StreamResponse:
        return self._files.answer(request, 'chart.js')

    # -- acts -------------------------------------------------------------------------------------

    async def _act(self, request: web.Request) -> web.StreamResponse:
        """Carries out a stop; passes all other acts on."""
        person = self._person(request)
        if person is None:
            return refused(401, 'Log in first.')
        values = await _json_of(request)
        if not (isinstance(values, dict) and values.get('act') == ActKind.STOP.value):
            return await self._passed_on(request, person, json.dumps(values).encode())
        try:
            act_of(values)
        except WrongAct as wrong:
            return refused(400, str(wrong))
        if person.role < RULES[ActKind.STOP].role:
            return refused(403, 'Your role does not allow this.')
        if not self._stop_requests.allows((_place(request), person.name), time.monotonic()):
            return refused(429, 'Too many requests: wait a moment.')
        outcome = await asyncio.shield(asyncio.ensure_future(self._stop(person)))
        return web.json_response({'ok': outcome.ok, 'text': outcome.text, 'mission': 0})

    async def _stop(self, person: Person) -> ActOutcome:
        """Stops the fleet and reports the stop, even if the browser does not wait for the answer.
        """
        asked = time.time()
        outcome = await self._stops.stop(person.name)
        _LOG.info('%s stopped the fleet: %s', person.name, outcome.text)
        self._worker.report({'person': person.name, 'time': asked, 'ok': outcome.ok,
                             'text': outcome.text})
        return outcome

    # -- other requests ---------------------------------------------------------------------------

    async def _relay(self, request: web.Request) -> web.StreamResponse:
        person = self._person(request)
        if person is None:
            if 'Authorization' in request.headers and not self._failures.allows(
                    _place(request), time.monotonic()):
                return refused(429, 'Too many wrong tokens: wait a minute.')
            return refused(401, 'Log in first.')
        return await self._passed_on(request, person, b'')

    async def _passed_on(self, request: web.Request, person: Person,
                         body: bytes) -> web.StreamResponse:
        if self._relayed[person] >= MOST_OF_PERSON or (
                sum(self._relayed.values()) >= MOST_RELAYED):
            return refused(503, 'Too many requests at the same time: close some pages.')
        self._relayed[person] += 1
        try:
            work = asyncio.ensure_future(self._worker.relay(
                request, body, person, self._headers, lambda: self._person(request) == person))
            connection = self._connection(request)
            if connection is not None:
                connection.work_with(work)
            return await work
        finally:
            self._relayed[person] -= 1
            if not self._relayed[person]:
                del self._relayed[person]


def refused(status: int, why: str) -> web.Response:
    """Returns the answer to a request that is not carried out."""
    return web.json_response({'ok': False, 'text': why}, status=status)


def _place(request: web.Request) -> str:
    return place_of(request.remote or '')


def _me_values(person: Optional[Person], has_login: bool) -> Dict[str, Any]:
    return {'name': person.name if person else None,
            'role': person.role.name.lower() if person else None, 'login': has_login}


async def _json_of(request: web.Request) -> Any:
    try:
        return json.loads(await asyncio.wait_for(request.text(), HEAD_WITHIN))
    except asyncio.TimeoutError:
        raise web.HTTPRequestTimeout(reason='The request did not come in time.') from None
    except (ValueError, LookupError, RecursionError):
        raise web.HTTPBadRequest(reason='The request is not JSON.') from None


