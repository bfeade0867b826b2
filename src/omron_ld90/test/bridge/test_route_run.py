"""One route: the goals to which it sends the robot, the complete edges, and its end."""
from __future__ import annotations

from typing import Tuple

import pytest
from bridge_builders import DOCK_VERTEX, graph_of, yard

from omron_arcl import Outcome
from omron_arcl.replies import DockingState
from omron_ld90.bridge.events import CommandEnded
from omron_ld90.bridge.goal_tracker import DOCK, GoalTracker, RouteFailed
from omron_ld90.bridge.graph_location import GraphLocation
from omron_ld90.bridge.robot_state import MapLocation, RobotLocation
from omron_ld90.bridge.route_progress import RouteProgress
from omron_ld90.bridge.route_run import RouteRun
from omron_ld90.bridge.route_strategies import RouteSettings, direct, vertex_by_vertex
from route_protocol.order_rules import edge_states
from route_protocol.values import EdgeState, Phase, Reason, ReasonCode, RouteOrder
from route_protocol.vehicle import Vehicle

SETTINGS = RouteSettings(dock_vertex=DOCK_VERTEX, strategy=vertex_by_vertex)
NEVER = float('-inf')


def vehicle_with(*edges: int, first: int = 0) -> Vehicle:
    """Returns the vehicle's side of the route protocol, after it has taken an order."""
    vehicle = Vehicle(lambda: 1, lambda: 0)
    vehicle.take_order(RouteOrder(7, edges, order=1, first=first, master='fleet'), first)
    return vehicle


class Drive:
    """A route over the yard that is driven vertex by vertex from its first vertex on."""

    def __init__(self, *edges: int, settings: RouteSettings = SETTINGS, first: int = 0) -> None:
        self.now, self.stamp = 0.0, 0
        self.tracker, self.location = GoalTracker(), RobotLocation()
        graph = yard()
        start = graph.start_vertex(edges[0]).position
        progress = RouteProgress(graph, edges, SETTINGS.vertex_tolerance, (DOCK_VERTEX,), start, 0)
        self.vehicle = vehicle_with(*edges, first=first)
        self.run = RouteRun(self.vehicle, settings, self.tracker, self.location, progress,
                            self.now)
        self.see(*start)
        self.run.drive()

    @property
    def states(self) -> Tuple[EdgeState, ...]:
        state = self.vehicle.state
        return edge_states(state.edges, state.completed, state.phase)

    def replace(self, *edges: int, first: int = 0) -> None:
        """Gives the vehicle another order, which has the same current edge."""
        state = self.vehicle.state
        self.vehicle.take_order(RouteOrder(7, edges, order=state.order + 1, first=first,
                                           master='fleet'), state.done)
        self.run.replace(self.now)

    def see(self, x: float, y: float) -> GraphLocation:
        self.stamp += 500_000_000
        self.now += 0.5
        self.location.update(MapLocation(self.stamp, x, y), self.now)
        self.tracker.located((x, y))
        return GraphLocation(self.run.progress.graph, (x, y), None, DOCK_VERTEX,
                             SETTINGS.vertex_tolerance, SETTINGS.corridor_width)

    def go(self, *places: Tuple[float, float]) -> str:
        """Lets the robot be seen at these places. Returns the notes for people."""
        told = ''
        for place in places:
            told += self.run.locate(self.see(*place), self.now)
            told += self.run.drive_on(self.now, NEVER)
        return told

    def arrive(self) -> None:
        self.tracker.word.give(1, 0)
        self.tracker.ended(CommandEnded(1, Outcome.SUCCEEDED), self.now)
        self.run.drive_on(self.now, NEVER)


def test_it_sends_the_robot_to_the_end_of_its_first_edge():
    drive = Drive(1, 5)
    assert drive.tracker.word.command == 'goto 2'
    assert drive.states == (EdgeState.PROCESSING, EdgeState.PROCESSING)


