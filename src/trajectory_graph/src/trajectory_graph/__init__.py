"""The trajectory graph of a robot fleet: vertices, edges, curves, YAML files, routes.

Units are metres, radians and m/s. The package depends neither on ROS nor on any robot.
"""
from trajectory_graph.curves import Curve, Projection
from trajectory_graph.errors import (
    DiscontinuousRoute,
    ForbiddenDirection,
    GraphError,
    NoPath,
    TrajectoryGraphError,
    UnknownEdge,
    UnknownVertex,
)
from trajectory_graph.graph import CurveType, Edge, Graph, Vertex
from trajectory_graph.graph_changes import change_of, speed_of
from trajectory_graph.routes import check_drivable, check_route, route_vertices
from trajectory_graph.splitting import split_edges
from trajectory_graph.yaml_file import load_graph, save_graph

__all__ = [
    'Curve', 'CurveType', 'DiscontinuousRoute', 'Edge', 'ForbiddenDirection', 'Graph', 'GraphError',
    'NoPath', 'Projection', 'TrajectoryGraphError', 'UnknownEdge', 'UnknownVertex', 'Vertex',
    'change_of', 'check_drivable', 'check_route', 'load_graph', 'route_vertices', 'save_graph',
    'speed_of', 'split_edges',
]
