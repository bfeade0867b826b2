"""The room that robots hold for their loads.

A robot with a load is a robot of another type (`laden_types`). Its radius may be larger, so
becoming one is like a grant: it needs that no other robot's allocation excludes its own with that
radius.

- From when its next stop takes a load, a robot becomes one that has the room for it, as soon as
  no robot is in its way: mostly long before it is there. So the planner knows, and leads others
  away.
- The step that takes the load does not begin before that.
- What a robot carries, or may carry, counts at once, also by what a person says. If others are too
  near then, the interlocking grants them nothing, as with all evidence.
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
    """Lets each robot count as one of the type that its load needs.

    laden  -- the types of the fleet's robots with each load of the site
    robots -- by name, each of its type without load
    clearance -- m that stays free between any two robots
    """

    def __init__(self, laden: LadenTypes, robots: Mapping[str, ManagedRobot],
                 desk: WorkDesk, geometry: SiteGeometry, clearance: float) -> None:
        self._laden, self._robots, self._desk = laden, robots, desk
        self._geometry, self._clearance = geometry, clearance
        self._own: Dict[str, RobotType] = {name: one.type for name, one in robots.items()}
        self.in_the_way: Dict[str, str] = {}
        """By robot that has no room to take its load, a robot that is too near."""
        for name in robots if laden else ():
            self._become(name, self._at_least(name))

    def follow(self, interlocking: Interlocking) -> List[str]:
        """Lets the robots follow their loads and their next stops. Returns those that changed."""
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
        """Returns what others must leave, so that robots that stand at their stops can take loads.
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
        """Returns whether a robot may not take these types of load yet: it has no room for them."""
        if not self._laden:
            return False
        needed = self._laden.laden(self._own[name], self._desk.load(name).may_be | loads)
        return self._robots[name].type.reach < needed.reach

    def _at_least(self, name: str) -> RobotType:
        """Returns the type of a robot by what it carries, or may carry."""
        return self._laden.laden(self._own[name], self._desk.load(name).may_be)

    def _wanted(self, name: str) -> RobotType:
        carried, taken = self._desk.load(name).may_be, self._desk.to_take(name)
        find = self._laden.laden if carried else self._laden.ready
        return find(self._own[name], carried | taken)

    def _become(self, name: str, kind: RobotType) -> None:
        if kind != self._robots[name].type:
            self._robots[name].become(kind)