def test_an_edge_is_complete_and_the_next_goal_sent_when_the_robot_is_there():
    drive = Drive(1, 5)
    drive.go((2.0, 0.0), (4.0, 0.0))
    drive.arrive()
    assert drive.states == (EdgeState.COMPLETE, EdgeState.PROCESSING)
    assert drive.tracker.word.command == 'goto 5'


def test_the_route_is_complete_with_its_last_edge():
    drive = Drive(1)
    drive.go((4.0, 0.0))
    assert drive.run.running
    drive.arrive()
    assert drive.vehicle.state.phase is Phase.COMPLETE
    assert drive.states == (EdgeState.COMPLETE,)


def test_the_dock_is_gone_to_by_its_own_command():
    assert Drive(9).tracker.word.command == DOCK


def test_twice_off_the_corridor_ends_it_and_once_does_not():
    drive = Drive(5, 6)
    drive.go((5.0, 0.6), (5.5, 0.0), (6.0, 0.6))
    with pytest.raises(RouteFailed, match='off the corridor'):
        drive.go((6.5, 0.6))


def test_without_progress_it_ends_after_the_stall_timeout():
    drive = Drive(1, 5)
    drive.go((1.0, 0.0))
    drive.run.drive_on(drive.now + 29.0, NEVER)
    # docking is also progress
    drive.run.drive_on(drive.now + 31.0, docking_changed=drive.now + 2.0)
    with pytest.raises(RouteFailed, match='no progress for 30 s'):
        drive.run.drive_on(drive.now + 33.0, NEVER)


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
    drive.replace(1, 5)
    assert drive.run.running
    assert drive.states == (EdgeState.COMPLETE, EdgeState.PROCESSING)
    assert drive.tracker.word.command == 'goto 5'


@pytest.mark.parametrize('edges, first', [((1, 5, 6), 0), ((5, 6), 1), ((9, 1, 5, 6), -1)])
def test_an_order_may_leave_out_or_add_edges_that_are_driven(edges, first):
    """The progress does not jump, and the robot is not sent again to its present goal."""
    drive = Drive(1, 5, first=8)
    drive.go((4.0, 0.0))
    drive.arrive()
    drive.go((6.0, 0.0))
    before = drive.run.progress.pose
    drive.tracker.word.give(2, 0)
    drive.replace(*edges, first=8 + first)
    assert drive.run.progress.pose == before
    assert drive.vehicle.state.done == 9
    assert not drive.tracker.word.must_be_given
    drive.go((8.0, 0.0))
    drive.arrive()
    assert drive.tracker.word.command == 'goto 6'
    assert drive.vehicle.state.done == 10


def completed(*edges: int) -> Drive:
    """Returns a route that has been driven vertex by vertex."""
    drive = Drive(*edges)
    for edge in edges:
        drive.go(drive.run.progress.graph.end_vertex(edge).position)
        drive.arrive()
    assert drive.vehicle.state.phase is Phase.COMPLETE
    return drive


def test_who_has_driven_a_route_has_no_more_business_with_the_robot():
    assert completed(1, 5).tracker.goal is None


def test_a_complete_route_that_is_ordered_shorter_stays_complete():
    drive = completed(1, 5)
    drive.replace(1)
    assert drive.vehicle.state.phase is Phase.COMPLETE
    assert drive.tracker.goal is None


def test_a_complete_route_that_gets_longer_much_later_has_not_stalled():
    drive = completed(1)
    drive.now += 100.0
    drive.replace(1, 5)
    assert drive.go((4.0, 0.0)) == ''


def test_a_docked_robot_has_docked_though_it_stands_in_front_of_the_vertex():
    drive = Drive(9)
    drive.go((0.0, -3.0), (0.0, -3.5))
    drive.arrive()
    assert drive.vehicle.state.phase is Phase.COMPLETE


def test_the_robot_may_brake_from_the_edge_before_to_the_one_behind_its_target():
    drive = Drive(1, 5, 6)
    assert drive.run.edges_under_way == (1, 5)
    drive.go((4.0, 0.0))
    drive.arrive()
    assert drive.run.edges_under_way == (1, 5, 6)


