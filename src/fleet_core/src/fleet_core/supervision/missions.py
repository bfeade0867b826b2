"""Missions: requests, the rules for refusing them, and the progress of each mission."""
from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Dict, FrozenSet, Iterable, Mapping, Optional, Tuple

from fleet_core.fleet import RobotType
from fleet_core.supervision.hindrances import Hindrance
from fleet_core.work.dependencies import Dependency
from fleet_core.work.rules import StepDecision
from fleet_core.work.stops import WorkStop, WrongStops, check_stops, dwells_of
from trajectory_graph import Graph

MOST_DESTINATIONS = 1000
LONGEST_DWELL = 1e6  # s; a longer dwell is a mistake


class MissionState(IntEnum):
    """The state of a mission, as in itrci_nav_msgs/MissionStatus."""

    PENDING = 0
    ACTIVE = 1
    SUCCEEDED = 2
    FAILED = 3
    REFUSED = 4
    CANCELLED = 5
    PAUSED = 6
    CANCELLING = 7     # it is ending: its steps end, or its load is brought away
    NEEDS_PERSON = 8   # a step asks, or its load is not where it should be
    BLOCKED = 9        # it waits for other missions
    PLANNED = 10       # it waits for its earliest time
    EXPIRED = 11       # its deadline passed before it began

    @property
    def is_open(self) -> bool:
        """Whether the mission has not ended."""
        return self not in (MissionState.SUCCEEDED, MissionState.FAILED, MissionState.REFUSED,
                            MissionState.CANCELLED, MissionState.EXPIRED)


def short_name(serial: int) -> str:
    """Returns the name of a mission that people use; '-' for a request that was not accepted."""
    return f'M{serial}' if serial else '-'


class DeadlineState(IntEnum):
    """Whether a mission will be done by its deadline, as in itrci_nav_msgs/MissionStatus."""

    NONE = 0      # it has no deadline
    AHEAD = 1     # it will be done in time, as far as is known
    AT_RISK = 2   # it will be late, or its deadline is near
    MISSED = 3    # the deadline passed before it was done


class CommandKind(IntEnum):
    """A command for a mission, as in itrci_nav_msgs/MissionCommand."""

    CANCEL = 0
    PAUSE = 1
    RESUME = 2
    RELEASE = 3
    MODIFY = 4
    ANSWER = 5   # the answer to a step that asks


class CommandCode(IntEnum):
    """The result of a command in a status, as in itrci_nav_msgs/MissionStatus."""

    NONE = 0
    NOT_DONE = 1
    NOT_STORED = 2


@dataclass(frozen=True)
class Request:
    """A request for a mission: visit these vertices in order.

    robot_type -- name of the type that must serve it; empty: any type
    robot      -- the robot that must serve it; empty: the robot in the best place
    priority   -- the mission with the higher priority is served first
    dwells     -- s to stay at each destination; negative: until released; empty: no stays
    stamp      -- time (s) at which it was sent; 0: the sender gave none
    requested_by -- person or program, for the records; empty: the sender gave none
    stops      -- the destinations with their steps; empty: the mission has no steps
    on_cancel  -- stops that the robot may make after a cancellation
    after      -- missions that have not ended, and must end before it begins
    template   -- name of the template from which its stops were made; empty: none
    arguments  -- the arguments of the template, by parameter
    earliest   -- s since 1970 before which it does not begin; 0: it begins at once
    deadline   -- s since 1970 by which it is to be done; 0: there is none

    Each attribute is a part of the request, as it is stored.
    """

    id: int
    destinations: Tuple[int, ...]
    robot_type: str = ''
    robot: str = ''
    priority: int = 0
    dwells: Tuple[float, ...] = ()
    stamp: float = 0.0
    requested_by: str = ''
    stops: Tuple[WorkStop, ...] = ()
    on_cancel: Tuple[WorkStop, ...] = ()
    after: Tuple[Dependency, ...] = ()
    template: str = ''
    arguments: Tuple[Tuple[str, str], ...] = ()
    earliest: float = 0.0
    deadline: float = 0.0

    def dwell(self, index: int) -> float:
        """Returns the seconds to stay at the destination number `index`."""
        return self.dwells[index] if self.dwells else 0.0

    @property
    def identity(self) -> Tuple[object, ...]:
        """A key that is the same for all copies of one request.

        The key of a request with a stamp has only the id, the stamp, the robot and the type, so
        MODIFY does not change it. Without a stamp, the key also has the priority, and the
        destinations or stops. In place of the stops of a template, it has the template's name and
        arguments, because the template may have changed. If a stop names a group, the key has the
        group's name, not the chosen place. The key does not have the fields that later versions add
        to the message. Otherwise an update would repeat missions.
        """
        places: Tuple[object, ...] = (self.template, self.arguments) if self.template else (
            _as_asked(self.stops), _as_asked(self.on_cancel), self.dwells) if self.stops else (
            self.destinations, self.dwells)
        asked = () if self.stamp else (self.priority, *places)
        return (self.id, self.stamp, self.robot_type, self.robot, *asked)

    def is_repeat_of(self, other: Request, other_is_open: bool) -> bool:
        """Returns whether this is the same request, sent again."""
        return self.identity == other.identity and (bool(self.stamp) or other_is_open)


