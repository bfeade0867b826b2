"""Orders from their acceptance to their end: base, horizon, updates, actions, pause, cancel."""
from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest
from vda_builders import DRIVING, STANDING, Lab, abilities, action, route_driver, say, way
from vda_builders import lab as laboratory
from vda_messages import payload

from trajectory_graph import Graph
from vda5050_protocol.values import EmergencyStop
from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.drivers.robot_view import RobotPose

HALL = way(8, 10, 12, 14, 32)


def references(lab):
    """Returns the references of the first error, by key."""
    return {reference['referenceKey']: reference['referenceValue']
            for reference in lab.state['errors'][0]['errorReferences']}


def test_an_idle_vehicle_tells_the_node_on_which_it_stands():
    lab = Lab(at=12)
    assert (lab.state['orderId'], lab.state['lastNodeId']) == ('', '12')
    assert lab.state['agvPosition']['x'] == pytest.approx(-1.5, abs=10.0)


def test_the_base_is_driven_as_one_route_and_the_first_node_is_passed():
    lab = Lab()
    lab.order(HALL.order('o', base=3))
    assert lab.nodes == ['10', '12', '14', '32']
    assert lab.state['lastNodeId'] == '8'
    assert [command.edges for command in lab.robot.routes] == [(1, 2)]


def test_the_journal_is_written_before_the_robot_is_sent():
    lab = Lab()
    lab.order(HALL.order('o'))
    kinds = [type(effect) for effect in lab.effects[-3:]]
    assert kinds == [fx.Keep, fx.DriverCommand, fx.SendState]


def test_an_update_extends_the_route_under_its_id_at_once():
    lab = Lab()
    lab.order(HALL.order('o', base=3))
    lab.drive(1)
    lab.order(HALL.part(2).order('o', 1, first_sequence=4))
    before, after = lab.robot.routes
    assert (before.edges, after.edges, after.first) == ((1, 2), (2, 3, 4), before.first + 1)
    assert before.route_id == after.route_id
    assert lab.robot.route == (1, 2, 3, 4)
    assert lab.state['orderUpdateId'] == 1
    lab.drive(3)
    assert lab.nodes == []
    assert (lab.state['lastNodeId'], lab.state['lastNodeSequenceId']) == ('32', 8)


def test_the_horizon_is_replaced_and_never_driven():
    lab = Lab()
    lab.order(HALL.order('o', base=2))
    lab.drive(1)
    lab.wait(5.0)
    assert lab.nodes == ['12', '14', '32']
    assert lab.robot.route == (1,)
    lab.order(way(10, 22).order('o', 1, first_sequence=2))
    assert lab.nodes == ['22']
    lab.drive(1)
    assert lab.state['lastNodeId'] == '22'


def test_a_completed_order_is_continued_where_it_ended():
    lab = Lab()
    lab.order(way(8, 10).order('o'))
    lab.drive(1)
    lab.order(way(10, 12).order('o', 1, first_sequence=2))
    lab.drive(1)
    assert (lab.state['lastNodeId'], lab.state['lastNodeSequenceId']) == ('12', 4)


def test_another_order_follows_a_completed_one():
    lab = Lab()
    lab.order(way(8, 10).order('o'))
    lab.drive(1)
    lab.order(way(10, 12).order('p'))
    lab.drive(1)
    assert (lab.state['orderId'], lab.state['lastNodeId']) == ('p', '12')


def test_a_single_node_order_is_its_actions():
    lab = Lab()
    lab.order(HALL.part(0, 0).order('o', actions={'8': [say('a', 'HARD')]}))
    assert lab.started == ['a']
    assert lab.status('a') == 'RUNNING'
    lab.end_action('a')
    assert lab.status('a') == 'FINISHED'
    assert not lab.robot.routes
    lab.order(way(8, 10).order('p'))
    assert lab.state['orderId'] == 'p'


