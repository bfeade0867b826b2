"""A stop does not wait for the messages before it: waiting messages are processed together."""
from __future__ import annotations

import pytest
from vda_builders import SAY, Lab, way
from vda_messages import payload

from vda5050_bench.track import action
from vda5050_protocol.action_queue import MAX_ENDED_INSTANT_ACTIONS, MAX_INSTANT_ACTIONS
from vda5050_vehicle.core import effects as fx

HALL = way(8, 10, 12, 14, 32)
MANY = 300


def messages(kind, number, **parameters):
    """Returns messages with one instant action each, and after them a message with a stop."""
    found = [payload({'actions': [action(kind, f'a{i}', **parameters)]}, 100 + i)
             for i in range(number)]
    return [('instantActions', message) for message in (
        *found, payload({'actions': [action('startPause', 'stop')]}, 999))]


@pytest.mark.parametrize('kind, parameters', [('stateRequest', {}), ('say', SAY)])
def test_messages_that_wait_together_cost_one_state_and_one_record_of_the_journal(kind, parameters):
    lab = Lab()
    lab.order(HALL.order('o'))
    effects = lab.vehicle.receive(messages(kind, MANY, **parameters), lab.now)
    assert sum(isinstance(effect, fx.SendState) for effect in effects) == 1
    assert sum(isinstance(effect, fx.Keep) for effect in effects) == 1
    lab.do(effects)
    assert not lab.robot.drives
    assert lab.state['paused']


def test_they_have_the_effects_that_they_have_one_by_one():
    sent = [('order', payload(HALL.order('o'), 1)),
            ('instantActions', payload({'actions': [action('startPause', 'p')]}, 2)),
            ('instantActions', payload({'actions': [action('stopPause', 'q')]}, 3)),
            ('order', payload(HALL.order('another'), 4)),
            ('instantActions', payload({'actions': [action('cancelOrder', 'c')]}, 5))]
    together, singly = Lab(), Lab()
    together.do(together.vehicle.receive(sent, together.now))
    for message in sent:
        singly.do(singly.vehicle.receive([message], singly.now))
    assert together.order_record == singly.order_record
    assert [(one.number, one.edges) for one in together.robot.routes] == [
        (one.number, one.edges) for one in singly.robot.routes]
    assert together.errors == singly.errors


def test_a_cancellation_and_the_next_order_may_come_together_for_a_robot_that_stands():
    lab = Lab()
    lab.order(HALL.order('o', base=1))
    lab.do(lab.vehicle.receive([
        ('instantActions', payload({'actions': [action('cancelOrder', 'c')]}, 7)),
        ('order', payload(HALL.order('p'), 8))], lab.now))
    assert (lab.errors, lab.state['orderId']) == ([], 'p')


def test_the_number_of_instant_actions_under_way_is_limited_but_not_that_of_stops():
    lab = Lab()
    lab.order(HALL.order('o'))
    for number in range(MAX_INSTANT_ACTIONS + 5):
        lab.act('say', f'a{number}', **SAY)
    assert lab.status(f'a{MAX_INSTANT_ACTIONS - 1}') == 'RUNNING'
    assert lab.status(f'a{MAX_INSTANT_ACTIONS + 4}') == 'FAILED'
    assert len(lab.started) == MAX_INSTANT_ACTIONS
    lab.act('startPause', 'stop')
    assert not lab.robot.drives


def test_a_message_of_very_many_actions_leaves_a_state_of_limited_size():
    lab = Lab()
    lab.receive_instant_actions(payload({'actions': [
        action('say', f'a{number}', **SAY) for number in range(1000)]}, 1))
    # the last action ends after the oldest ended actions were dropped
    assert len(lab.state['actionStates']) <= MAX_INSTANT_ACTIONS + MAX_ENDED_INSTANT_ACTIONS + 1
