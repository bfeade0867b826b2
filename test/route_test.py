#!/usr/bin/env python3
"""The simulated robot drives a fleet manager's routes and reports them edge by edge."""
from __future__ import annotations

import unittest
from typing import Sequence

import rospy
from route_robot import RouteRobot, state_list

from itrci_nav_msgs.msg import EdgeState
from system_support import run_cases, wait_until

OUT = [-13, -7, 1, 2]  # vertices 16 (dock) - 1 - 8 - 10 - 12, in maps/lab_graph.yaml
HOME = [-2, -1, 7, 13]
FROM_8_HOME = HOME[2:]


class Routes(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('route_test')
        cls.fleet = RouteRobot(speed=10.0, status_period=0.5)
        cls.fleet.restart_bridge(strategy='vertex_by_vertex')

    @classmethod
    def tearDownClass(cls) -> None:
        cls.fleet.restart_bridge(strategy='rolling')
        cls.fleet.robot.stop()

    def test_1_a_route_home_out_of_the_dock_and_home_again(self) -> None:
        self.drives_home(FROM_8_HOME)
        given, begin = len(self.fleet.commands.texts), len(self.fleet.states.messages)
        route_id = self.fleet.order(OUT)
        done = self.fleet.end_of(route_id)
        self.assertEqual([edge.edge_id for edge in done.edge_states], OUT)
        self.assertEqual(state_list(done), [EdgeState.COMPLETE] * 4, done.reason)
        self.assertEqual((done.symbolic_pose.edge_id, done.symbolic_pose.percentage), (2, 100.0))
        self.assertEqual(self.fleet.commands.texts[given:],
                         ['goto 1', 'goto 8', 'goto 10', 'goto 12'])
        self.check_reports([message for message in self.fleet.states.messages[begin:]
                            if message.route_id == route_id], OUT)

        self.drives_home(HOME)

    def drives_home(self, edges: Sequence[int]) -> None:
        done = self.fleet.end_of(self.fleet.order(edges))
        self.assertEqual(state_list(done), [EdgeState.COMPLETE] * len(edges), done.reason)
        self.assertEqual((done.symbolic_pose.edge_id, done.symbolic_pose.percentage), (13, 100.0))
        self.assertEqual(self.fleet.commands.texts[-1], 'dock')
        wait_until(lambda: self.fleet.status.messages[-1].docking_state == 'Docked', 10,
                   'a status of the docked robot')

    def check_reports(self, reports, edges) -> None:
        """Checks that percentages grow within an edge, that edges become complete in order, and
        that each stamp is the stamp of a location.
        """
        stamps = {status.header.stamp for status in self.fleet.status.messages}
        done, percentage = 0, 0.0
        for report in reports:
            self.assertIn(report.header.stamp, stamps)
            complete = state_list(report).count(EdgeState.COMPLETE)
            self.assertGreaterEqual(complete, done)
            if complete > done:
                done, percentage = complete, 0.0
            if complete < len(edges):
                self.assertEqual(report.symbolic_pose.edge_id, edges[complete])
                self.assertLess(report.symbolic_pose.percentage, 100.0)
            self.assertGreaterEqual(report.symbolic_pose.percentage, percentage)
            percentage = report.symbolic_pose.percentage

    def test_2_a_route_that_starts_elsewhere_is_refused(self) -> None:
        refused = self.fleet.end_of(self.fleet.order([29]))
        self.assertEqual(state_list(refused), [EdgeState.FAILED])
        self.assertIn('docked at vertex 16', refused.reason)


if __name__ == '__main__':
    run_cases(__file__)
