"""Which order waits at a vehicle, when the order is answered, and what its master is told."""
from __future__ import annotations

from itertools import count
from random import Random
from typing import Dict, List, Optional, Tuple, Union

import pytest
from hypothesis import given
from hypothesis import strategies as st

from route_protocol.intake import DISPLACED, DueOrder, Intake, NotYet, messages_of
from route_protocol.order_rules import RouteRefused
from route_protocol.values import (
    ANSWERED_WITHIN,
    NO_REASON,
    OVERRULED,
    TAKEN_OVER,
    EdgeState,
    EpochCause,
    Motion,
    Reason,
    ReasonCode,
    RouteOrder,
    RouteRefusal,
    RouteReport,
    SymbolicPose,
)
from route_protocol.vehicle import OLD_MASTER, Vehicle

NANOSECONDS = 1_000_000_000
ROLLS = Reason(ReasonCode.NOT_READY, 'it rolls')
AWAY = Reason(ReasonCode.STARTS_ELSEWHERE, 'it is elsewhere')
BAD = 99  # an edge that the vehicle refuses at once


class Fleet:
    """A vehicle and its intake.

    knows -- whether the vehicle can decide now about a route
    bad   -- whether the vehicle refuses every route
    """

    def __init__(self, patience: float = ANSWERED_WITHIN) -> None:
        self.vehicle = Vehicle(count(1).__next__, lambda: 1000)
        self.intake = Intake(self.vehicle, self._take_up, self._told, patience)
        self.knows = self.bad = False
        self.now = 100.0
        self.refusals: List[RouteRefusal] = []
        self.sent: List[Union[RouteRefusal, RouteReport]] = []

    def numbered(self, number: int, *edges: int, master: str = 'fleet', epoch: int = 0,
                 sent: float = 0.0) -> RouteOrder:
        state = self.vehicle.state
        return self.send(RouteOrder(7, edges, int(sent * NANOSECONDS), order=number, master=master,
                                    known_epoch=epoch or state.epoch, first=state.done))

    def old(self, route_id: int, *edges: int, sent: float = 0.0,
            received: float = 0.0) -> RouteOrder:
        return self.send(RouteOrder(route_id, edges, int(sent * NANOSECONDS),
                                    int(received * NANOSECONDS)))

    def send(self, order: RouteOrder) -> RouteOrder:
        self.intake.arrived(order, self.now)
        return order

    def knows_after(self, seconds: float) -> None:
        self.now += seconds
        self.knows = True
        self.intake.answer(self.now)

    @property
    def waits(self) -> Optional[RouteOrder]:
        return self.intake.waiting and self.intake.waiting.order

    @property
    def told(self) -> List[Tuple[int, Reason]]:
        return [(one.order or one.route_id, one.reason) for one in self.refusals]

    def report(self) -> RouteReport:
        return self.vehicle.report(0, SymbolicPose(), None, Motion.STANDING)

    def _take_up(self, due: DueOrder) -> None:
        if self.bad or BAD in due.given.edges:
            raise RouteRefused(AWAY)
        if not self.knows:
            raise NotYet(ROLLS)
        self.intake.take_order(due, self.now)

    def _told(self, refusal: RouteRefusal) -> None:
        self.refusals.append(refusal)
        self.sent += messages_of(refusal, self.vehicle.state, self.report)


@pytest.fixture(name='fleet')
def _fleet() -> Fleet:
    return Fleet()


# -- the table -------------------------------------------------------------------------------------

def test_a_route_that_can_be_answered_does_not_wait(fleet):
    fleet.knows = True
    fleet.numbered(5, 1, 2)
    assert (fleet.waits, fleet.vehicle.state.order) == (None, 5)


def test_another_one_waits_until_the_vehicle_can_tell(fleet):
    order = fleet.numbered(5, 1, 2)
    fleet.intake.answer(fleet.now + ANSWERED_WITHIN)
    assert fleet.waits == order
    fleet.knows_after(1.0)
    assert (fleet.waits, fleet.vehicle.state.order, fleet.told) == (None, 5, [])


@pytest.mark.parametrize('patience, given_up', [(3.0, 3.0), (60.0, ANSWERED_WITHIN)])
def test_but_not_for_ever_also_if_it_is_repeated(patience, given_up):
    fleet = Fleet(patience)
    order = fleet.numbered(5, 1, 2)
    for second in (1.0, 2.0, 3.0):
        fleet.now = 100.0 + second
        fleet.send(order)
    fleet.intake.answer(100.0 + given_up)
    assert fleet.told == []
    fleet.intake.answer(100.1 + given_up)
    assert (fleet.told, fleet.vehicle.state.refused) == ([(5, ROLLS)], 5)


@pytest.mark.parametrize('numbers, waits', [((5, 6), 6), ((6, 5), 6), ((6, 6), 6)])
def test_of_two_orders_of_one_master_the_one_with_the_larger_number_waits(fleet, numbers, waits):
    for number in numbers:
        fleet.numbered(number, 1, 2)
    assert fleet.waits.order == waits
    assert fleet.told == [], 'the number answers both'


