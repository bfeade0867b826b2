"""Numbered orders at a simulated AGV: each row of the table in `route_protocol.vehicle`."""
from __future__ import annotations

from typing import Optional

import pytest
from agv_builders import TICK, Conversation

from fleet_simulation.agv.faults import UnknownAgvFault, inject
from route_protocol.values import (
    EdgeState,
    EpochCause,
    Motion,
    Phase,
    Reason,
    ReasonCode,
    RouteOrder,
)

FAULT = Reason(ReasonCode.OTHER, 'a broken belt')


class NumberedConversation(Conversation):
    """An AGV and a master that numbers its orders."""

    def give(self, number: int, *edges: int, first: int = 0, epoch: Optional[int] = None,
             master: str = 'fleet') -> None:
        known = self.vehicle.state.epoch if epoch is None else epoch
        self.vehicle.handle(RouteOrder(number, edges, known_epoch=known, order=number, first=first,
                                       master=master))
        self._listen()

    @property
    def refusal(self) -> ReasonCode:
        return self.vehicle.state.refusal.code

    def is_at(self, order: int, refused: int, phase: Phase) -> None:
        state = self.vehicle.state
        assert (state.order, state.refused, state.phase) == (order, refused, phase), state


def driving(*edges: int, to: float = 2.0) -> NumberedConversation:
    agv = NumberedConversation()
    agv.give(5, *edges)
    agv.drive_to(to)
    return agv


def test_a_stop_without_a_number_begins_a_new_epoch() -> None:
    agv = driving(1, 2)
    before = agv.last.epoch
    agv.order(0)
    assert (agv.last.epoch != before, agv.last.cause) == (True, EpochCause.STOP)
    agv.is_at(0, 0, Phase.STOPPED)
    agv.wait(5.0)
    agv.give(6, 1, 2, epoch=before)
    agv.is_at(0, 6, Phase.STOPPED)
    assert agv.refusal is ReasonCode.OVERRULED, 'what was on its way is over'


@pytest.mark.parametrize('number', [4, 5])
@pytest.mark.parametrize('edges', [(), (1, 2, 3)])
def test_an_order_that_is_not_newer_is_ignored(number: int, edges: tuple) -> None:
    agv = driving(1, 2)
    heard = len(agv.reports)
    agv.give(number, *edges)
    agv.is_at(5, 0, Phase.RUNNING)
    assert (len(agv.reports), agv.refusals, agv.last.edges) == (heard, [], (1, 2))


def test_an_order_that_is_not_newer_than_a_refused_one_is_ignored() -> None:
    agv = driving(1, 2)
    agv.give(8, 3, first=7)
    agv.give(7, 1, 2, 3)
    agv.is_at(5, 8, Phase.RUNNING)
    assert agv.last.edges == (1, 2)


def test_a_newer_stop_is_taken_in_the_same_epoch_whatever_epoch_it_names() -> None:
    agv = driving(1, 2)
    epoch = agv.last.epoch
    agv.give(6, epoch=epoch + 1)
    agv.is_at(6, 0, Phase.STOPPED)
    assert (agv.last.epoch, agv.last.motion) == (epoch, Motion.COMING_TO_REST)
    agv.wait(5.0)
    assert agv.last.motion is Motion.STANDING


def test_a_stop_of_another_master_begins_a_new_epoch() -> None:
    agv = driving(1, 2)
    before = agv.last.epoch
    agv.give(1, master='other')
    assert agv.last.epoch != before and agv.last.cause is EpochCause.OTHER_MASTER
    assert (agv.last.master, agv.last.order) == ('other', 1)
    assert agv.last.motion is Motion.MOVED, 'it still rolls along a route of the first master'


@pytest.mark.parametrize('epoch', [0, 1])
def test_a_route_that_was_not_decided_in_this_epoch_is_refused(epoch: int) -> None:
    agv = driving(1, 2)
    agv.give(6, 1, 2, 3, epoch=epoch)
    agv.is_at(5, 6, Phase.RUNNING)
    assert agv.refusal is ReasonCode.OVERRULED