def test_a_new_base_is_asked_for_ten_metres_before_the_old_one_ends():
    lab = Lab()
    track = way(8, 35)
    lab.order(track.order('o', base=len(track.stops) - 1))
    asked = []
    while lab.robot.drives:
        lab.drive(1)
        ahead = sum(leg.length for leg in lab.vehicle.state.legs[
            :lab.vehicle.state.order.base_end])
        asked.append((ahead < 10.0, lab.state['newBaseRequest']))
    assert all(wanted == told for wanted, told in asked), asked
    assert {told for _, told in asked} == {True, False}


@pytest.mark.parametrize('order, error, field', [
    (way(8, 10).order('p'), 'orderError', None),
    (HALL.order('o', 0), None, None)])
def test_while_an_order_is_under_way(order, error, field):
    lab = Lab()
    lab.order(HALL.order('o', base=3))
    before = lab.order_record
    lab.order(order)
    assert lab.errors == ([error] if error else [])
    assert lab.order_record == before


def test_rejections_stay_until_an_order_is_taken():
    lab = Lab()
    lab.order(way(10, 12).order('far'))
    lab.wait(10.0)
    assert lab.errors == ['noRouteError']
    lab.order(HALL.order('o'))
    assert lab.errors == []


# --- fields that the vehicle cannot obey ----------------------------------------------------------

def order_with(element, **fields):
    order = HALL.order('o')
    kind, index = element
    target = order[kind][index]
    (target['nodePosition'] if kind == 'nodes' else target).update(fields)
    return order


@pytest.mark.parametrize('order, field', [
    (order_with(('edges', 1), trajectory={'degree': 1, 'knotVector': [], 'controlPoints': []}),
     'edges[1].trajectory'),
    (order_with(('edges', 0), maxSpeed=0.3), 'edges[0].maxSpeed'),
    (order_with(('edges', 0), maxHeight=0.2), 'edges[0].maxHeight'),
    (order_with(('edges', 0), orientation=1.0), 'edges[0].orientation'),
    (order_with(('edges', 0), rotationAllowed=False), 'edges[0].rotationAllowed'),
    (order_with(('edges', 0), corridor={'leftWidth': 0.1, 'rightWidth': 1.0}), 'edges[0].corridor'),
    (order_with(('edges', 0), direction='left'), 'edges[0].direction'),
    (order_with(('nodes', 2), theta=1.0), 'nodes[2].nodePosition.theta'),
    (order_with(('nodes', 0), theta=1.0), 'nodes[0].nodePosition.theta'),
    (order_with(('nodes', 0), theta=1.0, allowedDeviationTheta=0.9), 'nodes[0].nodePosition.theta'),
    (order_with(('nodes', 2), allowedDeviationXY=0.2), 'nodes[2].nodePosition.allowedDeviationXY'),
    (order_with(('nodes', 2), mapId='hall 2'), 'nodes[2].nodePosition.mapId'),
    ({**HALL.order('o'), 'zoneSetId': 'z'}, 'zoneSetId')])
def test_what_cannot_be_honoured_is_refused_by_name(order, field):
    lab = Lab()
    lab.order(order)
    assert lab.errors == ['orderError']
    assert references(lab)['field'] == field
    assert lab.state['orderId'] == ''
    key = field.rsplit('.', 1)[-1]
    tolerant = Lab(abilities_=abilities(key))
    tolerant.driver._abilities = abilities(key)
    tolerant.order(order)
    assert tolerant.state['orderId'] == 'o', f'{key} must be ignored'


@pytest.mark.parametrize('order', [
    order_with(('edges', 0), maxSpeed=2.0), order_with(('edges', 0), length=3.0),
    order_with(('edges', 0), orientation=0.0), order_with(('edges', 0), rotationAllowed=True),
    order_with(('edges', 0), corridor={'leftWidth': 1.0, 'rightWidth': 0.5}),
    order_with(('nodes', 0), theta=0.05),
    order_with(('nodes', 0), theta=1.0, allowedDeviationTheta=1.1),
    order_with(('nodes', 0), allowedDeviationXY=0.1),
    order_with(('nodes', 2), allowedDeviationXY=0.3),
    order_with(('nodes', 2), allowedDeviationXY=0.0),
    order_with(('nodes', 2), theta=1.0, allowedDeviationTheta=math.pi)])
