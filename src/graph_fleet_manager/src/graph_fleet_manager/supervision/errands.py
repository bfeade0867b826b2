"""What each robot is to do next, as the planner is asked and as its release is bounded."""
from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

from graph_fleet_manager.planning.tasks import Obstacle, Outcome, PlannedDrive, Task
from graph_fleet_manager.supervision.missions import Mission, MissionState
from graph_fleet_manager.supervision.plan_in_force import PlanInForce, RobotPlan
from graph_fleet_manager.supervision.robots import ManagedRobot
from trajectory_graph import Graph

UNTIL_RELEASED = 3600.0  # s that a dwell without an end is planned for
_MID_EDGE = 1e-6         # the least fraction of an edge at which a robot is between its ends


class Duty(Enum):
    """What a robot is about."""

    IDLE = 'idle'        # makes room where somebody needs it
    MISSION = 'mission'
    CHARGE = 'charge'
    STAND = 'stand'      # paused: it stays where it is


@dataclass(frozen=True)
class Errand:
    """What one robot is to do.

    mission -- that it serves, paused or not
    dock    -- at which it is to charge
    """

    duty: Duty = Duty.IDLE
    mission: Optional[Mission] = None
    dock: Optional[int] = None


def errand_of(mission: Optional[Mission], dock: Optional[int]) -> Errand:
    """A mission comes before charging, unless it is paused."""
    if mission is not None:
        paused = mission.state is MissionState.PAUSED
        return Errand(Duty.STAND if paused else Duty.MISSION, mission)
    return Errand(Duty.CHARGE, None, dock) if dock is not None else Errand()


class Cut(NamedTuple):
    """What was released as a plan was asked for; nothing more is until the plan is there."""

    base: int
    end: int


class Snapshot(NamedTuple):
    """What the planner is asked, and the state that its answer will fit."""

    tasks: Tuple[Task, ...]
    obstacles: Tuple[Obstacle, ...]
    cuts: Dict[str, Cut]

    def fits(self, robots: Mapping[str, ManagedRobot]) -> bool:
        """Is everything that was released still what it was, and nothing more?"""
        return all(robots[name].record.end == cut.end and robots[name].record.first <= cut.base
                   for name, cut in self.cuts.items())

    def plan(self, outcome: Outcome, made_at: float) -> PlanInForce:
        """The plan that an answer is."""
        return PlanInForce(outcome, {name: cut.base for name, cut in self.cuts.items()}, made_at)


def snapshot(robots: Mapping[str, ManagedRobot], errands: Mapping[str, Errand],
             plan: Optional[PlanInForce], now: float) -> Snapshot:
    """Where everybody is and what everybody is to do, as the planner reads it."""
    tasks: List[Task] = []
    obstacles: List[Obstacle] = []
    cuts: Dict[str, Cut] = {}
    for name, robot in robots.items():
        record = robot.record
        errand = errands[name]
        stands = errand.duty is Duty.STAND and record.is_standing
        if not robot.works or stands or (record.place is None and not record.held):
            vertices, edges = robot.blocked()
            if vertices or edges:
                obstacles.append(Obstacle(name, robot.type, vertices, edges))
            continue
        own = plan.plan_of(name) if plan is not None else None
        tasks.append(_task(robot, errand, own, now))
        cuts[name] = Cut(record.left[0] if record.held else record.end, record.end)
    return Snapshot(tuple(tasks), tuple(obstacles), cuts)


def have_moved(robots: Mapping[str, ManagedRobot], obstacles: Sequence[Obstacle]) -> bool:
    """Is one of these obstacles by now where the planner did not know of it?"""
    for obstacle in obstacles:
        vertices, edges = robots[obstacle.name].blocked()
        if not (set(vertices) <= set(obstacle.vertices) and set(edges) <= set(obstacle.edges)):
            return True
    return False


def _task(robot: ManagedRobot, errand: Errand, own: Optional[RobotPlan], now: float) -> Task:
    record, mission = robot.record, errand.mission
    vertex: Optional[int] = None
    mid_edge: Optional[Tuple[int, float]] = None
    begun = 0.0
    held = record.held
    if held:
        begun = record.left[1]
    elif record.place is not None and record.place.vertex is None:
        mid_edge = (record.place.edge,
                    min(max(record.place.fraction, _MID_EDGE), 1.0 - _MID_EDGE))
    elif record.place is not None:
        vertex = record.place.vertex
    destinations: Tuple[int, ...] = ()
    dwells: Tuple[float, ...] = ()
    priority = 0
    if errand.duty is Duty.MISSION and mission is not None:
        destinations, dwells = to_visit(robot, mission, now)
        priority = mission.request.priority
    elif errand.duty is Duty.CHARGE and errand.dock is not None:
        destinations = (errand.dock,)
    return Task(robot.name, robot.type, vertex, held, begun, mid_edge, 0.0, destinations, dwells,
                errand.duty is Duty.CHARGE, _kept(own, record.end), priority)


def _kept(own: Optional[RobotPlan], end: int) -> Optional[Tuple[PlannedDrive, ...]]:
    if own is None or end > own.base + len(own.drives):
        return None
    return own.behind(end)


def to_visit(robot: ManagedRobot, mission: Mission,
             now: float) -> Tuple[Tuple[int, ...], Tuple[float, ...]]:
    """Destinations, and s to stay at each, behind what the robot was given already."""
    graph = robot.record.graph
    ahead = [graph.end_vertex(edge).id for edge in robot.record.ahead]
    first = mission.reached + mission.visits(ahead)
    count = len(mission.request.destinations)
    destinations = mission.request.destinations[first:]
    if not mission.request.dwells:
        return destinations, ()
    dwells = [mission.request.dwell(index) for index in range(first, count)]
    dwells = [dwell if dwell >= 0.0 else UNTIL_RELEASED for dwell in dwells]
    if dwells and first == mission.reached and mission.dwell_until is not None:
        dwells[0] = (UNTIL_RELEASED if math.isinf(mission.dwell_until)
                     else max(mission.dwell_until - now, 0.0))
    return destinations, tuple(dwells)


def goes_until(robot: ManagedRobot, errand: Errand, own: RobotPlan, asked: bool) -> int:
    """Number of the record's edge before which a robot must stop in any case.

    On a mission: at a destination where it stays, and at the last one. Idle, or with a plan that
    does not lead to its destination: where it is, unless somebody asks it to make room.
    """
    record = robot.record
    end = own.base + len(own.drives)
    if errand.duty is Duty.STAND:
        return record.end
    if errand.duty is Duty.CHARGE:
        return end
    if errand.mission is not None:
        stop = _next_stop(record.graph, own.behind(record.done), errand.mission)
        if stop is not None:
            return record.done + stop
    return end if asked else record.end


def _next_stop(graph: Graph, drives: Sequence[PlannedDrive], mission: Mission) -> Optional[int]:
    """How many drives lead to the next destination at which a robot stops; None: not all do."""
    request, index = mission.request, mission.reached
    if mission.dwell_until is not None:
        return 0
    for number, drive in enumerate(drives, 1):
        vertex = graph.end_vertex(drive.edge).id
        while index < len(request.destinations) and request.destinations[index] == vertex:
            index += 1
            if request.dwell(index - 1) or index == len(request.destinations):
                return number
    return None
