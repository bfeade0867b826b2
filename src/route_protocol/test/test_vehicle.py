"""The vehicle's end: each row of its table, bad input, old masters, comparison with the model."""
from __future__ import annotations

from dataclasses import replace
from itertools import count
from random import Random
from typing import Dict, Iterator, List, Optional, Tuple, Type

import numbered_orders_model as model
import pytest
from hypothesis import given
from hypothesis import strategies as st

from route_protocol.old_masters import LATE_ORDER, OldMasters
from route_protocol.values import (
    LARGEST_NUMBER,
    LARGEST_RECORD_NUMBER,
    NO_REASON,
    OVERRULED,
    TAKEN_OVER,
    EdgeState,
    EpochCause,
    Motion,
    Phase,
    Reason,
    ReasonCode,
    RouteOrder,
    SymbolicPose,
)
from route_protocol.vehicle import SKIPPED_REPORTS, Answer, Judgement, Vehicle, VehicleState

NANOSECONDS = 1_000_000_000
WHY = Reason(ReasonCode.NO_PROGRESS, 'no progress')


def vehicle() -> Vehicle:
    """Returns a vehicle whose epochs are 1, 2, 3 ..., and whose clock stands still."""
    return Vehicle(count(1).__next__, lambda: 1000)


def order(number: int, *edges: int, first: int = 0, epoch: int = 1,
          master: str = 'fleet') -> RouteOrder:
    return RouteOrder(7, edges, known_epoch=epoch, order=number, first=first, master=master)


def took(*orders: RouteOrder) -> Vehicle:
    """Returns a vehicle that has taken these orders."""
    its = vehicle()
    for one in orders:
        obey(its, one)
    return its


def obey(its: Vehicle, given: RouteOrder, willing: bool = True) -> Answer:
    """Gives an order to the vehicle. Returns its answer.

    willing -- False: the vehicle refuses any route
    """
    judgement = its.judge(given)
    if judgement.answer is Answer.STOP:
        its.stop(given)
    elif judgement.answer is Answer.ROUTE and willing:
        its.take_order(given, judgement.done)
    elif judgement.answer is not Answer.IGNORED:
        its.refuse(given, judgement.reason or WHY)
        return Answer.REFUSED
    return judgement.answer


# -- the table -------------------------------------------------------------------------------------

def test_a_stop_without_a_number_begins_a_new_epoch():
    its = took(order(5, 1, 2))
    assert obey(its, RouteOrder(8, ())) is Answer.STOP
    state = its.state
    assert (state.epoch, state.cause, state.order, state.phase) == (
        2, EpochCause.STOP, 0, Phase.STOPPED)
    assert obey(its, order(6, 1, 2)) is Answer.REFUSED


@pytest.mark.parametrize('number', [1, 5])
@pytest.mark.parametrize('edges', [(), (1, 2, 3)])
def test_an_order_that_is_not_newer_is_ignored(number, edges):
    its = took(order(5, 1, 2))
    before = its.state
    assert obey(its, order(number, *edges)) is Answer.IGNORED
    assert its.state == before


def test_an_order_that_was_refused_is_ignored_when_it_comes_again_and_so_are_those_before_it():
    its = took(order(5, 1, 2))
    assert obey(its, order(8, 1, 2, 3), willing=False) is Answer.REFUSED
    for number in (6, 7, 8):
        assert obey(its, order(number, 1, 2, 3)) is Answer.IGNORED
    assert (its.state.order, its.state.refused, its.state.refusal) == (5, 8, WHY)
    assert obey(its, order(9, 1, 2, 3)) is Answer.ROUTE


def test_a_newer_stop_of_the_master_keeps_the_epoch():
    its = took(order(5, 1, 2))
    assert obey(its, order(6, epoch=0)) is Answer.STOP
    assert (its.state.epoch, its.state.order, its.state.phase) == (1, 6, Phase.STOPPED)


@pytest.mark.parametrize('edges', [(), (3,)])
def test_an_order_of_another_master_begins_a_new_epoch(edges):
    its = took(order(5, 1, 2))
    obey(its, order(1, *edges, first=4, master='other'))
    state = its.state
    assert (state.epoch, state.cause, state.master, state.order) == (
        2, EpochCause.OTHER_MASTER, 'other', 1)
    assert obey(its, order(9, 1, 2)) is Answer.REFUSED, 'the former master reads that'
    assert its.state == state, 'and its numbers count no more'


def test_a_route_of_another_master_that_is_refused_changes_nothing():
    its = took(order(5, 1, 2))
    before = its.state
    assert obey(its, order(9, 3, master='other'), willing=False) is Answer.REFUSED
    assert its.state == before


