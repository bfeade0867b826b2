"""Reading and writing of messages: the official schemas, and hostile input."""
from __future__ import annotations

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from vda_builders import IDENTITY, Lab, say, table, vehicle_document, way
from vda_messages import payload
from vda_schemas import paths, problems, validator

from vda5050_protocol import codecs
from vda5050_protocol.action_queue import MAX_INSTANT_ACTIONS
from vda5050_protocol.codec_3 import CODECS, VERSION_3_0
from vda5050_protocol.codecs import ORDER, VERSION_2_0, VERSION_2_1
from vda5050_protocol.fields import (
    MAX_MESSAGE,
    ListOf,
    Malformed,
    ObjectKind,
    read_json,
    write_json,
)
from vda5050_protocol.headers import Headers, timestamp
from vda5050_protocol.values import (
    AgvPosition,
    BlockingType,
    ConnectionMessage,
    ConnectionState,
    Deviation,
    EmergencyStop,
    Velocity,
    Visualization,
)
from vda5050_vehicle.core import factsheet as sheet
from vda5050_vehicle.core.state_report import state_of


def busy_lab(codec) -> Lab:
    """Returns a vehicle whose state has everything: base, horizon, actions, errors, pose."""
    lab = Lab(codec=codec)
    lab.order({'orderId': 'broken'})
    lab.order(way(8, 10, 12, 14, 32).order('o', base=3, actions={
        '8': [say('at the start')], '12': [say('hard', 'HARD')], '14': [say('horizon')]}))
    lab.act('noSuchAction')
    return lab


@pytest.mark.parametrize('version', sorted(CODECS))
def test_what_the_vehicle_sends_is_valid(version):
    codec = CODECS[version]
    headers = Headers(version, 'OMRON', 'lab', lambda: 1e9)
    lab = busy_lab(VERSION_2_1)
    sent = {
        'state': state_of(lab.vehicle.context),
        'connection': ConnectionMessage(ConnectionState.ONLINE),
        'visualization': Visualization(AgvPosition(1.0, 2.0, 0.5, 'map'), Velocity(1.0, 0.0, 0.1)),
        'factsheet': sheet.factsheet(vehicle_document(), lab.vehicle.context.table,
                                     lab.driver.longest)}
    for topic, message in sent.items():
        wire = json.loads(write_json(codec.write(topic, headers.make(topic), message)))
        found = problems(version, topic, wire)
        assert not found, f'{topic}: {found}'


# Endings of the names of fields that only people read.
FOR_PEOPLE = ('description', 'descriptor')
# This field concerns the loss of a release, but orders with `releaseRequired` are refused.
MEANINGLESS = ('edges.corridor.releaseLossBehavior',)


@pytest.mark.parametrize('version', sorted(CODECS))
def test_no_field_of_an_order_is_overlooked(version):
    """The codec reads every field of the official schema, so that none is ignored silently."""
    record = CODECS[version].records['order']
    overlooked = [path for path in paths(version, 'order')
                  if path not in (*HEADER_KEYS, *MEANINGLESS)
                  and not path.lower().endswith(FOR_PEOPLE) and not is_read(record, path)]
    assert overlooked == []


HEADER_KEYS = ('headerId', 'timestamp', 'version', 'manufacturer', 'serialNumber')


def is_read(record, path):
    """Returns whether a path of JSON keys leads to a field, or into a value of any JSON type."""
    kind = record
    for key in path.split('.'):
        kind = getattr(kind, 'kind', kind) if isinstance(kind, ListOf) else kind
        if not isinstance(kind, ObjectKind):
            return True
        field = next((field for field in kind.fields if key in (field.key, *field.aliases)), None)
        if field is None:
            return False
        kind = field.kind
    return True


def test_what_the_master_of_the_tests_sends_is_valid():
    order = json.loads(payload(way(8, 10, 12).order('o', actions={'10': [say('a')]})))
    assert validator('2.1.0', 'order').is_valid(order)


