"""The server of the page's process, behind the door: events, site, history and acts.

The door has checked the person, and names the person in two headers. This server checks only the
role.
"""
from __future__ import annotations

import asyncio
import concurrent.futures
import secrets
import time
from collections import Counter
from typing import Any, Awaitable, Callable, FrozenSet, List, Tuple

from aiohttp import web

from fleet_core.supervision.history import HistoryLine
from fleet_core.supervision.journal_database import JournalError
from fleet_page.core.acts import RULES, Act, ActKind, ActOutcome, WrongAct, act_of
from fleet_page.core.history import history_csv, history_values
from fleet_page.core.layers import LASER, LAYERS, ShownLayers
from fleet_page.core.metrics import CONTENT_TYPE
from fleet_page.core.page import NAMED, Page
from fleet_page.core.rate_limits import RateLimit
from fleet_page.core.records import HOUR
from fleet_page.core.roles import Person, UserRole
from fleet_page.door.door import LARGEST_REQUEST, refused
from fleet_page.door.worker import PERSON, ROLE, STOPPED
from fleet_page.web.finished import Finished, WebAnswer, json_bytes

Do = Callable[[Act, Person], ActOutcome]
"""Carries out an act of the fleet. It is called in separate threads and may take seconds."""
Watch = Callable[[FrozenSet[str]], None]
"""Gets the sources that the node must receive for the shown layers (ShownLayers.sources)."""
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

PERIOD = 0.1          # s, the shortest time between two updates to a client
SILENCE = 5.0         # s without a change after which an empty update is sent
STALLED = 30.0        # s after which a client that does not read is disconnected
MOST_CLIENTS = 100
MOST_CLIENTS_OF_ONE = 40
KEPT_FOR_OPERATORS = 20  # number of clients for which the role `see` leaves room
FRESH = 2.0           # s for which an answer from the journal is used again
MOST_HOURS = 24 * 90
MOST_SOURCES = 10     # largest number of sources (lasers, allocations) received at the same time


