"""Checks the planner's input, which uses the ids of the graph, and makes agents from it."""
from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import chain
from math import hypot, inf
from typing import Dict, FrozenSet, Iterable, List, NamedTuple, Optional, Sequence, Set, Tuple

from fleet_core.fleet import RobotType
from fleet_core.geometry.exclusions import ROUNDING
from fleet_core.planning.agents import LATER, Agent, PathQuery, Rests
from fleet_core.planning.mid_edge import MidEdgePosition
from fleet_core.planning.plans import Drive
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.tasks import CannotPlan, Task


class Problem:
    """The agents of a list of tasks.

    parking  -- ids of the vertices at which robots may be parked; a dock only for types that list
                this dock
    reserved -- ids of the vertices at which no robot is parked if there is enough other parking
    """

    def __init__(self, reservations: ReservationTable, tasks: Sequence[Task],
                 parking: Iterable[int], reserved: Iterable[int] = ()) -> None:
        self._reservations = reservations
        self._network: RoadNetwork = reservations.network
        some = frozenset(self._network.index[id] for id in parking)
        others = some - frozenset(self._network.index[id] for id in reserved)
        is_enough = len(others) >= sum(not task.stays for task in tasks)
        self._parking = others if is_enough else some
        self.tasks: Dict[str, Task] = {task.name: task for task in tasks}
        self._wanted = {name: frozenset(self._vertices(task.destinations))
                        for name, task in self.tasks.items()}
        self._robots_to = Counter(chain.from_iterable(self._wanted.values()))
        for kind in reservations.kinds:  # all at once: one by one this takes several times as long
            self._network.paths_to(kind, [vertex for name, task in self.tasks.items()
                                          if task.type == kind for vertex in self._wanted[name]])
        self._allowed = {kind: self._parking_of(kind) for kind in reservations.kinds}
        """The vertices at which robots of a type may be parked."""
        self._quiet = {kind: allowed.difference(self._robots_to)
                       for kind, allowed in self._allowed.items()}
        """The vertices of `_allowed` that are not the destination of any robot."""
        self._everywhere = frozenset(range(self._network.vertices)) - self._network.docks
        self.agents: Dict[str, Agent] = {
            name: self._agent(task) for name, task in self.tasks.items()}

    def _parking_of(self, kind: RobotType) -> FrozenSet[int]:
        docks = frozenset(self._network.index[id] for id in kind.docks or ()
                          if id in self._network.index)
        return (self._parking - self._network.docks) | (self._parking & docks)

    def rests(self, kind: RobotType) -> FrozenSet[int]:
        """Returns the vertices at which robots of a type may be parked."""
        return self._allowed[kind]

    def _rests_of(self, task: Task) -> Rests:
        """Returns the vertices at which a robot may be parked.

        Destinations of other robots are left out if enough vertices remain.
        """
        allowed, quiet = self._allowed[task.type], self._quiet[task.type]
        own = frozenset(vertex for vertex in self._wanted[task.name]
                        if self._robots_to[vertex] == 1 and vertex in allowed)
        is_enough = len(quiet) + len(own) >= len(self.tasks)
        return Rests(quiet, own) if is_enough else Rests(allowed)

    def with_rests(self, agent: Agent, rests: FrozenSet[int]) -> Agent:
        """Returns the same agent, allowed to end at `rests`."""
        task = self.tasks[agent.name]
        return agent._replace(query=self._query(task, agent.fixed, agent.mid_edge,
                                                  Rests(rests)))

    def without_destinations(self, agent: Agent) -> Agent:
        """Returns the same agent without destinations, so that it is only parked."""
        task = replace(self.tasks[agent.name], destinations=(), dwells=())
        return agent._replace(query=self._query(task, agent.fixed, agent.mid_edge,
                                                  agent.query.rests or Rests(self._everywhere)))

    def _agent(self, task: Task) -> Agent:
        fixed = self._fixed(task)
        mid_edge = self._mid_edge(task)
        rests: Optional[Rests] = None
        if not task.stays:
            rests = self._rests_of(task)
        elif not task.destinations:
            rests = Rests(self._everywhere, frozenset(
                self._vertices(() if task.vertex is None else (task.vertex,))))
        start = -1
        if task.vertex is not None:
            start = self._network.index[task.vertex]
        elif fixed:
            start = self._network.origin[fixed[0].drive]
        return Agent(task.name, task.type, start, fixed,
                     self._query(task, fixed, mid_edge, rests), task.priority, mid_edge)

    def _query(self, task: Task, fixed: Sequence[Drive], mid_edge: Optional[MidEdgePosition],
                rests: Optional[Rests]) -> PathQuery:
        network = self._network
        ready = (fixed[-1].end if fixed else 0.0) + task.ready
        vertex = -1
        origins: Dict[int, float] = {}
        if mid_edge is not None:
            for _, end, seconds in mid_edge.exits(network, task.type):
                origins[end] = min(seconds, origins.get(end, inf))
        else:
            assert fixed or task.vertex is not None  # `check` guarantees this
            vertex = (network.destination(fixed[-1].drive) if fixed
                      else network.index[task.vertex or 0])
            origins[vertex] = 0.0
        later = 1.0 if task.stays else LATER
        return PathQuery(network, task.type, vertex, origins, ready,
                         self._vertices(task.destinations), task.dwells, rests, later)

    def _fixed(self, task: Task) -> Tuple[Drive, ...]:
        """Returns the released drives with their times. The robot drives them without a wait."""
        times, now, drives = self._network.times(task.type), 0.0, []
        for k, edge in enumerate(task.released):
            begun = task.begun if k == 0 else 0.0
            drive = self._network.drive(edge)
            seconds = times[drive]
            if seconds == inf:  # forbidden after the grant: the robot drives at its own speed
                seconds = self._network.length(drive) / task.type.speed
            drives.append(Drive(drive, now, now + seconds * (1.0 - begun), begun))
            now = drives[-1].end
        return tuple(drives)

    def _mid_edge(self, task: Task) -> Optional[MidEdgePosition]:
        if task.mid_edge is None:
            return None
        edge, fraction = task.mid_edge
        curve = self._network.graph.curve(edge)
        return MidEdgePosition(self._network.drive(edge), fraction,
                               *curve.point_at(fraction * curve.length))

    def _vertices(self, ids: Iterable[int]) -> Tuple[int, ...]:
        return tuple(self._network.index[id] for id in ids)

    # -- checks -----------------------------------------------------------------------------------

    def too_near(self) -> List[Tuple[str, str]]:
        """Returns pairs of robots whose places exclude each other when planning begins."""
        by_place: Dict[int, List[_Held]] = {}
        held: List[_Held] = []
        for agent in self.agents.values():
            for one in _held_by(agent, self._network):
                by_place.setdefault(one.place, []).append(one)
                held.append(one)
        found: Set[Tuple[str, str]] = set()
        for one in held:
            for kind in self._reservations.kinds:
                for place in self._excluded(one, kind):
                    for other in by_place.get(place, ()):
                        if (other.name != one.name and other.kind == kind
                                and self._is_near(one, other)
                                and self._still_meets(one, other)
                                and self._still_meets(other, one)):
                            found.add((min(one.name, other.name), max(one.name, other.name)))
        return sorted(found)

    def _excluded(self, held: _Held, other: RobotType) -> List[int]:
        if held.mid_edge is not None:
            return list(self._reservations.places_near(held.kind, other, held.mid_edge))
        return self._reservations.blocking[held.kind, other].excluded(held.place)

    def _is_near(self, one: _Held, other: _Held) -> bool:
        """Returns whether `one` is too near to `other`, which stands between two vertices.

        True if `other` is not between vertices: then the places of both have been compared already.
        """
        if other.mid_edge is None:
            return True
        if one.mid_edge is None:
            return one.place in self._excluded(other, one.kind)
        apart = self._reservations.apart(one.kind, other.kind)
        return hypot(one.mid_edge.x - other.mid_edge.x,
                     one.mid_edge.y - other.mid_edge.y) < apart - ROUNDING

    def _still_meets(self, one: _Held, other: _Held) -> bool:
        """Returns whether the part of a drive ahead of `one` excludes the place of `other`.

        The part behind the robot does not count.
        """
        if one.begun == 0.0 or one.mid_edge is not None:
            return True
        blocks = self._reservations.blocking[one.kind, other.kind].drive(one.drive)
        slot = (other.place + self._network.drives if other.place < self._network.vertices
                else 2 * (other.place - self._network.vertices))
        return any(clear > one.begun for s, clear, _ in blocks if s == slot)


