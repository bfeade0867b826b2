#!/usr/bin/env python3
"""Starts each launch file: each topic of our nodes must have a publisher and a subscriber of the
same type.
"""
from __future__ import annotations

import os
import re
import time
import unittest
from pathlib import Path
from typing import Dict, List, NamedTuple, Set, Tuple
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
import rosservice

from ports import free_port
from system_support import Launched, run_cases, wait_until

ROOT = Path(__file__).resolve().parents[1]
LAB = {'map_file': ROOT / 'maps/lab.map', 'graph_file': ROOT / 'maps/lab_graph.yaml'}
SETTLED = 3.0  # s without a further registration
#: Topics that people and other software publish, and our nodes that may also publish them.
FROM_OUTSIDE: Dict[str, Set[str]] = {
    'clicked_point': {'rviz'}, 'move_base_simple/goal': {'rviz'},
    'initialpose': {'rviz', 'vda5050_vehicle'}, 'send_command': set(),
    'closed_edges': set(), 'device_states': {'fleet_devices'},
    'edge_command': {'fleet_visualisation'},
    'interactive_goals/feedback': {'rviz'}, 'graph_editor/feedback': {'rviz'},
    'fleet_handles/feedback': {'rviz'}, 'move_base/cancel': set(),
    'mission_request': {'goal_sender'}, 'mission_command': {'goal_sender', 'fleet_visualisation'}}
#: Topics of our nodes that people, other software, or optional nodes receive.
TO_OUTSIDE: Dict[str, Tuple[str, ...]] = {
    'shown in RViz': (
        'driven_path', 'feedback_markers', 'graph_markers', 'interactive_goals/update',
        'interactive_goals/update_full', 'laser_markers', 'laser_points', 'map',
        'map_markers/docks', 'map_markers/forbidden_areas', 'map_markers/goal_headings',
        'map_markers/goal_names', 'map_markers/goals', 'map_markers/lines', 'map_markers/points',
        'map_markers/sectors', 'route_markers', 'status_markers', '/graph_editor/findings',
        '/graph_editor/graph', '/graph_editor/map', '/graph_editor/update',
        '/graph_editor/update_full', '/graph_editor/words'),
    'published for people and other software': (
        'odom', 'status/battery_voltage', 'status/extended_status',
        'status/localization_score', 'status/location', 'status/state', 'status/state_of_charge',
        'status/temperature', 'user_feedback'),
    'as move_base has it, for its clients': (
        'move_base/feedback', 'move_base/result', 'move_base/status'),
    'of the fleet, for its display and its page': (
        '/docking_points', '/fleet_allocations', '/fleet_plan', '/fleet_poses'),
    'of the fleet, for the command mission and the page': ('/mission_templates', '/timetables'),
    'for fleet_devices, which need not run': ('/device_request',),
    'for a fleet manager or an adapter, which need not run': (
        '/mission_request', 'battery_state', 'route_refused')}
#: The services of our nodes, by the end of their names. Each has its type, and the file of our
#: program that calls it; empty: only other software calls it.
SERVICES: Dict[str, Tuple[str, str]] = {
    'stop_fleet': ('std_srvs/Trigger', 'graph_fleet_manager/commands/stop.py'),
    'resume_fleet': ('std_srvs/Trigger', 'graph_fleet_manager/nodes/fleet_acts.py'),
    'leave_fleet': ('std_srvs/Trigger', 'graph_fleet_manager/nodes/fleet_acts.py'),
    'join_fleet': ('std_srvs/Trigger', 'graph_fleet_manager/nodes/fleet_acts.py'),
    'declare_absent': ('itrci_nav_msgs/DeclareAbsent', 'graph_fleet_manager/nodes/fleet_acts.py'),
    'explain_mission': ('itrci_nav_msgs/ExplainMission',
                        'graph_fleet_manager/commands/mission.py'),
    'charge': ('itrci_nav_msgs/ChargeRobot', 'graph_fleet_manager/commands/fleet.py'),
    'pause_timetable': ('itrci_nav_msgs/PauseTimetable',
                        'graph_fleet_manager/commands/timetables.py'),
    'set_load': ('itrci_nav_msgs/SetLoad', 'graph_fleet_manager/commands/fleet.py'),
    'get_mission_status': ('itrci_nav_msgs/GetMissionStatus',
                           'fleet_requests/__init__.py'),
    'reload_graph': ('std_srvs/Trigger', 'graph_editor/nodes/take_over.py'),
    'static_map': ('nav_msgs/GetMap', ''),  # the service of map_server, for foreign planners
    'change_map': ('nav_msgs/LoadMap', '')}
