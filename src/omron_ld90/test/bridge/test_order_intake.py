"""Orders are due, wait, or are refused with one note to people about the reason."""
from __future__ import annotations

from dataclasses import replace
from typing import List, Optional, Tuple

import pytest

from omron_ld90.bridge.events import RobotSeen
from omron_ld90.bridge.order_intake import OrderIntake
from omron_ld90.bridge.robot_monitor import RobotMonitor
from omron_ld90.bridge.route_strategies import Settings
from route_protocol.old_masters import LATE_ORDER
from route_protocol.values import (
    ANSWERED_WITHIN,
    EMERGENCY_STOP,
    NO_REASON,
    TAKEN_OVER,
    Phase,
    Reason,
    ReasonCode,
    RouteOrder,
)
from route_protocol.vehicle import Vehicle

NANOSECONDS = 1_000_000_000
PATIENCE = 3.5
OFF_GRAPH = Reason(ReasonCode.OFF_GRAPH, 'off the graph')
NO_LOCATION = Reason(ReasonCode.NO_LOCATION, 'the robot has not reported its location')
NO_GRAPH = Reason(ReasonCode.NOT_READY, 'there is no graph')


def order(route_id: int = 7, sent: float = 100.0, received: float = 100.0,
          edges: Tuple[int, ...] = (1, 2)) -> RouteOrder:
    return RouteOrder(route_id, edges, int(sent * NANOSECONDS), int(received * NANOSECONDS))


class Bench:
    """An intake, and its notes and refusals."""

    def __init__(self, patience: float = PATIENCE) -> None:
        self.unknown = NO_REASON
        self.refusals: List[Tuple[int, Reason]] = []
        self.notes: List[str] = []
        self.robot = RobotMonitor(Settings())
        self.vehicle = Vehicle(lambda: 5, lambda: 0)
        self.intake = OrderIntake(
            self.vehicle, self.robot, patience,
            lambda refusal: self.refusals.append((refusal.route_id, refusal.reason)),
            self.notes.append)

    def take(self, order: RouteOrder, now: float) -> bool:
        return self.intake.arrived(order, now)

    def due(self, now: float) -> Optional[RouteOrder]:
        due = self.intake.due(lambda now: self.unknown, now)
        return due and due.given

    def drive(self, given: RouteOrder, phase: Phase = Phase.RUNNING) -> None:
        """The order was taken before, and its route is in this phase now."""
        numbered = self.intake.old_masters.numbered(given, self.vehicle.state)
        self.vehicle.take(numbered, self.vehicle.state.done)
        self.intake.taken(given, 100.0)
        if phase is Phase.COMPLETE:
            self.vehicle.complete(len(given.edges))

    def press_emergency_stop(self, pressed: bool, now: float) -> None:
        self.robot.update(RobotSeen(int(now * NANOSECONDS), emergency_stop=pressed), now)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_an_order_is_due_once(bench):
    assert bench.take(order(), 100.0)
    assert bench.due(100.0) == order()
    assert bench.due(100.1) is None


def test_one_waits_until_the_robot_is_known(bench):
    bench.unknown = NO_LOCATION
    bench.take(order(), 100.0)
    assert bench.due(100.0 + PATIENCE) is None
    bench.unknown = NO_REASON
    assert bench.due(100.0 + PATIENCE) == order()


def test_but_not_for_ever(bench):
    bench.unknown = NO_GRAPH
    bench.take(order(), 100.0)
    assert bench.due(100.1 + PATIENCE) is None
    assert bench.refusals == [(7, NO_GRAPH)]
    bench.unknown = NO_REASON
    assert bench.due(106.0) is None


def test_nor_longer_when_it_is_repeated(bench):
    bench.unknown = NO_LOCATION
    for second in range(4):
        bench.take(order(received=100.0 + second), 100.0 + second)
    assert bench.due(100.1 + PATIENCE) is None
    assert bench.refusals == [(7, NO_LOCATION)]


def test_nor_longer_than_the_route_protocol_allows():
    bench = Bench(patience=60.0)
    bench.unknown = NO_LOCATION
    bench.take(order(), 100.0)
    assert bench.due(100.1 + ANSWERED_WITHIN) is None
    assert bench.refusals == [(7, NO_LOCATION)]


def test_an_order_that_waits_does_not_pass_a_stop(bench):
    bench.take(order(), 100.0)
    assert bench.take(order(8, edges=()), 100.0)
    assert bench.due(100.0) is None
    assert not bench.refusals


def test_who_takes_the_robot_over_is_passed_by_no_order_that_waits(bench):
    bench.take(order(), 100.0)
    bench.intake.epoch_began(100.5)
    assert bench.due(100.5) is None
    assert bench.refusals == [(7, TAKEN_OVER)]


@pytest.mark.parametrize('sent, taken, is_taken', [
    (99.0, 100.6, False), (100.55, 100.6, True), (99.0, 100.5 + LATE_ORDER, True)])
