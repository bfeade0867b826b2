"""Questions to the planner, and the assumptions of its answers."""
from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Dict, List, Mapping, Optional, Tuple

from fleet_core.planning.tasks import Obstacle, PlannedDrive, PlanningOutcome, Task
from fleet_core.supervision.assumptions import (
    Assumption,
    Assumptions,
    PlanRole,
    World,
    assumption_of,
)
from fleet_core.supervision.duties import Duty, Errand, to_visit
from fleet_core.supervision.plan_check import fault_of
from fleet_core.supervision.plan_in_force import PlanInForce
from fleet_core.supervision.robot_plan import RobotPlan
from fleet_core.supervision.robots import ManagedRobot
from trajectory_graph import Graph

_MID_EDGE = 1e-6  # least fraction of an edge between a robot on it and either end


@dataclass(frozen=True)
class Question:
    """A question to the planner, and the assumptions of the answer.

    ends -- for each robot, the number in its record of the first edge that the planner may still
            change; grants of earlier edges do not make the answer useless
    """

    tasks: Tuple[Task, ...]
    obstacles: Tuple[Obstacle, ...]
    assumptions: Assumptions
    asked_at: float
    ends: Mapping[str, int]

    def plan(self, outcome: PlanningOutcome, world: World) -> Optional[PlanInForce]:
        """Returns the plan in an answer; None: since the question, a robot was granted edges that
        do not fit the plan.

        If a robot's errand has changed since the question, the plan still serves all other robots.
        """
        planned = {task.name for task in self.tasks}
        bases = {name: known.base for name, known in self.assumptions.robots.items()
                 if name in planned}
        for name, base in bases.items():
            record = world.robots[name].record
            end = self.assumptions.robots[name].end
            drives = outcome.drives.get(name, ())[end - base:record.end - base]
            if tuple(d.edge for d in drives) != record.part(end, record.end):
                return None  # it was granted other edges since, or more than the plan has
        plan = PlanInForce(outcome, bases, self.asked_at, self.assumptions)
        return plan if self._is_in_turn(plan, world) else None

    def fault_of(self, outcome: PlanningOutcome, graph: Graph) -> str:
        """Returns the first fault of an answer; empty: none.

        The answer may still have faults that this check does not find.
        """
        return fault_of(outcome, self.tasks, graph)

    def _is_in_turn(self, plan: PlanInForce, world: World) -> bool:
        """Returns whether the plan's order allows all edges granted since the question."""
        records = {name: robot.record for name, robot in world.robots.items()}
        return not any(plan.in_the_way(name, number - own.base, records)
                       for name, own in plan.plans.items()
                       for number in range(self.assumptions.robots[name].end, records[name].end))


def question_of(world: World, plan: Optional[PlanInForce], seed: int, now: float,
                foreseen: Mapping[str, Tuple[int, ...]] = MappingProxyType({})) -> Question:
    """Returns the places and errands of all robots, as a question to the planner.

    plan     -- the plan that the planner is to keep as far as it can; None: there is none
    foreseen -- by robot, the edges that count as released although they are not granted yet
    """
    tasks: List[Task] = []
    ends: Dict[str, int] = {}
    obstacles: List[Obstacle] = []
    assumed: Dict[str, Assumption] = {}
    for name, robot in world.robots.items():
        errand = world.errands[name]
        assumption = assumption_of(robot, errand)
        if assumption.role is PlanRole.OBSTACLE:
            vertices, edges, areas = assumption.places
            obstacles.append(Obstacle(name, robot.type, tuple(sorted(vertices)),
                                      tuple(sorted(edges)), tuple(areas)))
        elif assumption.role is not PlanRole.ABSENT:
            own = _plan_of(robot, plan)
            further = foreseen.get(name, ())
            ends[name] = robot.record.end + len(further)
            task, reach = _task(robot, errand, own, now, further)
            tasks.append(task)
            assumption = assumption._replace(reach=reach)
        assumed[name] = assumption
    return Question(tuple(tasks), tuple(obstacles),
                    Assumptions(assumed, world.network.closed, seed), now, ends)


def _plan_of(robot: ManagedRobot, plan: Optional[PlanInForce]) -> Optional[RobotPlan]:
    """Returns the plan of a robot that the planner is to keep; None: it has none.

    If the plan was made for another type of the robot, because of another load, it is not kept: its
    path may pass other robots too closely.
    """
    assumed = None if plan is None else plan.assumptions.robots.get(robot.name)
    if plan is None or assumed is None or assumed.kind != robot.type:
        return None
    return plan.plan_of(robot.name)


def _task(robot: ManagedRobot, errand: Errand, own: Optional[RobotPlan], now: float,
          further: Tuple[int, ...]) -> Tuple[Task, Optional[int]]:
    """Returns the planner's task for a robot, and how many destinations of its mission the task
    has.

    further -- edges after the granted ones that also count as released
    """
    record, mission = robot.record, errand.mission
    vertex: Optional[int] = None
    mid_edge: Optional[Tuple[int, float]] = None
    begun = 0.0
    held, position = record.held, record.position
    if held:
        begun = record.begins[1]
    elif position is not None and position.vertex is None:
        mid_edge = position.edge, min(max(position.fraction, _MID_EDGE), 1.0 - _MID_EDGE)
    elif position is not None:
        vertex = position.vertex
    destinations: Tuple[int, ...] = ()
    dwells: Tuple[float, ...] = ()
    priority = 0
    reach: Optional[int] = None
    if errand.duty is Duty.MISSION and mission is not None:
        destinations, dwells, reach = to_visit((*record.ahead, *further), record.graph, mission,
                                               now, errand.limit.reach)
        priority = mission.request.priority
    elif errand.place is not None:
        destinations = (errand.place,)
    return Task(robot.name, robot.type, vertex, (*held, *further), begun, mid_edge, 0.0,
                destinations, dwells, errand.stays,
                _kept(own, record.end + len(further)), priority), reach


def _kept(own: Optional[RobotPlan], end: int) -> Optional[Tuple[PlannedDrive, ...]]:
    if own is None or end > own.base + len(own.drives):
        return None
    return own.behind(end)