def test_a_route_of_another_epoch_is_refused():
    its = vehicle()
    assert its.judge(order(5, 1, epoch=9)) == Judgement(Answer.REFUSED, OVERRULED)


@pytest.mark.parametrize('first, edges', [(0, (9, 8)), (4, (3,)), (2, (3, 4))])
def test_a_route_must_have_the_number_that_the_vehicle_has_reached(first, edges):
    its = took(order(5, 1, 2, 3, first=0))
    its.complete(1)
    judgement = its.judge(order(6, *edges, first=first))
    assert judgement.reason.code is ReasonCode.WRONG_CHANGE


def test_a_running_route_must_go_on_with_the_edge_under_way():
    its = took(order(5, 1, 2, 3))
    its.complete(1)
    assert its.judge(order(6, 1, 4)).reason.text == 'it must go on with the edge under way, 2'
    assert its.judge(order(6, 1)).reason.code is ReasonCode.WRONG_CHANGE
    assert its.judge(order(6, 2, 4, first=1)) == Judgement(
        Answer.ROUTE, done=1, rest=(2, 4), goes_on=True)


def test_a_route_may_pass_a_place_twice():
    its = took(order(5, 1, -1, 1))
    its.complete(2)
    obey(its, order(6, 1, -1, first=2))
    assert (its.state.done, its.state.ahead) == (2, (1, -1))
    its.complete(1)
    assert its.state.ahead == (-1,)


def test_a_complete_route_goes_on_and_may_be_ordered_again_without_new_edges():
    its = took(order(5, 1, 2))
    its.complete(2)
    assert its.judge(order(6, 2, first=1)) == Judgement(Answer.ROUTE, done=2, rest=(), goes_on=True)
    obey(its, order(6, 2, first=1))
    assert its.state.phase is Phase.COMPLETE
    obey(its, order(7, 3, first=2))
    assert (its.state.phase, its.state.ahead) == (Phase.RUNNING, (3,))


def test_after_a_failure_a_route_begins_at_the_same_number_and_does_not_go_on():
    its = took(order(5, 1, 2))
    its.complete(1)
    its.fail(WHY)
    assert its.judge(order(6, 1)).answer is Answer.REFUSED
    assert its.judge(order(6, 3, first=1)) == Judgement(Answer.ROUTE, done=1, rest=(3,))
    assert its.state.order == 5


def test_after_its_master_moved_it_itself_a_route_has_the_next_number_and_does_not_go_on():
    its = took(order(5, 1, 2))
    its.leave_route()
    assert its.state.phase is Phase.RUNNING
    its.complete(2)
    its.leave_route()
    assert its.judge(order(6, 3, first=2)) == Judgement(Answer.ROUTE, done=2, rest=(3,))
    assert (its.state.epoch, its.state.order) == (1, 5)
    report = its.report(0, SymbolicPose(), None, Motion.STANDING)
    assert report.states == (EdgeState.COMPLETE, EdgeState.COMPLETE)


def test_a_new_epoch_fails_the_route_and_forgets_the_numbers():
    its = took(order(5, 1, 2))
    obey(its, order(6, 9), willing=False)
    its.begin_epoch(EpochCause.OTHER_GIVER, WHY)
    state = its.state
    assert (state.epoch, state.order, state.refused, state.phase, state.reason, state.master) == (
        2, 0, 0, Phase.FAILED, WHY, 'fleet')


# -- bad input -------------------------------------------------------------------------------------

@pytest.mark.parametrize('bad, words', [
    (order(6, 1, 2, 3, epoch=0), 'does not name the epoch'),
    (order(6, 1, 2, first=LARGEST_RECORD_NUMBER - 1), 'record numbers end'),
    (order(6, 1, 2, first=LARGEST_RECORD_NUMBER), 'record numbers end'),
    (order(6, 3, first=3), 'have the numbers 3 to 3'),
    (order(LARGEST_NUMBER, 1, 2, 3), 'no later order could have a larger one'),
    (order(6, 1, 2, 3, master=''), 'does not name its master'),
])
def test_bad_input_is_refused_in_one_sentence_and_nothing_is_lost(bad, words):
    its = took(order(5, 1, 2))
    before = its.state
    judgement = its.judge(bad)
    assert judgement.answer is Answer.REFUSED
    assert words in judgement.reason.text
    its.refuse(bad, judgement.reason)
    assert replace(its.state, refused=0, refusal=before.refusal) == before
    for answer, good in ((Answer.ROUTE, order(7, 1, 2, 3)), (Answer.STOP, order(8, epoch=0))):
        assert obey(its, good) is answer


