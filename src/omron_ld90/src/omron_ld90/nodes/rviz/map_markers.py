"""Makes the RViz markers of a map and of the live laser.

Each marker keeps its namespace and id, so that a newer marker replaces it. An array begins with
DELETEALL, because a late subscriber gets only the last message. Markers of the map have no stamp,
so that RViz need not find an old transform. Points and lines are drawn flat on the floor, in layers
a few millimetres apart.
"""
from __future__ import annotations

from typing import List, Sequence, Tuple

import numpy as np
import rospy
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from omron_ld90.nodes.support.poses import pose_from_robot
from omron_ld90.units import MM_PER_M, metres
from omron_map import MapDocument, MapObject
from rviz_drawing import drawing
from rviz_drawing.fast_messages import PointsMarker
from rviz_drawing.text_places import text_size
from trajectory_graph.placing import (
    BELOW_RIGHT_FIRST,
    MayCover,
    Places,
    box_around,
    box_beside,
    middle_of,
)

BLACK = drawing.colour(0.0, 0.0, 0.0)
WALL = drawing.colour(0.05, 0.06, 0.08)
GREEN = drawing.colour(0.0, 0.7, 0.15)
WHITE = drawing.colour(1.0, 1.0, 1.0)
ORANGE = drawing.colour(1.0, 0.55, 0.0, 0.4)
ORANGE_EDGE = drawing.colour(1.0, 0.45, 0.0)
VIOLET = drawing.colour(0.55, 0.3, 0.8)
LIGHT_BLUE = drawing.colour(0.35, 0.75, 1.0)

POINT_SIZE = 0.02  # m, for maps without a pitch
LINE_WIDTH = 0.05
SQUARE = (0.3, 0.3, 0.02)
ARROW = (0.5, 0.07, 0.07)
TEXT_HEIGHT = 0.3
HANDLE, NAME_AWAY = 0.7, 0.5  # m: width of a goal's handle; distance from its middle to the name
AREA_HEIGHT = 0.01
FENCE_WIDTH = 0.06
LASER_SIZE = 0.04

# Heights of the layers, m.
AREA_Z, POINT_Z, LINE_Z, LASER_Z, SQUARE_Z, ARROW_Z, TEXT_Z = (
    0.005, 0.02, 0.025, 0.03, 0.04, 0.08, 0.12)


def points(document: MapDocument, frame: str) -> Marker:
    """Returns the scan points, black."""
    size = metres(document.resolution) if document.resolution else POINT_SIZE
    return _many(frame, 'points', Marker.POINTS, BLACK, (size, size, 0.0),
                 document.points, POINT_Z)


def lines(document: MapDocument, frame: str) -> Marker:
    """Returns the wall lines, in a neutral colour, because red is only for problems."""
    return _many(frame, 'lines', Marker.LINE_LIST, WALL, (LINE_WIDTH, 0.0, 0.0),
                 document.lines.reshape(-1, 2), LINE_Z)


def goals(document: MapDocument, frame: str) -> Marker:
    """Returns the goals, green squares."""
    return _many(frame, 'goals', Marker.CUBE_LIST, GREEN, SQUARE, _positions(document.goals),
                 SQUARE_Z)


def docks(document: MapDocument, frame: str) -> Marker:
    """Returns the docks, green squares."""
    return _many(frame, 'docks', Marker.CUBE_LIST, GREEN, SQUARE, _positions(document.docks),
                 SQUARE_Z)


def goal_names(document: MapDocument, frame: str) -> MarkerArray:
    """Returns the names of goals and docks, in white, each at a corner of its handle.

    Edges of the graph lead to the sides of the handle.
    """
    names: List[Marker] = []
    places = Places()
    named = [obj for obj in document.goals + document.docks if obj.label]
    for obj in named:
        places.cover(box_around((metres(obj.x), metres(obj.y)), (HANDLE, HANDLE)))
    for obj in named:
        boxes = [box_beside((metres(obj.x), metres(obj.y)), NAME_AWAY,
                            text_size(obj.label, TEXT_HEIGHT), side) for side in BELOW_RIGHT_FIRST]
        names.append(drawing.text(
            'goal_names', len(names), obj.label,
            middle_of(boxes[places.place(boxes, may=MayCover.ALL)]), TEXT_HEIGHT, WHITE, TEXT_Z,
            frame))
    return drawing.complete(names)


