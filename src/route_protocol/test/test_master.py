"""The master's end of the route protocol, in every state of the model of numbered orders.

The search and the vehicle come from the model, but the master is the real one. The master's state
is part of each state that the search visits, and the master's functions process each report, order
and restart. So the search checks the invariants on the code that the fleet manager runs.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Callable, Dict, Iterator, NamedTuple, Optional, Set, Tuple

import pytest
from numbered_orders_model import (
    ME,
    NOBODY,
    Bounds,
    Edge,
    Model,
    Motion,
    Order,
    Report,
    State,
    where_it_is,
)
from proofs import LONG, is_whole

from route_protocol import master as real
from route_protocol import values
from route_protocol.messages import WrongReport

WHOLE = is_whole(__file__)
MOST = None if WHOLE else 10_000  # number of states that a search visits, the nearest first
_BASE = 2000  # greater than each label and each place

Change = Callable[[real.MasterState, real.MasterState], real.MasterState]
"""Returns a wrong state after a report, from the states before and after it."""
Reading = Callable[[values.RouteReport, real.MasterState], values.RouteReport]
"""Returns a wrong report, from the report that arrived and the state of the master."""


def number_of(edge: Edge) -> int:
    """Returns the signed id that stands for an edge of the model."""
    return (edge.label * _BASE + edge.origin) * _BASE + edge.destination


def edge_of(id: int) -> Edge:
    rest, destination = divmod(id, _BASE)
    return Edge(*divmod(rest, _BASE), destination)


class RealMaster(NamedTuple):
    """The real state, and where the newest report says that the vehicle is."""

    state: real.MasterState
    place: Optional[int] = 0
    edge: Optional[Edge] = None

    epoch = property(lambda self: self.state.epoch)
    sequence = property(lambda self: self.state.report)
    number = property(lambda self: self.state.number)
    done = property(lambda self: self.state.done)
    held = property(lambda self: self.state.held)
    anywhere = property(lambda self: self.state.is_anywhere)
    unknown = property(lambda self: self.state.unknown)
    commands = property(lambda self: self.state.commands)
    gap = property(lambda self: self.state.gap)

    @property
    def open(self) -> Tuple[Order, ...]:
        return tuple(Order(one.number, one.epoch, one.first, tuple(map(edge_of, one.edges)))
                     for one in self.state.open)


class WithRealMaster(Model):
    """The model with the real master.

    change, reading -- functions that plant a fault: `change` makes the state after a report wrong;
                       `reading` makes a report wrong before the master reads it
    """

    def __init__(self, change: Change = lambda before, after: after,
                 reading: Reading = lambda said, state: said) -> None:
        super().__init__()
        self._change, self._reading = change, reading

    def first_master(self, gap: Tuple[int, int] = (0, 0), unknown: int = 0) -> RealMaster:
        return RealMaster(real.MasterState(epoch=1, commands=True, gap=gap, unknown=unknown))

    def _next_number(self, master: RealMaster, drawn: int) -> int:
        return real.next_number(master.state, drawn + 1)

    def allocation(self, master: RealMaster) -> Set[Edge]:
        edges = {edge_of(step.edge) for step in master.state.may_be_on}
        return edges if master.edge is None else edges | {master.edge}

    def hear(self, master: RealMaster, said: Report, drawn: int) -> RealMaster:
        report = self._reading(as_sent(said, master.state), master.state)
        after, news = real.hear(master.state, report, ME, drawn + 1)
        if not news.is_new:
            return master
        return RealMaster(self._change(master.state, after), said.place, said.edge)

    def give(self, master: RealMaster, order: Order) -> RealMaster:
        if order.edges:
            ids = tuple(map(number_of, order.edges))
            state = real.give_route(master.state, order.number, ids, 0)
        else:
            state = real.give_stop(master.state, order.number, 0)
        return master._replace(state=state)

    def end(self, master: RealMaster) -> Optional[Tuple[int, Tuple[Edge, ...], int]]:
        state = master.state
        if not state.is_ready or state.is_stopping:
            return None
        if not state.ahead:
            return where_it_is(master)
        edges = tuple(map(edge_of, state.ahead))
        return state.done, edges, edges[-1].destination

    def new_orders(self, state: State, bounds: Bounds) -> Iterator[Tuple[str, Order, int]]:
        for name, order, labels in super().new_orders(state, bounds):
            known = state.master.state
            if name == 'shorten':
                edges = tuple(map(edge_of, known.ahead[:-1]))
                if not edges:
                    continue
                order = order._replace(first=known.done, edges=edges)
            elif name == 'stop':
                order = order._replace(first=known.done)
            yield name, order, labels


def as_sent(said: Report, state: real.MasterState) -> values.RouteReport:
    """Returns the model's report in the form in which a vehicle sends it.

    The model's report lacks the edges of the order that it shows. The master's state has them.
    """
    shown = next((one for one in state.open if one.number == said.order and one.edges), None)
    complete, ahead = values.EdgeState.COMPLETE, values.EdgeState.PROCESSING
    if shown is not None and said.master == ME:
        first, edges, driven = shown.first, shown.edges, said.done - shown.first
        states = [complete] * driven + [ahead] * (len(edges) - driven)
        if said.failed:
            states[driven] = values.EdgeState.FAILED
    elif said.failed or not said.order:
        first, edges, states = said.done, (), []
    else:
        first, edges, states = said.done - 1, (1,), [complete]
    return values.RouteReport(
        0, 0, edges, tuple(states), values.SymbolicPose(0, 0.0), epoch=said.epoch,
        master='' if said.master == NOBODY else said.master, order=said.order,
        refused=said.refused, first=first, motion=MOTIONS[said.motion], number=said.sequence)


MOTIONS = {
    Motion.STANDING: values.Motion.STANDING, Motion.ON_ROUTE: values.Motion.ON_ROUTE,
    Motion.COMING_TO_REST: values.Motion.COMING_TO_REST, Motion.MOVED: values.Motion.MOVED,
    Motion.UNKNOWN: values.Motion.UNKNOWN}
BOUNDS = {
    'two orders': Bounds(reports=2),
    'another master': Bounds(orders=1, edges=1, reports=2, others=1),
    'old masters': Bounds(orders=1, edges=1, reports=1, old=2),
    'an older journal': Bounds(orders=2, epochs=1, reports=2, restores=1),
    'an older journal and restarts': Bounds(edges=1, reports=1, restores=1),
}
if LONG:
    BOUNDS.update({
        'two orders and three reports': Bounds(),
        'an older journal and three orders': Bounds(orders=3, epochs=1, reports=2, restores=1),
        'two orders and another master': Bounds(orders=2, edges=1, reports=2, others=1),
        'restarts, two reports and an older journal': Bounds(edges=1, reports=2, restores=1),
    })


@pytest.mark.parametrize('name', BOUNDS)
def test_no_order_of_events_brings_a_vehicle_outside_what_the_master_knows(name, capsys):
    found = WithRealMaster().search(BOUNDS[name], MOST)
    with capsys.disabled():
        print(f'\n{name}, real master: {found.states} states')
    assert not found.flaw, str(found)


@pytest.mark.parametrize('bounds', [
    Bounds(orders=1), Bounds(edges=1, reports=1, restores=1),
    Bounds(orders=1, edges=1, reports=1, others=1)])
def test_the_master_can_bring_every_vehicle_to_a_new_edge(bounds):
    found = WithRealMaster().search(bounds, MOST, live=True)
    assert not found.flaw, str(found)


def _keeps_what_it_knew(before: real.MasterState, after: real.MasterState) -> real.MasterState:
    return after if before.unknown else replace(after, unknown=0)


CHANGES: Dict[str, Tuple[Change, str]] = {
    'it forgets all open orders but the newest':
        (lambda before, after: replace(after, open=after.open[-1:]), 'two orders'),
    'it holds nothing until the vehicle stands':
        (lambda before, after: replace(after, held=()), 'two orders'),
    'it does not notice that another one moves the vehicle':
        (lambda before, after: replace(after, is_anywhere=False), 'another master'),
    'it grants to a vehicle that does not count its orders':
        (lambda before, after: replace(after, commands=True), 'another master'),
    'it does not notice a number that its journal lacks':
        (_keeps_what_it_knew, 'an older journal'),
    'with an older journal it believes the first report':
        (lambda before, after: replace(after, unknown=0), 'an older journal'),
}
READINGS: Dict[str, Tuple[Reading, str]] = {
    'it believes a late report':
        (lambda said, state: replace(said, number=max(said.number, state.report + 1)),
         'two orders'),
    "it takes the numbers of another master's orders for its own":
        (lambda said, state: replace(said, master=ME), 'another master'),
}


def flaw_of(model: Model, bounds: str, live: bool = False) -> str:
    """Searches within the bounds. Returns the flaw that the search finds.

    A report that the master refuses is also a flaw.
    """
    try:
        return model.search(BOUNDS[bounds], MOST, live).flaw
    except WrongReport as wrong:
        return f'the master refuses a report: {wrong}'


@pytest.mark.parametrize('fault', CHANGES)
def test_an_effect_of_reports_that_is_left_out_is_found(fault):
    change, bounds = CHANGES[fault]
    assert flaw_of(WithRealMaster(change), bounds, live='grants' in fault), fault


@pytest.mark.parametrize('fault', READINGS)
def test_a_master_that_reads_reports_wrongly_is_found(fault):
    reading, bounds = READINGS[fault]
    assert flaw_of(WithRealMaster(reading=reading), bounds), fault


def test_a_master_that_draws_a_number_again_is_found():
    class DrawsAgain(WithRealMaster):
        def _next_number(self, master: RealMaster, drawn: int) -> int:
            return master.state.number + 1

    assert flaw_of(DrawsAgain(), 'an older journal')


def test_edges_are_held_while_the_vehicle_drives_a_route_that_is_not_open():
    """A new graph lacks an edge of the route. So the only open order of the master is a stop."""
    state = real.MasterState(epoch=1, number=3, order=2, done=1, commands=True,
                             open=(real.Order(3, 0, 1, ()),),
                             held=(real.Step(1, 12), real.Step(3, 14)))
    states = (values.EdgeState.COMPLETE, *3 * (values.EdgeState.PROCESSING,))
    drives = values.RouteReport(
        0, 0, (11, 12, 13, 14), states, values.SymbolicPose(0, 0.0), epoch=1, master=ME, order=2,
        first=0, motion=values.Motion.ON_ROUTE, number=1)
    after, _ = real.hear(state, drives, ME, 4)
    assert after.held == state.held
    stands, _ = real.hear(after, replace(drives, motion=values.Motion.STANDING, number=2), ME, 4)
    assert not stands.held


def test_a_report_that_says_nothing_new_leaves_all_that_follows_from_the_state():
    state = real.MasterState(epoch=1, report=1, number=2, order=2, done=1, commands=True,
                             open=(real.Order(2, 1, 0, (11, 12, 13)),))
    states = (values.EdgeState.COMPLETE, *2 * (values.EdgeState.PROCESSING,))
    drives = values.RouteReport(
        0, 0, (11, 12, 13), states, values.SymbolicPose(12, 40.0), epoch=1, master=ME, order=2,
        first=0, motion=values.Motion.ON_ROUTE, number=7)
    assert state.ahead == (12, 13)
    after, news = real.hear(state, drives, ME, 4)
    assert news.is_repeat and after == replace(state, report=7)
    later = replace(drives, number=8, states=(*2 * (values.EdgeState.COMPLETE,), states[2]))
    after, news = real.hear(after, later, ME, 4)
    assert not news.is_repeat and (after.done, after.ahead) == (2, (13,))
