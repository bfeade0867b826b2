"""Converts graphs to and from messages of `itrci_nav_msgs`.

The module does not import ROS; it only uses the fields of the messages.
"""
from __future__ import annotations

from typing import Any, Optional

from trajectory_graph.errors import GraphError
from trajectory_graph.graph import CurveType, Edge, Graph, Vertex


def graph_from_message(message: Any) -> Graph:
    """Returns the graph in an `itrci_nav_msgs/Graph`; raises GraphError if it is not valid."""
    return Graph(
        [Vertex(v.id, v.x, v.y, v.theta, v.theta_holonomic, v.label, v.frame_id, v.dock,
                _parking(v)) for v in message.vertices],
        [Edge(e.id, e.origin_id, e.destination_id, _curve_type(e), e.param_f, e.param_b,
              e.velocity_forward, e.velocity_backwards, e.section_of) for e in message.edges])


def fill_message(message: Any, graph: Graph, vertex_type: Any, edge_type: Any) -> Any:
    """Fills an empty `itrci_nav_msgs/Graph` and returns it.

    vertex_type, edge_type -- the message types of vertices and edges
    """
    message.vertices = [vertex_message(vertex, vertex_type) for vertex in graph.vertices.values()]
    message.edges = [edge_message(edge, edge_type) for edge in graph.edges.values()]
    return message


def vertex_message(vertex: Vertex, vertex_type: Any) -> Any:
    """Returns the `itrci_nav_msgs/Vertex` of a vertex."""
    return vertex_type(
        id=vertex.id, label=vertex.label, frame_id=vertex.frame_id, x=vertex.x, y=vertex.y,
        theta=vertex.theta, theta_holonomic=vertex.theta_holonomic, dock=vertex.dock,
        parking=vertex.parking is True, no_parking=vertex.parking is False)


def edge_message(edge: Edge, edge_type: Any) -> Any:
    """Returns the `itrci_nav_msgs/Edge` of an edge."""
    return edge_type(
        id=edge.id, origin_id=edge.origin, destination_id=edge.destination,
        curve_type=edge.curve_type.value, param_f=edge.param_f, param_b=edge.param_b,
        velocity_forward=edge.velocity_forward, velocity_backwards=edge.velocity_backwards,
        section_of=edge.section_of)


def _parking(vertex: Any) -> Optional[bool]:
    if vertex.parking and vertex.no_parking:
        raise GraphError('has both parking and no_parking set', 'vertex', vertex.id)
    return True if vertex.parking else False if vertex.no_parking else None


def _curve_type(edge: Any) -> CurveType:
    try:
        return CurveType(edge.curve_type)
    except ValueError:
        raise GraphError(f'curve_type is {edge.curve_type!r}, but must be spline or line',
                         'edge', edge.id) from None
