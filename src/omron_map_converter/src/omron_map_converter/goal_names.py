"""The names of a graph's vertices on the robot, for the converter and the bridge."""
from __future__ import annotations

from trajectory_graph import Vertex


def goal_name(vertex: Vertex) -> str:
    """Returns the name of the vertex in ARCL's `goto`."""
    return str(vertex.id)
