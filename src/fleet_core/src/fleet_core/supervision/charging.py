"""Charging: which robots are to charge, until when, and to which charger they may go.

    | a robot charges because               | until its charge is            | its missions |
    |---------------------------------------|--------------------------------|--------------|
    | its charge is below `charge_below`    | `leave_above`                  | wait         |
    | a waiting mission needs more charge   | `leave_above`                  | wait         |
    | it was asked to charge                | the charge that was asked for  | wait         |
    | it has nothing to do, and its charge  | `leave_above`; a robot that    | begin        |
    | is below `idle_below`                 | must charge may take its turn  |              |

The thresholds are those of `RobotSettings`. The rules of the turns are those of
`fleet_core.work.chargers`. The claims show which robots are in a charger. A charger is out of order
while robots cannot get there, because edges are closed or devices do not work.
"""
from __future__ import annotations

import math
from collections import Counter
from enum import Enum
from typing import (
    Callable,
    Collection,
    Dict,
    FrozenSet,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Set,
    Tuple,
)

from fleet_core.interlocking.claims import Claims
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.supervision.assignment import time_to
from fleet_core.supervision.battery import MUTE
from fleet_core.supervision.device_desk import DeviceView
from fleet_core.supervision.duties import follows
from fleet_core.supervision.mission_book import MissionBook
from fleet_core.supervision.missions import Mission
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.station_room import Occupancy
from fleet_core.work.chargers import Candidate, Charger, Occupied, turns_of
from fleet_core.work.queues import Others
from route_protocol.devices import DeviceMode

_MUTE = f'a report of its battery, which has not come for {MUTE:.0f} s'
_BROKEN = (DeviceMode.OFFLINE, DeviceMode.UNKNOWN)


class _Need(Enum):
    """Whether a robot has to charge."""

    NONE = 'no'
    TOP_UP = 'it has nothing to do'
    MUST = 'it gets no mission before'


class _Stay(NamedTuple):
    """A robot that stays in a charger and is no candidate for a turn.

    place -- the vertex where it is; None: it is between vertices
    """

    robot: str
    charger: str
    place: Optional[int]


