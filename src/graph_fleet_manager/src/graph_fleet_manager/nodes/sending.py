"""Messages out, of any content."""
from __future__ import annotations

from typing import Any, Callable

import genpy
import rospy


def send(publish: Callable[[Any], None], message: genpy.Message) -> None:
    """Publishes a message; one that cannot be serialised is told in the log, and left out."""
    try:
        publish(message)
    except (genpy.SerializationError, rospy.ROSSerializationException) as error:
        rospy.logerr('A defect: a %s is not sent, as it cannot be serialised (%s).',
                     type(message).__name__, error)
