"""What robots tell of their routes, as the route protocol has it, and what is wrong with it."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.geometry.areas import Point
from trajectory_graph import Graph
from trajectory_graph.route_protocol import NO_REASON, EdgeState, Location, Reason

LONGEST = 1000     # edges in a route; more is a mistake or an attack
NEAR = 0.3         # m from a vertex at which a robot stands on it at most, regardless of its play
AT_VERTEX = 0.02   # m from a vertex at which a robot that follows its edges exactly stands on it
TREMBLE = 0.05     # m by which the location of a robot that stands may change
CLOCK_ERROR = 0.2  # s by which a robot's clock may differ; `peer_watch` warns from there on
_OLD = 10.0        # s that a location may be old as it arrives
_OVERTAKEN = 10.0  # s: a report that is older than the last by more tells of a clock set back


@dataclass(frozen=True)
class Pose:
    """Where a robot reports to be: fraction (0..1) along the driving direction of a signed edge."""

    edge: int = 0  # 0 = off the graph
    fraction: float = 0.0


def distance(graph: Graph, one: Pose, other: Pose) -> float:
    """Metres between two poses, along their edge or straight; infinite from off the graph."""
    if one.edge == other.edge:
        length = graph.curve(one.edge).length if one.edge else 0.0
        return abs(one.fraction - other.fraction) * length
    if not (one.edge and other.edge):
        return math.inf
    return math.dist(point_of(graph, one), point_of(graph, other))


def point_of(graph: Graph, pose: Pose) -> Point:
    """x, y in m of a pose on the graph."""
    curve = graph.curve(pose.edge)
    x, y = curve.point_at(pose.fraction * curve.length)
    return float(x), float(y)


@dataclass(frozen=True)
class Report:
    """One report of a robot.

    stamp -- s, when the location that it uses was taken, by the robot's clock; 0: it had none
    age   -- s since then as it arrived; negative where the robot's clock is ahead
    location -- in metres; None where the robot did not tell it
    epoch -- of the robot's motion, which an order must know; 0: it tells none
    """

    route_id: int
    edges: Tuple[int, ...] = ()
    states: Tuple[EdgeState, ...] = ()
    pose: Pose = Pose()
    reason: Reason = NO_REASON
    stamp: float = 0.0
    age: float = 0.0
    location: Optional[Location] = None
    epoch: int = 0

    @property
    def completed(self) -> int:
        """How many edges, from the first on, are COMPLETE."""
        for index, state in enumerate(self.states):
            if state is not EdgeState.COMPLETE:
                return index
        return len(self.states)

    @property
    def left(self) -> Tuple[int, ...]:
        """The edges that are not COMPLETE."""
        return self.edges[self.completed:]

    @property
    def is_failed(self) -> bool:
        """Has the route, or what was left of it, failed?"""
        return EdgeState.FAILED in self.states

    @property
    def is_running(self) -> bool:
        """Is anything of the route still to be driven?"""
        return EdgeState.PROCESSING in self.states

    @property
    def is_ahead(self) -> bool:
        """Is the robot's clock ahead of ours by more than clocks may differ?"""
        return self.age < -CLOCK_ERROR

    def located(self, graph: Graph) -> Optional[Point]:
        """Where the robot is, x, y in m; None where the report does not tell it."""
        if self.location is not None:
            return self.location.x, self.location.y
        return point_of(graph, self.pose) if self.pose.edge else None


class WrongReport(Exception):
    """A report that cannot be true; the text, a clause, says why."""


def check_report(report: Report, graph: Graph) -> None:
    """Raises WrongReport for a report that makes no sense on this graph."""
    if len(report.edges) != len(report.states):
        raise WrongReport('it has not one state for each edge')
    if len(report.edges) > LONGEST:
        raise WrongReport(f'its route has more than {LONGEST} edges')
    if not math.isfinite(report.pose.fraction) or not 0.0 <= report.pose.fraction <= 1.0:
        raise WrongReport(f'it is at {100.0 * report.pose.fraction} % of an edge')
    if not (math.isfinite(report.stamp) and math.isfinite(report.age)):
        raise WrongReport('its stamp is no time')
    if report.pose.edge and abs(report.pose.edge) not in graph.edges:
        raise WrongReport(f'it is on edge {report.pose.edge}, which the graph does not have')


def is_overtaken(stamp: float, last: float) -> bool:
    """Was what has this stamp overtaken by what has the stamp `last`? Both by the robot's clock."""
    return 0.0 < last - stamp < _OVERTAKEN


def old_location(name: str, report: Report) -> str:
    """What is to be said of a robot whose location was old as it arrived; empty: it was not."""
    if report.age <= _OLD:
        return ''
    return (f'The locations of {name} are more than {_OLD:.0f} s old as they arrive: they are not '
            'renewed, or the clock of its computer differs (NTP); others stay far behind it.')


@dataclass(frozen=True)
class GraphPosition:
    """Where a robot stands: on a vertex, or at a fraction of a signed edge."""

    vertex: Optional[int] = None
    edge: int = 0
    fraction: float = 0.0

    def is_on(self, graph: Graph) -> bool:
        """Does a graph have this position?"""
        return abs(self.edge) in graph.edges if self.vertex is None else (
            self.vertex in graph.vertices)

    def point(self, graph: Graph) -> Point:
        """x, y in m."""
        if self.vertex is None:
            return point_of(graph, Pose(self.edge, self.fraction))
        vertex = graph.vertices[self.vertex]
        return vertex.x, vertex.y

    def distance(self, graph: Graph, pose: Pose) -> float:
        """Metres from there to a pose, along their edge or straight; infinite from off the graph.
        """
        if self.vertex is None:
            return distance(graph, Pose(self.edge, self.fraction), pose)
        if not pose.edge:
            return math.inf
        return math.dist(self.point(graph), point_of(graph, pose))

    def touches(self, graph: Graph, edges: Tuple[int, ...], play: float = 0.0) -> bool:
        """Is it on one of these edges, or at an end of one?

        A robot that strays by up to `play` (m) from its edge is told on the one that is nearest,
        which beside another edge need not be its own: then it is no farther than twice that away.
        """
        if self.vertex is None:
            if abs(self.edge) in map(abs, edges):
                return True
            here = self.point(graph)
            return any(graph.curve(e).project(*here).distance <= 2.0 * play for e in edges)
        return any(self.vertex in (graph.edge(e).origin, graph.edge(e).destination) for e in edges)

    def __str__(self) -> str:
        if self.vertex is not None:
            return f'vertex {self.vertex}'
        return f'{100.0 * self.fraction:.0f} % of edge {self.edge}'


def nearness(kind: RobotType) -> float:
    """m from a vertex at which a robot of this type stands on it."""
    return min(kind.play + AT_VERTEX, NEAR)


def position_of(pose: Pose, graph: Graph, near: float) -> Optional[GraphPosition]:
    """The position that a pose means: a vertex within `near` m of it; None off the graph."""
    if not pose.edge:
        return None
    length = graph.curve(pose.edge).length
    from_end = (1.0 - pose.fraction) * length
    near_end, near_start = from_end <= near, length - from_end <= near
    if near_end and (not near_start or pose.fraction > 0.5):
        return GraphPosition(vertex=graph.end_vertex(pose.edge).id)
    if near_start:
        return GraphPosition(vertex=graph.start_vertex(pose.edge).id)
    return GraphPosition(edge=pose.edge, fraction=pose.fraction)
