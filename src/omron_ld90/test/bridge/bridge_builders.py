"""What the bridge's tests share: small graphs, and a robot that obeys without any sockets."""
from __future__ import annotations

import heapq
import math
from typing import Callable, Dict, List, Optional, Sequence, Tuple

from omron_ld90.bridge import route_protocol as p
from omron_ld90.bridge.route_follower import RouteFollower
from omron_ld90.bridge.route_settings import Settings
from omron_ld90.bridge.route_strategies import STRATEGIES
from trajectory_graph import Edge, Graph, Vertex

DOCK_VERTEX = 90
NANOSECONDS = 1_000_000_000


def graph_of(places: Dict[int, Tuple[float, float]], ends: Dict[int, Tuple[int, int]]) -> Graph:
    """Straight edges `ends` {id: (origin, destination)} between vertices `places` {id: (x, y)}."""
    return Graph([Vertex(id, x, y, 0.0) for id, (x, y) in places.items()],
                 [Edge(id, *pair) for id, pair in ends.items()])


def yard() -> Graph:
    """A block of 4 x 4 m (vertices 1 2 3 4), a tail east of 2 (5, 6) and a dock south of 1.

        4 --3-- 3
        |4      |2
        1 --1-- 2 --5-- 5 --6-- 6
        |9
       90 (dock)
    """
    return graph_of(
        {1: (0, 0), 2: (4, 0), 3: (4, 4), 4: (0, 4), 5: (8, 0), 6: (12, 0), DOCK_VERTEX: (0, -4)},
        {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (4, 1), 5: (2, 5), 6: (5, 6), 9: (1, DOCK_VERTEX)})


def dissertation_graph() -> Graph:
    """Route [E1, E4, E5] leads from V1 over V2 and V7 to V6."""
    return graph_of({1: (0, 0), 2: (4, 0), 7: (8, 0), 6: (12, 2), 3: (4, 4)},
                    {1: (1, 2), 4: (2, 7), 5: (7, 6), 2: (2, 3)})


class GraphRobot:
    """Drives as an LD-90 would: shortest way, brakes for its goal, tells where it is at 2 Hz."""

    TOP_SPEED, ACCELERATION, BRAKING = 1.35, 0.5, 0.2
    STEP, STATUS_PERIOD = 0.1, 0.5

    def __init__(self, graph: Graph, vertex: int, period: float = STATUS_PERIOD) -> None:
        self.graph = graph
        self.position = graph.vertex(vertex).position
        self.docked = vertex == DOCK_VERTEX
        self.goal: Optional[str] = None
        self.commands: List[str] = []
        self.trail: List[Tuple[float, float]] = [self.position]
        self.speed = 0.0
        self.halts = 0
        self.period = period
        self._way: List[Tuple[float, float]] = []
        self._since_status = period

    def obey(self, command: str) -> List[p.Event]:
        """Takes a command; the robot's words in answer."""
        self.commands.append(command)
        events: List[p.Event] = []
        if self.goal is not None:
            events.append(p.MotionInterrupted(f'Going to {self.goal}'))
        if command == 'stop':
            self.goal, self._way, self.speed = None, [], 0.0
            return events
        if self.docked and command != 'dock':
            events += [p.Docking.UNDOCKING, p.Docking.UNDOCKED]
            self.docked = False
        self.goal = command.split()[-1]
        vertex = DOCK_VERTEX if command == 'dock' else int(self.goal)
        self._way = self._shortest_way(vertex)
        if command == 'dock':
            return [*events, p.Docking.UNDOCKED, p.Docking.DOCKING]
        return [*events, p.GoalStarted(self.goal)]

    def step(self, now: float) -> List[p.Event]:
        """Drives for STEP seconds; what the robot says meanwhile."""
        events: List[p.Event] = []
        left = self._left()
        if self._way:
            self.speed = min(self.speed + self.ACCELERATION * self.STEP, self.TOP_SPEED,
                             max(math.sqrt(2.0 * self.BRAKING * left), 0.05))
            self._advance(self.speed * self.STEP)
            if not self._way:
                self.speed = 0.0
                self.halts += 1
                if self.goal == 'dock':
                    self.docked = True
                    events.append(p.Docking.DOCKED)
                else:
                    events.append(p.GoalReached(self.goal))
                self.goal = None
        self._since_status += self.STEP
        if self._since_status >= self.period - 1e-9:
            self._since_status = 0.0
            events.append(self.located(now))
        return events

    def located(self, now: float) -> p.Located:
        return p.Located(int(now * NANOSECONDS), *self.position)

    def _left(self) -> float:
        points = [self.position, *self._way]
        return sum(math.dist(a, b) for a, b in zip(points, points[1:]))

    def _advance(self, length: float) -> None:
        while self._way:
            gap = math.dist(self.position, self._way[0])
            if gap > length:
                t = length / gap
                self.position = tuple(a + t * (b - a)
                                      for a, b in zip(self.position, self._way[0]))
                break
            length -= gap
            self.position = self._way.pop(0)
        self.trail.append(self.position)

    def _shortest_way(self, vertex: int) -> List[Tuple[float, float]]:
        """Points to the vertex, over the straight edges of the graph."""
        edge, projection = self.graph.nearest_edge(*self.position)
        queue = [(projection.arc_length, self.graph.start_vertex(edge).id, ()),
                 (self.graph.curve(edge).length - projection.arc_length,
                  self.graph.end_vertex(edge).id, ())]
        heapq.heapify(queue)
        seen = set()
        while queue:
            cost, at, before = heapq.heappop(queue)
            way = (*before, self.graph.vertex(at).position)
            if at == vertex:
                return list(way)
            if at in seen:
                continue
            seen.add(at)
            for edge in self.graph.edges_from(at):
                heapq.heappush(queue, (cost + self.graph.curve(edge).length,
                                       self.graph.end_vertex(edge).id, way))
        raise AssertionError(f'no way to vertex {vertex}')


