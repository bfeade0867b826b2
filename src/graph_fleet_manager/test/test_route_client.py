"""The fleet manager's side of the route protocol."""
from __future__ import annotations

import math
from dataclasses import replace
from itertools import count

import pytest
from fleet_builders import AGV, corridor, graph_of

from graph_fleet_manager.geometry.areas import Area
from graph_fleet_manager.interlocking.allocation import Hold
from graph_fleet_manager.interlocking.evidence import MANUAL_REACH
from graph_fleet_manager.interlocking.pending_order import REPEAT
from graph_fleet_manager.interlocking.reports import (
    NEAR,
    GraphPosition,
    Pose,
    Report,
    WrongReport,
    check_report,
    point_of,
    position_of,
)
from graph_fleet_manager.interlocking.route_client import RouteClient
from graph_fleet_manager.interlocking.route_record import RouteRecord
from route_protocol.values import (
    EdgeState,
    Reason,
    ReasonCode,
    RouteRefusal,
    reason_of,
)

DONE, AHEAD, FAILED = EdgeState.COMPLETE, EdgeState.PROCESSING, EdgeState.FAILED
GRAPH = corridor(6)  # vertices 1 to 6, edges of 2 m from k to k + 1


def no(text: str) -> Reason:
    """The reason of a refusal, with a text only."""
    return reason_of(0, text)


@pytest.fixture
def client():
    client = RouteClient(RouteRecord(GRAPH, AGV))
    client.record.position = GraphPosition(vertex=1)
    client.is_heard = True
    return client


@pytest.fixture
def ids():
    numbers = count(1)
    return lambda: next(numbers)


def report(id, edges, completed, fraction=0.0, state=AHEAD, reason='', age=0.0):
    states = (DONE,) * completed + (state,) * (len(edges) - completed)
    pose = Pose(edges[completed], fraction) if completed < len(edges) else Pose(edges[-1], 1.0)
    return Report(id, tuple(edges), states, pose, reason_of(0, reason), 100.0, age)


def restarted(client, graph=GRAPH):
    """The client after a restart of the fleet manager, perhaps with another graph."""
    again = RouteClient(RouteRecord(graph, AGV))
    again.restore(client.memory.on(graph))
    return again


def test_an_order_is_repeated_unchanged_until_the_report_has_its_length(client, ids):
    client.extend([1, 2], ids)
    first = client.due(0.0)
    assert (first.route_id, first.edges, first.repeated) == (1, (1, 2), False)
    assert client.due(REPEAT / 2) is None
    again = client.due(REPEAT)
    assert again == first._replace(repeated=True)
    client.take(report(1, [1], 0))
    assert client.due(2 * REPEAT) is not None
    client.take(report(1, [1, 2], 0))
    assert client.due(3 * REPEAT) is None


def test_an_extension_keeps_the_id_and_another_mission_takes_a_new_one(client, ids):
    client.extend([1, 2], ids)
    client.take(report(1, [1, 2], 1))
    client.extend([3], ids)
    assert client.due(0.0)[:2] == (1, (1, 2, 3))
    client.extend([4], ids, renew=True)
    assert client.due(0.0)[:2] == (2, (2, 3, 4)), 'the order must begin on the edge being driven'


def test_what_is_passed_is_told_once_whatever_is_reported_twice_or_late(client, ids):
    client.extend([1, 2, 3], ids)
    assert client.take(report(1, [1, 2, 3], 2)).passed == [2, 3]
    assert client.take(report(1, [1, 2, 3], 2)).passed == []
    assert client.take(report(1, [1, 2, 3], 1)).passed == []
    assert client.record.done == 2


def test_what_a_person_drives_after_a_failed_route_leaves_nothing(client, ids):
    """The person may drive the robot back again."""
    client.extend([1, 2], ids)
    client.take(report(1, [1, 2], 0, fraction=0.2))
    client.take(report(1, [1, 2], 0, fraction=0.9, state=FAILED, reason='taken over'))
    assert client.record.cleared == (0, pytest.approx(0.1))