def test_what_is_done_anyway_is_honoured(order):
    lab = Lab()
    lab.order(order)
    assert lab.state['orderId'] == 'o', lab.state['errors']


def test_a_deviation_is_measured_from_where_the_node_is_and_not_from_its_vertex():
    beside = HALL.order('o')
    beside['nodes'][2]['nodePosition']['y'] += 0.2
    for deviation, errors in ((0.4, ['orderError']), (0.5, [])):
        lab = Lab()
        beside['nodes'][2]['nodePosition']['allowedDeviationXY'] = deviation
        lab.order(beside)
        assert lab.errors == errors


def test_the_node_at_which_an_update_joins_is_not_judged_anew():
    lab = Lab()
    lab.order(HALL.order('o', base=2))
    lab.drive(1)
    update = HALL.part(1).order('o', 1, first_sequence=2)
    update['nodes'][0]['nodePosition'].update(theta=1.0, allowedDeviationXY=0.1)
    lab.order(update)
    assert (lab.errors, lab.state['orderUpdateId']) == ([], 1)


# --- identification of places ---------------------------------------------------------------------

def test_nodes_of_other_names_are_matched_by_their_place():
    order = HALL.order('o')
    for index, node in enumerate(order['nodes']):
        node['nodeId'] = f'P{index}'
        node['nodePosition']['x'] += 0.2
    for index, edge in enumerate(order['edges']):
        edge.update(edgeId=f'E{index}', startNodeId=f'P{index}', endNodeId=f'P{index + 1}')
    lab = Lab()
    lab.order(order)
    assert lab.robot.route == (1, 2, 3, 4)
    assert lab.nodes == ['P1', 'P2', 'P3', 'P4']


@pytest.mark.parametrize('change, error', [
    (lambda o: o['nodes'][2]['nodePosition'].update(x=50.0), 'orderError'),
    (lambda o: (o['nodes'][2].update(nodeId='nowhere'), o['nodes'][2].pop('nodePosition'),
                o['edges'][1].update(endNodeId='nowhere'),
                o['edges'][2].update(startNodeId='nowhere')), 'noRouteError')])
def test_places_that_there_are_not_are_refused(change, error):
    order = HALL.order('o')
    change(order)
    lab = Lab()
    lab.order(order)
    assert lab.errors == [error]
    assert not lab.robot.routes


def test_vertices_that_no_edge_joins_are_refused():
    order = HALL.order('o')
    order['nodes'] = [order['nodes'][0], {**order['nodes'][3], 'sequenceId': 2}]
    order['edges'] = [{**order['edges'][0], 'endNodeId': '14'}]
    lab = Lab()
    lab.order(order)
    assert lab.errors == ['noRouteError']


def test_a_direction_that_the_graph_forbids_is_refused():
    edges = [replace(edge, velocity_backwards=0.0) if edge.id == 1 else edge
             for edge in laboratory().edges.values()]
    graph = Graph(laboratory().vertices.values(), edges)
    lab = Lab(driver=route_driver(graph))
    lab.order(way(8, 10).order('there'))
    assert lab.robot.route == (1,)
    lab = Lab(at=10, driver=route_driver(graph))
    lab.order(way(10, 8).order('back'))
    assert lab.errors == ['noRouteError']
    assert not lab.robot.routes


def test_an_order_may_begin_in_the_middle_of_an_edge():
    """After a cancellation, the order may begin at a new node where the robot stands."""
    lab = Lab()
    lab.see(pose=RobotPose(-10.5, 0.0, 0.0))
    order = HALL.order('o')
    order['nodes'][0]['nodeId'] = 'here'
    order['nodes'][0]['nodePosition'].update(x=-10.5, y=0.0)
    order['edges'][0]['startNodeId'] = 'here'
    lab.order(order)
    assert lab.robot.route == (1, 2, 3, 4), lab.errors


