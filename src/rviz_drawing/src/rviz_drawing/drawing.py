"""Short functions that make markers for RViz. Lengths are in m."""
from __future__ import annotations

import colorsys
import math
import unicodedata
from typing import Iterable, List, Optional, Tuple, cast

import numpy as np
from geometry_msgs.msg import Point, Pose, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker

from node_lifecycle.headings import quaternion_from_yaw
from rviz_drawing.fast_messages import FastMarkerArray, PointsMarker
from trajectory_graph import Curve

XY = Tuple[float, float]

FRAME = 'map'
STEP = 0.15  # m between the points of a drawn curve
LAST_LETTER = 999  # code point of the last letter in RViz's font, which has Latin and Greek
LONGEST_TEXT = 400  # characters
_GOLDEN = 0.618034  # step on the circle of hues: each new hue is far from all earlier ones
_SUBSTITUTES = str.maketrans({
    '\u2018': "'", '\u2019': "'", '\u201c': '"', '\u201d': '"', '\u201e': '"',
    '\u2010': '-', '\u2011': '-', '\u2013': '-', '\u2014': '-', '\u2026': '...',
    '\u20ac': 'EUR', '\u2192': '->'})


def colour(red: float, green: float, blue: float, alpha: float = 1.0) -> ColorRGBA:
    """Returns a colour from its components, each in 0..1."""
    return ColorRGBA(red, green, blue, alpha)


def own_colour(number: int, saturation: float = 0.65) -> ColorRGBA:
    """Returns the colour of the robot with this number.

    The colours of robots with successive numbers differ clearly.
    """
    return colour(*colorsys.hsv_to_rgb((0.55 + number * _GOLDEN) % 1.0, saturation, 1.0))


def pose_at(place: XY, yaw: float = 0.0, z: float = 0.0) -> Pose:
    """Returns a pose from a point on the floor (m), a heading (rad) and a height (m)."""
    return Pose(Point(place[0], place[1], z), quaternion_from_yaw(yaw))


def shape(kind: int, namespace: str, number: int, paint: ColorRGBA,
          size: Tuple[float, float, float], pose: Optional[Pose] = None,
          frame: str = FRAME) -> Marker:
    """Returns a marker; without `pose` it is at the frame's origin.

    `size` is the marker's `scale`; its meaning depends on `kind`.
    """
    marker = Marker(type=kind, ns=namespace, id=number, color=paint, scale=Vector3(*size),
                    pose=pose or pose_at((0.0, 0.0)))
    marker.header.frame_id = frame
    return marker


def text(namespace: str, number: int, words: str, place: XY, height: float, paint: ColorRGBA,
         z: float = 1.0, frame: str = FRAME) -> Marker:
    """Returns a text that faces the viewer, centred at `place`; `height`: height of a capital.

    Letters that RViz lacks are replaced; see `drawable`.
    """
    marker = shape(Marker.TEXT_VIEW_FACING, namespace, number, paint, (0.0, 0.0, height),
                   pose_at(place, z=z), frame)
    marker.text = drawable(words)
    return marker


def drawable(words: str) -> str:
    """Returns `words` in letters that RViz has, of limited length.

    RViz draws no text at all if its font lacks a letter. So unknown accents are removed,
    typographic signs become plain ones, and all other unknown letters become `?`.
    """
    drawn = ''.join(map(_drawable_letter, words[:LONGEST_TEXT + 1].translate(_SUBSTITUTES)))
    return drawn if len(drawn) <= LONGEST_TEXT else drawn[:LONGEST_TEXT] + ' ...'


def _drawable_letter(letter: str) -> str:
    if letter == '\n' or (letter.isprintable() and ord(letter) <= LAST_LETTER):
        return letter
    if letter.isspace():
        return ' '
    base = unicodedata.normalize('NFKD', letter)[0]
    return base if base.isprintable() and ord(base) <= LAST_LETTER else '?'


def lines(namespace: str, number: int, paint: ColorRGBA, width: float,
          polylines: Iterable[np.ndarray], z: float, frame: str = FRAME) -> Marker:
    """Returns one marker with all polylines, each (N, 2).

    If there are no polylines, the marker deletes an older marker.
    """
    marker = shape(Marker.LINE_LIST, namespace, number, paint, (width, 0.0, 0.0),
                   frame=frame)
    for polyline in polylines:
        ends = np.repeat(polyline, 2, axis=0)[1:-1]
        marker.points += [Point(x, y, z) for x, y in cast(List[List[float]], ends.tolist())]
    marker.action = Marker.ADD if marker.points else Marker.DELETE
    return marker


def many(kind: int, namespace: str, number: int, paint: ColorRGBA,
         size: Tuple[float, float, float], places: np.ndarray, frame: str = FRAME) -> PointsMarker:
    """Returns a marker of many `places` (N, 3); if there are none, it deletes an older marker.

    Only a FastMarkerArray can send it.
    """
    return PointsMarker(
        places, header=Header(frame_id=frame), ns=namespace, id=number, type=kind, color=paint,
        scale=Vector3(*size), action=Marker.ADD if len(places) else Marker.DELETE,
        pose=pose_at((0.0, 0.0)))


def complete(markers: Iterable[Marker]) -> FastMarkerArray:
    """Returns an array with all `markers` of a topic. Its first marker deletes all older ones."""
    return FastMarkerArray(markers=[Marker(action=Marker.DELETEALL), *markers])


def at_height(places: np.ndarray, z: float) -> np.ndarray:
    """Returns places (N, 2) on the floor as places (N, 3) at the height `z`."""
    lifted = np.full((len(places), 3), z)
    lifted[:, :2] = np.asarray(places, float).reshape(-1, 2)
    return lifted


def segments(places: np.ndarray, z: float) -> np.ndarray:
    """Returns the pairs of ends (2 (N - 1), 3) that draw a polyline of N `places` as LINE_LIST."""
    return np.repeat(at_height(places, z), 2, axis=0)[1:-1]


def beside(curve: Curve, offset: float) -> np.ndarray:
    """Returns the curve as points (N, 2), shifted to its right by `offset` (m)."""
    places = curve.sample(STEP)
    steps = np.gradient(places, axis=0)
    lengths = np.maximum(np.hypot(steps[:, 0], steps[:, 1]), 1e-9)
    right = np.column_stack((steps[:, 1], -steps[:, 0])) / lengths[:, None]
    return places + offset * right


def ring(centre: XY, radius: float, corners: int = 24) -> np.ndarray:
    """Returns a closed polyline (corners + 1, 2) around `centre`."""
    angles = np.linspace(0.0, 2.0 * math.pi, corners + 1)
    return np.array(centre) + radius * np.column_stack((np.cos(angles), np.sin(angles)))


def square(centre: XY, half: float) -> np.ndarray:
    """Returns a closed polyline (5, 2), a square around `centre`; `half`: half of its side."""
    return np.array(centre) + half * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1)], float)


def arrowhead(tip: XY, yaw: float, length: float, z: float) -> np.ndarray:
    """Returns an arrow along `yaw` with its tip at `tip`: a triangle (3, 3) for TRIANGLE_LIST.

    Its corners are counter-clockwise from above, because RViz does not light the other side.
    """
    along = length * np.array((math.cos(yaw), math.sin(yaw)))
    across = 0.5 * np.array((-along[1], along[0]))
    back = np.array(tip) - along
    return at_height(np.array((tip, back + across, back - across)), z)
