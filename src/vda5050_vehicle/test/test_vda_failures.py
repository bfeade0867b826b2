"""Faults during an order: the order stays, the error is reported, and only a master drives on."""
from __future__ import annotations

import pytest
from vda_builders import DRIVING, STANDING, Lab, say, way

from route_protocol.values import EpochCause, Reason, ReasonCode, SymbolicPose
from vda5050_protocol.values import EmergencyStop
from vda5050_vehicle.drivers.robot_view import RobotPose, silence
from vda5050_vehicle.drivers.route_driver import PATIENCE

HALL = way(8, 10, 12, 14, 32)


def failed(reason: str = 'no progress for 30 s') -> Lab:
    """Returns a vehicle whose route failed after one edge."""
    lab = Lab()
    lab.order(HALL.order('o', base=4))
    lab.drive(1)
    lab.robot.fail(reason)
    lab.see(velocity=STANDING)
    lab.wait(0.2)
    return lab


@pytest.mark.parametrize('reason', [
    'emergency stop', 'lost link: outgoing: closed', 'taken over', 'no progress for 30 s'])
def test_a_failed_route_holds_the_vehicle_and_keeps_its_order(reason):
    lab = failed(reason)
    error = lab.state['errors'][0]
    assert (error['errorType'], error['errorLevel']) == ('driveError', 'FATAL')
    assert error['errorDescription'] == reason
    assert lab.nodes == ['12', '14', '32']
    assert not lab.state['paused'], 'there was no pause'
    routes = len(lab.robot.routes)
    lab.wait(60.0)
    assert len(lab.robot.routes) == routes, 'a motion was repeated without a master'


def test_stop_pause_drives_on_from_the_edge_it_is_on():
    lab = failed()
    assert lab.status(lab.act('stopPause')) == 'FINISHED'
    assert lab.errors == []
    assert not lab.state['paused']
    assert lab.robot.route == (2, 3)
    assert lab.robot.routes[-1].route_id != lab.robot.routes[0].route_id
    lab.drive(2)
    assert lab.nodes == ['32']


def test_an_update_extends_a_held_order_but_does_not_drive_it():
    lab = failed()
    routes = len(lab.robot.routes)
    lab.order(HALL.part(3).order('o', 1, first_sequence=6))
    lab.wait(5.0)
    assert lab.state['orderUpdateId'] == 1
    assert len(lab.robot.routes) == routes
    lab.act('stopPause')
    assert lab.robot.route == (2, 3, 4)


def test_a_held_order_is_cancelled_and_another_one_drives():
    lab = failed()
    cancel = lab.act('cancelOrder')
    assert lab.robot.routes[-1].edges == ()
    lab.settle()
    assert lab.status(cancel) == 'FINISHED'
    assert (lab.nodes, lab.errors) == ([], [])
    lab.order(HALL.part(1).order('p', start_deviation=2.0))
    assert lab.robot.route == (2, 3, 4)


def test_an_emergency_stop_is_told_and_stop_pause_waits_for_its_release():
    lab = failed('emergency stop')
    lab.see(e_stop=EmergencyStop.MANUAL)
    assert lab.state['safetyState']['eStop'] == 'MANUAL'
    assert set(lab.errors) == {'driveError', 'emergencyStop'}
    routes = len(lab.robot.routes)
    assert lab.status(lab.act('stopPause')) == 'FAILED'
    lab.see(e_stop=EmergencyStop.NONE)
    lab.wait(5.0)
    assert len(lab.robot.routes) == routes, 'the release of the stop must not start a drive'
    assert lab.status(lab.act('stopPause')) == 'FINISHED'
    assert lab.robot.route == (2, 3)


def test_a_robot_that_is_lost_has_no_pose_and_is_said_to_be():
    lab = Lab()
    lab.see(pose=None, velocity=None, lost='nothing was heard for 3 s')
    assert 'agvPosition' not in lab.state
    assert 'velocity' not in lab.state
    error = lab.state['errors'][0]
    assert (error['errorType'], error['errorLevel']) == ('vehicleConnectionError', 'FATAL')
    lab.order(HALL.order('o'))
    assert 'noRouteError' in lab.errors, 'it is unknown where an order would begin'
    lab.see(pose=RobotPose(-12.0, 0.0, 0.0), velocity=STANDING, lost='')
    assert lab.errors == ['noRouteError']