def test_a_large_deviation_of_the_first_node_lets_an_order_begin_afar():
    lab = Lab()
    lab.see(pose=RobotPose(-10.5, 0.0, 0.0))
    lab.order(HALL.order('o'))
    assert lab.errors == ['noRouteError']
    lab.order(HALL.order('p', start_deviation=3.0))
    assert lab.state['orderId'] == 'p'
    assert lab.robot.route == (1, 2, 3, 4), 'the robot stands on the first edge'


def test_a_robot_between_nodes_comes_first_to_the_first_node_of_an_order_within_its_deviation():
    lab = Lab()
    lab.see(pose=RobotPose(-10.5, 0.0, 0.0))  # on edge 1, which leads from vertex 8 to vertex 10
    lab.order(HALL.part(1, 3).order('p', start_deviation=3.0))
    assert lab.errors == []
    assert lab.robot.route == (1, 2, 3), 'the robot goes over edge 1 to the first node'
    lab.drive()
    assert len(lab.state['edgeStates']) == 2, 'edge 1 is no edge of the order'
    lab.drive()
    lab.order(HALL.part(3).order('p', 1, first_sequence=4))
    assert lab.robot.route == (1, 2, 3, 4), 'an update must extend the same route'
    lab.drive(2)
    assert lab.state['edgeStates'] == []


def test_a_robot_at_the_end_of_the_first_edge_drives_it_back_first():
    lab = Lab()
    lab.stand_at(10)
    lab.order(HALL.order('p', start_deviation=10.0))
    assert lab.robot.route == (-1, 1, 2, 3, 4)


def test_an_order_to_whose_first_node_no_edge_leads_is_refused_though_within_its_deviation():
    lab = Lab()
    x, y = laboratory().vertex(12).position
    lab.see(pose=RobotPose(x + 2.0, y + 2.0, 0.0))
    lab.order(HALL.part(2).order('p', start_deviation=50.0))
    assert lab.errors == ['noRouteError']
    assert lab.robot.route == ()


# --- actions of nodes and edges -------------------------------------------------------------------

def test_the_vehicle_stops_for_an_action_that_needs_it_and_then_drives_on():
    lab = Lab()
    lab.order(HALL.order('o', actions={'12': [say('a', 'HARD')]}))
    assert lab.robot.route == (1, 2)
    lab.drive(2)
    assert lab.status('a') == 'RUNNING'
    lab.end_action('a', text='spoken')
    assert lab.robot.route == (1, 2, 3, 4)
    assert lab.robot.routes[-1].route_id == lab.robot.routes[0].route_id


def test_an_action_beside_driving_does_not_stop_the_vehicle():
    lab = Lab()
    lab.order(HALL.order('o', actions={'12': [say('a')]}))
    assert lab.robot.route == (1, 2, 3, 4)
    lab.drive(2)
    assert lab.status('a') == 'RUNNING'


def test_the_action_of_an_edge_runs_while_the_edge_is_driven():
    lab = Lab()
    lab.order(HALL.order('o', actions={'2': [say('a')]}))
    assert lab.status('a') == 'WAITING'
    lab.drive(1)
    assert lab.status('a') == 'RUNNING'
    lab.drive(1)
    assert lab.status('a') == 'FINISHED'
    assert lab.cancelled == ['a']


def test_actions_of_the_horizon_wait_and_go_with_it():
    lab = Lab()
    lab.order(HALL.order('o', base=2, actions={'12': [say('a')]}))
    assert lab.status('a') == 'WAITING'
    lab.order(way(10, 22).order('o', 1, first_sequence=2))
    assert lab.status('a') is None


def test_the_node_at_which_an_update_joins_keeps_its_actions():
    lab = Lab()
    lab.order(HALL.order('o', base=2, actions={'10': [say('a')]}))
    lab.order(HALL.part(1).order('o', 1, first_sequence=2, actions={'10': [say('b')]}))
    assert (lab.status('a'), lab.status('b')) == ('WAITING', None)


