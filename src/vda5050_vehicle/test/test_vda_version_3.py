"""The differences between a vehicle of VDA 5050 3.0 and a vehicle of 2.1."""
from __future__ import annotations

import json

import pytest
from vda_builders import SAY, Lab, say, way
from vda_builders import lab as laboratory
from vda_messages import payload

from vda5050_protocol.action_queue import MAX_ENDED_INSTANT_ACTIONS
from vda5050_protocol.codec_3 import VERSION_3_0

HALL = way(8, 10, 12, 14, 32)


@pytest.fixture
def lab():
    return Lab(codec=VERSION_3_0)


def told(lab):
    """Returns types and levels of the errors as they were sent."""
    return [(error['errorType'], error['errorLevel']) for error in lab.wire['errors']]


def order_with(action, **changes):
    """Returns an order with an action at its second node."""
    return HALL.order('o', actions={'10': [{**action, **changes}]})


# --- instant actions ------------------------------------------------------------------------------

def test_an_instant_action_that_needs_the_vehicle_to_stand_is_done_though_it_cannot_block(lab):
    lab.act('startCharging', 'charge')
    assert lab.started == ['charge']
    assert lab.errors == []


def test_instant_actions_are_told_until_they_are_cleared(lab):
    lab.act('stateRequest', 'asked')
    lab.order(HALL.order('o'))
    assert lab.status('asked') == 'FINISHED'
    lab.act('say', 'runs', **SAY)
    lab.act('clearInstantActions', 'clear')
    assert [(found['actionId'], found['actionStatus'])
            for found in lab.wire['instantActionStates']] == [('runs', 'RUNNING'),
                                                              ('clear', 'FINISHED')]


def test_a_master_that_never_clears_them_is_told(lab):
    for number in range(MAX_ENDED_INSTANT_ACTIONS):
        assert lab.errors == []
        lab.act('stateRequest', f'asked {number}')
    assert told(lab) == [('INSTANT_ACTION_STATES_FULL', 'URGENT')]
    lab.act('clearInstantActions', 'clear')
    assert lab.errors == []


def test_an_order_is_cancelled_by_its_id_where_the_master_gives_one(lab):
    lab.order(HALL.order('o'))
    wrong = lab.act('cancelOrder', 'wrong', orderId='another')
    assert lab.status(wrong) == 'FAILED'
    assert told(lab) == [('NO_ORDER_TO_CANCEL', 'WARNING')]
    assert lab.robot.drives
    right = lab.act('cancelOrder', 'right', orderId='o')
    lab.settle()
    assert lab.status(right) == 'FINISHED'
    assert lab.nodes == []


# --- actions of orders ----------------------------------------------------------------------------

def test_single_lets_the_vehicle_drive_and_no_other_action_run(lab):
    lab.order(HALL.order('o', actions={'8': [say('alone', 'SINGLE'), say('then')]}))
    assert lab.started == ['alone']
    assert lab.robot.drives
    lab.end_action('alone')
    assert lab.started == ['alone', 'then']


def test_an_action_waits_for_those_that_run_before_it_is_done_alone(lab):
    lab.order(HALL.order('o', actions={'8': [say('first'), say('alone', 'SINGLE')]}))
    assert lab.started == ['first']
    lab.end_action('first')
    assert lab.started == ['first', 'alone']


def failed_at_10(lab):
    """Lets an action at vertex 10 fail that may be retried; the vehicle waits there."""
    lab.order(order_with(say('a', 'HARD'), retriable=True))
    lab.drive(1)
    lab.wait(0.1)
    lab.end_action('a', succeeded=False, text='no voice')
    assert lab.status('a') == 'RETRIABLE'
    assert not lab.robot.drives


def test_a_retriable_action_is_tried_again_when_the_master_says_so(lab):
    failed_at_10(lab)
    lab.wait(5.0)
    assert lab.started == ['a'], 'nothing may be repeated without a master'
    assert lab.status(lab.act('retry', 'again', actionId='a')) == 'FINISHED'
    assert lab.started == ['a', 'a']
    lab.end_action('a')
    lab.wait(0.1)
    assert lab.status('a') == 'FINISHED'
    assert lab.robot.drives


def test_a_retriable_action_that_is_skipped_has_failed(lab):
    failed_at_10(lab)
    assert lab.status(lab.act('skipRetry', 'skip', actionId='a')) == 'FINISHED'
    assert lab.status('a') == 'FAILED'
    assert told(lab) == [('ACTION_FAILED', 'CRITICAL')]
    lab.act('stopPause')
    assert lab.robot.drives


def test_an_order_that_waits_for_a_retry_can_be_cancelled(lab):
    failed_at_10(lab)
    cancel = lab.act('cancelOrder')
    lab.settle()
    assert (lab.status('a'), lab.status(cancel)) == ('FAILED', 'FINISHED')


