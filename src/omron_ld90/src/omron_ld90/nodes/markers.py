"""RViz markers of a map and of the live laser: what they look like, and nothing else.

Each marker keeps its namespace and id, so that a newer one replaces it. An array begins with
DELETEALL, because a late joiner gets only the last message. Points and lines are drawn flat on the
floor, in layers a few millimetres apart.
"""
from __future__ import annotations

from typing import List, Sequence

import numpy as np
import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from omron_ld90.arcl import RangeReading
from omron_ld90.maps import MapDocument, MapObject
from omron_ld90.maps.objects import printable
from omron_ld90.nodes.fast_messages import PointsMarker
from omron_ld90.nodes.units import MM_PER_M, metres, pose_from_robot

BLACK = ColorRGBA(0.0, 0.0, 0.0, 1.0)
RED = ColorRGBA(0.85, 0.05, 0.05, 1.0)
GREEN = ColorRGBA(0.0, 0.7, 0.15, 1.0)
WHITE = ColorRGBA(1.0, 1.0, 1.0, 1.0)
ORANGE = ColorRGBA(1.0, 0.55, 0.0, 0.4)
ORANGE_EDGE = ColorRGBA(1.0, 0.45, 0.0, 1.0)
VIOLET = ColorRGBA(0.55, 0.3, 0.8, 1.0)
LIGHT_BLUE = ColorRGBA(0.35, 0.75, 1.0, 1.0)

POINT_SIZE = 0.02  # m, for maps that have no pitch of their own
LINE_WIDTH = 0.05
SQUARE = Vector3(0.3, 0.3, 0.02)
ARROW = Vector3(0.5, 0.07, 0.07)
TEXT_HEIGHT = 0.3
TEXT_GAP = 0.1
CHARACTER_WIDTH = 0.6  # of the text height, at most on average
AREA_HEIGHT = 0.01
FENCE_WIDTH = 0.06
LASER_SIZE = 0.04

# Heights of the layers, m.
AREA_Z, POINT_Z, LINE_Z, LASER_Z, SQUARE_Z, ARROW_Z, TEXT_Z = (
    0.005, 0.02, 0.025, 0.03, 0.04, 0.08, 0.12)


def points(document: MapDocument, header: Header) -> Marker:
    """The scan points, black."""
    size = metres(document.resolution) if document.resolution else POINT_SIZE
    return _many(header, 'points', Marker.POINTS, BLACK, Vector3(size, size, 0.0),
                 document.points, POINT_Z)


def lines(document: MapDocument, header: Header) -> Marker:
    """The wall lines, red."""
    return _many(header, 'lines', Marker.LINE_LIST, RED, Vector3(LINE_WIDTH, 0.0, 0.0),
                 document.lines.reshape(-1, 2), LINE_Z)


def goals(document: MapDocument, header: Header) -> Marker:
    """The goals, green squares."""
    return _many(header, 'goals', Marker.CUBE_LIST, GREEN, SQUARE, _positions(document.goals),
                 SQUARE_Z)


def docks(document: MapDocument, header: Header) -> Marker:
    """The docks, green squares."""
    return _many(header, 'docks', Marker.CUBE_LIST, GREEN, SQUARE, _positions(document.docks),
                 SQUARE_Z)


def goal_names(document: MapDocument, header: Header) -> MarkerArray:
    """The names of goals and docks, white, each ending left of its square, or of its arrow."""
    names = []
    for obj in document.goals + document.docks:
        if not obj.label:
            continue
        half_width = len(obj.label) * CHARACTER_WIDTH * TEXT_HEIGHT / 2.0
        reach = ARROW.x if obj.heads_left else SQUARE.x / 2.0
        marker = _one(header, 'goal_names', len(names), Marker.TEXT_VIEW_FACING, WHITE,
                      Vector3(0.0, 0.0, TEXT_HEIGHT))
        marker.pose.position = Point(metres(obj.x) - reach - TEXT_GAP - half_width,
                                     metres(obj.y), TEXT_Z)
        marker.text = obj.label
        names.append(marker)
    return _array(header, names)


