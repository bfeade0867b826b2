"""Routes driven by the simulated LD-90 in the example laboratory, between its fences."""
from __future__ import annotations

from functools import lru_cache
from typing import Tuple

import pytest
from simulated_drive import DOCK_VERTEX, SimulatedDrive

from trajectory_graph import route_vertices
from trajectory_graph.shortest_paths import shortest_route

MISSION = (18, 39, 52, 6, DOCK_VERTEX)
HALF_CORRIDOR = 0.45  # m
TOLERANCE = 0.3  # m
ALONG_THE_HALL = (-13, -7, 1, 2, 3)  # vertices: dock - 1 - 8 - 10 - 12 - 14


@lru_cache(maxsize=None)
def driven(strategy: str) -> Tuple[SimulatedDrive, Tuple[int, ...], float]:
    """Drives from the dock and back. Returns the drive, its route, and its duration in s."""
    drive = SimulatedDrive(strategy)
    route = shortest_route(drive.graph, (DOCK_VERTEX, *MISSION))
    return drive, route, drive.drive(1, *route)


strategies = pytest.mark.parametrize('strategy', ['vertex_by_vertex', 'direct', 'rolling'])


@strategies
def test_the_mission_is_completed(strategy):
    drive, route, _ = driven(strategy)
    report = drive.follower.report()
    assert report.reason.text == ''
    assert set(report.states) == {2}
    assert (report.pose.edge, report.pose.percentage) == (route[-1], 100.0)


@strategies
def test_the_robot_stays_in_the_corridors_of_its_route(strategy):
    drive, route, _ = driven(strategy)
    assert drive.distance_from(route) <= HALF_CORRIDOR


@strategies
def test_every_vertex_is_visited_in_order(strategy):
    drive, route, _ = driven(strategy)
    since = 0
    for vertex in route_vertices(drive.graph, route)[:-1]:  # the last vertex is the dock
        away, since = drive.first_nearest_to(vertex, since)
        assert away <= TOLERANCE, f'vertex {vertex}'


@strategies
def test_percentages_only_grow_and_edges_complete_in_order(strategy):
    drive, route, _ = driven(strategy)
    done, percentage = 0, 0.0
    for report in drive.reports:
        complete = list(report.states).count(2)
        assert complete >= done
        if complete > done:
            done, percentage = complete, 0.0
        if complete < len(report.edges):
            assert report.pose.edge == route[complete]
            assert report.pose.percentage >= percentage
            percentage = report.pose.percentage


def test_rolling_is_the_fastest_and_a_quarter_faster_than_vertex_by_vertex():
    seconds = {strategy: driven(strategy)[2] for strategy in ('vertex_by_vertex', 'direct',
                                                              'rolling')}
    assert seconds['rolling'] < seconds['direct']
    assert 1.25 * seconds['rolling'] < seconds['vertex_by_vertex']


def test_native_with_a_command_for_the_last_goal_drives_the_shortest_way():
    drive = SimulatedDrive('native', vertex=8, native_command='goto {last}')
    drive.drive(1, 1, 2, 3)
    assert drive.commands == ['goto 14']
    assert set(drive.follower.report().states) == {2}


def under_way(**settings) -> SimulatedDrive:
    """Returns a robot that has left vertex 10 for vertex 12."""
    drive = SimulatedDrive('vertex_by_vertex', **settings)
    drive.order(1, *ALONG_THE_HALL)
    drive.run(lambda: list(drive.follower.report().states).count(2) == 3
              and drive.follower.report().pose.percentage > 20.0, 120.0)
    return drive


@pytest.mark.parametrize('fault, reason', [
    ('estop press', 'emergency stop'),
    ('motors off', 'Motors disabled'),
    ('other goto 27', 'taken over'),
    ('other stop', 'taken over'),
    ('lost', 'Robot lost'),
])
def test_a_fault_of_the_robot_ends_the_route(fault, reason):
    drive = under_way()
    drive.inject(fault)
    drive.run(lambda: not drive.follower.running, 60.0)
    report = drive.follower.report()
    assert report.reason.text == reason
    assert tuple(report.states) == (2, 2, 2, 3, 3)
    assert (drive.commands[-1] == 'stop') is (reason != 'taken over')


@pytest.mark.parametrize('words', ['other status', 'other patrol x', 'other say hello',
                                   'battery 30'])
def test_what_others_do_besides_driving_is_harmless(words):
    drive = under_way()
    drive.inject(words)
    drive.run(lambda: not drive.follower.running, 120.0)
    assert set(drive.follower.report().states) == {2}


def test_a_goal_that_cannot_be_reached_ends_the_route_with_the_robots_words():
    drive = SimulatedDrive('vertex_by_vertex')
    drive.inject('fail 12')
    drive.drive(1, *ALONG_THE_HALL)
    report = drive.follower.report()
    assert report.reason.text == 'Failed going to goal'
    assert tuple(report.states) == (2, 2, 2, 3, 3)


def test_who_takes_over_arrives():
    drive = under_way()
    drive.inject('other goto 10')
    drive.run(lambda: 'Arrived at 10' in drive.lines[-5:] and not drive.follower.running, 60.0)
    assert drive.commands[-1] == 'goto 12'


@pytest.mark.parametrize('stall_timeout, reason', [
    (20.0, 'no progress for 20 s'),
    (120.0, 'Failed going to goal'),
])
def test_a_blocked_way_ends_the_route_when_the_robot_or_the_bridge_gives_up(stall_timeout, reason):
    drive = SimulatedDrive(vertex=8, stall_timeout=stall_timeout)
    drive.inject('block -10880 6600')  # on edge 17, which leads into a dead end
    drive.drive(1, 14, 17)
    assert drive.follower.report().reason.text == reason
    assert tuple(drive.follower.report().states) == (2, 3)
    assert drive.commands[-1] == 'stop'


def test_a_robot_that_goes_another_way_around_what_blocks_its_own_ends_the_route():
    drive = SimulatedDrive('rolling', vertex=8)
    drive.order(1, 1, 2, 3, 4, 5, 6)
    drive.run(lambda: list(drive.follower.report().states).count(2) == 2, 60.0)
    drive.inject('block -1500 0')  # on edge 3
    drive.run(lambda: not drive.follower.running, 60.0)
    assert drive.follower.report().reason.text == 'off the corridor'
    assert tuple(drive.follower.report().states) == (2, 2, 3, 3, 3, 3)
    assert drive.commands[-1] == 'stop'


def test_the_stop_of_a_failed_route_is_obeyed_as_soon_as_the_robot_stands():
    """Once, the stop failed after 15 s, because enabled motors also cause a `Stopping` line."""
    drive = under_way()
    drive.inject('estop press')
    drive.run(lambda: not drive.follower.running, 10.0)
    drive.inject('estop release')
    drive.enable_motors()
    drive.run(lambda: not drive.stops, 2.0)


def test_after_a_failure_a_new_route_goes_on_from_the_middle_of_an_edge():
    drive = under_way()
    drive.inject('estop press')
    drive.run(lambda: not drive.follower.running, 10.0)
    drive.inject('estop release')
    drive.enable_motors()
    drive.run(lambda: not drive.follower.robot.owes_stop, 60.0)
    drive.drive(2, 2, 3)
    assert tuple(drive.follower.report().states) == (2, 2)
