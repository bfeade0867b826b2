"""What another graph changes of an edge, for robots that are on it or are to drive it.

One rule for all: the node that replaces a graph asks it, and so do the robots that then go on.
Speeds may change under way; ids, ends, curves and docks may not.
"""
from __future__ import annotations

from typing import Optional

import numpy as np

from trajectory_graph.graph import Graph

_SAME = 1e-3  # m between control points of a curve that has not changed


def change_of(old: Graph, new: Graph, signed_id: int) -> Optional[str]:
    """How an edge that `old` has is another one in `new`, a clause; None: it is the same."""
    id = abs(signed_id)
    if id not in old.edges:
        return None  # not known before: what changes is unknown
    if id not in new.edges:
        return 'is missing'
    before, after = old.edges[id], new.edges[id]
    if (before.origin, before.destination) != (after.origin, after.destination):
        return (f'joins vertices {after.origin} and {after.destination} and no longer '
                f'{before.origin} and {before.destination}')
    if np.abs(old.control_points(id) - new.control_points(id)).max() > _SAME:
        return 'runs elsewhere'
    for end in (before.origin, before.destination):
        if old.vertices[end].dock and not new.vertices[end].dock:
            return f'ends at vertex {end}, which is no longer a dock'
        if new.vertices[end].dock and not old.vertices[end].dock:
            return f'ends at vertex {end}, which is a dock now'
    return None


def speed_of(graph: Graph, signed_id: int) -> float:
    """m/s at which an edge may be driven in a direction; 0: it may not."""
    edge = graph.edge(signed_id)
    return edge.velocity_forward if signed_id > 0 else edge.velocity_backwards
