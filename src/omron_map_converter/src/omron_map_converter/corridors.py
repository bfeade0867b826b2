"""The floor that a robot needs to drive on a graph; no fence may touch it. In mm, map frame.

A corridor follows every edge's curve. At each place where the robot has to turn, a disc in which it
can turn is also free:
- at end vertices,
- where a path has a bend within a stretch as long as the robot's half diagonal,
- at vertices where a path is not nearly straight, if a corridor there is too narrow for turning,
- at the dock, from which a strip also leads to the station.
The corridors of edges that meet are joined, so junctions are open.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import List, Mapping, Optional

from shapely.geometry import LineString, Point
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

from omron_map_converter.bends import bends_of, corners_of
from omron_map_converter.footprint import HALF_DIAGONAL, HALF_WIDTH
from omron_map_converter.goals import MapPose, millimetres
from trajectory_graph import Graph

ROBOT_HALF_WIDTH = 1000.0 * HALF_WIDTH
ROBOT_HALF_DIAGONAL = 1000.0 * HALF_DIAGONAL
ARC = 8  # segments of a quarter circle: a circle of 0.5 m is exact to 2.4 mm
ROUNDING = 2.5  # mm added to outlines, so that polygons are no smaller than their circles
CURVE_TOLERANCE = 0.5  # mm between a curve and the polyline that represents it
SLIT = 17.0  # mm: gaps in the floor that are narrower than twice this are filled
NEARLY_STRAIGHT = math.radians(5.0)  # with a smaller turn a robot hardly leaves its lane
MITRE = 2  # Shapely's join style that keeps corners sharp


@dataclass(frozen=True)
class CorridorRules:
    """The dimensions of the floor for the robot, in mm."""

    width: float = 900.0
    edge_widths: Mapping[int, float] = field(default_factory=dict)
    """Widths of single edges, by edge id; the others have `width`."""
    turning_radius: float = ROBOT_HALF_DIAGONAL + 50.0
    station_distance: float = 1500.0
    """Distance from the dock pose to the station that it faces."""

    def width_of(self, edge_id: int) -> float:
        """Returns the width of an edge's corridor."""
        return self.edge_widths.get(edge_id, self.width)


@dataclass(frozen=True)
class Corridors:
    """The floor of a graph, and its parts."""

    curves: Mapping[int, LineString]
    """The curves of the edges, by edge id."""
    rules: CorridorRules
    floor: BaseGeometry
    """The floor that must stay free: half a corridor's width to either side of every curve, discs
    for turning, and the strip to the station, with slits filled."""

    def lanes_widened(self, by: float) -> BaseGeometry:
        """Returns only the corridors, each wider by `by` on either side."""
        return unary_union(_lanes(self.curves, self.rules, by))


def corridors_of(graph: Graph, rules: CorridorRules, dock: Optional[MapPose] = None) -> Corridors:
    """Returns the floor of `graph`; `dock` is the pose from which the robot docks."""
    curves = {id: LineString(graph.curve(id).points * 1000.0).simplify(CURVE_TOLERANCE)
              for id in graph.edges}
    floor = unary_union(_lanes(curves, rules) + _turning_places(graph, rules)
                        + _docking_place(dock, rules))
    without_slits = floor.buffer(SLIT, join_style=MITRE).buffer(-SLIT, join_style=MITRE)
    return Corridors(curves, rules, without_slits)


def _lanes(curves: Mapping[int, LineString], rules: CorridorRules,
           wider: float = 0.0) -> List[BaseGeometry]:
    return [_around(curve, rules.width_of(id) / 2.0 + wider) for id, curve in curves.items()]


def _around(shape: BaseGeometry, distance: float) -> BaseGeometry:
    return shape.buffer(distance + ROUNDING, ARC)


def _turning_places(graph: Graph, rules: CorridorRules) -> List[BaseGeometry]:
    places = bends_of(graph, HALF_DIAGONAL)
    narrow = {id for id in graph.edges if rules.width_of(id) < 2.0 * ROBOT_HALF_DIAGONAL}
    bent = corners_of(graph, NEARLY_STRAIGHT)
    places += [vertex.position for vertex in graph.vertices.values()
               if graph.is_end_vertex(vertex.id)
               or vertex.id in bent and not narrow.isdisjoint(graph.edges_at(vertex.id))]
    return [_around(Point(millimetres(place)), rules.turning_radius) for place in places]


def _docking_place(dock: Optional[MapPose], rules: CorridorRules) -> List[BaseGeometry]:
    if dock is None:
        return []
    ahead = math.radians(dock.heading)
    station = (dock.x + rules.station_distance * math.cos(ahead),
               dock.y + rules.station_distance * math.sin(ahead))
    flat = 2
    return [_around(Point(dock.x, dock.y), rules.turning_radius),
            LineString([(dock.x, dock.y), station]).buffer(rules.width / 2.0, cap_style=flat)]
