"""The rules of the route protocol, one by one, as a simulated AGV obeys them."""
from __future__ import annotations

import pytest
from agv_builders import Conversation, vehicle_at
from fleet_builders import graph_of

from route_protocol.values import Reason, ReasonCode, RouteOrder, SymbolicPose


def test_a_route_is_acknowledged_driven_and_complete() -> None:
    agv = Conversation()
    agv.order(7, 1, 2)
    assert (agv.reports[-1].route_id, agv.states()) == (7, [1, 1])
    agv.wait(30.0)
    assert agv.states() == [2, 2]
    assert agv.last.pose == SymbolicPose(2, 100.0)
    assert agv.vehicle.pose == pytest.approx((8.0, 0.0, 0.0))


def test_the_same_order_again_is_ignored() -> None:
    agv = Conversation()
    agv.order(7, 1, 2)
    heard = len(agv.reports)
    agv.order(7, 1, 2)
    assert (len(agv.reports), agv.refusals) == (heard, [])


def test_a_route_gets_longer_while_it_is_driven_without_a_stop() -> None:
    agv = Conversation()
    agv.order(7, 1)
    agv.drive_to(2.0)
    agv.order(7, 1, 2)
    agv.drive_to(4.5)
    assert (agv.states(), agv.vehicle.drive.speed) == ([2, 1], pytest.approx(1.0))


def test_it_drives_no_faster_than_its_order_allows_for_its_load() -> None:
    agv = Conversation()
    agv.vehicle.handle(RouteOrder(7, (1,), speed=0.4))
    agv.drive_to(2.0)
    assert agv.vehicle.drive.speed == pytest.approx(0.4)
    agv.wait(20.0)
    agv.order(7, 1, 2)  # without a load
    agv.drive_to(6.0)
    assert agv.vehicle.drive.speed == pytest.approx(1.0)


def test_a_complete_route_gets_longer() -> None:
    agv = Conversation()
    agv.order(7, 1)
    agv.wait(20.0)
    assert agv.states() == [2]
    agv.order(7, 1, 2)
    assert agv.states() == [2, 1]
    agv.wait(20.0)
    assert agv.states() == [2, 2]


def test_a_route_gets_shorter_as_long_as_it_can_stop() -> None:
    agv = Conversation()
    agv.order(7, 1, 2, 3)
    agv.drive_to(2.0)
    agv.order(7, 1)
    agv.wait(20.0)
    assert (agv.states(), agv.vehicle.drive.vertex) == ([2], 2)


def test_it_is_not_shortened_to_where_it_cannot_stop() -> None:
    agv = Conversation()
    agv.order(7, 1, 2, 3)
    agv.drive_to(3.6)
    agv.order(7, 1)
    assert agv.reason == ('at 1.00 m/s the vehicle cannot stop where the route demands it')
    assert (agv.last.route_id, agv.states()) == (7, [1, 1, 1])
    agv.wait(30.0)
    assert agv.states() == [2, 2, 2]


@pytest.mark.parametrize('edges, reason', [
    ((9,), 'The graph has no edge 9'),
    ((1, 3), 'Edge 1 ends at vertex 2, but the next edge 3 starts at vertex 3'),
    ((2,), 'edge 2 does not start where the vehicle is, at vertex 1'),
    ((-1,), 'edge -1 does not start where the vehicle is, but ends there, at vertex 1'),
    ((1, -1) * 501, 'the route has more than 1000 edges'),
])
def test_what_cannot_be_driven_is_refused_with_the_reason(edges: tuple, reason: str) -> None:
    agv = Conversation()
    agv.order(7, *edges)
    assert agv.reason == reason
    failed = agv.reports[-1]
    assert (failed.route_id, failed.edges, failed.reason.text) == (7, edges, reason)
    assert {int(state) for state in failed.states} == {3}
    assert agv.last.route_id == 0


def test_an_edge_of_speed_0_is_refused() -> None:
    agv = Conversation(2, graph_of({1: (0, 0), 2: (4, 0)}, {1: (1, 2)}, one_way=(1,)))
    agv.order(1, -1)
    assert agv.reason == 'The graph forbids driving over edge -1: its speed in this direction is 0'