@pytest.mark.parametrize('second, waits', [
    ((8, 1, 2), (7, 90.0)), ((8, 3), (8, 95.0)), ((7, 1, 2), (7, 90.0))])
def test_of_two_orders_without_a_number_the_later_one_waits(fleet, second, waits):
    fleet.old(7, 1, 2, sent=90.0)
    fleet.old(*second, sent=80.0 if second == (8, 1, 2) else 95.0)
    assert (fleet.waits.route_id, fleet.waits.stamp / NANOSECONDS) == waits


@pytest.mark.parametrize('first, second', [
    ('fleet', 'other'), ('fleet', OLD_MASTER), (OLD_MASTER, 'other')])
def test_the_order_of_another_master_waits_and_the_other_one_reads_that(fleet, first, second):
    for number, master in ((9, first), (5, second)):
        if master == OLD_MASTER:
            fleet.old(number, 1, 2)
        else:
            fleet.numbered(number, 1, 2, master=master)
    assert fleet.told == [(9, DISPLACED)]
    fleet.knows_after(1.0)
    assert fleet.vehicle.state.master == second


def test_a_route_that_is_refused_at_once_displaces_none(fleet):
    order = fleet.numbered(5, 1, 2)
    fleet.numbered(1, BAD, master='other')
    assert (fleet.waits, fleet.told) == (order, [(1, AWAY)])


@pytest.mark.parametrize('stop, taken', [(4, 5), (6, 6)])
def test_after_a_stop_a_numbered_route_is_judged_by_its_number(fleet, stop, taken):
    fleet.numbered(5, 1, 2)
    fleet.numbered(stop)
    fleet.knows_after(1.0)
    assert (fleet.vehicle.state.order, fleet.told) == (taken, [])


@pytest.mark.parametrize('master', ['fleet', OLD_MASTER])
def test_after_a_stop_a_route_without_a_number_is_forgotten(fleet, master):
    fleet.old(7, 1, 2)
    fleet.send(RouteOrder(8, (), order=5 if master else 0, master=master))
    assert (fleet.waits, fleet.told) == (None, [])


@pytest.mark.parametrize('stop', [
    RouteOrder(0, ()), RouteOrder(0, (), order=1, master='other')], ids=['past', 'other'])
def test_a_stop_that_begins_a_new_epoch_makes_the_waiting_route_refused(fleet, stop):
    fleet.numbered(4)
    fleet.numbered(5, 1, 2)
    fleet.send(stop)
    fleet.knows_after(1.0)
    assert fleet.told == [(5, OVERRULED)]


def test_a_new_epoch_refuses_the_waiting_route_at_once(fleet):
    fleet.numbered(5, 1, 2)
    fleet.intake.begin_epoch(EpochCause.OTHER_GIVER, NO_REASON, fleet.now)
    fleet.old(7, 1, 2)
    fleet.intake.begin_epoch(EpochCause.OTHER_GIVER, NO_REASON, fleet.now)
    assert (fleet.told, fleet.waits) == ([(5, OVERRULED), (7, TAKEN_OVER)], None)


# -- what old masters are told ---------------------------------------------------------------------

@pytest.mark.parametrize('in_force, refused, is_told', [
    ((), 0, True),        # the reports have an id, but no route
    ((), 7, True), ((7, 1, 2), 8, True),
    ((7, 1, 2), 7, False)])  # that route goes on
def test_an_old_master_reads_a_refusal_as_a_failed_route_unless_that_route_goes_on(
        fleet, in_force, refused, is_told):
    fleet.knows = True
    if in_force:
        fleet.old(*in_force)
    fleet.old(refused, BAD)
    reports = [one for one in fleet.sent if isinstance(one, RouteReport)]
    assert [(one.route_id, one.states, one.reason) for one in reports] == (
        [(refused, (EdgeState.FAILED,), AWAY)] if is_told else [])


def test_a_numbering_master_reads_no_failed_route_of_another_one(fleet):
    fleet.knows = True
    fleet.numbered(5, 1, 2)
    fleet.numbered(6, BAD)
    fleet.old(8, BAD)
    assert fleet.sent == fleet.refusals and len(fleet.refusals) == 2


# -- which orders count for old masters ------------------------------------------------------------

def test_a_route_of_an_old_master_is_late_that_was_sent_before_an_order_of_any_master(fleet):
    fleet.knows = True
    fleet.numbered(5, sent=90.0)
    fleet.old(7, 1, 2, sent=89.0)
    assert fleet.vehicle.state.order == 5
    fleet.old(7, 1, 2, sent=91.0)
    assert fleet.vehicle.state.master == OLD_MASTER


def test_a_route_of_an_old_master_repeats_its_own_only(fleet):
    fleet.knows = True
    fleet.old(8, 1, 2)
    fleet.numbered(5, 3)
    fleet.old(8, 1, 2)
    assert fleet.vehicle.state.master == 'fleet', 'it repeats the order before'
    fleet.old(7, 3)
    assert fleet.vehicle.state.master == OLD_MASTER, 'a label of another master is no repeat'


