#!/usr/bin/env python3
"""Prints the time of arrival (s, monotonic) and the number of each message of a topic."""
from __future__ import annotations

import os
import sys
import time

import rospy
from roslib.message import get_message_class


def main() -> None:
    """Listens to TOPIC of TYPE, given on the command line, until the process is ended."""
    topic, kind = sys.argv[1:]
    figures = os.fdopen(os.dup(1), 'w')
    os.dup2(2, 1)  # rospy's own messages must not mix with the figures
    rospy.init_node('bench_listener', anonymous=True)
    rospy.Subscriber(topic, get_message_class(kind),
                     lambda message: print(time.monotonic(), message.header.seq, file=figures,
                                           flush=True),
                     queue_size=1000, tcp_nodelay=True)
    rospy.spin()


if __name__ == '__main__':
    main()
