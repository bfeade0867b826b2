"""The location of a robot on the graph: which routes may begin there, and its symbolic pose."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Sequence, Tuple

from omron_arcl.replies import DockingState
from route_protocol.values import SymbolicPose
from trajectory_graph import Graph
from trajectory_graph.drawn_names import at_vertex, edge_name

DOCK_ZONE = 2.0  # m around the dock vertex, in which the robot manoeuvres outside the corridors


@dataclass(frozen=True)
class GraphLocation:
    """A location (m) on a graph. `corridor_width` and `vertex_tolerance` are in m.
    """

    graph: Graph
    position: Tuple[float, float]
    docking: Optional[DockingState]
    dock_vertex: Optional[int]
    vertex_tolerance: float
    corridor_width: float

    @property
    def _dock(self) -> Optional[int]:
        """The dock vertex; None if the graph does not have it."""
        return self.dock_vertex if self.dock_vertex in self.graph.vertices else None

    @property
    def is_docked(self) -> bool:
        """Whether the robot is docked; it then counts as standing on the dock vertex."""
        return self._dock is not None and self.docking is DockingState.DOCKED

    @property
    def is_about_the_dock(self) -> bool:
        """Whether the robot is docked or near the dock, where it may leave the corridors."""
        return self._dock is not None and (
            self.is_docked or self._distance_to(self._dock) <= DOCK_ZONE)

    def why_not_from(self, edge: int, being_driven: bool) -> str:
        """Returns the reason why a route cannot begin here with `edge`; empty if it can.

        A route can begin at the edge's first vertex and anywhere on the edge. It can begin at the
        last vertex only if the edge is `being_driven`: then the order may have been sent before our
        report that the edge is complete.
        """
        start, end = self.graph.start_vertex(edge).id, self.graph.end_vertex(edge).id
        curve, name = self.graph.curve(edge), edge_name(self.graph, edge)
        if self.is_docked:
            return '' if start == self.dock_vertex else (
                f'{name} starts {at_vertex(self.graph, start)}, but the robot is docked at vertex '
                f'{self.dock_vertex}')
        leaving = self.docking in (DockingState.DOCKING, DockingState.UNDOCKING)
        if leaving and start == self.dock_vertex and self.is_about_the_dock:
            return ''
        if self._distance_to(start) <= self.vertex_tolerance:
            return ''
        projection = curve.project(*self.position)
        if projection.distance > self.corridor_width / 2.0:
            return (f'{name} does not start where the robot is: the robot is '
                    f'{projection.distance:.2f} m away from it')
        if not being_driven and curve.length - projection.arc_length <= self.vertex_tolerance:
            return (f'{name} does not start where the robot is, but ends there, '
                    f'{at_vertex(self.graph, end)}')
        return ''

    def nearest_of(self, edges: Sequence[int]) -> Optional[int]:
        """Returns the index of the nearest edge whose corridor contains this location.

        If several edges are equally near, returns the first. None: the location is in no corridor.
        """
        distances = [self.graph.curve(edge).project(*self.position).distance for edge in edges]
        if not distances or min(distances) > self.corridor_width / 2.0:
            return None
        return next(index for index, distance in enumerate(distances)
                    if distance <= min(distances) + 0.01)

    def symbolic_pose(self) -> SymbolicPose:
        """Returns the place on the nearest edge, in its forward direction. Edge 0 means that the
        location is in no corridor.
        """
        if self._dock is not None and self.is_docked and self.graph.edges:
            way_out = self.graph.edges_from(self._dock)[0]
            return SymbolicPose(abs(way_out), 0.0 if way_out > 0 else 100.0)
        nearest = self.graph.nearest_edge(*self.position)
        if nearest is None or nearest[1].distance > self.corridor_width / 2.0:
            return SymbolicPose()
        return SymbolicPose(nearest[0], 100.0 * nearest[1].fraction)

    def _distance_to(self, vertex: int) -> float:
        return math.dist(self.position, self.graph.vertices[vertex].position)
