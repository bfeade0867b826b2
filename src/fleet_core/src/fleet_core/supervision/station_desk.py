"""The station desk: decides which robots may go to stations now, and where the others wait.

The rules are those of `fleet_core.work.queues`. This module applies them to missions, robots and
claims, and tells the planning how far each robot may go.
"""
from __future__ import annotations

from typing import AbstractSet, Dict, FrozenSet, List, Mapping, NamedTuple, Optional, Set, Tuple

from fleet_core.interlocking.claims import Claims
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.supervision.assignment import time_to
from fleet_core.supervision.duties import NO_LIMIT, WINDOW, StationLimit, follows
from fleet_core.supervision.mission_book import MissionBook
from fleet_core.supervision.missions import Mission
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.station_room import Occupancy, StationRoom, places_for
from fleet_core.supervision.work_desk import WorkDesk
from fleet_core.work.chargers import Charger
from fleet_core.work.queues import EMPTY_QUEUE, Others, Queue, Waiter, advanced
from fleet_core.work.stations import Station, StationKind


class QueueStanding(NamedTuple):
    """The position of a robot in the queue of a station.

    ahead -- number of robots that go before it
    place -- its queue place; None: it waits where it is
    """

    station: Station
    ahead: List[str]
    place: Optional[int]


class QueuePlace(NamedTuple):
    """A place at which robots wait for a station.

    robot    -- the robot to which it is given; empty: it is free
    is_there -- this robot stands there; False: it is on its way
    """

    vertex: int
    robot: str = ''
    is_there: bool = False


