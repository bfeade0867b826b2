"""Publishes what a robot sends: lines byte for byte, and numbers that may not fit a message."""
from __future__ import annotations

import struct
from io import BytesIO

import genpy
import rospy
from std_msgs.msg import String

from node_lifecycle import warn

_UNSERIALISABLE = (genpy.SerializationError, struct.error, ArithmeticError, TypeError, ValueError)


class LineMessage(String):
    """A String whose `data` are any bytes, as ROS allows. rospy's own type needs valid UTF-8."""

    def serialize(self, buff: BytesIO) -> None:
        """Writes length and bytes."""
        buff.write(struct.pack('<I', len(self.data)))
        buff.write(self.data)


def publish_checked(publisher: rospy.Publisher, message: genpy.Message) -> bool:
    """Publishes a message if it can be serialized; otherwise drops it and writes to the log.

    Returns whether the message was published. rospy itself would leave a part of a message that
    cannot be serialized in the buffer of the topic. Then every subscriber would drop the connection
    at the next message.
    """
    try:
        message.serialize(BytesIO())
    except _UNSERIALISABLE as error:
        warn('unserialisable', f'A message on {publisher.resolved_name} could not be serialised '
             f'and was not published: {error}')
        return False
    publisher.publish(message)
    return True
