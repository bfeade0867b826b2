"""The outbox: actions that follow an event, held back until their data are on the disk.

While the disk cannot be written, only orders that stop robots or shorten their routes go out.
The interlocking withdraws grants that could not be stored, and grants the edges anew later. All
other actions wait for the disk.
"""
from __future__ import annotations

import math
from math import inf
from typing import Callable, Dict, List, Mapping, Optional, Set

from fleet_core.interlocking.interlocking import InterlockedRobot, Interlocking
from fleet_core.supervision.actions import Action, Note, PublishStatus, SendRoute
from fleet_core.supervision.device_desk import DeviceDesk
from fleet_core.supervision.fleet_stop import FleetStop
from fleet_core.supervision.journal import Journal, RobotMemory
from fleet_core.supervision.journal_database import JournalUnavailable
from fleet_core.supervision.mission_book import MissionBook
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.work_desk import NEWEST_STEP, WorkDesk
from trajectory_graph import Graph

AGAIN = 2.0             # s between two attempts to write while writing fails
TOGETHER = 0.04         # s during which all changes that reports make share one commit
DEVICE_REQUEST = 'device_request'
"""Name, in the journal, of the number of the last request to devices."""
_JOURNAL = '/journal'   # key of the journal's state in `note_state`; no robot has such a name


class Outbox:
    """Collects the actions that follow an event. `actions` first stores what has changed.

    clock   -- returns the present time of the supervisor's clock
    trouble -- why nothing can be stored, as a clause; empty: everything can be stored

    Its attributes are the changes and actions that wait for one commit.
    """

    def __init__(self, journal: Journal, book: MissionBook, robots: Mapping[str, ManagedRobot],
                 everywhere: Mapping[str, InterlockedRobot], interlocking: Interlocking,
                 desk: WorkDesk, devices: DeviceDesk, clock: Callable[[], float]) -> None:
        self.trouble = ''
        self._journal = journal
        self._book, self._desk, self._devices = book, desk, devices
        self._robots, self._everywhere = robots, everywhere
        self._interlocking, self._clock = interlocking, clock
        self._stale: Set[str] = set()
        self._values: Dict[str, int] = {}
        self._stop: Optional[FleetStop] = None
        self._graph: Optional[Graph] = None
        self._try_at = self._stored_at = -inf
        self._is_sending = False
        self._actions: List[Action] = []
        self._wrong: Dict[str, str] = {}

    # -- adding actions ---------------------------------------------------------------------------

    def put(self, action: Action) -> None:
        """Adds an action."""
        self._actions.append(action)

    def note(self, text: str, is_warning: bool = False) -> None:
        """Adds a log text for the operators."""
        self.put(Note(text, is_warning))

    def note_state(self, subject: str, wrong: str, mended: str) -> None:
        """Logs what is wrong with a subject, but only when this changes.

        wrong  -- what is wrong; empty: nothing
        mended -- the text to log when nothing is wrong any more
        """
        before = self._wrong.get(subject, '')
        self._wrong[subject] = wrong
        if wrong != before:
            self.note(wrong or mended, bool(wrong))

    def robot_changed(self, name: str) -> None:
        """Notes that the stored state of a robot is outdated."""
        self._stale.add(name)

    def value_changed(self, name: str, number: int) -> None:
        """Notes that a number is to be stored."""
        self._values[name] = number

    def stop_changed(self, stop: FleetStop) -> None:
        """Notes that the fleet was stopped, or goes on."""
        self._stop = stop

    def graph_changed(self, graph: Graph) -> None:
        """Notes that from now on the stored data of robots refer to this graph."""
        self._graph = graph

    def send(self) -> None:
        """Notes that all due orders are to be sent."""
        self._is_sending = True

    # -- taking actions ---------------------------------------------------------------------------

    def actions(self, now: float) -> List[Action]:
        """Returns all actions to be done now, orders to robots first.

        The data on which they depend are on the disk.
        """
        self._store(now)
        orders = self._orders(self._clock()) if self._is_sending else []
        steps, requests = self._desk.due(now), self._devices.due(now)
        self._is_sending = False
        actions, self._actions = self._actions, []
        return [*orders, *steps, *requests, *actions]

    def actions_unless_due_later(self, now: float) -> List[Action]:
        """Returns `actions` if orders are to be sent at once, or if nothing is to be stored.

        Otherwise all actions wait until `due`, so that many reports share one commit.
        """
        return self.actions(now) if self._is_sending or not self._is_anything_new else []

    @property
    def due(self) -> Optional[float]:
        """The time to take the waiting actions; None: no action waits, or nothing can be stored.

        A commit is due TOGETHER s after the last one.
        """
        if self.trouble or not self._is_anything_new:
            return None
        return self._stored_at + TOGETHER

    @property
    def _is_anything_new(self) -> bool:
        return bool(self._stale or self._values or self._graph or self._stop
                    or self._book.is_changed or self._desk.is_changed
                    or self._interlocking.claims.is_changed)

    def _store(self, now: float) -> None:
        if now < self._try_at or not (self.trouble or self._is_anything_new):
            return
        claims = self._interlocking.claims
        new_claims = claims.to_store
        if claims.is_changed:
            self._values[DEVICE_REQUEST] = claims.number
        self._stale.update(self._interlocking.to_store, new_claims)
        missions, stays = self._book.changes, self._book.new_stays(now)
        works, loads = self._desk.changes
        values = {**self._values, **({NEWEST_STEP: self._desk.newest} if works or loads else {})}
        try:
            self._journal.store(missions, {name: self._memory(name)
                                           for name in sorted(self._stale)}, values, self._graph,
                                stays, self._stop, works, loads, new_claims)
        except JournalUnavailable as unavailable:
            self.trouble, self._try_at = unavailable.reason, now + AGAIN
            self._interlocking.not_stored(self.trouble)
            self.note_state(_JOURNAL, f'{unavailable} Until then no mission is accepted and no '
                            'robot gets anything new to drive; stops are sent.', '')
            return
        self.trouble = self._interlocking.trouble = ''
        self._try_at, self._stored_at = -inf, now
        self.note_state(_JOURNAL, '', 'The journal can be written again.')
        self._interlocking.stored(self._stale)
        claims.stored()
        self._stale.clear()
        self._values.clear()
        self._graph = self._stop = None
        self._book.stored()
        self._desk.stored()
        for mission in missions:
            self.put(PublishStatus(mission.status))

    def _orders(self, now: float) -> List[Action]:
        """Returns all orders that are due and that the interlocking lets pass.

        now -- the present time: the commit may have taken long
        """
        self._devices.update_open(now)
        return [SendRoute(name, *sending, self._everywhere[name].type.speed_limit)
                for name, sending in self._interlocking.orders(now)]

    def _memory(self, name: str) -> Optional[RobotMemory]:
        """Returns the state of a robot to be stored; None: the robot left the fleet for good."""
        known = self._everywhere.get(name)
        if known is None:
            return None
        robot = self._robots.get(name)
        if robot is None:
            return RobotMemory(known.master.memory, None, '', False, kind=known.type)
        return RobotMemory(robot.master.memory, robot.outage, robot.why, robot.is_halted,
                           robot.comes_to_rest, robot.dock,
                           None if math.isnan(robot.battery.charge) else robot.battery.charge,
                           robot.type, robot.charge_until, robot.tops_up)
