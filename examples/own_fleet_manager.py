#!/usr/bin/env python3
"""Drives one robot over edges of its graph, as a fleet manager does, and prints completed edges.

    examples/own_fleet_manager.py omron_ld90              prints where the robot is
    examples/own_fleet_manager.py omron_ld90 37 1 2       drives over these edges

A negative edge is driven from its destination to its origin. Exit status 0: the route is complete;
1: the route failed, the robot refused it, or Ctrl-C ended the program. Ctrl-C stops the robot.
"""
from __future__ import annotations

import argparse
import queue
import sys
import time
from typing import List

import rospy

from itrci_nav_msgs.msg import EdgeState, ExecutionRouteStates, TargetRoute

MASTER = 'own_fleet_manager'
REPEAT = 1.0  # s; an order that no report shows after this time is sent again


class NotDone(Exception):
    """The robot does not drive the route. The text is the reason."""


class OneRobot:
    """Sends numbered orders to one robot, and reads what it reports about them."""

    def __init__(self, name: str) -> None:
        self._order = TargetRoute()
        self._reports: queue.Queue[ExecutionRouteStates] = queue.Queue()
        self._orders = rospy.Publisher(f'/{name}/target_route', TargetRoute, queue_size=10)
        rospy.Subscriber(f'/{name}/execution_route_states', ExecutionRouteStates,
                         self._reports.put)
        self.report = self._next_report()

    def halt(self) -> None:
        """Sends a stop: an order without edges."""
        self._give()

    def stop(self) -> None:
        """Stops the robot. After that, its reports show the order numbers of this program."""
        self.halt()
        while not self._shows_order() or self.report.motion != ExecutionRouteStates.STANDING:
            self._follow()

    def drive(self, edges: List[int]) -> None:
        """Drives the robot along these edges. The robot must stand before. Raises NotDone."""
        done = sum(edge.state == EdgeState.COMPLETE for edge in self.report.edge_states)
        self._give(edges=edges, known_epoch=self.report.epoch, first=self.report.first + done)
        told = 0
        while told < len(edges):
            self._follow()
            if self._shows_order():
                states = [edge.state for edge in self.report.edge_states]
                for edge in edges[told:states.count(EdgeState.COMPLETE)]:
                    print(f'edge {edge} is complete', flush=True)
                told = states.count(EdgeState.COMPLETE)
                if EdgeState.FAILED in states:
                    raise NotDone(self.report.reason)
            elif self.report.epoch != self._order.known_epoch:
                raise NotDone(self.report.reason or 'another program or person drove or stopped '
                              f'the robot (epoch_cause {self.report.epoch_cause})')
            elif self.report.refused >= self._order.order:
                raise NotDone(f'the robot refused the route: {self.report.refusal}')

    def _give(self, **values: object) -> None:
        """Sends an order. Its number is above all numbers before, also those of an earlier run."""
        number = max(self._order.order + 1, int(time.time() * 1000))
        self._order = TargetRoute(master=MASTER, order=number, **values)
        self._order.header.stamp = rospy.Time.now()
        self._orders.publish(self._order)
        self._sent = time.monotonic()

    def _shows_order(self) -> bool:
        """Returns whether the last report shows that the robot has taken the order."""
        return self.report.master == MASTER and self.report.order == self._order.order

    def _follow(self) -> None:
        """Reads the next report. Sends the order again if no report shows it."""
        self.report = self._next_report()
        if not self._shows_order() and time.monotonic() - self._sent > REPEAT:
            self._orders.publish(self._order)
            self._sent = time.monotonic()

    def _next_report(self) -> ExecutionRouteStates:
        while not rospy.is_shutdown():
            try:
                return self._reports.get(timeout=0.1)
            except queue.Empty:
                pass
        raise NotDone('the program was ended')


def main() -> int:
    """Returns 0 when the robot has driven all edges, otherwise 1."""
    parser = argparse.ArgumentParser(description='Drives a robot over edges of its graph.')
    parser.add_argument('robot', help='namespace of the robot')
    parser.add_argument('edges', type=int, nargs='*',
                        help='signed ids of the edges, in driving order; none: print the place')
    arguments = parser.parse_args()
    rospy.init_node(MASTER, anonymous=True)
    try:
        robot = OneRobot(arguments.robot)
        place = robot.report.symbolic_pose
        print(f'the robot is on edge {place.edge_id} at {place.percentage:.0f} %')
        if arguments.edges:
            robot.stop()
            rospy.on_shutdown(robot.halt)  # also if Ctrl-C ends the program
            robot.drive(arguments.edges)
            print('the route is complete')
    except NotDone as reason:
        print(f'the route failed: {reason}')
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