def test_a_restarted_adapter_still_waits_for_the_retry(lab):
    failed_at_10(lab)
    lab = lab.restarted()
    lab.wait(0.1)
    assert lab.status('a') == 'RETRIABLE'
    lab.act('retry', 'again', actionId='a')
    assert lab.started == ['a']


def test_an_action_that_was_not_retried_on_its_edge_has_failed(lab):
    lab.order(HALL.order('o', actions={'1': [{**say('a'), 'retriable': True}]}))
    lab.end_action('a', succeeded=False, text='no voice')
    assert lab.status('a') == 'RETRIABLE'
    lab.drive(1)
    assert lab.status('a') == 'FAILED'
    assert lab.status(lab.act('retry', 'late', actionId='a')) == 'FAILED'


def test_what_is_not_retriable_is_not_tried_again(lab):
    lab.order(order_with(say('a')))
    assert lab.status(lab.act('retry', 'again', actionId='a')) == 'FAILED'
    assert told(lab) == [('INVALID_INSTANT_ACTION', 'WARNING')]


def test_2_1_has_none_of_these_actions():
    table = Lab().vehicle.context.table
    assert not {'retry', 'skipRetry', 'clearInstantActions'} & set(table.specs)
    assert {'retry', 'skipRetry', 'clearInstantActions'} <= set(
        Lab(codec=VERSION_3_0).vehicle.context.table.specs)


# --- orders ---------------------------------------------------------------------------------------

def test_a_start_within_the_ellipse_is_near_and_one_beside_it_is_not(lab):
    order = HALL.order('o')  # the hall lies along x
    order['nodes'][0]['nodePosition']['x'] += 2.0
    order['nodes'][0]['nodeId'] = order['edges'][0]['startNodeId'] = 'place'
    ellipse = {'a': 3.0, 'b': 0.1, 'theta': 1.5708}
    for theta, errors in ((1.5708, ['noRouteError']), (0.0, [])):
        order['nodes'][0]['nodePosition']['allowedDeviationXY'] = {**ellipse, 'theta': theta}
        lab.order(order)
        assert lab.errors == errors


@pytest.mark.parametrize('order, error', [
    (way(8, 10).order('p'), ('OTHER_ORDER_ACTIVE', 'WARNING')),
    (HALL.part(1).order('o', 2), ('INVALID_ORDER_UPDATE', 'WARNING')),
    (HALL.order('o', 0), ('OUTDATED_ORDER_UPDATE', 'WARNING')),
    (HALL.order('o', 1, base=2), ('SAME_ORDER_UPDATE_ID', 'WARNING'))])
def test_errors_have_the_names_of_3_0_under_way(lab, order, error):
    lab.order(HALL.order('o', base=2))
    lab.order(HALL.part(1).order('o', 1, base=2, first_sequence=2))
    lab.order(order)
    assert told(lab) == [error]


def on_another_map():
    order = HALL.order('o')
    for node in order['nodes']:
        node['nodePosition']['mapId'] = 'cellar'
    return order


def with_edge(**fields):
    order = HALL.order('o')
    order['edges'][0].update(fields)
    return order


@pytest.mark.parametrize('order, error', [
    ({'orderId': 'o'}, ('VALIDATION_FAILURE', 'WARNING')),
    (way(10, 12).order('o'), ('START_NODE_OUT_OF_RANGE', 'WARNING')),
    (order_with(say('a'), actionType='fly'), ('INVALID_ORDER_ACTION', 'WARNING')),
    (on_another_map(), ('UNKNOWN_MAP_ID', 'WARNING')),
    (with_edge(maximumSpeed=0.1), ('UNSUPPORTED_PARAMETER', 'CRITICAL')),
    (with_edge(corridor={'leftWidth': 1.0, 'rightWidth': 1.0, 'releaseRequired': True}),
     ('UNSUPPORTED_PARAMETER', 'CRITICAL'))])
def test_errors_have_the_names_of_3_0_before_an_order(lab, order, error):
    lab.order(order)
    assert told(lab) == [error]


def test_a_new_order_begins_with_update_0(lab):
    lab.order(HALL.order('o', 5))
    assert told(lab) == [('INVALID_ORDER', 'WARNING')]
    lab.order(HALL.order('o'))
    assert lab.errors == []


def test_a_copy_of_a_cancelled_order_is_an_update_of_it(lab):
    lab.order(HALL.order('o', base=3))
    lab.act('cancelOrder')
    lab.settle()
    lab.order(HALL.order('o', base=3))
    assert told(lab) == [('ORDER_UPDATE_FOLLOWING_CANCEL', 'WARNING')]


def test_a_refused_instant_action_is_told_until_one_is_taken_and_not_until_an_order_is(lab):
    lab.act('fly')
    lab.order(HALL.order('o'))
    assert told(lab) == [('INVALID_INSTANT_ACTION', 'WARNING')]
    lab.act('stateRequest')
    assert lab.errors == []


def test_an_order_is_taken_beside_an_instant_action_that_does_not_move_the_robot(lab):
    lab.act('say', 'a', **SAY)
    lab.order(HALL.order('o'))
    assert lab.errors == []


