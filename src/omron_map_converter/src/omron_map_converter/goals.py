"""The vertices of a trajectory graph as the goals and the dock of a map.

The graph is in metres and radians, a map in millimetres and degrees. This module converts the units
of everything that is written into a map.

A robot waits at an *end vertex* (with exactly one edge) with the heading of its way out, so that it
can leave without turning on the spot. At a dock it has the opposite heading: facing the station.
"""
from __future__ import annotations

import math
from typing import List, NamedTuple, Optional, Tuple

from omron_map import MapObject
from omron_map_converter.goal_names import goal_name
from trajectory_graph import Graph, Vertex


class MapPose(NamedTuple):
    """A pose in the map: mm and degrees."""

    x: float
    y: float
    heading: float


def millimetres(position: Tuple[float, float]) -> Tuple[int, int]:
    """Returns a position of the graph (m) in the unit of a map (whole mm)."""
    return round(position[0] * 1000.0), round(position[1] * 1000.0)


def heading_out(graph: Graph, vertex: Vertex) -> float:
    """Returns the heading (degrees) in which the only edge of an end vertex leads away from it.

    If the vertex is the origin of the edge, the heading is Theta of the vertex. If it is the
    destination, the heading is Theta + 180 degrees.
    """
    edge, = graph.edges_from(vertex.id)
    return math.degrees(vertex.theta) + (0.0 if edge > 0 else 180.0)


def goal(graph: Graph, vertex: Vertex) -> MapObject:
    """Returns the vertex as a goal; a goal at an end vertex has the heading for waiting."""
    heading = heading_out(graph, vertex) if graph.is_end_vertex(vertex.id) else None
    return MapObject.goal(goal_name(vertex), *millimetres(vertex.position), heading=heading)


def dock_pose(graph: Graph, vertex_id: int, heading: Optional[float] = None) -> MapPose:
    """Returns the pose before docking, facing the station.

    `heading` (degrees) replaces the heading that follows from the graph. Raises UnknownVertex, and
    ValueError if the vertex has several edges, so that the graph does not determine the heading.
    """
    vertex = graph.vertex(vertex_id)
    if heading is None:
        if not graph.is_end_vertex(vertex_id):
            raise ValueError(f'the dock vertex {vertex_id} has several edges: give the heading '
                             'that faces the station as dock_heading')
        heading = heading_out(graph, vertex) + 180.0
    return MapPose(*millimetres(vertex.position), heading)


def dock(graph: Graph, vertex_id: int, heading: Optional[float] = None) -> MapObject:
    """Returns the dock vertex as the robot's dock; arguments and errors as for `dock_pose`."""
    return MapObject.dock(goal_name(graph.vertex(vertex_id)),
                          *dock_pose(graph, vertex_id, heading))


def places_of(graph: Graph, dock_vertex: Optional[int],
              dock_heading: Optional[float] = None) -> List[MapObject]:
    """Returns all vertices as map objects, by id: goals, and a dock for `dock_vertex` (None: no
    dock).

    Raises the same errors as `dock_pose`.
    """
    if dock_vertex is not None:
        graph.vertex(dock_vertex)
    return [dock(graph, id, dock_heading) if id == dock_vertex else goal(graph, graph.vertex(id))
            for id in sorted(graph.vertices)]
