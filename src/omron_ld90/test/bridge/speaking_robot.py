"""A robot on a graph that takes and sends lines of ARCL, like an LD-90 or a less exact robot."""
from __future__ import annotations

import math
from typing import Callable, Optional

from bridge_builders import GraphRobot

from omron_arcl import ActivityKind
from trajectory_graph import Graph

UNDOCKING_TIME = 3.0  # s
_UNDOCKING = 'DockingState: Undocking ForcedState: Unforced ChargeState: Not'
_UNDOCKED = 'DockingState: Undocked ForcedState: Unforced ChargeState: Not'
_DOCKED = 'DockingState: Docked ForcedState: Unforced ChargeState: Bulk'


class SpeakingRobot(GraphRobot):
    """Takes lines of ARCL, and answers like an LD-90. After a stop during a drive it brakes.

    When it leaves its dock, it does not name its goal until it has undocked.

    interruption -- what it says about a drive that another command ends: the `name` of the goal,
        the `coordinates`, the previous `status`, or `nothing`
    """

    def __init__(self, graph: Graph, vertex: int, say: Callable[[str], None],
                 later: Callable[[float, Callable[[], None]], None], interruption: str,
                 braking: float) -> None:
        super().__init__(graph, vertex)
        self.status = _DOCKED if self.docked else 'Stopped'
        self._say, self._later = say, later
        self._interruption, self._braking_time = interruption, braking
        self._words = 0  # commands taken

    def receive(self, line: str) -> None:
        """Takes a command of any client."""
        if line == 'oneLineStatus':
            x, y = (round(1000.0 * value) for value in self.position)
            self._say(f'Status: {self.status} StateOfCharge: 80.0 Location: {x} {y} 0 '
                      'Temperature: 30')
            return
        self._words += 1
        if self.status == _UNDOCKING:
            self._say(_UNDOCKED)
        if self.goal is not None and self._interruption != 'nothing':
            place = '1000 2000' if self._interruption == 'coordinates' else self.goal
            ran = self.status if self._interruption == 'status' else f'Going to {place}'
            self._say(f'Interrupted: {ran}')
        if line == 'stop':
            self._coast()
            self.status = 'Stopping'
            self._say('Stopping')
            words = self._words
            self._later(self._braking_time, lambda: self._stand(words))
        elif self.docked and line != 'dock':
            self.obey(None, line)
            self.status = _UNDOCKING
            self._say(self.status)
            words = self._words
            self._later(UNDOCKING_TIME, lambda: self._leave_dock(words))
        else:
            self.obey(None, line)
            self.status = ('DockingState: Docking ForcedState: Unforced ChargeState: Not'
                           if line == 'dock' else f'Going to {self.goal}')
            self._say(self.status)

    def hear_another(self, line: str) -> None:
        """Takes a command of another client. All clients receive the result."""
        self.receive(line)

    def _leave_dock(self, words: int) -> None:
        if words == self._words:
            self._say(_UNDOCKED)
            self.status = f'Going to {self.goal}'
            self._say(self.status)

    def _coast(self) -> None:
        """Shortens the path to the distance that the braking robot still covers."""
        way, left, here = self._way, self.speed * self._braking_time / 2.0, self.position
        self.goal, self._way = None, []
        for point in way:
            length = math.dist(here, point)
            if length > left:
                x, y = (a + left / length * (b - a) for a, b in zip(here, point))
                self._way.append((x, y))
                break
            self._way.append(point)
            here, left = point, left - length

    def _stand(self, words: int) -> None:
        if words == self._words:  # no command has come while it braked
            self.halt(ActivityKind.STOPPED)
            self.status = 'Stopped'
            self._say('Stopped')

    def move(self, now: float) -> Optional[str]:
        """Drives on; returns the goal at which it has just arrived."""
        goal = self.goal
        self.step(now)
        if goal is None or self.goal is not None:
            return None
        self.status = _DOCKED if goal == 'dock' else f'Arrived at {goal}'
        self._say(self.status)
        return goal
