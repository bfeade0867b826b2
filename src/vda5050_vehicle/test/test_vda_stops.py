"""A cancel or a pause always reaches the robot.

The action is FINISHED only when the robot is known to stand. After another giver's stop, nothing is
driven.
"""
from __future__ import annotations

import time

import pytest
from vda_builders import DRIVING, STANDING, Lab, say, way
from vda_messages import payload

from route_protocol.values import EpochCause, Reason, ReasonCode
from vda5050_bench.track import action
from vda5050_protocol.codec_3 import VERSION_3_0
from vda5050_protocol.codecs import VERSION_2_1
from vda5050_vehicle.drivers.driver import SETTLING

HALL = way(8, 10, 12, 14, 32)
WRONG_CHANGE = Reason(ReasonCode.WRONG_CHANGE, 'no')


def under_way(**order):
    """Returns a vehicle that drives the second edge of an order."""
    lab = Lab()
    lab.order(HALL.order('o', **order))
    lab.drive(1)
    lab.see(velocity=DRIVING)
    return lab


def refuse_extension(lab, reason):
    """Extends the base, and lets the robot's side refuse the longer route."""
    lab.robot.refuses = reason
    lab.order(HALL.part(2).order('o', 1, first_sequence=4))
    assert lab.robot.routes[-1].edges == (2, 3, 4)
    lab.robot.refuses = None


# --- unknown motion does not count as standing ----------------------------------------------------

@pytest.mark.parametrize('kind', ['cancelOrder', 'startPause'])
def test_a_robot_that_hides_its_velocity_stands_when_its_side_says_so(kind):
    lab = under_way()
    lab.see(velocity=None)
    lab.robot.rolls = True
    stop = lab.act(kind)
    lab.wait(20.0)
    assert lab.robot.routes[-1].edges == ()
    assert (lab.status(stop), lab.state['driving']) == ('RUNNING', True)
    lab.robot.rolls = False
    lab.wait(0.1)
    assert (lab.status(stop), lab.state['driving']) == ('FINISHED', False)


@pytest.mark.parametrize('kind', ['cancelOrder', 'startPause'])
def test_a_velocity_from_before_the_stop_tells_nothing(kind):
    lab = Lab()
    lab.order(HALL.order('o'))
    lab.is_seen = False  # the last report says that the robot stands
    lab.robot.rolls = True
    stop = lab.act(kind)
    lab.wait(2.0)
    assert lab.status(stop) == 'RUNNING'
    lab.robot.rolls = False
    lab.wait(0.1)
    assert lab.status(stop) == 'FINISHED'


@pytest.mark.parametrize('kind', ['cancelOrder', 'startPause'])
def test_a_robot_that_is_seen_to_move_does_not_stand_though_its_side_says_so(kind):
    lab = under_way()
    stop = lab.act(kind)
    lab.wait(2.0)
    assert lab.status(stop) == 'RUNNING'
    lab.see(velocity=STANDING)
    assert lab.status(stop) == 'FINISHED'


@pytest.mark.parametrize('kind', ['cancelOrder', 'startPause'])
def test_a_stop_that_the_robot_owes_is_not_finished(kind):
    lab = under_way()
    stop = lab.act(kind)
    lab.see(velocity=STANDING)
    lab.robot.owes_stop = 'the robot has not obeyed the stop yet: lost link'
    lab.wait(5.0)
    assert lab.status(stop) == 'RUNNING'
    lab.robot.owes_stop = ''
    lab.wait(SETTLING + 0.3)
    assert lab.status(stop) == 'FINISHED'


# --- every cancel and pause reaches the robot -----------------------------------------------------

@pytest.mark.parametrize('kind', ['cancelOrder', 'startPause'])
def test_it_is_stopped_though_an_extension_of_its_route_was_refused(kind):
    lab = under_way(base=3)
    refuse_extension(lab, WRONG_CHANGE)
    lab.robot.routes.clear()
    stop = lab.act(kind)
    assert [command.edges for command in lab.robot.routes][-1:] == [()]
    assert lab.status(stop) == 'RUNNING'
    lab.settle()
    assert lab.status(stop) == 'FINISHED'


@pytest.mark.parametrize('kind', ['cancelOrder', 'startPause'])
@pytest.mark.parametrize('reason', ['taken over', 'no progress'])
def test_it_is_stopped_though_its_route_failed(kind, reason):
    lab = under_way()
    lab.robot.fail(reason)
    lab.wait(0.2)
    lab.robot.routes.clear()
    lab.act(kind)
    assert [command.edges for command in lab.robot.routes] == [()]


