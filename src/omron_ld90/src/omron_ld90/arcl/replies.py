"""What the robot says: one frozen dataclass per kind of line.

Lengths are mm, angles degrees, in the robot's map frame, as ARCL gives them (the ROS nodes turn
them into SI). Names (goals, routes, ...) are spelt as the robot spelt them: compare them with
`same_name`, for the robot itself does not respect case.
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Optional

import numpy as np


class Reply:
    """Base of every kind of line. `isinstance` tells them apart."""

    __slots__ = ()


def same_name(one: str, other: str) -> bool:
    """Whether two names mean the same object to the robot, which respects neither case nor ends."""
    return one.strip().casefold() == other.strip().casefold()


@dataclass(frozen=True)
class UnknownLine(Reply):
    """A line of no known kind: free text of another client, of a newer robot, or garbage."""

    text: str


# --- driving -----------------------------------------------------------------------------------

@dataclass(frozen=True)
class GoingTo(Reply):
    """The robot set out for a goal."""

    goal: str


@dataclass(frozen=True)
class GoingToPoint(Reply):
    """The robot set out for a point given by coordinates."""


@dataclass(frozen=True)
class ArrivedAt(Reply):
    """The robot stands at a goal."""

    goal: str


@dataclass(frozen=True)
class ArrivedAtPoint(Reply):
    """The robot stands at the point that it was sent to."""


@dataclass(frozen=True)
class FailedGoingTo(Reply):
    """The robot gave up driving to a goal."""

    goal: str


@dataclass(frozen=True)
class Stopping(Reply):
    """The robot slows down to a halt."""


@dataclass(frozen=True)
class Stopped(Reply):
    """The robot halted. No proof of one's own `stop`: undocking and enabling motors end so too."""


@dataclass(frozen=True)
class Parking(Reply):
    """The robot is parking (`parked`: has parked) of its own accord."""

    parked: bool


@dataclass(frozen=True)
class Interrupted(Reply):
    """What ran was replaced or stopped; `text` is the status text it had, e.g. `Going to 12`."""

    text: str


@dataclass(frozen=True)
class RobotError(Reply):
    """`Error: <text>`: something failed while running; names no command."""

    text: str


class DockingState(Enum):
    """Where the robot is between its path and its charging station."""

    UNDOCKED = 'Undocked'
    DOCKING = 'Docking'
    DOCKED = 'Docked'
    UNDOCKING = 'Undocking'


@dataclass(frozen=True)
class DockingStatus(Reply):
    """Docking state; `charge` is the charger's word: Not, Bulk, Overcharge, Float, Unknowable.

    Only `docking` tells whether the robot is docked: `charge` wavers while undocking.
    """

    docking: DockingState
    forced: bool
    charge: str


@dataclass(frozen=True)
class Patrolling(Reply):
    """The robot drives the goals of a route, for ever or (`once`) one time."""

    route: str
    once: bool


@dataclass(frozen=True)
class FinishedPatrolling(Reply):
    """The last goal of a route patrolled once was reached."""

    route: str


@dataclass(frozen=True)
class LapCompleted(Reply):
    """A patrol begins again (older robots say so)."""


# --- tasks, macros, lists ----------------------------------------------------------------------

@dataclass(frozen=True)
class WillDoTask(Reply):
    """`doTask` was accepted; `task` is its name and arguments."""

    task: str


@dataclass(frozen=True)
class DoingTask(Reply):
    """A task began."""

    task: str


@dataclass(frozen=True)
class CompletedTask(Reply):
    """A task ended well."""

    task: str


@dataclass(frozen=True)
class CompletedInstantTask(Reply):
    """A task that does not interrupt driving was done."""

    task: str


@dataclass(frozen=True)
class ExecutingMacro(Reply):
    """A macro began."""

    macro: str


@dataclass(frozen=True)
class CompletedMacro(Reply):
    """A macro ended well."""

    macro: str


@dataclass(frozen=True)
class ExecutingList(Reply):
    """The task list began."""


@dataclass(frozen=True)
class FinishedList(Reply):
    """The task list ended well."""


@dataclass(frozen=True)
class WaitState(Reply):
    """State of a wait task."""

    text: str


@dataclass(frozen=True)
class PauseState(Reply):
    """State of a pause task."""

    text: str


# --- emergency stop, motors, faults ------------------------------------------------------------

@dataclass(frozen=True)
class EStop(Reply):
    """The emergency stop; after its release the motors stay off until they are enabled.

    The manual spells it in four ways; `text` is the robot's.
    """

    pressed: bool
    text: str


@dataclass(frozen=True)
class Motors(Reply):
    """Whether the motors are powered."""

    enabled: bool


@dataclass(frozen=True)
class Fault(Reply):
    """A fault was raised (`cleared`: is over), told at the event or as an item of a fault list."""

    kind: str
    name: str
    short: str
    long: str
    driving: bool
    critical: bool
    application: bool
    cleared: bool = False


# --- errors ------------------------------------------------------------------------------------

@dataclass(frozen=True)
class CommandError(Reply):
    """The robot refused a command line; `CommandErrorDescription` follows, perhaps not at once."""

    command: str


@dataclass(frozen=True)
class CommandErrorDescription(Reply):
    """Why the command named by the last `CommandError` was refused."""

    text: str


@dataclass(frozen=True)
class UnknownCommand(Reply):
    """The robot has no such command; `name` may be cut short."""

    name: str