@pytest.mark.parametrize('late', [True, False])
def test_what_was_reported_before_a_refusal_does_not_tell_what_the_robot_has(client, ids, late):
    """It has accepted one order, and refused the next; the reports come after the refusal."""
    client.extend([1], ids)
    client.take(report(1, [1], 0))
    client.extend([2, 3], ids)
    client.due(0.0)
    client.extend([4], ids)
    client.due(0.0)
    client.refuse(RouteRefusal(1, (1, 2, 3, 4), no('no')), stamp=100.5)
    if late:
        client.take(report(1, [1], 0))
        assert client.record.held == (1, 2, 3, 4) and not client.is_ready
    client.take(replace(report(1, [1, 2, 3], 0), stamp=100.6))
    assert client.record.held == (1, 2, 3) and client.is_ready


def test_an_edge_is_left_by_the_reported_place_less_what_its_age_allows(client, ids):
    client.extend([1, 2], ids)
    client.take(report(1, [1, 2], 0, fraction=0.5, age=0.4))
    assert client.record.cleared == (0, pytest.approx(0.2))
    client.take(report(1, [1, 2], 1, fraction=0.1, age=0.4))
    assert client.record.cleared == (0, pytest.approx(0.8))
    client.take(report(1, [1, 2], 1, fraction=0.0, age=5.0))
    assert client.record.cleared == (0, pytest.approx(0.8)), 'a left part of an edge must stay left'


def test_a_refused_extension_waits_for_the_truth_and_takes_a_new_id(client, ids):
    client.extend([1], ids)
    client.take(report(1, [1], 0))
    client.extend([2, 3], ids)
    assert client.refuse(RouteRefusal(1, (1, 2, 3), no('no'))).refused.text == 'no'
    assert not client.is_ready and client.due(10.0) is None
    client.take(report(1, [1], 0, fraction=0.2))
    assert client.is_ready and client.record.ahead == (1,)
    client.extend([2], ids)
    assert client.due(10.0)[:2] == (2, (1, 2))


def test_all_failed_as_the_first_word_about_an_id_is_a_refusal_and_no_failure(client, ids):
    client.extend([1], ids)
    client.take(report(1, [1], 0))
    client.extend([2], ids, renew=True)
    heard = client.take(report(2, [1, 2], 0, state=FAILED, reason='not where the robot is'))
    assert heard.refused.text == 'not where the robot is' and not heard.failed


def test_a_route_that_stays_failed_after_it_was_refused_is_what_the_robot_has(client, ids):
    """The route failed before any report of it running arrived."""
    client.extend([1, 2], ids)
    failed = report(1, [1, 2], 0, fraction=0.2, state=FAILED, reason='blocked')
    assert client.take(failed).refused.text == 'blocked'
    again = client.take(failed)
    assert not again.refused and not again.failed and not client.is_ready, (
        'the same message again must not count')
    assert client.take(replace(failed, stamp=100.1)).failed.text == 'blocked'
    assert client.record.held == (1, 2) and client.is_ready


@pytest.mark.parametrize('stamp', [100.5, 0.0])
def test_a_refusal_that_comes_on_its_topic_and_as_a_report_is_one(client, ids, stamp):
    client.extend([1], ids)
    client.take(report(1, [1], 0))
    client.extend([2], ids, renew=True)
    refusal = RouteRefusal(2, (1, 2), no('no'))
    assert client.refuse(refusal, stamp).refused.text == 'no'
    heard = client.take(report(2, [1, 2], 0, state=FAILED, reason='no'))
    assert not heard.refused and not heard.failed and not client.is_ready
    client.take(replace(report(1, [1], 0), stamp=100.6))
    assert client.is_ready and client.record.held == (1,)


