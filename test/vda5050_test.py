#!/usr/bin/env python3
"""A VDA 5050 master drives the simulated LD-90 according to the rules of the standard.

The test checks each rule, drives the mission of the laboratory, and ends broker, adapter and
controller during a drive. Every message of the vehicle is checked against the official schemas if
they are installed. It is also checked with the strict checker of vda5050_bench, which finds errors
that the schemas allow.
"""
from __future__ import annotations

import json
import subprocess
import sys
import unittest
from pathlib import Path
from typing import Any, Dict, List

import rospy
import rostest
from jsonschema import Draft7Validator

from itrci_nav_msgs.msg import TargetRoute
from omron_ld90_msgs.msg import LinkState
from system_support import Recorder, kill_node, wait_until
from trajectory_graph import load_graph
from vda5050_bench.bench import RuleOutcome, scorecard, tried
from vda5050_bench.layout import shortest_edges, track_on
from vda5050_bench.master import BenchMaster, status_of
from vda5050_bench.track import action, node_ids
from vda5050_bench.trial import SlowAction, Trial
from vda5050_mqtt.link import Broker
from vda5050_mqtt.own_broker import OwnBroker

ROOT = Path(__file__).resolve().parents[1]
# scripts/run_tests.sh downloads them from PyPI
SCHEMAS = ROOT / 'build' / 'vda5050_schemas' / '2.1.0'
PREFIX = 'uagv/v2/OMRON/omron_ld90'
DOCK = 16
# The robot has no instant action that takes time without a drive. Because its clock is eight times
# as fast, it may happen to stop at a node, even in each of three attempts.
MAY_NOT_BE_TRIED = {
    'a new order is rejected while an action of actionStates has not ended',
    'an order from a node ahead, within its deviation, is driven or rejected',
    'after a cancellation: an order from a temporary node where the vehicle stands'}
MISSION = (DOCK, 18, 39, 52, 6, DOCK)


class Schemas:
    """Checks payloads against the official schemas."""

    def __init__(self) -> None:
        self._validators = {file.stem: Draft7Validator(json.loads(file.read_text()))
                            for file in SCHEMAS.glob('*.json')}
        self.problems: List[str] = []
        self.counts: Dict[str, int] = {}

    def check(self, topic: str, payload: bytes) -> None:
        self.counts[topic] = self.counts.get(topic, 0) + 1
        if topic in self._validators:
            self.problems += [f'{topic}: {error.message}' for error
                              in self._validators[topic].iter_errors(json.loads(payload))]

    @property
    def are_there(self) -> bool:
        """Returns whether there are schemas for the checks."""
        return bool(self._validators)


