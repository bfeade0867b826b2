"""The reports of the plain AGV, and those of its computer while the link between them is lost."""
from __future__ import annotations

from typing import Optional, Tuple

import pytest
from fleet_builders import AGV, graph_of

from route_protocol.values import (
    EpochCause,
    Motion,
    Phase,
    Reason,
    ReasonCode,
    RouteOrder,
)
from world.plain_agv import Agv, LostLink

GRAPH = graph_of({1: (0, 0), 2: (4, 0), 3: (8, 0)}, {1: (1, 2), 2: (2, 3)})
FAULT = Reason(ReasonCode.OTHER, 'a broken belt')
SECOND = 10 ** 9


def numbered(agv: Agv, number: int, *edges: int, epoch: Optional[int] = None) -> RouteOrder:
    return RouteOrder(number, edges, order=number, master='fleet',
                      known_epoch=agv.knows['epoch'] if epoch is None else epoch)


def on_its_way(braking: float = 0.0) -> Agv:
    """Returns an AGV that drives the route 1, 2 and is 2 m along edge 1."""
    agv = Agv(GRAPH, AGV, 1)
    agv.braking = braking
    assert agv.receive(numbered(agv, 5, 1, 2)) is None
    while agv.arc < 2.0:
        agv.drive(0.05)
    return agv


@pytest.mark.parametrize('braking, edge, arc', [(0.0, 1, 2.0), (1.0, 1, 3.0), (3.0, 2, 1.0)])
def test_after_the_loss_of_its_route_it_rolls_on_along_that_route(
        braking: float, edge: int, arc: float) -> None:
    agv = on_its_way(braking)
    agv.fail(FAULT)
    assert agv.told(0).motion is (Motion.COMING_TO_REST if braking else Motion.STANDING)
    agv.drive(10.0)
    assert (agv.edge, agv.arc) == (edge, pytest.approx(arc, abs=0.06))
    assert agv.told(0).motion is Motion.STANDING


def test_it_rolls_no_farther_than_to_the_end_of_the_route_that_it_had() -> None:
    agv = on_its_way(braking=100.0)
    agv.fail(FAULT)
    agv.drive(60.0)
    assert agv.position == (8.0, 0.0) and agv.told(0).motion is Motion.STANDING


def test_a_restart_without_memory_knows_no_master_and_no_order() -> None:
    agv = on_its_way()
    before = agv.told(0)
    agv.forget()
    now = agv.told(0)
    assert (now.master, now.order, now.cause) == ('', 0, EpochCause.RESTART)
    assert now.epoch != before.epoch and now.number > before.number
    refusal = agv.receive(numbered(agv, 6, 1, 2, epoch=before.epoch))
    assert refusal is not None and refusal.reason.code is ReasonCode.OVERRULED


def test_a_restart_with_memory_changes_nothing_that_it_says() -> None:
    agv = on_its_way()
    before = agv.told(0)
    agv.restart()
    now = agv.told(0)
    assert (now.epoch, now.order, now.states) == (before.epoch, before.order, before.states)


@pytest.mark.parametrize('old, location, stamp', [
    (0, (2.0, 0.5), 10 * SECOND), (3 * SECOND, (2.0, 0.5), 7 * SECOND), (None, None, 10 * SECOND)])
def test_it_reports_its_location_also_beside_its_edge(
        old: Optional[int], location: Optional[Tuple[float, float]], stamp: int) -> None:
    agv = on_its_way()
    agv.aside, agv.old = (0.0, 0.5), old
    said = agv.told(10 * SECOND)
    assert said.stamp == stamp
    assert (said.location is None) == (location is None)
    if said.location is not None and location is not None:
        assert (said.location.x, said.location.y) == pytest.approx(location, abs=0.06)


def test_moved_by_a_person_it_says_so_for_a_second() -> None:
    agv = on_its_way()
    agv.move_to(2, 1.0)
    said = agv.told(0)
    assert (said.motion, said.cause, said.is_failed) == (Motion.MOVED, EpochCause.OTHER_GIVER, True)
    agv.drive(1.1)
    assert agv.told(0).motion is Motion.STANDING


def test_without_a_link_the_motion_is_unknown_and_each_route_is_refused() -> None:
    agv = on_its_way()
    link = LostLink(agv, 0.0)
    said = link.told(0)
    assert (said.motion, said.is_failed, said.order) == (Motion.UNKNOWN, True, 5)
    refusal = link.receive(numbered(agv, 6, 1, 2, 2))
    assert refusal is not None and refusal.reason.code is ReasonCode.LOST_LINK
    after = link.told(0)
    assert (after.refused, after.number > said.number) == (6, True)
    agv.drive(60.0)
    assert agv.position == (8.0, 0.0), 'the robot itself knows nothing of the link'


def test_a_robot_that_lost_its_route_with_the_link_has_a_new_epoch_when_the_link_is_back() -> None:
    agv = on_its_way()
    before = agv.told(0).epoch
    link = LostLink(agv, 0.0)
    link.end()
    said = agv.told(0)
    assert (said.epoch != before, said.cause) == (True, EpochCause.LOST_LINK)
    assert (agv.phase, said.order) == (Phase.FAILED, 0)


def test_a_robot_without_a_route_keeps_its_epoch_over_a_lost_link() -> None:
    agv = Agv(GRAPH, AGV, 1)
    before = agv.told(0).epoch
    LostLink(agv, 0.0).end()
    assert agv.told(0).epoch == before


def test_a_stop_during_the_outage_is_obeyed_when_the_link_is_back() -> None:
    agv = on_its_way()
    link = LostLink(agv, 0.0)
    link.receive(numbered(agv, 6))
    said = link.told(0)
    assert (said.order, said.reason.code, said.motion) == (
        6, ReasonCode.STOP_OWED, Motion.UNKNOWN), 'its computer took the stop, and owes it'
    link.end()
    now = agv.told(0)
    assert (now.order, now.edges, agv.phase) == (6, (), Phase.STOPPED)


def test_a_stop_without_a_number_during_the_outage_begins_a_new_epoch_at_once() -> None:
    agv = on_its_way()
    link, before = LostLink(agv, 0.0), agv.knows['epoch']
    link.receive(RouteOrder(0, ()))
    said = link.told(0)
    assert (said.epoch != before, said.cause, said.order) == (True, EpochCause.STOP, 0)
    refusal = link.receive(numbered(agv, 6, 1, 2, epoch=before))
    assert refusal is not None
    link.end()
    assert agv.phase is Phase.STOPPED and agv.told(0).edges == ()


def test_a_stop_during_an_outage_ends_a_complete_route_too() -> None:
    agv = on_its_way()
    agv.drive(60.0)
    link = LostLink(agv, 0.0)
    link.receive(numbered(agv, 6))
    link.end()
    said = agv.told(0)
    assert (said.order, said.edges, said.done, said.cause) == (6, (), 2, EpochCause.RESTART)
