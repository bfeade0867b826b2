"""What happens to the fleet manager, one event after the other, and the clock between them."""
from __future__ import annotations

import itertools
import queue
import threading
import time
from typing import Callable, List, Optional, Sequence, Tuple

from graph_fleet_manager.supervision.actions import Action
from graph_fleet_manager.supervision.supervisor import Supervisor

TICK = 0.05       # s between two looks at the clock
_WAITING = 10000  # events, beyond which something is badly wrong
_EARLY = 1000     # events that are kept until there is a supervisor

Event = Callable[[Optional[Supervisor], float], Sequence[Action]]
"""What happened, told to the supervisor (None: there is none yet) with the time; what follows."""
ReadyEvent = Callable[[Supervisor, float], Sequence[Action]]
"""The same for events that nobody but a supervisor understands."""


class EventLoop:
    """Callbacks leave events, one thread takes them: those that are urgent first.

    However many events come, the clock is looked at in time.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._events: queue.PriorityQueue[Tuple[bool, int, Event]] = queue.PriorityQueue()
        self._room = threading.Semaphore(_WAITING)  # for what is not urgent
        self._numbers = itertools.count()
        self._early: List[ReadyEvent] = []
        self._due = clock()

    def put(self, event: Event) -> None:
        """Something happened; waits while too much does."""
        self._room.acquire()
        self._events.put((True, next(self._numbers), event))

    def put_urgent(self, event: Event) -> None:
        """Something happened that must not wait for what happened before, however much that is."""
        self._events.put((False, next(self._numbers), event))

    def put_report(self, event: ReadyEvent) -> None:
        """Something happened that means nothing where there is no supervisor yet: it comes again.
        """
        self.put(lambda supervisor, now: () if supervisor is None else event(supervisor, now))

    def put_order(self, event: ReadyEvent,
                  instead: Callable[[], Sequence[Action]] = tuple) -> None:
        """Something happened that comes only once: it is kept until there is a supervisor.

        Not if there is an answer to it `instead` by then.
        """
        def when_ready(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
            if supervisor is not None:
                return event(supervisor, now)
            answer = instead()
            if answer:
                return answer
            if len(self._early) < _EARLY:
                self._early.append(event)
            return ()
        self.put(when_ready)

    def begin(self, supervisor: Supervisor, now: float) -> List[Action]:
        """There is a supervisor: it hears what came before it."""
        early, self._early = self._early, []
        return [action for event in early for action in event(supervisor, now)]

    def take(self) -> Event:
        """The next event, or a look at the clock when it is time for that."""
        try:
            wait = self._due - self._clock()
            if wait > 0.0:
                can_wait, _, event = self._events.get(timeout=wait)
                if can_wait:
                    self._room.release()
                return event
        except queue.Empty:
            pass
        self._due = self._clock() + TICK
        return _tick


def _tick(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
    return () if supervisor is None else supervisor.tick(now)
