"""The route record of one robot: the edges that it was ordered to drive, and its progress on them.

The edges are numbered as in `route_protocol.master`. This module adds their lengths, and computes
from the reported pose what certainly lies behind the robot.
"""
from __future__ import annotations

from collections import deque
from itertools import count
from typing import Deque, List, Optional, Tuple

from fleet_core.fleet import RobotType
from fleet_core.interlocking.allocation import Hold
from fleet_core.interlocking.reports import CLOCK_ERROR, GraphPosition, Pose
from route_protocol.master import MasterState, Step, left
from trajectory_graph import Graph

# the largest cleared fraction of an edge: the robot is on the edge until it has passed the end
_NOT_OVER = 1.0 - 1e-9
# number of driven edges that are kept; far more than a robot drives while the planner works
_REMEMBERED = 100


class RouteRecord:
    """One robot's route record.

    kind  -- the robot's type, with its load; its highest speed limits how far the robot may have
             moved since a location was taken
    slack -- m by which the robot may be behind its reported place

    It has many methods because it answers every question about the driven and the ordered edges.
    """

    def __init__(self, graph: Graph, kind: RobotType, slack: float = 0.0) -> None:
        self.graph = graph
        self.kind = kind
        self.protocol = MasterState()
        """What the robot may still do according to its orders."""
        self.position: Optional[GraphPosition] = None
        """Where the robot stands, or the vertex that it passed last; None: not known."""
        self.pose = Pose()
        """The last reported pose."""
        self.generation = 0
        """Number of times that the record was begun anew. A plan of an earlier generation is void.
        """
        self.cleared: Tuple[int, float] = (0, 0.0)
        """Number of an edge, and a fraction of this edge. The path up to this point is certainly
        behind the robot.
        """
        self._slack = slack
        self._driven: Deque[Step] = deque(maxlen=_REMEMBERED)

    # -- state ------------------------------------------------------------------------------------

    @property
    def done(self) -> int:
        """Number of the edge that the robot drives now."""
        return self.protocol.done

    @property
    def end(self) -> int:
        """One more than the number of the last edge that the robot may drive."""
        return self.protocol.end

    @property
    def ahead(self) -> Tuple[int, ...]:
        """The edges that are not driven to their ends yet; the robot is driving the first one."""
        return self.protocol.ahead

    @property
    def held(self) -> Tuple[int, ...]:
        """The path of the robot: the edges that it has not certainly left, and the edges ahead."""
        return tuple(step.edge for step in self._path)

    @property
    def begins(self) -> Tuple[int, float]:
        """Number of the first edge that is held, and the fraction of it that lies behind the robot.

        The number may differ from that in `cleared`: a robot that came to rest has left the edges
        behind it, even if its pose is not on the edge ahead.
        """
        first = next((step.number for step in self._path), self.end)
        return first, self.cleared[1] if self.cleared[0] == first else 0.0

    @property
    def _path(self) -> Tuple[Step, ...]:
        if not self.ahead:
            return (*self.protocol.behind, *self.protocol.held)
        return (*self.protocol.behind, *map(Step, count(self.done), self.ahead))

    def holds(self) -> Tuple[Hold, ...]:
        """Returns all edges on which the robot may be, each with its cleared fraction."""
        number, fraction = self.cleared
        return tuple(Hold(step.edge, fraction if step.number == number else 0.0)
                     for step in self.protocol.may_be_on if step.number >= number)

    @property
    def is_standing(self) -> bool:
        """Whether the robot has nothing to drive."""
        return not self.protocol.may_drive

    @property
    def last_vertex(self) -> Optional[int]:
        """The vertex where the record ends; None: it ends between vertices, or nowhere."""
        if self.ahead:
            return self.graph.end_vertex(self.ahead[-1]).id
        return self.position.vertex if self.position else None

    @property
    def some_vertex(self) -> Optional[int]:
        """A vertex from which the robot's place can be reached along edges; None: not known."""
        if self.last_vertex is not None or self.position is None:
            return self.last_vertex
        return self.graph.end_vertex(self.position.edge).id

    @property
    def near(self) -> float:
        """Distance (m) from a vertex within which the robot counts as standing on it."""
        return self.kind.nearness

    def part(self, begin: int, end: int) -> Tuple[int, ...]:
        """Returns the edges with the numbers `begin` to `end` - 1, as far as the record has them.

        The record still has the last edges that the robot has left, because a plan may be older.
        """
        path = (*self._driven, *(Step(number, edge)
                                 for number, edge in enumerate(self.ahead, self.done)))
        return tuple(step.edge for step in path if begin <= step.number < end)

    def distance_ahead(self) -> float:
        """Returns the length (m) of the path that is still to be driven."""
        edges = self.ahead
        if not edges:
            return 0.0
        whole = sum(self.graph.curve(edge).length for edge in edges)
        fraction = self.pose.fraction if self.pose.edge == edges[0] else 0.0
        return whole - fraction * self.graph.curve(edges[0]).length

    def begun(self, edge: int, position: Optional[GraphPosition]) -> float:
        """Returns the fraction of a signed edge that lies behind a robot at this position."""
        if position is None or position.vertex is not None or abs(edge) != abs(position.edge):
            return 0.0
        fraction = position.fraction if edge == position.edge else 1.0 - position.fraction
        return min(max(fraction - self._slack / self.graph.curve(edge).length, 0.0), _NOT_OVER)

    # -- changes ----------------------------------------------------------------------------------

    def set_protocol(self, protocol: MasterState) -> None:
        """Notes a change of what the robot may still do according to its orders.

        A late copy of an old stop, from before the epoch, sets `done` back to its value at that
        stop. Then no edge with that number or a higher one lies behind the robot.
        """
        self.protocol = protocol
        if self.cleared[0] > self.done:
            self.cleared = (self.done, 0.0)

    def begins_with(self, edge: int) -> None:
        """Notes that a standing robot is granted this edge first.

        The part of the edge that lies behind the robot is not allocated.
        """
        self.cleared = (self.done, self.begun(edge, self.position))

    def stand(self, position: Optional[GraphPosition]) -> None:
        """Notes that the robot stands at this position, and on nothing else."""
        self.position = position
        self.cleared = (self.done, 0.0)

    def begin_anew(self) -> None:
        """Notes that the robot lost its route, or was moved by another giver. No plan fits any
        more.
        """
        self.generation += 1
        self._driven.clear()

    def passed(self, edges: Tuple[int, ...]) -> List[int]:
        """Notes that the robot has driven these edges, which come just before its present edge.

        Returns the ids of the vertices at their ends, in order.
        """
        begin = self.done - len(edges)
        self._driven.extend(Step(begin + k, edge) for k, edge in enumerate(edges))
        vertices = [self.graph.end_vertex(edge).id for edge in edges
                    if abs(edge) in self.graph.edges]
        if vertices:
            self.position = GraphPosition(vertex=vertices[-1])
        return vertices

    def leave(self, age: float) -> None:
        """Computes what certainly lies behind the robot. Its pose is `age` s old."""
        ahead = self.ahead
        if not ahead or self.pose.edge != ahead[0]:
            return
        behind = {step.number: step.edge for step in self.protocol.behind}
        number, arc = self.done, self.pose.fraction * self.graph.curve(ahead[0]).length
        arc -= self.margin(age)
        while arc < 0.0 and number - 1 in behind and number > self.cleared[0]:
            number -= 1
            arc += self.graph.curve(behind[number]).length
        length = self.graph.curve(behind.get(number, ahead[0])).length
        self.cleared = max(self.cleared, (number, min(max(arc / length, 0.0), _NOT_OVER)))
        self.protocol = left(self.protocol, self.cleared[0])

    def margin(self, age: float) -> float:
        """Returns how far (m) the robot may be away from a location that is `age` s old."""
        return self._slack + (max(age, 0.0) + CLOCK_ERROR) * self.kind.fastest