@pytest.mark.parametrize('stop', [order(LARGEST_NUMBER, epoch=0), order(9, epoch=0, master='')])
def test_a_stop_that_cannot_be_counted_is_one_past_the_master(stop):
    its = took(order(5, 1, 2))
    obey(its, stop)
    assert (its.state.epoch, its.state.phase, its.state.order) == (2, Phase.STOPPED, 0)
    assert obey(its, order(6, 1, 2, epoch=2)) is Answer.ROUTE


# -- reports and restarts --------------------------------------------------------------------------

def test_a_report_says_everything_and_its_number_grows():
    its = took(order(5, 1, 2, first=3))
    its.complete(1)
    obey(its, order(6, 9, first=1), willing=False)
    first, second = (its.report(8, SymbolicPose(2, 50.0), None, Motion.ON_ROUTE) for _ in range(2))
    assert (first.epoch, first.master, first.order, first.refused, first.first, first.done) == (
        1, 'fleet', 5, 6, 3, 4)
    assert first.states == (EdgeState.COMPLETE, EdgeState.PROCESSING)
    assert (first.number, second.number) == (1000, 1001)


def test_after_a_restart_with_memory_nothing_is_different_but_reports_have_larger_numbers():
    its = took(order(5, 1, 2))
    its.report(8, SymbolicPose(), None, Motion.ON_ROUTE)
    again = vehicle()
    again.resume(its.state)
    assert again.state == its.state
    assert again.report(8, SymbolicPose(), None, Motion.ON_ROUTE).number > 1000 + SKIPPED_REPORTS


def test_a_restart_without_a_sure_memory_fails_the_route_in_a_new_epoch():
    its = took(order(5, 1, 2))
    before = its.state
    its.forget(before, WHY)
    assert (its.state.phase, its.state.reason, its.state.master) == (Phase.FAILED, WHY, None)
    assert obey(its, order(6, 1, 2)) is Answer.REFUSED
    assert (its.state.epoch, its.state.cause) == (2, EpochCause.RESTART)


# -- masters without numbers -----------------------------------------------------------------------

def old(route_id: int, *edges: int, sent: float = 0.0, received: float = 100.0,
        epoch: int = 0) -> RouteOrder:
    return RouteOrder(route_id, edges, int(sent * NANOSECONDS), int(received * NANOSECONDS), epoch)


class OldFleet:
    """A vehicle, and the rules for its old masters."""

    def __init__(self) -> None:
        self.vehicle, self.old = vehicle(), OldMasters()

    def judge(self, given: RouteOrder, now: float = 100.0) -> Judgement:
        return self.old.judge(given, self.vehicle.state, now)

    def take_order(self, given: RouteOrder) -> None:
        numbered = self.old.numbered(given, self.vehicle.state)
        self.vehicle.take_order(numbered, self.vehicle.state.done)
        self.old.passed(given)


def test_routes_of_old_masters_are_numbered_from_the_place_where_they_are_taken():
    fleet = OldFleet()
    fleet.take_order(old(7, 1, 2))
    fleet.vehicle.complete(1)
    fleet.take_order(old(7, 1, 2, 3))
    assert (fleet.vehicle.state.order, fleet.vehicle.state.first, fleet.vehicle.state.done) == (
        2, 0, 1)
    fleet.take_order(old(8, 2, 5))
    assert (fleet.vehicle.state.first, fleet.vehicle.state.ahead) == (1, (2, 5))


@pytest.mark.parametrize('given, answer', [
    (old(8, 3, sent=99.0), Answer.IGNORED), (old(7, 1, 2, sent=101.0), Answer.IGNORED),
    (old(7, 1, 2, 3, sent=101.0), Answer.ROUTE), (old(8, 3, sent=101.0), Answer.ROUTE),
    (old(8, 3, epoch=9), Answer.REFUSED), (old(8, 3, epoch=1), Answer.ROUTE),
    (replace(old(8, 3), comes_again=True), Answer.REFUSED)])
def test_which_orders_of_old_masters_pass(given, answer):
    fleet = OldFleet()
    fleet.take_order(old(7, 1, 2, sent=100.0))
    assert fleet.judge(given).answer is answer


def test_an_order_that_is_late_stays_late_after_a_late_stop():
    fleet = OldFleet()
    fleet.take_order(old(7, 1, 2, sent=100.0))
    fleet.old.passed(old(8, sent=90.0))
    assert fleet.judge(old(6, 3, sent=95.0)).answer is Answer.IGNORED


