"""Numbered orders keep all invariants in every sequence of events, and each rule is needed."""
from __future__ import annotations

import pytest
from numbered_orders_model import RULES, Bounds, Model, Order, State
from proofs import LONG, is_whole

WHOLE = is_whole(__file__)
MOST = None if WHOLE else 20_000  # number of states that a search visits, the nearest first

BOUNDS = {
    'two orders': Bounds(),
    'another master': Bounds(orders=2, edges=1, reports=2, others=1),
    'another master, briefly': Bounds(orders=1, edges=1, reports=1, others=1),
    'old masters': Bounds(orders=1, edges=1, reports=1, old=2),
    'an older journal': Bounds(orders=3, epochs=1, reports=2, restores=1),
    'an older journal and restarts': Bounds(edges=1, reports=2, restores=1),
}
if LONG:
    BOUNDS.update({
        'another master, and back': Bounds(orders=1, edges=1, reports=2, others=1, epochs=3),
        'three orders': Bounds(orders=3, reports=2),
        'two orders of another master': Bounds(orders=1, others=2, reports=2),
        'another master and an older journal': Bounds(edges=1, reports=2, others=1, restores=1),
        'both other masters and an older journal': Bounds(edges=1, reports=1, others=1, old=1,
                                                          restores=1),
        'an older journal, restarts and three orders': Bounds(orders=3, edges=1, reports=2,
                                                              restores=1),
    })
NEEDED_IN = {
    'epoch': 'two orders',
    'takeover': 'another master',
    'stamp': 'old masters',
    'command': 'another master, briefly',
    'owner': 'another master',
    'moved': 'another master',
    'older': 'an older journal',
    'gap': 'an older journal',
    'accepted': 'an older journal',
    'clock': 'an older journal',
}
ALONE = Bounds(epochs=1, reports=2)  # no restarts, no other masters: enough for nearly all rules


@pytest.mark.parametrize('name', BOUNDS)
def test_no_order_of_events_brings_a_vehicle_outside_its_allocation(name, capsys):
    found = Model().search(BOUNDS[name], MOST)
    with capsys.disabled():
        print(f'\n{name}: {found.states} states')
    assert not found.flaw, str(found)


@pytest.mark.parametrize('bounds', [
    Bounds(orders=1), ALONE, BOUNDS['another master, briefly'], BOUNDS['old masters'],
    Bounds(edges=1, reports=1, restores=1), *([Bounds(reports=2)] if LONG else [])])
def test_every_vehicle_can_be_brought_to_a_new_edge(bounds):
    found = Model().search(bounds, MOST, live=True)
    assert not found.flaw, str(found)


@pytest.mark.parametrize('rule', RULES)
def test_without_any_one_of_its_rules_the_search_finds_a_violation(rule):
    bounds = BOUNDS[NEEDED_IN[rule]] if rule in NEEDED_IN else ALONE
    found = Model(rule).search(bounds, MOST, live=rule == 'command')
    assert found.flaw, f'nothing goes wrong in {found.states} states without: {RULES[rule]}'
    assert found.way, 'the search tells no way to the violation'


def test_the_way_to_a_violation_is_a_shortest_one():
    """An order is sent but not stored, arrives, and the master restarts without knowing it."""
    assert len(Model('commit').search(ALONE).way) == 3


def test_the_search_visits_orders_whose_beginning_is_driven_already():
    def continues_inside(state: State, order: Order) -> bool:
        vehicle = state.vehicle
        after = Model().obey(vehicle, order)
        return 0 < vehicle.order < after.order and bool(after.route) and vehicle.done > order.first

    assert _some_state_has(continues_inside)


def test_the_search_visits_a_late_order_from_before_a_failure():
    """The late order is longer than the failed order. The vehicle takes it, because it is newer."""
    def revives(state: State, order: Order) -> bool:
        after = Model().obey(state.vehicle, order)
        return state.vehicle.failed and bool(after.route)

    assert _some_state_has(revives)


def _some_state_has(wanted) -> bool:
    """Returns whether, within small bounds, a state has an order for which `wanted` is true."""
    model, seen, waiting = Model(), {State()}, [State()]
    while waiting:
        state = waiting.pop()
        if any(wanted(state, order) for order in state.orders):
            return True
        new = {after for _, after in model.steps(state, ALONE)} - seen
        seen |= new
        waiting.extend(new)
    return False
