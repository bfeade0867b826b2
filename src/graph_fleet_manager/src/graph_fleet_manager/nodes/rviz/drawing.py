"""Short functions that make markers for RViz. Lengths are in m, in the frame `map`."""
from __future__ import annotations

import colorsys
import math
from typing import Iterable, Tuple

import numpy as np
from geometry_msgs.msg import Point, Pose, Vector3
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from node_lifecycle.headings import quaternion_from_yaw
from trajectory_graph import Curve

FRAME = 'map'
STEP = 0.15         # m between the points of a drawn curve
LONGEST_TEXT = 120  # characters
LAST_LETTER = 255   # code point up to which RViz's font certainly draws
_GOLDEN = 0.618034  # step on the circle of hues: each new hue is far from all earlier ones


def colour(red: float, green: float, blue: float, alpha: float = 1.0) -> ColorRGBA:
    """A colour from its components, each in 0..1."""
    return ColorRGBA(red, green, blue, alpha)


def own_colour(number: int, saturation: float = 0.65) -> ColorRGBA:
    """The colour of the robot with this number. Robots with near numbers differ clearly."""
    return colour(*colorsys.hsv_to_rgb((0.55 + number * _GOLDEN) % 1.0, saturation, 1.0))


def shape(kind: int, namespace: str, number: int, paint: ColorRGBA,
          size: Tuple[float, float, float], pose: Pose) -> Marker:
    """A marker. The meaning of `size` is that of the marker's `scale` for this `kind`."""
    marker = Marker(type=kind, ns=namespace, id=number, color=paint, scale=Vector3(*size),
                    pose=pose)
    marker.header.frame_id = FRAME
    return marker


def text(namespace: str, number: int, words: str, place: Tuple[float, float], height: float,
         paint: ColorRGBA, z: float = 1.0) -> Marker:
    """A text that faces the viewer, centred at `place`. Letters that RViz lacks become `?`."""
    marker = shape(Marker.TEXT_VIEW_FACING, namespace, number, paint, (0.0, 0.0, height),
                   pose_at(place, z=z))
    marker.text = ''.join(
        letter if letter == '\n' or (letter.isprintable() and ord(letter) <= LAST_LETTER) else '?'
        for letter in words[:LONGEST_TEXT])
    return marker


def pose_at(place: Tuple[float, float], yaw: float = 0.0, z: float = 0.0) -> Pose:
    """A pose from a point on the floor (m), a heading (rad) and a height (m)."""
    return Pose(Point(place[0], place[1], z), quaternion_from_yaw(yaw))


def lines(namespace: str, number: int, paint: ColorRGBA, width: float,
          polylines: Iterable[np.ndarray], z: float) -> Marker:
    """All polylines, each (N, 2), in one marker. Without polylines the marker is a deletion."""
    marker = shape(Marker.LINE_LIST, namespace, number, paint, (width, 0.0, 0.0),
                   pose_at((0.0, 0.0)))
    for polyline in polylines:
        ends = np.repeat(polyline, 2, axis=0)[1:-1]
        marker.points += [Point(x, y, z) for x, y in ends.tolist()]
    marker.action = Marker.ADD if marker.points else Marker.DELETE
    return marker


def beside(curve: Curve, offset: float) -> np.ndarray:
    """The curve as points (N, 2), shifted to its right by `offset` (m)."""
    places = curve.sample(STEP)
    steps = np.gradient(places, axis=0)
    lengths = np.maximum(np.hypot(steps[:, 0], steps[:, 1]), 1e-9)
    right = np.column_stack((steps[:, 1], -steps[:, 0])) / lengths[:, None]
    return places + offset * right


def ring(centre: Tuple[float, float], radius: float, corners: int = 20) -> np.ndarray:
    """A closed polyline around `centre`."""
    angles = np.linspace(0.0, 2.0 * math.pi, corners + 1)
    return np.array(centre) + radius * np.column_stack((np.cos(angles), np.sin(angles)))