def test_a_route_that_fails_says_why_and_stays_the_robots(client, ids):
    client.extend([1, 2], ids)
    client.take(report(1, [1, 2], 0))
    heard = client.take(report(1, [1, 2], 1, state=FAILED, reason='off the corridor'))
    assert heard.failed.text == 'off the corridor'
    assert client.record.ahead == (2,)


def test_shortening_frees_nothing_before_a_report_shows_it(client, ids):
    client.extend([1, 2, 3], ids)
    client.take(report(1, [1, 2, 3], 0))
    assert client.shorten(ids)
    assert client.due(0.0)[:2] == (1, (1,))
    assert client.record.held == (1, 2, 3)
    client.take(report(1, [1, 2, 3], 0, fraction=0.1))
    assert client.record.held == (1, 2, 3)
    client.take(report(1, [1], 0, fraction=0.2))
    assert client.record.held == (1,) and not client.shorten(ids)


def test_a_stop_holds_everything_until_the_place_is_known(client, ids):
    client.extend([1, 2], ids)
    client.take(report(1, [1, 2], 0))
    client.halt(ids)
    assert client.due(0.0)[:2] == (2, ())
    client.take(Report(2, pose=Pose(1, 0.5), stamp=101.0))
    assert client.record.held == (1, 2) and client.order is None
    client.settle(GraphPosition(edge=1, fraction=0.5))
    assert client.record.held == () and client.record.is_standing


def test_a_route_of_somebody_else_is_noticed(client, ids):
    client.extend([1], ids)
    client.take(report(1, [1], 1))
    assert client.take(report(77, [2, 3], 0)).foreign


def test_what_was_refused_for_a_route_of_somebody_else_stays_held(client, ids):
    """The robot may be driving its earlier order, under the other giver's id."""
    client.extend([1, 2], ids)
    client.take(report(1, [1, 2], 1))
    client.extend([3], ids)
    client.refuse(RouteRefusal(1, (1, 2, 3), no('edge 1 does not start here')), stamp=100.5)
    assert client.take(replace(report(77, [2], 0), stamp=100.6)).foreign
    assert client.record.ahead == (2, 3)


def test_a_robot_that_left_the_end_of_its_route_is_noticed(client, ids):
    client.extend([1], ids)
    assert not client.take(report(1, [1], 1)).left
    away = Report(1, (1,), (DONE,), Pose(2, 0.5), stamp=101.0)
    assert not client.take(away).left, 'a single location may be an outlier'
    assert client.take(replace(away, stamp=102.0)).left


def test_a_robot_on_what_it_was_to_be_told_of_is_not_where_it_stood_once_that_is_taken_back(
        client, ids):
    """A person pushed it onto edge 2; the order for that edge was granted, but never sent."""
    client.take(Report(0, (), (), Pose(1, 0.0), stamp=100.0))
    client.extend([1, 2], ids)
    client.take(Report(0, (), (), Pose(2, 0.5), stamp=101.0))
    assert not client.shorten(ids)
    assert [area.line for area in client.allocation.areas] == [((3.0, 0.0),)]
    assert client.take(Report(0, (), (), Pose(2, 0.5), stamp=102.0)).left


def test_a_robot_that_falls_silent_as_it_arrives_was_not_moved_by_another_giver(client, ids):
    client.extend([1], ids)
    client.take(report(1, [1], 0, fraction=0.5))
    client.take(replace(report(1, [1], 1), stamp=101.0))
    assert not client.grow(5.0)


def test_a_robot_that_brakes_after_a_stop_is_not_moved_by_another_giver(client, ids):
    client.extend([1, 2], ids)
    client.take(report(1, [1, 2], 0, fraction=0.5))
    client.halt(ids)
    client.take(Report(2, (), (), Pose(1, 0.7), stamp=100.5))
    client.take(Report(2, (), (), Pose(1, 0.9), stamp=101.0))
    assert not client.grow(5.0)
    client.take(Report(2, (), (), Pose(2, 0.2), stamp=101.5))
    assert client.grow(5.0), 'it has moved farther than it needs for braking'