@pytest.mark.parametrize('first, edges', [(1, (2, 3)), (7, (1, 2))])
def test_a_route_whose_numbers_do_not_hold_the_edge_under_way_is_refused(
        first: int, edges: tuple) -> None:
    agv = driving(1, 2)
    agv.give(6, *edges, first=first)
    agv.is_at(5, 6, Phase.RUNNING)
    assert agv.refusal is ReasonCode.WRONG_CHANGE


def test_a_route_that_does_not_go_on_with_the_edge_under_way_is_refused() -> None:
    agv = driving(1, 2, to=5.0)
    agv.give(6, 1, 4)
    agv.is_at(5, 6, Phase.RUNNING)
    assert agv.refusal is ReasonCode.WRONG_CHANGE


def test_a_route_of_another_master_that_it_can_begin_is_taken() -> None:
    agv = driving(1, 2)
    before = agv.last.epoch
    agv.give(1, 1, 4, first=40, master='other')
    assert agv.last.epoch != before and agv.last.cause is EpochCause.OTHER_MASTER
    assert (agv.last.master, agv.last.order, agv.last.done) == ('other', 1, 40)
    assert agv.last.motion is Motion.ON_ROUTE
    agv.give(6, 1, 2, 3, epoch=before)
    assert agv.last.order == 1, 'the first master has lost the vehicle'


def test_a_route_of_another_master_that_it_cannot_begin_is_refused_but_not_counted() -> None:
    agv = driving(1, 2)
    agv.give(9, 3, master='other')
    agv.is_at(5, 0, Phase.RUNNING)
    assert agv.refusals[-1].order == 9 and agv.last.master == 'fleet'


def test_a_route_gets_longer_shorter_and_passes_a_place_twice() -> None:
    agv = driving(1, 2)
    agv.give(6, 1, -1, 1, 2)
    agv.is_at(6, 0, Phase.RUNNING)
    agv.wait(25.0)
    agv.give(7, 1, 2, first=2)
    agv.wait(30.0)
    agv.is_at(7, 0, Phase.COMPLETE)
    assert (agv.last.done, agv.last.first, agv.vehicle.pose[0]) == (4, 2, pytest.approx(8.0))


def test_a_route_that_it_cannot_drive_is_refused() -> None:
    agv = driving(1, 2, 3, to=3.6)
    agv.give(6, 1)
    agv.is_at(5, 6, Phase.RUNNING)
    assert agv.refusal is ReasonCode.CANNOT_BRAKE


def test_after_a_failure_the_order_stays_and_a_route_goes_on_from_its_edge() -> None:
    agv = driving(1, 2)
    agv.vehicle.fail(FAULT)
    agv.is_at(5, 0, Phase.FAILED)
    assert agv.last.motion is Motion.COMING_TO_REST
    agv.give(6, 1, 2, 3)
    agv.is_at(5, 0, Phase.FAILED)
    agv.wait(20.0)
    agv.is_at(6, 0, Phase.COMPLETE)
    assert agv.refusals == [], 'the route had to wait until the vehicle stood'


def test_a_route_that_waits_is_not_lost_to_one_that_is_refused() -> None:
    agv = driving(1, 2)
    agv.vehicle.fail(FAULT)
    agv.give(6, 1, 2, 3)
    agv.give(1, 9, master='other')
    agv.give(5, 1)
    agv.wait(20.0)
    agv.is_at(6, 0, Phase.COMPLETE)


@pytest.mark.parametrize('line, cause, motion', [
    ('estop', EpochCause.EMERGENCY_STOP, Motion.COMING_TO_REST),
    ('takeover', EpochCause.OTHER_GIVER, Motion.COMING_TO_REST),
    ('offgraph', EpochCause.OTHER_GIVER, Motion.MOVED),
    ('place 3', EpochCause.OTHER_GIVER, Motion.MOVED),
    ('drive_by_hand 1', EpochCause.OTHER_GIVER, Motion.MOVED),
    ('leave', EpochCause.RESTART, Motion.UNKNOWN)])