@dataclass(frozen=True)
class MissionChange:
    """The changes that MODIFY makes to a request.

    destinations -- to be visited from now on, without stays; empty: no change
    stops        -- to be made from `first_stop` on; empty: no change
    first_stop   -- number, from 1, of the first stop that is replaced; 0: the first stop that has
                    not begun
    """

    priority: int
    destinations: Tuple[int, ...] = ()
    stops: Tuple[WorkStop, ...] = ()
    first_stop: int = 0


@dataclass(frozen=True)
class StepAnswer:
    """The answer of a person, or of a program, to a step of a mission.

    key -- key of the answered step; 0: the step that asks
    """

    answer: StepDecision
    key: int = 0


@dataclass(frozen=True)
class Status:
    """The published status of a request.

    stamp        -- time (s) at which the request was sent; distinguishes requests with the same id
    command      -- the command to which `reason` and `command_code` refer; None: none
    asks         -- key of the step that waits for an answer; 0: no step waits
    template, arguments, earliest, deadline -- as in the request
    serial       -- serial of the mission; 0: the request was not accepted
    priority, destinations -- the present ones

    Each attribute is a field of the published status.
    """

    request_id: int
    state: MissionState
    robot: str = ''
    reached: int = 0
    reason: str = ''
    stamp: float = 0.0
    command: Optional[CommandKind] = None
    command_code: CommandCode = CommandCode.NONE
    asks: int = 0
    template: str = ''
    arguments: Tuple[Tuple[str, str], ...] = ()
    earliest: float = 0.0
    deadline: float = 0.0
    deadline_state: DeadlineState = DeadlineState.NONE
    serial: int = 0
    priority: int = 0
    destinations: Tuple[int, ...] = ()