def test_a_robot_that_a_person_drives_may_be_farther_on_while_it_is_silent(client):
    client.take(Report(0, (), (), Pose(1, 0.0), stamp=100.0))
    client.take(Report(0, (), (), Pose(1, 0.3), stamp=101.0))
    assert client.grow(5.0)


def test_a_robot_that_a_person_drives_slowly_may_be_farther_on_while_it_is_silent(client):
    for tick in range(11):  # 0.2 m/s: 0.02 m between two reports
        client.take(Report(0, (), (), Pose(1, 0.01 * tick), stamp=100.0 + 0.1 * tick))
    assert client.grow(5.0)


def test_a_robot_that_a_person_has_parked_does_not_grow_while_it_is_silent(client):
    client.take(Report(0, (), (), Pose(1, 0.0), stamp=100.0))
    for stamp in (101.0, 101.5, 102.0):
        client.take(Report(0, (), (), Pose(1, 0.3), stamp=stamp))
    assert not client.grow(5.0)


def test_a_robot_that_waits_on_a_route_of_another_giver_may_be_farther_on_while_it_is_silent(
        client):
    for stamp in (100.0, 101.0, 102.0):
        client.take(replace(report(77, [2, 3], 0), stamp=stamp))
    assert client.grow(5.0)


def test_a_restart_does_not_forget_that_a_person_drives_the_robot(client):
    stored = client.memory
    for tick in range(30):
        before = client.progress
        client.take(Report(0, (), (), Pose(1, 0.025 * tick), stamp=100.0 + 0.1 * tick))
        if client.progress != before:
            stored = client.memory
    again = RouteClient(RouteRecord(GRAPH, AGV))
    again.restore(stored)
    area = max(again.allocation.areas, key=lambda area: area.radius)
    where = point_of(GRAPH, Pose(1, 0.725))
    assert math.dist(area.line[0], where) + MANUAL_REACH <= area.radius
    assert not again.grow(1.0)
    again.take(Report(0, (), (), Pose(1, 0.8), stamp=104.0))
    assert again.evidence.reach == 0.0, 'it is known again where the robot is'


def test_the_first_report_after_a_restart_shows_that_a_person_has_moved_the_robot(client):
    client.take(Report(0, (), (), Pose(1, 0.0), stamp=100.0))
    client.take(Report(0, (), (), Pose(1, 0.0), stamp=102.0))
    again = restarted(client)
    again.take(Report(0, (), (), Pose(2, 0.5), stamp=110.0))
    assert again.grow(5.0)


def test_a_robot_that_a_person_takes_over_does_not_brake(client, ids):
    client.extend([1, 2], ids)
    client.take(report(1, [1, 2], 0, fraction=0.5))
    taken = Reason(ReasonCode.TAKEN_OVER, 'a person drives it')
    client.take(replace(report(1, [1, 2], 0, 0.7, FAILED), reason=taken, stamp=101.0))
    assert client.grow(5.0)


def test_a_robot_that_drove_on_unheard_and_then_stopped_was_not_moved_by_another_giver(client, ids):
    client.extend([1, 2, 3], ids)
    client.take(report(1, [1, 2, 3], 0, fraction=0.5))
    client.take(Report(77, (), (), Pose(3, 0.5), stamp=110.0))
    assert not client.grow(5.0)


def test_a_robot_on_its_route_was_not_moved_since_an_older_location_in_the_journal(client, ids):
    client.take(Report(0, (), (), Pose(1, 0.0), stamp=100.0))
    client.extend([1, 2], ids)
    again = restarted(client)
    again.take(Report(77, (), (), Pose(2, 0.5), stamp=110.0))
    assert not again.grow(5.0)


def test_a_robot_that_still_moves_seconds_after_its_drive_does_not_brake(client, ids):
    client.extend([1, 2], ids)
    client.take(report(1, [1, 2], 0, fraction=0.5))
    for tick in range(1, 9):
        client.take(replace(report(1, [1, 2], 0, 0.5 + 0.05 * (tick % 3), FAILED),
                            stamp=100.0 + 0.5 * tick))
    assert client.grow(5.0)


