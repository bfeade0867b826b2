"""Robots and missions as plain values, in the words of the fleet manager."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Optional, Tuple

from fleet_core.supervision.looks import ResourceLook
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.waits import WaitCode
from fleet_core.work.tables import LoadState

ROBOT_STATES = ('IDLE', 'BUSY', 'CHARGING', 'OFFLINE', 'STOPPED', 'TAKEN_OVER', 'FAILED',
                'OFF_GRAPH', 'OUT_OF_SERVICE', 'ABSENT', 'UNKNOWN')
MISSION_STATES = ('PENDING', 'ACTIVE', 'SUCCEEDED', 'FAILED', 'REFUSED', 'CANCELLED', 'PAUSED',
                  'CANCELLING', 'NEEDS_PERSON', 'BLOCKED', 'PLANNED', 'EXPIRED')
OPEN_STATES = ('PENDING', 'ACTIVE', 'PAUSED', 'CANCELLING', 'NEEDS_PERSON', 'BLOCKED', 'PLANNED')
DEADLINE_STATES = ('NONE', 'AHEAD', 'AT_RISK', 'MISSED')
DEADLINE_ALARMS = DEADLINE_STATES[2:]  # the states that people see as alarms


@dataclass(frozen=True)
class ShownPose:
    """A pose in the frame `map`: x (m), y (m), theta (rad); None: the heading is not known."""

    x: float
    y: float
    theta: Optional[float]


@dataclass(frozen=True)
class ShownRobot:
    """One robot.

    outage   -- an outage of itrci_nav_msgs/FleetRobot, without the prefix OUTAGE_; NONE: the robot
                works
    edge     -- signed id; 0: off the graph
    fraction -- part of the edge that is behind the robot, 0..1
    seen     -- time of its last report, s since 1970; 0: never
    battery  -- charge, 0..1; None: unknown
    mission  -- request id; None: it has no mission
    to_end   -- s until its mission ends, as the fleet manager expects; None: unknown
    not_open -- the device that the robot is in although no report says that the device is open;
                empty: there is none
    wait     -- name of the code of what it waits for (WaitCode)
    load     -- what it carries (name of a LoadState); load_serial: the serial of the load's
                mission; load_types: the types of load that it may be, as far as they are known
    software -- name and version of its software; empty: the robot does not report them

    Each attribute is a value that the page shows.
    """

    name: str
    type: str
    state: str
    outage: str
    edge: int
    fraction: float
    seen: float
    battery: Optional[float]
    mission: Optional[int]
    destination: int
    waits_for: str
    to_end: Optional[float] = None
    wait: str = WaitCode.NOTHING.name
    not_open: str = ''
    load: str = LoadState.EMPTY.name
    load_serial: int = 0
    software: str = ''
    load_types: Tuple[str, ...] = ()

    @property
    def is_working(self) -> bool:
        """Whether the robot carries out a step at a stop."""
        return self.state == 'BUSY' and self.wait == WaitCode.STEP.name

    @property
    def needs_person(self) -> bool:
        """Whether the robot waits for a person's answer, or waits to be unloaded."""
        return self.state in ('IDLE', 'BUSY') and self.wait == WaitCode.PERSON.name

    @property
    def is_waiting(self) -> bool:
        """Whether the robot has a mission and waits for something."""
        return self.mission is not None and not self.is_working and (
            self.wait != WaitCode.NOTHING.name)


@dataclass(frozen=True)
class ShownQueuePlace:
    """A place at which robots wait for a station. `robot`: the robot that has the place, or empty.
    """

    vertex: int
    robot: str = ''
    is_there: bool = False


@dataclass(frozen=True)
class ShownResource:
    """A station, a door or another resource, as the map shows it.

    kind     -- name of the kind (fleet_core.interlocking.resources)
    edges    -- ids of the edges that need it
    vertices -- ids of the vertices that need it
    device   -- name of the DeviceMode of its device; empty: it has no device
    robots   -- names of the robots that claim it
    look     -- name of its ResourceLook, which has a colour
    is_group -- whether its vertices are equal: a mission may name the station instead of a vertex
    queue    -- the queue places of a station, the first place first
    """

    name: str
    kind: str
    edges: Tuple[int, ...] = ()
    vertices: Tuple[int, ...] = ()
    device: str = ''
    robots: Tuple[str, ...] = ()
    look: str = ResourceLook.PLACE.name
    is_group: bool = False
    queue: Tuple[ShownQueuePlace, ...] = ()


@dataclass(frozen=True)
class ShownMachine:
    """A machine, as the map shows it.

    state    -- name of a MachineState
    look     -- name of its ResourceLook
    vertices -- where the machine stands or works; empty: unknown
    robot    -- the robot for which it works; empty: none
    """

    name: str
    state: str
    look: str
    vertices: Tuple[int, ...] = ()
    robot: str = ''