def goal_headings(document: MapDocument, frame: str) -> MarkerArray:
    """Returns a black arrow for the heading at each dock, and at each goal that has a heading."""
    arrows: List[Marker] = []
    for obj in document.goals + document.docks:
        if obj.has_heading:
            marker = drawing.shape(Marker.ARROW, 'goal_headings', len(arrows), BLACK, ARROW,
                                   frame=frame)
            marker.pose = pose_from_robot(obj.x, obj.y, obj.theta)
            marker.pose.position.z = ARROW_Z
            arrows.append(marker)
    return drawing.complete(arrows)


def forbidden_areas(document: MapDocument, frame: str) -> MarkerArray:
    """Returns forbidden areas as flat orange boxes, forbidden lines as orange lines."""
    markers: List[Marker] = []
    for number, area in enumerate(document.forbidden_areas):
        box = area.rectangle
        marker = drawing.shape(Marker.CUBE, 'forbidden_areas', number, ORANGE,
                               (metres(box.width), metres(box.height), AREA_HEIGHT), frame=frame)
        marker.pose = pose_from_robot(box.centre_x, box.centre_y, box.yaw)
        marker.pose.position.z = AREA_Z
        markers.append(marker)
    ends = [line.ends for line in document.forbidden_lines]
    if ends:
        markers.append(_many(frame, 'forbidden_lines', Marker.LINE_LIST, ORANGE_EDGE,
                             (FENCE_WIDTH, 0.0, 0.0), np.reshape(ends, (-1, 2)), AREA_Z))
    return drawing.complete(markers)


def sectors(document: MapDocument, frame: str) -> MarkerArray:
    """Returns the sectors (areas that change how the robot drives): violet outlines with names."""
    markers: List[Marker] = []
    for number, sector in enumerate(document.sectors):
        outline = sector.outline
        markers.append(_many(frame, 'sectors', Marker.LINE_STRIP, VIOLET, (LINE_WIDTH, 0.0, 0.0),
                             np.concatenate((outline, outline[:1])), AREA_Z, number))
        if sector.label:
            x, y = outline.mean(axis=0)
            markers.append(drawing.text('sector_names', number, sector.label,
                                        (metres(x), metres(y)), TEXT_HEIGHT * 0.7, VIOLET, TEXT_Z,
                                        frame))
    return drawing.complete(markers)


def laser(places: np.ndarray, header: Header, lifetime: float) -> Marker:
    """Returns the laser's hits at `places` (N, 2), m, in light blue.

    RViz removes them after `lifetime` seconds.
    """
    marker = drawing.many(Marker.POINTS, 'laser', 0, LIGHT_BLUE,
                          (LASER_SIZE, LASER_SIZE, 0.0), drawing.at_height(places, LASER_Z))
    marker.header = header
    marker.lifetime = rospy.Duration.from_sec(lifetime)
    return marker


def _many(frame: str, namespace: str, kind: int, paint: ColorRGBA,
          size: Tuple[float, float, float], positions: np.ndarray, z: float,
          number: int = 0) -> PointsMarker:
    """Returns a marker of many `positions` (N, 2) in mm.

    Without positions, the marker deletes an older marker.
    """
    places = drawing.at_height(positions / MM_PER_M, z)
    return drawing.many(kind, namespace, number, paint, size, places, frame)


def _positions(objects: Sequence[MapObject]) -> np.ndarray:
    return np.array([(obj.x, obj.y) for obj in objects]).reshape(-1, 2)