def test_a_refused_order_is_refused_again_and_one_from_before_the_epoch_for_a_while():
    fleet = OldFleet()
    fleet.old.refused(old(7, 1, sent=100.0), WHY)
    assert fleet.judge(old(7, 1, sent=100.0)) == Judgement(Answer.REFUSED, WHY)
    fleet.old.epoch_began(100.0)
    assert fleet.judge(old(8, 1, sent=99.9), 100.05) == Judgement(Answer.REFUSED, TAKEN_OVER)
    assert fleet.judge(old(8, 1, sent=99.9, received=102.0), 100.0 + LATE_ORDER).answer is (
        Answer.ROUTE)


# -- the model's vehicle ---------------------------------------------------------------------------

class Pair:
    """The real vehicle and the model's vehicle, which get the same events.

    The caller of the real vehicle must know whether a route begins where the vehicle is, and
    whether the vehicle still rolls. Here the model answers these two questions.
    """

    def __init__(self, random: Random, kind: Type[Vehicle] = Vehicle) -> None:
        self.random = random
        self.model, self.rules = model.Vehicle(master=model.NOBODY), model.Model()
        self.real = kind(count(1).__next__, lambda: 0)
        self.edges: Dict[int, model.Edge] = {}
        self.sent: List[model.Order] = []
        self.numbers = {model.ME: 0, model.OTHER: 0}

    def edge(self, origin: Optional[int]) -> model.Edge:
        label = len(self.edges) + 1
        self.edges[label] = model.Edge(label, -1 if origin is None else origin,
                                       self.random.randint(1, 3))
        return self.edges[label]

    def new_order(self) -> model.Order:
        """Returns an order that begins at the present place, or has a wrong start, record number or
        epoch.
        """
        its, random = self.model, self.random
        master = random.choice((model.ME, model.ME, model.ME, model.OTHER))
        self.numbers[master] += random.randint(1, 2)
        if random.random() < 0.2:
            return model.Order(self.numbers[master], 0, 0, (), master)
        known = (its.edge, *its.route[1:]) if its.edge is not None else its.route
        if its.rolling:
            known = its.rolling
        kept = random.randint(0, len(known)) if random.random() < 0.3 else len(known)
        edges = list(known[:kept])
        for _ in range(random.randint(0, 2)):
            edges.append(self.edge(edges[-1].destination if edges else its.place))
        first = its.done
        for _ in range(min(random.randint(0, 2), first)):
            edges.insert(0, self.edge(None))
            first -= 1
        if random.random() < 0.1:
            first += random.randint(1, 2)
        epoch = its.epoch - (random.random() < 0.1)
        return model.Order(self.numbers[master], epoch, first,
                           tuple(edges) or (self.edge(its.place),), master)

    def arrive(self, given: model.Order, willing: bool) -> None:
        before = self.model
        real = RouteOrder(0, tuple(edge.label for edge in given.edges), known_epoch=given.epoch,
                          order=given.number, first=given.first, master=given.master)
        judgement = self.real.judge(real)
        if (before.edge is None and given.first <= before.done <= real.end
                and judgement.reason.code is ReasonCode.WRONG_CHANGE):
            willing = False  # while it passes a vertex, the real vehicle keeps its route
        self.model = self.rules.obey(before, given, willing)
        fits = willing and not before.rolling
        if judgement.answer is Answer.ROUTE and fits:
            rest = tuple(self.edges[label] for label in judgement.rest)
            fits = (model._continues(before, rest) if rest else before.edge is None)
        obey(self.real, real, fits)

    def drive(self) -> None:
        if self.model.route or self.model.rolling:
            before, self.model = self.model, model.drive(self.model)
            if before.route:
                self.real.complete(self.model.done - self.real.state.first)

    def lose_route(self, cause: Optional[EpochCause]) -> None:
        """Makes the route fail. If there is a cause, begins a new epoch."""
        if cause is None:
            if self.model.route:
                self.model = model.without_route(self.model)._replace(failed=True)
                self.real.fail(WHY)
            return
        self.model = model.new_epoch(model.without_route(self.model), 0)
        if cause is EpochCause.RESTART:
            self.model = self.model._replace(master=model.NOBODY)
            self.real.forget(self.real.state, WHY)
        else:
            self.real.begin_epoch(cause, WHY)

    def rest(self) -> None:
        self.model = self.model._replace(rolling=())

    def check(self) -> None:
        its, real = self.model, self.real.state
        master = model.NOBODY if real.master is None else real.master
        assert (master, real.order, real.refused, real.epoch) == (
            its.master, its.order, its.refused, its.epoch)
        assert real.is_running is bool(its.route)
        if its.route:
            assert real.ahead == tuple(edge.label for edge in its.route)
        if its.order:
            assert real.done == its.done