@pytest.mark.parametrize('kind', ['cancelOrder', 'startPause'])
def test_it_is_stopped_though_it_drives_another_route(kind):
    lab = under_way()
    lab.robot.taken_by_another_master()
    lab.wait(0.1)
    assert lab.errors == ['driveError']
    assert lab.robot.routes[-1].edges, 'the vehicle must not stop the other route without a request'
    lab.act(kind)
    assert lab.robot.routes[-1].edges == ()


def test_a_paused_vehicle_leaves_a_person_who_drives_it_alone():
    lab = under_way()
    lab.act('startPause')
    lab.settle()
    routes = len(lab.robot.routes)
    lab.see(velocity=DRIVING)
    lab.wait(5.0)
    assert len(lab.robot.routes) == routes


# --- every cancel and pause survives a crash ------------------------------------------------------

@pytest.mark.parametrize('kind', ['cancelOrder', 'startPause'])
@pytest.mark.parametrize('answers', [True, False])
def test_a_cancel_survives_a_crash(kind, answers):
    lab = under_way(actions={'12': [say('later')]})
    lab.robot.answers = answers
    stop = lab.act(kind)
    lab.robot.answers = True
    lab.robot.routes.clear()
    lab = lab.restarted()
    lab.wait(0.2)
    assert lab.status(stop) == 'RUNNING'
    assert not lab.robot.drives
    lab.settle()
    assert lab.status(stop) == 'FINISHED'
    assert lab.nodes == ([] if kind == 'cancelOrder' else ['12', '14', '32'])
    lab.wait(30.0)
    assert not [command for command in lab.robot.routes if command.edges]


# --- stops with an actionId that is already known -------------------------------------------------

@pytest.mark.parametrize('kind', ['cancelOrder', 'startPause'])
@pytest.mark.parametrize('codec', [VERSION_2_1, VERSION_3_0])
def test_a_stop_under_an_action_id_of_before_is_done(kind, codec):
    lab = Lab(codec=codec)
    lab.act(kind, 'x')
    lab.settle()
    lab.act('stopPause')
    lab.order(way(8, 10).order('a'))
    lab.drive(1)
    lab.act(kind, 'x')
    lab.settle()
    lab.act('stopPause')
    lab.order(way(10, 12).order('b'))
    assert lab.robot.drives
    lab.see(velocity=DRIVING)
    lab.act(kind, 'x')
    assert not lab.robot.drives
    assert (lab.errors != []) is codec.is_3, 'the vehicle must keep ended actions and their ids'
    lab.settle()
    assert (lab.nodes == []) is (kind == 'cancelOrder')


def test_a_cancel_under_the_id_of_an_action_of_the_order_is_done_and_told():
    lab = under_way(actions={'14': [say('x')]})
    lab.act('cancelOrder', 'x')
    assert not lab.robot.drives
    lab.settle()
    assert lab.nodes == []
    assert lab.status('x') == 'FAILED', 'this action was cancelled with its order'
    assert 'instantActionError' in lab.errors


def test_a_cancel_that_comes_twice_is_done_once():
    lab = under_way()
    message = payload({'actions': [action('cancelOrder', 'x')]}, 7)
    lab.receive_instant_actions(message)
    lab.settle()
    stops = len(lab.robot.routes)
    lab.receive_instant_actions(message)
    assert (lab.status('x'), lab.errors, len(lab.robot.routes)) == ('FINISHED', [], stops)


# --- nothing is driven after a person's stop ------------------------------------------------------

@pytest.mark.parametrize('code', [
    ReasonCode.TAKEN_OVER, ReasonCode.OVERRULED, ReasonCode.WRONG_CHANGE, ReasonCode.OTHER])
def test_a_refusal_that_is_heard_before_the_failure_begins_no_route(code):
    lab = under_way(base=3)
    refuse_extension(lab, Reason(code, 'no'))
    lab.robot.overruled()
    lab.see(velocity=STANDING)
    routes = [command for command in lab.robot.routes if command.edges]
    lab.wait(10.0)
    assert [command for command in lab.robot.routes if command.edges] == routes
    assert lab.errors == ['driveError']
    lab.act('stopPause')
    assert lab.robot.drives


