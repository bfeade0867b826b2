#!/usr/bin/env python3
"""Wrong input: each is answered with one clear sentence, and whatever can still work goes on."""
from __future__ import annotations

import socket
import sys
import tempfile
import unittest
from pathlib import Path

import rospy
import rostest
from geometry_msgs.msg import PoseStamped
from rosgraph_msgs.msg import Log
from std_msgs.msg import String

from omron_ld90_msgs.msg import LinkState
from system_support import Recorder, connected_publisher, free_port, launched

SIMULATOR_PASSWORD = (Path(__file__).resolve().parents[1]
                      / 'src' / 'omron_ld90_sim' / 'config' / 'simulator_password')


class BadInput(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('bad_input')
        cls.log = Recorder('/rosout_agg', Log)
        cls.folder = tempfile.TemporaryDirectory()
        cls.files = Path(cls.folder.name)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.folder.cleanup()

    def stack(self, robot: str, **args: object):
        """The full stack in a namespace of its own, on free ports."""
        return launched('full_stack.launch', robot_name=robot, rviz='false',
                        **{'sim_speed': 10, 'arcl_port': free_port(),
                           'outgoing_port': free_port(), **args})

    def assert_says(self, node: str, *words: str) -> str:
        """`node` logs a sentence that holds all `words`; returns it."""
        message = self.log.wait_for(
            lambda m: m.name == node and m.level >= Log.WARN and all(w in m.msg for w in words),
            60, f'sentence of {node} with {words}')
        return message.msg

    def assert_still_drives(self, robot: str, goal: str = '20') -> None:
        answers = Recorder(f'/{robot}/arcl_response', String)
        connected_publisher(f'/{robot}/send_command', String).publish(f'goto {goal}')
        answers.wait_for(lambda m: m.data == f'Arrived at {goal}', 60, f'arrival at {goal}')

    def assert_pose_comes(self, robot: str) -> None:
        Recorder(f'/{robot}/pose', PoseStamped).wait_for(lambda m: True, 60, 'pose of the robot')

    def test_an_unreadable_graph_idles_the_bridge_and_the_rest_drives_on(self) -> None:
        graph = self.files / 'broken.yaml'
        graph.write_text('Vertices:\n- {Id: 1, X: here}\n')
        with self.stack('unreadable_graph', graph_file=graph):
            self.assert_says('/unreadable_graph/omron_edges_to_vertices', str(graph))
            self.assert_still_drives('unreadable_graph')

    def test_a_missing_map_is_named_and_the_robot_is_still_followed(self) -> None:
        nowhere = self.files / 'nowhere.map'
        # The simulator has another map: only what shows the map misses it.
        ports = {'arcl_port': free_port(), 'outgoing_port': free_port()}
        with launched('sim.launch', robot_name='missing_map', **ports), \
                self.stack('missing_map', sim='false', map_file=nowhere,
                           password_file=SIMULATOR_PASSWORD, **ports):
            self.assert_says('/missing_map/map_visualisation', str(nowhere))
            self.assert_pose_comes('missing_map')

    def test_a_wrong_password_is_told_apart_and_the_status_still_comes(self) -> None:
        password = self.files / 'password'
        password.write_text('guess\n')
        ports = {'arcl_port': free_port(), 'outgoing_port': free_port()}
        with launched('sim.launch', robot_name='wrong_password', **ports), \
                self.stack('wrong_password', sim='false', password_file=password, **ports):
            link = Recorder('/wrong_password/link_state', LinkState).wait_for(
                lambda m: m.state == LinkState.WRONG_PASSWORD, 60, 'wrong password')
            self.assertEqual(link.link, LinkState.COMMANDS)
            self.assertIn('password', link.reason)
            self.assert_pose_comes('wrong_password')
        self.assertFalse([m.msg for m in self.log.messages if 'guess' in m.msg],
                         'the password stands in the log')

    def test_an_unreachable_robot_is_named_with_its_address(self) -> None:
        port = free_port()  # where nobody listens
        with self.stack('unreachable', sim='false', arcl_port=port,
                        password_file=SIMULATOR_PASSWORD):
            self.assert_says('/unreachable/omron_controller', f'127.0.0.1:{port}')
            link = Recorder('/unreachable/link_state', LinkState).wait_for(
                lambda m: m.link == LinkState.COMMANDS and m.reason, 30, 'reason')
            self.assertNotEqual(link.state, LinkState.CONNECTED)

    def test_a_taken_outgoing_port_is_named_and_commands_still_work(self) -> None:
        with socket.socket() as holder:
            holder.bind(('127.0.0.1', 0))
            holder.listen()
            port = holder.getsockname()[1]
            with self.stack('taken_port', outgoing_port=port):
                self.assert_says('/taken_port/omron_connection_receiver', str(port))
                self.assert_still_drives('taken_port')

    def test_no_password_file_for_a_real_robot_says_how_to_give_one(self) -> None:
        with self.stack('no_password', sim='false'):
            sentence = self.assert_says('/no_password/omron_controller', 'password_file')
            self.assertIn('OMRON_LD90_PASSWORD', sentence)

    def test_without_a_graph_the_bridge_says_that_it_idles(self) -> None:
        with self.stack('no_graph', graph_file=''):
            self.log.wait_for(
                lambda m: m.name == '/no_graph/omron_edges_to_vertices' and 'graph' in m.msg,
                60, 'sentence of the idle bridge')
            self.assert_still_drives('no_graph')


if __name__ == '__main__':
    rostest.rosrun('omron_ld90', 'bad_input', BadInput, sys.argv)