def test_a_robot_without_a_clock_does_not_count_as_moved_for_ever(client):
    for fraction in (0.0, 0.3, 0.3):
        client.take(Report(0, (), (), Pose(1, fraction)))
    assert not client.grow(5.0)


def test_a_robot_whose_clock_is_set_back_does_not_count_as_moved_for_ever(client):
    for stamp, fraction in ((5000.0, 0.0), (5000.5, 0.3), (100.0, 0.3), (101.5, 0.3)):
        client.take(Report(0, (), (), Pose(1, fraction), stamp=stamp))
    assert not client.grow(5.0)


def test_a_robot_that_stands_off_its_route_blocks_no_more_because_its_report_comes_late(client):
    away = Report(0, (), (), Pose(3, 0.5), stamp=100.0)
    client.take(replace(away, age=1.0))
    assert [area.radius for area in client.allocation.areas] == [AGV.speed], 'it may still move'
    client.take(replace(away, stamp=100.5, age=2.0))
    assert [area.radius for area in client.allocation.areas] == [2.0 * AGV.speed], 'perhaps slowly'
    client.take(replace(away, stamp=101.0, age=2.0))
    assert [area.radius for area in client.allocation.areas] == [0.0]


@pytest.mark.parametrize('state', [AHEAD, FAILED])
def test_a_route_that_began_on_edges_that_a_new_graph_lacks_is_left_to_a_person(client, ids, state):
    client.extend([1, 2, 3], ids)
    client.due(0.0)
    reloaded = RouteClient(RouteRecord(graph_of({3: (4, 0), 4: (6, 0)}, {3: (3, 4)}), AGV))
    reloaded.restore(client.memory.on(reloaded.record.graph))
    heard = reloaded.take(Report(1, (1, 2, 3), (state,) * 3, Pose(3, 0.0), no('gone'), 101.0))
    assert heard.foreign if state is AHEAD else heard.failed
    assert reloaded.record.held == (3,)


def test_what_was_held_on_another_graph_is_free_once_a_later_stop_is_acknowledged_elsewhere(
        client, ids):
    client.lose([Area(((4.0, 2.0), (6.0, 2.0)))])
    client.take(Report(0, (), (), Pose(1, 0.0), stamp=100.0))
    assert client.allocation.areas, 'an earlier order may still be on its way'
    client.stop_after_loss(ids)
    client.take(Report(0, (), (), Pose(1, 0.0), stamp=101.0))
    assert client.allocation.areas, 'the stop may still be on its way'
    client.take(Report(client.due(0.0).route_id, (), (), Pose(1, 0.0), stamp=102.0))
    assert not client.allocation.areas


def test_a_robot_that_stands_on_an_edge_of_another_graph_keeps_it(client, ids):
    client.lose([Area(((0.0, 0.0), (0.0, 2.0)))])
    client.stop_after_loss(ids)
    client.take(Report(client.due(0.0).route_id, (), (), Pose(1, 0.0), stamp=100.0))
    assert client.allocation.areas


def test_a_robot_that_has_driven_there_and_back_holds_no_more_after_a_restart(client, ids):
    client.extend([1, -1], ids)
    client.take(report(1, [1, -1], 2))
    assert not client.allocation.holds
    again = RouteClient(RouteRecord(GRAPH, AGV))
    again.restore(client.memory)
    assert again.allocation == client.allocation


def test_a_refusal_that_is_heard_after_a_restart_leaves_a_longer_order_on_its_way(client, ids):
    client.extend([1], ids)
    client.due(0.0)
    client.extend([2], ids)
    sent = client.due(1.0)
    again = RouteClient(RouteRecord(GRAPH, AGV))
    again.restore(client.memory)
    heard = again.take(report(1, [1], 0, state=FAILED, reason='no'))
    assert not heard.failed, 'the robot may still take up the longer order'
    assert again.record.ahead == (1, 2)
    assert again.due(0.0).edges == sent.edges


