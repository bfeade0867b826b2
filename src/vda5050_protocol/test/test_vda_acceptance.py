"""All of figure 8 of the standard: each combination of answers to the questions, and the result."""
from __future__ import annotations

import itertools

import pytest

from vda5050_protocol.acceptance import Held, OrderAcceptance, Rejection, judge
from vda5050_protocol.values import OrderEdge, OrderMessage, OrderNode

BASE_END, LAST = ('b', 4), ('a', 2)
SAME, OTHER = 'held', 'another'


def order(order_id, update, start):
    node_id, sequence = start
    return OrderMessage(order_id, update, (
        OrderNode(node_id, sequence, True), OrderNode('z', sequence + 2, True)),
        (OrderEdge('e', sequence + 1, True, node_id, 'z'),))


def expected(is_new, busy, near, update, start, cancelled):
    """Returns the result in the figure of 2.1.0, with the questions in its order."""
    if is_new:
        if busy:
            return 'orderError'
        return OrderAcceptance.NEW if near else 'noRouteError'
    if update < 5:
        return 'orderUpdateError'
    if update == 5:
        return OrderAcceptance.DUPLICATE
    if cancelled:
        return 'orderUpdateError'
    if busy:
        return OrderAcceptance.APPEND if start == BASE_END else 'orderUpdateError'
    return OrderAcceptance.CONTINUE if start == LAST else 'orderUpdateError'


def expected_in_3(is_new, busy, near, update, start, cancelled):
    """Returns the result in the figure of 3.0.0.

    This figure also demands orderUpdateId 0, and checks for a cancellation before a copy.
    """
    if is_new and not busy and update != 0:
        return 'INVALID_ORDER'
    if not is_new and update == 5 and cancelled:
        return 'ORDER_UPDATE_FOLLOWING_CANCEL'
    return expected(is_new, busy, near, update, start, cancelled)


TABLE = list(itertools.product(
    (True, False), (True, False), (True, False), (0, 4, 5, 6),
    (BASE_END, LAST, ('b', 2), ('a', 4), ('c', 4)), (True, False)))


@pytest.mark.parametrize('is_new, busy, near, update, start, cancelled', TABLE)
def test_the_figure(is_new, busy, near, update, start, cancelled):
    held = Held(SAME, 5, busy, cancelled, BASE_END, LAST)
    for is_3, figure in ((False, expected), (True, expected_in_3)):
        verdict = judge(held, order(OTHER if is_new else SAME, update, start), near, is_3)
        wanted = figure(is_new, busy, near, update, start, cancelled)
        if isinstance(wanted, OrderAcceptance):
            assert verdict is wanted
        else:
            assert isinstance(verdict, Rejection)
            assert wanted in (verdict.error.kind.name, verdict.error.kind.name_3)
            assert verdict.error.kind.level.value == 'WARNING'


@pytest.mark.parametrize('held, order_id, update, wanted', [
    (Held(SAME, 5, acting='say'), OTHER, 0, 'orderError'),
    (Held(SAME, 5, acting='say', last_node=LAST), SAME, 6, OrderAcceptance.CONTINUE),
    (Held(SAME, 5, moving='dock'), OTHER, 0, 'orderError'),
    (Held(SAME, 5, moving='dock', last_node=LAST), SAME, 6, 'orderUpdateError'),
    (Held(SAME, 5, moving='dock'), SAME, 5, OrderAcceptance.DUPLICATE)])
def test_an_instant_action_under_way(held, order_id, update, wanted):
    verdict = judge(held, order(order_id, update, LAST), True)
    assert getattr(verdict, 'error', None) is None or verdict.error.kind.name == wanted
    assert isinstance(verdict, Rejection) or verdict is wanted
    references = verdict.error.references if isinstance(verdict, Rejection) else ()
    assert 'actionId' not in [reference.key for reference in references], (
        'vda-5050-lib would treat it as an error of that action, and wait for the order for ever')


def test_a_vehicle_without_any_order_takes_a_new_one():
    assert judge(Held(), order('first', 0, ('a', 0)), True) is OrderAcceptance.NEW


def test_a_rejection_refers_to_order_and_update():
    verdict = judge(Held(SAME, 5), order(SAME, 4, LAST), True)
    references = {reference.key: reference.value for reference in verdict.error.references}
    assert references['orderId'] == SAME
    assert references['orderUpdateId'] == '4'
    assert references['topic'] == 'order'