class ChargerDesk:
    """Gives robots their turns at chargers. The other robots wait.

    waiting -- for each robot that must charge and has no turn: what it waits for, in words
    leaving -- robots without work in a full charger while another robot has a turn there
    view    -- returns what is known of a device now
    """

    def __init__(self, chargers: Mapping[str, Charger], claims: Claims, book: MissionBook,
                 robots: Mapping[str, ManagedRobot],
                 view: Callable[[str, float], DeviceView]) -> None:
        self.waiting: Dict[str, str] = {}
        self.leaving: FrozenSet[str] = frozenset()
        self._chargers, self._claims, self._book, self._robots = chargers, claims, book, robots
        self._view = view
        self.at: Mapping[int, Charger] = {
            place: one for one in chargers.values() for place in one.places}
        """By place, the charger to which it belongs."""

    @property
    def reserved(self) -> FrozenSet[int]:
        """The places of chargers whose capacity is lower than the number of their places.

        A robot that is parked at one of these places would keep other robots from the other places.
        """
        return frozenset(place for one in self._chargers.values()
                         if one.capacity < len(one.places) for place in one.places)

    def update(self, short: Collection[str], network: RoadNetwork, now: float) -> List[str]:
        """Checks all batteries. Returns the robots whose state is to be stored.

        short -- robots whose charge is too low for a mission that waits for them
        """
        before = {name: _stored(robot) for name, robot in self._robots.items()}
        self.waiting = {}
        serving = self._book.serving
        candidates: Dict[str, Candidate] = {}
        for name, robot in self._robots.items():
            if robot.charge_until and robot.battery.charge >= robot.charge_until:
                robot.charge_until = 0.0
            if name not in serving:
                candidate = self._candidate(robot, name in short, network, now)
                if candidate is not None:
                    candidates[name] = candidate
        if candidates or any(robot.dock is not None for robot in self._robots.values()):
            self._give_turns(candidates, serving, network, now)
        return [name for name, robot in self._robots.items() if before[name] != _stored(robot)]

    def _candidate(self, robot: ManagedRobot, is_short: bool, network: RoadNetwork,
                   now: float) -> Optional[Candidate]:
        """Returns a robot as a candidate for a turn; None: it need not charge, or cannot charge.

        A robot that stands at its charger keeps its turn during an outage. A robot that reports,
        but not its charge, loses its turn, because it might stay there for ever.
        """
        if robot.works and robot.battery.is_mute(robot.liveness, now):
            if _has_to(robot, is_short) or (robot.battery.is_below_leaving
                                            and robot.stands_at(docks_of(robot, network))):
                self.waiting[robot.name] = _MUTE
            return None
        need = _need_of(robot, is_short)
        if need is _Need.NONE or not (robot.works or self._has_arrived(robot)):
            return None
        places = self._places(robot, network, now)
        charger = self.at[places[0]] if places else None
        return Candidate(robot.name, places, _charge(robot), need is _Need.MUST, robot.dock,
                         charger is not None and charger.name in self._claims.of(robot.name))

    @staticmethod
    def _has_arrived(robot: ManagedRobot) -> bool:
        return robot.dock is not None and robot.stands_at((robot.dock,))

    def _places(self, robot: ManagedRobot, network: RoadNetwork, now: float) -> Tuple[int, ...]:
        """Returns the docks at which a robot could charge now, the nearest one first."""
        docks = docks_of(robot, network)
        if robot.dock in docks and self._has_arrived(robot):
            return (robot.dock,)
        times = {dock: time_to(dock, robot, network) for dock in docks}
        return tuple(sorted((dock for dock in docks if times[dock] < math.inf
                             and not self._broken_at(dock, network, now)),
                            key=lambda dock: times[dock]))

    def _broken_at(self, dock: int, network: RoadNetwork, now: float) -> Set[str]:
        """Returns the names of broken devices that block the edges into a dock.

        Empty: at least one edge is not blocked.
        """
        needs, graph = self._claims.needs, network.graph
        found: Set[str] = set()
        for edge in graph.edges_from(dock):
            broken = {name for name in needs.of_edge(-edge) if needs.resources[name].has_device
                      and self._view(name, now).mode in _BROKEN}
            if not broken:
                return set()
            found |= broken
        return found

    def _give_turns(self, candidates: Mapping[str, Candidate], serving: Mapping[str, Mission],
                    network: RoadNetwork, now: float) -> None:
        stays = list(self._stays(candidates, serving))
        turns = turns_of(self._chargers.values(), candidates.values(), Occupied(
            {one.place for one in stays if one.place is not None},
            Counter(one.charger for one in stays), frozenset(self._going(serving).values())))
        for name, robot in self._robots.items():
            robot.dock = turns.get(name)
            robot.tops_up = robot.dock is not None and not candidates[name].needs
        for name, one in candidates.items():
            if one.needs and name not in turns:
                self.waiting[name] = self._why_none(one, turns, stays, network, now)
        self.leaving = frozenset(self._in_the_way(turns, stays))

    def _stays(self, candidates: Collection[str],
               serving: Mapping[str, Mission]) -> Iterator[_Stay]:
        """Yields the robots that claim chargers, are no candidates, and do not make room."""
        for name in self._claims.robots:
            for charger in self._claims.of(name) & self._chargers.keys():
                robot = self._robots.get(name)
                if name not in candidates and (robot is None or not robot.works or _is_to_stay(
                        serving.get(name), self._chargers[charger])):
                    yield _Stay(name, charger, None if robot is None else robot.record.last_vertex)

    def _going(self, serving: Mapping[str, Mission]) -> Dict[str, int]:
        """Returns, by robot, the place of the charger that is the mission's next destination."""
        return {name: mission.left[0] for name, mission in serving.items()
                if mission.left and mission.left[0] in self.at and follows(mission)}

    def occupancies(self) -> Dict[str, Occupancy]:
        """Returns the robots that take the places of chargers, by the charger's name.

        A robot that only tops up takes no place, because it gives way to missions. A robot whose
        mission has no stay at the dock takes no place either: it makes room before the next robot
        comes.
        """
        serving = self._book.serving
        going = self._going(serving)
        stopping = {name: place for name, place in going.items()
                    if serving[name].request.dwell(serving[name].reached)}
        turns = {name: robot.dock for name, robot in self._robots.items()
                 if robot.dock is not None}
        staying = [stay for stay in self._stays(turns, serving)
                   if stay.robot not in going]
        staying += [_Stay(name, self.at[dock].name, dock) for name, dock in turns.items()
                    if dock in self.at and not self._robots[name].tops_up]
        return {name: self._occupancy(
            {robot: (place,) for robot, place in stopping.items() if self.at[place].name == name},
            [stay for stay in staying if stay.charger == name]) for name in self._chargers}

    def _occupancy(self, waiters: Mapping[str, Tuple[int, ...]],
                   inside: Sequence[_Stay]) -> Occupancy:
        """Returns the robots that go to a charger for a mission, and the robots that stay in it."""
        kept = frozenset(stay.place for stay in inside if stay.place is not None)
        robots = (*waiters, *(stay.robot for stay in inside))
        return Occupancy(robots, tuple(waiters.values()), Others(len(inside), kept, kept),
                         doing=tuple(map(self._doing, robots)))

    def _doing(self, name: str) -> str:
        """Returns what a robot does at a charger, in words that follow the robot's name."""
        robot, mission = self._robots.get(name), self._book.of_robot(name)
        if robot is None or robot.outage is not None:
            return 'which is not in service'
        if mission is not None:
            return f'which serves mission {mission.request.id}'
        return f'which charges until {100.0 * (robot.charge_until or robot.battery.full):.0f} %'

    def _in_the_way(self, turns: Mapping[str, int], stays: List[_Stay]) -> Iterator[str]:
        """Yields robots without work that must leave their full charger, because another robot has
        a turn there and cannot claim the charger yet.
        """
        staying = {one.robot for one in stays}
        for name in {self.at[place].name for place in turns.values()}:
            charger, inside = self._chargers[name], self._claims.holders(name)
            if charger.capacity == len(charger.places) or len(inside) < charger.capacity:
                continue  # the plan itself moves a robot away from a place that another one needs
            going = {robot for robot, place in turns.items() if place in charger.places}
            if going - set(inside):
                yield from (one for one in inside if one not in going | staying)

    def _why_none(self, one: Candidate, turns: Mapping[str, int], stays: List[_Stay],
                  network: RoadNetwork, now: float) -> str:
        """Returns, in words, what a robot waits for if it must charge but has no turn."""
        robot = self._robots[one.robot]
        docks = docks_of(robot, network)
        if not docks:
            return 'a charger: the fleet file and the graph have no dock for its type'
        if not one.places:
            broken = {name for dock in docks for name in self._broken_at(dock, network, now)}
            if broken:
                device = self._claims.needs.resources[min(broken)]
                return f'a charger: the {device} on the way there does not work'
            return 'a charger: it can reach none'
        holders = {place: name for name, place in turns.items()}
        found: List[str] = []
        for charger in dict.fromkeys(self.at[place] for place in one.places):
            names = [*(holders[place] for place in charger.places if place in holders),
                     *(stay.robot for stay in stays if stay.charger == charger.name)]
            found.append(f'{charger.name} ({", ".join(names)})')
        return f'a charger: {", ".join(found)}'


