"""The values of `drives`: the record of a drive or stop, the stored and the published state."""
from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, IntEnum
from typing import NamedTuple, Optional, Tuple

from omron_arcl.execution import NO_GIVER, Giver, Outcome


class MotionCause(IntEnum):
    """Why a new epoch began, with the numbers of omron_ld90_msgs/Motion."""

    OTHER_GIVER = 1
    STOP = 2
    CANCEL = 3
    OTHER_CLIENT = 4
    ROBOT = 5
    EMERGENCY_STOP = 6
    RESTART = 7
    INTERRUPTED = 8


class MotionState(IntEnum):
    """The motion of the robot, with the numbers of omron_ld90_msgs/Motion."""

    UNKNOWN = 0
    STANDING = 1
    DRIVING = 2
    STOPPING = 3
    DOCKING = 4
    DOCKED = 5
    UNDOCKING = 6
    MANUAL = 7


_DRIVES = (MotionState.DRIVING, MotionState.STOPPING, MotionState.DOCKING, MotionState.UNDOCKING)


class RecordKind(Enum):
    """What a record is about."""

    DRIVE = 'drive'
    STOP = 'stop'
    FOREIGN_DRIVE = 'drive of another client or of the robot itself'
    FOREIGN_STOP = 'stop by another client, by the robot itself or by the emergency stop'


_DRIVEN = (RecordKind.DRIVE, RecordKind.FOREIGN_DRIVE)


class Fate(Enum):
    """The fate of a drive or stop; see the table in `drives`."""

    GIVEN = 'given'
    OBEYED = 'obeyed'
    UNKNOWN = 'unknown'
    OVER = 'over'


class CommandFate(IntEnum):
    """The fate of the last command of a giver, with the numbers of omron_ld90_msgs/LastCommand."""

    GIVEN = 1
    OBEYED = 2
    UNKNOWN = 3
    COMPLETED = 4
    FAILED = 5
    NOT_OBEYED = 6


@dataclass(frozen=True)
class Doubt:
    """The robot reports an activity that contradicts a command.

    since -- when an activity first contradicted the command
    why -- the robot's words for this activity
    outcome -- how the command ends if the doubt lasts
    count -- how often an activity contradicted the command
    broken_off -- an unclear interruption was among the contradictions; see `drives`
    is_certain -- the robot said `Stopped` after the unclear interruption
    """

    since: float
    why: str
    outcome: Outcome
    count: int = 1
    broken_off: bool = False
    is_certain: bool = False


