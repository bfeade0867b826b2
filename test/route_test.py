#!/usr/bin/env python3
"""A fleet manager's routes are driven by the simulated robot and reported edge by edge."""
from __future__ import annotations

import sys
import unittest

import rospy
import rostest
from std_msgs.msg import String

from itrci_nav_msgs.msg import EdgeState, ExecutionRouteStates, TargetRoute
from omron_ld90_msgs.msg import LinkState, RobotStatus
from system_support import Recorder, connected_publisher, wait_until

OUT = [-13, -7, 1, 2]  # dock - 1 - 8 - 10 - 12, in maps/lab_graph.yaml
HOME = [-2, -1, 7, 13]


class Routes(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('route_test')
        cls.states = Recorder('/omron_ld90/execution_route_states', ExecutionRouteStates)
        cls.status = Recorder('/omron_ld90/robot_status', RobotStatus)
        cls.commands = Recorder('/omron_ld90/send_command', String)
        cls.links = Recorder('/omron_ld90/link_state', LinkState)
        cls.routes = connected_publisher('/omron_ld90/target_route', TargetRoute)
        wait_until(lambda: {link.link for link in cls.links.messages
                            if link.state == LinkState.CONNECTED} == {'commands', 'outgoing'},
                   30, 'both links to the robot')
        cls.states.wait_for(lambda states: states.symbolic_pose.edge_id != 0, 30,
                            'report of the robot on the graph')

    def drive(self, route_id: int, edges) -> ExecutionRouteStates:
        """Orders a route and returns the report in which no edge is under way any more."""
        self.routes.publish(TargetRoute(route_id=route_id, edges=edges))
        return self.states.wait_for(
            lambda states: states.route_id == route_id and states.edge_states and all(
                edge.state != EdgeState.PROCESSING for edge in states.edge_states),
            90, f'end of route {route_id}')

    def test_1_a_route_from_the_dock_and_home_again(self) -> None:
        begin = len(self.states.messages)
        done = self.drive(1, OUT)
        self.assertEqual([edge.edge_id for edge in done.edge_states], OUT)
        self.assertEqual([edge.state for edge in done.edge_states], [EdgeState.COMPLETE] * 4,
                         done.reason)
        self.assertEqual((done.symbolic_pose.edge_id, done.symbolic_pose.percentage), (2, 100.0))
        self.assertEqual([command.data for command in self.commands.messages],
                         ['goto 1', 'goto 8', 'goto 10', 'goto 12'])
        self.check_reports([message for message in self.states.messages[begin:]
                            if message.route_id == 1], OUT)

        done = self.drive(2, HOME)
        self.assertEqual([edge.state for edge in done.edge_states], [EdgeState.COMPLETE] * 4,
                         done.reason)
        self.assertEqual((done.symbolic_pose.edge_id, done.symbolic_pose.percentage), (13, 100.0))
        self.assertEqual(self.commands.messages[-1].data, 'dock')
        wait_until(lambda: self.status.messages[-1].docking_state == 'Docked', 10,
                   'a status of the docked robot')

    def check_reports(self, reports, edges) -> None:
        """Percentages grow within an edge, edges complete in order, stamps are the locations'."""
        stamps = {status.header.stamp for status in self.status.messages}
        done, percentage = 0, 0.0
        for report in reports:
            self.assertIn(report.header.stamp, stamps)
            complete = sum(edge.state == EdgeState.COMPLETE for edge in report.edge_states)
            self.assertGreaterEqual(complete, done)
            if complete > done:
                done, percentage = complete, 0.0
            if complete < len(edges):
                self.assertEqual(report.symbolic_pose.edge_id, edges[complete])
                self.assertLess(report.symbolic_pose.percentage, 100.0)
            self.assertGreaterEqual(report.symbolic_pose.percentage, percentage)
            percentage = report.symbolic_pose.percentage

    def test_2_a_route_that_starts_elsewhere_is_refused(self) -> None:
        refused = self.drive(3, [29])
        self.assertEqual([edge.state for edge in refused.edge_states], [EdgeState.FAILED])
        self.assertIn('docked at vertex 16', refused.reason)


if __name__ == '__main__':
    rostest.rosrun('omron_ld90', 'route', Routes, sys.argv)