@pytest.mark.parametrize('blocking, holds', [('NONE', False), ('SOFT', True), ('HARD', True)])
def test_a_failed_action(blocking, holds):
    lab = Lab()
    lab.order(HALL.order('o', actions={'10': [say('a', blocking)]}))
    lab.drive(1)
    lab.end_action('a', False, 'no voice')
    error = lab.state['errors'][0]
    assert (error['errorType'], error['errorLevel']) == (
        'actionError', 'FATAL' if holds else 'WARNING')
    assert references(lab) == {'topic': 'order', 'orderId': 'o', 'orderUpdateId': '0',
                               'actionId': 'a'}
    assert not lab.state['paused'], 'there was no pause'
    assert lab.nodes == ['12', '14', '32']
    if holds:
        assert lab.robot.route == (1,)
        lab.act('stopPause')
        assert lab.robot.route == (1, 2, 3, 4)
        assert lab.errors == []


@pytest.mark.parametrize('wrong', [
    {'text': 'a\nb'}, {'text': ''}, {'text': 5}, {}, {'text': 'x', 'loud': True},
    {'text': '"; stop'}])
def test_parameters_that_the_table_does_not_allow_are_refused(wrong):
    lab = Lab()
    lab.order(HALL.order('o', actions={'10': [action('say', 'a', **wrong)]}))
    assert lab.errors == ['orderError']
    ended = lab.act('say', **wrong)
    assert lab.status(ended) == 'FAILED'
    assert not lab.started


# --- instant actions ------------------------------------------------------------------------------

def test_pause_stops_at_once_and_keeps_the_order():
    lab = Lab()
    lab.order(HALL.order('o'))
    lab.drive(1)
    lab.see(velocity=DRIVING)
    pause = lab.act('startPause')
    assert lab.robot.routes[-1].edges == ()
    assert lab.status(pause) == 'RUNNING'
    lab.settle()
    assert lab.status(pause) == 'FINISHED'
    assert lab.state['paused']
    assert lab.nodes == ['12', '14', '32']
    go_on = lab.act('stopPause')
    assert lab.status(go_on) == 'FINISHED'
    assert lab.robot.route == (2, 3, 4), 'a new route must begin on the present edge'
    lab.drive(3)
    assert lab.nodes == []


def test_cancel_stops_and_empties_the_order():
    lab = Lab()
    lab.order(HALL.order('o', base=3, actions={'8': [say('runs')], '12': [say('waits', 'HARD')]}))
    lab.drive(1)
    lab.see(velocity=DRIVING)
    cancel = lab.act('cancelOrder')
    again = lab.act('cancelOrder')
    assert lab.robot.routes[-1].edges == ()
    assert (lab.status('waits'), lab.status('runs')) == ('FAILED', 'RUNNING')
    assert lab.cancelled == ['runs']
    lab.settle()
    assert lab.status(cancel) == 'RUNNING', 'an action still runs'
    lab.end_action('runs', False, 'cancelled')
    assert (lab.status(cancel), lab.status(again)) == ('FINISHED', 'FINISHED')
    assert (lab.nodes, lab.state['orderId'], lab.errors) == ([], 'o', [])
    lab.order(HALL.part(1).order('o', 1, first_sequence=2))
    assert lab.errors == ['orderUpdateError']
    lab.order(HALL.part(1).order('p', start_deviation=2.0))
    assert lab.state['orderId'] == 'p'
    assert lab.robot.route == (2, 3, 4)


def test_there_is_nothing_to_cancel():
    lab = Lab()
    cancel = lab.act('cancelOrder')
    assert lab.status(cancel) == 'FAILED'
    assert lab.errors == ['noOrderToCancel']
    assert references(lab) == {'topic': 'instantActions', 'actionId': cancel}


