"""Checks whether a graph may be replaced by another one while robots drive on it.

The check uses the last reports of the robots. So it holds for each sender of routes, and even
without a planner. Edges that are planned but not yet on a running route may change, because they
are planned again.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping, Optional, Tuple

from trajectory_graph import Graph, change_of, speed_of
from trajectory_graph.drawn_names import edge_name


@dataclass(frozen=True)
class ReportedRoute:
    """The route and the place in a robot's last report.

    left -- signed ids of the edges of its running route that it has not completed, in order
    edge -- signed id of the edge on which it is; 0: off the graph
    """

    left: Tuple[int, ...] = ()
    edge: int = 0


def what_breaks(old: Graph, new: Graph, routes: Mapping[str, ReportedRoute]) -> Optional[str]:
    """Returns a sentence that says why `new` cannot replace `old` now; None if it can.

    routes -- the last report of each robot, by its name
    """
    for robot, route in routes.items():
        for edge in route.left:
            problem = change_of(old, new, edge)
            if problem is None and abs(edge) in new.edges and speed_of(new, edge) <= 0.0:
                problem = f'may not be driven {"forwards" if edge > 0 else "backwards"} any more'
            if problem is not None:
                return (f'{edge_name(old, abs(edge)).capitalize()} {problem}, but robot '
                        f'{robot} is to drive it on its running route: wait until it has arrived, '
                        'or stop it.')
        if route.edge:
            problem = change_of(old, new, route.edge)
            if problem is not None:
                return (f'{edge_name(old, abs(route.edge)).capitalize()} {problem}, but '
                        f'robot {robot} is on it: drive it elsewhere first.')
    return None
