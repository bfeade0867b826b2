"""The reports of robots about their routes, as in the route protocol, and their check."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple

from fleet_core.geometry.areas import Point
from route_protocol import messages
from route_protocol.messages import WrongReport
from route_protocol.values import Motion, RouteReport
from trajectory_graph import Graph
from trajectory_graph.drawn_names import at_vertex, place_name

TREMBLE = 0.05     # m by which the reported location of a standing robot may change
CLOCK_ERROR = 0.2  # s by which a robot's clock may differ; `peer_watch` warns above this
_OLD = 10.0        # s: people are warned of a location that is older at its arrival


@dataclass(frozen=True)
class Pose:
    """Where a robot reports to be: fraction (0..1) along the driving direction of a signed edge."""

    edge: int = 0  # 0 = off the graph
    fraction: float = 0.0


def distance(graph: Graph, one: Pose, other: Pose) -> float:
    """Returns the distance (m) between two poses: along their common edge, or else straight.

    Infinite if a pose is off the graph.
    """
    if one.edge == other.edge:
        length = graph.curve(one.edge).length if one.edge else 0.0
        return abs(one.fraction - other.fraction) * length
    if not (one.edge and other.edge):
        return math.inf
    return math.dist(point_of(graph, one), point_of(graph, other))


def point_of(graph: Graph, pose: Pose) -> Point:
    """Returns x, y in m of a pose on the graph."""
    curve = graph.curve(pose.edge)
    x, y = curve.point_at(pose.fraction * curve.length)
    return float(x), float(y)


@dataclass(frozen=True)
class Report:
    """One report of a robot, as it arrived.

    age -- age of its location at its arrival, in s; negative if the robot's clock is ahead
    """

    said: RouteReport
    age: float = 0.0

    @property
    def stamp(self) -> float:
        """Time of the location, in s by the robot's clock; 0: the report has no location."""
        return self.said.stamp / 1e9

    @property
    def pose(self) -> Pose:
        """The reported place on the graph."""
        return Pose(self.said.pose.edge, self.said.pose.percentage / 100.0)

    @property
    def motion(self) -> Motion:
        """What the robot does."""
        return self.said.motion

    @property
    def is_ahead(self) -> bool:
        """Whether the robot's clock is ahead of ours by more than CLOCK_ERROR."""
        return self.age < -CLOCK_ERROR

    def located(self, graph: Graph) -> Optional[Point]:
        """Returns the robot's location, x, y in m; None: the report has none."""
        location = self.said.location
        if location is not None:
            return location.x, location.y
        return point_of(graph, self.pose) if self.said.pose.edge else None


def check_report(report: Report, graph: Graph) -> None:
    """Raises WrongReport for a report that makes no sense on this graph."""
    pose = report.pose
    messages.check_report(report.said)
    if not math.isfinite(pose.fraction) or not 0.0 <= pose.fraction <= 1.0:
        raise WrongReport(f'it is at {100.0 * pose.fraction} % of an edge')
    if not (math.isfinite(report.stamp) and math.isfinite(report.age)):
        raise WrongReport('its stamp is not a finite number')
    if pose.edge and abs(pose.edge) not in graph.edges:
        raise WrongReport(f'it is on edge {pose.edge}, which the graph does not have')


def old_location(name: str, report: Report) -> str:
    """Returns the warning about a robot whose location was old at its arrival.

    Empty: it was not old.
    """
    if report.age <= _OLD:
        return ''
    return (f'The locations of {name} are more than {_OLD:.0f} s old when they arrive. Either they '
            'are not renewed, or the clock of its computer is wrong: check NTP. Until then other '
            'robots stay far behind it.')


@dataclass(frozen=True)
class GraphPosition:
    """Where a robot stands: on a vertex, or at a fraction of a signed edge."""

    vertex: Optional[int] = None
    edge: int = 0
    fraction: float = 0.0

    def is_on(self, graph: Graph) -> bool:
        """Returns whether the graph has this position."""
        return abs(self.edge) in graph.edges if self.vertex is None else (
            self.vertex in graph.vertices)

    def point(self, graph: Graph) -> Point:
        """Returns the point x, y in m."""
        if self.vertex is None:
            return point_of(graph, Pose(self.edge, self.fraction))
        vertex = graph.vertices[self.vertex]
        return vertex.x, vertex.y

    def distance(self, graph: Graph, pose: Pose) -> float:
        """Returns the distance (m) to a pose: along the common edge, or straight if there is none.

        Infinite if the pose is off the graph.
        """
        if self.vertex is None:
            return distance(graph, Pose(self.edge, self.fraction), pose)
        if not pose.edge:
            return math.inf
        return math.dist(self.point(graph), point_of(graph, pose))

    def touches(self, graph: Graph, edges: Tuple[int, ...], play: float = 0.0) -> bool:
        """Returns whether the position is on one of these edges, or at an end of one.

        A robot that strays by up to `play` (m) from its edge reports the nearest edge, which may
        not be its own. The reported position is then at most twice the play from its own edge.
        """
        if self.vertex is None:
            if abs(self.edge) in map(abs, edges):
                return True
            here = self.point(graph)
            return any(graph.curve(e).project(*here).distance <= 2.0 * play for e in edges)
        return any(self.vertex in (graph.edge(e).origin, graph.edge(e).destination) for e in edges)

    def told(self, graph: Graph) -> str:
        """Returns the position in words: `at vertex 5`, or `on edge 7 at 60 %`."""
        if self.vertex is not None:
            return at_vertex(graph, self.vertex)
        return f'on {place_name(graph, self.edge, self.fraction)}'


def position_of(pose: Pose, graph: Graph, near: float) -> Optional[GraphPosition]:
    """Returns the position that a pose means: a vertex within `near` m, or else the edge.

    None: the pose is off the graph.
    """
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
