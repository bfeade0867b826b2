"""A fleet at work: a discrete-event simulation with the planning core, missions and late robots.

A robot begins a drive as soon as its precedence allows, and at the last moment (nothing is released
ahead). When a mission ends, its robot gets the next one, and all robots are planned again from
their present places.
"""
from __future__ import annotations

import time
from bisect import bisect_right
from dataclasses import dataclass, field
from random import Random
from typing import Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.planning.planner import FleetPlanner
from graph_fleet_manager.planning.tasks import Outcome, PlannedDrive, Task


class Delays(NamedTuple):
    """Delays of robots: each drive takes between 1 and `slower` times as long as planned.

    About every `between_stalls` s of driving the robot stands for `stall` s.
    """

    slower: float = 1.1
    between_stalls: float = 800.0
    stall: float = 20.0


class Driven(NamedTuple):
    """One drive as it happened: at times `at` the robot was at fractions `share`."""

    edge: int
    at: Tuple[float, ...]
    share: Tuple[float, ...]

    def share_at(self, now: float) -> float:
        """The fraction driven at a time."""
        if now >= self.at[-1]:
            return 1.0
        k = max(bisect_right(self.at, now) - 1, 0)
        span = self.at[k + 1] - self.at[k]
        part = (now - self.at[k]) / span if span > 0.0 else 1.0
        return self.share[k] + part * (self.share[k + 1] - self.share[k])

    def time_of(self, share: float) -> float:
        """The time at which a fraction is driven."""
        for k in range(len(self.at) - 1):
            if share <= self.share[k + 1]:
                step = self.share[k + 1] - self.share[k]
                part = (share - self.share[k]) / step if step > 0.0 else 0.0
                return self.at[k] + max(part, 0.0) * (self.at[k + 1] - self.at[k])
        return self.at[-1]


@dataclass
class RobotState:
    """One robot in the run."""

    name: str
    type: RobotType
    vertex: int
    plan: Tuple[PlannedDrive, ...] = ()
    done: int = 0
    """The number of drives of the plan that have begun; the last of them may be under way."""
    driving: Optional[Driven] = None
    destinations: Tuple[int, ...] = ()
    served: int = 0
    log: List[Driven] = field(default_factory=list)


class FleetRun:
    """Missions for robots on one graph; `next_mission` draws the destinations of a robot's next
    one.
    """

    def __init__(self, planner: FleetPlanner, robots: Mapping[str, Tuple[RobotType, int]],
                 next_mission: Callable[[Random, int], Sequence[int]], delays: Delays, seed: int,
                 rounds: Optional[int] = 20, time_limit: float = 60.0) -> None:
        self.planner = planner
        self.robots = {name: RobotState(name, kind, vertex)
                       for name, (kind, vertex) in robots.items()}
        self._next_mission = next_mission
        self._delays = delays
        self._random = Random(seed)
        self._rounds = rounds
        self._time_limit = time_limit
        self._needs: Dict[Tuple[str, int], List[Tuple[str, int, float]]] = {}
        self.now = 0.0
        self.missions = 0
        self.planning_times: List[float] = []
        """CPU time of each plan, in s."""
        self.unserved: Dict[str, str] = {}
        self.longest_standstill = 0.0
        """The longest time in which no robot was driving, in s."""

    def run(self, seconds: float) -> None:
        """Runs for the given time."""
        for robot in self.robots.values():
            robot.destinations = tuple(self._next_mission(self._random, robot.vertex))
        self._plan()
        while True:
            self._begin_drives()
            ends = [(r.driving.at[-1], r.name) for r in self.robots.values() if r.driving]
            if not ends:
                if self._plan_again_when_stuck(seconds):
                    continue
                return
            # Next event: a drive ends, or a robot is far enough for another robot to begin.
            self.now = min(min(ends)[0], self._next_release())
            if self.now > seconds:
                return
            if self._end_drives():
                self._plan()

    def _plan_again_when_stuck(self, seconds: float) -> bool:
        """Plans again 1 s later, as the fleet manager would, because no robot drives."""
        self.longest_standstill += 1.0
        self.now += 1.0
        if self.longest_standstill > 300.0 or self.now > seconds:
            return False
        self._plan()
        return True

    def _end_drives(self) -> bool:
        """Ends the drives that end now; true if a mission ended."""
        ended = False
        for robot in self.robots.values():
            if robot.driving and robot.driving.at[-1] <= self.now:
                graph = self.planner.network.graph
                robot.vertex = graph.end_vertex(robot.driving.edge).id
                robot.driving = None
                while robot.destinations and robot.destinations[0] == robot.vertex:
                    robot.destinations = robot.destinations[1:]
                    if not robot.destinations:
                        robot.served += 1
                        self.missions += 1
                        ended = True
                if not robot.destinations:
                    robot.destinations = tuple(self._next_mission(self._random, robot.vertex))
        return ended

    # -- driving by precedence --------------------------------------------------------------------

    def _begin_drives(self) -> None:
        """Begins each drive whose time has come."""
        for robot in self.robots.values():
            if (robot.driving is None and robot.done < len(robot.plan)
                    and self._may_begin_at(robot) <= self.now):
                drive = robot.plan[robot.done]
                robot.driving = self._drive(drive.edge, drive.end - drive.start)
                robot.log.append(robot.driving)
                robot.done += 1

    def _next_release(self) -> float:
        return min((self._may_begin_at(robot) for robot in self.robots.values()
                    if robot.driving is None and robot.done < len(robot.plan)),
                   default=float('inf'))

    def _may_begin_at(self, robot: RobotState) -> float:
        """The time at which others are out of the way of a robot's next drive, or infinity."""
        begin = self.now
        for first, before, fraction in self._needs.get((robot.name, robot.done), ()):
            other = self.robots[first]
            if other.done <= before:
                return float('inf')
            if other.done == before + 1 and other.driving is not None:
                begin = max(begin, other.driving.time_of(fraction))
        return begin

    def _drive(self, edge: int, seconds: float) -> Driven:
        seconds *= self._random.uniform(1.0, self._delays.slower)
        if self._random.random() < seconds / self._delays.between_stalls:
            stop = self._random.random()
            return Driven(edge, (self.now, self.now + stop * seconds,
                                 self.now + stop * seconds + self._delays.stall,
                                 self.now + seconds + self._delays.stall), (0.0, stop, stop, 1.0))
        return Driven(edge, (self.now, self.now + seconds), (0.0, 1.0))

    # -- planning ---------------------------------------------------------------------------------

    def _plan(self) -> None:
        tasks = []
        for robot in self.robots.values():
            driving = robot.driving
            tasks.append(Task(
                robot.name, robot.type, None if driving else robot.vertex,
                (driving.edge,) if driving else (),
                min(driving.share_at(self.now), 1.0 - 1e-9) if driving else 0.0,
                destinations=robot.destinations,
                kept=robot.plan[robot.done:] if self.planning_times else None))
        begun = time.process_time()
        outcome = self.planner.plan(tasks, (), time.monotonic() + self._time_limit, self._rounds)
        self.planning_times.append(time.process_time() - begun)
        self._take(outcome)

    def _take(self, outcome: Outcome) -> None:
        self.unserved = dict(outcome.unserved)
        for name, robot in self.robots.items():
            robot.plan = outcome.drives[name]
            robot.done = 1 if robot.driving else 0
        self._needs = {}
        for constraint in outcome.precedence:
            self._needs.setdefault((constraint.then, constraint.drive), []).append(
                (constraint.first, constraint.before, constraint.fraction))
