"""The replies: one frozen dataclass for each kind of line of the robot, grouped by subject.

    from omron_arcl import parse_line, replies
    reply = parse_line('Going to 12')
    assert isinstance(reply, replies.GoingTo)

As in ARCL, lengths are in mm and angles in degrees, in the robot's map frame. The ROS nodes convert
them to SI units. Names of goals, routes and other objects are spelt as the robot spelt them.
Compare names with `same_name`, because the robot ignores case.
"""
from __future__ import annotations

import math
import re
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Optional, Tuple

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt  # not in the numpy of Ubuntu 20.04


class Reply:
    """Base of all kinds of lines. Distinguish the kinds with `isinstance`."""

    __slots__ = ()


def readable(name: str) -> str:
    """Returns a name as people read it, and as the robot's lines contain it.

    In names from files, surrogates may stand for bytes that are not valid UTF-8
    (`surrogateescape`). Such a name is read as Latin-1, as in `framing.decode`.
    """
    if name.isascii():
        return name
    try:
        return name.encode('utf-8', 'surrogateescape').decode('utf-8')
    except UnicodeDecodeError:
        return name.encode('utf-8', 'surrogateescape').decode('latin-1')
    except UnicodeEncodeError:  # other surrogates, which represent no bytes
        return name


def same_name(one: str, other: str) -> bool:
    """Returns whether two names mean the same object to the robot, which ignores case
    and outer blanks.
    """
    return readable(one).strip().casefold() == readable(other).strip().casefold()


def coordinates(name: str) -> Tuple[float, ...]:
    """Returns the numbers (mm, mm, and perhaps degrees) if `name` consists of them; else empty."""
    words = name.replace(',', ' ').split()
    try:
        numbers = tuple(map(float, words)) if len(words) in (2, 3) and '_' not in name else ()
    except ValueError:
        return ()
    return numbers if all(map(math.isfinite, numbers)) else ()


def names_emergency_stop(text: str) -> bool:
    """Returns whether a text is about the emergency stop, which robots spell in many ways."""
    return bool(_EMERGENCY_STOP.search(text))


_EMERGENCY_STOP = re.compile(r'e-?stop|emergency stop', re.IGNORECASE)


@dataclass(frozen=True)
class UnknownLine(Reply):
    """A line of no known kind: text of another client, a line of a newer robot, or garbage."""

    text: str


# --- status ---------------------------------------------------------------------------------------

@dataclass(frozen=True)
class ExtendedStatus(Reply):
    """`ExtendedStatusForHumans`: segments joined by `|`."""

    text: str


@dataclass(frozen=True)
class StatusText(Reply):
    """The robot's activity, in the form of another line; parse it with `parse_line`."""

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
    """The degree to which the laser scan fits the map, 0..1."""

    score: float


@dataclass(frozen=True)
class Temperature(Reply):
    """Degrees Celsius; None if the robot has no sensor (it sends -127 or -128)."""

    celsius: Optional[float]


@dataclass(frozen=True)
class OneLineStatus(Reply):
    """`oneLineStatus`: several status fields on one line. None means that a field was not sent.

    ignored -- the fields with impossible values, as the robot sent them; they count as not sent
    """

    status: str
    extended_status: Optional[str] = None
    state_of_charge: Optional[StateOfCharge] = None
    battery_voltage: Optional[BatteryVoltage] = None
    location: Optional[Location] = None
    localization_score: Optional[LocalizationScore] = None
    temperature: Optional[Temperature] = None
    ignored: Tuple[str, ...] = ()


# --- driving, docking, stopping, localizing -------------------------------------------------------

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
    """The robot halted. This does not prove that it obeyed a `stop`: the robot also says so after
    undocking, and after its motors were enabled.
    """


@dataclass(frozen=True)
class Parking(Reply):
    """The robot parks by its own decision (`parked`: it has parked)."""

    parked: bool


@dataclass(frozen=True)
class Interrupted(Reply):
    """A motion was replaced or stopped. `text` is the status text of that motion, such as
    `Going to 12`.
    """

    text: str


@dataclass(frozen=True)
class RobotError(Reply):
    """`Error: <text>`: the robot failed to carry something out. The line names no command."""

    text: str

    @property
    def pressed(self) -> bool:
        """Whether the error is that the emergency stop is pressed."""
        return names_emergency_stop(self.text)


@dataclass(frozen=True)
class Failure(Reply):
    """A failure in free words: `Cannot find path`, `Failed to localize`."""

    text: str


@dataclass(frozen=True)
class Patrolling(Reply):
    """The robot drives to the goals of a route, endlessly or (`once`) one time."""

    route: str
    once: bool


@dataclass(frozen=True)
class FinishedPatrolling(Reply):
    """The robot reached the last goal of a route that it patrolled once."""

    route: str


@dataclass(frozen=True)
class LapCompleted(Reply):
    """A lap of a patrol has ended, and the next one begins (sent by older robots)."""


class DockingState(Enum):
    """Whether the robot is undocked, docks, is docked, or undocks."""

    UNDOCKED = 'Undocked'
    DOCKING = 'Docking'
    DOCKED = 'Docked'
    UNDOCKING = 'Undocking'