def test_a_robot_is_on_the_edge_that_it_drives_or_has_just_driven_or_failed_on():
    drive = Drive(1, 5, 6)
    drive.go((4.0, 0.0))
    drive.arrive()
    assert [edge for edge in (1, 5, 6) if drive.run.is_on(edge)] == [1, 5]
    drive.vehicle.fail(Reason(ReasonCode.OTHER, 'why'))
    assert [edge for edge in (1, 5, 6) if drive.run.is_on(edge)] == [5]
    drive.vehicle.stop(RouteOrder(8, ()))
    assert not any(drive.run.is_on(edge) for edge in (1, 5, 6))


@pytest.mark.parametrize('edges, decides', [((1,), False), ((9,), True)])
def test_a_docked_robot_is_where_the_route_ended_only_if_that_is_the_dock(edges, decides):
    drive = completed(*edges)
    here = GraphLocation(drive.run.progress.graph, (4.0, 0.0), DockingState.DOCKED, DOCK_VERTEX,
                         SETTINGS.vertex_tolerance, SETTINGS.corridor_width)
    assert drive.run.decides_pose(here) is decides


def test_edges_on_which_the_robot_may_brake_are_allowed_on_its_edge_only():
    drive = Drive(1, 5)
    drive.run.allow((2,))
    drive.go((4.0, 0.6), (4.0, 0.7), (4.0, 0.0))
    drive.arrive()
    with pytest.raises(RouteFailed, match='off the corridor'):
        drive.go((4.0, 0.6), (4.0, 0.7))


def test_a_robot_that_only_trembles_makes_no_progress():
    drive = Drive(1, 5)
    drive.go((1.0, 0.0))
    begun = drive.now
    drive.now += 29.0
    drive.go((1.04, 0.0))
    with pytest.raises(RouteFailed, match='no progress for 30 s'):
        drive.run.drive_on(begun + 30.5, NEVER)


@pytest.mark.parametrize('docking, told', [
    (DockingState.DOCKED, ''), (None, 'The robot missed vertex 1 and is sent back to it.')])
def test_a_docked_robot_has_missed_no_vertex_wherever_it_stands(docking, told):
    graph = graph_of({DOCK_VERTEX: (0, 0), 1: (1, 0), 2: (0, -1)}, {9: (DOCK_VERTEX, 1), 1: (1, 2)})
    tracker, location, place = GoalTracker(), RobotLocation(), (0.0, -0.5)
    location.update(MapLocation(1, *place), 0.0)
    progress = RouteProgress(graph, (9, 1), SETTINGS.vertex_tolerance, (DOCK_VERTEX,),
                             (0.0, 0.0), 0)
    run = RouteRun(vehicle_with(9, 1), SETTINGS, tracker, location, progress, 0.0)
    run.target = 1
    here = GraphLocation(graph, place, docking, DOCK_VERTEX, SETTINGS.vertex_tolerance,
                         SETTINGS.corridor_width)
    assert run.locate(here, 0.5) == told
    assert tracker.word.must_be_given is bool(told)


class TestAVertexThatWasMissed:
    """The robot reports that it has arrived beyond a vertex that it did not reach."""

    @pytest.fixture
    def drive(self) -> Drive:
        drive = Drive(1, 5, settings=RouteSettings(dock_vertex=DOCK_VERTEX, strategy=direct))
        assert drive.tracker.word.command == 'goto 5'
        drive.go((2.0, 0.0))
        drive.arrive()
        return drive

    def test_it_is_sent_back_and_drives_on(self, drive):
        drive.now += 25.0
        assert drive.go((2.0, 0.0), (2.0, 0.0)) == (
            'The robot missed vertex 2 and is sent back to it.')
        assert drive.tracker.word.command == 'goto 2'
        drive.now += 25.0  # the robot may need this long
        drive.go((2.0, 0.0))

    def test_but_once_only(self, drive):
        drive.go((2.0, 0.0), (2.0, 0.0))
        drive.arrive()
        with pytest.raises(RouteFailed, match='says that it is at 2, but is 2.0 m away'):
            drive.go((2.0, 0.0), (2.0, 0.0))