def test_no_state_is_sent_before_the_robot_was_heard_or_is_lost():
    """A FATAL error in the first state after each start would make masters fail a mission.

    A first state without an error would tell masters that the vehicle takes orders.
    """
    lab = Lab(at=None)
    lab.do(lab.vehicle.connected(lab.now))
    lab.see()
    pause = lab.act('stopPause')
    lab.wait(1.0)
    assert lab.states == []
    lab.see(lost='the robot has not reported its pose yet')
    assert lab.errors == ['instantActionError', 'vehicleConnectionError']
    assert lab.status(pause) == 'FAILED'


def test_the_first_state_after_a_start_has_the_pose_of_the_robot():
    lab = Lab(at=None)
    lab.do(lab.vehicle.connected(lab.now))
    lab.stand_at(8)
    assert len(lab.states) == 1
    assert (lab.state['lastNodeId'], lab.errors) == ('8', [])
    assert 'agvPosition' in lab.state


@pytest.mark.parametrize('heard_at, now, words', [
    (None, 102.9, ''), (None, 103.1, 'yet'), (101.0, 103.5, ''), (101.0, 104.1, 'for 3 s')])
def test_a_robot_is_lost_once_it_was_silent_for_its_time(heard_at, now, words):
    text = silence(heard_at, since=100.0, now=now, timeout=3.0)
    assert bool(text) == bool(words)
    assert words in text


@pytest.mark.parametrize('changes', [
    {'e_stop': EmergencyStop.MANUAL}, {'lost': 'silent', 'pose': None}, {'localized': False}])
def test_an_error_of_the_robot_is_told_as_none_of_an_order(changes):
    """vda-5050-lib treats an error without references as a rejection of its last order."""
    lab = Lab()
    lab.see(**changes)
    assert lab.state['errors'][0]['errorReferences'] == [
        {'referenceKey': 'topic', 'referenceValue': 'state'}]


def test_a_robot_that_does_not_know_where_it_is():
    lab = Lab()
    lab.see(localized=False)
    assert lab.errors == ['localizationError']
    assert lab.state['agvPosition']['positionInitialized'] is False


def test_a_route_that_nobody_answers_is_repeated_unchanged_and_then_given_up():
    lab = Lab()
    lab.robot.answers = False
    lab.order(HALL.order('o'))
    lab.wait(PATIENCE + 2.0)
    driven = [command for command in lab.robot.routes if command.edges]
    assert len(set(driven)) == 1
    assert len(driven) >= PATIENCE - 2.0
    assert lab.errors == ['driveError']
    assert lab.robot.routes[-1].edges == (), 'a stop must follow, in case the route arrives late'


def test_a_refused_route_holds_the_vehicle():
    lab = Lab()
    lab.robot.refuses = Reason(ReasonCode.OFF_GRAPH, 'off the graph')
    lab.order(HALL.order('o'))
    lab.wait(0.1)
    assert lab.state['errors'][0]['errorDescription'] == 'off the graph'
    assert lab.nodes == ['10', '12', '14', '32']


def test_an_extension_of_a_route_that_the_robot_has_left_holds_the_vehicle():
    """Only a master may decide how the robot comes back to the end of its base."""
    lab = Lab()
    lab.order(HALL.order('o', base=2))
    lab.drive(1)
    lab.robot.refuses = Reason(ReasonCode.STARTS_ELSEWHERE, 'not at its end')
    lab.order(HALL.part(1).order('o', 1, first_sequence=2))
    lab.wait(0.1)
    assert lab.errors == ['driveError']
    lab.robot.refuses = None
    lab.wait(5.0)
    assert not lab.robot.drives
    lab.act('stopPause')
    assert lab.robot.drives
    lab.drive(3)
    assert lab.nodes == []


