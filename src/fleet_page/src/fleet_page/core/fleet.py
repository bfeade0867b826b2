"""Robots and missions as plain values, as the fleet manager publishes them."""
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
DEADLINE_ALARMS = DEADLINE_STATES[2:]  # of which people are told


@dataclass(frozen=True)
class ShownPose:
    """A pose in the frame `map`: x (m), y (m), theta (rad); None: the heading is not known."""

    x: float
    y: float
    theta: Optional[float]


@dataclass(frozen=True)
class ShownRobot:
    """One robot.

    outage   -- name of the code in itrci_nav_msgs/FleetRobot without OUTAGE_; NONE if it works
    edge     -- signed id; 0: off the graph
    fraction -- part of the edge that is behind the robot, 0..1
    seen     -- time of its last report, s since 1970; 0: never
    battery  -- charge, 0..1; None: unknown
    mission  -- request id; None: it has no mission
    to_end   -- s until its mission ends, as the fleet manager expects; None: unknown
    not_open -- the device in which it is, and which does not report that it is open; empty: none
    wait     -- name of the code of what it waits for (WaitCode)
    load     -- what it carries (name of a LoadState); load_serial: the serial of the load's
                mission; load_types: the types of load that it may be, as far as they are known
    software -- name and version of its software; empty: it does not tell them

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
        """Whether it carries out a step at a stop."""
        return self.state == 'BUSY' and self.wait == WaitCode.STEP.name

    @property
    def needs_person(self) -> bool:
        """Whether it waits for the answer of a person, or to be unloaded."""
        return self.state in ('IDLE', 'BUSY') and self.wait == WaitCode.PERSON.name

    @property
    def is_waiting(self) -> bool:
        """Whether it has a mission, and waits for something."""
        return self.mission is not None and not self.is_working and (
            self.wait != WaitCode.NOTHING.name)


@dataclass(frozen=True)
class ShownQueuePlace:
    """A place at which robots wait for a station. `robot`: that has it; empty: none has."""

    vertex: int
    robot: str = ''
    is_there: bool = False


@dataclass(frozen=True)
class ShownResource:
    """A station, a door or the like, as the map shows it.

    kind     -- name of the kind (fleet_core.interlocking.resources)
    edges    -- ids of the edges that need it
    vertices -- ids of the vertices that need it
    device   -- what its device shows (name of a DeviceMode); empty: it has none
    robots   -- names of the robots that claim it
    look     -- name of its ResourceLook, which has a colour
    is_group -- its vertices are equal: a mission may name it in place of one of them
    queue    -- of a station, the first place first
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
    vertices -- where it stands, or works; empty: that is not known
    robot    -- for which it works; empty: none
    """

    name: str
    state: str
    look: str
    vertices: Tuple[int, ...] = ()
    robot: str = ''


ALARMING = ('STOPPED', 'TAKEN_OVER', 'FAILED', 'OFF_GRAPH', 'TOO_NEAR', 'CLOCK', 'DEAF')
NEVER_HEARD = 'NEVER_HEARD'
_SILENT = 'SILENT'
NOT_OPEN = 'NOT_OPEN'  # it is in a door that does not report that it is open
LADEN = 'LADEN'        # it carries something, or may, and its mission has ended
ALARMS = (*ALARMING, _SILENT, NEVER_HEARD, NOT_OPEN, LADEN)


def alarm_of(robot: ShownRobot) -> str:
    """Returns why a robot needs a person, as one of ALARMS; empty: it does not."""
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
    """Returns what keeps a robot from working, as one of FAULTS; empty: nothing does."""
    return alarm_of(robot) or ('' if robot.outage == 'NONE' else robot.outage)


class RobotGroup(Enum):
    """What a robot counts as in the header of the page; the value is its key there."""

    IDLE = 'idle'
    DRIVING = 'driving'
    WORKING = 'working'
    """It carries out a step at a stop."""
    WAITING = 'waiting'
    """It has something to do, and waits."""
    CHARGING = 'charging'
    TROUBLE = 'trouble'
    """It needs a person."""
    AWAY = 'away'
    """It is offline, out of service or absent."""


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
    """What a robot may occupy.

    holds  -- signed ids of edges, each with the fraction that is behind the robot
    vertex -- on which it stands; 0: none
    areas  -- radius (m) and line of each further place
    """

    holds: Tuple[Tuple[int, float], ...]
    vertex: int
    areas: Tuple[Tuple[float, Line], ...] = ()


@dataclass(frozen=True)
class MissionStatus:
    """The status of a mission. `stamp` (ns) distinguishes missions with the same id.

    not_done -- the act that was not carried out, for the given reason; empty: the reason concerns
                the mission itself
    asks     -- key of the step that waits for an answer; 0: none does
    told     -- when the fleet manager told it, s since 1970
    deadline -- one of DEADLINE_STATES
    template -- the template and its arguments, for people; empty: none
    serial   -- number of the mission at this site, for people; 0: it was not accepted
    destinations -- vertices in force; empty: those of the request

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

    arguments -- of its template, each with the name of its parameter
    every     -- minutes from one run to the next one of a day
    begin     -- minute of the day of its first run
    end       -- minutes from the beginning of that day to the last time at which a run may be
    days      -- days of the week on which it begins; 0 is Monday
    next      -- of its next run, s since 1970; None: it is paused
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
    """The request of a mission. `template`: empty if it has destinations itself."""

    id: int
    stamp: int
    destinations: Tuple[int, ...]
    robot: str
    robot_type: str
    priority: int
    requested_by: str = ''
    template: str = ''
    arguments: Tuple[Tuple[str, str], ...] = ()
