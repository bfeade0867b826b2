"""Decides when a simulated robot reports: at changes, when its place matters, and every few s.

A real robot reports ten times a second, but few of these reports change anything. A simulated robot
reports its place only when a decision of the supervisor can depend on this place:

- when the end of its route comes as near as the distance that the supervisor grants ahead,
- when it leaves a place for which another robot waits according to the plan. This time is computed.
  As long as it cannot be computed, the robot reports every `WAITED` s.
- when any robot ends its route or the status of a mission changes: the supervisor may then ask the
  planner, and the question contains the places of all robots.

In addition each robot reports every few seconds, so that it does not count as silent.
"""
from __future__ import annotations

import math
from typing import Dict, List, Mapping, NamedTuple, Protocol, Set, Tuple

from fleet_core.fleet import RobotType
from fleet_core.supervision.supervisor import Supervisor
from trajectory_graph import Graph

WAITED = 0.5        # s, longest time between two reports of a robot for which another waits
_AGAIN = 0.2        # s, the same after the robot has left the place that the other awaits
_BEHIND = 0.001     # m; added to a distance, so that rounding does not put the robot before it
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
    """The properties of a simulated robot that determine when it reports."""

    graph: Graph
    kind: RobotType

    @property
    def is_driving(self) -> bool:
        """Whether the robot has a route that is not finished."""

    @property
    def news(self) -> object:
        """The values whose changes are reported at once."""

    def seconds_left(self, ahead: float) -> float:
        """Returns the seconds until only `ahead` m of its route are left.

        Infinite: no more than `ahead` m are left now, or this time is unknown.
        """

    def seconds_past(self, number: int, fraction: float, distance: float) -> float:
        """Returns the seconds until the robot is `distance` m past the point at `fraction` of an
        edge.

        0: the robot is already there. Infinite: it stops earlier, or this time is unknown.

        number -- number of the edge in the robot's route record
        """


class ReportTimes:
    """The time of each robot's next report."""

    def __init__(self, rhythm: Rhythm) -> None:
        self._rhythm = rhythm
        self._told: Dict[str, Tuple[float, object]] = {}
        self._touched: Set[str] = set()
        """Robots that were driven, or got an order, since `is_due` last compared their news."""
        self._moved: Set[str] = set()
        """Robots that were driven, or got an order, since the supervisor's last event."""
        self._granted: Dict[str, float] = {}
        """For each robot: when the end of its route comes as near as the distance that the
        supervisor grants ahead.
        """
        self._waited: Dict[str, float] = {}
        """For each robot for which another robot waits: when its place matters."""
        self._asked = -math.inf
        """The last time at which the places of all driving robots mattered."""

    def touch(self, name: str) -> None:
        """Notes that a robot was driven, or got an order."""
        self._touched.add(name)
        self._moved.add(name)

    def ask_all(self, now: float) -> None:
        """Notes that the supervisor may ask the planner now, so the places of all robots matter."""
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
        """Computes, after an event of the supervisor, when the robots' places will matter.

        Precondition: each robot has been driven at least to the last change of its motion.
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
        """Returns for each waiting robot the time at which the place of the robot matters to it."""
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
    """Returns for each robot the robots that wait for it. They wait for it in the plan, or they
    wait for a resource that it claims.
    """
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
