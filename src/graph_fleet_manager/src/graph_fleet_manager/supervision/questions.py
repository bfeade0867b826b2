"""What the planner is asked, what its answer assumes, and whether the fleet is still as assumed."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Dict, FrozenSet, List, Mapping, NamedTuple, Optional, Tuple

from graph_fleet_manager.geometry.areas import Area
from graph_fleet_manager.interlocking.allocation import Allocation, Knowledge
from graph_fleet_manager.planning.road_network import RoadNetwork
from graph_fleet_manager.planning.tasks import Obstacle, Outcome, PlannedDrive, Task
from graph_fleet_manager.supervision.duties import Duty, Errand, to_visit
from graph_fleet_manager.supervision.plan_in_force import PlanInForce, RobotPlan
from graph_fleet_manager.supervision.robots import ManagedRobot

_MID_EDGE = 1e-6  # the least fraction of an edge at which a robot is between its ends


class Role(Enum):
    """What a plan makes of a robot."""

    DRIVING = 'driving'     # it drives on over what it was granted
    STANDING = 'standing'   # it stands, and goes where its plan leads
    OBSTACLE = 'obstacle'   # it goes nowhere by a plan
    ABSENT = 'absent'       # it is nowhere


class Assumption(NamedTuple):
    """What a plan assumes of one robot.

    generation -- of its route record
    base, end  -- numbers in the record: of the first edge that the plan has, and behind the last
    places     -- of an obstacle: vertices, edges and areas on which it may be
    errand     -- key of what it is to do
    reach      -- destinations of its mission that the plan knows of; None: all
    """

    role: Role
    generation: int
    base: int
    end: int
    places: Tuple[FrozenSet[int], FrozenSet[int], FrozenSet[Area]]
    errand: Tuple[Duty, int, int, int]
    reach: Optional[int] = None


class World(NamedTuple):
    """What a plan depends on, as it is now."""

    robots: Mapping[str, ManagedRobot]
    errands: Mapping[str, Errand]
    network: RoadNetwork


@dataclass(frozen=True)
class Assumptions:
    """What a plan assumes: the role and the duty of each robot, closed edges, and a seed."""

    robots: Mapping[str, Assumption]
    closed: FrozenSet[int]
    seed: int

    def still_useful(self, world: World) -> bool:
        """Is the fleet as assumed, or so that the plan still serves?"""
        return self.closed == world.network.closed and all(
            self.holds(name, world) for name in world.robots)

    def holds(self, name: str, world: World) -> bool:
        """Is a robot as assumed?"""
        before, robot = self.robots.get(name), world.robots[name]
        if before is None:
            return False
        now = _assumed(robot, world.errands[name])
        if before.errand != now.errand or before.generation != now.generation:
            return False
        if before.role in (Role.OBSTACLE, Role.ABSENT) or now.role in (Role.OBSTACLE, Role.ABSENT):
            return before.role is now.role and all(
                ours == theirs if now.errand[0] is Duty.STAND else ours <= theirs
                for ours, theirs in zip(now.places, before.places))
        return robot.record.end >= before.end and not self._is_used_up(before, world.errands[name])

    @staticmethod
    def _is_used_up(before: Assumption, errand: Errand) -> bool:
        """Does a mission go on beyond the last destination but one that the plan knows of?"""
        return before.reach is not None and errand.mission is not None and (
            errand.mission.reached >= before.reach - 1)


@dataclass(frozen=True)
class Question:
    """What the planner is asked, and what its answer will assume."""

    tasks: Tuple[Task, ...]
    obstacles: Tuple[Obstacle, ...]
    assumptions: Assumptions
    asked_at: float

    def plan(self, outcome: Outcome, world: World) -> Optional[PlanInForce]:
        """The plan that an answer is; None where it does not serve any more."""
        if not self.assumptions.still_useful(world):
            return None
        planned = {task.name for task in self.tasks}
        bases = {name: known.base for name, known in self.assumptions.robots.items()
                 if name in planned}
        for name, base in bases.items():
            record = world.robots[name].record
            end = self.assumptions.robots[name].end
            drives = outcome.drives.get(name, ())[end - base:record.end - base]
            if record.first > base or tuple(d.edge for d in drives) != record.part(
                    end, record.end):
                return None  # it was granted something else meanwhile, or more than the plan has
        return PlanInForce(outcome, bases, self.asked_at, self.assumptions)


def question_of(world: World, plan: Optional[PlanInForce], seed: int, now: float) -> Question:
    """Where all robots are and what each is to do, as the planner reads it."""
    tasks: List[Task] = []
    obstacles: List[Obstacle] = []
    assumed: Dict[str, Assumption] = {}
    for name, robot in world.robots.items():
        errand = world.errands[name]
        assumption = _assumed(robot, errand)
        if assumption.role is Role.OBSTACLE:
            vertices, edges, areas = assumption.places
            obstacles.append(Obstacle(name, robot.type, tuple(sorted(vertices)),
                                      tuple(sorted(edges)), tuple(areas)))
        elif assumption.role is not Role.ABSENT:
            own = plan.plan_of(name) if plan is not None else None
            task, reach = _task(robot, errand, own, now)
            tasks.append(task)
            assumption = assumption._replace(reach=reach)
        assumed[name] = assumption
    return Question(tuple(tasks), tuple(obstacles),
                    Assumptions(assumed, world.network.closed, seed), now)


def _assumed(robot: ManagedRobot, errand: Errand) -> Assumption:
    record, allocation = robot.record, robot.client.allocation
    stands = errand.duty is Duty.STAND
    if allocation.knowledge is not Knowledge.KNOWN:
        role = Role.ABSENT
    elif not robot.works or stands or (record.position is None and not record.held):
        role = Role.OBSTACLE
    else:
        role = Role.DRIVING if record.ahead else Role.STANDING
    places = _places(allocation) if role is Role.OBSTACLE else _NOWHERE
    base = record.cleared[0] if record.held else record.end
    return Assumption(role, record.generation, base, record.end, places, errand.key)


def _places(allocation: Allocation) -> Tuple[FrozenSet[int], FrozenSet[int], FrozenSet[Area]]:
    vertices = () if allocation.vertex is None else (allocation.vertex,)
    return (frozenset(vertices), frozenset(abs(hold.edge) for hold in allocation.holds),
            frozenset(allocation.areas))


_NOWHERE: Tuple[FrozenSet[int], FrozenSet[int], FrozenSet[Area]] = (
    frozenset(), frozenset(), frozenset())


def _task(robot: ManagedRobot, errand: Errand, own: Optional[RobotPlan],
          now: float) -> Tuple[Task, Optional[int]]:
    """What the planner is asked for a robot, and how many destinations of its mission that has."""
    record, mission = robot.record, errand.mission
    vertex: Optional[int] = None
    mid_edge: Optional[Tuple[int, float]] = None
    begun = 0.0
    held, position = record.held, record.position
    if held:
        begun = record.cleared[1]
    elif position is not None and position.vertex is None:
        mid_edge = position.edge, min(max(position.fraction, _MID_EDGE), 1.0 - _MID_EDGE)
    elif position is not None:
        vertex = position.vertex
    destinations: Tuple[int, ...] = ()
    dwells: Tuple[float, ...] = ()
    priority = 0
    reach: Optional[int] = None
    if errand.duty is Duty.MISSION and mission is not None:
        destinations, dwells, reach = to_visit(robot, mission, now)
        priority = mission.request.priority
    elif errand.duty is Duty.CHARGE and errand.dock is not None:
        destinations = (errand.dock,)
    return Task(robot.name, robot.type, vertex, held, begun, mid_edge, 0.0, destinations, dwells,
                errand.duty is Duty.CHARGE, _kept(own, record.end), priority), reach


def _kept(own: Optional[RobotPlan], end: int) -> Optional[Tuple[PlannedDrive, ...]]:
    if own is None or end > own.base + len(own.drives):
        return None
    return own.behind(end)
