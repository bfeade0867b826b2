"""Sequences of events of one robot in which the yard's model once found an error.

Also a property of grants.
"""
from __future__ import annotations

from dataclasses import replace
from random import Random

import pytest
from fleet_builders import AGV, corridor, random_graph
from hypothesis import assume, given
from hypothesis import strategies as st

from fleet_core.interlocking.allocation import Knowledge
from fleet_core.interlocking.reports import Report
from fleet_core.interlocking.route_master import RouteMaster
from fleet_core.interlocking.route_record import RouteRecord
from route_protocol.values import EdgeState, Motion, RouteReport, SymbolicPose, VehicleLocation

GRAPH = corridor(4)
C, P = EdgeState.COMPLETE, EdgeState.PROCESSING


def master() -> RouteMaster:
    """The master of a robot that has not reported yet. Its orders are numbered from 1 on."""
    return RouteMaster(RouteRecord(GRAPH, AGV), int)


def told(number, edge, percentage, motion=Motion.STANDING, states=(), edges=(), order=0, age=0.0,
         epoch=1, refused=0):
    """A report of a robot."""
    curve = GRAPH.curve(edge)
    x, y = curve.point_at(percentage / 100.0 * curve.length)
    return Report(RouteReport(
        0, 0, edges, states, SymbolicPose(edge, percentage), location=VehicleLocation(x, y, 0.0),
        epoch=epoch, master='path_supervisor', order=order, first=1 if order else 0,
        refused=refused, motion=motion, number=number), age)


@pytest.mark.parametrize('age', [0.0, 3.0])
def test_after_a_restart_a_robot_that_has_driven_there_and_back_holds_no_more_than_before(age):
    robot = master()
    robot.hear(told(1, 1, 0.0))
    robot.extend((1, -1))
    robot.hear(told(2, -1, 0.0, Motion.ON_ROUTE, (C, P), (1, -1), 1, age))
    robot.hear(told(3, -1, 100.0, Motion.STANDING, (C, C), (1, -1), 1))
    restored = master()
    restored.restore(robot.memory)
    assert robot.allocation == restored.allocation


def test_by_an_older_journal_an_order_may_still_be_on_its_way_until_the_robot_obeys_a_newer_stop():
    robot = master()
    robot.hear(told(1, 1, 0.0))
    robot.doubt()
    robot.hear(told(2, 1, 0.0))
    assert robot.allocation.knowledge is Knowledge.UNKNOWN and robot.needs_stop
    robot.halt()
    assert robot.order is not None
    robot.hear(told(3, 1, 0.0, order=robot.order.number))
    assert robot.allocation.knowledge is Knowledge.KNOWN


def test_where_a_robot_was_while_it_could_be_anywhere_does_not_count_once_it_stands():
    """Otherwise a late report would stop the robots near it (walk 2168 in the yard, other bounds).
    """
    robot = master()
    robot.hear(told(1, 1, 0.0))
    robot.doubt()
    robot.hear(told(2, 3, 50.0, Motion.ON_ROUTE, age=5.0))
    robot.halt()
    assert robot.order is not None
    robot.hear(told(3, 1, 0.0, order=robot.order.number))
    assert robot.allocation.vertex == 1 and not robot.allocation.areas


def test_a_master_with_a_lost_journal_and_a_clock_set_back_finds_the_numbers_of_its_robot():
    """Otherwise the robot would ignore the orders, and the master would refuse all reports.

    An order that the journal lacks may still be on its way.
    """
    robot = master()
    robot.hear(told(1, 1, 0.0, order=1000))
    assert robot.allocation.knowledge is Knowledge.UNKNOWN and robot.needs_stop
    robot.halt()
    assert robot.order is not None and robot.order.number > 1000 + 365 * 24 * 3600 * 1000
    robot.hear(told(2, 1, 0.0, order=1001))  # an order that the journal lacks has arrived
    assert robot.allocation.knowledge is Knowledge.UNKNOWN
    robot.hear(told(3, 1, 0.0, order=robot.order.number))
    assert robot.allocation.vertex == 1 and robot.is_ready


@pytest.mark.parametrize('take_back', [RouteMaster.halt, RouteMaster.shorten])
def test_where_a_lost_route_led_is_held_also_when_a_longer_route_that_was_never_sent_is_taken_back(
        take_back):
    """The longer route was not sent, because the journal could not be written."""
    robot = master()
    robot.hear(told(1, 1, 0.0))
    robot.extend((1, 2))
    robot.due(0.0)
    robot.hear(told(2, 1, 50.0, Motion.ON_ROUTE, (P, P), (1, 2), 1))
    robot.extend((3,))
    lost = (EdgeState.FAILED,) * 2
    robot.hear(told(3, 1, 60.0, Motion.COMING_TO_REST, lost, (1, 2), 1))
    take_back(robot)
    assert {hold.edge for hold in robot.allocation.holds} == {1, 2}


