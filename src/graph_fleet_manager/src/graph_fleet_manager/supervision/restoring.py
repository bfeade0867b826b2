"""Restores the robots of a fleet after a restart, on a graph that may have changed."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Mapping, Optional, Tuple

from graph_fleet_manager.fleet import Fleet, RobotType
from graph_fleet_manager.geometry.areas import Area, Point
from graph_fleet_manager.interlocking.orders import Memory
from graph_fleet_manager.interlocking.reports import GraphPosition
from graph_fleet_manager.interlocking.route_client import RouteClient
from graph_fleet_manager.interlocking.route_record import RouteRecord
from graph_fleet_manager.supervision.journal import RobotMemory
from graph_fleet_manager.supervision.outages import Outage
from graph_fleet_manager.supervision.robots import ManagedRobot
from graph_fleet_manager.supervision.settings import RobotSettings
from trajectory_graph import Graph

_STEP = 0.1  # m between two points of a curve that is kept as a line


@dataclass(frozen=True)
class RemovedRobot:
    """A robot that is not in the fleet file any more. It keeps what it held."""

    name: str
    type: RobotType
    client: RouteClient

    @property
    def needs_person(self) -> bool:
        """The robot is never given anything to drive."""
        return True

    @property
    def is_silent(self) -> bool:
        """Reports of the robot are not received."""
        return True


def robots_of(fleet: Fleet, settings: Mapping[str, RobotSettings], graph: Graph,
              memories: Mapping[str, RobotMemory], before: Optional[Graph],
              now: float) -> Dict[str, ManagedRobot]:
    """All robots by name, each with its stored state.

    settings -- a robot without an entry gets the defaults of RobotSettings
    before   -- the other graph to which the stored states refer; None: they refer to this graph
    """
    robots: Dict[str, ManagedRobot] = {}
    for robot in fleet.robots:
        own = settings.get(robot.name, RobotSettings())
        managed = ManagedRobot(robot.name, robot.type, own, RouteClient(
            RouteRecord(graph, robot.type, own.slack, own.stopping)))
        memory = memories.get(robot.name)
        if memory is not None:
            _restore(managed, memory, graph, before, now)
        if robot.absent and managed.outage is not Outage.ABSENT:
            managed.declare_absent(now)
        robots[robot.name] = managed
    return robots


def removed_of(fleet: Fleet, graph: Graph, memories: Mapping[str, RobotMemory],
               before: Optional[Graph], now: float) -> Dict[str, RemovedRobot]:
    """Robots that are stored, but are not in the fleet file any more."""
    names = {robot.name for robot in fleet.robots}
    removed: Dict[str, RemovedRobot] = {}
    for name, memory in memories.items():
        if name not in names and memory.kind is not None and not memory.client.evidence.is_absent:
            client = RouteClient(RouteRecord(graph, memory.kind))
            # It has no topics here any more, so that not even a stop can be sent to it.
            client.restore(memory.client.on(graph)._replace(is_stopping=False), now)
            client.lose(lost_areas(memory.client, graph, before))
            removed[name] = RemovedRobot(name, memory.kind, client)
    return removed


def _restore(robot: ManagedRobot, memory: RobotMemory, graph: Graph, before: Optional[Graph],
             now: float) -> None:
    robot.client.restore(memory.client.on(graph), now)
    robot.client.lose(lost_areas(memory.client, graph, before))
    outage = memory.outage
    if outage is not None and (outage.needs_person or outage is Outage.ABSENT):
        robot.outage, robot.why = outage, memory.why
    robot.is_halted, robot.comes_to_rest = memory.is_halted, memory.comes_to_rest
    robot.dock = memory.dock
    if memory.charge is not None:
        robot.battery.charge = memory.charge


def lost_areas(memory: Memory, graph: Graph, before: Optional[Graph]) -> List[Area]:
    """Areas where a robot may be and that the new graph has elsewhere, or not at all.

    before -- the other graph to which the memory refers; None: it refers to this graph
    """
    if before is None:
        return []
    kept = memory.on(graph)
    held = {abs(edge) for edge in kept.held if _is_kept(abs(edge), graph, before)}
    areas = [Area(_line(before, edge, begin)) for edge, begin in _parts(memory).items()
             if abs(edge) in before.edges and abs(edge) not in held]
    position = memory.position
    if position is not None and position.is_on(before) and not (
            kept.position == position and _is_there(position, graph, before)):
        areas.append(Area((position.point(before),)))
    return areas


def _parts(memory: Memory) -> Dict[int, float]:
    """The signed edges that the robot may be on, each with the fraction that lies behind it."""
    parts = dict.fromkeys(memory.held, 0.0)
    first = memory.held[0] if memory.cleared[0] < len(memory.edges) else 0
    if first and memory.held.count(first) == 1:
        parts[first] = memory.cleared[1]
    return parts


def _is_kept(edge: int, graph: Graph, before: Graph) -> bool:
    """Is the curve of an edge the same in both graphs?

    A robot may drive a route of another giver over an edge that the graph before did not have.
    """
    if not (edge in graph.edges and edge in before.edges):
        return False
    ends = [(one.edge(edge).curve_type, one.edge(edge).param_f, one.edge(edge).param_b, *(
        (vertex.position, vertex.theta)
        for vertex in (one.start_vertex(edge), one.end_vertex(edge)))) for one in (graph, before)]
    return ends[0] == ends[1]


def _is_there(position: GraphPosition, graph: Graph, before: Graph) -> bool:
    return position.is_on(graph) and position.point(graph) == position.point(before)


def _line(graph: Graph, edge: int, begin: float) -> Tuple[Point, ...]:
    """The curve of a signed edge from a fraction of it on."""
    curve = graph.curve(edge)
    first, rest = begin * curve.length, (1.0 - begin) * curve.length
    steps = max(int(rest / _STEP), 1)
    points = (curve.point_at(first + rest * k / steps) for k in range(steps + 1))
    return tuple((float(x), float(y)) for x, y in points)