def test_an_instant_action_that_comes_again_is_done_once_and_answered():
    lab = Lab()
    lab.act('say', 'a', text='hello')
    states = len(lab.states)
    lab.act('say', 'a', text='hello')
    assert lab.started == ['a']
    lab.wait(1.0)
    assert len(lab.states) == states + 1


def test_an_unknown_instant_action_is_failed():
    lab = Lab()
    assert lab.status(lab.act('fly')) == 'FAILED'
    assert lab.errors == ['instantActionError']


def test_charging_needs_a_vehicle_without_an_order():
    lab = Lab()
    lab.order(HALL.order('o'))
    lab.act('startCharging', 'a', 'HARD')
    lab.drive(1)
    lab.settle()
    assert lab.status('a') == 'FAILED'
    assert not lab.started
    idle = Lab()
    idle.act('startCharging', 'a', 'HARD')
    assert idle.started == ['a']


@pytest.mark.parametrize('kind', ['startCharging', 'stopCharging'])
@pytest.mark.parametrize('blocking', ['NONE', 'SOFT', 'HARD'])
def test_charging_is_done_alone_and_standing_whatever_blocking_it_comes_with(kind, blocking):
    lab = Lab()
    lab.order(HALL.order('o', actions={'10': [action(kind, 'a', blocking), say('b')]}))
    assert lab.robot.route == (1,), lab.errors
    lab.drive(1)
    assert lab.started == ['a']
    lab.end_action('a')
    assert lab.started == ['a', 'b']
    idle = Lab()
    idle.act(kind, 'a', blocking)
    assert idle.started == ['a']


def test_waiting_is_standing_whatever_blocking_it_comes_with():
    lab = Lab()
    lab.order(HALL.order('o', actions={'10': [action('wait', 'a', 'NONE', seconds=2)]}))
    assert lab.robot.route == (1,), lab.errors


def test_an_order_waits_for_the_end_of_an_instant_action():
    """In VDA 5050, question 3 of figure 8 counts all action states."""
    lab = Lab()
    lab.act('startCharging', 'a', 'HARD')
    lab.order(HALL.order('o'))
    assert (lab.errors, lab.state['orderId']) == (['orderError'], '')
    lab.end_action('a')
    lab.order(HALL.order('o'))
    assert (lab.errors, lab.state['orderId']) == ([], 'o')
    other = Lab()
    other.act('say', 'a', text='hello')
    other.order(HALL.order('o'))
    assert other.errors == ['orderError']


def test_an_update_does_not_drive_on_from_where_an_instant_action_takes_the_robot():
    lab = Lab()
    lab.order(way(8, 10).order('o'))
    lab.drive(1)
    lab.act('startCharging', 'a', 'HARD')
    lab.order(way(10, 12).order('o', 1, first_sequence=2))
    assert (lab.errors, lab.state['orderUpdateId']) == (['orderUpdateError'], 0)


def test_no_order_is_taken_while_the_robot_is_told_where_it_is():
    lab = Lab()
    lab.act('initPosition', x=1.0, y=2.0, theta=0.5, mapId='map')
    lab.order(HALL.order('o'))
    assert lab.errors == ['orderError']


def test_a_refused_instant_action_is_told_until_another_one_is_taken():
    lab = Lab()
    lab.act('fly')
    assert lab.errors == ['instantActionError']
    lab.act('say', text='hello')
    assert lab.errors == []


def test_a_hard_instant_action_stops_the_vehicle_which_drives_on_after_it():
    lab = Lab()
    lab.order(HALL.order('o'))
    lab.drive(1)
    lab.see(velocity=DRIVING)
    lab.act('say', 'a', 'HARD', text='hello')
    assert lab.robot.routes[-1].edges == ()
    lab.settle()
    assert lab.status('a') == 'RUNNING'
    lab.end_action('a')
    assert lab.robot.route == (2, 3, 4)