def test_a_failure_of_an_earlier_route_heard_after_a_restart_is_no_refusal_of_the_last_order(
        client, ids):
    client.extend([1, 2], ids)
    client.extend([3], ids, renew=True)
    client.due(0.0)
    again = restarted(client)
    heard = again.take(report(1, [1, 2], 0, state=FAILED, reason='a person drives it'))
    assert heard.failed and again.order is None
    assert again.withdrawn == 2, 'the last order may still be on its way'


def test_a_refusal_by_a_robot_without_a_clock_is_settled_by_its_next_report(client, ids):
    client.extend([1], ids)
    refused = replace(report(1, [1], 0, state=FAILED, reason='no'), stamp=0.0)
    assert client.take(refused).refused
    client.take(refused)
    assert client.is_ready, 'it still waits for a report of the truth'


def test_an_order_that_was_withdrawn_is_not_given_again_by_a_restart(client, ids):
    client.extend([1], ids)
    client.take(report(1, [1], 1))
    client.extend([2], ids, renew=True)
    client.due(0.0)
    client.withdraw()
    again = restarted(client)
    again.take(report(1, [1], 1))
    assert again.order is None and again.withdrawn == 2


def test_a_robot_stays_within_its_allocation_on_a_graph_without_the_beginning_of_its_route(ids):
    """The base of its unacknowledged route lies before the edges that the new graph has."""
    whole = corridor(8)
    client = RouteClient(RouteRecord(whole, AGV))
    client.record.position, client.is_heard = GraphPosition(vertex=1), True
    client.extend([1, 2, 3, 4, 5, -5], ids)
    client.take(report(1, [1, 2, 3, 4, 5, -5], 0))
    client.extend([-4], ids, renew=True)
    client.take(report(1, [1, 2, 3, 4, 5, -5], 3, fraction=0.5))
    left = graph_of({k: (2.0 * (k - 1), 0.0) for k in range(4, 9)},
                    {k: (k, k + 1) for k in range(4, 8)})
    again = restarted(client, left)
    assert 4 in {hold.edge for hold in again.allocation.holds}


def test_a_stop_never_lets_a_robot_turn_back(client, ids):
    client.extend([1, 2, -2, 2], ids)
    client.take(report(1, [1, 2, -2, 2], 1, fraction=0.9))
    before = client.allocation
    client.halt(ids)
    assert client.allocation == before


@pytest.mark.parametrize('has_stopped', [False, True])
def test_an_order_that_is_given_again_lets_only_a_driving_robot_turn_back(client, ids,
                                                                          has_stopped):
    client.extend([1, 2, -2, 2], ids)
    client.take(report(1, [1, 2, -2, 2], 1, fraction=0.9))
    before = client.allocation
    client.try_again(ids, 3, has_stopped)
    assert (client.allocation == before) is has_stopped


@pytest.mark.parametrize('is_restarted', [False, True])
def test_more_edges_under_an_unacknowledged_id_do_not_let_the_robot_turn_back(client, ids,
                                                                              is_restarted):
    """It cannot drive the later edges before it has taken up the route."""
    client.extend([1, 2, 3], ids)
    client.take(report(1, [1, 2, 3], 1, fraction=0.9))
    client.extend([4], ids, renew=True)
    before = client.allocation.holds
    client.extend([-4, -3, -2], ids)
    if is_restarted:
        memory, client = client.memory, RouteClient(RouteRecord(GRAPH, AGV))
        client.restore(memory)
    assert client.allocation.holds == (*before, Hold(-4), Hold(-3), Hold(-2))