ALARMING = ('STOPPED', 'TAKEN_OVER', 'FAILED', 'OFF_GRAPH', 'TOO_NEAR', 'CLOCK', 'DEAF')
NEVER_HEARD = 'NEVER_HEARD'
_SILENT = 'SILENT'
NOT_OPEN = 'NOT_OPEN'  # the robot is in a door, and no report says that the door is open
LADEN = 'LADEN'        # the robot carries, or perhaps carries, something, and its mission has ended
ALARMS = (*ALARMING, _SILENT, NEVER_HEARD, NOT_OPEN, LADEN)


def alarm_of(robot: ShownRobot) -> str:
    """Returns why a robot needs a person, as one of ALARMS; empty if it needs none."""
    if robot.state == 'UNKNOWN':
        return NEVER_HEARD
    is_missed = robot.outage == _SILENT and robot.mission is not None
    if is_missed or robot.outage in ALARMING:
        return robot.outage
    if robot.not_open:
        return NOT_OPEN
    return LADEN if robot.needs_person and robot.mission is None else ''


FAULTS = (*ALARMS, *(outage.name for outage in Outage if outage.name not in ALARMS))


def fault_of(robot: ShownRobot) -> str:
    """Returns what keeps a robot from working, as one of FAULTS; empty if nothing does."""
    return alarm_of(robot) or ('' if robot.outage == 'NONE' else robot.outage)


class RobotGroup(Enum):
    """The groups of robots that the header of the page counts; the value is the group's key."""

    IDLE = 'idle'
    DRIVING = 'driving'
    WORKING = 'working'
    """The robot carries out a step at a stop."""
    WAITING = 'waiting'
    """The robot has something to do, and waits."""
    CHARGING = 'charging'
    TROUBLE = 'trouble'
    """The robot needs a person."""
    AWAY = 'away'
    """The robot is offline, out of service or absent."""


_WITH_WORK = {'IDLE': RobotGroup.IDLE, 'BUSY': RobotGroup.DRIVING, 'CHARGING': RobotGroup.CHARGING}


def group_of(robot: ShownRobot) -> RobotGroup:
    """Returns the group of a robot."""
    if alarm_of(robot) or robot.needs_person:
        return RobotGroup.TROUBLE
    if robot.is_working:
        return RobotGroup.WORKING
    group = _WITH_WORK.get(robot.state, RobotGroup.AWAY)
    waits = group is RobotGroup.DRIVING and robot.wait != WaitCode.NOTHING.name
    return RobotGroup.WAITING if waits else group


@dataclass(frozen=True)
class ShownPlan:
    """The next edges of a robot, with signed ids. The first `released` edges are released."""

    edges: Tuple[int, ...]
    released: int


Line = Tuple[Tuple[float, float], ...]
"""Points (m)."""


@dataclass(frozen=True)
class ShownAllocation:
    """All places that a robot may occupy.

    holds  -- signed ids of edges, each with the fraction that is behind the robot
    vertex -- the vertex on which it stands; 0: none
    areas  -- radius (m) and line of each other place
    """

    holds: Tuple[Tuple[int, float], ...]
    vertex: int
    areas: Tuple[Tuple[float, Line], ...] = ()


@dataclass(frozen=True)
class MissionStatus:
    """The status of a mission. `stamp` (ns) distinguishes missions with the same id.

    not_done -- the act that was not carried out for the given reason; empty: the reason concerns
                the mission itself
    asks     -- key of the step that waits for an answer; 0: none does
    told     -- time of the status, s since 1970
    deadline -- one of DEADLINE_STATES
    template -- the template and its arguments, for people; empty: none
    serial   -- number of the mission at this site, for people; 0: it was not accepted
    destinations -- the vertices in force; empty: the destinations of the request are in force

    Each attribute is a value that the page shows.
    """

    id: int
    stamp: int
    state: str
    robot: str
    reached: int
    reason: str
    not_done: str = ''
    asks: int = 0
    told: float = 0.0
    deadline: str = 'NONE'
    template: str = ''
    serial: int = 0
    destinations: Tuple[int, ...] = ()


@dataclass(frozen=True)
class ShownTemplate:
    """A template of missions, with the names of its parameters."""

    name: str
    parameters: Tuple[str, ...]


@dataclass(frozen=True)
class ShownTimetable:
    """A timetable. The page shows each value.

    arguments -- arguments of its template, each with the name of its parameter
    every     -- minutes from one run to the next, within a day
    begin     -- minute of the day of the first run
    end       -- latest time of a run, in minutes from the beginning of the same day
    days      -- days of the week on which it begins; 0 is Monday
    next      -- time of the next run, s since 1970; None: it is paused
    """

    name: str
    template: str
    arguments: Tuple[Tuple[str, str], ...]
    every: int
    begin: int
    end: int
    days: Tuple[int, ...]
    next: Optional[float]


@dataclass(frozen=True)
class MissionRequest:
    """The request of a mission. `template` is empty if the request itself has destinations."""

    id: int
    stamp: int
    destinations: Tuple[int, ...]
    robot: str
    robot_type: str
    priority: int
    requested_by: str = ''
    template: str = ''
    arguments: Tuple[Tuple[str, str], ...] = ()