#: For each launch file that this test does not start: the test that starts it, and a word by which
#: that test names it.
ELSEWHERE = {
    'rviz.launch': ('rviz_support.py', 'rviz.launch'),
    'editor_rviz.launch': ('graph_editor_site_test.py', 'editor_rviz'),
    'map_converter.launch': ('converter.test', 'map_converter'),
    'multimaster.launch': ('joined_fleet.py', 'multimaster'),
    'join_masters.launch': ('joined_fleet.py', 'multimaster'),
    'job_client.launch': ('queue_job.test', 'job_client'),
    'job_server.launch': ('jobs.test', 'job_server'),
    'node_host.launch': ('hosted_test.py', 'node_host'),
    'robot_host.launch': ('hosted.test', 'hosted')}
#: Launch files that this test starts, directly or through another launch file.
STARTED = {'full_stack.launch', 'robot.launch', 'sim.launch', 'visualisation.launch',
           'steps.launch', 'vda5050.launch', 'two_robots.launch', 'fleet_manager.launch',
           'edit.launch'}
#: Topics of a fleet manager, which is not always there.
OF_THE_FLEET = ('graph', 'fleet_state', 'mission_status', 'target_route')
NOT_OURS = ('/rosout', 'body_state_publisher')
EVERYBODYS = {'/rosout', '/rosout_agg', '/tf', '/tf_static', '/diagnostics', '/clock'}


class Wire(NamedTuple):
    """A topic, with the message type in each of its publishers and subscribers."""

    name: str
    offered: Dict[str, str]
    heard: Dict[str, str]


def wires() -> List[Wire]:
    """Returns all topics of the running nodes, without the topics of this test."""
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
    """Returns the topics when these nodes run and no further registration comes."""
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
    maxDiff = None

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('wiring_test')
        cls.services: Set[str] = set()
        cls.to_outside: Set[str] = set()
        os.environ.pop('DISPLAY', None)

    def check(self, found: List[Wire], has_fleet_manager: bool = False) -> None:
        may_be_alone = (*FROM_OUTSIDE, *(() if has_fleet_manager else OF_THE_FLEET))
        for wire in found:
            kinds = {*wire.offered.values(), *wire.heard.values()} - {'*'}
            self.assertLessEqual(len(kinds), 1, f'{wire}: one name, several types')
            for suffix, ours in FROM_OUTSIDE.items():
                if wire.name.endswith(f'/{suffix}'):
                    givers = {node.rsplit('/', 1)[1] for node in wire.offered}
                    self.assertLessEqual(givers, ours, f'{wire}: no other node publishes this')
            if wire.heard and not wire.name.endswith(tuple(f'/{name}' for name in may_be_alone)):
                self.assertTrue(wire.offered, f'{wire}: no node publishes what is subscribed to')
            if wire.offered and not wire.heard:
                self.to_outside.add(re.sub('^/(omron_ld90|robot_[ab])/', '', wire.name))
        self.check_services()

    def check_services(self) -> None:
        for name in rosservice.get_service_list():
            last = name.rsplit('/', 1)[1]
            if last in ('get_loggers', 'set_logger_level', 'tf2_frames'):
                continue
            self.assertIn(last, SERVICES, f'{name}: no node calls it')
            self.assertEqual(SERVICES[last][0], rosservice.get_service_type(name), name)
            self.services.add(last)

    def named(self, found: List[Wire], name: str) -> Wire:
        return next(wire for wire in found if wire.name == name)

    def test_the_full_stack_with_a_fleet_manager(self) -> None:
        with Launched('full_stack.launch', fleet_manager='true', steps='true', rviz='false',
                      **ports('arcl_port', 'outgoing_port')):
            found = settled('/omron_ld90/omron_controller', '/omron_ld90/goal_sender',
                            '/omron_ld90/omron_edges_to_vertices', '/path_supervisor',
                            '/omron_ld90/step_runner',
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

    def test_z_the_tables_hold_nothing_else(self) -> None:
        """Each entry of the tables exists, and this or another test starts each launch file."""
        self.assertEqual(self.services, set(SERVICES))
        self.assertEqual(sorted(self.to_outside), sorted(
            name for names in TO_OUTSIDE.values() for name in names))
        for name, (kind, caller) in SERVICES.items():
            if caller:
                package = caller.split('/')[0]
                source = (ROOT / 'src' / package / 'src' / caller).read_text(encoding='utf-8')
                self.assertIn(name, source)
                self.assertIn(kind.split('/')[1], source)
        files = {file.name for folder in (ROOT / 'launch', *(ROOT / 'src').glob('*/launch'))
                 for file in folder.glob('*.launch')}
        self.assertEqual(files, {*STARTED, *ELSEWHERE})
        for test, word in ELSEWHERE.values():
            self.assertIn(word, (ROOT / 'test' / test).read_text(encoding='utf-8'))


if __name__ == '__main__':
    run_cases(__file__)