def test_init_position_is_finished_when_the_robot_is_there():
    lab = Lab()
    told = lab.act('initPosition', x=1.0, y=2.0, theta=0.5, mapId='map', lastNodeId='14')
    assert fx.SetPose(RobotPose(1.0, 2.0, 0.5)) in lab.effects
    assert lab.status(told) == 'RUNNING'
    lab.see(pose=RobotPose(1.1, 2.0, 0.5))
    assert lab.status(told) == 'FINISHED'
    assert lab.state['lastNodeId'] == '14'


@pytest.mark.parametrize('before, after, ends', [
    ((0.6, 2.0, 0.5), (0.6, 2.0, 0.5), False),      # 0.4 m away, and still there
    ((0.6, 2.0, 0.5), (0.75, 2.0, 0.5), False),  # the robot has hardly moved
    ((0.6, 2.0, 0.5), (0.9, 2.0, 0.5), True),
    ((1.0, 2.0, 0.2), (1.0, 2.0, 0.2), False),      # 0.3 rad away, and still there
    ((1.0, 2.0, 0.2), (1.0, 2.0, 0.48), True),
    ((1.0, 2.05, 0.5), (1.0, 2.05, 0.5), True),  # the robot was at the requested pose before
    ((9.0, 9.0, 0.0), (1.3, 2.0, 0.6), True),  # the robot has localised itself
    ((9.0, 9.0, 0.0), (1.6, 2.0, 0.5), False)])
def test_init_position_is_finished_only_where_the_pose_has_become_the_one_that_was_told(
        before, after, ends):
    lab = Lab()
    lab.see(pose=RobotPose(*before))
    told = lab.act('initPosition', x=1.0, y=2.0, theta=0.5, mapId='map')
    lab.wait(1.0)
    lab.see(pose=RobotPose(*after))
    lab.wait(1.0)
    assert (lab.status(told) == 'FINISHED') is ends
    lab.wait(10.0)
    assert lab.status(told) == ('FINISHED' if ends else 'FAILED')


def test_init_position_refuses_a_last_node_that_there_is_not():
    lab = Lab()
    before = lab.state['lastNodeId']
    told = lab.act('initPosition', x=1.0, y=50.0, theta=0.5, mapId='map', lastNodeId='somewhere')
    assert (lab.status(told), lab.errors) == ('FAILED', ['instantActionError'])
    assert references(lab)['actionParameter'] == 'lastNodeId'
    assert lab.state['lastNodeId'] == before
    assert not [effect for effect in lab.effects if isinstance(effect, fx.SetPose)]


def test_init_position_takes_the_masters_own_name_of_a_vertex():
    lab = Lab()
    x, y = laboratory().vertex(12).position
    lab.act('initPosition', x=x, y=y, theta=0.0, mapId='map', lastNodeId='Point-0012')
    lab.see(pose=RobotPose(x, y, 0.0))
    assert lab.state['lastNodeId'] == 'Point-0012'


def test_init_position_fails_where_the_robot_does_not_take_it():
    lab = Lab()
    told = lab.act('initPosition', x=1.0, y=2.0, theta=0.5, mapId='map')
    lab.wait(11.0)
    assert lab.status(told) == 'FAILED'
    assert lab.status(lab.act('initPosition', x=1.0, y=2.0, theta=0.5, mapId='cellar')) == 'FAILED'


def test_a_log_report_tells_what_happened():
    lab = Lab()
    lab.order(HALL.order('o'))
    report = lab.act('logReport', reason='curious')
    effect = next(e for e in lab.effects if isinstance(e, fx.WriteLog))
    assert effect.reason == 'curious'
    assert any('order o' in line for line in effect.lines)
    lab.end_action(report, text='report_1.log')
    state = next(a for a in lab.state['actionStates'] if a['actionId'] == report)
    assert (state['actionStatus'], state['resultDescription']) == ('FINISHED', 'report_1.log')


# --- the times at which a state is sent -----------------------------------------------------------

def test_states_come_twice_a_second_while_it_drives_and_seldom_else():
    lab = Lab()
    lab.wait(10.0)
    before = len(lab.states)
    lab.wait(20.0)
    assert 3 <= len(lab.states) - before <= 5
    lab.order(HALL.order('o'))
    lab.see(velocity=DRIVING)
    before = len(lab.states)
    lab.wait(5.0)
    assert 9 <= len(lab.states) - before <= 12


