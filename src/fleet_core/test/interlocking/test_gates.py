"""Guards of the interlocking for which a second guard refuses the same cases.

If such a guard is left out, no search of `test_yard` finds a flaw. So each guard is tested alone.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Dict

from fleet_builders import AGV, corridor

from fleet_core.fleet import RobotType
from fleet_core.geometry.site_geometry import SiteGeometry
from fleet_core.interlocking.claims import Claims
from fleet_core.interlocking.interlocking import Gate, Grant, Interlocking, Refusal
from fleet_core.interlocking.reports import Report
from fleet_core.interlocking.resources import Needs, Resource, ResourceKind
from fleet_core.interlocking.route_master import ME, RouteMaster
from fleet_core.interlocking.route_record import RouteRecord
from route_protocol.values import (
    EdgeState,
    Motion,
    RouteReport,
    SymbolicPose,
    VehicleLocation,
)

GRAPH = corridor(4)


@dataclass
class Robot:
    """A robot that stands on edge 1, and needs no person."""

    name: str
    master: RouteMaster
    type: RobotType = AGV
    needs_person: bool = False


def standing(**metres: float) -> Dict[str, Robot]:
    """Robots by name; each stands at the given distance (m) from the beginning of edge 1."""
    robots = {}
    for name, arc in metres.items():
        robots[name] = Robot(name, RouteMaster(RouteRecord(GRAPH, AGV), int))
        robots[name].master.hear(Report(RouteReport(
            0, 0, (), (), SymbolicPose(1, 100.0 * arc / GRAPH.curve(1).length),
            location=VehicleLocation(arc, 0.0, 0.0), epoch=1, master=ME, motion=Motion.STANDING,
            number=1)))
    return robots


def test_a_robot_at_work_is_granted_nothing():
    robots = standing(a=0.0)
    site = Interlocking(SiteGeometry(GRAPH), 0.1, robots)
    site.at_work = frozenset('a')
    assert site.grant(robots['a'], (1,)) == Grant((), Refusal(Gate.AT_WORK, 0))
    site.at_work = frozenset()
    assert site.grant(robots['a'], (1,)) == Grant((1,))


def test_a_robot_too_near_to_another_is_granted_nothing():
    robots = standing(a=0.0, b=0.6)
    site = Interlocking(SiteGeometry(GRAPH), 0.1, robots)
    assert site.grant(robots['b'], (1,)) == Grant((), Refusal(Gate.TOO_NEAR, 0, 'a'))


def before_an_open_door(*edges: int) -> Interlocking:
    """A site where a robot stands at the beginning of edge 1, and `edges` lead through an open
    door.
    """
    geometry = SiteGeometry(GRAPH)
    door = Resource('door', ResourceKind.DOOR, frozenset(edges), has_device=True)
    site = Interlocking(geometry, 0.1, standing(a=0.0), claims=Claims(Needs((door,), geometry)))
    site.claims.want('a', edges)
    site.claims.stored()
    site.claims.open_for = {'door': site.claims.number}
    return site


def test_a_route_that_could_not_be_stored_is_granted_anew_before_it_is_sent():
    site = before_an_open_door(1)
    robot = site._robots['a']
    assert site.grant(robot, (1,)).edges == (1,)
    site.not_stored('the disk is full')
    assert not site.orders(0.0) and not robot.master.allocation.holds
    site.claims.open_for = {}
    site.trouble = ''
    assert not site.orders(0.0), 'the door is not open any more'
    assert site.grant(robot, (1,)).refusal.gate is Gate.CLAIM


def test_of_a_route_only_the_part_that_was_never_sent_is_taken_back():
    site = before_an_open_door(2)
    robot = site._robots['a']
    site.grant(robot, (1,))
    (_, first), = site.orders(0.0)
    site.grant(robot, (2,))
    site.not_stored('the disk is full')
    assert robot.master.record.ahead == (1,) and robot.master.order is first.order
    (_, again), = site.orders(10.0)
    assert again == (first.order, True), 'the robot may know it: it is stored, and repeated'


def test_a_stop_and_a_shorter_route_are_sent_also_if_they_could_not_be_stored():
    site = before_an_open_door(3)
    robot = site._robots['a']
    site.grant(robot, (1, 2))
    site.orders(0.0)
    for takes_away, left in ((robot.master.shorten, (1,)), (robot.master.halt, ())):
        takes_away()
        site.not_stored('the disk is full')
        (_, sending), = site.orders(0.0)
        assert sending.order.edges == left


def closes(site: Interlocking) -> None:
    """Makes the report of the door old, so that no fresh report says that the door is open."""
    site.claims.open_for = {}


def opens(site: Interlocking) -> None:
    site.claims.open_for = {'door': site.claims.number}


def drives(site: Interlocking, edge: int) -> None:
    """Lets the robot report that it is in the middle of an edge of its route."""
    master = site._robots['a'].master
    order = master.order
    passed = order.edges.index(edge)
    master.hear(Report(RouteReport(
        0, 0, order.edges, (EdgeState.COMPLETE,) * passed + (EdgeState.PROCESSING,) * (
            len(order.edges) - passed), SymbolicPose(edge, 50.0),
        location=VehicleLocation(GRAPH.curve(1).length * (edge - 0.5), 0.0, 0.0), epoch=1,
        master=ME, order=order.number, first=order.first, motion=Motion.ON_ROUTE, number=2)))


def restarts(site: Interlocking) -> None:
    """Restarts the fleet manager from its journal. No fresh report says that the door is open."""
    robot = site._robots['a']
    memory, robot.master = robot.master.memory, RouteMaster(RouteRecord(GRAPH, AGV), int)
    robot.master.restore(memory)
    closes(site)


def test_an_order_does_not_leave_if_the_door_closed_while_it_was_stored():
    site = before_an_open_door(2)
    site.grant(site._robots['a'], (1, 2))
    closes(site)
    assert not site.orders(5.0)
    opens(site)
    (_, sending), = site.orders(6.0)
    assert sending.order.edges == (1, 2) and not sending.repeated


def test_such_an_order_is_granted_anew_because_no_robot_knows_it():
    site = before_an_open_door(2)
    robot = site._robots['a']
    site.grant(robot, (1, 2))
    closes(site)
    assert site.keep_out() == ['a'] and robot.master.order is None
    assert site.grant(robot, (1, 2)).edges == (1,)


def test_an_order_of_before_a_restart_is_not_repeated_into_a_door_that_has_closed():
    site = before_an_open_door(1)
    site.grant(site._robots['a'], (1,))
    restarts(site)
    assert not site.orders(0.0) and not site.keep_out(), 'the robot may have taken it'
    opens(site)
    (_, sending), = site.orders(0.0)
    assert sending.order.edges == (1,)


def test_a_robot_that_shows_no_such_order_after_the_restart_is_stopped_and_asks_anew():
    site = before_an_open_door(1)
    site.grant(site._robots['a'], (1,))
    restarts(site)
    site._robots['a'].master.hear(Report(RouteReport(
        0, 0, (), (), SymbolicPose(1, 0.0), location=VehicleLocation(0.0, 0.0, 0.0), epoch=1,
        master=ME, motion=Motion.STANDING, number=2)))
    assert site.keep_out() == ['a']
    (_, sending), = site.orders(0.0)
    assert sending.order.edges == ()


def test_a_route_ends_before_a_door_that_is_not_open_any_more():
    site = before_an_open_door(3)
    site.grant(site._robots['a'], (1, 2, 3))
    site.orders(0.0)
    drives(site, 1)
    assert not site.keep_out()
    closes(site)
    assert site.keep_out() == ['a'] and not site.keep_out()
    (_, sending), = site.orders(0.0)
    assert sending.order.edges == (1, 2)


def test_a_robot_in_a_door_that_is_not_open_any_more_keeps_its_route():
    site = before_an_open_door(2, 3)
    site.grant(site._robots['a'], (1, 2, 3))
    site.orders(0.0)
    drives(site, 2)
    closes(site)
    assert not site.keep_out()
