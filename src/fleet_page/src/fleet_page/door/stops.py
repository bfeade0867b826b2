"""Carries out stops. While one stop runs, a second one waits; it serves all requests that come."""
from __future__ import annotations

import asyncio
import concurrent.futures
from typing import Callable, Optional

from fleet_page.core.acts import ActOutcome


class Stops:
    """Stops the fleet in a thread of its own.

    A request is served by a stop that begins after the request has come. So any number of requests
    needs at most two stops: the present stop and the next one. The next stop has the name of its
    first requester.
    """

    def __init__(self, stop: Callable[[str], ActOutcome]) -> None:
        self._stop = stop
        self._thread = concurrent.futures.ThreadPoolExecutor(1, 'stop')
        self._running: Optional[asyncio.Future[ActOutcome]] = None
        self._next: Optional[asyncio.Future[ActOutcome]] = None

    async def stop(self, person: str) -> ActOutcome:
        """Stops the fleet for a person. Returns the outcome of a stop begun after this call."""
        if self._next is None:
            self._next = asyncio.ensure_future(self._after(self._running, person))
        return await asyncio.shield(self._next)

    async def _after(self, before: Optional[asyncio.Future[ActOutcome]], person: str) -> ActOutcome:
        if before is not None:
            await asyncio.wait([before])
        self._running, self._next = self._next, None
        return await asyncio.get_event_loop().run_in_executor(
            self._thread, self._stop, person)

    def close(self) -> None:
        """Begins no further stop."""
        self._thread.shutdown(wait=False)