class _Held(NamedTuple):
    """A place that a robot holds when planning begins."""

    name: str
    kind: RobotType
    place: int
    drive: int
    begun: float
    mid_edge: Optional[MidEdgePosition]


def _held_by(agent: Agent, network: RoadNetwork) -> List[_Held]:
    name, kind, mid_edge = agent.name, agent.kind, agent.mid_edge
    if mid_edge is not None:
        return [_Held(name, kind, network.vertices + (mid_edge.drive >> 1), mid_edge.drive, 0.0,
                      mid_edge)]
    if not agent.fixed:
        return [_Held(name, kind, agent.vertex, -1, 0.0, None)]
    return [_Held(name, kind, network.vertices + (drive.drive >> 1), drive.drive, drive.begun, None)
            for drive in agent.fixed]


def check(network: RoadNetwork, tasks: Sequence[Task]) -> None:
    """Raises CannotPlan if a robot has no place or several, or if an id or a number is invalid."""
    for task in tasks:
        _check_place(task)
        _check_ids(network, task)
        _check_numbers(task)


def _check_place(task: Task) -> None:
    places = (task.vertex is not None, bool(task.released), task.mid_edge is not None)
    if places not in ((True, False, False), (True, True, False), (False, True, False),
                      (False, False, True)):
        raise CannotPlan(f'Robot {task.name} must stand on one vertex, drive, or stand on one '
                         'edge; say which.')


def _check_ids(network: RoadNetwork, task: Task) -> None:
    for id in (*task.destinations, *(() if task.vertex is None else (task.vertex,))):
        if id not in network.index:
            raise CannotPlan(f'Robot {task.name}: the graph has no vertex {id}; choose another.')
    for id in (*task.released, *(() if task.mid_edge is None else task.mid_edge[:1])):
        if abs(id) not in network.edge_index:
            raise CannotPlan(f'Robot {task.name}: the graph has no edge {id}; choose another.')
    for first, second in zip(task.released, task.released[1:]):
        if network.destination(network.drive(first)) != network.origin[network.drive(second)]:
            raise CannotPlan(f'Robot {task.name}: edge {second} does not begin where edge '
                             f'{first} ends; correct its route.')


def _check_numbers(task: Task) -> None:
    numbers = (task.begun, task.ready, *task.dwells,
               *(() if task.mid_edge is None else task.mid_edge[1:]))
    if not all(0.0 <= number < inf for number in numbers) or task.begun >= 1.0:
        raise CannotPlan(f'Robot {task.name}: fractions and times must be numbers, 0 or more; '
                         'fractions must be below 1.')
    if task.dwells and len(task.dwells) != len(task.destinations):
        raise CannotPlan(f'Robot {task.name} has {len(task.destinations)} destinations but '
                         f'{len(task.dwells)} dwells; give one for each.')