@dataclass(frozen=True)
class SetUpError(Reply):
    """A command came in the wrong order, or what it needs is not set up or not there."""

    text: str


# --- status ------------------------------------------------------------------------------------

@dataclass(frozen=True)
class ExtendedStatus(Reply):
    """`ExtendedStatusForHumans`: segments joined by `|`."""

    text: str


@dataclass(frozen=True)
class StatusText(Reply):
    """What the robot does; another line in itself, to be read with `parse_line`."""

    text: str


@dataclass(frozen=True)
class StateOfCharge(Reply):
    """Charge of the battery in percent."""

    percent: float


@dataclass(frozen=True)
class BatteryVoltage(Reply):
    """Voltage of the battery, which older robots send instead of the charge."""

    volts: float


@dataclass(frozen=True)
class Location(Reply):
    """The robot's pose in its map: mm, mm, degrees (-180..180)."""

    x: float
    y: float
    heading: float


@dataclass(frozen=True)
class LocalizationScore(Reply):
    """How well the laser fits the map, 0..1."""

    score: float


@dataclass(frozen=True)
class Temperature(Reply):
    """Degrees Celsius; None where the robot has no sensor (it says -127 or -128)."""

    celsius: Optional[float]


@dataclass(frozen=True)
class OneLineStatus(Reply):
    """`oneLineStatus`: several status fields on one line; None is a field that was not sent."""

    status: str
    extended_status: Optional[str] = None
    state_of_charge: Optional[StateOfCharge] = None
    battery_voltage: Optional[BatteryVoltage] = None
    location: Optional[Location] = None
    localization_score: Optional[LocalizationScore] = None
    temperature: Optional[Temperature] = None


@dataclass(frozen=True, eq=False)
class RangeReading(Reply):
    """Points that a range device sees: (N, 2) int64, mm, in the map frame; read only.

    `cumulative` points are remembered for some time, others belong to one scan.
    """

    device: str
    points: np.ndarray
    cumulative: bool = False

    def __eq__(self, other: object) -> bool:
        return (isinstance(other, RangeReading) and self.device == other.device
                and self.cumulative == other.cumulative
                and np.array_equal(self.points, other.points))

    __hash__ = None


# --- queries -----------------------------------------------------------------------------------

@dataclass(frozen=True)
class Goal(Reply):
    """A goal of the map in use; docks are not listed."""

    name: str


@dataclass(frozen=True)
class Route(Reply):
    """A route of the map in use."""

    name: str


@dataclass(frozen=True)
class Macro(Reply):
    """A macro of the map in use."""

    name: str


@dataclass(frozen=True)
class Odometer(Reply):
    """Distance (mm), rotation (degrees) and time (s) since the last reset."""

    distance: float
    rotation: float
    seconds: float


@dataclass(frozen=True)
class DateTime(Reply):
    """The robot's clock, as it writes it (MM/DD/YYYY HH:MM:SS)."""

    text: str


@dataclass(frozen=True)
class DistanceBetween(Reply):
    """Length of the path between two goals, mm."""

    distance: float
    origin: str
    destination: str


@dataclass(frozen=True)
class MapObjectName(Reply):
    """An object of the map, with its type."""

    name: str
    type: str


@dataclass(frozen=True)
class MapObjectCoord(Reply):
    """Pose of an object of the map: mm, mm, degrees."""

    name: str
    x: float
    y: float
    heading: float


@dataclass(frozen=True)
class ConfigValue(Reply):
    """A key of a configuration section, with its value."""

    key: str
    value: str


@dataclass(frozen=True)
class Input(Reply):
    """A digital input or output (`output`); `state` is on, off or broken."""

    name: str
    state: str
    output: bool = False


@dataclass(frozen=True)
class RangeDevice(Reply):
    """A range device of the robot, e.g. `Laser_1`, and what kind it is."""

    name: str
    kind: str


@dataclass(frozen=True)
class Item(Reply):
    """An item of a list that needs no closer reading; `prefix` is what stands before the colon."""

    prefix: str
    text: str


@dataclass(frozen=True)
class EndOf(Reply):
    """The end of a list, in lower case: `goals` for `End of goals`, `rangedevicelist`, ..."""

    what: str


@dataclass(frozen=True)
class HelpEntry(Reply):
    """A command of the robot's help list."""

    name: str
    description: str


# --- what is said in passing --------------------------------------------------------------------

@dataclass(frozen=True)
class MapChanged(Reply):
    """Another map is in use: goals changed, and the robot may not know where it is."""


@dataclass(frozen=True)
class ConfigurationChanged(Reply):
    """A configuration was loaded."""


@dataclass(frozen=True)
class Localizing(Reply):
    """The robot looks for its place (`done`: has found it) where it was told."""

    done: bool
    text: str


@dataclass(frozen=True)
class Done(Reply):
    """An immediate command was carried out; `text` is the line, e.g. `Reset odometer`."""

    text: str


@dataclass(frozen=True)
class ConfigErrors(Reply):
    """The configuration was loaded with errors."""

    text: str


@dataclass(frozen=True)
class Notice(Reply):
    """News that asks nothing of a client: `kind` QueueUpdate, PayloadUpdate, Charge, ..."""

    kind: str
    text: str


@dataclass(frozen=True)
class Echo(Reply):
    """Whether the server echoes what it is sent."""

    on: bool


@dataclass(frozen=True)
class ServerClosing(Reply):
    """The server is about to close the connection, and says why."""

    text: str
