"""The obstacles of a map as a dense set of points, and the places on edges that they obstruct.

All in mm, map frame.
"""
from __future__ import annotations

from typing import Callable, List, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from omron_map import MapDocument, MapObject, RotatedRectangle
from trajectory_graph import Graph

LINE_PITCH = 20.0
AREA_PITCH = 100.0
CURVE_PITCH = 50.0


class Obstruction(NamedTuple):
    """The point of an edge's curve that is nearest to an obstacle."""

    edge_id: int
    x: float
    y: float
    distance: float


def obstacle_points(document: MapDocument,
                    ignored: Callable[[MapObject], bool] = lambda obj: False) -> np.ndarray:
    """Returns points (N,2) on everything that a robot cannot pass, except `ignored` objects.

    They are on scan points, wall lines and forbidden lines (a point every LINE_PITCH), and in
    forbidden areas (a point every AREA_PITCH).
    """
    points: List[np.ndarray] = [document.points.astype(float)]
    points += [_along(*line) for line in document.lines.tolist()]
    for obj in document.forbidden_lines:
        if not ignored(obj):
            points.append(_along(*map(float, obj.ends.ravel())))
    points += [_inside(obj.rectangle) for obj in document.forbidden_areas if not ignored(obj)]
    return np.concatenate(points)


def obstructions(graph: Graph, obstacles: np.ndarray, clearance: float) -> List[Obstruction]:
    """Returns the edges whose curves have an obstacle nearer than `clearance`, and where."""
    if not len(obstacles):
        return []
    nearest = cKDTree(obstacles)
    found = []
    for id in sorted(graph.edges):
        curve = graph.curve(id).sample(CURVE_PITCH / 1000.0) * 1000.0
        distances, _ = nearest.query(curve, distance_upper_bound=clearance)
        worst = int(np.argmin(distances))
        if distances[worst] < clearance:
            x, y = curve[worst].tolist()
            found.append(Obstruction(id, x, y, float(distances[worst])))
    return found


def _along(x1: float, y1: float, x2: float, y2: float) -> np.ndarray:
    count = int(np.hypot(x2 - x1, y2 - y1) / LINE_PITCH) + 2
    return np.column_stack((np.linspace(x1, x2, count), np.linspace(y1, y2, count)))


def _inside(rectangle: RotatedRectangle) -> np.ndarray:
    start, right, _, up = rectangle.corners
    across = np.linspace(0.0, 1.0, int(rectangle.width / AREA_PITCH) + 2)
    along = np.linspace(0.0, 1.0, int(rectangle.height / AREA_PITCH) + 2)
    u, v = (grid.reshape(-1, 1) for grid in np.meshgrid(across, along))
    return start + u * (right - start) + v * (up - start)
