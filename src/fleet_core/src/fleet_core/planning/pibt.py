"""PIBT: one step of all robots at once. Robots choose their moves in the order of priorities.

If a robot is in the way of a more urgent robot, it is asked to move. It then asks the robots that
are in its own way (Okumura et al., AIJ 2022).
"""
from __future__ import annotations

import time
from math import inf
from random import Random
from typing import AbstractSet, Dict, List, Mapping, Optional, Sequence, Set, Tuple

from fleet_core.fleet import RobotType
from fleet_core.planning.agents import Agent
from fleet_core.planning.mid_edge import MidEdgePosition
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.road_network import Roads

STAY = -1
# number of drives ahead of a robot that others keep free when they make room for it
_FAR = 12


_Neighbours = List[Tuple[RobotType, List[int], List[int]]]
"""For each robot type, the vertices and the edges that a drive excludes."""


class PibtAgent:
    """One robot in the search over configurations.

    A robot that begins between two vertices begins at an extra vertex, numbered after all vertices
    of the graph. From this vertex only the rest of a drive leads away. No drive leads back to it.

    name, kind -- of the robot
    begin      -- its first state: leg * vertices + vertex
    targets    -- the vertex that ends each leg; the robot stays at the last target
    roads      -- the roads that are open to it
    """

    def __init__(self, agent: Agent, rest: Optional[int], vertices: int, vertex: int,
                 estimates: Sequence[Sequence[float]], roads: Roads) -> None:
        query = agent.query
        self.name, self.kind = agent.name, agent.kind
        self.targets = (*query.destinations, *(() if rest is None else (rest,)))
        self._vertices = vertices
        self._estimates = estimates
        self.roads = roads
        self.begin = self.arrive(0, vertex)

    def arrive(self, leg: int, vertex: int) -> int:
        """Returns the state of a robot that arrives at a vertex on a leg."""
        last = len(self.targets) - 1
        while leg < last and self.targets[leg] == vertex:
            leg += 1
        return leg * self._vertices + vertex

    def vertex(self, state: int) -> int:
        """Returns the vertex of a state."""
        return state % self._vertices

    def leg(self, state: int) -> int:
        """Returns the leg of a state."""
        return state // self._vertices

    def estimate(self, state: int) -> Sequence[float]:
        """Returns the seconds from each vertex to the end of the leg."""
        return self._estimates[state // self._vertices]

    def to_go(self, state: int) -> float:
        """Returns the seconds to the end of the leg."""
        return self.estimate(state)[state % self._vertices]

    def has_path(self, deadline: float) -> bool:
        """Returns whether the robot could reach its targets in order without traffic.

        Also returns False if this is not known by the deadline (monotonic s).
        """
        vertex = self.vertex(self.begin)
        for target in self.targets[self.leg(self.begin):]:
            reached, ahead = {vertex}, [vertex]
            while ahead and target not in reached:
                for _, end, _ in self.roads[ahead.pop()]:
                    if end not in reached:
                        reached.add(end)
                        ahead.append(end)
            if target not in reached or time.monotonic() > deadline:
                return False
            vertex = target
        return True

    def is_end(self, state: int) -> bool:
        """Returns whether the robot is where it is to stay."""
        leg, vertex = divmod(state, self._vertices)
        return leg == len(self.targets) - 1 and vertex == self.targets[-1]


class Pibt:
    """Makes steps for robots on a graph; `rests` are the vertices where they are to end.

    Robots that are booked in the reservation table stand there for ever. The agents are not booked.
    Most attributes are tables that each choice of a robot reads: neighbours and the present step.
    """

    def __init__(self, reservations: ReservationTable, agents: Sequence[Agent],
                 rests: Sequence[Optional[int]], random: Random) -> None:
        network = reservations.network
        self._random = random
        self._reservations = reservations
        self._first_edge = network.vertices
        self._open: Dict[Tuple[RobotType, int], Roads] = {}
        self._kinds = [t.kind for t in agents]
        self._mid_edge: Dict[int, MidEdgePosition] = {
            robot: t.mid_edge for robot, t in enumerate(agents) if t.mid_edge is not None}
        self.agents: List[PibtAgent] = [
            self._agent(robot, t, rest) for robot, (t, rest) in enumerate(zip(agents, rests))]
        self._near: Dict[Tuple[RobotType, int], _Neighbours] = {}
        self._near_rest: Dict[Tuple[int, int], _Neighbours] = {}
        self._near_point: Dict[Tuple[int, RobotType], Mapping[int, Tuple[float, float]]] = {}

    def _agent(self, robot: int, agent: Agent, rest: Optional[int]) -> PibtAgent:
        network = self._reservations.network
        targets = (*agent.query.destinations, *(() if rest is None else (rest,)))
        estimates = [network.estimates(agent.kind, target) for target in targets]
        roads, vertices = self._free_roads(agent), self._first_edge
        if not self._mid_edge:
            return PibtAgent(agent, rest, vertices, agent.query.vertex, estimates, roads)
        own, vertex = vertices + robot, agent.query.vertex
        if agent.mid_edge is not None:
            vertex = own
            exits = [exit for exit in agent.mid_edge.exits(network, agent.kind)
                     if not self._reservations.against_rest(agent.kind, agent.mid_edge, exit[0])]
            roads = [*roads, *([] for _ in range(robot)), exits]
            estimates[0] = [*estimates[0], *(inf for _ in range(robot)), min(
                (seconds + estimates[0][end] for _, end, seconds in exits), default=inf)]
        return PibtAgent(agent, rest, vertices + len(self._kinds), vertex, estimates, roads)

    def _free_roads(self, agent: Agent) -> Roads:
        """Returns the roads of an agent that do not lead past a robot that stands for ever."""
        roads = agent.query.roads
        key = agent.kind, id(roads)
        if key not in self._open:
            bookings = self._reservations.slots[agent.kind].row
            self._open[key] = [[road for road in away if not bookings(road[0])] for away in roads]
        return self._open[key]

    def is_end(self, configuration: Sequence[int]) -> bool:
        """Returns whether each robot is where it is to stay."""
        return all(agent.is_end(state) for agent, state in zip(self.agents, configuration))

    def choices(self, robot: int, state: int) -> List[int]:
        """Returns all moves of one robot in a step, in random order."""
        agent = self.agents[robot]
        moves = [STAY, *(road[0] for road in agent.roads[agent.vertex(state)])]
        self._random.shuffle(moves)
        return moves

    def step(self, configuration: Sequence[int], order: Sequence[int], forced: Mapping[int, int]
             ) -> Optional[Tuple[Tuple[int, ...], Dict[int, int], List[Tuple[int, int]]]]:
        """Returns the next configuration, the drives that lead there, and the changes of priority.

        In the third value each pair names a robot and another robot that lets it go first. Returns
        None if the forced moves exclude each other.
        """
        agents = self.agents
        self._vertex = [agent.vertex(state) for agent, state in zip(agents, configuration)]
        self._states = configuration
        self._at = {vertex: robot for robot, vertex in enumerate(self._vertex)}
        self._still_mid_edge = [robot for robot in self._mid_edge if self._is_mid_edge(robot)]
        self._moves: Dict[int, Tuple[int, int]] = {}
        self._decided: Set[int] = set()
        self._taken: Dict[RobotType, Set[int]] = {kind: set() for kind in self._reservations.kinds}
        self._promoted: List[Tuple[int, int]] = []
        for robot, move in forced.items():
            self._decided.add(robot)
            if move != STAY:
                if move >> 1 in self._taken[self._kinds[robot]] or self._in_the_way(robot, move):
                    return None
                self._go(robot, move)
        for robot in order:
            if robot not in self._decided:
                self._decide(robot)
        reached = list(configuration)
        for robot, (_, end) in self._moves.items():
            reached[robot] = agents[robot].arrive(agents[robot].leg(configuration[robot]), end)
        return tuple(reached), {robot: move[0] for robot, move in self._moves.items()}, \
            self._promoted

    def _decide(self, robot: int) -> None:
        """Chooses the move of a robot: towards the end of its leg or, if that is impossible, to
        stay.
        """
        self._decided.add(robot)
        agent, vertex = self.agents[robot], self._vertex[robot]
        estimate = agent.estimate(self._states[robot])
        options = sorted((estimate[end], drive, end) for drive, end, _ in agent.roads[vertex]
                         if estimate[end] < estimate[vertex])
        for _, drive, _ in options:
            if drive >> 1 in self._taken[agent.kind]:
                continue
            others = self._in_the_way(robot, drive)
            if not others:
                self._go(robot, drive)
                return
            path = self._path(robot)
            if all(self._leaves(other, path) for other in others):
                return
            stuck = next(other for other in others if other not in self._moves)
            if self._stands_on(robot, self._path(stuck)) and self._leave(robot, self._path(stuck)):
                self._promoted.append((stuck, robot))
                return

    def _leaves(self, robot: int, avoid: AbstractSet[int]) -> bool:
        """Makes a robot in the way leave. Returns whether it leaves, or makes another one leave."""
        if robot in self._decided:
            return robot in self._moves
        return self._leave(robot, avoid)

    def _leave(self, robot: int, avoid: AbstractSet[int]) -> bool:
        """Moves a robot anywhere, preferably not onto `avoid`, or asks others to make room."""
        self._decided.add(robot)
        agent, vertex = self.agents[robot], self._vertex[robot]
        estimate = agent.estimate(self._states[robot])
        options = sorted((end in avoid, estimate[end], self._random.random(), drive)
                         for drive, end, _ in agent.roads[vertex])
        for _, _, _, drive in options:
            if drive >> 1 in self._taken[agent.kind]:
                continue
            others = self._in_the_way(robot, drive)
            if not others:
                self._go(robot, drive)
                return True
            if all(self._leaves(other, avoid) for other in others):
                return True
        return False

    def _go(self, robot: int, drive: int) -> None:
        self._moves[robot] = (drive, self._reservations.network.destination(drive))
        for kind, _, edges in self._neighbours(robot, drive):
            self._taken[kind].update(edges)

    def _in_the_way(self, robot: int, drive: int) -> List[int]:
        """Returns the robots whose places at the beginning of this step exclude a drive."""
        at, kinds = self._at, self._kinds
        found = []
        for kind, vertices, _ in self._neighbours(robot, drive):
            for vertex in vertices:
                other = at.get(vertex)
                if other is not None and other != robot and kinds[other] == kind:
                    found.append(other)
        for other in self._still_mid_edge:
            if other != robot and self._passes(robot, drive, other):
                found.append(other)
        return found

    def _neighbours(self, robot: int, drive: int) -> _Neighbours:
        """Returns for each type the vertices and edges that a robot's drive excludes."""
        kind, blocking = self._kinds[robot], self._reservations.blocking
        if self._is_mid_edge(robot):
            found = self._near_rest.get((robot, drive))
            if found is None:
                begun = self._mid_edge[robot].behind(drive)
                found = self._near_rest[robot, drive] = [
                    self._sorted(other, blocking[kind, other].rest(drive, begun))
                    for other in self._reservations.kinds]
            return found
        found = self._near.get((kind, drive >> 1))
        if found is None:
            found = self._near[kind, drive >> 1] = [
                self._sorted(other, blocking[kind, other].excluded(
                    self._first_edge + (drive >> 1))) for other in self._reservations.kinds]
        return found

    def _sorted(self, kind: RobotType,
                places: Sequence[int]) -> Tuple[RobotType, List[int], List[int]]:
        return (kind, [p for p in places if p < self._first_edge],
                [p - self._first_edge for p in places if p >= self._first_edge])

    # -- robots that are still between two vertices ------------------------------------------------

    def _is_mid_edge(self, robot: int) -> bool:
        return self._vertex[robot] >= self._first_edge

    def _passes(self, robot: int, drive: int, other: int) -> bool:
        """Returns whether a robot's drive leads past the point of another robot between two
        vertices.
        """
        key = other, self._kinds[robot]
        if key not in self._near_point:
            self._near_point[key] = self._reservations.places_near(
                self._kinds[other], self._kinds[robot], self._mid_edge[other])
        part = self._near_point[key].get(self._first_edge + (drive >> 1))
        if part is None:
            return False
        begun = self._mid_edge[robot].behind(drive) if self._is_mid_edge(robot) else 0.0
        return begun < (1.0 - part[0] if drive & 1 else part[1])

    def _stands_on(self, robot: int, path: AbstractSet[int]) -> bool:
        """Returns whether a robot stands on a vertex of a path, or between two of its vertices."""
        if not self._is_mid_edge(robot):
            return self._vertex[robot] in path
        drive = self._mid_edge[robot].drive
        return {self._reservations.network.destination(d) for d in (drive, drive ^ 1)} <= path

    def _path(self, robot: int) -> AbstractSet[int]:
        """Returns the next vertices of a robot's shortest path."""
        agent, vertex = self.agents[robot], self._vertex[robot]
        estimate = agent.estimate(self._states[robot])
        path = {vertex}
        for _ in range(_FAR):
            ahead = min(((estimate[end], end) for _, end, _ in agent.roads[vertex]),
                        default=(inf, vertex))
            if ahead[0] >= estimate[vertex]:
                break
            vertex = ahead[1]
            path.add(vertex)
        return path


def choose_rests(reservations: ReservationTable,
                 agents: Sequence[Agent]) -> Optional[List[Optional[int]]]:
    """Returns the vertex at which each robot is to rest; None for a robot without rests.

    A robot with nothing to do stays where it is if it may. Returns None in place of the list if no
    free rest is left for a robot.
    """
    taken: List[Tuple[RobotType, int]] = [
        (t.kind, t.query.destinations[-1]) for t in agents if t.query.rests is None]
    found: Dict[str, Optional[int]] = {}
    for agent in sorted(agents, key=lambda t: len(t.query.destinations)):
        query = agent.query
        if query.rests is None:
            found[agent.name] = None
            continue
        rests = sorted(query.rests.whole)
        paths = reservations.network.paths_to(agent.kind, rests)
        seconds = [float(path[query.destinations[-1]]) if query.destinations
                   else query.seconds_to(path) for path in paths]
        for _, rest in sorted(zip(seconds, rests)):
            slots = reservations.slots[agent.kind]
            if not slots.row(slots.drives + rest) and not any(
                    reservations.blocking[agent.kind, kind].excludes(rest, vertex)
                    for kind, vertex in taken):
                found[agent.name] = rest
                taken.append((agent.kind, rest))
                break
        else:
            return None
    return [found[agent.name] for agent in agents]
