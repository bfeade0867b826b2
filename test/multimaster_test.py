#!/usr/bin/env python3
"""A fleet manager under its own ROS master drives a robot that runs under another.

The robot's stack runs under a master on 127.0.0.2; this test is the fleet manager's side, under a
master on 127.0.0.3. multimaster_fkie joins the two; nothing leaves the loopback interface.
"""
from __future__ import annotations

import os
import signal
import subprocess
import unittest
from pathlib import Path
from typing import Dict

import rosgraph
import rospy

from itrci_nav_msgs.msg import EdgeState, ExecutionRouteStates, TargetRoute
from ports import free_port
from system_support import Recorder, connected_publisher, run_cases, wait_until

ROBOT, FLEET = '127.0.0.2', '127.0.0.3'
HERE = Path(__file__).resolve().parent
# From the dock (vertex 16) into the corridor, in maps/lab_graph.yaml.
ROUTE = [-13, -7, 1]


def environment(address: str, master_port: int) -> Dict[str, str]:
    """What a shell on that machine would have set."""
    return {'ROS_IP': address, 'ROS_MASTER_URI': f'http://{address}:{master_port}'}


class TwoMasters(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        cls.processes = []
        if subprocess.run(['rospack', 'find', 'fkie_master_sync'], stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL, check=False).returncode:
            return
        robot_port, fleet_port = free_port(ROBOT), free_port(FLEET)
        cls.robot = environment(ROBOT, robot_port)
        fleet = environment(FLEET, fleet_port)
        cls.launch(cls.robot, robot_port, HERE / 'multimaster_robot_side.launch',
                   peer=FLEET, rpc_port=free_port(ROBOT),
                   arcl_port=os.environ['LD90_ARCL_PORT'],
                   outgoing_port=os.environ['LD90_OUTGOING_PORT'])
        cls.launch(fleet, fleet_port, HERE.parent / 'launch' / 'multimaster.launch',
                   peer=ROBOT, rpc_port=free_port(FLEET))
        os.environ.update(fleet)
        master = rosgraph.Master('/fleet_side')
        wait_until(master.is_online, 30, 'the ROS master of the fleet side')
        rospy.init_node('fleet_side')

    @classmethod
    def launch(cls, variables: Dict[str, str], master_port: int, file: Path,
               **args: object) -> None:
        cls.processes.append(subprocess.Popen(
            ['roslaunch', '-p', str(master_port), str(file)]
            + [f'{name}:={value}' for name, value in args.items()],
            env={**os.environ, **variables}))

    @classmethod
    def tearDownClass(cls) -> None:
        for process in cls.processes:
            process.send_signal(signal.SIGINT)
        for process in cls.processes:
            try:
                process.wait(30)
            except subprocess.TimeoutExpired:
                process.kill()

    def setUp(self) -> None:
        if not self.processes:
            self.skipTest('fkie multimaster is not there: '
                       + os.environ.get('MULTIMASTER_MISSING', 'run scripts/multimaster.sh once'))

    def test_a_route_of_the_fleet_side_is_driven_and_reported_back(self) -> None:
        states = Recorder('/omron_ld90/execution_route_states', ExecutionRouteStates)
        routes = connected_publisher('/omron_ld90/target_route', TargetRoute, timeout=60)
        states.wait_for(lambda message: message.symbolic_pose.edge_id != 0, 60,
                        'report of the robot on the graph')

        done = self.drive(states, routes)
        self.assertEqual([edge.edge_id for edge in done.edge_states], ROUTE)
        self.assertEqual([edge.state for edge in done.edge_states],
                         [EdgeState.COMPLETE] * len(ROUTE), done.reason)
        self.assertEqual(done.symbolic_pose.edge_id, ROUTE[-1])
        self.assertAlmostEqual(done.symbolic_pose.percentage, 100.0, places=3)

    @staticmethod
    def drive(states: Recorder, routes: rospy.Publisher) -> ExecutionRouteStates:
        """The route's end; as a fleet manager does, it is sent anew while the link is down."""
        for route_id in range(1, 61):
            routes.publish(TargetRoute(route_id=route_id, edges=ROUTE))
            done = states.wait_for(
                lambda message, route_id=route_id: message.route_id == route_id and all(
                    edge.state in (EdgeState.COMPLETE, EdgeState.FAILED)
                    for edge in message.edge_states),
                90, f'end of route {route_id}')
            if 'lost link' not in done.reason:
                break
            states.wait_for(lambda _: True, 10, 'next report', after=len(states.messages))
        return done

    def test_only_the_route_topics_cross(self) -> None:
        master = rosgraph.Master('/fleet_side')
        wanted = {'/omron_ld90/execution_route_states', '/omron_ld90/route_refused'}
        wait_until(lambda: wanted <= {topic for topic, _ in master.getPublishedTopics('')}, 60,
                   'the route states and refusals on the fleet side')
        crossed = {topic for topic, _ in master.getTopicTypes()
                   if topic.startswith('/omron_ld90/')}
        self.assertEqual(crossed, {'/omron_ld90/target_route',
                                   '/omron_ld90/execution_route_states',
                                   '/omron_ld90/route_refused'})


if __name__ == '__main__':
    run_cases(__file__)
