"""Hands jobs to an OMRON Fleet Manager: connects the state machine `JobClient` to an ARCL link.

`omron_arcl` connects and logs in. When the link closes, even because the process ends, the TCP
connection is reset: the kernel drops bytes that were not delivered. So no command of an old link
arrives after the first query of the next link.
"""
from __future__ import annotations

import threading
from collections import deque
from typing import Callable, ContextManager, Deque, List, Optional, Tuple

from omron_arcl import Backoff, Link, LinkError, Received
from omron_arcl.arcl_link import ArclLink
from omron_arcl.errors import ConnectionLost
from omron_arcl.session import LoggedIn
from omron_jobs.client.handed_jobs import HandedJob, HandedStop
from omron_jobs.client.job_client import JobClient

SILENCE = 6.0   # s without a line after which the link counts as lost
BEAT = 1.5      # s between two requests for a sign of life
_SIGN_OF_LIFE = 'getDateTime'


class JobHandover:
    """Serves `jobs` over one link, from `start` to `close`.

    on_change -- called with each job that has changed, in any thread, with the lock held
    lock      -- guards the jobs: they do not change while a caller holds it
    Only the thread of the link calls the methods `hear_...` and `next_to_send`.
    """

    def __init__(self, jobs: JobClient, host: str, port: int, password: bytes,
                 on_change: Callable[[HandedJob], None], *,
                 lock: Optional[ContextManager[bool]] = None, silence: float = SILENCE,
                 backoff: Optional[Backoff] = None) -> None:
        self._jobs, self._on_change = jobs, on_change
        self._lock = lock or threading.RLock()
        self.problem = ''       # why no job is handed over although there is a link
        self._to_send: Deque[str] = deque()
        self._beat = 0.0
        self._link = ArclLink('Fleet Manager link', host, port, password, self, silence=silence,
                              backoff=backoff, resets=True)

    # -- for any thread ----------------------------------------------------------------------------

    def start(self) -> None:
        """Begins to connect."""
        self._link.start()

    def close(self) -> None:
        """Ends the link. The jobs stay."""
        self._link.close()

    @property
    def link(self) -> Link:
        """The state of the link."""
        return self._link.link

    @property
    def jobs(self) -> List[HandedJob]:
        """All jobs, the oldest first."""
        with self._lock:
            return self._jobs.jobs

    def request(self, stops: Tuple[HandedStop, ...], request: str) -> HandedJob:
        """Stores a job, and hands it over as soon as possible. Raises like `JobClient.request`."""
        with self._lock:
            job = self._jobs.request(stops, request)
            self._report_changes()
        self._link.wake()
        return job

    def modify(self, request: str, stops: Tuple[HandedStop, ...]) -> HandedJob:
        """Gives a job other goals or priorities. Raises like `JobClient.modify`."""
        with self._lock:
            job = self._jobs.modify(request, stops)
            self._report_changes()
        self._link.wake()
        return job

    def cancel(self, id: str) -> None:
        """Cancels a job. Raises OSError."""
        with self._lock:
            self._jobs.cancel(id)
            self._report_changes()
        self._link.wake()

    # -- in the thread of the link -----------------------------------------------------------------

    def hear_login(self, login: LoggedIn, now: float) -> None:
        """Begins a link."""
        self._beat = now
        with self._lock:
            self._jobs.hear_login()

    def hear_loss(self, cause: LinkError) -> None:
        """Ends a link. Lines that were not sent are dropped; the next link queries their jobs."""
        self._to_send.clear()
        with self._lock:
            self._jobs.hear_loss()

    def hear_line(self, line: Received, now: float) -> None:
        """Reads a line of the Fleet Manager, and reports the changed jobs."""
        with self._lock:
            self._jobs.hear_line(line.text, now)
            self._report_changes()

    def next_to_send(self, now: float) -> Optional[bytes]:
        """Returns the next line to send; before that, stores the changes of jobs."""
        if not self._to_send:
            self._to_send.extend(self._due(now))
        if not self._to_send and now - self._beat >= BEAT:
            self._beat = now
            self._to_send.append(_SIGN_OF_LIFE)
        return self._to_send.popleft().encode('ascii') if self._to_send else None

    def hear_turn(self, now: float) -> None:
        """Ends the link if an answer is overdue."""
        with self._lock:
            if self._jobs.is_stuck(now):
                raise ConnectionLost('the Fleet Manager does not answer')

    def _due(self, now: float) -> List[str]:
        with self._lock:
            try:
                self._jobs.store_news()
                lines = self._jobs.due(now)
                self.problem = self._jobs.problem
            except OSError as problem:
                self.problem, lines = f'jobs cannot be stored: {problem.strerror}', []
            self._report_changes()
            return lines

    def _report_changes(self) -> None:
        for job in self._jobs.pop_changes():
            self._on_change(job)
