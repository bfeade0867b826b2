"""How much room a graph's edges have, and which cannot have a whole corridor. Metres."""
from __future__ import annotations

from typing import Dict, NamedTuple, Tuple

import numpy as np

from graph_editor.floor import Floor
from trajectory_graph import Graph

STEP = 0.05  # m between the places of a curve that are looked at


class Tightest(NamedTuple):
    """The place of an edge with the least clearance."""

    clearance: float
    place: Tuple[float, float]


def tightest_places(graph: Graph, floor: Floor) -> Dict[int, Tightest]:
    """The tightest place of every edge, by its id."""
    found = {}
    for id in graph.edges:
        points = graph.curve(id).sample(STEP)
        clearances = floor.clearance_at(points)
        worst = int(np.argmin(clearances))
        found[id] = Tightest(float(clearances[worst]), (float(points[worst][0]),
                                                        float(points[worst][1])))
    return found


def narrow_edges(graph: Graph, floor: Floor, corridor: float, robot_width: float
                 ) -> Dict[int, float]:
    """Corridor (m, to the whole cm) of the edges that have no room for `corridor`."""
    widths = {}
    for id, tightest in tightest_places(graph, floor).items():
        if tightest.clearance < corridor / 2.0:
            widths[id] = max(int(200.0 * tightest.clearance) / 100.0, robot_width + 0.01)
    return widths