class StationDesk:
    """The queues of all stations that robots must claim.

    stations -- by name; stations that robots need not claim are left out
    desk     -- the work desk, which sends a mission to another place of a group
    """

    def __init__(self, stations: Mapping[str, Station], claims: Claims, book: MissionBook,
                 robots: Mapping[str, ManagedRobot], desk: WorkDesk) -> None:
        self._claims, self._book, self._robots, self._desk = claims, book, robots, desk
        self._stations = {name: one for name, one in stations.items()
                          if name in claims.needs.resources}
        self._at = {place: one for one in self._stations.values() for place in one.places}
        self._queues: Dict[str, Queue] = {}
        self.limits: Dict[str, StationLimit] = {}
        """By robot, how far it may go; robots without an entry may go as far as they want."""

    @property
    def reserved(self) -> FrozenSet[int]:
        """The places of stations and queues."""
        return frozenset(place for one in self._stations.values()
                         for place in (*one.places, *one.queue))

    def may_go_to(self, name: str, place: int) -> bool:
        """Returns whether the queues of stations let a robot go to a place now."""
        station = self._at.get(place)
        return station is None or self._queue_of(station).turns.get(name) == place

    def standing_of(self, name: str) -> Optional[QueueStanding]:
        """Returns the position of a robot in its queue; None: it waits in no queue."""
        for station in self._stations.values():
            queue = self._queue_of(station)
            if name in queue.waits:
                before = [*queue.turns, *queue.waits]
                return QueueStanding(station, before[:before.index(name)], queue.waits[name])
        return None

    def places_of(self, name: str) -> Tuple[bool, Tuple[QueuePlace, ...]]:
        """Returns whether any place of a resource will do, and its queue places in order.

        For a resource that is not a station: False, and no queue places.
        """
        station = self._stations.get(name)
        if station is None:
            return False, ()
        waits = self._queue_of(station).waits
        robots = {place: robot for robot, place in waits.items()}
        return station.kind is StationKind.GROUP, tuple(
            QueuePlace(place, robot, bool(robot)
                       and self._robots[robot].record.last_vertex == place)
            for place in station.queue for robot in (robots.get(place, ''),))

    def inside(self, station: str) -> List[str]:
        """Returns the names of the robots that claim a station."""
        return self._claims.holders(station)

    def room(self, at: Mapping[int, Charger], chargers: Mapping[str, Occupancy]) -> StationRoom:
        """Returns the stations and chargers to which a further robot may be sent now.

        at       -- by place, the charger to which it belongs
        chargers -- the robots that take the places of each charger, by its name
        """
        going = self._going()
        return StationRoom({**at, **self._at}, self._desk.choices, {**chargers, **{
            name: self._occupancy(station, going) for name, station in self._stations.items()}})

    def _occupancy(self, station: Station, going: Mapping[str, Mission]) -> Occupancy:
        waiters = {name: mission for name, mission in going.items()
                   if self._at.get(mission.left[0]) is station}
        staying = [robot for name, robot in self._robots.items() if name not in waiters
                   and self._is_at(robot, station) and not self._makes_room(robot, going)]
        kept = frozenset(robot.record.last_vertex for robot in staying
                         if robot.record.last_vertex is not None)
        inside = sum(station.name in self._claims.of(robot.name) for robot in staying)
        waits = self._queue_of(station).waits
        return Occupancy(
            (*waiters, *(robot.name for robot in staying)),
            tuple(places_for(mission, station, self._desk.choices(mission))
                  for mission in waiters.values()), Others(inside, kept, kept),
            frozenset(self._claims.holders(station.name) if waits else ()))

    def _is_at(self, robot: ManagedRobot, station: Station) -> bool:
        return station.name in self._claims.of(robot.name) or (
            robot.record.last_vertex in station.queue)

    def _queue_of(self, station: Station) -> Queue:
        return self._queues.get(station.name, EMPTY_QUEUE)

    # -- changes ----------------------------------------------------------------------------------

    def advance(self, network: RoadNetwork, leaving: AbstractSet[str] = frozenset()) -> None:
        """Follows missions, robots and claims. Chooses among the places of groups.

        leaving -- robots without work that are to leave, because other robots need their places
        """
        going = self._going() if self._stations or leaving else {}
        in_the_way = {*leaving, *self._advance(going, network)}
        self.limits = {name: limit for name in (self._robots if going or in_the_way else ())
                       for limit in (self._limit(name, going.get(name), name in in_the_way),)
                       if limit != NO_LIMIT}

    def _advance(self, going: Mapping[str, Mission], network: RoadNetwork) -> Set[str]:
        """Advances the queues. Returns the robots that are to leave stations for other robots."""
        leaving: Set[str] = set()
        for station in self._stations.values():
            waiters = [self._waiter(name, mission, station, network)
                       for name, mission in going.items()
                       if self._at.get(mission.left[0]) is station]
            if not waiters:
                self._queues.pop(station.name, None)
                continue
            others = self._others(station, {one.robot for one in waiters}, going)
            queue = advanced(self._queue_of(station), station, waiters, others)
            self._queues[station.name] = queue
            for name, place in queue.turns.items():
                if going[name].left[0] != place:
                    self._desk.choose(going[name], place)
            if queue.waits:
                leaving.update(name for name in self._claims.holders(station.name)
                               if name not in queue.turns)
        return leaving

    def _going(self) -> Dict[str, Mission]:
        """Returns the missions whose robots go on to their next stops, by robot."""
        return {name: mission for name, mission in self._book.serving.items()
                if mission.left and follows(mission) and self._robots[name].outage is None}

    def _waiter(self, name: str, mission: Mission, station: Station,
                network: RoadNetwork) -> Waiter:
        robot, places = self._robots[name], places_for(mission, station,
                                                       self._desk.choices(mission))
        if len(places) > 1:
            places = tuple(sorted(places, key=lambda one: time_to(one, robot, network)))
        return Waiter(name, places, (-mission.request.priority, mission.serial),
                      robot.record.last_vertex, station.name in self._claims.of(name))

    def _others(self, station: Station, waiters: AbstractSet[str],
                going: Mapping[str, Mission]) -> Others:
        inside = [name for name in self._claims.holders(station.name) if name not in waiters]
        at: Set[int] = set()
        kept: Set[int] = set()
        for name, robot in self._robots.items():
            vertex = robot.record.last_vertex
            if name in waiters or vertex not in (*station.places, *station.queue):
                continue
            at.add(vertex)
            if not self._makes_room(robot, going):
                kept.add(vertex)
        return Others(len(inside), at, kept)

    def _makes_room(self, robot: ManagedRobot, going: Mapping[str, Mission]) -> bool:
        """Returns whether a robot will leave its place if another robot needs the place."""
        if robot.outage is not None:
            return False
        mission = going.get(robot.name)
        if mission is not None:
            return mission.dwell_until is None
        return self._book.of_robot(robot.name) is None and robot.dock is None

    def _limit(self, name: str, mission: Optional[Mission], is_in_the_way: bool) -> StationLimit:
        robot = self._robots[name]
        is_free = robot.outage is None and self._book.of_robot(name) is None and robot.dock is None
        if mission is None:
            return StationLimit(leaves=is_in_the_way and is_free)
        reach = self._reach(name, mission)
        if reach != mission.reached:
            return StationLimit(reach)
        place = self._queue_of(self._at[mission.left[0]]).waits.get(name)
        is_there = place is not None and robot.record.last_vertex == place
        return StationLimit(reach, True, place, is_there, is_in_the_way and place is None)

    def _reach(self, name: str, mission: Mission) -> Optional[int]:
        """Returns how many destinations of a mission come before the next station for which its
        robot has no turn.

        None: none of the next destinations is at such a station.
        """
        first = mission.reached
        some = mission.request.destinations[first:first + WINDOW]
        for number, place in enumerate(some, first):
            if place in self._at and not (number == first and self.may_go_to(name, place)):
                return number
        return None