def test_an_order_is_read_and_written_back():
    sent = way(8, 10, 12).order('o', 3, base=2, actions={'10': [say('a', 'SOFT')]})
    header, order = VERSION_2_1.read('order', payload(sent, 7))
    assert header.header_id == 7
    assert (order.order_id, order.order_update_id) == ('o', 3)
    assert [node.released for node in order.nodes] == [True, True, False]
    assert order.nodes[1].actions[0].blocking_type is BlockingType.SOFT
    assert order.nodes[1].actions[0].arguments == {'text': 'hello'}
    assert ORDER.write(order) == sent


OPTIONAL = {
    '2.1.0': ['zoneSetId', 'nodes.nodeDescription', 'nodes.nodePosition.theta',
              'nodes.nodePosition.allowedDeviationXY', 'nodes.nodePosition.allowedDeviationTheta',
              'edges.maxSpeed', 'edges.trajectory', 'edges.corridor', 'edges.orientation',
              'edges.rotationAllowed', 'nodes.actions.actionDescription',
              'nodes.actions.actionParameters'],
    '3.0.0': ['orderDescription', 'nodes.nodePosition.theta', 'edges.maximumSpeed',
              'nodes.nodePosition.allowedDeviationXY', 'edges.maximumRotationSpeed',
              'edges.reachOrientationBeforeEntering', 'edges.corridor', 'edges.trajectory',
              'edges.startNodeId', 'nodes.actions.actionParameters', 'nodes.actions.retriable']}


def with_null(order, path):
    """Sets a field of the order to null, in each element of the lists on its JSON path."""
    *parents, key = path.split('.')
    holders = [order]
    for parent in parents:
        holders = [item for holder in holders for item in (
            holder[parent] if isinstance(holder[parent], list) else [holder[parent]])]
    assert holders
    for holder in holders:
        holder[key] = None


@pytest.mark.parametrize('version, path', [
    (version, path) for version, found in OPTIONAL.items() for path in found])
def test_null_in_an_optional_field_is_as_if_it_were_absent(version, path):
    codec = CODECS[version]
    lab = Lab(codec=codec)
    order = json.loads(lab.payload('order', way(8, 10).order('o', actions={
        '10': [{'actionType': 'stop', 'actionId': 'a', 'blockingType': 'NONE'}]})))
    _, absent = codec.read('order', json.dumps(order).encode())
    with_null(order, path)
    _, found = codec.read('order', json.dumps(order).encode())
    assert found == absent


@pytest.mark.parametrize('path', ['orderId', 'nodes', 'nodes.nodeId', 'nodes.nodePosition.x',
                                  'nodes.actions', 'edges.released'])
def test_null_in_a_required_field_is_malformed(path):
    order = json.loads(payload(way(8, 10).order('o')))
    with_null(order, path)
    with pytest.raises(Malformed, match='null'):
        VERSION_2_1.read('order', json.dumps(order).encode())


def test_null_is_no_reason_to_overlook_the_other_spelling_of_a_key():
    sent = way(8, 10).order('o')
    sent['nodes'][0]['nodePosition'].update(allowedDeviationXY=None, allowedDeviationXy=1.5)
    _, order = VERSION_2_1.read('order', payload(sent))
    assert order.nodes[0].position.allowed_deviation_xy == Deviation(1.5, 1.5)


def test_2_0_spells_a_key_otherwise_and_is_understood():
    sent = way(8, 10).order('o')
    sent['nodes'][0]['nodePosition']['allowedDeviationXy'] = 1.5
    _, order = VERSION_2_1.read('order', payload(sent))
    assert order.nodes[0].position.allowed_deviation_xy == Deviation(1.5, 1.5)