@dataclass
class Mission:
    """An accepted request and its progress.

    serial      -- number of the mission among all accepted ones; it is never used twice, unlike ids
    reached     -- number of visited destinations; one with a dwell counts after the dwell
    stays_since -- the supervisor's time when its stay at a destination began; None: it does not
                   stay now
    reason      -- why it ended, or what it waits for
    changes     -- number of changes of its destinations; plans from before a change are useless
    stored      -- its status on the disk; None: it is not stored yet
    changed_by  -- the person or program that requested the changes that are not stored yet; empty:
                   no such changes, or no name
    is_held     -- its robot must stand because of its steps, as the `WorkDesk` decides
    is_bound    -- its robot possibly carries its load, so no other robot may serve it
    has_worked  -- one of its steps was ordered, so the mission has begun
    asks        -- key of the step that waits for an answer; 0: no step waits

    Each attribute is one fact of its progress, as it is stored.
    """

    serial: int
    request: Request
    state: MissionState = MissionState.PENDING
    robot: str = ''
    reached: int = 0
    stays_since: Optional[float] = None
    reason: str = ''
    changes: int = 0
    stored: Optional[Status] = None
    changed_by: str = ''
    is_held: bool = False
    is_bound: bool = False
    has_worked: bool = False
    asks: int = 0
    deadline_state: DeadlineState = DeadlineState.NONE

    @property
    def status(self) -> Status:
        """The status to be published."""
        asked = self.request
        return Status(asked.id, self.state, self.robot, self.reached, self.reason, asked.stamp,
                      asks=self.asks, template=asked.template, arguments=asked.arguments,
                      earliest=asked.earliest, deadline=asked.deadline,
                      deadline_state=self.deadline_state, serial=self.serial,
                      priority=asked.priority, destinations=asked.destinations)

    @property
    def has_begun(self) -> bool:
        """Whether a robot serves the mission, or has reached one of its destinations."""
        return bool(self.robot or self.reached or self.stays_since is not None)

    @property
    def dwell_until(self) -> Optional[float]:
        """When the robot may leave the destination where it stays; infinite: when a person or
        program releases it.

        None: it does not stay now.
        """
        if self.stays_since is None:
            return None
        dwell = self.request.dwell(self.reached)
        return self.stays_since + dwell if dwell >= 0.0 else math.inf

    @property
    def left(self) -> Tuple[int, ...]:
        """The destinations still to be visited, including the one at which the robot stays."""
        return self.request.destinations[self.reached:]

    def changed(self, change: MissionChange) -> Request:
        """Returns the request after a change.

        The destination at which the robot stays now counts as visited.
        """
        request = replace(self.request, priority=change.priority)
        if not change.destinations:
            return request
        kept = self.reached + (self.stays_since is not None)
        dwells = (*request.dwells[:kept], *(0.0 for _ in change.destinations))
        return replace(request, destinations=(*request.destinations[:kept], *change.destinations),
                       dwells=dwells if request.dwells else ())

    def visits(self, passed: Iterable[int]) -> int:
        """Returns the number of destinations that a path along these vertices visits.

        The robot must come to rest at a destination with a dwell. So the count ends before such a
        destination.
        """
        count, index = 0, self.reached
        for vertex in passed:
            while index < len(self.request.destinations) and (
                    self.request.destinations[index] == vertex):
                if self.request.dwell(index):
                    return count
                index += 1
                count += 1
        return count


def _as_asked(stops: Iterable[WorkStop]) -> Tuple[WorkStop, ...]:
    """Returns the stops without the places that were chosen for their groups."""
    return tuple(replace(stop, place=0) if stop.group else stop for stop in stops)


class RequestRefused(Exception):
    """A request that is not accepted. Its text is a clause that says why and what to do."""