class Bench:
    """A follower and a robot joined, with a clock that only runs when it is told to."""

    def __init__(self, graph: Graph, vertex: int, strategy: str = 'vertex_by_vertex',
                 period: float = GraphRobot.STATUS_PERIOD, **settings) -> None:
        self.robot = GraphRobot(graph, vertex, period)
        self.follower = RouteFollower(
            Settings(dock_vertex=DOCK_VERTEX, strategy=STRATEGIES[strategy], **settings), graph)
        self.now = 100.0
        self.reports: List[p.RouteReport] = []
        self.notes: List[str] = []
        if self.robot.docked:
            self.tell(p.Docking.DOCKED)
        self.tell(self.robot.located(self.now))

    def tell(self, *events: p.Event) -> None:
        """Events to the follower; the robot obeys what it sends."""
        for event in events:
            self._act(self.follower.handle(event, self.now))

    def order(self, route_id: int, *edges: int, stamp: float = 0.0) -> None:
        self.tell(p.RouteOrder(route_id, edges, int(stamp * NANOSECONDS)))

    def run(self, until: Optional[Callable[[Bench], bool]] = None, seconds: float = 300.0) -> None:
        """Lets time pass until the condition holds (by default: no route runs)."""
        until = until or (lambda bench: not bench.follower.running)
        end = self.now + seconds
        while not until(self):
            assert self.now < end, f'not within {seconds} s; last report: {self.last}'
            self.now += GraphRobot.STEP
            self.tell(*self.robot.step(self.now))
            self._act(self.follower.tick(self.now))
            self.reports.append(self.follower.report())

    def wait(self, seconds: float) -> None:
        """Lets time pass without the robot saying or doing anything."""
        end = self.now + seconds
        while self.now < end:
            self.now += GraphRobot.STEP
            self._act(self.follower.tick(self.now))

    @property
    def last(self) -> Optional[p.RouteReport]:
        return self.reports[-1] if self.reports else None

    @property
    def commands(self) -> List[str]:
        return self.robot.commands

    def states(self) -> Sequence[int]:
        return [int(state) for state in self.follower.report().states]

    def _act(self, actions: Sequence[p.Action]) -> None:
        for action in actions:
            if isinstance(action, p.Send):
                self.tell(*self.robot.obey(action.command))
            elif isinstance(action, p.RouteReport):
                self.reports.append(action)
            else:
                self.notes.append(action.text)