def goal_headings(document: MapDocument, header: Header) -> MarkerArray:
    """Which way the robot faces at goals with heading and at docks: black arrows."""
    arrows = []
    for obj in document.goals + document.docks:
        if obj.has_heading:
            marker = _one(header, 'goal_headings', len(arrows), Marker.ARROW, BLACK, ARROW)
            marker.pose = pose_from_robot(obj.x, obj.y, obj.theta)
            marker.pose.position.z = ARROW_Z
            arrows.append(marker)
    return _array(header, arrows)


def forbidden_areas(document: MapDocument, header: Header) -> MarkerArray:
    """Forbidden areas as flat orange boxes, forbidden lines as orange lines."""
    markers: List[Marker] = []
    for number, area in enumerate(document.forbidden_areas):
        box = area.rectangle
        marker = _one(header, 'forbidden_areas', number, Marker.CUBE, ORANGE,
                      Vector3(metres(box.width), metres(box.height), AREA_HEIGHT))
        marker.pose = pose_from_robot(box.centre_x, box.centre_y, box.yaw)
        marker.pose.position.z = AREA_Z
        markers.append(marker)
    ends = [((line.extent.from_x, line.extent.from_y), (line.extent.to_x, line.extent.to_y))
            for line in document.forbidden_lines]
    if ends:
        fence = _many(header, 'forbidden_lines', Marker.LINE_LIST, ORANGE_EDGE,
                      Vector3(FENCE_WIDTH, 0.0, 0.0), np.reshape(ends, (-1, 2)), AREA_Z)
        markers.append(fence.to_plain())
    return _array(header, markers)


def sectors(document: MapDocument, header: Header) -> MarkerArray:
    """Sectors (areas that change how the robot drives) as violet outlines with their names."""
    markers: List[Marker] = []
    for number, sector in enumerate(document.sectors):
        outline = sector.outline
        edge = _many(header, 'sectors', Marker.LINE_STRIP, VIOLET, Vector3(LINE_WIDTH, 0.0, 0.0),
                     np.concatenate((outline, outline[:1])), AREA_Z, number)
        markers.append(edge.to_plain())
        if sector.label:
            name = _one(header, 'sector_names', number, Marker.TEXT_VIEW_FACING, VIOLET,
                        Vector3(0.0, 0.0, TEXT_HEIGHT * 0.7))
            centre = outline.mean(axis=0)
            name.pose.position = Point(metres(centre[0]), metres(centre[1]), TEXT_Z)
            name.text = sector.label
            markers.append(name)
    return _array(header, markers)


def laser(reading: RangeReading, header: Header, lifetime: float) -> Marker:
    """What a range device sees, light blue; RViz drops it after `lifetime` seconds."""
    marker = _many(header, printable(reading.device), Marker.POINTS, LIGHT_BLUE,
                   Vector3(LASER_SIZE, LASER_SIZE, 0.0), reading.points, LASER_Z)
    marker.lifetime = rospy.Duration.from_sec(lifetime)
    return marker


def _one(header: Header, namespace: str, number: int, kind: int, colour: ColorRGBA,
         scale: Vector3) -> Marker:
    return Marker(header=header, ns=namespace, id=number, type=kind, color=colour, scale=scale,
                  pose=Pose(orientation=Quaternion(0.0, 0.0, 0.0, 1.0)))


def _many(header: Header, namespace: str, kind: int, colour: ColorRGBA, scale: Vector3,
          positions: np.ndarray, z: float, number: int = 0) -> PointsMarker:
    """A marker of many `positions` (N, 2) in mm; without any it takes an older one away."""
    array = np.full((len(positions), 3), z)
    array[:, :2] = np.asarray(positions).reshape(-1, 2) / MM_PER_M
    return PointsMarker(
        array, header=header, ns=namespace, id=number, type=kind, color=colour, scale=scale,
        action=Marker.ADD if len(array) else Marker.DELETE,
        pose=Pose(orientation=Quaternion(0.0, 0.0, 0.0, 1.0)))


def _positions(objects: Sequence[MapObject]) -> np.ndarray:
    return np.array([(obj.x, obj.y) for obj in objects]).reshape(-1, 2)


def _array(header: Header, markers: List[Marker]) -> MarkerArray:
    return MarkerArray([Marker(header=header, action=Marker.DELETEALL)] + markers)