def test_nor_by_one_that_was_on_its_way(bench, sent, taken, is_taken):
    bench.intake.epoch_began(100.5)
    assert bench.take(order(sent=sent, received=taken), taken) is is_taken


def test_a_refused_order_is_refused_again_with_the_same_reason(bench):
    bench.take(order(), 100.0)
    bench.intake.refuse(bench.due(100.0), OFF_GRAPH)
    assert not bench.take(order(), 101.0)
    assert bench.refusals == [(7, OFF_GRAPH)] * 2


def test_one_without_a_stamp_may_be_a_new_one_and_is_judged_again(bench):
    for now in (100.0, 101.0):
        assert bench.take(order(sent=0.0), now)
        bench.intake.refuse(bench.due(now), OFF_GRAPH)


def test_but_not_when_its_latching_publisher_only_connects_again(bench):
    bench.take(order(sent=0.0), 100.0)
    bench.intake.refuse(bench.due(100.0), OFF_GRAPH)
    assert not bench.take(replace(order(sent=0.0), comes_again=True), 101.0)
    assert [route_id for route_id, _ in bench.refusals] == [7, 7]
    assert bench.due(101.0) is None


@pytest.mark.parametrize('latched', [
    order(), replace(order(sent=0.0), known_epoch=5)], ids=['stamp', 'epoch'])
def test_a_latched_order_that_says_when_it_was_given_may_come_with_a_connection(bench, latched):
    assert bench.take(replace(latched, comes_again=True), 100.0)


def test_a_latched_order_that_is_driven_already_is_no_refusal(bench):
    again = replace(order(sent=0.0), comes_again=True)
    bench.drive(order(sent=0.0))
    assert not bench.take(again, 100.0)
    assert not bench.refusals


def test_an_order_without_a_stamp_that_comes_after_a_take_over_is_not_passed_by_it(bench):
    bench.intake.epoch_began(100.5)
    assert bench.take(order(sent=0.0), 100.5)


@pytest.mark.parametrize('sent, is_taken', [(99.9, False), (100.0, True), (100.1, True)])
def test_an_order_is_late_that_was_sent_before_that_of_the_route(bench, sent, is_taken):
    longer = order(sent=sent, edges=(1, 2, 3))
    bench.drive(order())
    assert bench.take(longer, 100.2) is is_taken
    assert len(bench.notes) == (not is_taken)


def test_no_order_is_late_where_the_clock_was_set_back(bench):
    """Applies to this computer's clock: if only the sender's was set back, the stamps show a late
    order.
    """
    after = order(sent=100.0 - 60.0, edges=(1, 2, 3))
    bench.drive(order())
    assert bench.take(replace(after, received=int((100.1 - 60.0) * 1e9)), 101.0)
    assert not bench.take(replace(after, received=int(100.1 * 1e9)), 101.0)


@pytest.mark.parametrize('phase, notes', [
    (Phase.RUNNING, []), (Phase.COMPLETE, ['Route 7 is ignored: it is complete. Another drive '
                                           'needs another id.'])])
def test_an_order_that_comes_again_is_told_once_where_its_route_is_over(bench, phase, notes):
    bench.drive(order(), phase)
    for _ in range(3):
        assert not bench.take(order(), 101.0)
    assert (bench.notes, bench.refusals) == (notes, [])


def test_in_an_emergency_stop_an_order_does_not_wait_for_what_is_unknown(bench):
    bench.unknown = NO_LOCATION
    bench.press_emergency_stop(True, 100.0)
    bench.take(order(), 100.0)
    assert bench.due(100.0) is None
    assert bench.refusals == [(7, EMERGENCY_STOP)]


def test_after_an_emergency_stop_refusals_are_noted_again(bench):
    bench.press_emergency_stop(True, 100.0)
    bench.take(order(), 100.0)
    bench.due(100.0)
    bench.press_emergency_stop(False, 101.0)
    bench.take(order(8), 101.0)
    bench.intake.refuse(bench.due(101.0), OFF_GRAPH)
    assert bench.notes[1:] == ['Route 8 was refused: off the graph.']


def test_in_an_emergency_stop_only_the_first_refusal_is_noted_and_the_end_of_it(bench):
    bench.press_emergency_stop(True, 100.0)
    for count in range(3):
        bench.take(order(7 + count), 100.0 + count)
        assert bench.due(100.0 + count) is None
    assert [reason for _, reason in bench.refusals] == [EMERGENCY_STOP] * 3
    assert len(bench.notes) == 1
    bench.press_emergency_stop(False, 104.0)
    for route_id in (10, 11):
        bench.take(order(route_id), 104.0)
        bench.intake.taken(bench.due(104.0), 104.0)
    assert bench.notes[1:] == ['Route 10 is driven: the emergency stop is over.']
