"""A new route id may make a robot hold places behind it again. No other robot may hold them."""
from __future__ import annotations

from dataclasses import dataclass
from itertools import count

import pytest
from fleet_builders import AGV, graph_of

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.geometry.site_geometry import SiteGeometry
from graph_fleet_manager.interlocking.interlocking import Gate, Interlocking
from graph_fleet_manager.interlocking.reports import GraphPosition, Pose, Report
from graph_fleet_manager.interlocking.route_client import RouteClient
from graph_fleet_manager.interlocking.route_record import RouteRecord
from route_protocol.values import EdgeState

# A triangle 1, 2, 3, whose edge 1 is crossed by edge 5; edge 4 leads away from vertex 1.
GRAPH = graph_of({1: (0, 0), 2: (20, 0), 3: (10, 15), 4: (-5, 0), 5: (6, -3), 6: (6, 3)},
                 {1: (1, 2), 2: (2, 3), 3: (3, 1), 4: (1, 4), 5: (5, 6)})
CLEARANCE = 0.1


@dataclass
class Robot:
    """A robot as the interlocking needs it."""

    name: str
    client: RouteClient
    type: RobotType = AGV
    needs_person: bool = False
    is_silent: bool = False


@pytest.fixture
def robots():
    """Robot a drives round the triangle, and is far behind the crossing; robot b is before it."""
    found = {name: Robot(name, RouteClient(RouteRecord(GRAPH, AGV))) for name in 'ab'}
    for robot, vertex in zip(found.values(), (1, 5)):
        robot.client.record.position = GraphPosition(vertex=vertex)
        robot.client.is_heard = True
    return found


@pytest.fixture
def site(robots):
    ids = count(1)
    return Interlocking(SiteGeometry(GRAPH), CLEARANCE, robots, lambda: next(ids))


def drive(robot, fraction):
    """The robot reports that it is on its first edge, and has taken up its route."""
    edges = tuple(robot.client.order.edges)
    robot.client.take(Report(robot.client.route_id, edges, (EdgeState.PROCESSING,) * len(edges),
                             Pose(edges[0], fraction), stamp=100.0))


def test_a_robot_gets_no_new_id_while_another_robot_has_a_place_to_which_it_could_turn_back(
        robots, site):
    a, b = robots.values()
    site.grant(a, (1, 2, 3))
    drive(a, 0.9)
    assert site.grant(b, (5,)).edges == (5,)
    given = site.grant(a, (4,), renew=True)
    assert (given.edges, given.refusal.gate) == ((), Gate.NOT_READY)
    assert not site.excluding('a')
    assert site.grant(a, (4,)).edges == (4,), 'the same id lets the robot not turn back'
    assert not site.excluding('a')


def test_a_robot_gets_a_new_id_if_the_places_to_which_it_could_turn_back_are_free(robots, site):
    a, b = robots.values()
    site.grant(a, (1, 2, 3))
    drive(a, 0.9)
    assert site.grant(a, (4,), renew=True).edges == (4,)
    given = site.grant(b, (5,))
    assert (given.edges, given.refusal.gate) == ((), Gate.OCCUPIED)
