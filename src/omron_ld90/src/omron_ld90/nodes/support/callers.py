"""The sender of a message."""
from __future__ import annotations

from typing import Dict

import rospy
from rospy.topics import get_topic_manager

from omron_arcl.execution import Giver


def caller_of(message: rospy.Message) -> str:
    """Returns the node that sent a message."""
    return header_of(message).get('callerid', 'unknown')


def header_of(message: rospy.Message) -> Dict[str, str]:
    """Returns the header of the connection on which a message came.

    All messages of one connection have the same header object.
    """
    header: Dict[str, str] = getattr(message, '_connection_header', {})
    return header


def process_of(message: rospy.Message) -> str:
    """Returns the address of the process that sent a message.

    A restarted node has another address.
    """
    header, topic = header_of(message), header_of(message).get('topic', '')
    subscription = get_topic_manager().get_subscriber_impl(topic) if topic else None
    for connection in getattr(subscription, 'connections', ()):
        if connection.header is header:
            return str(connection.endpoint_id)
    return ''


def giver_of(message: rospy.Message) -> Giver:
    """Returns the program that sent a command in a message."""
    return Giver(caller_of(message), process_of(message))
