"""The HTTP server: server-sent events to clients, POST requests from them. It decides nothing."""
from __future__ import annotations

import asyncio
import concurrent.futures
import json
import logging
import secrets
import ssl
import time
from dataclasses import dataclass
from typing import Any, Awaitable, Callable, Dict, Optional

from aiohttp import web

from fleet_page.core.acts import RULES, Act, ActKind, Outcome, WrongAct, act_of
from fleet_page.core.history import history_csv
from fleet_page.core.metrics import CONTENT_TYPE
from fleet_page.core.page import Page
from fleet_page.core.rate_limits import RateLimit
from fleet_page.core.records import HOUR
from fleet_page.core.roles import LOCAL, Person, Role, Sessions, Tokens
from fleet_page.web.files import PageFiles
from fleet_page.web.security import HEADERS, Addresses
from graph_fleet_manager.supervision.journal_database import JournalError

Do = Callable[[Act, Person], Outcome]
"""Carries out an act of the fleet. It is called in separate threads and may take seconds."""
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

PERIOD = 0.1          # s, the shortest time between two updates to a client
SILENCE = 5.0         # s without a change after which an empty update is sent
STALLED = 30.0        # s after which a client that reads nothing is disconnected
MOST_CLIENTS = 100
MOST_CLIENTS_OF_ONE = 20
LARGEST_REQUEST = 20_000
MOST_HOURS = 24 * 90
COOKIE = 'fleet_page'
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Access:
    """The access to the page. Without tokens each user may do everything."""

    addresses: Addresses
    tokens: Optional[Tokens] = None
    secure: bool = False


