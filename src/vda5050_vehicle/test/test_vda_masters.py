"""Messages in the form of the masters of docs/how-to/vda5050_masters.md, with their settings."""
from __future__ import annotations

import json
import re
from dataclasses import dataclass
from typing import Any, Dict, Sequence, Tuple

import pytest
from vda_builders import Lab, abilities, lab, say
from vda_messages import ROOT

from vda5050_protocol.codec_3 import CODECS

VERTICES = (8, 10, 12, 14)
ALL = len(VERTICES)


@dataclass(frozen=True)
class Master:
    """The keys that a master writes into each message, and those that the vehicle must ignore."""

    header: Dict[str, Any]
    version: str
    ignored: Tuple[str, ...] = ()

    def vehicle(self) -> Lab:
        return Lab(codec=CODECS[self.version], abilities_=abilities(*self.ignored))

    def message(self, number: int, body: Dict[str, Any]) -> bytes:
        return json.dumps({'headerId': number, **self.header, **body}).encode()


MASTERS = {
    'openTCS': Master({'timestamp': '2026-11-01T10:00:00.123456Z', 'version': '2.0.0',
                       'manufacturer': 'OMRON', 'serialNumber': 'lab'}, '2.0.0', ('maxSpeed',)),
    'Isaac Mission Dispatch': Master(
        {'timestamp': '2026-11-01T11:00:00.123456', 'version': '2.0.0', 'manufacturer': '',
         'serialNumber': ''}, '2.1.0', ('theta', 'mapId', 'allowedDeviationXY')),
    'vda-5050-lib': Master({'timestamp': '2026-11-01T10:00:00.123Z', 'version': '2.0.0',
                            'manufacturer': 'OMRON', 'serialNumber': 'lab'}, '2.0.0'),
    'vda5050-sdk': Master({'timestamp': '2026-11-01T10:00:00.123Z', 'version': '2.1.0',
                           'manufacturer': 'OMRON', 'serialNumber': 'lab'}, '2.1.0'),
    'vda5050_core': Master({'timestamp': '2026-11-01T10:00:00.123Z', 'version': '2.0.0',
                            'manufacturer': 'OMRON', 'serialNumber': 'lab'}, '2.0.0')}
# Optional fields that a serialiser writes as null if they have no value.
NULLS_OF_AN_ACTION = dict.fromkeys(('actionDescription', 'actionParameters'))
NULLS_OF_A_NODE = dict.fromkeys(('nodeDescription',))
NULLS_OF_A_POSITION = dict.fromkeys((
    'theta', 'allowedDeviationXY', 'allowedDeviationTheta', 'mapDescription'))
NULLS_OF_AN_EDGE = dict.fromkeys((
    'edgeDescription', 'maxSpeed', 'maxHeight', 'minHeight', 'orientation', 'orientationType',
    'direction', 'rotationAllowed', 'maxRotationSpeed', 'length', 'trajectory', 'corridor'))


def elements(names: Sequence[str], first: int, released: int, node: Dict[str, Any],
             edge: Dict[str, Any]) -> Dict[str, Any]:
    """Returns the nodes and edges of an order, from vertex number `first` on.

    node -- keys that each position of a node gets
    edge -- keys that each edge gets
    """
    places = [lab().vertex(vertex).position for vertex in VERTICES]
    return {
        'nodes': [{'nodeId': names[i], 'sequenceId': 2 * i, 'released': i < released, 'actions': [],
                   'nodePosition': {'x': places[i][0], 'y': places[i][1], **node}}
                  for i in range(first, ALL)],
        'edges': [{'edgeId': f'{names[i]} --- {names[i + 1]}', 'sequenceId': 2 * i + 1,
                   'released': i + 1 < released, 'startNodeId': names[i],
                   'endNodeId': names[i + 1], 'actions': [], **edge}
                  for i in range(first, ALL - 1)]}


