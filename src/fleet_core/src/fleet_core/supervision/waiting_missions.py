"""Assigns waiting missions to free robots."""
from __future__ import annotations

from math import inf
from typing import Callable, Collection, Dict, FrozenSet, List, Mapping, Optional, Tuple

from fleet_core.supervision.assignment import assign, own_hindrance
from fleet_core.supervision.hindrances import Hindrance
from fleet_core.supervision.mission_book import MissionBook
from fleet_core.supervision.missions import Acceptance, Mission, MissionState
from fleet_core.supervision.networks import Networks
from fleet_core.supervision.pending_missions import FIRST, Key, key_of
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.station_room import StationRoom

AGAIN = 1.0   # s after which waiting missions are examined again even if no robot became free
AT_ONCE = 50  # number of further missions, beyond those that robots could serve now, to be examined


class WaitingMissions:
    """Gives each waiting mission a robot, or says why it has none.

    Each time it examines as many missions as the free robots could serve. It also examines some
    other missions, in turn, to find out what they wait for. So a mission that no free robot can
    serve does not delay the others.
    """

    def __init__(self, book: MissionBook, robots: Mapping[str, ManagedRobot],
                 laden: Callable[[], Collection[str]]) -> None:
        """`laden` returns the robots that carry something and therefore begin no mission."""
        self._book, self._laden = book, laden
        self._robots = robots
        self._short: Dict[int, str] = {}
        self._question: Optional[Tuple[object, ...]] = None
        self._looked = -inf
        self._left = 0  # number of missions still to be examined in this round
        self._last: Key = FIRST  # key of the mission that was examined last

    @property
    def short(self) -> FrozenSet[str]:
        """Robots that must charge before they can serve a mission that waits for them."""
        return frozenset(self._short.values())

    @property
    def own_hindrances(self) -> Dict[str, Hindrance]:
        """What hinders each robot from serving any mission now, by the robot's name."""
        busy, laden = self._book.serving, self._laden()
        return {name: own_hindrance(robot, name in busy, name in laden)
                for name, robot in self._robots.items()}

    def hold(self, reason: str) -> None:
        """Gives no mission to a robot now, and notes the reason."""
        self._question = None
        for mission in self._next():
            self._book.set(mission, MissionState.PENDING, reason)

    def assign(self, acceptance: Acceptance, networks: Networks, now: float,
               room_now: Callable[[], StationRoom]) -> List[str]:
        """Assigns waiting missions. Returns the robots that got one."""
        pending = self._book.pending
        if not pending:
            self._short = {}
            return []
        own = self.own_hindrances
        free = {name: self._robots[name] for name, one in own.items() if not one}
        room = room_now()
        question = (pending.changes, room.key, *free)
        if question != self._question or now - self._looked >= AGAIN:
            self._question, self._looked, self._left = question, now, len(pending)
        elif not self._left:
            return []
        missions = {mission.serial: mission for mission in (
            *pending.first({name: robot.type.model for name, robot in free.items()}),
            *self._next())}
        found = assign(list(missions.values()), own, self._robots, acceptance, networks, now,
                       room)
        for mission, name in found.assigned:
            self._book.set(mission, MissionState.ACTIVE, '', name)
        for serial, reason in found.waiting.items():
            self._book.set(missions[serial], MissionState.PENDING, reason)
        self._short = {serial: name for serial, name in {**self._short, **found.short}.items()
                       if self._is_short(serial, missions, found.short)}
        return [name for _, name in found.assigned]

    def _next(self) -> List[Mission]:
        missions = self._book.pending.behind(self._last, AT_ONCE)
        if missions:
            self._last = key_of(missions[-1])
        self._left = max(self._left - len(missions), 0)
        return missions

    def _is_short(self, serial: int, looked_at: Mapping[int, Mission],
                  short: Mapping[int, str]) -> bool:
        """Returns whether a mission still waits until a robot has charged."""
        return serial in short if serial in looked_at else self._book.is_pending(serial)