@pytest.mark.parametrize('key', ['actions', 'instantActions'])
@pytest.mark.parametrize('type_key', ['actionType', 'actionName'])
def test_instant_actions_come_under_the_keys_of_drafts_too(key, type_key):
    sent = {key: [{type_key: 'stateRequest', 'actionId': 'a', 'blockingType': 'NONE'}]}
    _, message = VERSION_2_1.read('instantActions', payload(sent))
    assert message.actions[0].action_type == 'stateRequest'


def test_2_0_0_knows_no_maps():
    lab = Lab(codec=VERSION_2_0)
    assert 'maps' not in lab.state
    assert Lab().state['maps'] == [{'mapId': 'map', 'mapVersion': '1', 'mapStatus': 'ENABLED'}]


@pytest.mark.parametrize('damage, path', [
    (lambda o: o.pop('orderId'), 'orderId'),
    (lambda o: o.update(orderUpdateId=-1), 'orderUpdateId'),
    (lambda o: o.update(orderUpdateId=1.5), 'orderUpdateId'),
    (lambda o: o.update(orderUpdateId=True), 'orderUpdateId'),
    (lambda o: o.update(orderUpdateId=2 ** 32), 'orderUpdateId'),
    (lambda o: o.update(nodes={}), 'nodes'),
    (lambda o: o.update(nodes=[0] * 3000), 'nodes'),
    (lambda o: o['nodes'][1].update(nodeId=5), 'nodes[1].nodeId'),
    (lambda o: o['nodes'][1].update(nodeId='x' * 2000), 'nodes[1].nodeId'),
    (lambda o: o['nodes'][1].update(nodeId='a\x07'), 'nodes[1].nodeId'),
    (lambda o: o['nodes'][1].update(released='true'), 'nodes[1].released'),
    (lambda o: o['nodes'][1]['nodePosition'].update(x=10 ** 400), 'nodes[1].nodePosition.x'),
    (lambda o: o['nodes'][1]['nodePosition'].update(theta=4.0), 'nodes[1].nodePosition.theta'),
    (lambda o: o['edges'][0].update(actions=[{'actionType': 'a', 'actionId': 'b',
                                              'blockingType': 'hard'}]),
     'edges[0].actions[0].blockingType'),
    (lambda o: o.update(version='3.0.0'), 'version'),
])
def test_a_malformed_order_is_refused_with_the_place(damage, path):
    message = json.loads(payload(way(8, 10, 12).order('o')))
    damage(message)
    with pytest.raises(Malformed) as caught:
        VERSION_2_1.read('order', json.dumps(message).encode())
    assert caught.value.path == path


@pytest.mark.parametrize('text', [
    b'', b'{', b'[]', b'null', b'"x"', b'\xff', b'{"a": NaN}', b'{"a": Infinity}',
    b'[' * 100_000, b'{"a":' * 50_000, b'x' * (MAX_MESSAGE + 1)])
def test_what_is_no_json_object_is_refused(text):
    with pytest.raises(Malformed):
        read_json(text)


def test_a_parameter_nested_without_end_is_refused():
    value = 'x'
    for _ in range(50):
        value = [value]
    sent = {'actions': [{'actionType': 'say', 'actionId': 'a', 'blockingType': 'NONE',
                         'actionParameters': [{'key': 'text', 'value': value}]}]}
    with pytest.raises(Malformed, match='nested'):
        VERSION_2_1.read('instantActions', payload(sent))


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(
        st.sampled_from(['orderId', 'nodes', 'edges', 'actions', 'headerId', 'x', 'version',
                         'nodePosition', 'sequenceId', 'released']), inner, max_size=6),
    max_leaves=20)


@given(JSON)
def test_no_json_upsets_the_reader(value):
    text = json.dumps(value).encode()
    for topic in ('order', 'instantActions'):
        try:
            VERSION_2_1.read(topic, text)
        except Malformed as problem:
            assert str(problem)