def test_opentcs_drives_step_by_step_and_charges_at_the_end():
    """openTCS uses its own names of points, and charges with the blocking type SOFT.

    Each order message has one more step in its base. All edges have maxSpeed.
    """
    master = MASTERS['openTCS']
    vehicle = master.vehicle()
    names = [f'Point-{vertex:04}' for vertex in VERTICES]
    for step in range(1, ALL):
        order = {'orderId': 'TOrder-1', 'orderUpdateId': step - 1, **elements(
            names, step - 1, step + 1, {'mapId': 'map'}, {'maxSpeed': 1.0})}
        if step == 1:  # the deviation of the first node reaches the vehicle
            order['nodes'][0]['nodePosition'].update(allowedDeviationXY=0.01,
                                                     allowedDeviationTheta=0.5)
        order['nodes'][-1]['actions'] = [{'actionType': 'startCharging', 'actionId': 'charge',
                                          'blockingType': 'SOFT'}]
        vehicle.receive_order(master.message(step, order))
        assert vehicle.errors == []
        assert (vehicle.state['orderId'], vehicle.state['orderUpdateId']) == ('TOrder-1', step - 1)
        vehicle.drive(1)
        assert vehicle.state['lastNodeId'] == names[step]
    assert vehicle.started == ['charge']
    vehicle.end_action('charge')
    assert (vehicle.nodes, vehicle.status('charge')) == ([], 'FINISHED')
    assert 'maps' not in vehicle.state, 'the schema of 2.0 allows no other keys'


def test_isaac_sends_routes_from_where_the_robot_is_and_leaves_the_header_empty():
    """Isaac has its own node names. Its nodes have a heading and a deviation; the first has no map.
    """
    master = MASTERS['Isaac Mission Dispatch']
    vehicle = master.vehicle()
    names = [f'mission-n0-s{2 * number}' for number in range(ALL)]
    order = {'orderId': 'mission-n0', 'orderUpdateId': 0, **elements(
        names, 0, ALL, {'theta': 0.0, 'mapId': 'map', 'mapDescription': '',
                        'allowedDeviationXY': 0.1, 'allowedDeviationTheta': 0.0},
        {'edgeDescription': ''})}
    order['nodes'][0]['nodePosition'].update(mapId='', allowedDeviationXY=0.0)
    vehicle.receive_order(master.message(1, order))
    assert vehicle.errors == []
    vehicle.drive(ALL - 1)
    assert (vehicle.nodes, vehicle.state['lastNodeId']) == ([], names[-1])
    assert all('errorDescription' in error for error in vehicle.state['errors'])


def test_isaac_does_actions_as_orders_of_one_node():
    master = MASTERS['Isaac Mission Dispatch']
    vehicle = master.vehicle()
    x, y = lab().vertex(8).position
    action = {'actionType': 'say', 'actionId': 'mission-n0-s0-n0', 'blockingType': 'HARD',
              'actionParameters': [{'key': 'text', 'value': 'hello'}], 'actionDescription': ''}
    vehicle.receive_order(master.message(1, {
        'orderId': 'mission-n0', 'orderUpdateId': 0, 'edges': [],
        'nodes': [{'nodeId': 'mission-n0-s0', 'sequenceId': 0, 'released': True,
                   'actions': [action], 'nodeDescription': '',
                   'nodePosition': {'x': x, 'y': y, 'theta': 0.02, 'mapId': '',
                                    'allowedDeviationXY': 0.0, 'allowedDeviationTheta': 0.0}}]}))
    vehicle.end_action('mission-n0-s0-n0')
    assert vehicle.status('mission-n0-s0-n0') == 'FINISHED'


