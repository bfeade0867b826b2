"""When simulated robots report: at each change, when their place matters, and else periodically.

A real robot reports ten times a second. Most of these reports change nothing. Here a robot reports
its place when a decision of the supervisor can depend on it:

- no more of its route is left than the supervisor grants ahead,
- it leaves a place for which another robot waits by the plan. That moment is computed.
- Where it cannot be computed for what another robot waits, it reports every `WAITED` s.
- A robot ends its route, or the status of a mission changes: a question to the planner tells how
  far all robots have driven.

Else it reports seldom, so that it does not count as silent.
"""
from __future__ import annotations

import math
from typing import Dict, List, Mapping, NamedTuple, Protocol, Set, Tuple

from fleet_core.fleet import RobotType
from fleet_core.supervision.supervisor import Supervisor
from trajectory_graph import Graph

WAITED = 0.5        # s between two reports of a robot for which another waits, at most
_AGAIN = 0.2        # s between two reports of a robot that has left such a place already
_BEHIND = 0.001     # m behind a point, so that rounding does not put the robot before it
_TOGETHER = 1e-6    # s; events with a smaller time difference happen at the same time


class Rhythm(NamedTuple):
    """Periods of repeated actions, in virtual s; 0: in every step.

    driving    -- between two reports of a driving robot if nothing changes
    standing   -- between two reports of a standing robot if nothing changes
    supervisor -- between two ticks of the supervisor if no message comes
    room       -- between two checks of the distances between robots
    """

    driving: float = 0.0
    standing: float = 0.0
    supervisor: float = 0.0
    room: float = 0.0


class ReportingRobot(Protocol):
    """What a simulated robot says about its next reports."""

    graph: Graph
    kind: RobotType

    @property
    def is_driving(self) -> bool:
        """Whether the robot has a route that is not finished."""

    @property
    def news(self) -> object:
        """The part of the report that is sent at once when it changes."""

    def seconds_left(self, ahead: float) -> float:
        """Returns the s until no more than `ahead` m of its route are left.

        Infinite: it is so already, or this cannot be told.
        """

    def seconds_past(self, number: int, fraction: float, distance: float) -> float:
        """Returns the s until it is so many m behind this fraction of an edge of its route.

        number -- of the edge in its route record
        0: it is so already. Infinite: it stops before, or this cannot be told.
        """


class ReportTimes:
    """The time of each robot's next report."""

    def __init__(self, rhythm: Rhythm) -> None:
        self._rhythm = rhythm
        self._told: Dict[str, Tuple[float, object]] = {}
        self._touched: Set[str] = set()
        """Robots that were driven, or got an order, since they were asked for news."""
        self._moved: Set[str] = set()
        """The same since the supervisor's last event."""
        self._granted: Dict[str, float] = {}
        """By robot: when only what is granted ahead is left of its route."""
        self._waited: Dict[str, float] = {}
        """By robot for which another one waits: when its place matters."""
        self._asked = -math.inf
        """When the places of all driving robots mattered last."""

    def touch(self, name: str) -> None:
        """Notes that a robot was driven, or got an order."""
        self._touched.add(name)
        self._moved.add(name)

    def ask_all(self, now: float) -> None:
        """Notes that the supervisor may ask the planner now, so that all places matter."""
        self._asked = now

    def is_due(self, name: str, robot: ReportingRobot, now: float) -> bool:
        """Returns whether a robot reports now."""
        last, before = self._told.get(name, (-math.inf, None))
        pause = self._rhythm.driving if robot.is_driving else self._rhythm.standing
        due = min(last + pause, self._granted.get(name, math.inf), self._waited.get(name, math.inf))
        if now >= due - _TOGETHER or last < self._asked - _TOGETHER and robot.is_driving:
            return True
        if name not in self._touched:
            return False
        self._touched.discard(name)
        return robot.news != before

    def reported(self, name: str, robot: ReportingRobot, now: float) -> None:
        """Notes that a robot reports now."""
        self._told[name] = now, robot.news
        self._granted.pop(name, None)
        self._waited.pop(name, None)

    def follow(self, supervisor: Supervisor, robots: Mapping[str, ReportingRobot],
               now: float) -> None:
        """Computes when places matter, after an event of the supervisor.

        All robots have been driven as far as their motion has changed.
        """
        if not self._rhythm.driving:
            return
        for name in self._moved:
            self._granted[name] = now + robots[name].seconds_left(
                supervisor.robots[name].settings.release_ahead - _BEHIND)
        self._moved.clear()
        self._waited = {
            name: min(self._matters_at(supervisor, name, robots[name], waiting, now))
            for name, waiting in _waited_for(supervisor).items()
            if name in robots and robots[name].is_driving}

    def _matters_at(self, supervisor: Supervisor, name: str, robot: ReportingRobot,
                    waiting: List[str], now: float) -> List[float]:
        """Returns when the place of a robot matters to each robot that waits for it."""
        plan, record = supervisor.plan_executor.plan, supervisor.robots[name].record
        last = self._told.get(name, (now, None))[0]
        found = []
        for other in waiting:
            own = None if plan is None else plan.plan_of(other)
            turn = None if plan is None or own is None else plan.turn_behind(
                other, supervisor.robots[other].record.end - own.base, name)
            if turn is None:
                found.append(last + WAITED)
                continue
            seconds = robot.seconds_past(*turn, record.margin(0.0) + _BEHIND)
            found.append(now + seconds if seconds > 0.0 else max(now, last + _AGAIN))
        return found


def _waited_for(supervisor: Supervisor) -> Dict[str, List[str]]:
    """Returns, by robot, the robots that wait for it by the plan, or for what it claims."""
    found: Dict[str, List[str]] = {}
    executor, claims = supervisor.plan_executor, supervisor.interlocking.claims
    for name, other in executor.waits_for.items():
        if other:
            found.setdefault(other, []).append(name)
    wanted = {name: resource.name for name, resource in executor.lacks.items()}
    for name in supervisor.robots:
        standing = supervisor.stations.standing_of(name)
        if standing is not None:
            wanted[name] = standing.station.name
    for name, resource in wanted.items():
        for other in claims.holders(resource):
            if other != name:
                found.setdefault(other, []).append(name)
    return found
