"""People read once why an order is ignored or refused, and when an emergency stop is over."""
from __future__ import annotations

import pytest
from bridge_builders import Bench, yard

from omron_ld90.bridge.order_notes import OrderNotes
from route_protocol.values import EMERGENCY_STOP, NO_REASON, Reason, ReasonCode, RouteOrder

OFF_GRAPH = Reason(ReasonCode.OFF_GRAPH, 'off the graph')


@pytest.fixture(name='bench')
def _bench() -> Bench:
    return Bench(yard(), 1)


def test_why_an_order_is_ignored_is_noted_once():
    notes = []
    order_notes = OrderNotes(notes.append)
    for reason in (OFF_GRAPH, OFF_GRAPH, NO_REASON):
        order_notes.ignored(RouteOrder(7, (1,)), reason)
    assert notes == ['Route 7 is ignored: off the graph.']


def test_an_order_whose_route_is_over_is_noted_once(bench):
    bench.order(7, 1)
    bench.run()
    for _ in range(3):
        bench.order(7, 1)
    assert bench.notes[-1:] == ['Route 7 is ignored: it is complete. Another drive needs another '
                                'id.']
    assert len([note for note in bench.notes if 'ignored' in note]) == 1


def test_in_an_emergency_stop_an_order_does_not_wait_for_what_is_unknown():
    bench = Bench(yard(), 1, links=('the link',))
    bench.link_is_up['the link'] = None
    bench.press(True)
    bench.order(7, 1)
    assert [refusal.reason for refusal in bench.refusals] == [EMERGENCY_STOP]


def test_in_an_emergency_stop_only_the_first_refusal_is_noted_and_the_end_of_it(bench):
    bench.press(True)
    for route_id in (7, 8, 9):
        bench.order(route_id, 1)
    assert [refusal.reason for refusal in bench.refusals] == [EMERGENCY_STOP] * 3
    assert bench.notes == ['Route 7 was refused: emergency stop.']
    bench.press(False)
    for route_id in (10, 11):
        bench.order(route_id, 1, 5)
    assert bench.notes[1:] == ['Route 10 is driven: the emergency stop is over.']


def test_after_an_emergency_stop_refusals_are_noted_again(bench):
    bench.press(True)
    bench.order(7, 1)
    bench.press(False)
    bench.order(8, 5)
    assert bench.notes[1:] == [f'Route 8 was refused: {bench.refusals[-1].reason}.']
