"""Publishing of ROS messages."""
from __future__ import annotations

from typing import Any, Callable

import genpy
import rospy


def send(publish: Callable[[Any], None], message: genpy.Message) -> None:
    """Publishes a message. A message that cannot be serialised is logged and not sent."""
    try:
        publish(message)
    except (genpy.SerializationError, rospy.ROSSerializationException) as error:
        rospy.logerr('A defect: a %s is not sent, because it cannot be serialised (%s).',
                     type(message).__name__, error)


class Newcomers(rospy.SubscribeListener):
    """Calls `tell(publish)` for every new subscriber; `publish` sends to this subscriber only."""

    def __init__(self, tell: Callable[[Callable[[Any], None]], None]) -> None:
        super().__init__()
        self._tell = tell

    def peer_subscribe(self, topic_name: str, topic_publish: Callable[[Any], None],
                       peer_publish: Callable[[Any], None]) -> None:
        """Notes that a subscriber has connected."""
        self._tell(peer_publish)
