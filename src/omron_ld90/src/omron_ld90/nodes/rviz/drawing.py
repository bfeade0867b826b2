"""Short functions that make markers for RViz: shape, position, size, colour."""
from __future__ import annotations

import math
import unicodedata
from typing import Iterable, Tuple

import numpy as np
from geometry_msgs.msg import Point, Pose, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker

from node_lifecycle.headings import quaternion_from_yaw
from omron_ld90.nodes.rviz.fast_messages import FastMarkerArray, PointsMarker

XY = Tuple[float, float]

LAST_LETTER = 999  # code point of the last letter in RViz's font, which has Latin and Greek
LONGEST_TEXT = 400  # characters
_SUBSTITUTES = str.maketrans({
    '\u2018': "'", '\u2019': "'", '\u201c': '"', '\u201d': '"', '\u201e': '"',
    '\u2010': '-', '\u2011': '-', '\u2013': '-', '\u2014': '-', '\u2026': '...',
    '\u20ac': 'EUR', '\u2192': '->'})


def colour(red: float, green: float, blue: float, alpha: float = 1.0) -> ColorRGBA:
    """A colour with components in 0..1."""
    return ColorRGBA(red, green, blue, alpha)


def shape(kind: int, frame: str, namespace: str, paint: ColorRGBA,
          size: Tuple[float, float, float], number: int = 0) -> Marker:
    """A marker at the frame's origin; `size` in m has the meaning of `scale` for this `kind`."""
    marker = Marker(type=kind, ns=namespace, id=number, color=paint)
    marker.header.frame_id = frame
    marker.scale.x, marker.scale.y, marker.scale.z = size
    marker.pose.orientation.w = 1.0
    return marker


def text(frame: str, namespace: str, words: str, place: XY, height: float, paint: ColorRGBA,
         number: int = 0, z: float = 1.5) -> Marker:
    """`words` that face the viewer, centred at `place`; `height` of a capital letter in m.

    Letters that RViz lacks are replaced, see `drawable`.
    """
    marker = shape(Marker.TEXT_VIEW_FACING, frame, namespace, paint, (0.0, 0.0, height), number)
    marker.text = drawable(words)
    marker.pose.position.x, marker.pose.position.y, marker.pose.position.z = place[0], place[1], z
    return marker


def drawable(words: str) -> str:
    """`words` in letters that RViz has, of limited length.

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


def pose_at(place: XY, yaw: float = 0.0, z: float = 0.0) -> Pose:
    """A pose from a position on the floor, a direction and a height."""
    return Pose(position=Point(place[0], place[1], z), orientation=quaternion_from_yaw(yaw))


def many(kind: int, frame: str, namespace: str, paint: ColorRGBA,
         size: Tuple[float, float, float], places: np.ndarray, number: int = 0) -> PointsMarker:
    """A marker of many `places` (N, 3) in m; if there are none, it deletes an older marker."""
    return PointsMarker(
        places, header=Header(frame_id=frame), ns=namespace, id=number, type=kind, color=paint,
        scale=Vector3(*size), action=Marker.ADD if len(places) else Marker.DELETE,
        pose=pose_at((0.0, 0.0)))


def at_height(places: np.ndarray, z: float) -> np.ndarray:
    """Places (N, 2) on the floor as (N, 3), `z` above it."""
    lifted = np.full((len(places), 3), z)
    lifted[:, :2] = np.asarray(places, float).reshape(-1, 2)
    return lifted


def segments(places: np.ndarray, z: float) -> np.ndarray:
    """The pairs of ends (2 (N - 1), 3) that draw a polyline of N `places` as LINE_LIST."""
    return np.repeat(at_height(places, z), 2, axis=0)[1:-1]


def circle(centre: XY, radius: float, corners: int = 24) -> np.ndarray:
    """A closed polyline (corners + 1, 2) around `centre`."""
    angles = np.linspace(0.0, 2.0 * math.pi, corners + 1)
    return np.array(centre) + radius * np.column_stack((np.cos(angles), np.sin(angles)))


def arrowhead(tip: XY, yaw: float, length: float, z: float) -> np.ndarray:
    """The triangle (3, 3), for TRIANGLE_LIST, of an arrow along `yaw` that ends at `tip`.

    Counter-clockwise seen from above, because RViz does not light the other side.
    """
    along = length * np.array((math.cos(yaw), math.sin(yaw)))
    across = 0.5 * np.array((-along[1], along[0]))
    back = np.array(tip) - along
    return at_height(np.array((tip, back + across, back - across)), z)


def complete(markers: Iterable[Marker]) -> FastMarkerArray:
    """An array with all `markers` of a topic; it first deletes all older ones."""
    return FastMarkerArray(markers=[Marker(action=Marker.DELETEALL), *markers])
