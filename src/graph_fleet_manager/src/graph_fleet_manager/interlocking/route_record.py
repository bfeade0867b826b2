"""The route record: all edges that a robot was ever granted, and its progress on them.

The edges are numbered from the first one on. The numbers go on from one route id to the next. The
robot holds each edge that is on the record and that it has not left, and no other robot may be
granted it. The record gets shorter only if a report justifies it.
"""
from __future__ import annotations

from typing import List, Optional, Sequence, Tuple

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.interlocking.allocation import Hold
from graph_fleet_manager.interlocking.reports import (
    CLOCK_ERROR,
    NEAR,
    TREMBLE,
    GraphPosition,
    Pose,
    nearness,
)
from trajectory_graph import Graph

# the fraction of an edge that is driven except for a tiny remainder
_NOT_OVER = 1.0 - 1e-9


class RouteRecord:
    """One robot's route record.

    kind     -- the robot's type; its speed bounds how far it may have moved since a location
    slack    -- m by which the robot may be behind its reported place
    stopping -- braking distance (m) from the place where it acknowledges a shorter route
    """

    def __init__(self, graph: Graph, kind: RobotType, slack: float = 0.0,
                 stopping: float = 1.0) -> None:
        self.graph = graph
        self.kind = kind
        self.position: Optional[GraphPosition] = None
        """Where the robot stands, or where it stood before its record begins; None: not known."""
        self.pose = Pose()
        """The last reported pose."""
        self.edges: List[int] = []
        self.first = 0
        """Number of the first edge that is still in `edges`."""
        self.done = 0
        """Number of the edge that is being driven, and so the number of complete edges."""
        self.generation = 0
        """Number of times that the record was begun anew. A plan of an earlier generation is void.
        """
        self.cleared: Tuple[int, float] = (0, 0.0)
        """Edge and fraction that certainly lie behind the robot."""
        self.told = 0
        """Number behind the last edge of which the robot may have been told."""
        self.tail: Tuple[int, ...] = ()
        """Edges that were taken back, but that the robot may still reach before it stands."""
        self._tail_at = 0  # number of the edge that the first edge of the tail had
        self.stopping = stopping
        self._slack = slack

    # -- state ------------------------------------------------------------------------------------

    @property
    def end(self) -> int:
        """Number behind the last edge."""
        return self.first + len(self.edges)

    @property
    def ahead(self) -> Tuple[int, ...]:
        """The edges not yet complete, the one being driven first."""
        return self.part(self.done, self.end)

    @property
    def held(self) -> Tuple[int, ...]:
        """The edges of the record that other robots may not be granted."""
        return self.part(max(self.cleared[0], self.first), self.end)

    def holds(self, back_to: Optional[int] = None) -> Tuple[Hold, ...]:
        """All edges that other robots may not be granted, each with its cleared fraction.

        back_to -- number of an edge to which the robot may turn back; None: it cannot turn back
        """
        number, fraction = self.begin_of_holds(back_to)
        held = [Hold(edge) for edge in self.part(number, self.end)]
        if held:
            held[0] = Hold(held[0].edge, fraction)
        return (*held, *map(Hold, self.tail))

    def begin_of_holds(self, back_to: Optional[int] = None) -> Tuple[int, float]:
        """Number and cleared fraction of the first edge that is held."""
        cleared = max(self.cleared, (self.first, 0.0))
        return cleared if back_to is None else min(cleared, (max(back_to, self.first), 0.0))

    @property
    def is_standing(self) -> bool:
        """Has the robot driven all edges that were ordered?"""
        return self.done == self.end

    @property
    def last_vertex(self) -> Optional[int]:
        """The vertex where the record ends; None: it ends between vertices, or nowhere."""
        if self.ahead:
            return self.graph.end_vertex(self.ahead[-1]).id
        return self.position.vertex if self.position else None

    @property
    def some_vertex(self) -> Optional[int]:
        """A vertex from which edges lead to the robot's place; None: not known."""
        if self.last_vertex is not None or self.position is None:
            return self.last_vertex
        return self.graph.end_vertex(self.position.edge).id

    @property
    def near(self) -> float:
        """Distance (m) from a vertex within which the robot counts as standing on it."""
        return nearness(self.kind)

    def part(self, begin: int, end: int) -> Tuple[int, ...]:
        """The edges from number `begin` to before `end`. Edge `begin` must still be in `edges`."""
        return tuple(self.edges[begin - self.first:max(begin, end) - self.first])

    def distance_ahead(self) -> float:
        """Length (m) of the path that is still to be driven."""
        edges = self.ahead
        if not edges:
            return 0.0
        whole = sum(self.graph.curve(edge).length for edge in edges)
        fraction = self.pose.fraction if self.pose.edge == edges[0] else 0.0
        return whole - fraction * self.graph.curve(edges[0]).length

    def begun(self, edge: int) -> float:
        """The fraction of an edge behind a robot that stands on it and would drive it that way."""
        position = self.position
        if position is None or position.vertex is not None or abs(edge) != abs(position.edge):
            return 0.0
        fraction = position.fraction if edge == position.edge else 1.0 - position.fraction
        return min(max(fraction - self._slack / self.graph.curve(edge).length, 0.0), _NOT_OVER)

    def certainly_begun(self, edge: int) -> float:
        """The fraction of the first edge ahead behind a robot, also if it was pushed back on it."""
        pose = self.pose
        if abs(edge) != abs(pose.edge):
            return 0.0
        fraction = pose.fraction if edge == pose.edge else 1.0 - pose.fraction
        number, cleared = self.cleared
        behind = fraction - (self._slack + TREMBLE) / self.graph.curve(edge).length
        return min(max(behind, 0.0), cleared if number == self.done else 0.0)

    def has_left(self) -> bool:
        """Has a robot with nothing to drive reported that it is not at its position?"""
        return (self.position is not None
                and self.position.distance(self.graph, self.pose) > NEAR + TREMBLE)

    # -- changes ----------------------------------------------------------------------------------

    def append(self, edges: Sequence[int]) -> None:
        """Adds edges to the record. A robot that stands on an edge must begin with that edge."""
        if self.is_standing and self.position is not None and self.position.vertex is None:
            self.cleared = (self.done, self.begun(edges[0]))
        self.edges += edges

    def cut(self, end: int) -> None:
        """Removes the edges from number `end` on. The robot does not hold them."""
        del self.edges[end - self.first:]
        self.told = min(self.told, self.end)

    def shorten(self, end: int, age: float) -> None:
        """The robot has acknowledged that its route ends before edge number `end`.

        It acknowledged with a location that is `age` s old. From the place that it may have reached
        since, it may still need its stopping distance. The removed edges within that distance
        become the tail.
        """
        reach = self.stopping + (max(age, 0.0) + CLOCK_ERROR) * self.kind.speed
        removed = self.part(end, self.end)
        self.cut(end)
        reach -= self.distance_ahead()
        tail: List[int] = []
        for edge in () if self.is_standing else removed:
            if reach <= 0.0:
                break
            tail.append(edge)
            reach -= self.graph.curve(edge).length
        self.tail, self._tail_at = tuple(tail), end

    def complete(self, done: int) -> List[int]:
        """Sets the number of complete edges. Returns the vertices passed by that, in order."""
        passed = []
        while self.done < min(done, self.end):
            vertex = self.graph.end_vertex(self.edges[self.done - self.first]).id
            self.done += 1
            self.position = GraphPosition(vertex=vertex)
            passed.append(vertex)
        if self.is_standing or self.done > self._tail_at:
            self.tail = ()
        return passed

    def turn_back(self, number: int) -> None:
        """Counts the edges from `number` on as not driven: a late order led the robot back."""
        self.done, self.cleared = number, min(self.cleared, (number, 0.0))
        start = self.graph.start_vertex(self.edges[number - self.first])
        self.position = GraphPosition(vertex=start.id)
        self.generation += 1

    def leave(self, age: float) -> None:
        """Computes what certainly lies behind the robot from its pose, which is `age` s old."""
        if self.is_standing:
            self.cleared = (self.done, 0.0)
            return
        edge = self.edges[self.done - self.first]
        if self.pose.edge != edge:
            return
        number, arc = self.done, self.pose.fraction * self.graph.curve(edge).length
        arc -= self.margin(age)
        while arc < 0.0 and number > max(self.cleared[0], self.first):
            number -= 1
            arc += self.graph.curve(self.edges[number - self.first]).length
        length = self.graph.curve(self.edges[number - self.first]).length
        self.cleared = max(self.cleared, (number, min(max(arc / length, 0.0), _NOT_OVER)))

    def margin(self, age: float) -> float:
        """Distance (m) that the robot may be away from a location that is `age` s old."""
        return self._slack + (max(age, 0.0) + CLOCK_ERROR) * self.kind.speed

    def forget(self, number: int) -> None:
        """Drops the edges before a number, if they are left."""
        keep = min(self.cleared[0], self.done, number)
        if keep > self.first:
            del self.edges[:keep - self.first]
            self.first = keep

    def settle(self, position: Optional[GraphPosition]) -> None:
        """The robot stands at this position and holds nothing else."""
        # One number is skipped, so that no earlier plan can fit the edges that follow.
        self._begin_at(self.end + 1, ())
        self.position = position

    def adopt(self, edges: Sequence[int]) -> None:
        """The robot drives these edges, which this record did not know."""
        self._begin_at(self.end, edges)

    def restore(self, edges: Sequence[int], done: int, position: Optional[GraphPosition],
                cleared: Tuple[int, float], tail: Sequence[int]) -> None:
        """Sets the record to its state before a restart, with `done` of these edges complete."""
        self._begin_at(0, edges)
        self.done, self.cleared = done, cleared
        self.tail, self._tail_at = tuple(tail), self.end
        self.position = position

    def _begin_at(self, number: int, edges: Sequence[int]) -> None:
        self.first = self.done = number
        self.generation += 1
        self.edges = list(edges)
        self.cleared = (number, 0.0)
        self.tail = ()
        self.told = self.end
