"""Graphs in messages of `itrci_nav_msgs`, told apart from ROS: only the fields' names are used."""
from __future__ import annotations

from typing import Any, Optional

from trajectory_graph.errors import GraphError
from trajectory_graph.graph import CurveType, Edge, Graph, Vertex


def graph_from_message(message: Any) -> Graph:
    """The graph in an `itrci_nav_msgs/Graph`; raises GraphError when it is not valid."""
    return Graph(
        [Vertex(v.id, v.x, v.y, v.theta, v.theta_holonomic, v.label, v.frame_id, v.dock,
                _parking(v)) for v in message.vertices],
        [Edge(e.id, e.origin_id, e.destination_id, _curve_type(e), e.param_f, e.param_b,
              e.velocity_forward, e.velocity_backwards) for e in message.edges])


def fill_message(message: Any, graph: Graph, vertex_type: Any, edge_type: Any) -> Any:
    """Fills an empty `itrci_nav_msgs/Graph`; the types are those of its elements. Returns it."""
    message.vertices = [
        vertex_type(id=v.id, label=v.label, frame_id=v.frame_id, x=v.x, y=v.y, theta=v.theta,
                    theta_holonomic=v.theta_holonomic, dock=v.dock, parking=v.parking is True,
                    no_parking=v.parking is False)
        for v in graph.vertices.values()]
    message.edges = [
        edge_type(id=e.id, origin_id=e.origin, destination_id=e.destination,
                  curve_type=e.curve_type.value, param_f=e.param_f, param_b=e.param_b,
                  velocity_forward=e.velocity_forward, velocity_backwards=e.velocity_backwards)
        for e in graph.edges.values()]
    return message


def _parking(vertex: Any) -> Optional[bool]:
    if vertex.parking and vertex.no_parking:
        raise GraphError('is said to be parking and to be none', 'vertex', vertex.id)
    return True if vertex.parking else False if vertex.no_parking else None


def _curve_type(edge: Any) -> CurveType:
    try:
        return CurveType(edge.curve_type)
    except ValueError:
        raise GraphError(f'curve_type is {edge.curve_type!r}, but must be spline or line',
                         'edge', edge.id) from None
