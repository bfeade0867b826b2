"""Waiting missions go to free robots, as soon as there are both."""
from __future__ import annotations

from math import inf
from typing import FrozenSet, List, Mapping, Tuple

from graph_fleet_manager.supervision.assignment import assign
from graph_fleet_manager.supervision.missions import Acceptance, MissionBook, MissionState
from graph_fleet_manager.supervision.networks import Networks
from graph_fleet_manager.supervision.robots import ManagedRobot

AGAIN = 1.0  # s after which waiting missions are looked at although nobody came free


class WaitingMissions:
    """Gives each waiting mission a robot, or says why it has none."""

    def __init__(self, book: MissionBook, robots: Mapping[str, ManagedRobot]) -> None:
        self.short: FrozenSet[str] = frozenset()
        """Robots that a mission waits for until they are charged."""
        self._book = book
        self._robots = robots
        self._looked: Tuple[object, float] = ((), -inf)

    def hold(self, reason: str) -> None:
        """None is given to anybody now, and why."""
        self._looked = (), -inf
        for mission in self._book.open:
            if mission.state is MissionState.PENDING:
                self._book.set(mission, MissionState.PENDING, reason)

    def assign(self, acceptance: Acceptance, networks: Networks, now: float) -> List[str]:
        """The robots that got a mission now."""
        pending = [m for m in self._book.open if m.state is MissionState.PENDING]
        if not pending:
            self.short = frozenset()
            return []
        busy = {m.robot for m in self._book.open if m.robot}
        free = {name: robot for name, robot in self._robots.items()
                if robot.works and name not in busy and robot.is_charged
                and (robot.record.held or robot.record.position is not None)}
        question = (tuple(m.serial for m in pending), tuple(free))
        if question == self._looked[0] and now - self._looked[1] < AGAIN:
            return []
        self._looked = question, now
        found = assign(pending, free, self._robots, acceptance, networks, now)
        self.short = found.short
        for mission, name in found.assigned:
            self._book.set(mission, MissionState.ACTIVE, '', name)
        for mission in pending:
            if mission.serial in found.waiting:
                self._book.set(mission, MissionState.PENDING, found.waiting[mission.serial])
        return [name for _, name in found.assigned]
