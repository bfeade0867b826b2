"""Messages from a robot's lines: lines byte for byte, and numbers that may not fit."""
from __future__ import annotations

import struct
from io import BytesIO

import genpy
import rospy
from std_msgs.msg import String

from node_lifecycle import warn

_UNSERIALISABLE = (genpy.SerializationError, struct.error, ArithmeticError, TypeError, ValueError)


class LineMessage(String):
    """A String whose `data` are bytes. ROS strings are bytes; only rospy's own type needs UTF-8."""

    def serialize(self, buff: BytesIO) -> None:
        """Writes length and bytes."""
        buff.write(struct.pack('<I', len(self.data)))
        buff.write(self.data)


def publish_checked(publisher: rospy.Publisher, message: genpy.Message) -> bool:
    """Publishes a message that can be serialized; drops and logs any other. Returns whether it did.

    rospy would leave a part of a message that cannot be serialized in the topic's buffer. Then the
    next message reaches no subscriber, because every subscriber drops the connection.
    """
    try:
        message.serialize(BytesIO())
    except _UNSERIALISABLE as error:
        warn('unserialisable', f'A message on {publisher.resolved_name} could not be serialised '
             f'and was not published: {error}')
        return False
    publisher.publish(message)
    return True
