"""Which robot charges, where and how long, under all events."""
from __future__ import annotations

import math
from dataclasses import replace

import pytest
from fleet_builders import AGV, corridor, graph_of

from fleet_core.supervision.battery import MUTE
from fleet_core.supervision.fleet_view import RobotState, robot_views
from fleet_core.supervision.missions import MissionState
from fleet_core.supervision.settings import RobotSettings
from trajectory_graph import Graph
from world.supervised_fleet import SupervisedFleet


def with_docks(graph, *docks):
    """The same graph with charging docks at some vertices."""
    return Graph([replace(v, dock=v.id in docks) for v in graph.vertices.values()],
                 graph.edges.values())


def yard(robots, docks=(6,), **more):
    """Robots {name: vertex} that charge at docks of a corridor with a siding at 3."""
    kind = replace(AGV, docks=frozenset(docks))
    return SupervisedFleet(with_docks(corridor(6, siding_at=3), *docks),
                           {name: (kind, vertex) for name, vertex in robots.items()}, **more)


def charge(fleet, **charges):
    """Sets the charge that the batteries report."""
    for name, charge in charges.items():
        fleet.do(fleet.supervisor.battery(name, charge, fleet.now))


def view_of(fleet, name):
    """The published state of a robot."""
    return next(v for v in robot_views(fleet.supervisor, fleet.now) if v.name == name)


def charging_at_6(**more):
    """Robot `a` charges at 6, and is half full."""
    fleet = yard({'a': 4}, **more)
    charge(fleet, a=0.2)
    fleet.run(20.0)
    charge(fleet, a=0.5)
    fleet.run(1.0)
    assert fleet.agvs['a'].visited[-1] == 6
    assert view_of(fleet, 'a').state is RobotState.CHARGING
    return fleet


def test_who_is_charged_leaves_the_dock_to_who_waits_for_it():
    fleet = yard({'a': 4, 'b': 1})
    charge(fleet, a=0.1, b=0.2)
    fleet.run(20.0)
    assert fleet.agvs['a'].visited[-1] == 6 and view_of(fleet, 'b').waits_for == 'a free dock'
    charge(fleet, a=0.8)
    fleet.run(40.0)
    assert fleet.agvs['b'].visited[-1] == 6


def test_a_restart_does_not_end_the_charging_half_way():
    fleet = charging_at_6()
    fleet.restart()
    charge(fleet, a=0.5)
    assert_charges_before_it_works(fleet)


def test_a_short_silence_does_not_end_the_charging_half_way():
    fleet = charging_at_6()
    fleet.silent['a'] = fleet.now + 8.0
    fleet.run(20.0)
    assert_charges_before_it_works(fleet)


def test_a_battery_that_falls_silent_does_not_block_the_dock_for_ever():
    fleet = yard({'a': 4, 'b': 1})
    charge(fleet, a=0.1)
    fleet.run(20.0)
    charge(fleet, a=0.4)
    for _ in range(12):  # the battery of b keeps reporting
        charge(fleet, b=0.2)
        fleet.run(10.0)
    assert fleet.agvs['b'].visited[-1] == 6 and view_of(fleet, 'b').state is RobotState.CHARGING
    assert math.isnan(view_of(fleet, 'a').battery), 'an old charge must not be reported as new'


def test_a_battery_that_falls_silent_is_named_as_what_its_robot_waits_for():
    fleet = charging_at_6()
    fleet.run(MUTE + 5.0)
    assert view_of(fleet, 'a').state is RobotState.IDLE
    assert view_of(fleet, 'a').waits_for == (
        'a report of its battery, which has not come for 60 s')
    charge(fleet, a=0.2)
    fleet.run(1.0)
    assert view_of(fleet, 'a').state is RobotState.CHARGING
    assert view_of(fleet, 'a').waits_for == ''


def test_a_mission_says_that_nothing_is_heard_of_the_battery_that_it_waits_for():
    fleet = yard({'a': 4})
    charge(fleet, a=0.2)
    fleet.run(MUTE + 5.0)
    fleet.request(1, 1)
    fleet.run(3.0)
    assert fleet.state(1) is MissionState.PENDING
    assert fleet.statuses[-1].reason == (
        'a must charge first, and there is no battery report from a')


