"""Missions: what is asked for, what is refused, and how far each is."""
from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Dict, FrozenSet, Iterable, Mapping, Optional, Tuple

from graph_fleet_manager.fleet import RobotType
from trajectory_graph import Graph

MOST_DESTINATIONS = 1000
LONGEST_DWELL = 1e6  # s; more is a mistake


class MissionState(IntEnum):
    """As in itrci_nav_msgs/MissionStatus."""

    PENDING = 0
    ACTIVE = 1
    SUCCEEDED = 2
    FAILED = 3
    REFUSED = 4
    CANCELLED = 5
    PAUSED = 6

    @property
    def is_open(self) -> bool:
        """Is anything still to be done?"""
        return self in (MissionState.PENDING, MissionState.ACTIVE, MissionState.PAUSED)


class Command(IntEnum):
    """As in itrci_nav_msgs/MissionCommand."""

    CANCEL = 0
    PAUSE = 1
    RESUME = 2
    RELEASE = 3
    MODIFY = 4


class CommandCode(IntEnum):
    """What a status says of a command; as in itrci_nav_msgs/MissionStatus."""

    NONE = 0
    NOT_DONE = 1
    NOT_STORED = 2


@dataclass(frozen=True)
class Request:
    """A request: visit these vertices in order.

    robot_type -- name; empty: any
    robot      -- the robot that must do it; empty: the best placed
    priority   -- the higher goes first
    dwells     -- s to stay at each destination, negative: until released; empty: nowhere
    stamp      -- s, when it was sent; 0 where the sender did not say
    requested_by -- person or program, for the records; empty: the sender did not say
    """

    id: int
    destinations: Tuple[int, ...]
    robot_type: str = ''
    robot: str = ''
    priority: int = 0
    dwells: Tuple[float, ...] = ()
    stamp: float = 0.0
    requested_by: str = ''

    def dwell(self, index: int) -> float:
        """Seconds to stay at a destination."""
        return self.dwells[index] if self.dwells else 0.0

    @property
    def identity(self) -> Tuple[object, ...]:
        """Two requests that are equal in this are the same one, sent twice.

        Fields that messages get later do not belong to it, or an update would repeat missions. A
        stamp tells them apart, also after MODIFY; without one all that was asked for does.
        """
        asked = () if self.stamp else (self.destinations, self.priority, self.dwells)
        return (self.id, self.stamp, self.robot_type, self.robot, *asked)

    def is_repeat_of(self, other: Request, other_is_open: bool) -> bool:
        """Is it the same request, sent again?"""
        return self.identity == other.identity and (bool(self.stamp) or other_is_open)


@dataclass(frozen=True)
class Change:
    """What MODIFY makes of a request.

    destinations -- to be visited from now on, without stays; empty: as before
    """

    priority: int
    destinations: Tuple[int, ...] = ()


@dataclass(frozen=True)
class Status:
    """What is told of a request.

    stamp        -- s, when the request was sent: of several with its id it is about this one
    command      -- of which the reason tells, with what `command_code` says; None: of none
    """

    request_id: int
    state: MissionState
    robot: str = ''
    reached: int = 0
    reason: str = ''
    stamp: float = 0.0
    command: Optional[Command] = None
    command_code: CommandCode = CommandCode.NONE


