"""Files that people write: the table of actions, the vehicle's file, credentials, layouts."""
from __future__ import annotations

import json

import pytest
import yaml
from vda_builders import PACKAGE, abilities, lab, table, vehicle_document, way
from vda_schemas import problems

from vda5050_vehicle.conformance.layout import lif, main, shortest_edges
from vda5050_vehicle.conformance.track import read_track
from vda5050_vehicle.core.action_table import WrongTable, read_table
from vda5050_vehicle.core.factsheet import WrongVehicle, check_vehicle
from vda5050_vehicle.mqtt.credentials import WrongCredentials, read_credentials
from vda5050_vehicle.mqtt.link import Broker
from vda5050_vehicle.protocol.codec_3 import CODECS
from vda5050_vehicle.protocol.codecs import VERSION_2_1

LINE = {'server': 'execute', 'type': 'some_msgs/Do', 'goal': {'text': 'do {what}'},
        'scopes': ['NODE'], 'parameters': {'what': {'type': 'STRING'}}}


def test_a_call_has_the_arguments_in_its_goal():
    spec = table().specs['say']
    assert spec.call.fields({'text': 'hello'}) == {'command': 'say hello'}


@pytest.mark.parametrize('document, words', [
    (None, 'actions:'), ({'actions': []}, 'actions:'), ({'actions': {'a': {}}}, 'server'),
    ({'actions': {'a': {**LINE, 'scopes': ['HERE']}}}, 'HERE'),
    ({'actions': {'a': {**LINE, 'blocking': ['MAYBE']}}}, 'MAYBE'),
    ({'actions': {'a': {**LINE, 'colour': 'red'}}}, 'colour'),
    ({'actions': {'a': {**LINE, 'parameters': {}}}}, 'what'),
    ({'actions': {'a': {**LINE, 'parameters': {'what': {'type': 'TEXT'}}}}}, 'TEXT'),
    ({'actions': {'a': {**LINE, 'parameters': {'what': {'typ': 'STRING'}}}}}, 'typ')])
def test_a_wrong_table_says_what_is_wrong(document, words):
    with pytest.raises(WrongTable, match=words):
        read_table(document)


@pytest.mark.parametrize('change', [
    lambda d: d.pop('agvGeometry'), lambda d: d['physicalParameters'].pop('speedMax'),
    lambda d: d['physicalParameters'].update(heightMax='low')])
def test_a_wrong_vehicle_file_says_what_is_wrong(change):
    document = vehicle_document()
    change(document)
    with pytest.raises(WrongVehicle):
        check_vehicle(document)


def test_the_package_knows_nothing_of_the_robot_but_its_tables():
    sources = '\n'.join(file.read_text() for file in (PACKAGE / 'src').rglob('*.py'))
    for word in ('omron', 'ld90', 'LD-90', 'execute_command', 'arcl'):
        found = [line for line in sources.splitlines() if word.lower() in line.lower()
                 and 'vehicle-type' not in line]
        assert not found, found
    assert abilities().top_speed == 1.35


@pytest.mark.parametrize('text', [
    '', 'username: a', 'username: a\npassword: 5', '- a\n- b', 'username: [a\npassword: secret'])
def test_wrong_credentials_are_refused_and_not_told(tmp_path, text):
    file = tmp_path / 'credentials.yaml'
    file.write_text(text)
    with pytest.raises(WrongCredentials) as caught:
        read_credentials(str(file))
    assert 'secret' not in str(caught.value)


def test_credentials_are_read_and_shown_nowhere(tmp_path):
    file = tmp_path / 'credentials.yaml'
    file.write_text('username: lab\npassword: "Cormorant 7"\n')
    username, password = read_credentials(str(file))
    assert (username, password) == ('lab', 'Cormorant 7')
    assert 'Cormorant' not in f'{Broker("host", 1883, username, password)!r}'
    assert read_credentials('') == ('', '')


def test_a_way_is_the_shortest_over_the_graph():
    assert shortest_edges(lab(), (8, 14)) == [1, 2, 3]
    with pytest.raises(ValueError):
        shortest_edges(lab(), (8, 4711))


def test_an_order_is_made_of_a_graph_and_read_as_a_track(capsys, tmp_path):
    graph = str(PACKAGE.parents[1] / 'maps' / 'lab_graph.yaml')
    assert main(['order', '--graph', graph, '--vertices', '8', '14', '--order-id', 'mission',
                 '--manufacturer', 'M', '--serial', 'S']) == 0
    text = capsys.readouterr().out
    order = json.loads(text)
    assert order['orderId'] == 'mission'
    assert VERSION_2_1.read('order', text.encode())[0].serial_number == 'S'
    assert [node['nodeId'] for node in order['nodes']] == ['8', '10', '12', '14']
    file = tmp_path / 'order.json'
    file.write_text(text)
    assert read_track(str(file)).stops == way(8, 14).stops
    assert main(['order', '--graph', graph, '--vertices', '8', '4711']) == 1


@pytest.mark.parametrize('version', sorted(CODECS))
def test_an_order_is_made_in_the_version_of_the_vehicle(capsys, version):
    graph = str(PACKAGE.parents[1] / 'maps' / 'lab_graph.yaml')
    assert main(['order', '--graph', graph, '--vertices', '8', '14', '--version', version,
                 '--manufacturer', 'M', '--serial', 'S']) == 0
    text = capsys.readouterr().out
    header, order = CODECS[version].read('order', text.encode())
    assert (header.version, len(order.edges)) == (version, 3)
    assert not problems(version, 'order', json.loads(text))


def test_a_layout_has_every_vertex_and_both_directions():
    layout = lif(lab(), 'lab', 'LD-90', 0.0)['layouts'][0]
    assert {node['nodeId'] for node in layout['nodes']} == {str(v) for v in lab().vertices}
    assert len(layout['edges']) == 2 * len(lab().edges)
    assert yaml.safe_dump(layout)