def _is_to_stay(mission: Optional[Mission], charger: Charger) -> bool:
    """Returns whether a robot without outage stays in a charger for its mission."""
    return mission is not None and (
        not follows(mission) or mission.dwell_until is not None
        or bool(mission.left) and mission.left[0] in charger.places)


def _stored(robot: ManagedRobot) -> Tuple[Optional[int], bool, float]:
    return robot.dock, robot.tops_up, robot.charge_until


def _need_of(robot: ManagedRobot, is_short: bool) -> _Need:
    if _has_to(robot, is_short):
        return _Need.MUST
    if robot.dock is not None and not robot.battery.may_leave:
        return _Need.TOP_UP if robot.tops_up else _Need.MUST
    return _Need.TOP_UP if robot.battery.is_below_idle else _Need.NONE


def _has_to(robot: ManagedRobot, is_short: bool) -> bool:
    """Returns whether a robot has to begin to charge."""
    battery = robot.battery
    return bool(robot.charge_until) or battery.is_low or is_short and battery.is_below_leaving


def _charge(robot: ManagedRobot) -> float:
    charge = robot.battery.charge
    return math.inf if math.isnan(charge) else charge


def docks_of(robot: ManagedRobot, network: RoadNetwork) -> List[int]:
    """Returns the docks at which a robot may charge."""
    return sorted(dock for dock in robot.type.docks or ()
                  if dock in network.index and network.graph.vertices[dock].dock)