@dataclass
class Mission:
    """An accepted request, and how far it is.

    serial      -- counts all accepted missions; ids may come again, serials never do
    reached     -- destinations visited, dwells included
    stays_since -- the supervisor's time since which it stays at a destination; None: it does not
    reason      -- why it ended, or what it waits for
    changes     -- how often it got other destinations: plans for the ones before serve no more
    stored      -- its status as it is on the disk; None: it is not there yet
    changed_by  -- the requester of its changes that are not stored yet; empty: none, or not given
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

    @property
    def status(self) -> Status:
        """As it is told."""
        return Status(self.request.id, self.state, self.robot, self.reached, self.reason,
                      self.request.stamp)

    @property
    def dwell_until(self) -> Optional[float]:
        """When it may leave the destination where it stays; infinite: when it is released.

        None: it does not stay now.
        """
        if self.stays_since is None:
            return None
        dwell = self.request.dwell(self.reached)
        return self.stays_since + dwell if dwell >= 0.0 else math.inf

    @property
    def left(self) -> Tuple[int, ...]:
        """Destinations still to be visited; that of a dwell under way included."""
        return self.request.destinations[self.reached:]

    def changed(self, change: Change) -> Request:
        """What it is to do after a change; a stay under way ends with its destination."""
        request = replace(self.request, priority=change.priority)
        if not change.destinations:
            return request
        kept = self.reached + (self.stays_since is not None)
        dwells = (*request.dwells[:kept], *(0.0 for _ in change.destinations))
        return replace(request, destinations=(*request.destinations[:kept], *change.destinations),
                       dwells=dwells if request.dwells else ())

    def visits(self, passed: Iterable[int]) -> int:
        """How many destinations a way along these vertices visits.

        Where it is to stay it must come to rest: such a destination ends the count before it.
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


class RequestRefused(Exception):
    """A request that is not accepted; the text, a clause, says why and what to do."""


@dataclass(frozen=True)
class Acceptance:
    """What requests are judged by.

    robots -- type of each robot by its name
    places -- vertices at which robots are, or from which they have driven, as far as known
    able   -- robots for a request, by what it says of them and its docks; filled when asked
    """

    graph: Graph
    robots: Mapping[str, RobotType]
    places: Mapping[str, int] = field(default_factory=dict)
    able: Dict[Tuple[str, str, FrozenSet[int]], Tuple[str, ...]] = field(
        default_factory=dict, compare=False, repr=False)

    def check(self, request: Request) -> None:
        """Raises RequestRefused for what no robot of the fleet can do."""
        if not request.destinations:
            raise RequestRefused('it has no destinations')
        if len(request.destinations) > MOST_DESTINATIONS:
            raise RequestRefused(f'it has more than {MOST_DESTINATIONS} destinations')
        for vertex in request.destinations:
            if vertex not in self.graph.vertices:
                raise RequestRefused(f'the graph has no vertex {vertex}')
        if request.dwells and len(request.dwells) != len(request.destinations):
            raise RequestRefused(f'it has {len(request.destinations)} destinations but '
                                 f'{len(request.dwells)} dwells; give one for each, or none')
        if not all(math.isfinite(d) and d <= LONGEST_DWELL for d in request.dwells):
            raise RequestRefused(f'a dwell must be a number up to {LONGEST_DWELL:.0f} s')
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
        robots = self.robots_for(request)
        if not robots:
            raise RequestRefused('no such robot may be sent to its dock')
        self._check_part(request, robots)

    def _check_part(self, request: Request, robots: Iterable[str]) -> None:
        """Raises RequestRefused where no edges lead from one destination to another, or to it from
        any of the robots."""
        first, *others = request.destinations
        part = self.graph.part_of(first)
        for other in others:
            if other not in part:
                raise RequestRefused(f'vertices {first} and {other} are in different parts of the '
                                     'graph, which no edges join')
        if all(self.places.get(name, first) not in part for name in robots):
            raise RequestRefused(f'vertex {first} is in another part of the graph than '
                                 f'{request.robot or "each of its robots"}')

    def check_change(self, mission: Mission, change: Change) -> None:
        """Raises RequestRefused for a change after which no robot could do the rest, or not the
        robot that serves the mission."""
        if not change.destinations:
            return
        self.check(replace(mission.request, priority=change.priority, dwells=(),
                           destinations=change.destinations,
                           robot=mission.robot or mission.request.robot))

    def robots_for(self, request: Request) -> Tuple[str, ...]:
        """Robots that may serve a request as far as type, name and docks say."""
        vertices = self.graph.vertices
        docks = frozenset(v for v in request.destinations if v in vertices and vertices[v].dock)
        key = request.robot, request.robot_type, docks
        if key not in self.able:
            self.able[key] = tuple(
                name for name, kind in self.robots.items()
                if request.robot in ('', name) and request.robot_type in ('', kind.name)
                and all(kind.may_dock(dock) for dock in docks))
        return self.able[key]
