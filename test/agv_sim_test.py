#!/usr/bin/env python3
"""Simulated AGVs drive the routes that arrive by topic, and report correctly."""
from __future__ import annotations

import json
import math
import os
import re
import socket
import subprocess
import sys
import unittest
from pathlib import Path
from typing import Dict, List

import rospy
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import BatteryState

from itrci_nav_msgs.msg import EdgeState, ExecutionRouteStates, RouteRefused, TargetRoute
from system_support import Recorder, connected_publisher, run_cases
from trajectory_graph import Graph, load_graph

COMPLETE = EdgeState.COMPLETE
EXAMPLE = Path(__file__).resolve().parents[1] / 'examples' / 'own_fleet_manager.py'


class AgvSimTest(unittest.TestCase):
    """The test plays the fleet manager of two AGVs."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.graph: Graph = load_graph(rospy.get_param('/agvs/graph_file'))
        cls.states = Recorder('/agv_1/execution_route_states', ExecutionRouteStates)
        cls.refusals = Recorder('/agv_1/route_refused', RouteRefused)
        cls.route = connected_publisher('/agv_1/target_route', TargetRoute)
        cls.states.wait_for(lambda one: re.fullmatch(r'agv_sim \d+\.\d+\.\d+', one.software),
                            10.0, 'a first report, with the software')

    def drive(self, route_id: int, edges: List[int]) -> ExecutionRouteStates:
        before = len(self.states.messages)
        self.route.publish(route_id=route_id, edges=edges)
        return self.states.wait_for(
            lambda one: one.route_id == route_id and len(one.edge_states) == len(edges)
            and all(edge.state == COMPLETE for edge in one.edge_states),
            30.0, f'complete route {route_id}', before)

    def test_a_route_is_driven_and_extended(self) -> None:
        first = self.graph.edges_from(18)[0]
        middle = self.graph.end_vertex(first).id
        second = next(edge for edge in self.graph.edges_from(middle) if edge != -first)
        self.drive(1, [first])
        end = self.drive(1, [first, second])
        self.assertEqual((second, 100.0), (end.symbolic_pose.edge_id, end.symbolic_pose.percentage))
        goal = self.graph.end_vertex(second)
        pose = Recorder('/agv_1/pose', PoseStamped).wait_for(lambda _: True, 20.0, 'pose').pose
        self.assertLess(math.dist(goal.position, (pose.position.x, pose.position.y)), 0.001)
        robots = self.where()
        told = robots['agv_1']['x'], robots['agv_1']['y']
        self.assertLess(math.dist(goal.position, told), 0.001)
        self.assertEqual({'agv_1', 'agv_2'}, set(robots))
        self.drive(2, [-second, -first])

    def test_what_it_cannot_drive_is_refused(self) -> None:
        self.route.publish(route_id=77, edges=[9999])
        refused = self.refusals.wait_for(lambda one: one.route_id == 77, 20.0, 'refusal')
        self.assertIn('9999', refused.reason)
        failed = self.states.wait_for(lambda one: one.route_id == 77, 20.0, 'failed report')
        self.assertEqual([EdgeState.FAILED], [edge.state for edge in failed.edge_states])

    def test_a_silent_agv_says_nothing_until_it_speaks_again(self) -> None:
        self.ask('@agv_2 silence')
        states = Recorder('/agv_2/execution_route_states', ExecutionRouteStates)
        states.wait_for(lambda _: True, 20.0, 'the latched report')
        heard = len(states.messages)
        self.assertEqual('ok', self.ask('@agv_2 battery 40'))
        self.assertEqual(heard, len(states.messages))
        self.ask('@agv_2 silence 0')
        states.wait_for(lambda _: True, 20.0, 'a report', heard)
        Recorder('/agv_2/battery_state', BatteryState).wait_for(
            lambda one: abs(one.percentage - 0.4) < 0.01, 20.0, 'battery at 40 %')

    def test_the_smallest_manager_with_numbers_drives_and_tells_the_place(self) -> None:
        first = self.graph.edges_from(8)[0]
        self.assertEqual([f'edge {first} is complete', 'the route is complete'],
                         self.manage(first))
        self.assertEqual(8, self.began_at)
        self.assertEqual([f'edge {-first} is complete', 'the route is complete'],
                         self.manage(-first))
        self.assertEqual(self.graph.end_vertex(first).id, self.began_at)
        self.assertIn('the robot refused the route', self.manage(-first)[-1])
        self.assertEqual([], self.manage())
        self.assertEqual(8, self.began_at)
        end = Recorder('/agv_2/execution_route_states', ExecutionRouteStates).wait_for(
            lambda one: one.motion == one.STANDING, 10.0, 'a standing robot')
        self.assertEqual('own_fleet_manager', end.master)

    def manage(self, *edges: int) -> List[str]:
        """Runs examples/own_fleet_manager.py. Returns its output without the first line, which has
        the robot's place.
        """
        done = subprocess.run([sys.executable, str(EXAMPLE), 'agv_2', '--', *map(str, edges)],
                              check=False, text=True, stdout=subprocess.PIPE, timeout=30.0)
        place, *lines = done.stdout.splitlines()
        edge, percentage = map(int, re.findall(r'-?\d+', place))
        self.assertIn(percentage, (0, 100))
        self.began_at = (self.graph.end_vertex(edge) if percentage
                         else self.graph.start_vertex(edge)).id
        return lines

    def where(self) -> Dict[str, Dict[str, float]]:
        return json.loads(self.ask('where'))['robots']

    def ask(self, line: str) -> str:
        port = int(os.environ.get('LD90_ARCL_PORT', 17171))
        with socket.create_connection(('127.0.0.1', port), timeout=5.0) as connection:
            connection.sendall(line.encode() + b'\n')
            return connection.makefile().readline().strip()


if __name__ == '__main__':
    rospy.init_node('agv_sim_test')
    run_cases(__file__)
