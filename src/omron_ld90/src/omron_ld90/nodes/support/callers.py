"""Who sent a message."""
from __future__ import annotations

import rospy


def caller_of(message: rospy.Message) -> str:
    """The node that sent a message."""
    return getattr(message, '_connection_header', {}).get('callerid', 'unknown')
