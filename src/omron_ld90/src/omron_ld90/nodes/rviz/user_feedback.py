"""Sentences for the person at the screen: on a topic, in the log, and as text in RViz.

The text is at the goal that was clicked, or at the robot, because the person looks there. The text
is within the map, and a dark panel behind it makes it readable.
"""
from __future__ import annotations

import math
import textwrap
from typing import List, Optional, Tuple

import rospy
from std_msgs.msg import String
from visualization_msgs.msg import Marker, MarkerArray

from omron_ld90.operator.notices import NoticeSeverity, OperatorNotice
from rviz_drawing import drawing

TEXT_HEIGHT = 0.38  # m
LINE_PITCH, CHARACTER_PITCH = 1.2, 0.48  # in units of the text's height
COLUMNS = 36  # characters in a line
GAP = 0.5  # m between the place and the panel above it
Z = 2.0  # m, above all else
SHOWN_FOR = rospy.Duration(8.0)
PANEL = drawing.colour(0.08, 0.09, 0.11, 0.85)
COLOURS = {
    NoticeSeverity.INFO: drawing.colour(1.0, 0.95, 0.6),
    NoticeSeverity.GOOD: drawing.colour(0.4, 1.0, 0.45),
    NoticeSeverity.BAD: drawing.colour(1.0, 0.5, 0.35),
}


class UserFeedback:
    """Publishes sentences on `user_feedback` and shows the last one on `feedback_markers`."""

    def __init__(self, map_frame: str) -> None:
        self.robot = (0.0, 0.0)  # m, in the map
        self._frame = map_frame
        self._west, self._east = -math.inf, math.inf
        self._text = rospy.Publisher('user_feedback', String, queue_size=10, tcp_nodelay=True)
        self._markers = rospy.Publisher(
            'feedback_markers', MarkerArray, queue_size=10, tcp_nodelay=True)

    def stay_within(self, west: float, east: float) -> None:
        """Keeps the text between these x coordinates (m) if it fits."""
        self._west, self._east = west, east

    def say(self, severity: NoticeSeverity, text: str,
            place: Optional[Tuple[float, float]] = None) -> None:
        """Shows `text`, and logs it."""
        (rospy.logwarn if severity is NoticeSeverity.BAD else rospy.loginfo)('%s', text)
        self.show(OperatorNotice(severity, text), place)

    def show(self, notice: OperatorNotice, place: Optional[Tuple[float, float]] = None) -> None:
        """Shows the notice at `place` (m, in the map), or at the robot's last position."""
        self._text.publish(notice.text)
        markers = self._draw(notice, place)
        for marker in markers:
            marker.lifetime = SHOWN_FOR
        self._markers.publish(MarkerArray(markers=markers))

    def _draw(self, notice: OperatorNotice, place: Optional[Tuple[float, float]]) -> List[Marker]:
        lines = textwrap.wrap(notice.text, COLUMNS) or ['']
        width = (max(map(len, lines)) + 2) * CHARACTER_PITCH * TEXT_HEIGHT
        height = (len(lines) * LINE_PITCH + 0.5) * TEXT_HEIGHT
        x, y = place or self.robot
        x = max(self._west + width / 2, min(self._east - width / 2, x))
        middle = (x, y + GAP + height / 2)
        panel = drawing.shape(Marker.CUBE, 'feedback_panel', 0, PANEL, (width, height, 0.01),
                              drawing.pose_at(middle, z=Z - 0.2), self._frame)
        return [panel, drawing.text('feedback', 0, '\n'.join(lines), middle, TEXT_HEIGHT,
                                    COLOURS[notice.severity], Z, self._frame)]