@dataclass(frozen=True)
class DriveRecord:
    """One drive or stop of ours, or the newest motion or stop that others caused.

    All that is known about a drive is in this one value, because its parts change together.

    goal -- the goal as people read it
    names -- the names with which the robot may confirm a drive, in lower case; an empty name means
        that the robot confirms the drive without a name
    """

    number: int
    kind: RecordKind
    fate: Fate
    giver: Giver = NO_GIVER
    goal: str = ''
    names: Tuple[str, ...] = ()
    words: str = ''
    command: int = 0
    """The number that the giver gave to the command; 0: the giver does not number its commands."""
    ending: CommandFate = CommandFate.NOT_OBEYED
    """How a drive that is OVER ended."""
    shown: str = ''
    """For a drive of others: the motion that the robot showed; the drive is recognised by it.
    For a stop: `DOCKED` and the dock, if the robot has shown after the stop that it is docked.
    """
    acknowledged_by: str = ''
    """The line or status by which the robot acknowledged a drive."""
    verb: str = ''
    """The name of the command of a drive, such as `goto`."""
    stands_for: Tuple[Tuple[str, int], ...] = ()
    """Giver and number of each earlier stop that this stop has replaced; they share its fate."""
    is_cancelled: bool = False
    """Whether the giver has cancelled this drive while a newer drive was about to replace it."""
    order: int = field(default=0, compare=False)
    """The number of its command in the order of sending on this connection; 0: the command was not
    sent on this connection. It is not stored.
    """
    doubt: Optional[Doubt] = field(default=None, compare=False)
    """Set while the robot seems not to obey a command under way. It is not stored."""

    @property
    def commands(self) -> Tuple[Tuple[str, int], ...]:
        """Giver and number of each command whose fate this record shows."""
        return ((self.giver.name, self.command), *self.stands_for)

    @property
    def command_fate(self) -> CommandFate:
        """The fate of the commands of this record."""
        if self.fate is not Fate.OVER:
            return CommandFate[self.fate.name]
        return self.ending if self.kind is RecordKind.DRIVE else CommandFate.COMPLETED

    @property
    def pending(self) -> bool:
        """Whether this is a drive that the robot has not answered."""
        return self.kind is RecordKind.DRIVE and self.fate is Fate.GIVEN

    @property
    def was_broken_off(self) -> bool:
        """Whether this drive ended before its goal, although the robot did not give up."""
        return (self.kind is RecordKind.DRIVE and self.fate is Fate.OVER
                and self.ending is CommandFate.NOT_OBEYED)

    @property
    def owed(self) -> bool:
        """Whether this is a stop that the robot has not obeyed."""
        return self.kind is RecordKind.STOP and self.fate is not Fate.OVER

    @property
    def may_move(self) -> bool:
        """Whether this is a drive that the robot carries out, or may carry out."""
        return self.kind is RecordKind.DRIVE and self.fate is not Fate.OVER


@dataclass(frozen=True)
class LastCommand:
    """The newest command of a giver that numbers its commands.

    foreign_epoch -- the newest epoch that this giver did not begin, but another giver, another
        client, the robot itself or its emergency stop
    """

    giver: str
    number: int
    fate: CommandFate
    foreign_epoch: int = 0


@dataclass(frozen=True)
class DriveMemory:
    """The state that survives a restart: the epoch, why it began, the records, and the fate of the
    last command of each giver.

    foreign_epoch -- the foreign epoch of givers that have no last command; see `LastCommand`. It is
        the newest epoch that began for another reason than a start of the controller
    """

    epoch: int
    previous_epoch: int = 0
    foreign_epoch: int = 0
    cause: MotionCause = MotionCause.RESTART
    reason: str = ''
    records: Tuple[DriveRecord, ...] = ()
    last_commands: Tuple[LastCommand, ...] = ()

    @property
    def ruling(self) -> Optional[DriveRecord]:
        """The record whose giver drives the robot."""
        return next((r for r in reversed(self.records) if not r.pending), None)

    @property
    def giver(self) -> Giver:
        """The program that drives the robot, or has stopped it; empty: none, or unknown."""
        ruling = self.ruling
        return NO_GIVER if ruling is None or ruling.fate is Fate.UNKNOWN else ruling.giver

    @property
    def drives(self) -> bool:
        """Whether the ruling record is a drive (of ours or of others), not a stop."""
        return self.ruling is not None and self.ruling.kind in _DRIVEN

    @property
    def goal(self) -> str:
        """The goal of the ruling record (see `drives`); empty if it has none."""
        return self.ruling.goal if self.ruling else ''

    @property
    def stop_owed(self) -> bool:
        """Whether the robot has not obeyed a stop yet."""
        return any(record.owed for record in self.records)

    @property
    def names(self) -> Tuple[str, ...]:
        """The names of all drives in the records."""
        return tuple(name for record in self.records for name in record.names)


class RobotMotion(NamedTuple):
    """The state of the robot's motion that is published."""

    memory: DriveMemory
    state: MotionState
    emergency_stop: bool

    @property
    def is_driving(self) -> bool:
        """Whether the robot drives, or has been told to."""
        return self.state in _DRIVES or any(
            record.kind is RecordKind.DRIVE and record.fate in (Fate.GIVEN, Fate.OBEYED)
            for record in self.memory.records)
