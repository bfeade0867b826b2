"""Messages that arrive twice have an effect only once, even if the copy comes very late."""
from __future__ import annotations

import pytest
from vda_builders import SAY, Lab, say, way
from vda_messages import payload

from vda5050_bench.track import action
from vda5050_protocol.received import REMEMBERED, ReceivedMessages


def driven(lab, order):
    """Sends an order, and drives it to its end; returns its message."""
    message = lab.order(order)
    while lab.robot.drives:
        lab.drive(1)
    for action_id in lab.started:
        lab.end_action(action_id)
    lab.wait(0.1)
    return message


def there_and_back():
    """Returns a vehicle that has driven two orders and stands where the first order begins."""
    lab = Lab(at=8)
    first = driven(lab, way(8, 10).order('there', actions={'8': [say('a')]}))
    driven(lab, way(10, 8).order('back'))
    return lab, first


def test_a_copy_of_an_order_that_was_driven_long_ago_is_refused():
    lab, first = there_and_back()
    routes = list(lab.robot.routes)
    lab.receive_order(first)
    lab.wait(1.0)
    assert lab.errors == ['orderError']
    assert 'is a copy' in lab.state['errors'][0]['errorDescription']
    assert (lab.state['orderId'], lab.robot.routes, lab.started) == ('back', routes, ['a'])


def test_it_is_refused_by_a_restarted_adapter_too():
    lab, first = there_and_back()
    lab = lab.restarted()
    lab.receive_order(first)
    assert lab.errors == ['orderError']
    assert lab.state['orderId'] == 'back'


def test_a_master_that_sends_the_order_anew_gets_it_driven():
    lab, _ = there_and_back()
    driven(lab, way(8, 10).order('there'))
    assert (lab.state['orderId'], lab.state['lastNodeId'], lab.errors) == ('there', '10', [])


def test_an_order_that_was_refused_may_come_again():
    lab = Lab(at=10)
    message = payload(way(8, 10).order('o'), 7)
    lab.receive_order(message)
    assert lab.errors == ['noRouteError']
    lab.stand_at(8)
    lab.receive_order(message)
    assert (lab.errors, lab.nodes) == ([], ['10'])


@pytest.mark.parametrize('kind, parameters', [('stopPause', {}), ('say', SAY)])
def test_a_copy_of_an_instant_action_is_not_done_again(kind, parameters):
    lab = Lab(at=8)
    message = payload({'actions': [action(kind, 'i', **parameters)]}, 7)
    lab.receive_instant_actions(message)
    if lab.started:
        lab.end_action('i')
    lab.order(way(8, 10).order('o'))  # a new order makes the vehicle forget the instant action
    lab.act('startPause')
    lab.settle()
    started = list(lab.started)
    lab.receive_instant_actions(message)
    assert lab.status('i') == 'FAILED'
    assert lab.state['paused']
    assert lab.started == started


@pytest.mark.parametrize('kind', ['cancelOrder', 'startPause'])
def test_a_copy_that_stops_the_vehicle_stops_it(kind):
    lab = Lab(at=8)
    message = payload({'actions': [action(kind, 'i')]}, 7)
    lab.receive_instant_actions(message)
    lab.act('stopPause')
    lab.order(way(8, 10, 12).order('o'))
    assert lab.robot.drives
    lab.receive_instant_actions(message)
    assert not lab.robot.drives


def test_only_the_newest_messages_are_remembered():
    received = ReceivedMessages()
    for number in range(REMEMBERED + 1):
        received = received.with_message(b'%d' % number)
    assert b'0' not in received
    assert b'1' in received
    assert b'1' in ReceivedMessages(received.digests)
