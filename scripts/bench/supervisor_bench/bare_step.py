#!/usr/bin/env python3
"""The floor of a step: sends one byte to a TCP port for each command that arrives."""
from __future__ import annotations

import socket
import sys

import rospy

from itrci_nav_msgs.msg import StepCommand


def main() -> None:
    """Runs the node. The argument is the port."""
    rospy.init_node('bare_step')
    connection = socket.create_connection(('127.0.0.1', int(rospy.myargv(sys.argv)[1])))
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    kept = rospy.Subscriber('/bare_step', StepCommand, lambda _: connection.sendall(b'x'),
                            queue_size=100, tcp_nodelay=True)
    rospy.spin()
    kept.unregister()


if __name__ == '__main__':
    main()
