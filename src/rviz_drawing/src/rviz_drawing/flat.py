"""Shapes flat on the floor, many of them in one marker. Units are metres and radians.

RViz draws each marker separately, and draws lines anew in each frame. So all parts of a drawing are
one list of triangles. With a thousand edges this is ten times as fast.
"""
from __future__ import annotations

import math
from typing import Iterable, List, NamedTuple, Tuple, cast

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from rviz_drawing.drawing import colour, pose_at

DISC_CORNERS = 12
DIGITS = {
    '0': [(1, 0), (3, 0), (4, 2), (4, 6), (3, 8), (1, 8), (0, 6), (0, 2), (1, 0)],
    '1': [(0.5, 6), (2.5, 8), (2.5, 0)],
    '2': [(0, 6.5), (1, 8), (3, 8), (4, 6.5), (4, 5), (0, 0), (4, 0)],
    '3': [(0, 8), (4, 8), (1.8, 5), (3, 5), (4, 3.8), (4, 1.5), (3, 0), (1, 0), (0, 1.5)],
    '4': [(3, 0), (3, 8), (0, 2.5), (4.3, 2.5)],
    '5': [(4, 8), (0.5, 8), (0.2, 4.6), (3, 5), (4, 3.8), (4, 1.3), (3, 0), (1, 0), (0, 1.2)],
    '6': [(3.5, 8), (1.5, 7), (0, 4), (0, 1.5), (1, 0), (3, 0), (4, 1.5), (4, 3.3), (3, 4.7),
          (1, 4.7), (0, 3.3)],
    '7': [(0, 8), (4, 8), (1.3, 0)],
    '8': [(1, 4.2), (0, 2.5), (0, 1.3), (1, 0), (3, 0), (4, 1.3), (4, 2.5), (3, 4.2), (1, 4.2),
          (0.3, 5.5), (0.3, 7), (1.2, 8), (2.8, 8), (3.7, 7), (3.7, 5.5), (3, 4.2)],
    '9': [(0.5, 0), (2.5, 1), (4, 4), (4, 6.5), (3, 8), (1, 8), (0, 6.5), (0, 4.7), (1, 3.3),
          (3, 3.3), (4, 4.7)],
}
"""The strokes of the digits, in eighths of a digit's height. Digits are drawn as shapes, because
RViz is slow with text."""
STROKE = 1.4  # width of a stroke, in eighths of the height


class FlatShape(NamedTuple):
    """A flat shape in one colour."""

    corners: np.ndarray
    """(3 N, 2) m: the corners of N triangles."""
    z: float
    paint: ColorRGBA


def flat(parts: Iterable[FlatShape], at: Tuple[float, float] = (0.0, 0.0)) -> Marker:
    """Returns one marker of all parts, with its origin at `at`."""
    marker = Marker(type=Marker.TRIANGLE_LIST, pose=pose_at(at), color=colour(1.0, 1.0, 1.0))
    marker.scale.x = marker.scale.y = marker.scale.z = 1.0
    for part in parts:
        corners = cast(List[List[float]], part.corners.tolist())
        marker.points += [Point(x, y, part.z) for x, y in corners]
        marker.colors += [part.paint] * len(part.corners)
    return marker


def disc(diameter: float, z: float, paint: ColorRGBA) -> FlatShape:
    """Returns a disc around the origin."""
    angles = np.linspace(0.0, 2.0 * np.pi, DISC_CORNERS + 1)
    rim = diameter / 2.0 * np.column_stack((np.cos(angles), np.sin(angles)))
    triangles = np.stack((np.zeros((DISC_CORNERS, 2)), rim[:-1], rim[1:]), axis=1)
    return FlatShape(triangles.reshape(-1, 2), z, paint)


def moved(part: FlatShape, to: Tuple[float, float]) -> FlatShape:
    """Returns the part with its origin moved to another place."""
    return part._replace(corners=part.corners + np.array(to))


def together(markers: Iterable[Marker]) -> Marker:
    """Returns one marker that joins several markers, which `flat` has made at the origin."""
    whole = flat(())
    for marker in markers:
        whole.points += marker.points
        whole.colors += marker.colors
    return whole


def strip(points: np.ndarray, width: float, z: float, paint: ColorRGBA) -> FlatShape:
    """Returns a line of the given width through points (N,2)."""
    along = np.diff(points, axis=0)
    along = along / np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    along = np.vstack((along[:1], along[1:] + along[:-1], along[-1:]))
    along = along / np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    aside = width / 2.0 * np.column_stack((-along[:, 1], along[:, 0]))
    left, right = points + aside, points - aside
    pieces = np.stack((left[:-1], right[:-1], left[1:], left[1:], right[:-1], right[1:]), axis=1)
    return FlatShape(pieces.reshape(-1, 2), z, paint)


def arrow(yaw: float, length: float, width: float, z: float, paint: ColorRGBA) -> FlatShape:
    """Returns a triangle with its tip at the distance `length` from the origin."""
    ahead = np.array((math.cos(yaw), math.sin(yaw)))
    aside = width / 2.0 * np.array((-ahead[1], ahead[0]))
    return FlatShape(np.stack((length * ahead, aside, -aside)), z, paint)


def number(value: int, height: float, z: float, paint: ColorRGBA) -> List[FlatShape]:
    """Returns the digits of a number, from the origin to the right."""
    unit, parts = height / 8.0, []
    for place, digit in enumerate(str(value)):
        stroke = np.array(DIGITS.get(digit, [(0, 4), (4, 4)]), float) + (6.0 * place, 0.0)
        parts.append(strip(unit * stroke, STROKE * unit, z, paint))
    return parts


def number_size(value: int, height: float) -> Tuple[float, float]:
    """Returns width and height of a number. Its middle is `height` / 2 above the origin."""
    unit = height / 8.0
    return unit * (6.0 * len(str(value)) - 1.7 + STROKE), height + unit * STROKE