@given(st.binary(min_size=1, max_size=300))
def test_no_bytes_upset_the_vehicle(noise):
    lab = Lab()
    lab.do(lab.vehicle.receive([('order', noise)], lab.now))
    lab.do(lab.vehicle.receive([('instantActions', noise)], lab.now))
    assert lab.state['orderId'] == ''
    assert 'validationError' in lab.errors


def test_timestamps_never_go_back_and_ids_count_per_topic():
    clock = iter([100.0, 101.0, 50.0, 50.0, 102.0])
    headers = Headers('2.1.0', 'OMRON', 'lab', lambda: next(clock))
    made = [headers.make(topic) for topic in ('state', 'state', 'state', 'connection', 'state')]
    stamps = [header.timestamp for header in made]
    assert stamps == sorted(set(stamps))
    assert [header.header_id for header in made] == [0, 1, 2, 0, 3]


@pytest.mark.parametrize('codec', CODECS.values(), ids=CODECS)
@pytest.mark.parametrize('theta', [math.pi, -math.pi])
def test_a_heading_of_pi_stays_within_pi_on_the_wire(codec, theta):
    message = Visualization(AgvPosition(1.0, 2.0, theta, 'map'))
    wire = codec.write('visualization', Headers('', '', '', lambda: 1e9).make('state'), message)
    position = wire.get('agvPosition') or wire['mobileRobotPosition']
    assert 3.14159 < abs(position['theta']) <= math.pi
    assert math.copysign(1.0, position['theta']) == math.copysign(1.0, theta)


@pytest.mark.parametrize('version', ['2.1.0', '2.0.0', '2.0', '2', 'v2'])
def test_the_version_is_read_in_the_spellings_of_masters(version):
    header, _ = VERSION_2_1.read('order', payload(way(8, 10).order('o'), version=version))
    assert header.version == version


@pytest.mark.parametrize('written, read', [
    (3.141593, math.pi), (-3.141593, -math.pi), (3.1416, math.pi), (3.142, math.pi), (3.0, 3.0)])
def test_pi_is_read_with_the_rounding_of_its_writer(written, read):
    sent = way(8, 10).order('o')
    sent['nodes'][1]['nodePosition']['theta'] = written
    _, order = VERSION_2_1.read('order', payload(sent))
    assert order.nodes[1].position.theta == read


def test_a_timestamp_is_utc_with_milliseconds():
    assert timestamp(0.25) == '1970-01-01T00:00:00.250Z'


def test_numbers_on_the_wire_are_finite():
    with pytest.raises(ValueError):
        write_json({'x': math.nan})


def test_every_action_of_the_table_is_in_the_factsheet():
    told = {found['actionType'] for found in sheet.factsheet(
        vehicle_document(), Lab().vehicle.context.table, None)['protocolFeatures']['agvActions']}
    assert told >= set(table().specs) | {'cancelOrder', 'startPause', 'stopPause', 'initPosition',
                                         'stateRequest', 'factsheetRequest', 'logReport'}


def test_the_factsheet_leaves_out_what_is_refused():
    told = set(supported('2.1.0'))
    assert 'order.nodes.nodePosition' in told
    assert not told & {'order.edges.maxSpeed', 'order.edges.corridor'}


def factsheet(version, longest=None):
    """Returns the factsheet as it is sent."""
    message = sheet.factsheet(vehicle_document(), Lab().vehicle.context.table, longest)
    return CODECS[version].write('factsheet', Headers(version, 'OMRON', 'lab', lambda: 1e9).make(
        'factsheet'), message)


def supported(version):
    """Returns the optional parameters of the factsheet."""
    return [line['parameter'] for line in
            factsheet(version)['protocolFeatures']['optionalParameters']]


@pytest.mark.parametrize('version', sorted(CODECS))
def test_the_factsheet_names_fields_as_its_version_does(version):
    known = {f'{topic}.{path}' for topic in ('order', 'state') for path in paths(version, topic)}
    if version == '2.0.0':  # the spelling in the text of the standard, which has precedence
        known.add('order.nodes.nodePosition.allowedDeviationXY')
    assert set(supported(version)) <= known


