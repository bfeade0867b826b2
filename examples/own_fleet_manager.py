#!/usr/bin/env python3
"""Drives one robot over edges of its graph, as a fleet manager does, and prints completed edges.

    examples/own_fleet_manager.py omron_ld90 37 1 2

A negative edge is driven from its destination to its origin. Exit status 0: the route is complete;
1: the route failed, the robot refused it, or Ctrl-C ended the program. Ctrl-C stops the robot.
"""
from __future__ import annotations

import argparse
import sys
import threading
import time
from typing import List, Optional, Set

import rospy

from itrci_nav_msgs.msg import EdgeState, ExecutionRouteStates, RouteRefused, TargetRoute

REPEAT = 1.0  # s; without an acknowledgement for this time, the route is sent again


class OneRobot:
    """Sends routes to one robot and follows its reports.

    done    -- set when the route is complete, has failed or was refused
    failure -- reason of the failure or refusal; empty: none
    """

    def __init__(self, name: str) -> None:
        self.done = threading.Event()
        self.failure = ''
        self._heard = threading.Event()
        self._report: Optional[ExecutionRouteStates] = None
        self._route: Optional[TargetRoute] = None
        self._told: Set[int] = set()
        self._routes = rospy.Publisher(f'/{name}/target_route', TargetRoute, queue_size=10)
        rospy.Subscriber(f'/{name}/execution_route_states', ExecutionRouteStates, self._on_report)
        rospy.Subscriber(f'/{name}/route_refused', RouteRefused, self._on_refusal)

    def drive(self, edges: List[int]) -> None:
        """Sends a new route until the robot acknowledges it; `done` is set when the route ends.

        edges -- signed ids in driving order; a negative edge is driven from its destination to its
                 origin
        """
        while not self._heard.wait(0.1):
            if rospy.is_shutdown():
                return
        # A new route needs an id that no earlier route of this robot had.
        route = TargetRoute(route_id=int(time.time()) % 2**31, edges=edges,
                            known_epoch=self._report.epoch)
        route.header.stamp = rospy.Time.now()
        self._route = route
        while not (self.done.is_set() or self._is_acknowledged() or rospy.is_shutdown()):
            self._routes.publish(route)
            self.done.wait(REPEAT)

    def stop(self) -> None:
        """Stops the robot: it always obeys a route without edges."""
        self._routes.publish(TargetRoute(route_id=0))

    def _is_acknowledged(self) -> bool:
        return self._report.route_id == self._route.route_id

    def _on_report(self, report: ExecutionRouteStates) -> None:
        self._report = report
        self._heard.set()
        if self._route is None or report.route_id != self._route.route_id:
            return
        for place, edge in enumerate(report.edge_states):
            if edge.state == EdgeState.COMPLETE and place not in self._told:
                self._told.add(place)
                print(f'edge {edge.edge_id} is complete', flush=True)
        states = {edge.state for edge in report.edge_states}
        if EdgeState.FAILED in states:
            self.failure = report.reason
        if EdgeState.PROCESSING not in states:
            self.done.set()

    def _on_refusal(self, refusal: RouteRefused) -> None:
        if self._route is not None and refusal.route_id == self._route.route_id:
            self.failure = refusal.reason
            self.done.set()


def main() -> int:
    """Returns 0 when the robot has driven all edges, otherwise 1."""
    parser = argparse.ArgumentParser(description='Drives a robot over edges of its graph.')
    parser.add_argument('robot', help='namespace of the robot')
    parser.add_argument('edges', type=int, nargs='+',
                        help='signed ids of the edges, in driving order')
    arguments = parser.parse_args()
    rospy.init_node('own_fleet_manager', anonymous=True)
    robot = OneRobot(arguments.robot)
    rospy.on_shutdown(robot.stop)
    robot.drive(arguments.edges)
    while not robot.done.wait(0.1):
        if rospy.is_shutdown():
            return 1
    print(f'the route failed: {robot.failure}' if robot.failure else 'the route is complete')
    return 1 if robot.failure else 0


if __name__ == '__main__':
    sys.exit(main())
