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
