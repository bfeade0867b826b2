"""Answers that take time to make: one thread makes an answer for all requests that wait for it."""
from __future__ import annotations

import asyncio
import concurrent.futures
import gzip
import json
from collections import OrderedDict
from dataclasses import dataclass, field, replace
from typing import Any, Callable, Dict, Tuple

from aiohttp import web

MOST_KEPT = 8
_COMPRESSED = 1000  # bytes; larger answers are compressed


@dataclass(frozen=True)
class WebAnswer:
    """The bytes of an answer; `compressed`: the same bytes with gzip, empty for a short answer."""

    content: bytes
    kind: str
    status: int = 200
    headers: Dict[str, str] = field(default_factory=dict)
    compressed: bytes = b''


def json_bytes(values: Any, status: int = 200) -> WebAnswer:
    """Returns JSON values as an answer."""
    return WebAnswer(json.dumps(values).encode(), 'application/json', status)


class Finished:
    """The last answer of each name, with the state from which the answer was made."""

    def __init__(self) -> None:
        self._thread = concurrent.futures.ThreadPoolExecutor(1, 'answers')
        self._made: OrderedDict[str, Tuple[Any, asyncio.Future[WebAnswer]]] = OrderedDict()

    def close(self) -> None:
        """Stops making answers."""
        self._thread.shutdown(wait=False)

    async def answer(self, request: web.Request, name: str, state: Any,
                     make: Callable[[], WebAnswer]) -> web.Response:
        """Returns the answer of this name for this state. If there is none, a thread calls `make`.
        """
        known = self._made.get(name)
        if known is None or known[0] != state:
            known = state, asyncio.ensure_future(asyncio.get_event_loop().run_in_executor(
                self._thread, lambda: _compressed(make())))
            self._made[name] = known
            while len(self._made) > MOST_KEPT:
                self._made.popitem(last=False)
        made = await asyncio.shield(known[1])
        headers = {**made.headers, 'Vary': 'Accept-Encoding'}
        body = made.content
        if made.compressed and 'gzip' in request.headers.get('Accept-Encoding', ''):
            headers['Content-Encoding'], body = 'gzip', made.compressed
        return web.Response(body=body, status=made.status, headers=headers,
                            content_type=made.kind, charset='utf-8')


def _compressed(made: WebAnswer) -> WebAnswer:
    if len(made.content) < _COMPRESSED:
        return made
    return replace(made, compressed=gzip.compress(made.content, 6))