def test_only_an_order_that_begins_an_epoch_makes_orders_on_their_way_void(fleet):
    fleet.knows = True
    fleet.old(8, 1, 2)
    fleet.numbered(5, 3)
    fleet.now += 5.0
    fleet.numbered(6, 3, 4)
    fleet.old(9, 1, sent=fleet.now - 0.1, received=fleet.now)
    assert (fleet.told, fleet.vehicle.state.route_id) == ([], 9)


@pytest.mark.parametrize('age, is_taken', [(1.6, False), (0.05, True)])
def test_a_route_of_an_old_master_is_void_that_was_on_its_way_when_an_epoch_began(
        fleet, age, is_taken):
    fleet.knows = True
    fleet.intake.begin_epoch(EpochCause.OTHER_GIVER, NO_REASON, fleet.now)
    fleet.now += 0.1
    fleet.old(7, 1, sent=fleet.now - age, received=fleet.now)
    assert (fleet.told == []) is (fleet.vehicle.state.order == 1) is is_taken


def test_a_refused_route_is_refused_again_but_one_without_a_stamp_may_be_a_new_one(fleet):
    fleet.knows, fleet.bad = True, True
    stamped, other = fleet.old(7, 1, sent=90.0), fleet.old(8, 1)
    fleet.bad = False
    fleet.send(other)
    assert fleet.vehicle.state.route_id == 8
    fleet = Fleet()
    fleet.knows, fleet.bad = True, True
    fleet.send(stamped)
    fleet.bad = False
    fleet.send(stamped)
    assert fleet.told == [(7, AWAY)] * 2


def test_a_latched_route_that_only_comes_with_a_connection_is_refused(fleet):
    fleet.send(RouteOrder(7, (1,), comes_again=True))
    assert (fleet.waits, [number for number, _ in fleet.told]) == (None, [7])


@pytest.mark.parametrize('latched', [
    RouteOrder(7, (1,), 1, comes_again=True),
    RouteOrder(7, (1,), known_epoch=1, comes_again=True)], ids=['stamp', 'epoch'])
def test_but_not_one_that_says_when_it_was_given(fleet, latched):
    assert fleet.send(latched) == fleet.waits


def test_a_latched_route_that_is_driven_already_is_no_refusal(fleet):
    fleet.knows = True
    fleet.old(7, 1)
    fleet.send(RouteOrder(7, (1,), comes_again=True))
    assert fleet.told == []


@pytest.mark.parametrize('received, is_taken', [(40.1, True), (100.1, False)])
def test_no_route_is_late_where_the_clock_of_the_vehicle_was_set_back(fleet, received, is_taken):
    fleet.knows = True
    fleet.old(7, 1, sent=100.0)
    fleet.old(7, 1, 2, sent=40.0, received=received)
    assert (fleet.vehicle.state.edges == (1, 2)) is is_taken


# -- property --------------------------------------------------------------------------------------

@given(st.integers(0, 2 ** 32))
def test_each_route_is_answered_in_time_and_none_is_forgotten(seed):
    """Masters send orders, repetitions and stops in any sequence. At some times the vehicle can
    decide, at other times it cannot.
    """
    random, fleet = Random(seed), Fleet()
    first: Dict[Tuple[int, int], float] = {}
    numbers = count(1)
    sent: List[RouteOrder] = []
    for _ in range(40):
        master = random.choice(('fleet', 'fleet', 'other'))
        happens = random.choice(('route', 'route', 'repeat', 'stop', 'time', 'time', 'epoch'))
        if happens == 'repeat' and sent:
            fleet.send(random.choice(sent))
        elif happens in ('route', 'stop'):
            edges = (random.choice((1, 2, BAD)),) if happens == 'route' else ()
            sent.append(fleet.numbered(next(numbers), *edges, master=master))
        elif happens == 'epoch' and random.random() < 0.3:
            fleet.intake.begin_epoch(EpochCause.OTHER_GIVER, NO_REASON, fleet.now)
        else:
            fleet.now += random.choice((0.1, 1.0, 2.0))
            fleet.knows = random.random() < 0.3
            fleet.intake.answer(fleet.now)
        waits = fleet.waits
        if waits is not None:
            answers = len(fleet.refusals)  # an order may come again after its refusal
            since = first.setdefault((waits.order, answers), fleet.now)
            assert fleet.now <= since + ANSWERED_WITHIN, 'a route waits for too long'
        read = {number for number, _ in fleet.told}
        state = fleet.vehicle.state
        newest = {order.master: order for order in sent}
        for master, order in newest.items():
            taken = (state.master, state.order) == (master, order.order)
            is_over = order.known_epoch != state.epoch  # the next report shows the new epoch
            assert taken or order is waits or order.order in read or is_over, (
                'a route was forgotten')
