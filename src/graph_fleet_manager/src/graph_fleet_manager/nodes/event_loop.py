"""What happens to the fleet manager, one event after the other, and the clock between them.

Stops go first. Then comes what was reported, commanded and answered, in the order of its arrival.
A tick comes when it is due, after all of these that arrived before. Requests have what time is
left, and at least one turn between two ticks; a tick is due at once when none is left.
"""
from __future__ import annotations

import heapq
import itertools
import threading
import time
from collections import deque
from typing import Callable, Deque, List, NamedTuple, Optional, Sequence

from graph_fleet_manager.supervision.actions import Action
from graph_fleet_manager.supervision.supervisor import Supervisor

TICK = 0.05       # s between two looks at the clock
_WAITING = 10000  # events, and as many requests, beyond which something is badly wrong
_EARLY = 1000     # events that are kept until there is a supervisor

Event = Callable[[Optional[Supervisor], float], Sequence[Action]]
"""What happened, told to the supervisor (None: there is none yet) with the time; what follows."""
ReadyEvent = Callable[[Supervisor, float], Sequence[Action]]
"""The same for events that nobody but a supervisor understands."""
ReportEvent = Callable[[Supervisor, float, float], Sequence[Action]]
"""The same with the time at which it arrived, after the time that it is now."""


class _Waiting(NamedTuple):
    """An event and when it arrived; the number tells the order of those that came together."""

    arrived: float
    number: int
    event: Event


class EventLoop:
    """Callbacks leave events, one thread takes them. Times are those of `clock` (s, monotonic)."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._changed = threading.Condition()
        self._numbers = itertools.count()
        self._stops: Deque[Event] = deque()
        self._events: List[_Waiting] = []  # a heap
        self._requests: Deque[Event] = deque()
        self._room = threading.Semaphore(_WAITING)
        self._request_room = threading.Semaphore(_WAITING)
        self._early: List[ReadyEvent] = []
        self._due = clock()
        self._heard: Optional[float] = None
        """A tick is due, after all events that arrived until then; None: none is due."""
        self._had_turn = False  # requests, since the last tick

    # -- callbacks --------------------------------------------------------------------------------

    def put(self, event: Event) -> None:
        """Something happened; waits while too much does."""
        self._put(event, self._clock())

    def _put(self, event: Event, arrived: float) -> None:
        self._room.acquire()
        with self._changed:
            heapq.heappush(self._events, _Waiting(arrived, next(self._numbers), event))
            self._changed.notify()

    def put_urgent(self, event: Event) -> None:
        """Something happened that must not wait for what happened before, however much that is."""
        with self._changed:
            self._stops.append(event)
            self._changed.notify()

    def put_report(self, event: ReportEvent) -> None:
        """Something happened that means nothing where there is no supervisor yet: it comes again.
        """
        arrived = self._clock()
        self._put(lambda supervisor, now: (
            () if supervisor is None else event(supervisor, now, arrived)), arrived)

    def put_order(self, event: ReadyEvent) -> None:
        """Something happened that comes only once: it is kept until there is a supervisor."""
        self.put(self._when_ready(event))

    def put_request(self, event: ReadyEvent, instead: Callable[[], Sequence[Action]]) -> None:
        """The same for what others go before; not kept where there is an answer `instead`."""
        self._request_room.acquire()
        with self._changed:
            self._requests.append(self._when_ready(event, instead))
            self._changed.notify()

    def _when_ready(self, event: ReadyEvent,
                    instead: Callable[[], Sequence[Action]] = tuple) -> Event:
        def when_ready(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
            if supervisor is not None:
                return event(supervisor, now)
            answer = instead()
            if answer:
                return answer
            if len(self._early) < _EARLY:
                self._early.append(event)
            return ()
        return when_ready

    # -- the thread that takes them ---------------------------------------------------------------

    def begin(self, supervisor: Supervisor, now: float) -> List[Action]:
        """There is a supervisor: it hears what came before it."""
        early, self._early = self._early, []
        return [action for event in early for action in event(supervisor, now)]

    def take(self) -> Event:
        """The next event, or a tick when it is time for that."""
        with self._changed:
            while True:
                now = self._clock()
                if self._heard is None and now >= self._due:
                    self._heard = now
                event = self._next()
                if event is not None:
                    return event
                if self._heard is not None:
                    return self._tick(self._heard)
                if not self._changed.wait(self._due - now):
                    self._heard = max(self._clock(), self._due)

    def _next(self) -> Optional[Event]:
        """What goes before the tick."""
        if self._stops:
            return self._stops.popleft()
        if self._events and (self._heard is None or self._events[0].arrived <= self._heard):
            self._room.release()
            return heapq.heappop(self._events).event
        if self._requests and (self._heard is None or not self._had_turn):
            self._request_room.release()
            self._had_turn = True
            request = self._requests.popleft()
            if not self._requests:
                self._due = self._clock()  # a robot is to drive at once
            return request
        return None

    def _tick(self, heard: float) -> Event:
        self._due = self._clock() + TICK
        self._heard, self._had_turn = None, False
        return lambda supervisor, now: () if supervisor is None else supervisor.tick(now, heard)