@dataclass(frozen=True)
class Acceptance:
    """The data with which requests are checked.

    robots -- type of each robot by its name
    places -- for each robot, a vertex that edges connect with its place; no entry: its place is
              unknown
    able   -- robots that may serve a request; the key is the robot, type and docks that the request
              demands
    """

    graph: Graph
    robots: Mapping[str, RobotType]
    places: Mapping[str, int] = field(default_factory=dict)
    able: Dict[Tuple[str, str, FrozenSet[int]], Tuple[str, ...]] = field(
        default_factory=dict, compare=False, repr=False)

    def check(self, request: Request) -> None:
        """Raises RequestRefused for a request that no robot of the fleet can carry out."""
        self._check_destinations(request)
        _check_times(request)
        self._check_robot(request)
        self._check_stops(request)
        robots = self.robots_for(request)
        if not robots:
            raise RequestRefused('no such robot may be sent to its dock')
        self._check_part(request, robots)

    def _check_destinations(self, request: Request) -> None:
        """Raises RequestRefused for destinations that no mission may have."""
        if not request.destinations:
            raise RequestRefused('it has no destinations')
        if len(request.destinations) > MOST_DESTINATIONS:
            raise RequestRefused(f'it has more than {MOST_DESTINATIONS} destinations')
        for vertex in request.destinations:
            if vertex not in self.graph.vertices:
                raise RequestRefused(f'the graph has no vertex {vertex}')

    def _check_robot(self, request: Request) -> None:
        """Raises RequestRefused for a robot or a type that the fleet does not have."""
        types = {kind.name for kind in self.robots.values()}
        if request.robot_type and request.robot_type not in types:
            raise RequestRefused(f'there is no robot of type {request.robot_type!r}; there are: '
                                 f'{", ".join(sorted(types))}')
        if request.robot and request.robot not in self.robots:
            raise RequestRefused(f'there is no robot {request.robot!r}; there are: '
                                 f'{", ".join(sorted(self.robots))}')
        if request.robot and request.robot_type not in ('', self.robots[request.robot].name):
            raise RequestRefused(f'robot {request.robot} is of type '
                                 f'{self.robots[request.robot].name}, not {request.robot_type}')

    def _check_stops(self, request: Request) -> None:
        """Raises RequestRefused for steps, or stops after a cancellation, that cannot be made."""
        try:
            check_stops(request.stops, request.on_cancel)
        except WrongStops as wrong:
            raise RequestRefused(str(wrong)) from None
        if request.on_cancel and not request.stops:
            raise RequestRefused('it has stops after a cancellation, but no stops')
        part = self.graph.part_of(request.destinations[0])
        for stop in request.on_cancel:
            if stop.place not in part:
                raise RequestRefused(f'no edges lead to vertex {stop.place}, which on_cancel names '
                                     'as a stop')

    def _check_part(self, request: Request, robots: Iterable[str]) -> None:
        """Raises RequestRefused unless edges connect all destinations with one of the robots."""
        first, *others = request.destinations
        part = self.graph.part_of(first)
        for other in others:
            if other not in part:
                raise RequestRefused(f'vertices {first} and {other} are in different parts of the '
                                     'graph, which no edges join')
        if all(self.places.get(name, first) not in part for name in robots):
            raise RequestRefused(f'vertex {first} is in another part of the graph than '
                                 f'{request.robot or "each of its robots"}')

    def check_change(self, mission: Mission, change: MissionChange) -> None:
        """Raises RequestRefused if the mission cannot be served any more after the change.

        If a robot serves the mission already, only this robot counts.
        """
        if not change.destinations and not change.stops:
            return
        self.check(replace(
            mission.request, priority=change.priority, dwells=dwells_of(change.stops),
            destinations=change.destinations or tuple(stop.place for stop in change.stops),
            stops=change.stops, on_cancel=mission.request.on_cancel if change.stops else (),
            robot=mission.robot or mission.request.robot))

    def robots_for(self, request: Request) -> Tuple[str, ...]:
        """Returns the robots that may serve a request, according to its type, robot and docks."""
        docks = self._docks(request)
        key = request.robot, request.robot_type, docks
        if key not in self.able:
            self.able[key] = tuple(name for name in self.robots
                                   if self._unfitness(request, name, docks) is Hindrance.NONE)
        return self.able[key]

    def unfitness(self, request: Request, name: str) -> Hindrance:
        """Returns why a robot may never serve a request; NONE: it may."""
        return self._unfitness(request, name, self._docks(request))

    def _unfitness(self, request: Request, name: str, docks: FrozenSet[int]) -> Hindrance:
        kind = self.robots[name]
        if request.robot not in ('', name):
            return Hindrance.OTHER_ROBOT
        if request.robot_type not in ('', kind.name):
            return Hindrance.OTHER_TYPE
        return Hindrance.NONE if all(map(kind.may_dock, docks)) else Hindrance.DOCK

    def _docks(self, request: Request) -> FrozenSet[int]:
        vertices = self.graph.vertices
        places = (*request.destinations, *(stop.place for stop in request.on_cancel))
        return frozenset(v for v in places if v in vertices and vertices[v].dock)


def _check_times(request: Request) -> None:
    """Raises RequestRefused for dwells, an earliest time or a deadline that make no sense."""
    if request.dwells and len(request.dwells) != len(request.destinations):
        raise RequestRefused(f'it has {len(request.destinations)} destinations but '
                             f'{len(request.dwells)} dwells; give one for each, or none')
    if not all(math.isfinite(d) and d <= LONGEST_DWELL for d in request.dwells):
        raise RequestRefused(f'a dwell must be a number up to {LONGEST_DWELL:.0f} s')
    if not all(math.isfinite(time) and time >= 0.0
               for time in (request.earliest, request.deadline)):
        raise RequestRefused('its earliest time or its deadline is no time')
    if request.deadline and request.deadline <= request.earliest:
        raise RequestRefused('its deadline is not after its earliest time')
