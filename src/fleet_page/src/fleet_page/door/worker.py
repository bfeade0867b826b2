"""The door's connection to the page's process. The door passes requests on and reports its stops.
"""
from __future__ import annotations

import asyncio
import contextlib
import json
import logging
from collections import deque
from typing import Any, Callable, Deque, Dict, Optional

import aiohttp
from aiohttp import web

from fleet_page.core.roles import Person

PERSON, ROLE = 'X-Person', 'X-Role'
STOPPED = '/stopped'   # the route by which the door reports stops; browsers cannot use it
ANSWER_WITHIN = 30.0   # s within which the answer of the page's process must begin
STALLED = 30.0         # s after which a client that does not read is disconnected
CHECKED = 1.0          # s between two checks whether the session of an open stream is valid
_RETRY = 1.0           # s between two attempts to report a stop
_MOST_REPORTS = 1000   # stops that are kept for the page's process, at most
_PASSED_ON = ('Accept-Encoding', 'If-None-Match', 'Last-Event-ID', 'Content-Type')
_OWN_HEADERS = ('Accept-Encoding', 'User-Agent')  # aiohttp must not add them
_LEFT_OUT = frozenset(name.lower() for name in (
    'Connection', 'Transfer-Encoding', 'Keep-Alive', 'Date', 'Server'))
_LOG = logging.getLogger(__name__)


class Worker:
    """The page's process behind a Unix socket in a folder that only its user can open."""

    def __init__(self, path: str) -> None:
        self._session = aiohttp.ClientSession(
            connector=aiohttp.UnixConnector(path, limit=0), auto_decompress=False,
            cookie_jar=aiohttp.DummyCookieJar(), timeout=aiohttp.ClientTimeout(total=None))
        self._reports: Deque[Dict[str, Any]] = deque(maxlen=_MOST_REPORTS)
        self._reporting: Optional[asyncio.Future[None]] = None

    async def close(self) -> None:
        """Ends all connections to the page's process."""
        if self._reporting is not None:
            self._reporting.cancel()
        await self._session.close()

    async def relay(self, request: web.Request, body: bytes, person: Person,
                    headers: Dict[str, str], may_go_on: Callable[[], bool]) -> web.StreamResponse:
        """Passes a request on. Passes its answer back while `may_go_on` returns True."""
        passed = {name: request.headers[name] for name in _PASSED_ON if name in request.headers}
        passed.update({PERSON: person.name, ROLE: person.role.name})
        try:
            answer = await asyncio.wait_for(self._session.request(
                request.method, request.url.with_scheme('http').with_host('page').with_port(80),
                data=body or None, headers=passed, skip_auto_headers=_OWN_HEADERS,
                allow_redirects=False), ANSWER_WITHIN)
        except (aiohttp.ClientError, asyncio.TimeoutError, ValueError) as error:
            return web.json_response({'ok': False, 'text': 'The page does not answer '
                                      f'({type(error).__name__}). STOP ALL works.'}, status=503)
        try:
            return await _pass_back(request, answer, headers, may_go_on)
        finally:
            answer.close()

    def report(self, stop: Dict[str, Any]) -> None:
        """Reports a stop for the audit list, as soon as the page's process can receive it."""
        self._reports.append(stop)
        if self._reporting is None or self._reporting.done():
            self._reporting = asyncio.ensure_future(self._report())

    async def _report(self) -> None:
        while self._reports:
            stop = self._reports[0]
            if not await self._told(stop):
                await asyncio.sleep(_RETRY)
            elif self._reports and self._reports[0] is stop:
                self._reports.popleft()

    async def _told(self, stop: Dict[str, Any]) -> bool:
        with contextlib.suppress(aiohttp.ClientError, asyncio.TimeoutError):
            answer = await asyncio.wait_for(self._session.post(
                'http://page' + STOPPED, data=json.dumps(stop).encode()), ANSWER_WITHIN)
            answer.release()
            return bool(answer.status == 200)
        return False


async def _pass_back(request: web.Request, answer: aiohttp.ClientResponse, headers: Dict[str, str],
                     may_go_on: Callable[[], bool]) -> web.StreamResponse:
    response = web.StreamResponse(status=answer.status, headers={
        **headers, **{name: value for name, value in answer.headers.items()
                      if name.lower() not in _LEFT_OUT}})
    try:
        await response.prepare(request)
        while may_go_on():
            try:
                data = await asyncio.wait_for(answer.content.readany(), CHECKED)
            except asyncio.TimeoutError:
                continue
            if not data:
                break
            await asyncio.wait_for(response.write(data), STALLED)
        else:
            _abort(request)
    except (ConnectionError, asyncio.TimeoutError, aiohttp.ClientError):
        _abort(request)  # otherwise unread data would stay, or half an answer would seem whole
    return response


def _abort(request: web.Request) -> None:
    if request.transport is not None:
        request.transport.abort()