@pytest.mark.parametrize('kind, parameters', [
    ('startCharging', {}), ('initPosition', {'x': 1.0, 'y': 2.0, 'theta': 0.0, 'mapId': 'map'})])
def test_no_order_is_taken_while_an_instant_action_moves_the_robot(lab, kind, parameters):
    lab.act(kind, 'a', **parameters)
    assert lab.status('a') == 'RUNNING'
    lab.order(HALL.order('o'))
    assert told(lab) == [('OTHER_ORDER_ACTIVE', 'WARNING')]


def test_the_same_update_again_is_ignored(lab):
    lab.order(HALL.order('o', base=3))
    lab.order(HALL.order('o', base=3))
    assert lab.errors == []


def test_an_update_of_a_cancelled_order_is_refused(lab):
    lab.order(HALL.order('o', base=3))
    lab.act('cancelOrder')
    lab.settle()
    lab.order(HALL.order('o', 1))
    assert told(lab) == [('ORDER_UPDATE_FOLLOWING_CANCEL', 'WARNING')]


def test_stops_are_never_refused_for_a_parameter_too_many():
    lab = Lab()  # the format of 2.1
    lab.order(HALL.order('o'))
    lab.receive_instant_actions(payload({'actions': [{
        'actionType': 'startPause', 'actionId': 'stop', 'blockingType': 'HARD',
        'actionParameters': [{'key': 'why', 'value': 'a person'}]}]}, 99))
    assert not lab.robot.drives


# --- the standard's own orders --------------------------------------------------------------------

def test_an_order_in_the_form_of_the_standard_is_driven(lab):
    """The fields are those of 3.0.0, 7.3. The ends of an edge follow from its sequenceId."""
    (x_of_8, y_of_8), (x_of_10, y_of_10) = (laboratory().vertex(v).position for v in (8, 10))
    order = {
        'orderId': 'o', 'orderUpdateId': 0, 'orderDescription': 'for people',
        'nodes': [
            {'nodeId': '8', 'sequenceId': 0, 'released': True, 'nodeDescriptor': 'start',
             'nodePosition': {'x': x_of_8, 'y': y_of_8, 'mapId': 'map', 'allowedDeviationXY': {
                 'a': 0.5, 'b': 0.5, 'theta': 0.0}}, 'actions': []},
            {'nodeId': '10', 'sequenceId': 2, 'released': True, 'nodePosition': {
                'x': x_of_10, 'y': y_of_10, 'mapId': 'map'}, 'actions': [
                    {**say('a'), 'actionDescriptor': 'says a word', 'retriable': True}]}],
        'edges': [
            {'edgeId': 'any', 'sequenceId': 1, 'released': True, 'edgeDescriptor': 'aisle',
             'orientation': 0.0, 'orientationType': 'TANGENTIAL', 'maximumSpeed': 2.0,
             'maximumRotationSpeed': 4.0, 'maximumMobileRobotHeight': 2.5, 'length': 5.0,
             'reachOrientationBeforeEntering': False, 'actions': []}]}
    lab.receive_order(payload(order, 1, '3.0.0'))
    assert (lab.errors, lab.nodes) == ([], ['10'])
    lab.drive(1)
    lab.end_action('a')
    assert (lab.state['lastNodeId'], lab.nodes, lab.status('a')) == ('10', [], 'FINISHED')


@pytest.mark.parametrize('ends, errors', [
    ({}, []), ({'startNodeId': '8', 'endNodeId': '10'}, []),
    ({'startNodeId': '10'}, [('VALIDATION_FAILURE', 'WARNING')]),
    ({'endNodeId': '12'}, [('VALIDATION_FAILURE', 'WARNING')])])
def test_ends_of_edges_may_come_but_must_not_contradict_the_nodes(lab, ends, errors):
    order = json.loads(lab.payload('order', HALL.order('o')))
    assert 'startNodeId' not in order['edges'][0]
    order['edges'][0].update(ends)
    lab.receive_order(json.dumps(order).encode())
    assert told(lab) == errors


@pytest.mark.parametrize('fields, errors', [
    ({'maximumRotationSpeed': 0.1}, ['orderError']), ({'maxRotationSpeed': 0.1}, ['orderError']),
    ({'maximumRotationSpeed': 0.1, 'maxRotationSpeed': 9.0}, ['orderError']),
    ({'maximumRotationSpeed': 9.0}, []), ({'maxRotationSpeed': 9.0}, [])])
def test_the_rotation_speed_is_read_by_its_name_in_the_text_and_by_that_in_the_schema(
        lab, fields, errors):
    lab.order(with_edge(**fields))
    assert lab.errors == errors


def test_a_new_order_begins_with_sequence_id_0(lab):
    lab.order(HALL.order('o', first_sequence=2))
    assert told(lab) == [('INVALID_ORDER', 'WARNING')]
