#!/usr/bin/env python3
"""The ROS master ends and a new one starts. All nodes register again, with their parameters."""
from __future__ import annotations

import os
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any, Dict, Set, Tuple
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
from ros_master import RosMaster

from itrci_nav_msgs.msg import (
    ClosedEdges,
    FleetState,
    MissionCommand,
    PlanRequest,
    TargetRoute,
)
from system_support import Recorder, connected_publisher, program, run_cases, wait_until

HERE = Path(__file__).resolve().parent
NODES = ('/graph_server', '/path_planner', '/path_supervisor', '/agv_sim')
ALL_OVER = 10.0  # s after the start of a ROS master within which each node must register

Registrations = Set[Tuple[str, str, str]]  # node, kind, name


class WatchedMaster(RosMaster):
    """A ROS master, with the registrations of the nodes under test."""

    def registrations(self) -> Registrations:
        """Returns all registrations of the nodes under test."""
        state = rosgraph.Master('/test', self.uri).getSystemState()
        return {(node, kind, name) for kind, entries in zip(('pub', 'sub', 'srv'), state)
                for name, nodes in entries for node in nodes if node in NODES}

    def parameters(self) -> Dict[str, Any]:
        """Returns the parameters of the nodes under test."""
        _, _, tree = ServerProxy(self.uri).getParam('/test', '/')
        return {node: tree.get(node[1:]) for node in NODES}

    def process_of(self, node: str) -> int:
        _, _, pid = ServerProxy(rosgraph.Master('/test', self.uri).lookupNode(node)).getPid('/test')
        return int(pid)


def command(name: str, *words: str) -> subprocess.CompletedProcess:
    """Runs a command as a user would. Returns its result."""
    return subprocess.run([program('graph_fleet_manager', name), *words], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=30, check=False)


class MasterRestartTest(unittest.TestCase):
    """A fleet manager with two simulated AGVs."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.TemporaryDirectory()
        # the fleet manager of this test keeps its files in ROS_HOME
        os.environ['ROS_HOME'] = cls.folder.name
        cls.master = WatchedMaster()
        os.environ['ROS_MASTER_URI'] = cls.master.uri
        cls.launch = subprocess.Popen(
            ['roslaunch', str(HERE / 'master_restart_fleet.launch'), f'files:={cls.folder.name}'])
        rospy.init_node('master_restart_test', disable_signals=True)
        cls.fleet = Recorder('/fleet_state', FleetState)
        cls.fleet.wait_for(lambda state: state.robots, 60, 'a fleet')
        cls.talk = {kind: connected_publisher(topic, kind) for topic, kind in (
            ('/mission_command', MissionCommand), ('/plan_request', PlanRequest),
            ('/closed_edges', ClosedEdges), ('/agv_1/target_route', TargetRoute))}

    @classmethod
    def tearDownClass(cls) -> None:
        cls.launch.send_signal(signal.SIGINT)
        cls.launch.wait(30)
        cls.master.kill()
        cls.folder.cleanup()

    def have_all_log(self) -> None:
        """Makes each node log a line: at each log line, rospy asks the master for a parameter."""
        self.talk[MissionCommand].publish(command=99)
        self.talk[PlanRequest].publish(plan_id=1)
        self.talk[ClosedEdges].publish(edges=[4711])
        self.talk[TargetRoute].publish(route_id=77, edges=[4711])

    def restart_master(self) -> None:
        """Starts a new ROS master after the old one was killed. The nodes log meanwhile."""
        before, parameters = self.before
        self.master.start()
        deadline = time.monotonic() + ALL_OVER
        while time.monotonic() < deadline and not before <= self.master.registrations():
            self.have_all_log()
            time.sleep(0.1)
        self.assertEqual(before - self.master.registrations(), set(), 'registrations are missing')
        self.assertEqual(parameters, self.master.parameters())

    def test_1_after_a_restart_of_the_master_all_is_as_before(self) -> None:
        type(self).before = self.master.registrations(), self.master.parameters()
        self.assertEqual({node for node, _, _ in self.before[0]}, set(NODES))
        self.master.kill()
        self.restart_master()

    def test_2_the_fleet_is_stopped_without_a_master(self) -> None:
        self.master.kill()
        told = len(self.fleet.messages)
        stopped = command('fleet', 'stop')
        self.assertEqual(stopped.returncode, 0, stopped.stdout)
        self.assertIn('Every robot was told to stop', stopped.stdout)
        self.fleet.wait_for(lambda state: state.robots[0].waits_for == 'the fleet is stopped', 10,
                            'stopped fleet', told)
        self.restart_master()
        resumed = command('fleet', 'resume')
        self.assertEqual(resumed.returncode, 0, resumed.stdout)

    def test_3_and_with_a_master_that_hangs(self) -> None:
        with self.master.hangs():
            begun = time.monotonic()
            stopped = command('fleet', 'stop')
            self.assertEqual(stopped.returncode, 0, stopped.stdout)
            self.assertLess(time.monotonic() - begun, 20.0)
        self.assertEqual(command('fleet', 'resume').returncode, 0)

    def test_4_a_node_that_dies_then_finds_its_parameters(self) -> None:
        for node in NODES:
            process = self.master.process_of(node)
            os.kill(process, signal.SIGKILL)
            wait_until(lambda node=node, old=process: self.is_back(node, old), 30,
                       f'{node} is back')
        wait_until(lambda: 'idle' in command('fleet', 'list').stdout, 30, 'a fleet at work')
        wait_until(lambda: self.before[0] <= self.master.registrations(), 30,
                   'all registrations of the new processes')

    def is_back(self, node: str, old: int) -> bool:
        try:
            return self.master.process_of(node) != old
        except (OSError, rosgraph.MasterError):
            return False


if __name__ == '__main__':
    run_cases(__file__)
