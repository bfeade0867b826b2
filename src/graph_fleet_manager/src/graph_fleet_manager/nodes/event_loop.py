"""The queue of the fleet manager: events from callbacks, and ticks of the clock between them.

`turns` has the order of the kinds of events. Events of one kind keep the order of their arrival,
with these exceptions:

- An answer of the planner counts as a command.
- Only the newest report of a robot waits. It takes the turn of the oldest report that it replaces.
- When no request is left, a tick is due at once.
- Before a command, the waiting requests for its mission are handled.

Requests and commands wait until there is a supervisor, because their senders do not repeat them.

While the whole process is halted, reports collect in its sockets. Therefore the next tick, which
looks for robots that do not report, is delayed: callbacks can take these reports first.
"""
from __future__ import annotations

import heapq
import itertools
import threading
import time
from collections import OrderedDict, deque
from typing import Callable, Deque, Dict, List, NamedTuple, Optional, Sequence, Tuple, Union

from fleet_core.supervision.actions import Action, Note, PublishStatus
from fleet_core.supervision.mission_book import MOST_OPEN
from fleet_core.supervision.mission_commands import refused
from fleet_core.supervision.missions import CommandKind, MissionChange, Request, StepAnswer
from fleet_core.supervision.supervisor import Supervisor
from graph_fleet_manager.nodes.turns import TurnKind, Turns, Waiting

STALL = 1.0       # s; if more time passes between two looks at the clock, the process was halted
RECOVERY = 0.25   # s after a halt in which callbacks take the reports that came during the halt
BATCH = 100       # the most requests in one commit; a stop may have to wait for one commit
# The most commands and reports that may wait together, and the most requests that may wait. If more
# come, callbacks block.
_WAITING = 10000
_TOO_EARLY = f'the fleet manager has not started yet, and {MOST_OPEN} already wait for it'

Event = Callable[[Optional[Supervisor], float], Sequence[Action]]
"""An event: gets the supervisor (None: there is none yet) and the time, returns actions."""
ReadyEvent = Callable[[Supervisor, float], Sequence[Action]]
"""An event that needs a supervisor."""
ReportEvent = Callable[[Supervisor, float, float], Sequence[Action]]
"""An event that needs a supervisor; gets the present time, and the time when the event arrived."""


class _Arrived(NamedTuple):
    """A report and the time of its arrival; `number` orders reports with the same time."""

    at: float
    number: int
    event: Event


