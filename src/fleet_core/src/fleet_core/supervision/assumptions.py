"""The assumptions of a plan about the fleet, and the check whether they still hold."""
from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import AbstractSet, Dict, FrozenSet, Mapping, NamedTuple, Optional, Tuple

from fleet_core.fleet import RobotType
from fleet_core.geometry.areas import Area
from fleet_core.interlocking.allocation import Allocation, Knowledge
from fleet_core.interlocking.changes import Changes
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.supervision.duties import NO_LIMIT, Duty, Errand, ErrandKey, StationLimit, errand_of
from fleet_core.supervision.missions import Mission
from fleet_core.supervision.robots import ManagedRobot


class PlanRole(Enum):
    """How a plan treats a robot."""

    DRIVING = 'driving'     # it drives on along its granted edges
    STANDING = 'standing'   # it stands, and will follow its plan
    OBSTACLE = 'obstacle'   # it gets no plan, and blocks all places where it may be
    ABSENT = 'absent'       # it is not at the site


class Assumption(NamedTuple):
    """The assumption of a plan about one robot.

    generation -- generation of its route record
    base       -- number of the plan's first edge in the route record
    end        -- the number that follows the last granted edge in the route record
    kind       -- its type, which depends on its load
    places     -- for an obstacle: the vertices, edges and areas where it may be
    errand     -- key of its errand
    reach      -- number of its mission's destinations that the plan includes; None: all
    """

    role: PlanRole
    generation: int
    base: int
    end: int
    kind: RobotType
    places: Tuple[FrozenSet[int], FrozenSet[int], FrozenSet[Area]]
    errand: ErrandKey
    reach: Optional[int] = None


class World(NamedTuple):
    """The present state of all that a plan depends on.

    versions -- a number for each robot, which grows when the robot or its errand changes
    """

    robots: Mapping[str, ManagedRobot]
    errands: Mapping[str, Errand]
    network: RoadNetwork
    versions: Mapping[str, int]


class WorldView:
    """Finds out which robots and errands have changed since the last call of `world`.

    changes -- the changes that the route masters of the robots note
    """

    def __init__(self, robots: Mapping[str, ManagedRobot], changes: Changes) -> None:
        self._robots, self._changes = robots, changes
        self._states: Dict[str, Tuple[object, ...]] = {}
        self._errands: Dict[str, Errand] = {}
        self._versions: Dict[str, int] = {}

    def world(self, serving: Mapping[str, Mission], network: RoadNetwork,
              limits: Mapping[str, StationLimit]) -> World:
        """Returns the present state of all that a plan depends on.

        serving -- the missions that robots serve, by robot
        limits  -- how far each robot may go; a robot without an entry has no limit
        """
        for name, robot in self._robots.items():
            mission, limit = serving.get(name), limits.get(name, NO_LIMIT)
            state = (self._changes.of(name), robot.outage, robot.is_halted, robot.comes_to_rest,
                     robot.dock, limit, None if mission is None else (
                         mission.serial, mission.state, mission.reached, mission.stays_since,
                         mission.is_held, mission.request, mission.changes))
            if state != self._states.get(name):
                self._states[name] = state
                self._errands[name] = errand_of(mission, robot.dock, limit)
                self._versions[name] = self._versions.get(name, 0) + 1
        return World(self._robots, self._errands, network, self._versions)


@dataclass(frozen=True)
class Assumptions:
    """The assumptions of a plan: role and errand of each robot, closed edges, and a seed."""

    robots: Mapping[str, Assumption]
    closed: FrozenSet[int]
    seed: int
    _held: Dict[str, Tuple[int, bool]] = field(default_factory=dict, compare=False, repr=False)
    """The last version of each robot, and whether the assumption about this version held."""

    def misfits(self, world: World) -> AbstractSet[str]:
        """Returns the robots whose assumptions do not hold."""
        for name, version in world.versions.items():
            if self._held.get(name, (0, False))[0] != version:
                self._held[name] = version, self.holds(name, world)
        return {name for name, (_, holds) in self._held.items() if not holds}

    def holds(self, name: str, world: World) -> bool:
        """Returns whether the assumption about one robot holds."""
        before, robot = self.robots.get(name), world.robots[name]
        if before is None:
            return False
        errand, record = world.errands[name], robot.record
        if (before.errand, before.generation, before.kind) != (
                errand.key, record.generation, robot.type):
            return False
        role = _role_of(robot, errand)
        if not {before.role, role}.isdisjoint((PlanRole.OBSTACLE, PlanRole.ABSENT)):
            return before.role is role and all(
                ours == theirs if errand.duty is Duty.STAND else ours <= theirs
                for ours, theirs in zip(_places_of(robot, role), before.places))
        return record.end >= before.end and not self._is_used_up(before, errand)

    @staticmethod
    def _is_used_up(before: Assumption, errand: Errand) -> bool:
        """Returns whether the plan includes at most one of the destinations that are left."""
        return before.reach is not None and errand.mission is not None and (
            errand.mission.reached >= before.reach - 1)


def assumption_of(robot: ManagedRobot, errand: Errand) -> Assumption:
    """Returns the present state of a robot, as an assumption."""
    record, role = robot.record, _role_of(robot, errand)
    return Assumption(role, record.generation, record.begins[0], record.end, robot.type,
                      _places_of(robot, role), errand.key)


def _role_of(robot: ManagedRobot, errand: Errand) -> PlanRole:
    """Returns how a plan is to treat a robot now."""
    record, master = robot.record, robot.master
    if master.allocation.knowledge is not Knowledge.KNOWN:
        return PlanRole.ABSENT
    if not robot.works or errand.duty is Duty.STAND or master.has_lost_places or (
            record.position is None and not record.held):
        return PlanRole.OBSTACLE
    return PlanRole.DRIVING if record.ahead else PlanRole.STANDING


def _places_of(robot: ManagedRobot,
               role: PlanRole) -> Tuple[FrozenSet[int], FrozenSet[int], FrozenSet[Area]]:
    """Returns the vertices, edges and areas where a robot may be; none if it is no obstacle."""
    return _places(robot.master.allocation) if role is PlanRole.OBSTACLE else _NOWHERE


def _places(allocation: Allocation) -> Tuple[FrozenSet[int], FrozenSet[int], FrozenSet[Area]]:
    vertices = () if allocation.vertex is None else (allocation.vertex,)
    return (frozenset(vertices), frozenset(abs(hold.edge) for hold in allocation.holds),
            frozenset(allocation.areas))


_NOWHERE: Tuple[FrozenSet[int], FrozenSet[int], FrozenSet[Area]] = (
    frozenset(), frozenset(), frozenset())
