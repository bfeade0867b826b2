"""Sentences for the person at the screen: on a topic, in the log, and as text in RViz.

The text stands where the person looks: at the goal that was clicked, or at the robot.
"""
from __future__ import annotations

from typing import Optional, Tuple

import rospy
from std_msgs.msg import ColorRGBA, String
from visualization_msgs.msg import Marker

from omron_ld90.nodes.arcl_news import Tone

TEXT_HEIGHT = 0.38  # m
ABOVE = 0.75  # m between the place and the middle of the text
SHOWN_FOR = 8.0  # s
COLOURS = {
    Tone.NEWS: ColorRGBA(1.0, 0.95, 0.6, 1.0),
    Tone.GOOD: ColorRGBA(0.4, 1.0, 0.45, 1.0),
    Tone.BAD: ColorRGBA(1.0, 0.45, 0.3, 1.0),
}


class UserFeedback:
    """Publishes sentences on `user_feedback` and shows the last one on `feedback_marker`."""

    def __init__(self, map_frame: str, base_frame: str) -> None:
        self._map_frame, self._base_frame = map_frame, base_frame
        self._text = rospy.Publisher('user_feedback', String, queue_size=10, tcp_nodelay=True)
        self._marker = rospy.Publisher('feedback_marker', Marker, queue_size=10, tcp_nodelay=True)

    def say(self, tone: Tone, text: str, place: Optional[Tuple[float, float]] = None) -> None:
        """Tell `text` at `place` (m, in the map), or at the robot."""
        (rospy.logwarn if tone is Tone.BAD else rospy.loginfo)('%s', text)
        self._text.publish(text)
        marker = Marker(type=Marker.TEXT_VIEW_FACING, ns='feedback', color=COLOURS[tone], text=text)
        marker.header.frame_id = self._map_frame if place else self._base_frame
        x, y = place or (0.0, 0.0)
        marker.pose.position.x, marker.pose.position.y = x, y + ABOVE
        marker.pose.position.z = 2.0
        marker.pose.orientation.w = 1.0
        marker.scale.z = TEXT_HEIGHT
        marker.lifetime = rospy.Duration(SHOWN_FOR)
        self._marker.publish(marker)
