"""Routes are driven to their end with each strategy, and reported during the drive."""
from __future__ import annotations

import math
from dataclasses import replace

import pytest
from bridge_builders import Bench, dissertation_graph, yard
from hypothesis import given, settings
from hypothesis import strategies as st

from omron_ld90.bridge.events import RobotSeen
from omron_ld90.bridge.route_follower import RouteFollower
from omron_ld90.bridge.route_strategies import RouteSettings
from route_protocol.values import SymbolicPose, VehicleLocation

ALL = ('vertex_by_vertex', 'direct', 'rolling')


@pytest.mark.parametrize('strategy', ALL)
def test_the_dissertations_example_is_driven(strategy):
    bench = Bench(dissertation_graph(), 1, strategy)
    bench.order(7, 1, 4, 5)
    bench.run()
    report = bench.follower.report()
    assert (report.route_id, report.edges, bench.states()) == (7, (1, 4, 5), [2, 2, 2])
    assert report.pose == SymbolicPose(5, 100.0)
    assert not report.reason


def test_vertex_by_vertex_stops_at_each():
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1, 4, 5)
    bench.run()
    assert bench.commands == ['goto 2', 'goto 7', 'goto 6']
    assert bench.robot.halts == 3


def test_direct_sends_the_last_vertex_when_the_shortest_way_is_the_route():
    bench = Bench(dissertation_graph(), 1, 'direct')
    bench.order(7, 1, 4, 5)
    bench.run()
    assert bench.commands == ['goto 6']


def test_direct_cuts_a_route_that_is_not_the_shortest_way():
    bench = Bench(yard(), 1, 'direct')
    bench.order(7, 1, 2, 3)  # round the block, although edge 4 is the shorter way
    bench.run()
    assert bench.commands == ['goto 2', 'goto 3', 'goto 4']
    assert bench.states() == [2, 2, 2]


def test_rolling_passes_without_stopping():
    bench = Bench(yard(), 2, 'rolling')
    bench.order(7, 5, 6)
    bench.run()
    assert bench.commands[-1] == 'goto 6'
    assert bench.robot.halts == 1


def test_rolling_looks_no_farther_ahead_than_braking_demands():
    bench = Bench(yard(), 1, 'rolling')
    bench.order(7, 1, 5, 6)
    assert 'goto 6' not in bench.commands  # 12 m away, while the robot stands
    bench.run()
    assert bench.commands[-1] == 'goto 6'
    assert bench.robot.halts == 1


def test_rolling_waits_at_a_vertex_that_the_free_way_leaves_out():
    bench = Bench(yard(), 1, 'rolling')
    bench.order(7, 1, -1)
    bench.run(lambda bench: bench.commands[-1] == 'goto 1')
    assert math.dist(bench.robot.position, (4.0, 0.0)) <= 0.3
    bench.run()
    assert bench.states() == [2, 2]
    assert bench.last.pose == SymbolicPose(-1, 100.0)


def test_rolling_is_a_quarter_faster_than_vertex_by_vertex_on_a_straight_way():
    seconds = {}
    for strategy in ('vertex_by_vertex', 'rolling'):
        bench = Bench(yard(), 1, strategy)
        bench.order(7, 1, 5, 6)
        bench.run()
        seconds[strategy] = bench.now
    start = 100.0
    assert seconds['rolling'] - start < 0.75 * (seconds['vertex_by_vertex'] - start)


def test_native_names_every_goal_in_one_command():
    bench = Bench(yard(), 1, 'native', native_command='gotoGoals {goals}')
    bench.order(7, 1, 5, 6)
    bench.run()
    assert bench.commands == ['gotoGoals 2 5 6']
    assert bench.states() == [2, 2, 2]


@pytest.mark.parametrize('strategy', [*ALL, 'native'])
def test_the_dock_vertex_is_reached_by_docking(strategy):
    bench = Bench(yard(), 2, strategy, native_command='gotoGoals {goals}')
    bench.order(7, -1, 9)
    bench.run(lambda bench: bench.commands[-1] == 'dock')
    bench.run()
    assert bench.robot.docked
    assert 'goto 90' not in bench.commands
    assert bench.last.pose == SymbolicPose(9, 100.0)


