#!/usr/bin/env python3
"""Every strategy drives a tour of the lab, and the robot stays in the corridors of its route."""
from __future__ import annotations

import unittest

import rospy
from route_robot import RouteRobot, state_list

from itrci_nav_msgs.msg import EdgeState
from system_support import run_cases

TOUR = [1, 2, 19, 20, 23, -24, -5, -4, -3, -2, -1]  # 8 10 12 24 26 40 33 32 14 12 10 8
SHORTEST = [1, 2, 3, 4, 5, 6]                       # 8 10 12 14 32 33 35
HALF_CORRIDOR = 0.45  # m


class Strategies(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('route_strategies_test')
        cls.lab = RouteRobot(speed=5.0, status_period=0.1)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.lab.robot.stop()

    def drive(self, route, **parameters) -> list:
        """Drives a route by a bridge restarted with these parameters; the commands it sent."""
        # The robot's clock runs 5 times as fast as ours: so do its speeds.
        self.lab.restart_bridge(top_speed=5 * 1.35, acceleration=10.0, braking=5.0, **parameters)
        commands, places = len(self.lab.commands.messages), len(self.lab.status.messages)
        done = self.lab.end_of(self.lab.order(route))
        self.assertEqual(state_list(done), [EdgeState.COMPLETE] * len(route), done.reason)
        self.assertEqual(done.symbolic_pose.edge_id, route[-1])
        self.assertEqual(done.symbolic_pose.percentage, 100.0)
        self.assertLessEqual(self.lab.distance_from(route, places), HALF_CORRIDOR)
        return self.lab.commands.texts[commands:]

    def test_1_vertex_by_vertex(self) -> None:
        self.assertEqual(len(self.drive(TOUR, strategy='vertex_by_vertex')), len(TOUR))

    def test_2_direct(self) -> None:
        self.assertLess(len(self.drive(TOUR, strategy='direct')), len(TOUR))

    def test_3_rolling(self) -> None:
        self.assertIn('goto 8', self.drive(TOUR, strategy='rolling'))

    def test_4_native(self) -> None:
        """The simulator has no command for several goals, so the template names the last one."""
        self.assertEqual(self.drive(SHORTEST, strategy='native', native_command='goto {last}'),
                         ['goto 35'])


if __name__ == '__main__':
    run_cases(__file__)