class WebServer:
    """The HTTP routes, sessions and streams of one page. One event loop uses it."""

    def __init__(self, page: Page, do: Do, files: PageFiles, access: Access) -> None:
        self._page, self._do, self._files, self._access = page, do, files, access
        self._sessions = Sessions()
        self._instance = secrets.token_hex(4)
        self._requests = RateLimit(200.0, 50.0)
        self._acts = RateLimit(20.0, 5.0)
        self._stops = RateLimit(20.0, 5.0)
        self._logins = RateLimit(5.0, 0.1)
        self._all_logins = RateLimit(30.0, 1.0)
        self._clients: Dict[str, int] = {}
        # Stops have their own threads, so that a slow act cannot delay them.
        self._threads = concurrent.futures.ThreadPoolExecutor(8, 'acts')
        self._stop_threads = concurrent.futures.ThreadPoolExecutor(4, 'stops')
        self.app = web.Application(middlewares=[self._guard], client_max_size=LARGEST_REQUEST)
        self.app.add_routes([
            web.get('/', self._index), web.get('/page/{name}', self._file),
            web.get('/chart.js', self._chart), web.get('/api/me', self._me),
            web.get('/api/events', self._events), web.get('/api/site', self._site),
            web.get('/api/map.png', self._map), web.get('/api/history', self._history),
            web.get('/api/history.csv', self._history_csv), web.get('/api/replay', self._replay),
            web.get('/api/audit', self._audit), web.get('/metrics', self._metrics),
            web.post('/api/login', self._login), web.post('/api/logout', self._logout),
            web.post('/api/act', self._act)])
        self._closing = False
        self.app.on_shutdown.append(self._close)

    @property
    def clients(self) -> int:
        """The number of browsers that follow the fleet."""
        return sum(self._clients.values())

    async def _close(self, _: web.Application) -> None:
        self._closing = True
        self._threads.shutdown(wait=False)
        self._stop_threads.shutdown(wait=False)

    # -- permission --------------------------------------------------------------------------------

    @property
    def _guard(self) -> Any:
        @web.middleware
        async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
            answer = await self._guarded(request, handler)
            if not answer.prepared:
                answer.headers.update(
                    {name: value for name, value in HEADERS.items()
                     if name not in answer.headers})
            return answer
        return guard

    async def _guarded(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        hosts = request.headers.getall('Host', [])
        if len(hosts) != 1 or not self._access.addresses.allow_host(hosts[0]):
            return _refused(421, 'This host name is not one of the page: add it to ~names.')
        if request.method == 'POST':
            origins = request.headers.getall('Origin', [])
            if len(origins) != 1 or not self._access.addresses.allow_origin(origins[0], hosts[0]):
                return _refused(403, 'The request does not come from this page.')
            if request.content_type != 'application/json':
                return _refused(415, 'The request must be JSON.')
        elif request.method not in ('GET', 'HEAD'):
            return _refused(405, 'GET and POST only.')
        if request.path != '/api/act' and not self._requests.allows(
                request.remote, time.monotonic()):
            return _refused(429, 'Too many requests.')
        try:
            return await handler(request)
        except web.HTTPException as error:
            return _refused(error.status, error.reason or '')

    def _person(self, request: web.Request) -> Optional[Person]:
        if self._access.tokens is None:
            return LOCAL
        session = request.cookies.get(COOKIE, '')
        return self._sessions.person(session, time.time()) if session else None

    def _may(self, request: web.Request, role: Role) -> Person:
        """The person of the request. Raises an HTTP error for a person without that role."""
        person = self._person(request)
        if person is None:
            raise web.HTTPUnauthorized(reason='Log in first.')
        if person.role < role:
            raise web.HTTPForbidden(reason='Your role does not allow this.')
        return person

    async def _login(self, request: web.Request) -> web.StreamResponse:
        now = time.monotonic()
        if not (self._logins.allows(request.remote, now) and self._all_logins.allows('', now)):
            return _refused(429, 'Too many attempts: wait a minute.')
        values = await _json_of(request)
        token = values.get('token') if isinstance(values, dict) else None
        person = None
        if self._access.tokens is not None and isinstance(token, str):
            person = self._access.tokens.person(token)
        if person is None:
            _LOG.warning('A login from %s was refused.', request.remote)
            return _refused(401, 'This token is not valid.')
        _LOG.info('%s logged in from %s.', person.name, request.remote)
        answer = web.json_response(_me_values(person, True))
        answer.set_cookie(COOKIE, self._sessions.open(person, time.time()), httponly=True,
                          secure=self._access.secure, path='/')
        answer.cookies[COOKIE]['samesite'] = 'Strict'  # aiohttp 3.6 has no argument for it
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

    # -- views ------------------------------------------------------------------------------------

    async def _events(self, request: web.Request) -> web.StreamResponse:
        self._may(request, Role.SEE)
        address = request.remote or ''
        if self.clients >= MOST_CLIENTS or (
                self._clients.get(address, 0) >= MOST_CLIENTS_OF_ONE):
            return _refused(503, 'Too many pages follow the fleet: close some.')
        answer = web.StreamResponse(headers={
            **HEADERS, 'Content-Type': 'text/event-stream', 'X-Accel-Buffering': 'no'})
        seen = self._seen(request.headers.get('Last-Event-ID', ''))
        self._clients[address] = self._clients.get(address, 0) + 1
        try:
            await answer.prepare(request)
            await self._stream(request, answer, seen)
        except (ConnectionError, asyncio.TimeoutError):
            if request.transport is not None:
                request.transport.abort()  # else the data that it did not read would be kept
        finally:
            self._clients[address] -= 1
            if not self._clients[address]:
                del self._clients[address]
        return answer

    async def _stream(self, request: web.Request, answer: web.StreamResponse,
                      seen: int) -> None:
        """Sends the newest state, as long as the client reads and its session is valid."""
        live, told = self._page.model.live, time.monotonic()
        while not self._closing and self._person(request) is not None:
            now = time.monotonic()
            if live.revision != seen or now - told >= SILENCE:
                text = live.update(seen)
                seen, told = live.revision, now
                message = f'id: {self._instance}-{seen}\ndata: {text}\n\n'
                await asyncio.wait_for(answer.write(message.encode()), STALLED)
            await asyncio.sleep(PERIOD)

    def _seen(self, event: str) -> int:
        """The revision that a reconnecting client has; 0: it has none of this server."""
        instance, _, number = event.partition('-')
        if instance != self._instance or not number.isdecimal() or len(number) > 15:
            return 0
        return int(number)

    async def _site(self, request: web.Request) -> web.StreamResponse:
        self._may(request, Role.SEE)
        return _compressed(web.json_response(self._page.site_values()))

    async def _map(self, request: web.Request) -> web.StreamResponse:
        self._may(request, Role.SEE)
        walls = self._page.site.walls
        if walls is None:
            return _refused(404, 'There is no map.')
        return web.Response(body=walls.png, content_type='image/png')

    async def _history(self, request: web.Request) -> web.StreamResponse:
        self._may(request, Role.SEE)
        hours = _number(request, 'hours', 24, 1, MOST_HOURS)
        since = time.time() - HOUR * int(hours)
        lines, trouble = await self._missions(since)
        values = self._page.history(lines, since, time.time())
        return _compressed(web.json_response({**values, 'trouble': trouble}))

    async def _history_csv(self, request: web.Request) -> web.StreamResponse:
        self._may(request, Role.SEE)
        hours = _number(request, 'hours', 24, 1, MOST_HOURS)
        since = time.time() - HOUR * int(hours)
        lines, trouble = await self._missions(since)
        if trouble:
            return _refused(503, trouble)
        return web.Response(
            text=history_csv(lines, since), content_type='text/csv',
            headers={'Content-Disposition': 'attachment; filename="missions.csv"'})

    async def _missions(self, since: float) -> Any:
        try:
            return await asyncio.get_event_loop().run_in_executor(
                self._threads, self._page.missions, since), ''
        except JournalError as error:
            return [], str(error)

    async def _replay(self, request: web.Request) -> web.StreamResponse:
        self._may(request, Role.SEE)
        span = self._page.replay.span
        moment = None
        if 'time' in request.query:
            at = _number(request, 'time', 0.0, 0.0, 1e11)
            try:
                moment = self._page.replay.at(at)
            except OSError as error:
                return _refused(503, f'The replay cannot be read: {error}.')
        return web.json_response({'span': span, 'moment': moment})

    async def _audit(self, request: web.Request) -> web.StreamResponse:
        self._may(request, Role.OPERATE)
        return _compressed(web.json_response({'rows': self._page.records.audit(200)}))

    async def _metrics(self, request: web.Request) -> web.StreamResponse:
        if not self._is_monitor(request):
            self._may(request, Role.SEE)
        return web.Response(body=self._page.metrics(self.clients).encode(),
                            headers={'Content-Type': CONTENT_TYPE})

    def _is_monitor(self, request: web.Request) -> bool:
        """Whether the request has a valid token in its Authorization header, as of Prometheus."""
        kind, _, token = request.headers.get('Authorization', '').partition(' ')
        return (kind == 'Bearer' and self._access.tokens is not None
                and self._all_logins.allows('metrics', time.monotonic())
                and self._access.tokens.person(token) is not None)

    # -- acts -------------------------------------------------------------------------------------

    async def _act(self, request: web.Request) -> web.StreamResponse:
        person = self._person(request)
        if person is None:
            return _refused(401, 'Log in first.')
        try:
            act = act_of(await _json_of(request))
        except WrongAct as wrong:
            return _refused(400, str(wrong))
        if person.role < RULES[act.kind].role:
            return _refused(403, 'Your role does not allow this.')
        is_stop = act.kind is ActKind.STOP
        limit = self._stops if is_stop else self._acts
        if not limit.allows((request.remote, person.name), time.monotonic()):
            return _refused(429, 'Too many requests: wait a moment.')
        outcome = await asyncio.shield(self._done(person, act, is_stop))
        return web.json_response({'ok': outcome.ok, 'text': outcome.text,
                                  'mission': outcome.mission})

    async def _done(self, person: Person, act: Act, is_stop: bool) -> Outcome:
        """Carries out an act and records its outcome, even if the client does not wait for it."""
        if act.kind in (ActKind.ADD_FAVOURITE, ActKind.REMOVE_FAVOURITE):
            outcome = self._page.change_favourites(act)
        else:
            outcome = await asyncio.get_event_loop().run_in_executor(
                self._stop_threads if is_stop else self._threads, self._do, act, person)
        self._page.done(person, act, outcome, time.time())
        return outcome


async def serve(server: WebServer, host: str, port: int,
                certificates: Optional[ssl.SSLContext]) -> web.AppRunner:
    """Begins to listen. Raises OSError if the port is in use."""
    runner = web.AppRunner(server.app, access_log=None, handle_signals=False)
    await runner.setup()
    site = web.TCPSite(runner, host, port, ssl_context=certificates, shutdown_timeout=1.0)
    await site.start()
    return runner


def _me_values(person: Optional[Person], has_login: bool) -> Dict[str, Any]:
    return {'name': person.name if person else None,
            'role': person.role.name.lower() if person else None, 'login': has_login}


async def _json_of(request: web.Request) -> Any:
    try:
        return json.loads(await request.text())
    except (ValueError, LookupError, RecursionError):
        raise web.HTTPBadRequest(reason='The request is not JSON.') from None


def _number(request: web.Request, name: str, default: float, least: float,
            most: float) -> float:
    try:
        value = float(request.query.get(name, default))
    except ValueError:
        value = least - 1.0
    if not least <= value <= most:
        raise web.HTTPBadRequest(reason=f'{name} must be a number from {least:g} to {most:g}.')
    return value


def _refused(status: int, why: str) -> web.Response:
    return web.json_response({'ok': False, 'text': why}, status=status)


def _compressed(answer: web.Response) -> web.Response:
    answer.enable_compression()
    return answer
