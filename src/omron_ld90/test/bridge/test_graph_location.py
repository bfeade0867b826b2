"""The place on the graph that belongs to a location, given a corridor width and a tolerance."""
from __future__ import annotations

from typing import Optional, Tuple

import pytest
from bridge_builders import DOCK_VERTEX, graph_of, yard

from omron_arcl.replies import DockingState
from omron_ld90.bridge.graph_location import GraphLocation
from route_protocol.values import SymbolicPose
from trajectory_graph import Graph


def at(x: float, y: float, docking: Optional[DockingState] = None, graph: Optional[Graph] = None,
       dock_vertex: Optional[int] = DOCK_VERTEX) -> GraphLocation:
    return GraphLocation(graph or yard(), (x, y), docking, dock_vertex, vertex_tolerance=0.3,
                         corridor_width=0.9)


@pytest.mark.parametrize(('place', 'pose'), [
    ((1.0, 0.2), SymbolicPose(1, 25.0)),
    ((4.0, 3.0), SymbolicPose(2, 75.0)),
    ((2.0, 0.6), SymbolicPose(0, 0.0)),  # outside the corridor
])
def test_the_symbolic_pose_is_on_the_nearest_edge(place: Tuple[float, float], pose):
    assert at(*place).symbolic_pose() == pose


def test_a_docked_robot_is_on_the_way_out_of_the_dock_wherever_its_station_is():
    assert at(0.0, -4.8, DockingState.DOCKED).symbolic_pose() == SymbolicPose(9, 100.0)


def test_a_graph_that_is_a_dock_only_has_no_edge_to_be_on():
    graph = graph_of({DOCK_VERTEX: (0, -4)}, {})
    assert at(0.0, -4.0, DockingState.DOCKED, graph).symbolic_pose() == SymbolicPose(0, 0.0)


def test_without_a_dock_vertex_a_docked_robot_is_where_it_is():
    here = at(1.0, 0.0, DockingState.DOCKED, dock_vertex=None)
    assert not here.is_docked
    assert here.symbolic_pose() == SymbolicPose(1, 25.0)


def test_about_the_dock_is_within_two_metres_or_docked():
    assert at(0.0, -2.1).is_about_the_dock
    assert not at(0.0, -1.9).is_about_the_dock
    assert at(3.0, 3.0, DockingState.DOCKED).is_about_the_dock


@pytest.mark.parametrize(('place', 'reason'), [
    ((0.2, 0.1), ''),  # at the first vertex of the edge
    ((2.0, 0.3), ''),  # on the edge
    ((2.0, 0.6), 'the robot is 0.60 m away from it'),
    ((3.9, 0.0), 'but ends there, at vertex 2'),
])
def test_a_route_begins_where_the_robot_is(place: Tuple[float, float], reason: str):
    assert reason in at(*place).why_not_from(1, being_driven=False)
    assert bool(at(*place).why_not_from(1, being_driven=False)) is bool(reason)


def test_an_edge_that_is_being_driven_may_be_begun_at_its_end():
    assert not at(3.9, 0.0).why_not_from(1, being_driven=True)


def test_a_docked_robot_begins_at_the_dock_only():
    assert not at(0.0, -4.8, DockingState.DOCKED).why_not_from(-9, being_driven=False)
    assert 'docked at vertex 90' in at(0.0, -4.8, DockingState.DOCKED).why_not_from(1, True)


def test_a_robot_that_leaves_the_dock_may_begin_at_the_dock():
    assert not at(0.0, -3.0, DockingState.UNDOCKING).why_not_from(-9, being_driven=False)


def test_of_equally_near_edges_the_first_counts():
    assert at(4.0, 0.0).nearest_of([2, 1]) == 0
    assert at(4.0, 0.0).nearest_of([3, 1, 2]) == 1
    assert at(2.0, 2.0).nearest_of([1, 2, 3, 4]) is None
    assert at(2.0, 2.0).nearest_of([]) is None