def test_a_late_copy_of_a_stop_takes_the_record_back_and_what_lay_behind_with_it():
    """The copy makes the robot count its edges from the place of that stop (walk 2 in the yard)."""
    robot = master()
    robot.hear(told(1, 1, 0.0))
    robot.extend((1,))
    robot.halt()
    robot.hear(told(2, 1, 0.0, order=2))
    robot.hear(told(3, 1, 0.0, epoch=2))
    robot.extend((1,))
    robot.hear(told(4, 1, 0.0, order=2, epoch=2))  # it has obeyed the copy, and refuses order 3
    robot.extend((2, 3))
    robot.hear(told(5, 1, 0.0, Motion.ON_ROUTE, (P, P, P), (1, 2, 3), 4, epoch=2))
    assert {hold.edge for hold in robot.allocation.holds} == {1, 2, 3}


def test_the_path_of_a_robot_that_came_to_rest_begins_with_the_edge_that_is_ahead_of_it():
    """Otherwise a plan that is made at this moment begins one edge too early, and the robot never
    drives.
    """
    robot = master()
    robot.hear(told(1, 1, 0.0))
    robot.extend((1,))
    robot.due(0.0)
    robot.hear(told(2, 1, 80.0, Motion.ON_ROUTE, (P,), (1,), 1))
    assert robot.record.held == (1,) and robot.record.begins[0] == 1
    robot.extend((2,))  # this order is on its way
    robot.hear(told(3, 1, 100.0, states=(C,), edges=(1,), order=1))
    assert robot.record.held == (2,) and robot.record.begins == (2, 0.0)


def test_a_robot_that_stands_elsewhere_is_given_no_route_until_a_second_location_tells_where():
    """Otherwise the route would begin where the robot is not (walk 1011 in the yard)."""
    robot = master()
    robot.hear(told(1, 1, 0.0))
    robot.hear(told(2, 3, 0.0, epoch=2))
    assert not robot.is_ready
    robot.hear(told(3, 3, 0.0, epoch=2))
    assert robot.is_ready and robot.record.last_vertex == 3


def test_a_refused_shorter_route_is_forgotten_with_the_record_that_it_was_part_of():
    """A late copy of a stop sets the numbers of edges back. Then the same number means another
    edge.
    """
    robot = master()
    robot.hear(told(1, 1, 0.0))
    robot.extend((1,))
    robot.halt()
    robot.hear(told(2, 1, 0.0, order=2))
    robot.extend((1, 2, 3))
    robot.due(0.0)
    robot.hear(told(3, 1, 50.0, Motion.ON_ROUTE, (P, P, P), (1, 2, 3), 3))
    robot.shorten()
    robot.hear(told(4, 1, 60.0, Motion.ON_ROUTE, (P, P, P), (1, 2, 3), 3, refused=4))
    robot.hear(told(5, 1, 0.0, epoch=2))
    robot.hear(told(6, 1, 0.0, order=2, epoch=2))
    robot.extend((1, 2, 3))
    robot.due(0.0)
    robot.hear(told(7, 1, 10.0, Motion.ON_ROUTE, (P, P, P), (1, 2, 3), 5, epoch=2))
    robot.shorten()
    assert robot.order is not None and robot.order.edges == (1,)


@given(st.integers(0, 50), st.sampled_from((0.0, 0.1, 0.25, 0.5)), st.sampled_from((0.0, 0.1)),
       st.integers(0, 99), st.floats(0.0, 1.0), st.floats(-0.35, 0.35), st.floats(-0.35, 0.35))
def test_a_grant_adds_the_granted_edge_only_also_if_the_robot_stands_beside_its_place(
        seed, play, slack, choice, fraction, x, y):
    """Otherwise the allocation would exclude places that no condition of the grant has checked."""
    graph = random_graph(Random(seed), 4, 1, 3.0)
    edge = sorted(graph.edges)[choice % len(graph.edges)]
    robot = RouteMaster(RouteRecord(graph, replace(AGV, play=play), slack), int)
    near = graph.curve(edge).point_at(fraction * graph.curve(edge).length)
    at = VehicleLocation(float(near[0]) + x, float(near[1]) + y, 0.0)
    for number in (1, 2, 3):
        robot.hear(Report(RouteReport(
            number, 0, (), (), SymbolicPose(edge, 100.0 * fraction), location=at, epoch=1,
            master='path_supervisor', motion=Motion.STANDING, number=number)))
    here, before = robot.record.position, set(robot.allocation.areas)
    assert here is not None
    onto = [here.edge, -here.edge] if here.vertex is None else graph.edges_from(here.vertex)
    assume(onto)
    robot.extend((onto[choice % len(onto)],))
    assert set(robot.allocation.areas) <= before
