#!/usr/bin/env python3
"""Faults on a route: the fleet manager gets the reason, and only driven edges are COMPLETE."""
from __future__ import annotations

import unittest
from typing import Callable

import actionlib
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from route_robot import BRIDGE, RouteRobot, state_list
from std_msgs.msg import String

from itrci_nav_msgs.msg import Edge, EdgeState, ExecutionRouteStates, Graph, Vertex
from omron_ld90_msgs.msg import ExecuteCommandAction, ExecuteCommandGoal
from system_support import Recorder, connected_publisher, run_cases, wait_until

HALL = [1, 2, 3, 4, 5, 6]  # vertices 8 10 12 14 32 33 35, 24 m


class Faults(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('route_faults_test')
        cls.lab = RouteRobot(speed=4.0, status_period=0.2)
        cls.diagnostics = Recorder('/diagnostics', DiagnosticArray)
        cls.others = connected_publisher('/omron_ld90/send_command', String, to='omron_controller')

    @classmethod
    def tearDownClass(cls) -> None:
        cls.lab.robot.stop()

    def tearDown(self) -> None:
        """Ends the fault and brings the robot back to vertex 8."""
        self.lab.robot.inject('estop release')
        at_rest = (ExecutionRouteStates.STANDING, ExecutionRouteStates.MOVED)
        wait_until(lambda: self.lab.states.messages[-1].motion in at_rest, 30,
                   'no stop of the bridge is on its way, which would overtake a drive')
        heard = len(self.lab.responses.messages)
        self.others.publish('enableMotors')
        with self.lab.at_speed(16.0):
            self.others.publish('goto 8')
            self.lab.responses.wait_for(lambda line: line.data == 'Arrived at 8', 60,
                                        'the robot back at 8', after=heard)
        place = len(self.lab.status.messages)
        self.lab.status.wait_for(lambda status: not status.emergency_stop, 10,
                                 'a status without emergency stop', after=place)

    def fails(self, reason: str, bring_about: Callable[[], object], stopped: bool = True) -> None:
        """Makes a route fail after two edges. Checks the reason, and whether the robot is stopped.
        """
        route_id = self.lab.under_way(HALL, 2)
        commands, told = len(self.lab.commands.messages), len(self.diagnostics.messages)
        bring_about()
        end = self.lab.end_of(route_id)
        self.assertEqual(end.reason, reason)
        self.assertEqual(state_list(end), [EdgeState.COMPLETE] * 2 + [EdgeState.FAILED] * 4)
        self.diagnosed(reason, told)
        sent = [command.goal.command for command in self.lab.commands.messages[commands:]
                if command._connection_header['callerid'] == BRIDGE]
        self.assertEqual('stop' in sent, stopped)

    def diagnosed(self, reason: str, after: int = 0) -> None:
        self.diagnostics.wait_for(lambda array: any(
            status.level == DiagnosticStatus.ERROR and reason in status.message
            and 'edges_to_vertices' in status.name for status in array.status),
            10, f'diagnostic about {reason}', after)

    def test_1_emergency_stop(self) -> None:
        self.fails('emergency stop', lambda: self.lab.robot.inject('estop press'))

    def test_2_another_ros_node_takes_over(self) -> None:
        self.fails('taken over', lambda: self.others.publish('goto 10'), stopped=False)

    def test_3_a_lost_link(self) -> None:
        # with `direct`, the robot is sent far ahead
        self.lab.restart_bridge(strategy='direct', link_timeout=0.5)
        self.addCleanup(self.lab.restart_bridge, strategy='rolling', link_timeout=2.0)
        route_id = self.lab.under_way(HALL, 1)
        self.lab.robot.inject('refuse on')
        self.lab.robot.inject('drop')
        end = self.lab.end_of(route_id)
        self.assertTrue(end.reason.startswith('lost link'), end.reason)
        self.assertIn(EdgeState.FAILED, state_list(end))
        heard = len(self.lab.responses.messages)
        self.lab.robot.inject('refuse off')
        self.lab.wait_ready()
        self.lab.responses.wait_for(lambda line: line.data == 'Stopped', 10,
                                    'the stop that the broken link delayed', after=heard)

    def test_4_a_stop_of_the_fleet_manager(self) -> None:
        self.lab.under_way(HALL, 2)
        heard = len(self.lab.responses.messages)
        route_id = self.lab.order([])
        self.lab.states.wait_for(lambda states: states.route_id == route_id, 20, 'acknowledgement')
        self.lab.responses.wait_for(lambda line: line.data == 'Stopped', 10, 'a robot that stops',
                                    after=heard)

    def test_5_a_stop_in_rviz_is_the_last_word(self) -> None:
        """A robot that brakes gets no goal, even if its status only says `Stopping` and `Stopped`,
        without the name of the goal.
        """
        clicks = actionlib.ActionClient('/omron_ld90/execute_command', ExecuteCommandAction)
        self.assertTrue(clicks.wait_for_server(rospy.Duration(10.0)))
        self.lab.robot.inject('dialect interrupted nothing')
        self.addCleanup(self.lab.robot.inject, 'dialect interrupted name')
        route_id = self.lab.under_way(HALL, 1)
        given, heard = len(self.lab.drives_heard()), len(self.lab.responses.messages)
        clicks.send_goal(ExecuteCommandGoal(command='stop'))
        self.lab.responses.wait_for(lambda line: line.data == 'Stopped', 20, 'a robot that stands',
                                    after=heard)
        self.assertEqual(self.lab.end_of(route_id, 20.0).reason, 'taken over')
        late = self.lab.drives_heard()[given:]
        lines = [line.data for line in self.lab.responses.messages[heard:]]
        self.assertLess(len(late), 2, lines)  # one goal may already have been on its way
        self.assertNotIn('Going to', ' '.join(lines[lines.index('Stopping'):]))

    def test_6_a_robot_that_is_lost(self) -> None:
        self.fails('Robot lost', lambda: self.lab.robot.inject('lost'))
        told = len(self.lab.states.messages)
        # The robot is told to stop when its route has failed. It is localized when it stands.
        self.lab.states.wait_for(lambda states: states.motion == states.STANDING, 20,
                                 'a robot that stands', after=told)
        self.others.publish('localizeToPoint {:.0f} {:.0f} {:.0f}'.format(*self.lab.robot.pose))
        self.lab.responses.wait_for(lambda line: line.data == 'Localized to point', 10,
                                    'a robot that has been found')
        self.lab.states.wait_for(lambda states: states.symbolic_pose.edge_id == 3, 10,
                                 'report of the robot on edge 3', after=told)
        end = self.lab.end_of(self.lab.order([3]))
        self.assertEqual(state_list(end), [EdgeState.COMPLETE], end.reason)

    def test_7_a_refused_command_ends_the_route(self) -> None:
        """The fleet manager's graph has a vertex for which the robot has no goal."""
        graphs = rospy.Publisher('/graph', Graph, queue_size=1, latch=True)
        known = self.lab.graph
        vertices = [Vertex(id=v.id, frame_id=v.frame_id, x=v.x, y=v.y, theta=v.theta)
                    for v in known.vertices.values()]
        vertices.append(Vertex(id=99, frame_id=vertices[0].frame_id, x=-8.0, y=1.0))
        edges = [Edge(id=e.id, origin_id=e.origin, destination_id=e.destination,
                      curve_type=e.curve_type.value, param_f=e.param_f, param_b=e.param_b,
                      velocity_forward=e.velocity_forward, velocity_backwards=e.velocity_backwards)
                 for e in known.edges.values()]
        edges.append(Edge(id=99, origin_id=10, destination_id=99, curve_type='line',
                          velocity_forward=0.5))
        graphs.publish(Graph(vertices=vertices, edges=edges))
        wait_until(lambda: graphs.get_num_connections() >= 1, 10, 'the bridge subscribes to /graph')
        end = self.lab.end_of(self.lab.order([1, 99]))
        self.assertIn('99', end.reason)
        self.assertEqual(state_list(end)[-1], EdgeState.FAILED)


if __name__ == '__main__':
    run_cases(__file__)
