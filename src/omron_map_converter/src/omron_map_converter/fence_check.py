"""Checks the fences of a map, independently of how they were made. All in mm, map frame.

A *leak* is a place at which a robot can leave the corridors. For the check, the robot is a disc of
its width that starts at any vertex. At a leak, the centre of the disc can get farther from every
curve than half a corridor plus ALLOWANCE, outside the zones for turning and docking. The check only
widens and cuts shapes; it shares no code with the search for fences.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, List, Tuple

import numpy as np
from shapely.geometry import LineString, MultiPoint, Point, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union
from shapely.prepared import prep

from omron_map import MapObject
from omron_map_converter.corridors import ROBOT_HALF_WIDTH, ROUNDING, Corridors
from omron_map_converter.goals import millimetres
from trajectory_graph import Graph

ALLOWANCE = 50.0
INTRUSION = 5.0  # a fence may reach into a corridor by this length
POINT_PITCH = 60.0  # obstacle points nearer to each other than this count as one
ARC = 16  # segments of a quarter circle; circles drawn with them are smaller than true ones
SHORTEST_GATE = 1.0  # a shorter gap between fences is only an effect of rounding
TOUCHING = 0.1  # pieces of a gap are joined if the distance between them is below twice this


@dataclass(frozen=True)
class FenceCheck:
    """The faults of a map's fences."""

    leaks: Tuple[Tuple[float, float], ...]
    """The leaks: x, y of the middle of each gap."""
    lost_area: float
    """Area (mm2) of the floor that fences cover; see the function `lost_area`."""

    @property
    def passed(self) -> bool:
        """Whether there is no fault."""
        return not self.leaks and self.lost_area < 1.0


def check_fences(graph: Graph, corridors: Corridors, fences: Iterable[MapObject],
                 walls: np.ndarray) -> FenceCheck:
    """Looks for leaks between `fences` (as written into the map) and `walls` (N,2)."""
    shapes = [shape_of(fence) for fence in fences]
    return FenceCheck(tuple(_leaks(graph, corridors, shapes, walls)),
                      lost_area(corridors.floor, shapes))


def shape_of(fence: MapObject) -> BaseGeometry:
    """Returns the polygon of a forbidden area, or the line of a forbidden line."""
    if fence.is_area:
        return Polygon(fence.rectangle.corners)
    return LineString(fence.ends)


def lost_area(floor: BaseGeometry, shapes: Iterable[BaseGeometry]) -> float:
    """Returns the area (mm2) of the floor that `shapes` cover.

    A strip along the edge of the floor does not count: it is INTRUSION mm wide. A shape that is a
    line counts as 1 mm wide.
    """
    inner = floor.buffer(-INTRUSION)
    near = prep(inner)
    touching = [shape.buffer(0.5) for shape in shapes if near.intersects(shape)]
    return inner.intersection(unary_union(touching)).area if touching else 0.0


def _leaks(graph: Graph, corridors: Corridors, shapes: List[BaseGeometry],
           walls: np.ndarray) -> List[Tuple[float, float]]:
    allowed = unary_union([corridors.lanes_widened(ALLOWANCE - ROUNDING), corridors.floor])
    # GEOS omits parts of the buffer of some long lines, so only points are selected with a buffer.
    obstacles = [shape for shape in shapes if shape.distance(allowed.boundary) <= ROBOT_HALF_WIDTH]
    in_reach = prep(allowed.boundary.buffer(ROBOT_HALF_WIDTH))
    obstacles += [point for point in map(Point, _thinned(walls)) if in_reach.contains(point)]
    blocked = unary_union([shape.buffer(ROBOT_HALF_WIDTH, ARC) for shape in obstacles])
    vertices = MultiPoint([millimetres(vertex.position) for vertex in graph.vertices.values()])
    reached = [part for part in _parts(allowed.difference(blocked))
               if prep(part).intersects(vertices)]
    gates = unary_union(reached).boundary.intersection(allowed.boundary)
    whole_gates = unary_union([gate.buffer(TOUCHING) for gate in _parts(gates)])
    return [gate.centroid.coords[0] for gate in _parts(whole_gates)
            if gate.length > 2.0 * SHORTEST_GATE]


def _thinned(points: np.ndarray) -> np.ndarray:
    """Returns one of the points in each square with the side POINT_PITCH."""
    if not len(points):
        return points
    _, first = np.unique(np.floor(points / POINT_PITCH).astype(int), axis=0, return_index=True)
    return points[first]


def _parts(shape: BaseGeometry) -> List[BaseGeometry]:
    return [] if shape.is_empty else list(getattr(shape, 'geoms', [shape]))
