"""One route: where it sends the robot, what is complete, and what ends it."""
from __future__ import annotations

from typing import Tuple

import pytest
from bridge_builders import DOCK_VERTEX, yard

from omron_ld90.bridge.events import CommandEnded, Ending
from omron_ld90.bridge.goal_tracker import GoalTracker, RouteFailed
from omron_ld90.bridge.graph_location import GraphLocation
from omron_ld90.bridge.own_goals import DOCK
from omron_ld90.bridge.robot_state import Located, RobotLocation
from omron_ld90.bridge.route_progress import RouteProgress
from omron_ld90.bridge.route_run import RouteRun
from omron_ld90.bridge.route_strategies import Settings, vertex_by_vertex
from trajectory_graph.route_protocol import EdgeState, Phase, RouteOrder

SETTINGS = Settings(dock_vertex=DOCK_VERTEX, strategy=vertex_by_vertex)
NEVER = float('-inf')


class Drive:
    """A route over the yard from its first vertex on, vertex by vertex."""

    def __init__(self, *edges: int) -> None:
        self.now, self.stamp = 0.0, 0
        self.tracker, self.location = GoalTracker(), RobotLocation()
        graph = yard()
        start = graph.start_vertex(edges[0]).position
        progress = RouteProgress(graph, edges, SETTINGS.vertex_tolerance, (DOCK_VERTEX,), start, 0)
        self.run = RouteRun(RouteOrder(7, edges, 0), SETTINGS, self.tracker, self.location,
                            progress, self.now)
        self.see(*start)
        self.run.drive()

    def see(self, x: float, y: float) -> GraphLocation:
        self.stamp += 500_000_000
        self.now += 0.5
        self.location.update(Located(self.stamp, x, y), self.now)
        self.tracker.located((x, y))
        return GraphLocation(self.run.progress.graph, (x, y), None, DOCK_VERTEX,
                             SETTINGS.vertex_tolerance, SETTINGS.corridor_width)

    def go(self, *places: Tuple[float, float]) -> str:
        """The robot is seen at these places; what people are told."""
        told = ''
        for place in places:
            told += self.run.locate(self.see(*place), self.now)
            told += self.run.go_on(self.now, NEVER)
        return told

    def arrive(self) -> None:
        self.tracker.given(1)
        self.tracker.ended(CommandEnded(1, Ending.SUCCEEDED), self.now)
        self.run.go_on(self.now, NEVER)


def test_it_sends_the_robot_to_the_end_of_its_first_edge():
    drive = Drive(1, 5)
    assert drive.tracker.command == 'goto 2'
    assert drive.run.states == (EdgeState.PROCESSING, EdgeState.PROCESSING)


def test_an_edge_is_complete_and_the_next_goal_sent_when_the_robot_is_there():
    drive = Drive(1, 5)
    drive.go((2.0, 0.0), (4.0, 0.0))
    drive.arrive()
    assert drive.run.states == (EdgeState.COMPLETE, EdgeState.PROCESSING)
    assert drive.tracker.command == 'goto 5'


def test_the_route_is_complete_with_its_last_edge():
    drive = Drive(1)
    drive.go((4.0, 0.0))
    assert drive.run.running
    drive.arrive()
    assert drive.run.phase is Phase.COMPLETE
    assert drive.run.states == (EdgeState.COMPLETE,)


def test_the_dock_is_gone_to_by_its_own_command():
    assert Drive(9).tracker.command == DOCK


def test_twice_off_the_corridor_ends_it_and_once_does_not():
    drive = Drive(5, 6)
    drive.go((5.0, 0.6), (5.5, 0.0), (6.0, 0.6))
    with pytest.raises(RouteFailed, match='off the corridor'):
        drive.go((6.5, 0.6))


def test_without_progress_it_ends_after_the_stall_timeout():
    drive = Drive(1, 5)
    drive.go((1.0, 0.0))
    drive.run.go_on(drive.now + 29.0, NEVER)
    drive.run.go_on(drive.now + 31.0, docking_changed=drive.now + 2.0)  # docking is progress, too
    with pytest.raises(RouteFailed, match='no progress for 30 s'):
        drive.run.go_on(drive.now + 33.0, NEVER)


def test_an_arrival_elsewhere_is_not_believed_after_two_locations():
    drive = Drive(1)
    drive.go((1.0, 0.0))
    drive.arrive()
    drive.go((1.0, 0.0))
    with pytest.raises(RouteFailed, match='says that it is at 2, but is 3.0 m away'):
        drive.go((1.0, 0.0))


def test_a_longer_route_goes_on_from_what_is_done():
    drive = Drive(1)
    drive.go((4.0, 0.0))
    drive.arrive()
    drive.run.replace(RouteOrder(7, (1, 5), 0), drive.now)
    assert drive.run.running
    assert drive.run.states == (EdgeState.COMPLETE, EdgeState.PROCESSING)
    assert drive.tracker.command == 'goto 5'


def test_of_a_route_whose_graph_is_gone_the_edges_driven_are_remembered():
    run = RouteRun(RouteOrder(7, (1, 5, 6), 0), SETTINGS, GoalTracker(), RobotLocation(), None, 0.0,
                   Phase.FAILED, completed=1)
    assert not run.is_on_graph
    assert run.states == (EdgeState.COMPLETE, EdgeState.FAILED, EdgeState.FAILED)
    assert run.record(owes_stop=True).completed == 1
