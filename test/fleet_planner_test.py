#!/usr/bin/env python3
"""graph_server and path_planner under a ROS master: the graph is published, changed and closed.

The planner plans a fleet on this graph. The test plays the supervisor and the robots.
"""
from __future__ import annotations

import itertools
import os
import subprocess
import unittest
from dataclasses import replace
from typing import Iterable, List, Optional

import rosnode
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rosgraph_msgs.msg import Log
from std_msgs.msg import Header
from std_srvs.srv import Trigger, TriggerResponse

from itrci_nav_msgs.msg import (
    ClosedEdges,
    DockingPoints,
    EdgeCommand,
    EdgeState,
    ExecutionRouteStates,
    FleetObstacle,
    ParkingPlaces,
    PlanAnswer,
    PlanRequest,
    RobotTask,
    SymbolicPose,
)
from itrci_nav_msgs.msg import Graph as GraphMessage
from system_support import Recorder, connected_publisher, program, run_cases, wait_until
from trajectory_graph import Edge, Graph, Vertex, save_graph
from trajectory_graph.messages import graph_from_message


def corridor(*without: int) -> Graph:
    """Returns vertices 1 to 5 in a row, with edges 1 to 4 between them, and some branches.

    - edge 5 leads from 5 to dock 6
    - edge 7 leads from 3 to a siding, vertex 7
    - edges 8 and 9 form a second route from 2 to 4 through vertex 8
    """
    places = {1: (0, 0), 2: (3, 0), 3: (6, 0), 4: (9, 0), 5: (12, 0), 6: (16, 0), 7: (6, 3),
              8: (6, -4)}
    ends = {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (4, 5), 5: (5, 6), 7: (3, 7), 8: (2, 8), 9: (8, 4)}
    ends = {id: pair for id, pair in ends.items() if id not in without}
    joined = {vertex for pair in ends.values() for vertex in pair}
    return Graph([Vertex(id, x, y, 0.0, dock=id == 6) for id, (x, y) in places.items()
                  if id in joined],
                 [Edge(id, *pair, velocity_forward=1.0, velocity_backwards=1.0)
                  for id, pair in ends.items()])