def test_with_what_its_battery_told_last_a_robot_may_work():
    fleet = charging_at_6()  # the last known charge is one half, and the robot charges
    fleet.run(MUTE + 5.0)
    fleet.request(1, 1)
    fleet.run_until_done(1)


def test_a_long_silence_does_not_end_the_charging_half_way():
    fleet = charging_at_6()
    fleet.silent['a'] = fleet.now + 2.0 * MUTE
    fleet.run(2.0 * MUTE + 5.0)
    assert view_of(fleet, 'a').state is RobotState.CHARGING
    charge(fleet, a=0.5)
    assert_charges_before_it_works(fleet)


def test_after_a_restart_a_silent_battery_is_not_taken_for_a_full_one():
    fleet = yard({'a': 4}, docks=())
    charge(fleet, a=0.2)
    fleet.request(1, 3)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.restart()
    fleet.run(3.0)
    fleet.do(fleet.supervisor.bring_in('a', fleet.now)[1])
    fleet.run(10.0)
    assert fleet.statuses[-1].reason == 'a must charge first'


def assert_charges_before_it_works(fleet: SupervisedFleet) -> None:
    fleet.request(1, 1)
    fleet.run(20.0)
    assert fleet.state(1) is MissionState.PENDING
    charge(fleet, a=0.8)
    fleet.run_until_done(1)


def test_who_drops_out_on_the_way_leaves_the_dock_to_others():
    fleet = yard({'a': 1, 'b': 4})
    charge(fleet, a=0.1, b=0.9)
    fleet.run(1.5)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    charge(fleet, b=0.2)
    fleet.run(20.0)
    assert fleet.agvs['b'].visited[-1] == 6


def test_another_dock_is_taken_when_the_way_to_the_first_is_closed():
    fleet = yard({'a': 4}, docks=(1, 6))
    charge(fleet, a=0.2)
    fleet.run(1.5)
    fleet.close(5)
    fleet.run(30.0)
    assert fleet.agvs['a'].visited[-1] == 1


def test_a_robot_that_finds_no_dock_says_why():
    fleet = yard({'a': 4}, docks=())
    charge(fleet, a=0.2)
    fleet.request(1, 1)
    fleet.run(3.0)
    assert view_of(fleet, 'a').waits_for == (
        'a dock: the fleet file and the graph have none for its type')
    assert fleet.statuses[-1].reason == 'a must charge first'
    fleet = yard({'a': 4})
    fleet.close(5)
    charge(fleet, a=0.2)
    fleet.run(3.0)
    assert view_of(fleet, 'a').waits_for == 'a dock: it can reach none'


def test_for_a_mission_that_needs_more_than_is_left_a_robot_charges_first():
    fleet = yard({'a': 4}, settings=RobotSettings(release_ahead=0.0, endurance=20.0))
    charge(fleet, a=0.4)  # enough for 6 m
    fleet.request(1, 2, 4, 2)
    fleet.run(20.0)
    assert fleet.state(1) is MissionState.PENDING and fleet.agvs['a'].visited[-1] == 6
    charge(fleet, a=0.95)  # enough for 17 m, of which it needs 16 m
    fleet.run_until_done(1)


def test_near_a_dock_is_not_docked():
    kind = replace(AGV, play=0.25, docks=frozenset({3}))
    graph = with_docks(graph_of({1: (0, 0), 2: (4, 0), 3: (8, 0)}, {1: (1, 2), 2: (2, 3)}), 3)
    fleet = SupervisedFleet(graph, {'a': (kind, 1)})
    fleet.request(1, 3)
    fleet.run_until(lambda: fleet.agvs['a'].edge == 2 and fleet.agvs['a'].arc > 3.75)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(4.0)
    assert 3.7 < fleet.agvs['a'].arc < 3.99
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.run_until_done(1)
    assert fleet.agvs['a'].arc == pytest.approx(4.0), 'the robot must have got the end of its route'


def test_who_stands_elsewhere_gives_up_a_dock_that_it_cannot_reach_any_more():
    fleet = yard({'a': 1}, planning=5.0)
    charge(fleet, a=0.2)
    fleet.run(1.0)
    assert fleet.supervisor.robots['a'].dock == 6
    fleet.close(3)
    fleet.run(1.0)
    assert fleet.supervisor.robots['a'].dock is None
    assert view_of(fleet, 'a').waits_for == 'a dock: it can reach none'
