"""All edges that a robot was ever given, counted through, and how far it is on them.

Whatever the ids of its routes, the edges go on counting: the *route record*. What is on it
and not yet left is the robot's alone; a record only gets shorter when a report says so.
"""
from __future__ import annotations

from typing import List, Optional, Sequence, Tuple

from graph_fleet_manager.supervision.liveness import TREMBLE
from graph_fleet_manager.supervision.reports import NEAR, Place, Pose, place_of
from trajectory_graph import Graph

_NOT_OVER = 1.0 - 1e-9  # the fraction of an edge that is nearly driven


class RouteRecord:
    """One robot's route record.

    speed -- m/s, the most that the robot may drive back in the time that a report is old
    slack -- m that it may be short of where it reports to be
    """

    def __init__(self, graph: Graph, speed: float, slack: float = 0.0) -> None:
        self.graph = graph
        self.place: Optional[Place] = None
        """Where the robot stands, or stood before its record; None: nobody knows."""
        self.pose = Pose()
        """Where it last reported to be."""
        self.lost_at: Optional[Place] = None
        """Of a robot that is off the graph by that: where it was before."""
        self.edges: List[int] = []
        self.first = 0
        """Number of the first edge that is still in `edges`."""
        self.done = 0
        """Number of the edge that is being driven: so many are complete."""
        self.begun = 0
        """How often it began anew: no plan of before is true any more when that changes."""
        self.left: Tuple[int, float] = (0, 0.0)
        """Edge and fraction that certainly lie behind the robot."""
        self.told = 0
        """Number behind the last edge of which the robot may have been told."""
        self._speed, self._slack = speed, slack

    # -- what is known ----------------------------------------------------------------------------

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
        """The edges that nobody else may be given."""
        return self.part(max(self.left[0], self.first), self.end)

    @property
    def is_standing(self) -> bool:
        """Is everything driven that was ordered?"""
        return self.done == self.end

    @property
    def last_vertex(self) -> Optional[int]:
        """Where it ends; None between vertices and nowhere."""
        if self.ahead:
            return self.graph.end_vertex(self.ahead[-1]).id
        return self.place.vertex if self.place else None

    def part(self, begin: int, end: int) -> Tuple[int, ...]:
        """The edges from number `begin`, which must not be forgotten yet, to before `end`."""
        return tuple(self.edges[begin - self.first:max(begin, end) - self.first])

    def distance_ahead(self) -> float:
        """Length (m) of what is still to be driven."""
        edges = self.ahead
        if not edges:
            return 0.0
        whole = sum(self.graph.curve(edge).length for edge in edges)
        fraction = self.pose.fraction if self.pose.edge == edges[0] else 0.0
        return whole - fraction * self.graph.curve(edges[0]).length

    def has_left(self) -> bool:
        """Does a robot that has nothing to drive say that it is somewhere else?"""
        if self.place is None:
            self.place = place_of(self.pose, self.graph)
            return False
        return self.place.distance(self.graph, self.pose) > NEAR + TREMBLE

    # -- what changes it --------------------------------------------------------------------------

    def see(self, pose: Pose) -> None:
        """It reports to be there."""
        if pose.edge:
            self.lost_at = None
        elif self.pose.edge:
            self.lost_at = place_of(self.pose, self.graph)
        self.pose = pose

    def append(self, edges: Sequence[int]) -> None:
        """More edges are the robot's; one that stands on an edge is on the first of them."""
        if self.is_standing and self.place is not None and self.place.vertex is None:
            fraction = self.place.fraction if edges[0] == self.place.edge else (
                1.0 - self.place.fraction)
            slack = self._slack / self.graph.curve(edges[0]).length
            self.left = (self.done, min(max(fraction - slack, 0.0), _NOT_OVER))
        self.edges += edges

    def cut(self, end: int) -> None:
        """Edges from a number on are not the robot's any more."""
        del self.edges[end - self.first:]
        self.told = min(self.told, self.end)

    def complete(self, done: int) -> List[int]:
        """So many edges are complete; returns the vertices passed by that, in order."""
        passed = []
        while self.done < min(done, self.end):
            vertex = self.graph.end_vertex(self.edges[self.done - self.first]).id
            self.done += 1
            self.place = Place(vertex=vertex)
            passed.append(vertex)
        return passed

    def leave(self, age: float) -> None:
        """Finds what certainly lies behind the robot by its pose, which is `age` s old."""
        if self.is_standing:
            self.left = (self.done, 0.0)
            return
        edge = self.edges[self.done - self.first]
        if self.pose.edge != edge:
            return
        number, arc = self.done, self.pose.fraction * self.graph.curve(edge).length
        arc -= self._slack + max(age, 0.0) * self._speed
        while arc < 0.0 and number > max(self.left[0], self.first):
            number -= 1
            arc += self.graph.curve(self.edges[number - self.first]).length
        length = self.graph.curve(self.edges[number - self.first]).length
        self.left = max(self.left, (number, min(max(arc / length, 0.0), _NOT_OVER)))

    def forget(self, number: int) -> None:
        """Drops the edges before a number, as far as they are left."""
        keep = min(self.left[0], self.done, number)
        if keep > self.first:
            del self.edges[:keep - self.first]
            self.first = keep

    def settle(self, place: Optional[Place]) -> None:
        """The robot stands here, and holds nothing else any more."""
        # One number is left out, so that no plan made before can fit what comes after.
        self._begin_at(self.end + 1, ())
        self.place, self.lost_at = place, None

    def adopt(self, edges: Sequence[int]) -> None:
        """The robot drives these edges, of which nothing was known."""
        self._begin_at(self.end, edges)

    def restore(self, edges: Sequence[int], done: int, place: Optional[Place],
                lost_at: Optional[Place]) -> None:
        """As it was before a restart, with `done` of these edges complete."""
        self._begin_at(0, edges)
        self.done, self.left = done, (done, 0.0)
        self.place, self.lost_at = place, lost_at

    def _begin_at(self, number: int, edges: Sequence[int]) -> None:
        self.first = self.done = number
        self.begun += 1
        self.edges = list(edges)
        self.left = (number, 0.0)
        self.told = self.end