def test_the_edge_to_the_dock_is_complete_when_the_robot_is_docked_and_not_before():
    bench = Bench(yard(), 1)
    bench.order(7, 9)
    bench.run()
    for report in bench.reports[:-2]:
        assert report.states[0] == 1
        assert report.pose.percentage < 100.0


def test_a_docked_robot_stands_on_the_dock_vertex():
    bench = Bench(yard(), 90)
    bench.robot.position = (0.0, -4.8)  # at the station, beyond the vertex
    bench.now += 1.0
    bench.look()
    assert bench.follower.report().pose == SymbolicPose(9, 100.0)
    bench.order(7, -9, 1)
    bench.run()
    assert bench.states() == [2, 2]


def test_the_first_report_acknowledges_the_route():
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1, 4, 5)
    assert bench.reports[0].route_id == 7
    assert bench.reports[0].states == (1, 1, 1)
    assert bench.reports[0].pose == SymbolicPose(1, 0.0)


def test_a_report_carries_the_stamp_of_the_location_used():
    bench = Bench(dissertation_graph(), 1)
    bench.order(7, 1, 4, 5)
    bench.run(seconds=30.0, until=lambda bench: bench.states()[0] == 2)
    assert bench.last.stamp == bench.follower.robot.location.last.stamp
    before = bench.follower.report()
    bench.wait(0.3)
    after = replace(bench.follower.report(), number=before.number)
    assert after == before  # nothing has changed, so nothing is reported


def test_after_the_end_the_last_route_is_told_until_the_robot_goes_elsewhere():
    bench = Bench(yard(), 2)
    bench.order(7, 5)
    bench.run()
    assert bench.follower.report().pose == SymbolicPose(5, 100.0)
    bench.robot.position = (6.0, 0.0)
    bench.now += 1.0
    bench.look()
    assert bench.follower.report().route_id == 7
    assert bench.follower.report().pose == SymbolicPose(5, 50.0)


def test_off_the_graph_the_edge_is_zero():
    bench = Bench(yard(), 2)
    bench.robot.position = (6.0, 3.0)
    bench.now += 1.0
    bench.look()
    assert bench.follower.report().pose == SymbolicPose(0, 0.0)


@st.composite
def journeys(draw):
    """Returns a random continuous route over the yard, without the dock."""
    graph = yard()
    start = at = draw(st.sampled_from([1, 2, 3, 4, 5, 6]))
    route = []
    for _ in range(draw(st.integers(1, 7))):
        route.append(draw(st.sampled_from([edge for edge in graph.edges_from(at)
                                           if abs(edge) != 9])))
        at = graph.end_vertex(route[-1]).id
    return start, tuple(route)


@settings(max_examples=settings.default.max_examples * 3 // 5)
@given(journeys(), st.sampled_from(ALL), st.sampled_from([0.1, 0.3, 0.5, 1.0]))
def test_every_route_is_driven_in_order_and_told_truly(journey, strategy, period):
    start, route = journey
    graph = yard()
    bench = Bench(graph, start, strategy, period)
    bench.order(7, *route)
    bench.run()
    assert bench.states() == [2] * len(route), bench.follower.report().reason.text
    assert bench.last.pose == SymbolicPose(route[-1], 100.0)
    # Every vertex was visited within the tolerance, in the order of the route.
    trail = iter(bench.robot.trail)
    for edge in route:
        vertex = graph.end_vertex(edge)
        assert any(math.dist(point, vertex.position) <= 0.3 for point in trail), vertex
    # States only go forward, edges become complete in order, percentages grow within an edge.
    done, percentage = 0, 0.0
    for report in bench.reports:
        complete = list(report.states).count(2)
        assert report.states == (2,) * complete + (1,) * (len(route) - complete)
        assert complete >= done
        if complete > done:
            done, percentage = complete, 0.0
        if complete < len(route):
            assert report.pose.edge == route[complete]
            assert report.pose.percentage < 100.0
        assert report.pose.percentage >= percentage
        percentage = report.pose.percentage if complete < len(route) else 0.0


@pytest.mark.parametrize('place, location', [
    ((1.0, 0.0), VehicleLocation(1.0, 0.0, 0.5)), (None, None)])
def test_reports_tell_where_the_robot_is_in_metres(place, location):
    follower = RouteFollower(RouteSettings(), dissertation_graph())
    follower.handle(RobotSeen(1, place=place, heading=0.5), 1.0)
    assert follower.report().location == location
