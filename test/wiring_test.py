#!/usr/bin/env python3
"""Each launch file is started: every wire between our nodes has two ends of one type."""
from __future__ import annotations

import os
import time
import unittest
from pathlib import Path
from typing import Dict, List, NamedTuple, Set
from xmlrpc.client import ServerProxy

import rosgraph
import rospy

from ports import free_port
from system_support import Launched, run_cases, wait_until

ROOT = Path(__file__).resolve().parents[1]
LAB = {'map_file': ROOT / 'maps/lab.map', 'graph_file': ROOT / 'maps/lab_graph.yaml'}
SETTLED = 3.0  # s without another registration
#: What only people and other software give: of our nodes those named publish it, too.
FROM_OUTSIDE: Dict[str, Set[str]] = {
    'clicked_point': {'rviz'}, 'move_base_simple/goal': {'rviz'},
    'initialpose': {'rviz', 'vda5050_vehicle'}, 'send_command': set(),
    'closed_edges': set(), 'edge_command': {'fleet_visualisation'},
    'interactive_goals/feedback': {'rviz'}, 'graph_editor/feedback': {'rviz'},
    'fleet_handles/feedback': {'rviz'}, 'move_base/cancel': set(),
    'mission_request': {'goal_sender'}, 'mission_command': {'goal_sender', 'fleet_visualisation'}}
#: What a fleet manager gives, which need not run.
OF_THE_FLEET = ('graph', 'fleet_state', 'mission_status', 'target_route')
NOT_OURS = ('/rosout', 'body_state_publisher')
EVERYBODYS = {'/rosout', '/rosout_agg', '/tf', '/tf_static', '/diagnostics', '/clock'}


class Wire(NamedTuple):
    """A topic, with the type of each node that publishes it or listens to it."""

    name: str
    offered: Dict[str, str]
    heard: Dict[str, str]


def wires() -> List[Wire]:
    """All topics of the nodes that run, but for those of this test."""
    master = rosgraph.Master(rospy.get_name())
    publishers, subscribers, _ = master.getSystemState()
    ends: Dict[str, Wire] = {}
    for node in {node for side in (publishers, subscribers) for _, nodes in side for node in nodes}:
        if node == rospy.get_name() or node.endswith(NOT_OURS):
            continue
        api = ServerProxy(master.lookupNode(node))
        for offered, topics in ((True, api.getPublications(rospy.get_name())[2]),
                                (False, api.getSubscriptions(rospy.get_name())[2])):
            for name, kind in topics:
                wire = ends.setdefault(name, Wire(name, {}, {}))
                (wire.offered if offered else wire.heard)[node] = kind
    return [wire for wire in ends.values() if wire.name not in EVERYBODYS]


def settled(*nodes: str) -> List[Wire]:
    """The topics once these nodes run and nothing more is registered."""
    master = rosgraph.Master(rospy.get_name())
    last: list = []
    since = time.monotonic()

    def is_settled() -> bool:
        nonlocal last, since
        state = master.getSystemState()[:2]
        if state != last:
            last, since = state, time.monotonic()
        running = {node for side in state for _, names in side for node in names}
        return set(nodes) <= running and time.monotonic() - since > SETTLED
    wait_until(is_settled, 90.0, f'{nodes}, and nothing more')
    return wires()


def ports(*names: str) -> Dict[str, int]:
    return {name: free_port() for name in names}


class Wiring(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('wiring_test')
        os.environ.pop('DISPLAY', None)

    def check(self, found: List[Wire], has_fleet_manager: bool = False) -> None:
        may_be_alone = (*FROM_OUTSIDE, *(() if has_fleet_manager else OF_THE_FLEET))
        for wire in found:
            kinds = {*wire.offered.values(), *wire.heard.values()} - {'*'}
            self.assertLessEqual(len(kinds), 1, f'{wire}: one name, several types')
            for suffix, ours in FROM_OUTSIDE.items():
                if wire.name.endswith(f'/{suffix}'):
                    givers = {node.rsplit('/', 1)[1] for node in wire.offered}
                    self.assertLessEqual(givers, ours, f'{wire}: nobody else gives this')
            if wire.heard and not wire.name.endswith(tuple(f'/{name}' for name in may_be_alone)):
                self.assertTrue(wire.offered, f'{wire}: nobody offers what is listened to')

    def named(self, found: List[Wire], name: str) -> Wire:
        return next(wire for wire in found if wire.name == name)

    def test_the_full_stack_with_a_fleet_manager(self) -> None:
        with Launched('full_stack.launch', fleet_manager='true', rviz='false',
                      **ports('arcl_port', 'outgoing_port')):
            found = settled('/omron_ld90/omron_controller', '/omron_ld90/goal_sender',
                            '/omron_ld90/omron_edges_to_vertices', '/path_supervisor',
                            '/path_planner', '/graph_server')
            self.check(found, has_fleet_manager=True)
            route = self.named(found, '/omron_ld90/target_route')
            self.assertEqual(set(route.offered), {'/path_supervisor'})
            self.assertIn('/omron_ld90/omron_edges_to_vertices', route.heard)

    def test_the_full_stack_with_a_vda_5050_adapter_and_the_editor_beside_it(self) -> None:
        with Launched('full_stack.launch', vda5050='true', rviz='false',
                      **ports('arcl_port', 'outgoing_port')), \
                Launched('edit.launch', package='graph_editor', rviz='false', window='false',
                         **LAB):
            found = settled('/omron_ld90/omron_controller', '/omron_ld90/vda5050_vehicle',
                            '/omron_ld90/omron_edges_to_vertices', '/graph_editor')
            self.check(found)
            pose = self.named(found, '/initialpose')
            self.assertIn('/omron_ld90/vda5050_vehicle', pose.offered)
            self.assertIn('/omron_ld90/omron_controller', pose.heard)
            for wire in found:
                ends = {*wire.offered, *wire.heard}
                if '/graph_editor' in ends:
                    self.assertEqual(ends, {'/graph_editor'}, f'{wire}: the editor is alone')

    def test_two_robots_share_nothing_but_the_graph(self) -> None:
        with Launched('two_robots.launch', rviz='false', **ports(
                'arcl_port_a', 'outgoing_port_a', 'arcl_port_b', 'outgoing_port_b')):
            found = settled('/robot_a/omron_controller', '/robot_b/omron_controller',
                            '/robot_a/goal_sender', '/robot_b/goal_sender')
            self.check(found)
            for wire in found:
                robots = {node.split('/')[1] for node in (*wire.offered, *wire.heard)}
                if wire.name not in ('/graph', '/fleet_state', '/mission_request',
                                     '/mission_status'):
                    self.assertEqual(len(robots), 1, f'{wire}: of one robot only')


if __name__ == '__main__':
    run_cases(__file__)
