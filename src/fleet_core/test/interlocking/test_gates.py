"""Guards of the interlocking behind which others stand: each of them refuses by itself.

No search of `test_yard` finds a flaw without them.
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
from route_protocol.values import Motion, RouteReport, SymbolicPose, VehicleLocation

GRAPH = corridor(4)


@dataclass
class Robot:
    """A robot that stands on edge 1, and needs no person."""

    name: str
    master: RouteMaster
    type: RobotType = AGV
    needs_person: bool = False


def standing(**metres: float) -> Dict[str, Robot]:
    """Robots by name, each so far from the beginning of edge 1."""
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


def before_an_open_door(edge: int) -> Interlocking:
    """A robot stands at the beginning of edge 1. An edge leads through a door, which is open."""
    geometry = SiteGeometry(GRAPH)
    door = Resource('door', ResourceKind.DOOR, frozenset({edge}), has_device=True)
    site = Interlocking(geometry, 0.1, standing(a=0.0), claims=Claims(Needs((door,), geometry)))
    site.claims.want('a', [edge])
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