def test_3_0_names_renamed_fields_in_factsheet_and_errors():
    assert {'state.mobileRobotPosition', 'order.edges.maximumMobileRobotHeight'} <= set(
        supported('3.0.0'))
    assert VERSION_3_0.path('order', 'edges[0].rotationAllowed') == (
        'edges[0].reachOrientationBeforeEntering')
    assert VERSION_3_0.path('order', 'zoneSetId') is None
    lab = Lab(codec=VERSION_3_0)
    order = json.loads(lab.payload('order', way(8, 10).order('o')))
    order['edges'][0]['maximumSpeed'] = 0.1
    lab.receive_order(json.dumps(order).encode())
    assert {'referenceKey': 'field', 'referenceValue': 'edges[0].maximumSpeed'} in (
        lab.wire['errors'][0]['errorReferences'])


@pytest.mark.parametrize('version, key', [
    ('2.0.0', 'maxArrayLens'), ('2.1.0', 'maxArrayLens'), ('3.0.0', 'maximumArrayLengths')])
def test_the_factsheet_tells_the_longest_order(version, key):
    limits = factsheet(version, longest=Lab().driver.longest)['protocolLimits'][key]
    assert (limits['order.nodes'], limits['order.edges']) == (1000, 999)
    assert limits['instantActions'] == MAX_INSTANT_ACTIONS


def order_of_3(**position):
    sent = way(8, 10, 12).order('o')
    sent['nodes'][0]['nodePosition'].update(position)
    sent['edges'][0].update(maximumSpeed=0.3, reachOrientationBeforeEntering=True)
    sent['nodes'][1]['actions'] = [say('a', 'SINGLE')]
    return payload(sent).replace(b'"2.1.0"', b'"3.0.0"')


def test_3_0_is_read_under_its_own_keys():
    _, order = VERSION_3_0.read('order', order_of_3(
        allowedDeviationXY={'a': 2.0, 'b': 0.5, 'theta': 1.0}))
    assert order.nodes[0].position.allowed_deviation_xy == Deviation(2.0, 0.5, 1.0)
    assert (order.edges[0].max_speed, order.edges[0].rotation_allowed) == (0.3, False)
    assert order.nodes[1].actions[0].blocking_type is BlockingType.SINGLE
    with pytest.raises(Malformed, match='allowedDeviationXY'):
        VERSION_3_0.read('order', order_of_3(allowedDeviationXY=0.5))


def test_3_0_is_written_under_its_own_keys():
    headers = Headers('3.0.0', 'OMRON', 'lab', lambda: 1e9)
    lab = busy_lab(VERSION_2_1)
    lab.see(e_stop=EmergencyStop.MANUAL)
    lab.act('initPosition', x=0.0, y=0.0, theta=0.0, mapId='map')
    wire = VERSION_3_0.write('state', headers.make('state'), state_of(lab.vehicle.context))
    assert wire['powerSupply']['stateOfCharge'] == 80.0
    assert wire['mobileRobotPosition']['localized'] is True
    assert wire['safetyState']['activeEmergencyStop'] == 'MANUAL'
    assert ('EMERGENCY_STOP', 'URGENT') in [
        (error['errorType'], error['errorLevel']) for error in wire['errors']]
    instant = [found['actionType'] for found in wire['instantActionStates']]
    assert instant == ['noSuchAction', 'initializePosition']
    assert {found['actionId'] for found in wire['actionStates']} == {'at the start', 'hard',
                                                                     'horizon'}
    assert VERSION_3_0.major == 'v3'


def test_levels_of_2_x_are_two():
    lab = busy_lab(VERSION_2_1)
    assert {error['errorLevel'] for error in lab.state['errors']} <= {'WARNING', 'FATAL'}
    assert codecs.VERSION_2_1.major == 'v2'
    assert IDENTITY.map_id == 'map'