class WebServer:
    """The routes and streams of one page. One event loop uses them.

    The attributes are used by more than one route: page, clients, finished answers and limits.
    """

    def __init__(self, page: Page, do: Do, watch: Watch = lambda sources: None) -> None:
        self._page, self._do, self._watch = page, do, watch
        self._sources: Counter[str] = Counter()
        self._instance = secrets.token_hex(4)
        self._acts = RateLimit(30.0, 5.0)
        self._clients: Counter[Person] = Counter()
        self._threads = concurrent.futures.ThreadPoolExecutor(8, 'acts')
        self._finished = Finished()
        self.app = web.Application(middlewares=[self._guard], client_max_size=LARGEST_REQUEST)
        self.app.add_routes([
            web.get('/api/events', self._events), web.get('/api/site', self._site),
            web.get('/api/map.png', self._map), web.get('/api/history', self._history),
            web.get('/api/history.csv', self._history_csv), web.get('/api/replay', self._replay),
            web.get('/api/robot', self._robot), web.get('/api/fences', self._fences),
            web.get('/api/audit', self._audit),
            web.get('/metrics', self._metrics), web.post('/api/act', self._act),
            web.post(STOPPED, self._stopped)])
        self._closing = False
        self.app.on_shutdown.append(self._close)

    @property
    def clients(self) -> int:
        """The number of browsers that follow the fleet."""
        return sum(self._clients.values())

    async def _close(self, _: web.Application) -> None:
        self._closing = True
        self._threads.shutdown(wait=False)
        self._finished.close()

    # -- permission --------------------------------------------------------------------------------

    @property
    def _guard(self) -> Any:
        @web.middleware
        async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
            try:
                return await handler(request)
            except web.HTTPException as error:
                return refused(error.status, error.reason or '')
        return guard

    def _may(self, request: web.Request, role: UserRole) -> Person:
        """Returns the person of the request. Raises an HTTP error if the role is too low."""
        person = _person(request)
        if person.role < role:
            raise web.HTTPForbidden(reason='Your role does not allow this.')
        return person

    # -- views ------------------------------------------------------------------------------------

    async def _events(self, request: web.Request) -> web.StreamResponse:
        person = self._may(request, UserRole.SEE)
        kept = 0 if person.role > UserRole.SEE else KEPT_FOR_OPERATORS
        if self.clients >= MOST_CLIENTS - kept or self._clients[person] >= MOST_CLIENTS_OF_ONE:
            return refused(503, 'Too many pages follow the fleet: close some.')
        answer = web.StreamResponse(headers={
            'Cache-Control': 'no-store', 'Content-Type': 'text/event-stream',
            'X-Accel-Buffering': 'no'})
        seen = self._seen(request.headers.get('Last-Event-ID', ''))
        layers = self._layers(request)
        self._clients[person] += 1
        self._count_sources(layers, 1)
        try:
            await answer.prepare(request)
            await self._stream(request, answer, seen, layers)
        except (ConnectionError, asyncio.TimeoutError):
            if request.transport is not None:
                request.transport.abort()  # otherwise the data that it did not read would be kept
        finally:
            self._clients[person] -= 1
            self._count_sources(layers, -1)
        return answer

    def _layers(self, request: web.Request) -> ShownLayers:
        """Returns the layers that a request names; if it has no field `layers`, only the plan."""
        if 'layers' not in request.query:
            return ShownLayers()
        names = frozenset(request.query['layers'].split(',')) & frozenset(LAYERS) - {LASER}
        robot = request.query.get('laser', '')
        return ShownLayers(names, robot if robot in self._page.model.robots else '')

    def _count_sources(self, layers: ShownLayers, step: int) -> None:
        for source in layers.sources:
            self._sources[source] += step
            if not self._sources[source]:
                del self._sources[source]
        self._watch(frozenset(list(self._sources)[:MOST_SOURCES]))

    async def _stream(self, request: web.Request, answer: web.StreamResponse, seen: int,
                      layers: ShownLayers) -> None:
        """Sends the newest state until the door ends the connection, e.g. with the session."""
        live, told = self._page.model.live, time.monotonic()
        while not self._closing and request.transport is not None:
            now = time.monotonic()
            text = live.update(seen, layers) if live.revision != seen else ''
            seen = live.revision
            if text or now - told >= SILENCE:
                text, told = text or live.nothing_new(), now
                message = f'id: {self._instance}-{seen}\ndata: {text}\n\n'
                await asyncio.wait_for(answer.write(message.encode()), STALLED)
            await asyncio.sleep(PERIOD)

    def _seen(self, event: str) -> int:
        """Returns the revision that a client had before it connected again; 0: it had none.
        """
        instance, _, number = event.partition('-')
        if instance != self._instance or not number.isdecimal() or len(number) > 15:
            return 0
        return int(number)

    async def _site(self, request: web.Request) -> web.StreamResponse:
        self._may(request, UserRole.SEE)
        values = self._page.site_values()
        return await self._finished.answer(request, 'site', self._page.model.site_revision,
                                           lambda: json_bytes(values()))

    async def _map(self, request: web.Request) -> web.StreamResponse:
        self._may(request, UserRole.SEE)
        walls = self._page.site.walls
        if walls is None:
            return refused(404, 'There is no map.')
        return web.Response(body=walls.png, content_type='image/png')

    async def _fences(self, request: web.Request) -> web.StreamResponse:
        self._may(request, UserRole.SEE)
        fences = self._page.site.fences
        return await self._finished.answer(request, 'fences', self._page.model.site_revision,
                                           lambda: json_bytes({'fences': fences}))

    async def _history(self, request: web.Request) -> web.StreamResponse:
        self._may(request, UserRole.SEE)
        hours, since = _span(request)
        sums = self._page.history_sums(since)

        def make() -> WebAnswer:
            lines, trouble = self._missions(since)
            values = history_values(lines, sums, since, time.time())
            return json_bytes({**values, 'trouble': trouble})
        return await self._finished.answer(request, f'history {hours}', _moment(), make)

    async def _history_csv(self, request: web.Request) -> web.StreamResponse:
        self._may(request, UserRole.SEE)
        hours, since = _span(request)

        def make() -> WebAnswer:
            lines, trouble = self._missions(since)
            if trouble:
                return json_bytes({'ok': False, 'text': trouble}, 503)
            return WebAnswer(history_csv(lines, since).encode(), 'text/csv', 200, {
                'Content-Disposition': 'attachment; filename="missions.csv"'})
        return await self._finished.answer(request, f'csv {hours}', _moment(), make)

    def _missions(self, since: float) -> Tuple[List[HistoryLine], str]:
        try:
            return self._page.missions(since), ''
        except JournalError as error:
            return [], str(error)

    async def _replay(self, request: web.Request) -> web.StreamResponse:
        self._may(request, UserRole.SEE)
        span = self._page.replay.span
        moment = None
        if 'time' in request.query:
            at = _number(request, 'time', 0.0, 0.0, 1e11)
            try:
                moment = self._page.replay.at(at)
            except OSError as error:
                return refused(503, f'The replay cannot be read: {error}.')
        return web.json_response({'span': span, 'moment': moment})

    async def _robot(self, request: web.Request) -> web.StreamResponse:
        self._may(request, UserRole.SEE)
        values = self._page.robot_values(request.query.get('name', ''))
        if values is None:
            return refused(404, 'There is no such robot.')
        answer = web.json_response(values)
        answer.enable_compression()
        return answer

    async def _audit(self, request: web.Request) -> web.StreamResponse:
        self._may(request, UserRole.OPERATE)
        answer = web.json_response({'rows': self._page.records.audit(200)})
        answer.enable_compression()
        return answer

    async def _metrics(self, request: web.Request) -> web.StreamResponse:
        self._may(request, UserRole.SEE)
        return web.Response(body=self._page.metrics(self.clients).encode(),
                            headers={'Content-Type': CONTENT_TYPE})

    # -- acts -------------------------------------------------------------------------------------

    async def _act(self, request: web.Request) -> web.StreamResponse:
        person = _person(request)
        try:
            act = act_of(await request.json())
        except WrongAct as wrong:
            return refused(400, str(wrong))
        if person.role < RULES[act.kind].role:
            return refused(403, 'Your role does not allow this.')
        if act.kind is ActKind.STOP:
            return refused(404, 'The door carries out stops.')
        if not self._acts.allows(person.name, time.monotonic()):
            return refused(429, 'Too many requests: wait a moment.')
        outcome = await asyncio.shield(self._done(person, act))
        return web.json_response({'ok': outcome.ok, 'text': outcome.text,
                                  'mission': outcome.mission})

    async def _done(self, person: Person, act: Act) -> ActOutcome:
        """Carries out an act and records its outcome, even if the client does not wait for the
        answer.
        """
        if act.kind in NAMED:
            outcome = self._page.change_named(act)
        elif act.kind is ActKind.ACKNOWLEDGE:
            outcome = self._page.acknowledge(act.name, person)
        else:
            outcome = await asyncio.get_event_loop().run_in_executor(
                self._threads, self._do, act, person)
        self._page.done(person, act, outcome, time.time())
        return outcome

    async def _stopped(self, request: web.Request) -> web.StreamResponse:
        """Records a stop that the door has carried out."""
        stop = await request.json()
        self._page.done(Person(stop['person'], UserRole.OPERATE), Act(ActKind.STOP),
                        ActOutcome(stop['ok'], stop['text']), stop['time'])
        return web.json_response({})


async def serve(server: WebServer, path: str) -> web.AppRunner:
    """Begins to listen at a Unix socket; only the door connects to it. Raises OSError."""
    runner = web.AppRunner(server.app, access_log=None, handle_signals=False)
    await runner.setup()
    await web.UnixSite(runner, path, shutdown_timeout=1.0).start()
    return runner


def _person(request: web.Request) -> Person:
    """Returns the person that the door has named for a request."""
    return Person(request.headers[PERSON], UserRole[request.headers[ROLE]])


def _span(request: web.Request) -> Tuple[int, float]:
    hours = int(_number(request, 'hours', 24, 1, MOST_HOURS))
    return hours, time.time() - HOUR * hours


def _moment() -> int:
    """Returns the number of the present period of FRESH s, in which an answer is used again."""
    return int(time.monotonic() // FRESH)


def _number(request: web.Request, name: str, default: float, least: float,
            most: float) -> float:
    try:
        value = float(request.query.get(name, default))
    except ValueError:
        value = least - 1.0
    if not least <= value <= most:
        raise web.HTTPBadRequest(reason=f'{name} must be a number from {least:g} to {most:g}.')
    return value