def at_an_action(last=None):
    """Returns a vehicle that waits for an action of a node, and drives on when the action ends."""
    lab = Lab()
    lab.order(HALL.order('o', actions={'10': [say('a', 'HARD'), last or say('b', 'HARD')]}))
    lab.drive(1)
    assert lab.errors == []
    lab.end_action('a')
    return lab


def test_a_robot_that_was_stopped_while_it_stood_is_not_driven_on():
    lab = under_way(base=2)
    lab.see(velocity=STANDING)
    lab.robot.overruled(EpochCause.STOP)
    lab.wait(0.1)
    lab.order(HALL.part(1).order('o', 1, first_sequence=2))
    lab.wait(5.0)
    assert lab.errors == ['driveError']
    assert lab.robot.route == (1,)
    lab.act('stopPause')
    assert (lab.errors, lab.robot.drives) == ([], True)


def test_a_robot_that_was_stopped_while_it_stood_is_not_driven_on_by_an_order_that_was_faster():
    lab = under_way(base=2)
    lab.see(velocity=STANDING)
    lab.robot.overruled(EpochCause.STOP)
    lab.order(HALL.part(1).order('o', 1, first_sequence=2))
    lab.wait(5.0)
    assert lab.errors == ['driveError']
    assert lab.robot.route == (1,)


@pytest.mark.parametrize('cause', [EpochCause.RESTART, EpochCause.LOST_LINK])
def test_a_robot_that_only_forgot_its_orders_while_it_stood_is_driven_on(cause):
    lab = under_way(base=2)
    lab.see(velocity=STANDING)
    lab.robot.overruled(cause)
    lab.wait(0.1)
    lab.order(HALL.part(1).order('o', 1, first_sequence=2))
    assert (lab.errors, lab.robot.drives) == ([], True)


def test_an_epoch_of_its_own_action_holds_nothing():
    lab = at_an_action(action('wait', 'b', 'HARD', seconds=5))
    lab.robot.overruled()  # by the action
    lab.wait(0.1)
    lab.end_action('b')
    assert (lab.errors, lab.robot.drives) == ([], True)
    assert lab.robot.routes[-1].epoch == lab.robot.vehicle.state.epoch


def test_a_person_who_stops_the_robot_while_it_speaks_holds_it():
    lab = at_an_action()
    lab.robot.overruled()  # the action `say` does not explain a new epoch
    lab.wait(0.1)
    lab.end_action('b')
    lab.wait(5.0)
    assert lab.errors == ['driveError']
    assert len(lab.robot.routes) == 1


def test_an_order_that_is_repeated_keeps_its_number_and_its_epoch():
    lab = Lab()
    lab.robot.answers = False
    lab.order(HALL.order('o'))
    known = lab.robot.vehicle.state.epoch
    lab.robot.overruled()
    lab.wait(3.0)
    assert len(lab.robot.routes) > 1
    assert {(one.number, one.epoch) for one in lab.robot.routes} == {
        (lab.robot.routes[0].number, known)}


@pytest.mark.parametrize('standing, velocity, rests, ended', [
    (True, None, False, True), (True, STANDING, False, True), (False, STANDING, False, False),
    (True, DRIVING, False, False), (None, None, False, True), (None, None, True, True)])
def test_a_robot_that_tells_of_its_motion_stands_where_nothing_says_otherwise(
        standing, velocity, rests, ended):
    lab = under_way()
    stop = lab.act('startPause')
    lab.see(standing=standing, velocity=velocity, rests=rests)
    lab.wait(3.0)
    assert (lab.status(stop) == 'FINISHED') is ended


# --- the cost of an event -------------------------------------------------------------------------

def test_an_event_in_an_order_of_a_thousand_nodes_costs_under_two_milliseconds():
    lab = Lab()
    track = way(8, *[10, 8] * 500)
    lab.order(track.order('long', base=1000, actions={'10': []}))
    assert len(lab.nodes) == 1000
    costs = []
    for _ in range(30):
        lab.robot.percentage += 3.0
        lab.now += 0.1
        report = lab.robot.report()
        begun = time.process_time()
        lab.driver.on_report(report, lab.now)
        lab.vehicle.tick(lab.now)
        lab.vehicle.robot_seen(lab.view, lab.now)
        costs.append(time.process_time() - begun)
        if lab.robot.percentage > 80.0:
            lab.robot.done, lab.robot.percentage = lab.robot.done + 1, 0.0
    assert sorted(costs)[len(costs) // 2] < 2 * 0.002, costs  # two events each