@dataclass(frozen=True)
class DockingStatus(Reply):
    """The docking state. `charge` is the charger's state: Not, Bulk, Overcharge, Float, Unknowable.

    To see whether the robot is docked, use only `docking`: `charge` is unreliable during undocking.
    """

    docking: DockingState
    forced: bool
    charge: str


@dataclass(frozen=True)
class Localizing(Reply):
    """The robot searches for its position at the given place; `done`: it has found the position."""

    done: bool
    text: str


# --- tasks, macros and task lists -----------------------------------------------------------------

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
    """A task ended successfully."""

    task: str


@dataclass(frozen=True)
class CompletedInstantTask(Reply):
    """A task that does not interrupt driving is done."""

    task: str


@dataclass(frozen=True)
class ExecutingMacro(Reply):
    """A macro began."""

    macro: str


@dataclass(frozen=True)
class CompletedMacro(Reply):
    """A macro ended successfully."""

    macro: str


@dataclass(frozen=True)
class ExecutingList(Reply):
    """The task list began."""


@dataclass(frozen=True)
class FinishedList(Reply):
    """The task list ended successfully."""


@dataclass(frozen=True)
class WaitState(Reply):
    """State of a wait task."""

    text: str


# --- the emergency stop, the motors and faults ----------------------------------------------------

@dataclass(frozen=True)
class EStop(Reply):
    """The emergency stop; after its release the motors stay off until they are enabled.

    The manual spells it in four ways; `text` is the robot's own wording.
    """

    pressed: bool
    text: str


@dataclass(frozen=True)
class Motors(Reply):
    """Whether the motors are powered."""

    enabled: bool


@dataclass(frozen=True)
class Fault(Reply):
    """A fault was raised, or has ended (`cleared`). The line comes at once, or in a list."""

    kind: str
    name: str
    short: str
    long: str
    driving: bool
    critical: bool
    application: bool
    cleared: bool = False


# --- refused commands -----------------------------------------------------------------------------

@dataclass(frozen=True)
class CommandError(Reply):
    """The robot refused a command line. A `CommandErrorDescription` follows, at once or later."""

    command: str


@dataclass(frozen=True)
class CommandErrorDescription(Reply):
    """The reason why the command of the last `CommandError` was refused."""

    text: str


@dataclass(frozen=True)
class UnknownCommand(Reply):
    """The robot has no such command; `name` may be shortened."""

    name: str


@dataclass(frozen=True)
class SetUpError(Reply):
    """A command came in the wrong order, or lacks something that must be set up before."""

    text: str


@dataclass(frozen=True)
class Usage(Reply):
    """A command lacked arguments; `syntax` is the robot's syntax, with the command's name first."""

    syntax: str


# --- the map in use and its objects, and settings of the robot ------------------------------------

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
class MapObjectCoord(Reply):
    """Pose of an object of the map: mm, mm, degrees."""

    name: str
    x: float
    y: float
    heading: float


@dataclass(frozen=True)
class MapChanged(Reply):
    """Another map is in use: its goals differ, and the robot may not know its position."""


@dataclass(frozen=True)
class ConfigValue(Reply):
    """A key of a configuration section, with its value."""

    key: str
    value: str


@dataclass(frozen=True)
class ConfigurationChanged(Reply):
    """A configuration was loaded."""


# --- range devices, inputs and outputs ------------------------------------------------------------

@dataclass(frozen=True, eq=False)
class RangeReading(Reply):
    """Points that a range device sees: (N, 2) int64, mm, in the map frame; read only.

    If `cumulative`, the robot remembers the points for some time; otherwise they are one scan.
    """

    device: str
    points: npt.NDArray[np.int64]
    cumulative: bool = False

    def __eq__(self, other: object) -> bool:
        return (isinstance(other, RangeReading) and self.device == other.device
                and self.cumulative == other.cumulative
                and np.array_equal(self.points, other.points))

    def __hash__(self) -> int:
        return hash((self.device, self.cumulative, self.points.tobytes()))


@dataclass(frozen=True)
class Input(Reply):
    """A digital input or output (`output`). `state`: on, off or broken; '' in a list of names."""

    name: str
    state: str
    output: bool = False


@dataclass(frozen=True)
class ExternalIOUpdate(Reply):
    """Inputs or outputs of an external set have changed."""

    name: str


# --- items, confirmations and notices that are not parsed further; the connection -----------------

@dataclass(frozen=True)
class Item(Reply):
    """An item of a list, not parsed further; `prefix` is the text before the colon."""

    prefix: str
    text: str


@dataclass(frozen=True)
class EndOf(Reply):
    """The end of a list. `what` names the list in lower case: `goals`, `rangedevicelist`, ..."""

    what: str


@dataclass(frozen=True)
class HelpEntry(Reply):
    """A command of the robot's help list."""

    name: str
    description: str


@dataclass(frozen=True)
class Done(Reply):
    """An immediate command was carried out; `text` is the line, e.g. `Reset odometer`."""

    text: str


@dataclass(frozen=True)
class Notice(Reply):
    """A notice that needs no action by a client: `kind` QueueUpdate, PayloadUpdate, Charge, ..."""

    kind: str
    text: str


@dataclass(frozen=True)
class Echo(Reply):
    """Whether the server echoes the commands that it receives."""

    on: bool


@dataclass(frozen=True)
class ServerClosing(Reply):
    """The server is about to close the connection; `text` has the reason."""

    text: str