class FleetPlannerTest(unittest.TestCase):
    """All tests use the same nodes; each test begins with the whole corridor and no closed edge."""

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('fleet_planner_test')
        cls.graph_file = rospy.get_param('/graph_server/graph_file')
        cls.plan_ids = itertools.count(1)
        cls.graphs = Recorder('/graph', GraphMessage)
        cls.parking = Recorder('/parking', ParkingPlaces)
        cls.closed = Recorder('/closed_edges_in_force', ClosedEdges)
        cls.answers = Recorder('/plan_answer', PlanAnswer)
        cls.diagnostics = Recorder('/diagnostics', DiagnosticArray)
        cls.log = Recorder('/rosout', Log)
        cls.requests = connected_publisher('/plan_request', PlanRequest, to='path_planner')
        cls.closing = connected_publisher('/closed_edges', ClosedEdges, to='graph_server')
        cls.commands = connected_publisher('/edge_command', EdgeCommand, to='graph_server')
        cls.commands.publish(command=EdgeCommand.CLOSE, edges=[3, 99])
        cls.closed.wait_for(lambda _: True, 10, 'closure before there is a graph')
        cls.reports = rospy.Publisher('/agv_1/execution_route_states', ExecutionRouteStates,
                                      queue_size=10, latch=True)  # as robots do
        wait_until(lambda: cls.reports.get_num_connections() > 0, 20, 'graph_server subscribes')
        rospy.wait_for_service('/reload_graph', 30)
        wait_until(cls.answers.is_connected, 30, 'connection to /plan_answer')
        cls.first_words = cls.diagnostics.wait_for(
            lambda array: any(status.name == 'graph_server: graph' for status in array.status),
            20, 'diagnosis of the graph')

    @classmethod
    def tearDownClass(cls) -> None:
        for file in (cls.graph_file, rospy.get_param('/graph_server/closed_edges_file'),
                     rospy.get_param('/graph_server/graph_in_force_file')):
            if os.path.exists(file):
                os.unlink(file)

    def setUp(self) -> None:
        self.report(at=0)
        wait_until(lambda: self.accepted(corridor()), 10, 'the whole corridor in force')
        self.close()

    # -- actions of the tests ----------------------------------------------------------------------

    def reload(self, graph: Graph) -> TriggerResponse:
        save_graph(graph, self.graph_file)
        return rospy.ServiceProxy('/reload_graph', Trigger)()

    def close(self, *edges: int) -> List[int]:
        """Closes these edges and opens all others. Returns the edges that are then closed."""
        before = len(self.closed.messages)
        message = ClosedEdges(edges=list(edges))
        message.header.stamp = rospy.Time.now()
        self.closing.publish(message)
        told = self.closed.wait_for(lambda now: now.header.stamp == message.header.stamp, 10,
                                    'closure', before)
        return list(told.edges)

    def report(self, at: int, left: Iterable[int] = ()) -> None:
        """Sends a report of agv_1: the robot's edge, and the edges that are left of its route."""
        report = ExecutionRouteStates(
            route_id=1, edge_states=[EdgeState(edge, EdgeState.PROCESSING) for edge in left],
            symbolic_pose=SymbolicPose(at, 50.0))
        self.reports.publish(report)

    def plan(self, *tasks: RobotTask, patience: float = 10.0, **fields: object) -> PlanAnswer:
        """Returns the planner's answer to a request with the present graph and closed edges."""
        request = PlanRequest(plan_id=next(self.plan_ids), tasks=list(tasks),
                              graph_stamp=self.graphs.messages[-1].header.stamp,
                              closed_edges=self.closed.messages[-1].edges)
        request.header.stamp = rospy.Time.now()
        for name, value in fields.items():
            setattr(request, name, value)
        self.requests.publish(request)
        answer = self.answers.wait_for(lambda one: one.plan_id == request.plan_id, patience,
                                       'answer')
        self.assertEqual(request.header.stamp, answer.header.stamp)
        return answer

    def planned(self, *tasks: RobotTask, **fields: object) -> List[List[int]]:
        """Returns the edges in the plan of each robot."""
        answer = self.plan(*tasks, **fields)
        self.assertEqual((PlanAnswer.PLANNED, []), (answer.result, answer.unserved), answer.reason)
        return [list(plan.drives.edges) for plan in answer.plans]

    # -- graph_server -----------------------------------------------------------------------------

    def test_a_missing_graph_is_told_until_it_is_there(self):
        status = next(status for status in self.first_words.status
                      if status.name == 'graph_server: graph')
        self.assertEqual(DiagnosticStatus.ERROR, status.level)
        self.assertIn(self.graph_file, status.message)
        self.diagnostics.wait_for(
            lambda array: any(status.name == 'graph_server: graph'
                              and status.level == DiagnosticStatus.OK
                              and 'in force' in status.message for status in array.status),
            20, 'diagnosis without errors')

    def test_edges_that_are_closed_before_there_is_a_graph_are_closed_on_it(self):
        self.assertEqual([[3, 99], [3]], [list(told.edges) for told in self.closed.messages[:2]])

    def test_late_joiners_get_the_graph_its_docks_and_its_parking(self):
        graph = graph_from_message(rospy.wait_for_message('/graph', GraphMessage, 10))
        self.assertEqual((corridor().vertices, corridor().edges), (graph.vertices, graph.edges))
        docks = rospy.wait_for_message('/docking_points', DockingPoints, 10).docking_points
        self.assertEqual([(6, ['truck'])], [(dock.vertex_id, dock.robot_types) for dock in docks])
        # vertex 1 is an end, 7 is in the siding, 8 is in the second route; on 5 a robot would cut
        # off the dock
        parking = wait_until(lambda: self.parking_told([1, 6, 7, 8]), 20, 'parking of the graph')
        self.assertEqual(self.graphs.messages[-1].header.stamp, parking.header.stamp)
        capacities = {one.robot_type: (one.robots, one.docks) for one in parking.capacities}
        self.assertEqual({'agv': (3, 0), 'truck': (3, 1)}, capacities)

    def parking_told(self, vertices: List[int]) -> Optional[ParkingPlaces]:
        """Returns the latched message on /parking if it has these vertices, otherwise None.

        After an edge is opened, the new message comes a moment later.
        """
        told = rospy.wait_for_message('/parking', ParkingPlaces, 20)
        return told if list(told.vertices) == vertices else None

    def test_what_the_graph_allows_is_told_in_words(self):
        self.reload(corridor(8, 9))
        self.log.wait_for(lambda line: line.name == '/graph_server' and line.msg.startswith(
            'The graph holds 2 robots of type agv without cutting any robot off'), 20, 'capacity')

    def test_a_graph_that_breaks_a_running_route_is_refused_until_it_is_driven(self):
        before = len(self.graphs.messages)
        self.report(at=1, left=[1, 2, 7])
        refused = wait_until(lambda: self.refused(corridor(7)), 10, 'a refusal')
        self.assertIn('Edge 7 is missing, but robot agv_1 is to drive it', refused)
        self.assertEqual(before, len(self.graphs.messages), 'the old graph stays in force')

        self.report(at=3)
        accepted = wait_until(lambda: self.accepted(corridor(7)), 10, 'a new graph in force')
        self.assertIn('7 edges', accepted)
        told = self.graphs.wait_for(lambda graph: len(graph.edges) == 7, 10, 'new graph', before)
        self.assertGreater(told.header.stamp, self.graphs.messages[before - 1].header.stamp)

    def refused(self, graph: Graph) -> str:
        answer = self.reload(graph)
        return '' if answer.success else answer.message

    def accepted(self, graph: Graph) -> str:
        answer = self.reload(graph)
        return answer.message if answer.success else ''

    def test_a_file_that_is_no_graph_is_refused(self):
        with open(self.graph_file, 'w', encoding='utf-8') as file:
            file.write('Edges: []\nVertices: no\n')
        answer = rospy.ServiceProxy('/reload_graph', Trigger)()
        self.assertFalse(answer.success)
        self.assertIn('line 2', answer.message)

    def test_closed_edges_outlive_graph_server_and_unknown_ones_are_told(self):
        self.assertEqual([3], self.close(3, 99))
        self.log.wait_for(lambda line: line.name == '/graph_server' and 'Edges 99' in line.msg,
                          10, 'a log line about edge 99')
        closures = len(self.closed.messages)
        self.restart()
        told = self.closed.wait_for(lambda message: list(message.edges) == [3], 30,
                                    'closure of a new graph_server', closures)
        self.assertEqual([3], list(told.edges))

    def test_the_edges_of_two_operators_are_all_closed(self):
        operators = [self.edge('close', edge) for edge in ('3', '8')]
        self.assertEqual([0, 0], [one.wait(30) for one in operators])
        self.assertEqual([3, 8], list(self.closed.messages[-1].edges))
        said, _ = self.edge('open', '3').communicate(timeout=30)
        head, *closed = (line.split() for line in said.splitlines())
        self.assertEqual(['closed', 'edge'], head[:2])
        self.assertEqual(['8'], [row[0] for row in closed])

    def edge(self, *words: str) -> subprocess.Popen[str]:
        return subprocess.Popen([program('graph_fleet_manager', 'edge'), *words],
                                stdout=subprocess.PIPE, text=True)

    def test_a_command_counts_whatever_its_clock_says(self):
        now = rospy.Time.now()
        for stamp, edge in ((now, 3), (rospy.Time(1), 8), (now + rospy.Duration(9999), 9),
                            (rospy.Time(2), 1)):
            before = len(self.closed.messages)
            message = EdgeCommand(command=EdgeCommand.CLOSE, edges=[edge])
            message.header.stamp = stamp
            self.commands.publish(message)
            self.closed.wait_for(lambda told, edge=edge: edge in told.edges, 10,
                                 f'closure at {stamp.to_sec()}', before)
        self.assertEqual([1, 3, 8, 9], list(self.closed.messages[-1].edges))

    def test_a_list_that_is_not_used_is_told(self):
        self.closing.publish(ClosedEdges(edges=[3], header=Header(stamp=rospy.Time(1))))
        self.log.wait_for(lambda line: line.name == '/graph_server'
                          and 'stamp 1.000 s is not used' in line.msg, 10,
                          'a log line about the list')

    def test_a_restart_does_not_take_up_a_file_that_breaks_a_running_route(self):
        save_graph(corridor(7), self.graph_file)
        self.report(at=1, left=[1, 2, 7])
        self.restart()
        self.assertEqual(8, len(self.graphs.messages[-1].edges), 'the edge on which agv_1 drives')
        self.report(at=2)
        wait_until(lambda: self.accepted(corridor(7)), 10, 'a new graph in force')

    def restart(self) -> None:
        """Ends graph_server. Waits until roslaunch has restarted it and it has put a graph in
        force.
        """
        graphs = len(self.graphs.messages)
        rosnode.kill_nodes(['/graph_server'])
        self.graphs.wait_for(lambda _: True, 30, 'graph of a new graph_server', graphs)
        for publisher in (self.closing, self.commands, self.reports):
            wait_until(lambda p=publisher: p.get_num_connections() > 0, 20,
                       f'graph_server as subscriber of {publisher.resolved_name}')
        rospy.wait_for_service('/reload_graph', 20)

    # -- path_planner -----------------------------------------------------------------------------

    def test_two_robots_swap_places_in_the_corridor(self):
        answer = self.plan(
            RobotTask(robot='agv_1', robot_type='agv', vertex=1, destinations=[5], stays=True),
            RobotTask(robot='agv_2', robot_type='agv', vertex=5, destinations=[1], stays=True),
            improvement=0.2)
        self.assertEqual((PlanAnswer.PLANNED, []), (answer.result, answer.unserved))
        ends = [corridor().end_vertex(plan.drives.edges[-1]).id for plan in answer.plans]
        self.assertEqual([5, 1], ends)
        self.assertTrue(answer.precedence.drive, 'one of them goes first')
        self.assertGreaterEqual(answer.cost, answer.lower_bound)
        first = answer.plans[0].drives
        self.assertAlmostEqual(3.0, first.ends[0] - first.starts[0], 6)

    def test_a_closed_edge_is_driven_round(self):
        task = RobotTask(robot='agv_1', robot_type='agv', vertex=2, destinations=[4], stays=True)
        self.assertEqual([[2, 3]], self.planned(task))
        self.close(3)
        self.assertEqual([[8, 9]], self.planned(task))

    def test_nobody_is_parked_on_the_only_way_that_closed_edges_leave(self):
        self.parking.wait_for(lambda told: 8 in told.vertices, 20, 'parking of the whole graph')
        before = len(self.parking.messages)
        self.close(3)
        self.parking.wait_for(lambda told: 8 not in told.vertices, 20, 'parking beside 8', before)
        before = len(self.parking.messages)
        self.close()
        self.parking.wait_for(lambda told: 8 in told.vertices, 20, 'parking as before', before)

    def test_a_dead_robot_is_driven_round_or_named(self):
        task = RobotTask(robot='agv_1', robot_type='agv', vertex=2, destinations=[4], stays=True)
        dead = FleetObstacle(robot='truck_1', robot_type='truck', vertices=[3])
        self.assertEqual([[8, 9]], self.planned(task, obstacles=[dead]))
        dead.edges = [9]
        answer = self.plan(task, obstacles=[dead])
        self.assertEqual(['agv_1'], [one.robot for one in answer.unserved])
        self.assertIn('truck_1, which cannot move', answer.unserved[0].reason)

    def test_what_is_released_is_kept_and_parking_is_that_of_the_graph(self):
        parking = self.parking.wait_for(
            lambda one: one.header.stamp == self.graphs.messages[-1].header.stamp, 20, 'parking')
        task = RobotTask(robot='agv_1', robot_type='agv', released=[1, 2], begun=0.5,
                         destinations=[2])
        answer = self.plan(task)
        plan = answer.plans[0]
        self.assertEqual(((1, 2), 2), (plan.drives.edges[:2], plan.released))
        self.assertAlmostEqual(1.5, plan.drives.ends[0], 6)
        wait_until(lambda: self.end_of(self.plan(task)) in parking.vertices, 10,
                   'a plan that ends on parking, once the planner also knows the parking')

    def end_of(self, answer: PlanAnswer) -> int:
        """Returns the vertex on which the first robot's plan ends."""
        return corridor().end_vertex(answer.plans[0].drives.edges[-1]).id

    def test_a_planner_that_was_ended_answers_again(self):
        task = RobotTask(robot='agv_1', robot_type='agv', vertex=2, destinations=[4], stays=True)
        self.assertEqual([[2, 3]], self.planned(task))
        rosnode.kill_nodes(['/path_planner'])
        wait_until(lambda: not (self.requests.get_num_connections() or self.answers.is_connected()),
                   20, 'the end of path_planner')
        wait_until(lambda: self.requests.get_num_connections() > 0 and self.answers.is_connected(),
                   30, 'a new path_planner')
        answer = wait_until(lambda: self.plan_on_new_graph(task), 30, 'a plan of the new planner')
        self.assertEqual([2, 3], list(answer.plans[0].drives.edges))

    def test_nonsense_is_refused_and_another_graph_told(self):
        stranger = RobotTask(robot='agv_1', robot_type='boat', vertex=1)
        answer = self.plan(stranger)
        self.assertEqual(PlanAnswer.REFUSED, answer.result)
        self.assertIn("no robot type 'boat'", answer.reason)
        old = self.graphs.messages[-1].header.stamp - rospy.Duration(1)
        self.assertEqual(PlanAnswer.OTHER_GRAPH, self.plan(graph_stamp=old).result)

    def test_the_planner_follows_a_new_graph(self):
        slow = corridor()
        edges = [replace(edge, velocity_forward=0.1) if edge.id == 3 else edge
                 for edge in slow.edges.values()]
        before = len(self.graphs.messages)
        self.assertTrue(self.reload(Graph(slow.vertices.values(), edges)).success)
        self.graphs.wait_for(lambda _: True, 10, 'new graph', before)
        task = RobotTask(robot='agv_1', robot_type='agv', vertex=2, destinations=[4], stays=True)
        answer = wait_until(lambda: self.plan_on_new_graph(task), 30, 'a plan on the new graph')
        self.assertEqual([8, 9], list(answer.plans[0].drives.edges))

    def plan_on_new_graph(self, task: RobotTask) -> PlanAnswer | None:
        """Returns the plan on the new graph; None if there is none yet.

        Messages that are published while connections are made get lost. So the test repeats the
        request, like path_supervisor.
        """
        try:
            answer = self.plan(task, patience=2.0)
        except AssertionError:
            return None
        return None if answer.result == PlanAnswer.OTHER_GRAPH else answer


if __name__ == '__main__':
    run_cases(__file__)
