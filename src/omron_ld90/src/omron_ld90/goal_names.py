"""What the vertices of a graph are called on the robot: for the converter and the bridge alike."""
from __future__ import annotations

from trajectory_graph import Vertex


def goal_name(vertex: Vertex) -> str:
    """The name under which ARCL's `goto` knows the vertex."""
    return str(vertex.id)