@pytest.mark.parametrize('changes', [
    {'velocity': DRIVING}, {'e_stop': EmergencyStop.MANUAL}, {'localized': False},
    {'field_violation': True}, {'lost': 'gone', 'pose': None}])
def test_a_change_is_told_at_once(changes):
    lab = Lab()
    before = len(lab.states)
    lab.see(**changes)
    assert len(lab.states) == before + 1
    lab.see()
    assert len(lab.states) == before + 1


def test_a_broker_that_is_back_gets_factsheet_and_state():
    lab = Lab()
    before = len(lab.states)
    lab.do(lab.vehicle.connected(lab.now))
    assert len(lab.states) == before + 1
    assert fx.SendFactsheet() in lab.effects


def test_a_message_for_another_major_version_is_refused():
    lab = Lab()
    message = payload(HALL.order('o')).replace(b'"2.1.0"', b'"3.0.0"')
    lab.do(lab.vehicle.receive([('order', message)], lab.now))
    assert lab.errors == ['validationError']
    assert lab.state['velocity'] == {'vx': STANDING.vx, 'vy': 0.0, 'omega': 0.0}


# --- refused messages -----------------------------------------------------------------------------

@pytest.mark.parametrize('damage, found', [
    (lambda o: o.pop('nodes'), {'orderId': 'o', 'orderUpdateId': '3'}),
    (lambda o: o.update(nodes=[]), {'orderId': 'o', 'orderUpdateId': '3'}),
    (lambda o: o.update(orderUpdateId=-1), {'orderId': 'o'}),
    (lambda o: o.update(orderId=5), {'orderUpdateId': '3'})])
def test_a_malformed_order_is_refused_under_the_ids_that_can_be_read(damage, found):
    lab = Lab()
    order = HALL.order('o', 3)
    damage(order)
    lab.order(order)
    told = references(lab)
    assert told.pop('topic') == 'order'
    assert told.pop('field')
    assert told == found


def test_malformed_instant_actions_are_refused_as_one_message():
    """vda-5050-lib treats an error with an actionId as an error of that action alone."""
    lab = Lab()
    lab.receive_instant_actions(payload({'actions': [{'actionType': 'say', 'actionId': 'a'}]}))
    assert references(lab) == {'topic': 'instantActions', 'field': 'actions[0].blockingType'}


@pytest.mark.parametrize('key', ['manufacturer', 'serialNumber'])
def test_a_message_for_another_vehicle_is_refused(key):
    lab = Lab()
    message = {**json.loads(payload(HALL.order('o'))), key: 'another'}
    lab.receive_order(json.dumps(message).encode())
    assert (lab.errors, references(lab)['field']) == (['validationError'], key)
    action_message = {**json.loads(payload({'actions': [action('startPause', 'p')]})), key: 'other'}
    lab.receive_instant_actions(json.dumps(action_message).encode())
    assert lab.status('p') is None


def test_a_master_may_leave_the_vehicle_out_of_the_header():
    lab = Lab()
    message = {**json.loads(payload(HALL.order('o'))), 'manufacturer': '', 'serialNumber': ''}
    lab.receive_order(json.dumps(message).encode())
    assert lab.state['orderId'] == 'o'


def test_an_integer_may_be_written_as_a_number_with_a_point():
    lab = Lab()
    lab.order(HALL.part(0, 0).order('o', actions={'8': [
        action('wait', 'a', 'HARD', seconds=2.0)]}))
    started = next(effect for effect in lab.effects if isinstance(effect, fx.StartAction))
    assert started.spec.call.fields(started.arguments) == {'command': 'doTask wait 2'}
    refused = Lab()
    refused.order(HALL.part(0, 0).order('o', actions={'8': [
        action('wait', 'a', 'HARD', seconds=2.5)]}))
    assert refused.errors == ['orderError']
