#!/usr/bin/env python3
"""A node is killed or suspended during a route: the route is driven to its end, nothing twice."""
from __future__ import annotations

import os
import signal
import time
import unittest
from typing import List

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from route_robot import RouteRobot, state_list

from itrci_nav_msgs.msg import EdgeState, TargetRoute
from system_support import Recorder, process_of, run_cases, wait_until

HALL = [1, 2, 3, 4, 5, 6]  # vertices 8 10 12 14 32 33 35, 24 m
LONG = bool(os.environ.get('LD90_LONG_TESTS'))
STANDSTILL = 10.0 if LONG else 3.0  # s
AFTER_EDGES = (1, 3, 4) if LONG else (2,)
NODES = ('omron_controller', 'omron_connection_receiver', 'omron_edges_to_vertices')


class Survival(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('route_survival_test')
        cls.lab = RouteRobot(speed=3.0, status_period=0.2)
        cls.diagnostics = Recorder('/diagnostics', DiagnosticArray)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.lab.robot.stop()

    def way(self) -> List[int]:
        """Returns the route through the hall, from the robot's end of the hall to the other end."""
        x = self.lab.status.messages[-1].pose.position.x
        return HALL if x < 0.0 else [-edge for edge in reversed(HALL)]

    def survives(self, what, done: int) -> None:
        """Drives a whole route, in either direction, with the mishap `what` after `done` edges."""
        self.lab.wait_ready()
        route = self.way()
        given, heard = len(self.lab.drives_heard()), len(self.lab.responses.messages)
        route_id = self.lab.under_way(route, done)
        what()
        end = self.lab.end_of(route_id, 120.0)
        commands = self.lab.drives_heard()[given:]
        lines = [line.data for line in self.lab.responses.messages[heard:]]
        self.assertEqual(state_list(end), [EdgeState.COMPLETE] * len(route),
                         f'{end.reason}; it heard {commands} and said: {lines}')
        self.assertEqual(sorted(set(commands)), sorted(commands), 'the robot got a command twice')
        self.assertNotIn('Stopping', lines)

    def kill(self, node: str) -> None:
        os.kill(process_of(f'/omron_ld90/{node}'), signal.SIGKILL)

    def halt(self, node: str, seconds: float) -> None:
        pid = process_of(f'/omron_ld90/{node}')
        os.kill(pid, signal.SIGSTOP)
        try:
            time.sleep(seconds)  # the length of the suspension, not a wait for a condition
        finally:
            os.kill(pid, signal.SIGCONT)

    def test_1_a_controller_that_dies(self) -> None:
        for done in AFTER_EDGES:
            self.survives(lambda: self.kill('omron_controller'), done)

    def test_2_a_receiver_that_dies(self) -> None:
        for done in AFTER_EDGES:
            self.survives(lambda: self.kill('omron_connection_receiver'), done)

    def test_3_a_bridge_that_dies(self) -> None:
        for done in AFTER_EDGES:
            self.survives(lambda: self.kill('omron_edges_to_vertices'), done)

    def test_4_nodes_that_stand_still(self) -> None:
        for node in NODES:
            self.survives(lambda node=node: self.halt(node, STANDSTILL), 2)

    def test_5_a_link_that_breaks(self) -> None:
        self.survives(lambda: self.lab.robot.inject('drop'), 2)

    def test_6_a_route_that_has_ended_is_not_driven_again_after_a_restart(self) -> None:
        with self.lab.at_speed(16.0):
            last = self.lab.end_of(self.lab.order(self.way()))
        given = len(self.lab.commands.messages)
        self.lab.restart_bridge()
        self.lab.routes.publish(TargetRoute(
            route_id=last.route_id, edges=[edge.edge_id for edge in last.edge_states]))
        heard = len(self.lab.states.messages)
        self.lab.states.wait_for(lambda states: states.route_id == last.route_id, 10.0,
                                 'the ended route in the reports', after=heard)
        self.assertEqual([], self.lab.commands.texts[given:])

    def test_7_a_stop_that_the_controller_cannot_hear_is_obeyed_when_it_is_back(self) -> None:
        self.lab.restart_bridge(strategy='direct')  # so the robot is sent far ahead
        self.lab.under_way(self.way(), 1)
        heard = len(self.lab.responses.messages)
        with self.lab.at_speed(0.5):  # so the robot does not arrive before the controller is back
            self.kill('omron_controller')
            self.lab.order([])
            self.lab.responses.wait_for(lambda line: line.data == 'Stopped', 30.0,
                                        'a robot that stops', after=heard)
        wait_until(lambda: self.lab.status.messages[-1].status == 'Stopped', 10.0,
                   'a robot at rest')

    def test_8_a_receiver_that_stands_still_is_told_by_the_bridge(self) -> None:
        self.lab.wait_ready()
        wait_until(lambda: self.route_diagnosis().level == DiagnosticStatus.OK, 10.0,
                   f'a bridge without errors, not: {self.route_diagnosis().message}')
        pid = process_of('/omron_ld90/omron_connection_receiver')
        os.kill(pid, signal.SIGSTOP)
        try:
            wait_until(lambda: 'outgoing: its node has reported nothing'
                       in self.route_diagnosis().message, 10.0, 'the suspension in /diagnostics')
            self.assertEqual(DiagnosticStatus.WARN, self.route_diagnosis().level)
            refused = self.lab.order(self.way())
            end = self.lab.end_of(refused, 20.0)
            self.assertIn('outgoing: its node has reported nothing', end.reason)
        finally:
            os.kill(pid, signal.SIGCONT)
        self.lab.wait_ready()

    def route_diagnosis(self) -> DiagnosticStatus:
        """Returns the newest diagnosis of the bridge."""
        return next((status for array in reversed(self.diagnostics.messages)
                     for status in array.status
                     if status.name == 'omron_ld90/omron_edges_to_vertices: route'),
                    DiagnosticStatus(level=DiagnosticStatus.STALE, message='nothing'))


if __name__ == '__main__':
    run_cases(__file__)
