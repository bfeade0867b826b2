"""The room that robots hold for their loads.

A robot with a load has another type (`laden_types`). This type may have a larger radius. So a
change of the type is like a grant: the robot's allocation with the new radius must not exclude the
allocation of any other robot.

- If a robot takes a load at its next stop, it gets a type with room for the load. It gets the type
  as soon as no other robot is in the way, usually long before it reaches the stop. So the planner
  takes the room into account, and leads other robots away.
- The step that takes the load does not begin before the robot has this type.
- A load that a robot carries, or may carry, counts at once, even if only a person says so. If other
  robots are too near then, the interlocking grants them nothing, as after any evidence.
"""
from __future__ import annotations

from typing import AbstractSet, Dict, List, Mapping, Set

from fleet_core.fleet import RobotType
from fleet_core.geometry.site_geometry import SiteGeometry
from fleet_core.interlocking.interlocking import Interlocking
from fleet_core.supervision.laden_types import LadenTypes
from fleet_core.supervision.plan_executor import RoomForLoads
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.work_desk import WorkDesk


class LoadRoom:
    """Gives each robot the type that its load requires.

    laden  -- the types of the fleet's robots with each load of the site
    robots -- by name; at first each has its type without load
    clearance -- m that stays free between any two robots
    """

    def __init__(self, laden: LadenTypes, robots: Mapping[str, ManagedRobot],
                 desk: WorkDesk, geometry: SiteGeometry, clearance: float) -> None:
        self._laden, self._robots, self._desk = laden, robots, desk
        self._geometry, self._clearance = geometry, clearance
        self._own: Dict[str, RobotType] = {name: one.type for name, one in robots.items()}
        self.in_the_way: Dict[str, str] = {}
        """Key: a robot that has no room to take its load; value: a robot that is too near to it."""
        for name in robots if laden else ():
            self._become(name, self._at_least(name))

    def follow(self, interlocking: Interlocking) -> List[str]:
        """Updates the types of the robots. Returns the robots whose type has changed."""
        if not self._laden:
            return []
        self.in_the_way.clear()
        changed: List[str] = []
        for name, robot in self._robots.items():
            wanted, least = self._wanted(name), self._at_least(name)
            if wanted.reach > max(robot.type.reach, least.reach):
                other = interlocking.without_room(robot, wanted)
                if other:
                    self.in_the_way[name] = other
                    wanted = least
            if wanted != robot.type:
                self._become(name, wanted)
                changed.append(name)
        return changed

    def to_be_made(self) -> RoomForLoads:
        """Returns the robots that must leave, and the vertices that must stay free, before robots
        at their stops can take loads.
        """
        robots: Set[str] = set()
        places: Set[int] = set()
        widest = max((kind.reach for kind in self._own.values()), default=0.0)
        for name, other in self.in_the_way.items():
            position = self._robots[name].position
            if position is None or position.vertex is None or (
                    position.vertex != self._desk.next_stop(name)):
                continue
            robots.add(other)
            distance = self._wanted(name).reach + widest + self._clearance
            places.update(near.other for near in self._geometry.exclusions.excluding(
                self._geometry.index[position.vertex], distance))
        ids = self._geometry.vertex_ids
        return RoomForLoads(frozenset(robots), frozenset(
            ids[place] for place in places if place < len(ids)))

    def lacks_room(self, name: str, loads: AbstractSet[str]) -> bool:
        """Returns whether a robot has no room yet to take these types of load."""
        if not self._laden:
            return False
        needed = self._laden.laden(self._own[name], self._desk.load(name).may_be | loads)
        return self._robots[name].type.reach < needed.reach

    def _at_least(self, name: str) -> RobotType:
        """Returns the type that a robot needs for the load that it carries, or may carry."""
        return self._laden.laden(self._own[name], self._desk.load(name).may_be)

    def _wanted(self, name: str) -> RobotType:
        carried, taken = self._desk.load(name).may_be, self._desk.to_take(name)
        find = self._laden.laden if carried else self._laden.ready
        return find(self._own[name], carried | taken)

    def _become(self, name: str, kind: RobotType) -> None:
        if kind != self._robots[name].type:
            self._robots[name].become(kind)
