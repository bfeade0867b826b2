"""Fences as objects of a map: makes, recognises and checks them."""
from __future__ import annotations

from enum import Enum
from typing import Iterable, List

import numpy as np
from shapely.geometry import Point
from shapely.geometry.base import BaseGeometry
from shapely.prepared import prep

from omron_map import MapObject
from omron_map_converter.corridors import ROBOT_HALF_WIDTH, Corridors
from omron_map_converter.fence_check import check_fences, shape_of
from omron_map_converter.fence_cover import fence_areas, fence_lines
from omron_map_converter.obstacles import obstructions
from trajectory_graph import Graph

FENCE = 'omron_ros_map fence'
"""Description of the objects that keep the robot in the corridors; a later run replaces them."""


class Fences(Enum):
    """The objects that keep the robot in the graph's corridors."""

    AREAS = 'areas'
    LINES = 'lines'
    NONE = 'none'


def is_fence(obj: MapObject) -> bool:
    """Returns whether a converter made the object to keep the robot in its corridors."""
    return obj.description == FENCE


def fence_objects(floor: BaseGeometry, walls: np.ndarray, kind: Fences) -> List[MapObject]:
    """Returns fences as map objects around `floor` (mm), at openings between `walls` (N,2)."""
    if kind is Fences.AREAS:
        return [MapObject.forbidden_area(fence.rectangle, description=FENCE)
                for fence in fence_areas(floor, walls)]
    if kind is Fences.LINES:
        return [MapObject.forbidden_line(*fence.line, description=FENCE)
                for fence in fence_lines(floor, walls)]
    return []


def notes_on_fences(graph: Graph, corridors: Corridors, fences: Iterable[MapObject],
                    walls: np.ndarray) -> List[str]:
    """Returns the faults of the fences, as sentences for a person; empty if there are none."""
    check = check_fences(graph, corridors, fences, walls)
    notes = [f'The fences leave a gap at {x:.0f} {y:.0f} mm: close it by hand in MobilePlanner.'
             for x, y in check.leaks]
    if check.lost_area >= 1.0:
        notes.append(f'The fences take {check.lost_area / 1e6:.3f} m2 of the corridors.')
    return notes


def notes_on_homes(corridors: Corridors, homes: Iterable[MapObject]) -> List[str]:
    """Returns notes on start positions outside the corridors, from which a robot reaches no goal.
    """
    return [f'{home} at {_where(home)} mm is outside the corridors: a robot that starts there can '
            'drive to no goal.' for home in homes
            if not corridors.floor.intersects(_shape(home))]


def _shape(home: MapObject) -> BaseGeometry:
    return shape_of(home) if home.is_area else Point(home.x, home.y)


def _where(home: MapObject) -> str:
    centre = _shape(home).centroid
    return f'{centre.x:.0f} {centre.y:.0f}'


def notes_on_places(corridors: Corridors, places: Iterable[MapObject]) -> List[str]:
    """Returns notes on places that the fences cut off."""
    floor = prep(corridors.floor)
    return [f'{place} is outside the corridors: the robot cannot drive to it '
            'any more.' for place in places if not floor.contains(Point(place.x, place.y))]


def notes_on_walls(graph: Graph, walls: np.ndarray) -> List[str]:
    """Returns notes on edges that the robot cannot follow because of an obstacle in the map."""
    return [f'Edge {found.edge_id} leads past an obstacle at a distance of {found.distance:.0f} mm '
            f'near {found.x:.0f} {found.y:.0f} mm, but the robot is {2 * ROBOT_HALF_WIDTH:.0f} mm '
            'wide.' for found in obstructions(graph, walls, ROBOT_HALF_WIDTH)]