class SupervisorEvents:
    """The queues of events: callbacks put events into them, and one thread takes the events.

    trouble -- a clause that says why requests cannot wait for a supervisor; empty if they can

    Times are those of `clock` (s, monotonic). The attributes are the queues and their turns.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic,
                 trouble: Callable[[], str] = str) -> None:
        self._clock, self._trouble = clock, trouble
        self._changed = threading.Condition()
        self._numbers = itertools.count()
        self._stops: Deque[Event] = deque()
        self._commands: Deque[Event] = deque()
        self._reports: List[_Arrived] = []  # a heap
        self._newest: Dict[str, Tuple[ReportEvent, float]] = {}  # with the time of its arrival
        self._requests: OrderedDict[int, Request] = OrderedDict()
        self._by_id: Dict[int, List[int]] = {}  # the numbers of the requests with each id
        self._room = threading.Semaphore(_WAITING)
        self._request_room = threading.Semaphore(_WAITING)
        self._is_ready = False
        self._early: List[Event] = []
        """Commands that came before there was a supervisor."""
        self._looked = clock()
        self._turns = Turns(self._looked)

    # -- callbacks --------------------------------------------------------------------------------

    def put(self, event: Event) -> None:
        """Queues a command. Blocks while too many commands and reports wait."""
        self._room.acquire()
        with self._changed:
            self._commands.append(event)
            self._changed.notify()

    def put_urgent(self, event: Event) -> None:
        """Queues a stop. It is taken before all events that wait. Never blocks."""
        with self._changed:
            self._stops.append(event)
            self._changed.notify()

    def put_report(self, event: ReportEvent, key: str = '') -> None:
        """Queues a report. Without a supervisor the report is dropped: its sender repeats it.

        key -- the report replaces a waiting report with this key; empty: it replaces none
        """
        arrived = self._clock()
        key = key or f'{next(self._numbers)}'
        with self._changed:
            is_waiting = key in self._newest
            self._newest[key] = event, arrived
        if is_waiting:
            return
        self._room.acquire()
        with self._changed:
            heapq.heappush(self._reports, _Arrived(
                arrived, next(self._numbers),
                lambda supervisor, now: self._report(key, supervisor, now)))
            self._changed.notify()

    def _report(self, key: str, supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
        with self._changed:
            event, arrived = self._newest.pop(key)
        return () if supervisor is None else event(supervisor, now, arrived)

    def put_order(self, event: ReadyEvent, lost: str = '') -> None:
        """Queues a command that its sender does not repeat, and keeps it until there is a
        supervisor.

        lost -- the warning if the command is lost because too many commands are kept already
        """
        def when_ready(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
            if supervisor is not None:
                return event(supervisor, now)
            if len(self._early) >= MOST_OPEN:
                return (Note(lost, True),) if lost else ()
            self._early.append(when_ready)
            return ()
        self.put(when_ready)

    def put_command(self, request_id: int, command: CommandKind,
                    change: Union[None, MissionChange, StepAnswer] = None,
                    requested_by: str = '') -> None:
        """Queues a command, after the waiting requests with its id."""
        def do(supervisor: Supervisor, now: float) -> Sequence[Action]:
            before = self._requests_with(request_id)
            return [*(supervisor.requests(before, now) if before else ()),
                    *supervisor.command(request_id, command, now, change, requested_by)]
        self.put_order(do, f'The command {command.name} for mission {request_id} is ignored: '
                           f'{_TOO_EARLY}.')

    def put_request(self, request: Request) -> None:
        """Queues a request. Blocks while too many requests wait.

        Without a supervisor, a request is refused if MOST_OPEN requests wait already.
        """
        with self._changed:
            is_refused = not self._is_ready and len(self._requests) >= MOST_OPEN
        if is_refused:
            self.put(lambda supervisor, now: (PublishStatus(refused(request, _TOO_EARLY)),))
            return
        self._request_room.acquire()
        with self._changed:
            number = next(self._numbers)
            self._requests[number] = request
            self._by_id.setdefault(request.id, []).append(number)
            self._changed.notify()

    # -- the thread that takes the events ---------------------------------------------------------

    def begin(self) -> None:
        """Queues the commands that waited for a supervisor, in the order of their arrival."""
        with self._changed:
            self._is_ready = True
            early, self._early = self._early, []
            self._commands.extendleft(reversed(early))
            for _ in early:
                self._room.acquire(blocking=False)

    def end(self) -> None:
        """Makes requests and commands wait, because there is no supervisor any more."""
        with self._changed:
            self._is_ready = False

    def hurry(self, due: Optional[float]) -> None:
        """Makes the next tick due at `due`, unless it is due earlier; None changes nothing."""
        self._turns.hurry(due)

    def next_event(self) -> Event:
        """Waits for the next event or tick, and returns it."""
        with self._changed:
            is_due = False
            while True:
                before, now = self._looked, self._clock()
                self._looked = now
                if now - before > STALL:
                    self._turns.put_off(now + RECOVERY)
                elif is_due:
                    now = max(now, self._turns.due)
                kind = self._turns.next(self._waiting(), now)
                if kind is not None:
                    return self._taken_of(kind)
                is_due = not self._changed.wait(self._turns.due - now)

    def _waiting(self) -> Waiting:
        return Waiting(bool(self._stops), bool(self._commands),
                       self._reports[0].at if self._reports else None,
                       bool(self._requests) and (self._is_ready or bool(self._trouble())))

    def _taken_of(self, kind: TurnKind) -> Event:
        if kind is TurnKind.TICK:
            return self._tick(self._turns.heard)
        if kind is TurnKind.REQUEST:
            return self._accept('' if self._is_ready else self._trouble())
        if kind is TurnKind.STOP:
            return self._stops.popleft()
        self._room.release()
        if kind is TurnKind.COMMAND:
            return self._commands.popleft()
        return heapq.heappop(self._reports).event

    def _accept(self, trouble: str) -> Event:
        """Returns an event that accepts up to BATCH requests, or refuses them for the reason
        `trouble`.
        """
        requests = [self._taken(number)
                    for number in list(itertools.islice(self._requests, BATCH))]
        if not self._requests:
            self._turns.hurry(self._clock())  # at once, so that a robot starts without delay
        return lambda supervisor, now: (
            [PublishStatus(refused(request, trouble)) for request in requests]
            if supervisor is None else supervisor.requests(requests, now))

    def _requests_with(self, request_id: int) -> List[Request]:
        with self._changed:
            return [self._taken(number) for number in list(self._by_id.get(request_id, ()))]

    def _taken(self, number: int) -> Request:
        request = self._requests.pop(number)
        numbers = self._by_id[request.id]
        numbers.remove(number)
        if not numbers:
            del self._by_id[request.id]
        self._request_room.release()
        return request

    def _tick(self, heard: float) -> Event:
        def tick(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
            actions = () if supervisor is None else supervisor.tick(now, heard)
            self._turns.ended(self._clock())
            return actions
        return tick
