"""std_msgs/String that carries a line of the robot byte for byte, whatever its bytes are."""
from __future__ import annotations

import struct
from io import BytesIO

from std_msgs.msg import String


class LineMessage(String):
    """A String whose `data` is bytes. ROS strings are bytes; only rospy's own type wants UTF-8."""

    def serialize(self, buff: BytesIO) -> None:
        """Writes length and bytes."""
        buff.write(struct.pack('<I', len(self.data)))
        buff.write(self.data)
