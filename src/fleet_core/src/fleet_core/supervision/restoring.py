"""Restores the robots of a fleet after a restart, on a graph that may have changed."""
from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import AbstractSet, Dict, List, Mapping, Optional, Tuple

from fleet_core.fleet import Fleet, RobotType
from fleet_core.geometry.areas import Area, Point
from fleet_core.interlocking.changes import Changes
from fleet_core.interlocking.reports import GraphPosition
from fleet_core.interlocking.route_master import Clock, Memory, RouteMaster
from fleet_core.interlocking.route_record import RouteRecord
from fleet_core.supervision.journal import RobotMemory
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.settings import RobotSettings
from route_protocol.master import Step
from trajectory_graph import Graph

_STEP = 0.1  # m between two points of a curve that is kept as a line


@dataclass(frozen=True)
class RemovedRobot:
    """A robot that is not in the fleet file any more. The places that it held stay blocked."""

    name: str
    type: RobotType
    master: RouteMaster

    @property
    def needs_person(self) -> bool:
        """Always true: the robot is never given anything to drive."""
        return True


def robots_of(fleet: Fleet, settings: Mapping[str, RobotSettings], graph: Graph,
              memories: Mapping[str, RobotMemory], before: Optional[Graph],
              now: float, clock: Clock, changes: Changes) -> Dict[str, ManagedRobot]:
    """Returns all robots by name, each with its stored state.

    settings -- a robot without an entry gets the defaults of RobotSettings
    before   -- the other graph to which the stored states refer; None: they refer to `graph`
    changes  -- where the robots' changes are noted
    """
    robots: Dict[str, ManagedRobot] = {}
    for robot in fleet.robots:
        own = settings.get(robot.name, RobotSettings())
        managed = ManagedRobot(robot.name, robot.type, own, RouteMaster(
            RouteRecord(graph, robot.type, own.slack), clock, partial(changes.add, robot.name)))
        memory = memories.get(robot.name)
        if memory is not None:
            _restore(managed, memory, graph, before, now)
        else:  # a new robot; or the robot's numbers were lost with the journal
            managed.master.restore(Memory(), now)
        if robot.absent and managed.outage is not Outage.ABSENT:
            managed.declare_absent(now)
        robots[robot.name] = managed
    return robots


def removed_of(fleet: Fleet, graph: Graph, memories: Mapping[str, RobotMemory],
               before: Optional[Graph], now: float, clock: Clock,
               changes: Changes) -> Dict[str, RemovedRobot]:
    """Returns the robots that are in the journal, but not in the fleet file any more."""
    names = {robot.name for robot in fleet.robots}
    removed: Dict[str, RemovedRobot] = {}
    for name, memory in memories.items():
        if name not in names and memory.kind is not None and not memory.master.is_absent:
            master = RouteMaster(RouteRecord(graph, memory.kind), clock,
                                 partial(changes.add, name))
            # The robot has no topics here any more, so not even a stop can be sent to it.
            kept, areas = on_graph(memory.master, graph, before)
            master.restore(kept, now)
            master.lose(areas)
            master.drop_stops()
            removed[name] = RemovedRobot(name, memory.kind, master)
    return removed


def _restore(robot: ManagedRobot, memory: RobotMemory, graph: Graph, before: Optional[Graph],
             now: float) -> None:
    kept, areas = on_graph(memory.master, graph, before)
    robot.master.restore(kept, now)
    robot.master.lose(areas)
    outage = memory.outage
    if outage is not None and (outage.needs_person or outage is Outage.ABSENT):
        robot.outage, robot.why = outage, memory.why
    robot.is_halted, robot.comes_to_rest = memory.is_halted, memory.comes_to_rest
    robot.dock, robot.tops_up = memory.dock, memory.tops_up
    robot.charge_until = memory.charge_until
    if memory.charge is not None:
        robot.battery.charge = memory.charge


def on_graph(memory: Memory, graph: Graph, before: Optional[Graph]) -> Tuple[Memory, List[Area]]:
    """Returns the part of the stored state that a graph allows, and areas that replace the rest.

    A robot may follow an order over an edge that the graph does not have. It must be stopped.

    before -- the other graph to which the memory refers; None: it refers to `graph`
    """
    if before is None:
        return memory, []
    protocol = memory.protocol
    kept = {step for step in protocol.may_be_on if _is_kept(abs(step.edge), graph, before)}
    orders = tuple(order for order in protocol.open if kept.issuperset(order.steps(protocol.done)))
    dropped = [step for order in protocol.open if order not in orders
               for step in order.steps(protocol.done)]
    held = dict.fromkeys((*protocol.held, *dropped))
    position, places = _position_on(memory, graph, before)
    return memory._replace(position=position, protocol=replace(
        protocol, open=orders, behind=tuple(step for step in protocol.behind if step in kept),
        held=tuple(step for step in held if step in kept),
    )), [*_areas_of(memory, kept, before), *places]


def _areas_of(memory: Memory, kept: AbstractSet[Step], before: Graph) -> List[Area]:
    """Returns the areas of those edges that the robot may be on, but that are not kept."""
    number, fraction = memory.cleared
    return [Area(_line(before, step.edge, fraction if step.number == number else 0.0))
            for step in memory.protocol.may_be_on
            if step not in kept and step.number >= number and abs(step.edge) in before.edges]


def _position_on(memory: Memory, graph: Graph,
                 before: Graph) -> Tuple[Optional[GraphPosition], List[Area]]:
    """Returns the stored position; None: the graph does not have it any more.

    The second value is the area of a position that is lost in this way, if the robot stood there.
    """
    position = memory.position
    if position is None or _is_there(position, graph, before):
        return position, []
    if position.is_on(before) and not memory.protocol.may_drive:
        return None, [Area((position.point(before),))]
    return None, []


def _is_kept(edge: int, graph: Graph, before: Graph) -> bool:
    """Returns whether the curve of an edge is the same in both graphs.

    Even the old graph may lack the edge: another giver may have ordered a drive on it.
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
    """Returns points on the curve of a signed edge, from the fraction `begin` on."""
    curve = graph.curve(edge)
    first, rest = begin * curve.length, (1.0 - begin) * curve.length
    steps = max(int(rest / _STEP), 1)
    points = (curve.point_at(first + rest * k / steps) for k in range(steps + 1))
    return tuple((float(x), float(y)) for x, y in points)