class Vda5050(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('vda5050_test')
        host, _, port = rospy.get_param('~broker').rpartition(':')
        cls.own_broker = OwnBroker(int(port))
        cls.schemas = Schemas()
        cls.broker = Broker(host, int(port))
        cls.master = BenchMaster(cls.broker, PREFIX, on_payload=cls.schemas.check)
        cls.graph = load_graph(ROOT / 'maps' / 'lab_graph.yaml')
        cls.link_states = Recorder('/omron_ld90/link_state', LinkState)
        cls.routes = Recorder('/omron_ld90/target_route', TargetRoute)
        cls.master.wait(lambda s: s['lastNodeId'] == str(DOCK) and not s['errors'], 60,
                        'a vehicle without errors, at the dock')

    @classmethod
    def tearDownClass(cls) -> None:
        cls.master.close()
        cls.own_broker.close()

    def tearDown(self) -> None:
        self.assertEqual(self.schemas.problems, [])
        self.assertEqual(self.master.checker.violations, [])
        self.assertEqual(self.master.checker.remarks, [])

    def test_1_every_rule_of_the_bench(self) -> None:
        """Acceptance, updates, pause, cancellation, and a broker that is killed during an order."""
        trial = Trial(self.master, track_on(self.graph, (DOCK, 8, 14), 'map'), 60,
                      self.own_broker, SlowAction('wait', {'seconds': 5}))
        verdicts = list(tried(trial, '2.1.0'))
        self.assertEqual({v.rule.sentence for v in verdicts if v.outcome is not RuleOutcome.PASSED}
                         - MAY_NOT_BE_TRIED, set(), scorecard(verdicts))
        self.assertGreater(self.schemas.counts['state'], 50)

    def test_2_the_mission_with_adapter_and_controller_killed_under_way(self) -> None:
        master, track = self.master, track_on(self.graph, MISSION, 'map')
        edges = list(shortest_edges(self.graph, MISSION))
        first, heard = len(self.routes.messages), master.count()
        killed = track.stops[6].node_id
        order = track.order('mission')
        order['nodes'][5]['actions'] = [action('wait', 'started', 'HARD', seconds=30)]
        order['nodes'][10]['actions'] = [action('say', 'later', text='half way')]
        master.send('order', order)
        master.wait(lambda s: status_of(s, 'started') == 'RUNNING', 60,
                    'the action for which the vehicle stands', after=heard)

        before = master.state
        master.checker.restarted()
        kill_node('/omron_ld90/vda5050_vehicle')
        master.wait(lambda m: m['connectionState'] == 'CONNECTIONBROKEN', 10, 'the last will',
                    'connection', master.count('connection') - 1)
        state = master.wait(lambda s: status_of(s, 'started') == 'FAILED', 20,
                            'the order from the journal, in which the started action is FAILED',
                            after=master.count())
        self.assertEqual(state['orderId'], 'mission')
        self.assertEqual(node_ids(state), node_ids(before))
        self.assertFalse(state['paused'], 'there was no pause')
        state = master.wait(lambda s: 'agvPosition' in s, 20, 'a robot that reports')
        self.assertEqual([error['errorType'] for error in state['errors']], ['actionError'])
        self.assertEqual(master.ended(master.act('stopPause'))['actionStatus'], 'FINISHED')

        master.wait(lambda s: s['lastNodeId'] == killed, 60, f'node {killed}',
                    after=master.count())
        kill_node('/omron_ld90/omron_controller')
        self.go_on_if_held(order['nodes'])
        state = master.wait(lambda s: not s['nodeStates'] and not s['driving'], 120,
                            'the end of the mission', after=master.count())
        self.assertEqual(state['lastNodeId'], str(DOCK), state['errors'])
        self.assertEqual(state['errors'], [])
        self.assertEqual(status_of(state, 'later'), 'FINISHED')
        sent = [list(message.edges) for message in self.routes.messages[first:]]
        for route in sent:
            self.assertIn(str(route)[1:-1], str(edges)[1:-1], 'edges that were not ordered')

    def test_3_charging_is_left_and_begun(self) -> None:
        master = self.master
        leave = master.act('stopCharging', blocking='HARD')
        self.assertEqual(master.ended(leave, 30)['actionStatus'], 'FINISHED', master.state)
        master.wait(lambda s: not s['batteryState']['charging'], 10, 'no charging any more')
        charge = master.act('startCharging', blocking='HARD')
        self.assertEqual(master.ended(charge, 30)['actionStatus'], 'FINISHED', master.state)
        master.wait(lambda s: s['batteryState']['charging'], 10, 'charging')

        # Like an order of openTCS: SOFT, at the end of an order to the dock.
        order = track_on(self.graph, (DOCK, 8, DOCK), 'map').order('recharge')
        order['nodes'][-1]['actions'] = [action('startCharging', 'recharge', 'SOFT')]
        heard = master.count()
        master.send('order', order)
        state = master.wait(lambda s: status_of(s, 'recharge') in ('FINISHED', 'FAILED'), 120,
                            'the end of charging by order', after=heard)
        self.assertEqual(status_of(state, 'recharge'), 'FINISHED', state['errors'])
        state = master.wait(lambda s: s['batteryState']['charging'], 10, 'charging')
        self.assertEqual((state['lastNodeId'], state['nodeStates'], state['errors']),
                         (str(DOCK), [], []))

    def test_4_two_masters_of_one_robot_are_refused(self) -> None:
        ended = subprocess.run(
            [str(ROOT / 'scripts' / 'run.sh'), 'vda5050:=true', 'fleet_manager:=true'],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=30, check=False)
        self.assertNotEqual(ended.returncode, 0)
        self.assertIn(b'two masters', ended.stdout)

    def test_5_the_messages_were_checked_against_the_official_schemas(self) -> None:
        if not self.schemas.are_there:
            self.skipTest(f'{SCHEMAS} is missing: vda5050-sdk was not installed')

    def go_on_if_held(self, nodes: List[Dict[str, Any]]) -> None:
        """Waits until the vehicle drives on. If its order is suspended, sends stopPause."""
        master, ids = self.master, [node['nodeId'] for node in nodes]
        passed = len(ids) - len(node_ids(master.state))
        state = master.wait(lambda s: s['errors'] or len(ids) - len(node_ids(s)) > passed, 60,
                            'a vehicle that drives on, or is paused', after=master.count())
        if state['errors']:
            self.assertEqual([error['errorType'] for error in state['errors']], ['driveError'])
            self.assertTrue(state['nodeStates'], 'an error cleared the order')
            wait_until(lambda: self.links() == {'commands': LinkState.CONNECTED,
                                                'outgoing': LinkState.CONNECTED},
                       30, 'both links to the robot')
            self.assertEqual(master.ended(master.act('stopPause'))['actionStatus'], 'FINISHED')

    def links(self) -> Dict[str, int]:
        """Returns the states of the links to the robot."""
        return {link.link: link.state for link in self.link_states.messages}


if __name__ == '__main__':
    rostest.rosrun('omron_ld90', 'vda5050', Vda5050, sys.argv)
