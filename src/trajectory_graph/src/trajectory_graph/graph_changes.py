"""Compares an edge in two graphs, for robots that are on the edge or will drive it.

The comparison is used by the node that replaces a graph, and by the robots that continue their
routes on the new graph. During a drive the speeds of an edge may change. Its id, ends, curve and
docks may not change.
"""
from __future__ import annotations

from typing import Optional

import numpy as np

from trajectory_graph.drawn_names import at_vertex, vertex_name
from trajectory_graph.graph import Graph

_SAME = 1e-3  # m; if no control point has moved farther, the curve has not changed


def change_of(old: Graph, new: Graph, signed_id: int) -> Optional[str]:
    """Returns a clause that says how an edge differs between two graphs; None: it is the same."""
    id = abs(signed_id)
    if id not in old.edges:
        return None  # the old graph does not have the edge, so there is nothing to compare
    if id not in new.edges:
        return 'is missing'
    before, after = old.edges[id], new.edges[id]
    if (before.origin, before.destination) != (after.origin, after.destination):
        ends = [' and '.join(vertex_name(graph, end) for end in (edge.origin, edge.destination))
                for graph, edge in ((new, after), (old, before))]
        return f'joins {ends[0]} and no longer {ends[1]}'
    if np.abs(old.control_points(id) - new.control_points(id)).max() > _SAME:
        return 'runs elsewhere'
    for end in (before.origin, before.destination):
        if old.vertices[end].dock and not new.vertices[end].dock:
            return f'ends {at_vertex(old, end)}, which is no longer a dock'
        if new.vertices[end].dock and not old.vertices[end].dock:
            return f'ends {at_vertex(new, end)}, which is a dock now'
    return None


def speed_of(graph: Graph, signed_id: int) -> float:
    """Returns the speed (m/s) of an edge in a direction; 0: this direction is forbidden."""
    edge = graph.edge(signed_id)
    return edge.velocity_forward if signed_id > 0 else edge.velocity_backwards