@pytest.mark.parametrize('name', ['vda-5050-lib', 'vda5050-sdk', 'vda5050_core'])
def test_an_order_of_a_library_with_the_vertices_as_nodes(name):
    master = MASTERS[name]
    vehicle = master.vehicle()
    order = {'orderId': 'o', 'orderUpdateId': 0, **elements(
        [str(vertex) for vertex in VERTICES], 0, 3, {'mapId': 'map'}, {})}
    order['nodes'][1]['actions'] = [say('a', 'SOFT')]
    vehicle.receive_order(master.message(1, order))
    assert vehicle.errors == []
    vehicle.drive(1)
    vehicle.end_action('a')
    vehicle.receive_instant_actions(master.message(1, {'actions': [
        {'actionType': 'cancelOrder', 'actionId': 'c', 'blockingType': 'HARD'}]}))
    vehicle.settle()
    assert (vehicle.status('c'), vehicle.nodes) == ('FINISHED', [])


def test_vda_5050_lib_finds_its_rejected_order_by_the_references():
    """The references have topic and ids, but no actionId. The state has the configured version."""
    master = MASTERS['vda-5050-lib']
    vehicle = master.vehicle()
    vehicle.receive_order(master.message(1, {'orderId': 'o', 'orderUpdateId': 3, **elements(
        [f'{vertex}' for vertex in VERTICES], 2, ALL, {'mapId': 'map'}, {})}))
    error = vehicle.state['errors'][0]
    assert {reference['referenceKey']: reference['referenceValue']
            for reference in error['errorReferences']} == {
        'topic': 'order', 'orderId': 'o', 'orderUpdateId': '3', 'nodeId': '12'}
    assert vehicle.state['version'] == '2.0.0'


@pytest.mark.parametrize('name', MASTERS)
def test_a_master_whose_serialiser_writes_null_for_what_it_does_not_set(name):
    """Serialisers of C# and pydantic write null by default."""
    master = MASTERS[name]
    vehicle = master.vehicle()
    order = {'orderId': 'o', 'orderUpdateId': 0, 'zoneSetId': None, **elements(
        [str(vertex) for vertex in VERTICES], 0, ALL, {'mapId': 'map', **NULLS_OF_A_POSITION},
        NULLS_OF_AN_EDGE)}
    for node in order['nodes']:
        node.update(NULLS_OF_A_NODE)
    vehicle.receive_order(master.message(1, order))
    assert vehicle.errors == []
    vehicle.receive_instant_actions(master.message(1, {'actions': [
        {'actionType': 'stateRequest', 'actionId': 's', 'blockingType': 'NONE',
         **NULLS_OF_AN_ACTION}]}))
    assert vehicle.status('s') == 'FINISHED'
    vehicle.drive(ALL - 1)
    assert vehicle.nodes == []


def test_vda5050_sdk_pauses_and_resumes_under_two_ids():
    master = MASTERS['vda5050-sdk']
    vehicle = master.vehicle()
    vehicle.receive_order(master.message(1, {'orderId': 'o', 'orderUpdateId': 0, **elements(
        [str(vertex) for vertex in VERTICES], 0, ALL, {'mapId': 'map'}, {})}))
    for number, (kind, name, is_paused) in enumerate(2 * [
            ('startPause', 'pause', True), ('stopPause', 'resume', False)]):
        vehicle.receive_instant_actions(master.message(number, {'actions': [
            {'actionType': kind, 'actionId': name, 'blockingType': 'NONE'}]}))
        vehicle.settle()
        assert (vehicle.state['paused'], vehicle.robot.drives) == (is_paused, not is_paused)


@pytest.mark.parametrize('name', MASTERS)
def test_the_page_tells_the_settings_that_are_tried_here(name):
    page = (ROOT / 'docs' / 'how-to' / 'vda5050_masters.md').read_text(encoding='utf-8')
    section = page.split(f'## {name}\n')[1].split('\n## ')[0]
    settings = dict(re.findall(r'(vda5050_\w+):=([^\s`\'"]+)', section))
    assert settings.get('vda5050_version', '2.1.0') == MASTERS[name].version
    assert tuple(filter(None, settings.get('vda5050_ignored_fields', '').split(','))) == (
        MASTERS[name].ignored)
