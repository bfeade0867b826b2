#!/usr/bin/env python3
"""Each wrong input causes one clear message; the parts that do not need this input work."""
from __future__ import annotations

import shutil
import socket
import tempfile
import unittest
from pathlib import Path

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped

from omron_ld90_msgs.msg import LinkState
from ports import free_port
from system_support import Launched, Recorder, drive_to, run_cases

ROOT = Path(__file__).resolve().parents[1]
SIMULATOR_PASSWORD = ROOT / 'src' / 'omron_ld90_sim' / 'config' / 'simulator_password'
LAB_MAP = ROOT / 'maps' / 'lab.map'


class BadInput(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('bad_input')
        cls.folder = tempfile.TemporaryDirectory()
        cls.files = Path(cls.folder.name)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.folder.cleanup()

    @staticmethod
    def stack(robot: str, **args: object) -> Launched:
        """Returns the full stack in a namespace of its own, on free ports."""
        return Launched('full_stack.launch', robot_name=robot, rviz='false',
                        **{'sim_speed': 10, 'arcl_port': free_port(),
                           'outgoing_port': free_port(), **args})

    def assert_pose_comes(self, robot: str) -> None:
        Recorder(f'/{robot}/pose', PoseStamped).wait_for(lambda m: True, 60, 'pose of the robot')

    def assert_error_shown(self, name: str, words: str) -> None:
        Recorder('/diagnostics', DiagnosticArray).wait_for(
            lambda array: any(status.name.endswith(name) and words in status.message
                              and status.level == DiagnosticStatus.ERROR
                              for status in array.status), 10, f'ERROR of {name} in /diagnostics')

    def test_an_unreadable_graph_and_a_taken_outgoing_port_stop_nothing_else(self) -> None:
        graph = self.files / 'broken.yaml'
        graph.write_text('Vertices:\n- {Id: 1, X: here}\n')
        with socket.socket() as holder:
            holder.bind(('127.0.0.1', 0))
            holder.listen()
            port = holder.getsockname()[1]
            with self.stack('half', graph_file=graph, outgoing_port=port) as stack:
                stack.wait_for_line('/omron_edges_to_vertices cannot work', f'{graph}, line 1')
                self.assert_error_shown('omron_edges_to_vertices: configuration',
                                        f'{graph}, line 1')
                stack.wait_for_line('Link "outgoing"', f'another program has port {port}')
                drive_to('half', '20')
                holder.close()
                self.assert_pose_comes('half')

    def test_a_missing_map_and_a_wrong_password_are_told_and_the_robot_is_still_followed(
            self) -> None:
        nowhere, password = self.files / 'nowhere.map', self.files / 'password'
        password.write_text('guess\n')
        # The simulator has another map, so only the nodes that show the map do not have it.
        ports = {'arcl_port': free_port(), 'outgoing_port': free_port()}
        with Launched('sim.launch', robot_name='followed', **ports), \
                self.stack('followed', sim='false', map_file=nowhere, password_file=password,
                           **ports) as stack:
            stack.wait_for_line('No map is shown', str(nowhere))
            link = Recorder('/followed/link_state', LinkState).wait_for(
                lambda m: m.state == LinkState.WRONG_PASSWORD, 60, 'wrong password')
            self.assertEqual(link.link, LinkState.COMMANDS)
            self.assertIn('password', link.reason)
            self.assert_pose_comes('followed')
            self.assertNotIn('guess', stack.output)

    def test_an_unreachable_robot_is_named_with_its_address(self) -> None:
        port = free_port()  # no program listens there
        with self.stack('unreachable', sim='false', arcl_port=port,
                        password_file=SIMULATOR_PASSWORD) as stack:
            stack.wait_for_line('"commands"', f'127.0.0.1:{port}', 'refused')
            link = Recorder('/unreachable/link_state', LinkState).wait_for(
                lambda m: m.link == LinkState.COMMANDS and m.reason, 30, 'reason')
            self.assertNotEqual(link.state, LinkState.CONNECTED)

    def test_without_password_file_and_graph_the_nodes_say_how_to_give_them(self) -> None:
        site_map = self.files / 'site.map'
        shutil.copy(str(LAB_MAP), str(site_map))
        with self.stack('nothing_given', sim='false', map_file=site_map) as stack:
            stack.wait_for_line('/omron_controller cannot work', 'password_file',
                                'OMRON_LD90_PASSWORD')
            stack.wait_for_line('/omron_edges_to_vertices idles', 'graph_file')


if __name__ == '__main__':
    run_cases(__file__)
