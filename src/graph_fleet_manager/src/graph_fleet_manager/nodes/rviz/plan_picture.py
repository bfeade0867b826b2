"""The plans of a fleet in RViz, each one in the colour of its robot."""
from __future__ import annotations

from typing import Dict, List, Mapping, Sequence, Set

from visualization_msgs.msg import Marker

from itrci_nav_msgs.msg import FleetPlan, FleetRobot, FleetState, RobotPlan
from rviz_drawing import drawing
from trajectory_graph import Graph

PLAN_WIDTH, RELEASED_WIDTH, BLOCKED_WIDTH = 0.04, 0.13, 0.22
BLOCKED = drawing.colour(1.0, 0.25, 0.2, 0.6)
LANE = 0.07     # m between the plans of two robots on one edge
LANES = 4
_Z = 0.05
#: States in which a robot obeys no order: its allocation is blocked for the others.
BLOCKING = frozenset((FleetRobot.OFFLINE, FleetRobot.STOPPED, FleetRobot.TAKEN_OVER,
                      FleetRobot.FAILED, FleetRobot.OFF_GRAPH, FleetRobot.OUT_OF_SERVICE))


def plan_markers(graph: Graph, plan: FleetPlan, state: FleetState,
                 numbers: Mapping[str, int]) -> List[Marker]:
    """Returns the plans as thin lines, released edges as thick lines, destinations as rings.

    If a robot obeys no order, the edges that it blocks are red.

    numbers -- the number of each robot's colour, by the robot's name
    """
    plans: Dict[str, RobotPlan] = {one.robot: one for one in plan.plans}
    markers: List[Marker] = []
    blocked: Set[int] = set()
    for robot in state.robots:
        number = numbers.get(robot.name, 0)
        own = plans.get(robot.name, RobotPlan())
        released, planned = ([edge for edge in edges if abs(edge) in graph.edges] for edges in (
            own.drives.edges[:own.released], own.drives.edges[own.released:]))
        if robot.state in BLOCKING:
            blocked.update(map(abs, released))
            if abs(robot.pose.edge_id) in graph.edges:
                blocked.add(abs(robot.pose.edge_id))
            continue
        markers += _plan_of_robot(graph, planned, released, number)
        if robot.destination in graph.vertices and robot.has_mission:
            place = graph.vertices[robot.destination].position
            markers.append(drawing.lines('destinations', number, drawing.own_colour(number), 0.07,
                                         [drawing.ring(place, 0.3 + 0.05 * (number % LANES))], _Z))
    markers.append(drawing.lines('blocked', 0, BLOCKED, BLOCKED_WIDTH,
                                 [graph.curve(edge).sample(drawing.STEP) for edge in blocked],
                                 _Z / 2))
    return markers


def _plan_of_robot(graph: Graph, planned: Sequence[int], released: Sequence[int],
                   number: int) -> List[Marker]:
    """Returns the plan of one robot and its released edges."""
    lane = LANE * (number % LANES + 0.5)
    return [drawing.lines(name, number, drawing.own_colour(number), width,
                          [drawing.beside(graph.curve(edge), lane)
                           for edge in dict.fromkeys(edges)], _Z + 0.001 * number)
            for name, width, edges in (('plans', PLAN_WIDTH, planned),
                                       ('released', RELEASED_WIDTH, released))]