def test_an_order_under_a_new_id_lets_a_robot_turn_back_that_comes_to_its_beginning_again(
        client, ids):
    client.extend([1, 2, -2, 2], ids)
    client.take(report(1, [1, 2, -2, 2], 1, fraction=0.9))
    assert client.allocation.holds[0].cleared > 0.0
    assert client.turns_back_if_renewed(True) and not client.turns_back_if_renewed(False)
    client.extend([3], ids, renew=True)
    assert client.allocation.holds[0] == Hold(2)


@pytest.mark.parametrize('is_restarted', [False, True])
def test_a_robot_that_forgot_its_route_holds_what_a_late_copy_leads_over(client, ids, is_restarted):
    client.extend([1, 2, -2], ids)
    client.take(report(1, [1, 2, -2], 3))
    client.extend([-1], ids)
    assert [hold.edge for hold in client.allocation.holds] == [-1]
    if is_restarted:
        memory, client = client.memory, RouteClient(RouteRecord(GRAPH, AGV))
        client.restore(memory)
    client.take(Report(0, (), (), Pose(1, 1.0), stamp=101.0))
    assert client.withdrawn == 1
    assert [hold.edge for hold in client.allocation.holds] == [1, 2, -2, -1]


def test_after_a_restart_an_order_on_its_way_is_repeated_under_its_old_id(client, ids):
    client.extend([1], ids)
    client.take(report(1, [1], 0))
    client.extend([2], ids)
    other = RouteClient(RouteRecord(GRAPH, AGV))
    other.restore(client.memory)
    seen = report(1, [1], 0, fraction=0.5)
    other.take(seen)
    assert other.record.ahead == (1, 2)
    assert other.due(0.0)[:2] == (1, (1, 2))


def test_after_a_restart_without_memory_what_is_reported_is_released_and_fixed():
    client = RouteClient(RouteRecord(GRAPH, AGV))
    seen = report(9, [1, 2, 3], 1, fraction=0.5)
    heard = client.take(seen)
    assert client.record.ahead == (2, 3) and not heard.foreign
    assert client.due(0.0) is None, 'no motion may be ordered without a request'


@pytest.mark.parametrize('pose, place', [
    (Pose(1, 0.0), GraphPosition(vertex=1)), (Pose(1, 0.9), GraphPosition(vertex=2)),
    (Pose(-1, 0.1), GraphPosition(vertex=2)), (Pose(1, 0.5), GraphPosition(edge=1, fraction=0.5)),
    (Pose(), None)])
def test_the_place_that_a_pose_means(pose, place):
    assert position_of(pose, GRAPH, NEAR) == place


@pytest.mark.parametrize('fraction, play, touches', [
    # 0.14 m from edge 1: which of the two edges is nearest is a matter of chance
    (0.1, 0.25, True),
    (0.1, 0.0, False), (0.5, 0.25, False)])
def test_where_edges_part_a_robot_that_strays_may_be_told_on_either(fraction, play, touches):
    fork = graph_of({1: (0.0, 0.0), 2: (5.0, 0.0), 3: (5.0, 1.4)}, {1: (1, 2), 2: (1, 3)})
    assert GraphPosition(edge=2, fraction=fraction).touches(fork, (1,), play) is touches


@pytest.mark.parametrize('wrong', [
    Report(1, (1, 2), (AHEAD,)), Report(1, pose=Pose(1, float('nan'))), Report(1, pose=Pose(99)),
    Report(1, pose=Pose(1, 1.5)), Report(1, (1,) * 2000, (AHEAD,) * 2000),
    Report(1, stamp=float('inf'))])
def test_reports_that_make_no_sense_are_refused(wrong):
    with pytest.raises(WrongReport):
        check_report(wrong, GRAPH)


def test_after_a_restart_what_was_refused_is_not_ordered_again(client, ids):
    idle = Report(0, pose=Pose(1, 0.0), stamp=100.0)
    client.extend([1], ids)
    client.refuse(RouteRefusal(1, (1,), no('no')))
    client.take(idle)
    other = RouteClient(RouteRecord(GRAPH, AGV))
    other.restore(client.memory)
    assert other.due(0.0) is None and other.record.ahead == ()