def test_an_order_that_was_refused_is_not_given_again_with_the_next_one():
    lab = Lab()
    lab.robot.refuses = Reason(ReasonCode.OTHER, 'no, I say')
    lab.order(HALL.order('o'))
    lab.wait(0.1)
    lab.robot.refuses = None
    assert lab.errors == ['driveError']
    lab.act('cancelOrder')
    lab.settle()
    lab.order(way(8, 10).order('p'))
    assert lab.robot.route == (1,)


@pytest.mark.parametrize('cause, words', [
    (EpochCause.OTHER_GIVER, 'another program or person'), (EpochCause.STOP, 'another program'),
    (EpochCause.EMERGENCY_STOP, 'another program'), (EpochCause.RESTART, 'does not know its route'),
    (EpochCause.LOST_LINK, 'does not know its route')])
def test_the_cause_of_a_new_epoch_is_told_where_the_route_has_no_reason(cause, words):
    lab = Lab()
    lab.order(HALL.order('o'))
    lab.drive(1)
    lab.robot.overruled(cause, Reason(ReasonCode.OTHER, ''))
    lab.wait(0.1)
    assert words in lab.state['errors'][0]['errorDescription']


def test_another_master_on_the_robot_holds_the_vehicle():
    lab = Lab()
    lab.order(HALL.order('o'))
    lab.drive(1)
    lab.robot.taken_by_another_master()
    lab.wait(0.1)
    assert 'another program or person' in lab.state['errors'][0]['errorDescription']


def test_a_robot_of_another_master_is_stopped_before_it_drives_for_this_one():
    lab = Lab()
    lab.robot.taken_by_another_master()
    lab.wait(0.1)
    lab.order(HALL.order('o'))
    assert [command.edges for command in lab.robot.routes] == [()]
    assert not lab.robot.drives
    lab.wait(0.2)
    assert lab.robot.route == (1, 2, 3, 4)
    assert lab.errors == []


def test_after_the_order_others_may_use_the_robot():
    lab = Lab()
    lab.order(way(8, 10).order('o'))
    lab.drive(1)
    lab.robot.taken_by_another_master()
    lab.wait(5.0)
    assert lab.errors == []


def test_a_vertex_passed_while_the_robot_stops_counts_as_passed():
    lab = Lab()
    lab.order(HALL.order('o'))
    lab.drive(1)
    lab.see(velocity=DRIVING)
    lab.robot.percentage = 95.0
    lab.wait(0.1)
    lab.act('startPause')
    lab.robot.place = SymbolicPose(3, 2.0)
    lab.settle()
    assert lab.state['lastNodeId'] == '12'
    lab.act('stopPause')
    assert lab.robot.route == (3, 4)


@pytest.mark.parametrize('edge, percentage, passed', [
    (2, 99.0, True), (-2, 1.0, True), (3, 0.5, True), (2, 60.0, False)])
def test_a_robot_that_rolls_to_the_end_of_its_base_while_it_stops_has_driven_it(
        edge, percentage, passed):
    """The bridge refuses a route over an edge at whose end the robot stands."""
    lab = Lab()
    lab.order(HALL.order('o', base=3))
    lab.drive(1)
    lab.see(velocity=DRIVING)
    lab.act('startPause')
    lab.robot.place = SymbolicPose(edge, percentage)
    lab.settle()
    assert (lab.state['lastNodeId'] == '12') is passed
    routes = len(lab.robot.routes)
    lab.act('stopPause')
    assert len(lab.robot.routes) == routes + (0 if passed else 1)
    lab.order(HALL.part(2).order('o', 1, first_sequence=4))
    assert lab.robot.route == ((3, 4) if passed else (2, 3, 4))


def test_a_pause_during_an_action_lets_it_end_but_starts_no_other():
    lab = Lab()
    lab.order(HALL.order('o', actions={'8': [say('a', 'HARD'), say('b', 'HARD')]}))
    lab.act('startPause')
    lab.end_action('a')
    assert lab.status('b') == 'WAITING'
    lab.act('stopPause')
    assert lab.status('b') == 'RUNNING'
    lab.end_action('b')
    assert lab.robot.route == (1, 2, 3, 4)
