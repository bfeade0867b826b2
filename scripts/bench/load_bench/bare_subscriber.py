#!/usr/bin/env python3
"""The floor of path_supervisor: receives all reports, and answers each report of one robot."""
from __future__ import annotations

import sys

import rospy

from itrci_nav_msgs.msg import ExecutionRouteStates, TargetRoute


def main() -> None:
    """Runs the node. The arguments are names of robots; the reports of the first robot are
    answered.
    """
    rospy.init_node('bare_subscriber')
    first, *others = rospy.myargv(sys.argv)[1:]
    answers = rospy.Publisher('/bare_answer', TargetRoute, queue_size=10, tcp_nodelay=True)
    kept = [rospy.Subscriber(f'/{first}/execution_route_states', ExecutionRouteStates,
                             lambda message: answers.publish(header=message.header),
                             queue_size=100, tcp_nodelay=True)]
    kept += [rospy.Subscriber(f'/{name}/execution_route_states', ExecutionRouteStates,
                              lambda message: None, queue_size=100, tcp_nodelay=True)
             for name in others]
    rospy.spin()


if __name__ == '__main__':
    main()