def steps(pair: Pair) -> Iterator[Tuple[str, str]]:
    random = pair.random
    for _ in range(60):
        happens = random.choice(('new', 'new', 'again', 'drive', 'drive', 'drive', 'fail', 'epoch',
                                 'rest'))
        said = ''
        if happens == 'new':
            pair.sent.append(pair.new_order())
            if random.random() < 0.8:
                said = str(pair.sent[-1])
                pair.arrive(pair.sent[-1], random.random() < 0.9)
        elif happens == 'again' and pair.sent:
            given = random.choice(pair.sent)
            said = str(given)
            pair.arrive(given, random.random() < 0.9)
        elif happens == 'drive':
            pair.drive()
        elif happens == 'fail':
            pair.lose_route(None)
        elif happens == 'epoch' and random.random() < 0.3:
            pair.lose_route(random.choice((EpochCause.OTHER_GIVER, EpochCause.RESTART)))
        elif happens == 'rest':
            pair.rest()
        yield happens, said


@given(st.integers(0, 2 ** 32))
def test_the_vehicle_does_what_the_model_says(seed):
    """Orders arrive late, repeatedly, in any sequence or never, while the vehicle drives."""
    pair = Pair(Random(seed))
    told = []
    for step in steps(pair):
        told.append(step)
        try:
            pair.check()
        except AssertionError as error:
            raise AssertionError(f'{error}\n' + '\n'.join(map(str, told))) from None


class ObeysANumberAgain(Vehicle):
    def judge(self, order):
        kept = self.state
        self.state = replace(kept, order=min(kept.order, max(order.order - 1, 0)), refused=0)
        judgement = super().judge(order)
        self.state = kept
        return judgement


class ObeysWhatItRefused(Vehicle):
    def judge(self, order):
        kept, self.state = self.state, replace(self.state, refused=0)
        judgement = super().judge(order)
        self.state = kept
        return judgement


class ObeysOrdersOfAnOlderEpoch(Vehicle):
    def judge(self, order):
        return super().judge(replace(order, known_epoch=self.state.epoch))


class BeginsWhereTheOrderBegins(Vehicle):
    def judge(self, order):
        answer = super().judge(order)
        wrong = answer.reason.code is ReasonCode.WRONG_CHANGE
        return replace(answer, answer=Answer.ROUTE, done=order.first,
                       rest=order.edges) if wrong else answer


class KeepsItsNumbersInANewEpoch(Vehicle):
    def begin_epoch(self, cause, reason=NO_REASON):
        order = self.state.order
        super().begin_epoch(cause, reason)
        self.state = replace(self.state, order=order)


class KeepsTheEpochForAnotherMaster(Vehicle):
    def begin_epoch(self, cause, reason=NO_REASON):
        if cause is not EpochCause.OTHER_MASTER:
            super().begin_epoch(cause, reason)


class RestartsInTheSameEpoch(Vehicle):
    def begin_epoch(self, cause, reason=NO_REASON):
        if cause is not EpochCause.RESTART:
            super().begin_epoch(cause, reason)


class ForgetsItsRefusals(Vehicle):
    def refuse(self, order, reason):
        kept = self.state
        told = super().refuse(order, reason)
        self.state = kept
        return told


class DrivesOnWhenItsRouteIsLost(Vehicle):
    def fail(self, reason):
        pass


@pytest.mark.parametrize('kind', [
    ObeysANumberAgain, ObeysWhatItRefused, ObeysOrdersOfAnOlderEpoch, BeginsWhereTheOrderBegins,
    KeepsItsNumbersInANewEpoch, KeepsTheEpochForAnotherMaster, RestartsInTheSameEpoch,
    ForgetsItsRefusals, DrivesOnWhenItsRouteIsLost])
def test_a_vehicle_that_leaves_a_rule_out_is_found(kind):
    assert any(not agrees(Pair(Random(seed), kind)) for seed in range(500))


def agrees(pair: Pair) -> bool:
    for _ in steps(pair):
        try:
            pair.check()
        except AssertionError:
            return False
    return True


def test_a_default_state_knows_no_master_and_stands():
    state = VehicleState(5)
    assert (state.master, state.is_running, state.ahead) == (None, False, ())
