#!/usr/bin/env python3
"""Wrong input: each is answered with one clear sentence, and whatever can still work goes on."""
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
        """The full stack in a namespace of its own, on free ports."""
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

    def test_an_unreadable_graph_idles_the_bridge_and_the_rest_drives_on(self) -> None:
        graph = self.files / 'broken.yaml'
        graph.write_text('Vertices:\n- {Id: 1, X: here}\n')
        with self.stack('unreadable_graph', graph_file=graph) as stack:
            stack.wait_for_line('/omron_edges_to_vertices cannot work', f'{graph}, line 2')
            self.assert_error_shown('omron_edges_to_vertices: configuration', f'{graph}, line 2')
            drive_to('unreadable_graph', '20')

    def test_a_missing_map_is_named_and_the_robot_is_still_followed(self) -> None:
        nowhere = self.files / 'nowhere.map'
        # The simulator has another map: only what shows the map misses it.
        ports = {'arcl_port': free_port(), 'outgoing_port': free_port()}
        with Launched('sim.launch', robot_name='missing_map', **ports), \
                self.stack('missing_map', sim='false', map_file=nowhere,
                           password_file=SIMULATOR_PASSWORD, **ports) as stack:
            stack.wait_for_line('No map is shown', str(nowhere))
            self.assert_pose_comes('missing_map')

    def test_a_wrong_password_is_told_apart_and_the_status_still_comes(self) -> None:
        password = self.files / 'password'
        password.write_text('guess\n')
        ports = {'arcl_port': free_port(), 'outgoing_port': free_port()}
        with Launched('sim.launch', robot_name='wrong_password', **ports), \
                self.stack('wrong_password', sim='false', password_file=password, **ports) as stack:
            link = Recorder('/wrong_password/link_state', LinkState).wait_for(
                lambda m: m.state == LinkState.WRONG_PASSWORD, 60, 'wrong password')
            self.assertEqual(link.link, LinkState.COMMANDS)
            self.assertIn('password', link.reason)
            self.assert_pose_comes('wrong_password')
            self.assertNotIn('guess', stack.output)

    def test_an_unreachable_robot_is_named_with_its_address(self) -> None:
        port = free_port()  # where nobody listens
        with self.stack('unreachable', sim='false', arcl_port=port,
                        password_file=SIMULATOR_PASSWORD) as stack:
            stack.wait_for_line('"commands"', f'127.0.0.1:{port}', 'refused')
            link = Recorder('/unreachable/link_state', LinkState).wait_for(
                lambda m: m.link == LinkState.COMMANDS and m.reason, 30, 'reason')
            self.assertNotEqual(link.state, LinkState.CONNECTED)

    def test_a_taken_outgoing_port_is_named_and_taken_over_when_it_is_free(self) -> None:
        with socket.socket() as holder:
            holder.bind(('127.0.0.1', 0))
            holder.listen()
            port = holder.getsockname()[1]
            with self.stack('taken_port', outgoing_port=port) as stack:
                stack.wait_for_line('Link "outgoing"', f'another program has port {port}')
                drive_to('taken_port', '20')
                holder.close()
                self.assert_pose_comes('taken_port')

    def test_no_password_file_for_a_real_robot_says_how_to_give_one(self) -> None:
        with self.stack('no_password', sim='false') as stack:
            stack.wait_for_line('/omron_controller cannot work', 'password_file',
                                'OMRON_LD90_PASSWORD')

    def test_without_a_graph_the_bridge_says_that_it_idles(self) -> None:
        site_map = self.files / 'site.map'
        shutil.copy(str(LAB_MAP), str(site_map))
        with self.stack('no_graph', map_file=site_map) as stack:
            stack.wait_for_line('/omron_edges_to_vertices idles', 'graph_file')
            drive_to('no_graph', '20')


if __name__ == '__main__':
    run_cases(__file__)
