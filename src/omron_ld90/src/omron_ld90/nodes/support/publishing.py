"""Messages made of what a robot says: lines byte for byte, and numbers that may not fit."""
from __future__ import annotations

import struct
from io import BytesIO

import genpy
import rospy
from std_msgs.msg import String

from node_lifecycle import warn

_UNSERIALISABLE = (genpy.SerializationError, struct.error, ArithmeticError, TypeError, ValueError)


class LineMessage(String):
    """A String whose `data` is bytes. ROS strings are bytes; only rospy's own type wants UTF-8."""

    def serialize(self, buff: BytesIO) -> None:
        """Writes length and bytes."""
        buff.write(struct.pack('<I', len(self.data)))
        buff.write(self.data)


def publish_checked(publisher: rospy.Publisher, message: genpy.Message) -> bool:
    """Publishes a message that can be serialised; drops any other, and logs that. Whether it was.

    rospy would leave half of a message that cannot be serialised in the topic's buffer. The next
    one then reaches no subscriber, for every subscriber drops the connection.
    """
    try:
        message.serialize(BytesIO())
    except _UNSERIALISABLE as error:
        warn('unserialisable', f'A message on {publisher.resolved_name} could not be serialised '
             f'and was not published: {error}')
        return False
    publisher.publish(message)
    return True
