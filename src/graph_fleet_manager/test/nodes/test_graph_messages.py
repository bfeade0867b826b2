"""The messages that graph_server publishes, and the messages of robots that it reads."""
from __future__ import annotations

import genpy
import pytest

from fleet_core.fleet import Fleet, RobotType
from fleet_core.site.changes import ReportedRoute
from fleet_core.site.closures import Closures, EdgeAction, EdgeOperation
from fleet_core.site.survey import Capacity, Survey
from graph_fleet_manager.messages.graphs import (
    WrongCommand,
    closed_edges_message,
    docking_points_message,
    edge_operation,
    graph_message,
    parking_message,
    reported_route,
)
from itrci_nav_msgs.msg import EdgeCommand, EdgeState, ExecutionRouteStates, SymbolicPose, Vertex
from trajectory_graph import Edge, Graph, GraphError, split_edges
from trajectory_graph import Vertex as GraphVertex
from trajectory_graph.messages import graph_from_message

STAMP = genpy.Time(1700000000, 5)
GRAPH = Graph([GraphVertex(1, 0.0, 0.0, 0.0, parking=True), GraphVertex(2, 2.0, 0.0, 0.0),
               GraphVertex(3, 4.0, 0.0, 0.0, parking=False),
               GraphVertex(4, 6.0, 0.0, 0.0, dock=True)],
              [Edge(1, 1, 2), Edge(2, 2, 3), Edge(3, 3, 4)])


def test_a_graph_arrives_as_it_was_with_what_it_says_of_parking():
    message = graph_message(GRAPH, STAMP)
    assert message.header.stamp == STAMP
    again = graph_from_message(message)
    assert (again.vertices, again.edges) == (GRAPH.vertices, GRAPH.edges)


def test_a_section_arrives_with_the_name_of_its_edge():
    cut = split_edges(GRAPH, 1.0)
    again = graph_from_message(graph_message(cut, STAMP))
    assert [edge.drawn_id for edge in again.edges.values()] == [1, 1, 2, 2, 3, 3]
    assert [id for id in again.vertices if again.divides_an_edge(id)] == [5, 6, 7]


def test_a_vertex_that_is_parking_and_none_is_refused():
    message = graph_message(GRAPH, STAMP)
    message.vertices[0] = Vertex(id=1, parking=True, no_parking=True)
    with pytest.raises(GraphError, match='vertex 1'):
        graph_from_message(message)


def test_docking_points_name_the_types_that_charge_there():
    fleet = Fleet((RobotType('agv', 0.4, 1.0), RobotType('truck', 0.5, 1.0, docks=frozenset((4,)))),
                  ())
    point, = docking_points_message(GRAPH, fleet, STAMP).docking_points
    assert (point.vertex_id, point.robot_types) == (4, ['truck'])


def test_parking_bears_the_version_of_its_graph():
    found = Survey(0.9, frozenset((3, 1)), (Capacity('agv', 2, 1),), (), (), (), ())
    message = parking_message(found, STAMP)
    assert (message.header.stamp, message.vertices) == (STAMP, [1, 3])
    assert [(c.robot_type, c.robots, c.docks) for c in message.capacities] == [('agv', 2, 1)]


def test_closures_bear_the_moment_at_which_they_were_said(tmp_path):
    closures = Closures(tmp_path / 'closed.json')
    closures.replace([2], STAMP.to_nsec(), STAMP.to_nsec(), GRAPH.edges)
    message = closed_edges_message(closures)
    assert (message.header.stamp, message.edges) == (STAMP, [2])


def command(code: int, *edges: int, stamp: int = 0, number: int = 1) -> EdgeCommand:
    message = EdgeCommand(command=code, edges=list(edges))
    message.header.stamp, message.header.seq = genpy.Time(stamp), number
    return message


@pytest.mark.parametrize('code, action', [(EdgeCommand.OPEN, EdgeAction.OPEN),
                                          (EdgeCommand.CLOSE, EdgeAction.CLOSE)])
def test_a_command_is_an_operation_on_its_edges_in_either_direction(code, action):
    assert edge_operation(command(code, 3, -4), '/a') == EdgeOperation(action, frozenset((3, 4)))


def test_a_message_has_one_identity_and_another_one_another():
    def identity(sender='/a', **of):
        return edge_operation(command(EdgeCommand.CLOSE, 3, **of), sender).identity
    assert identity(stamp=5) == identity(stamp=5) != ''
    others = [identity(stamp=5), identity(stamp=6), identity(stamp=5, number=2),
              identity('/b', stamp=5)]
    assert len(set(others)) == 4


@pytest.mark.parametrize('message, words', [
    (command(7, 3), 'has the code 7'), (command(EdgeCommand.CLOSE), 'names no edge')])
def test_a_command_that_cannot_be_carried_out_says_why(message, words):
    with pytest.raises(WrongCommand, match=words):
        edge_operation(message, '/a')


@pytest.mark.parametrize('states, left', [
    ([], ()),
    ([(1, EdgeState.COMPLETE), (-2, EdgeState.PROCESSING), (3, EdgeState.PROCESSING)], (-2, 3)),
    ([(1, EdgeState.COMPLETE), (2, EdgeState.COMPLETE)], ()),
    ([(1, EdgeState.FAILED), (2, EdgeState.FAILED)], ()),
], ids=['no route', 'under way', 'complete', 'failed'])
def test_what_is_left_of_a_route_is_what_must_not_be_broken(states, left):
    report = ExecutionRouteStates(edge_states=[EdgeState(*state) for state in states],
                                  symbolic_pose=SymbolicPose(-2, 40.0))
    assert reported_route(report) == ReportedRoute(left, -2)