def test_what_begins_a_new_epoch(line: str, cause: EpochCause, motion: Motion) -> None:
    agv = driving(1, 2)
    before = agv.last
    inject(agv.vehicle, line)
    agv.wait(TICK)
    now = agv.last
    assert (now.epoch != before.epoch, now.cause, now.motion) == (True, cause, motion)
    assert (now.order, now.refused, now.number > before.number) == (0, 0, True)
    inject(agv.vehicle, 'join')
    agv.wait(10.0)
    assert agv.last.motion is Motion.STANDING
    agv.give(6, 1, 2, epoch=before.epoch)
    assert agv.refusals[-1].reason.code is ReasonCode.OVERRULED


def test_another_program_drives_it_to_the_end_of_an_edge() -> None:
    agv = driving(1)
    agv.wait(10.0)
    inject(agv.vehicle, 'drive_by_hand 2')
    agv.wait(1.0)
    agv.give(6, 2, 3)
    assert agv.refusal is ReasonCode.TAKEN_OVER
    agv.wait(10.0)
    assert (agv.last.motion, agv.vehicle.drive.vertex) == (Motion.STANDING, 3)
    agv.give(7, 3)
    agv.is_at(7, 6, Phase.RUNNING)


def test_a_stop_ends_the_drive_of_another_program() -> None:
    agv = NumberedConversation()
    inject(agv.vehicle, 'drive_by_hand 1')
    agv.drive_to(1.5)
    agv.give(6)
    assert agv.last.motion is Motion.MOVED
    agv.wait(10.0)
    assert agv.last.motion is Motion.STANDING and agv.vehicle.pose[0] < 3.5


def test_an_edge_that_begins_elsewhere_cannot_be_driven_by_hand() -> None:
    with pytest.raises(UnknownAgvFault, match='edge 2 does not start where the vehicle is'):
        inject(NumberedConversation().vehicle, 'drive_by_hand 2')


def test_an_old_master_that_takes_over_ends_what_is_on_its_way() -> None:
    agv = driving(1, 2)
    before = agv.last.epoch
    agv.order(70, 1, 4)
    assert (agv.last.master, agv.last.cause) == ('', EpochCause.OTHER_MASTER)
    agv.give(6, 1, 2, 3, epoch=before)
    assert agv.last.route_id == 70 and agv.refusals[-1].reason.code is ReasonCode.OVERRULED


def test_numbers_of_reports_grow() -> None:
    agv = driving(1, 2)
    agv.wait(20.0)
    numbers = [report.number for report in agv.reports]
    assert numbers == sorted(set(numbers))


# -- masters with and without numbers --------------------------------------------------------------

def test_a_refused_route_is_told_to_an_old_master_unless_the_reports_show_a_route_of_that_id(
        ) -> None:
    agv = NumberedConversation()
    agv.order(0, 3)
    assert [report.states for report in agv.reports] == [(EdgeState.FAILED,)]
    agv.order(4, 1, 2)
    heard = len(agv.reports)
    agv.order(4, 1, 3)
    assert len(agv.refusals) == 2 and len(agv.reports) == heard, 'the route itself goes on'


def test_a_route_that_waits_is_refused_when_another_master_orders() -> None:
    agv = driving(1, 2)
    agv.give(6)
    agv.give(7, 1, 2)
    agv.give(1, -1, master='other')
    assert [one.order for one in agv.refusals] == [7]
    agv.is_at(6, 7, Phase.STOPPED)
    agv.wait(5.0)
    assert (agv.vehicle.state.master, agv.last.edges) == ('other', (-1,))


def test_a_route_of_an_old_master_that_was_sent_before_a_numbered_stop_is_late() -> None:
    agv = driving(1, 2)
    agv.vehicle.handle(RouteOrder(9, (), stamp=2_000, order=6, master='fleet'))
    agv.wait(5.0)
    agv.order(8, 1, 2, stamp=1_000)
    agv.is_at(6, 0, Phase.STOPPED)
