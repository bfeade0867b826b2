"""Guards of the interlocking behind which others stand: each of them refuses by itself.

No search of `test_yard` finds a flaw without them.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Dict

from fleet_builders import AGV, corridor

from fleet_core.fleet import RobotType
from fleet_core.geometry.site_geometry import SiteGeometry
from fleet_core.interlocking.interlocking import Gate, Grant, Interlocking, Refusal
from fleet_core.interlocking.reports import Report
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