def test_a_refused_change_never_shows_as_failed() -> None:
    agv = Conversation()
    agv.order(7, 1, 2)
    agv.wait(1.0)
    agv.order(7, 2, 3)
    assert agv.reason == 'route 7 must go on with the edges done and the current one: 1'
    assert all(3 not in report.states for report in agv.reports)
    assert agv.last.edges == (1, 2)


def test_another_route_begins_on_the_edge_being_driven() -> None:
    agv = Conversation()
    agv.order(7, 1, 2)
    agv.drive_to(2.0)
    agv.order(8, 1, 4)
    assert (agv.last.route_id, agv.states()) == (8, [1, 1])
    agv.wait(30.0)
    assert agv.vehicle.drive.vertex == 5


def test_another_route_may_begin_with_the_edge_just_left() -> None:
    agv = Conversation()
    agv.order(7, 1, 2)
    agv.drive_to(4.2)
    agv.order(8, 1, 2, 3)
    assert (agv.refusals, agv.states()) == ([], [2, 1, 1])


def test_another_route_elsewhere_is_refused_while_one_is_driven() -> None:
    agv = Conversation()
    agv.order(7, 1, 2)
    agv.drive_to(2.0)
    agv.order(8, -1)
    assert agv.reason == ('the vehicle drives on edge 1, with which the route does not begin: '
                          'stop it first, or let it end its route')
    assert agv.last.route_id == 7


def test_an_empty_route_stops() -> None:
    agv = Conversation()
    agv.order(7, 1, 2)
    agv.drive_to(2.0)
    agv.order(8)
    assert (agv.last.route_id, agv.last.edges) == (8, ())
    agv.wait(5.0)
    assert agv.vehicle.drive.at_rest
    assert agv.vehicle.pose[0] == pytest.approx(3.0, abs=0.15)


def test_a_route_back_waits_until_the_vehicle_stands() -> None:
    agv = Conversation()
    agv.order(7, 1, 2)
    agv.drive_to(2.0)
    agv.order(8)
    agv.order(9, -1)
    assert agv.last.route_id == 8
    agv.wait(20.0)
    assert (agv.last.route_id, agv.states(), agv.refusals) == (9, [2], [])
    assert agv.vehicle.drive.vertex == 1


def test_an_order_that_came_late_is_left_out() -> None:
    agv = Conversation()
    agv.order(8, 1, stamp=2_000)
    agv.order(7, 1, 2, stamp=1_000)
    assert (agv.last.route_id, agv.refusals) == (8, [])


def test_an_order_from_a_clock_that_is_ahead_is_refused() -> None:
    agv = vehicle_at(1)
    agv.handle(RouteOrder(1, (1,), stamp=5_000_000_000, received=1_000_000_000))
    assert 'synchronise the clocks' in agv.new_messages()[0].reason.text


def test_a_failed_route_cannot_be_changed_but_another_one_goes_on_from_there() -> None:
    agv = Conversation()
    agv.order(7, 1, 2)
    agv.drive_to(1.0)
    agv.vehicle.fail(Reason(ReasonCode.OTHER, 'a broken belt'))
    assert (agv.states(), agv.last.reason.text) == ([3, 3], 'a broken belt')
    agv.order(7, 1)
    assert agv.reason == 'route 7 has failed: a new route needs another id'
    agv.wait(5.0)
    agv.order(8, 1, 2)
    agv.wait(20.0)
    assert agv.states() == [2, 2]


def test_during_an_emergency_stop_nothing_is_taken_up() -> None:
    agv = Conversation()
    agv.order(7, 1)
    agv.wait(2.0)
    agv.vehicle.press_emergency_stop()
    assert agv.last.reason.text == 'emergency stop'
    agv.order(8, 1)
    assert agv.reason == 'emergency stop'
    agv.vehicle.release_emergency_stop()
    agv.order(9, 1)
    agv.wait(20.0)
    assert agv.states() == [2]


def test_an_idle_vehicle_tells_where_it_is() -> None:
    assert Conversation(1).last.pose == SymbolicPose(1, 0.0)
    assert Conversation(4).last.pose == SymbolicPose(3, 100.0)


def test_another_route_that_ends_where_it_cannot_stop_is_refused() -> None:
    agv = Conversation()
    agv.order(7, 1, 2)
    agv.drive_to(3.6)
    agv.order(8, 1)
    assert agv.reason == 'at 1.00 m/s the vehicle cannot stop where the route demands it'
    assert agv.last.route_id == 7
