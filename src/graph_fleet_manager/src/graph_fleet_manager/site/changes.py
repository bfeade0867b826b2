"""May a graph be replaced by another one while robots drive on it?

Judged by what the robots themselves reported last: that holds whoever sent their routes, and also
while nobody plans. What is planned but not under way may change; it is planned anew.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping, Optional, Tuple

import numpy as np

from trajectory_graph import Graph

_SAME = 1e-3  # m between control points of a curve that has not changed


@dataclass(frozen=True)
class ReportedRoute:
    """What a robot reported last.

    left -- signed ids of the edges of its running route that it has not completed, in order
    edge -- signed id of the edge on which it is; 0: off the graph
    """

    left: Tuple[int, ...] = ()
    edge: int = 0


def what_breaks(old: Graph, new: Graph, routes: Mapping[str, ReportedRoute]) -> Optional[str]:
    """Why `new` cannot replace `old` now, as a sentence; None where it can.

    routes -- by the name of the robot
    """
    for robot, route in routes.items():
        for edge in route.left:
            problem = _change_of(old, new, edge)
            if problem is None and abs(edge) in new.edges and _speed(new, edge) <= 0.0:
                problem = f'may not be driven as {edge} any more'
            if problem is not None:
                return (f'Edge {abs(edge)} {problem}, but robot {robot} is to drive it on its '
                        'running route: wait until it has arrived, or stop it.')
        if route.edge:
            problem = _change_of(old, new, route.edge)
            if problem is not None:
                return (f'Edge {abs(route.edge)} {problem}, but robot {robot} is on it: drive it '
                        'elsewhere first.')
    return None


def _change_of(old: Graph, new: Graph, signed_id: int) -> Optional[str]:
    """How an edge that `old` has is another one in `new`."""
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


def _speed(graph: Graph, signed_id: int) -> float:
    edge = graph.edge(signed_id)
    return edge.velocity_forward if signed_id > 0 else edge.velocity_backwards
