#!/usr/bin/env python3
"""Nodes that are forks of a node host behave like other nodes."""
from __future__ import annotations

import os
import signal
import unittest
from pathlib import Path
from typing import Dict, Set

import rosgraph
import rospy

from omron_ld90_msgs.msg import LinkState, RobotStatus
from system_support import Recorder, drive_to, kill_node, process_of, run_cases, wait_until

ROBOT = 'omron_ld90'
NODES = ('omron_controller', 'omron_connection_receiver', 'omron_edges_to_vertices')
SOON = 30.0  # s


def processes() -> Dict[str, int]:
    """Returns the process ids of the nodes that answer."""
    found = {}
    for node in NODES:
        try:
            found[node] = process_of(f'/{ROBOT}/{node}')
        except (OSError, rosgraph.MasterException):
            continue
    return found


def parent_of(pid: int) -> int:
    return int(Path(f'/proc/{pid}/stat').read_text().rsplit(')', 1)[1].split()[1])


class HostedTest(unittest.TestCase):
    """All tests use one robot."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.links = Recorder(f'/{ROBOT}/link_state', LinkState)
        cls.statuses = Recorder(f'/{ROBOT}/robot_status', RobotStatus)
        wait_until(lambda: len(processes()) == len(NODES), SOON, 'all nodes')

    def setUp(self) -> None:
        wait_until(lambda: len(processes()) == len(NODES), SOON, 'all nodes')

    def test_each_node_is_a_process_of_its_own_and_the_host_is_the_parent_of_all(self) -> None:
        running = processes()
        self.assertEqual(len(set(running.values())), len(NODES))
        parents: Set[int] = {parent_of(pid) for pid in running.values()}
        self.assertEqual(len(parents), 1)
        self.assertIn('node_host', Path(f'/proc/{parents.pop()}/cmdline').read_text())

    def test_private_parameters_remappings_and_logs_are_the_nodes_own(self) -> None:
        _, subscribed, _ = rosgraph.Master('/test').getSystemState()
        self.assertIn(['/clicked_goal', [f'/{ROBOT}/omron_controller']], subscribed)
        self.assertEqual(rospy.get_param(f'/{ROBOT}/omron_edges_to_vertices/dock_vertex'), 16)
        for node, pid in processes().items():
            logs = {os.readlink(link) for link in Path(f'/proc/{pid}/fd').iterdir()
                    if link.is_symlink() and str(link.resolve()).endswith('.log')}
            self.assertTrue(any(node in log for log in logs), f'{node}: {logs}')

    def test_the_robot_drives(self) -> None:
        drive_to(ROBOT, '18')

    def test_a_node_that_is_killed_is_respawned_alone(self) -> None:
        before = processes()
        kill_node(f'/{ROBOT}/omron_controller')
        wait_until(lambda: processes().get('omron_controller', 0) not in
                   (0, before['omron_controller']), SOON, 'a new controller')
        after = processes()
        self.assertEqual({**before, 'omron_controller': 0}, {**after, 'omron_controller': 0})

    def test_all_nodes_come_back_when_the_host_is_killed(self) -> None:
        before = processes()
        os.kill(parent_of(before['omron_controller']), signal.SIGKILL)
        wait_until(lambda: set(processes().values()).isdisjoint(before.values())
                   and len(processes()) == len(NODES), SOON, 'new nodes')
        drive_to(ROBOT, '52')


if __name__ == '__main__':
    rospy.init_node('hosted_test')
    run_cases(__file__)
