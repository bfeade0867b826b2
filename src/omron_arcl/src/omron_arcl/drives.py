"""One record per drive: they tell the driver of the robot, its obedience, and the owed stop.

Read this module first.

The machine keeps one `Record` for each drive and each stop, in the order of sending, and one for
what others did. Everything else is derived from the records and the robot's lines: the giver, the
epoch, the motion, the owed stop. No I/O and no clock.

Fates of a record (`Fate`), and the events that lead from one to the next:

    event                        GIVEN        OBEYED       UNKNOWN      remarks
    the robot acknowledges it    OBEYED       OBEYED       OBEYED       older records are dropped
    the robot refuses it         dropped      -            -            the giver before it stays
    it was never sent            dropped      -            -
    the robot completes it       OVER         OVER         OVER         a stop drops older records
    the robot gives up           dropped      OVER         OVER
    link lost, timeout, restart  UNKNOWN      UNKNOWN      UNKNOWN
    emergency stop               UNKNOWN      UNKNOWN      UNKNOWN      a stop is owed for GIVEN
    another client stops         GIVEN        dropped      dropped      a stop is owed for GIVEN
    another client drives        GIVEN        dropped      dropped      also stops, if none is GIVEN

Derived:
- The *ruling* record is the newest one that is not a drive in the state GIVEN. Its giver drives the
  robot. While its fate is unknown, the published giver is empty.
- An *epoch*, a random number, lasts as long as one giver drives. A new one begins when the ruling
  record becomes a stop, or comes from another giver, another client or the robot itself.
- A stop is owed while its record is not OVER.
- The *last command* of each giver that numbers its commands, and what became of it. So a program
  whose connection broke, or which was restarted, need not guess whether the robot obeys it.

Invariants:
- No drive that names an epoch passes a stop or drive that its giver does not know of.
- A refused command changes no giver. Each drive has a giver, which can stop it.
- No time between two lines decides on their meaning: the order of lines does. See `STOPPINGS`.

docs/reference/omron_controller.md states the limits of what can be known.
"""
from __future__ import annotations

import math
import secrets
from collections import deque
from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from typing import Callable, Deque, Dict, NamedTuple, Optional, Set, Tuple

from omron_arcl.activity import MOVING, STANDING, Activity, ActivityKind, activity_of
from omron_arcl.commands import Command, Course
from omron_arcl.errors import ArclError
from omron_arcl.execution import NO_GIVER, Execution, Giver, Outcome
from omron_arcl.replies import driving, safety, tasks
from omron_arcl.replies.reply import Reply

LOOK = 2.0  # s of a new connection to wait for a status that may make an owed stop unnecessary
RETRY = 1.0  # s between two attempts to send an owed stop
_KEPT_EPOCHS = 100
_KEPT_RECORDS = 20
_KEPT_GIVERS = 20


class Cause(IntEnum):
    """Why a new epoch began; as in omron_ld90_msgs/Motion."""

    OTHER_GIVER = 1
    STOP = 2
    CANCEL = 3
    OTHER_CLIENT = 4
    ROBOT = 5
    EMERGENCY_STOP = 6
    RESTART = 7


class MotionState(IntEnum):
    """The motion of the robot; as in omron_ld90_msgs/Motion."""

    UNKNOWN = 0
    STANDING = 1
    DRIVING = 2
    STOPPING = 3
    DOCKING = 4
    DOCKED = 5
    UNDOCKING = 6
    MANUAL = 7


class Kind(Enum):
    """What a record is about."""

    DRIVE = 'drive'
    STOP = 'stop'
    FOREIGN_DRIVE = 'drive of another client or of the robot itself'
    FOREIGN_STOP = 'stop by another client, by the robot itself or by the emergency stop'


class Fate(Enum):
    """What became of a drive or stop, see the table above."""

    GIVEN = 'given'
    OBEYED = 'obeyed'
    UNKNOWN = 'unknown'
    OVER = 'over'


class CommandFate(IntEnum):
    """What became of the last command of a giver; as in omron_ld90_msgs/LastCommand."""

    GIVEN = 1
    OBEYED = 2
    UNKNOWN = 3
    COMPLETED = 4
    FAILED = 5
    NOT_OBEYED = 6


class Overruled(ArclError):
    """The giver of a command does not know of an earlier command or motion of the robot."""

    def __init__(self, why: str) -> None:
        super().__init__(f'Not sent, another command came first: {why}.')


class Unclear(ArclError):
    """A drive was refused because it is unknown at this moment whether the robot obeys."""


@dataclass(frozen=True)
class Record:
    """One drive or stop, or what others did.

    goal -- the goal for people; names -- the names by which the robot may confirm a drive, in
    lower case: `` if the robot needs no name for it
    """

    number: int
    kind: Kind
    fate: Fate
    giver: Giver = NO_GIVER
    goal: str = ''
    names: Tuple[str, ...] = ()
    words: str = ''
    command: int = 0
    """Number of the command at its giver; 0: the giver does not number its commands."""
    ending: CommandFate = CommandFate.NOT_OBEYED
    """How a drive that is OVER ended."""

    @property
    def command_fate(self) -> CommandFate:
        """What became of its command."""
        if self.fate is not Fate.OVER:
            return CommandFate[self.fate.name]
        return self.ending if self.kind is Kind.DRIVE else CommandFate.COMPLETED

    @property
    def pending(self) -> bool:
        """Whether it is a drive that the robot has not answered."""
        return self.kind is Kind.DRIVE and self.fate is Fate.GIVEN

    @property
    def owed(self) -> bool:
        """Whether it is a stop that the robot has not obeyed."""
        return self.kind is Kind.STOP and self.fate is not Fate.OVER

    @property
    def may_move(self) -> bool:
        """Whether it is a drive that the robot carries out, or may carry out."""
        return self.kind is Kind.DRIVE and self.fate is not Fate.OVER


@dataclass(frozen=True)
class LastCommand:
    """The newest command of a giver that numbers its commands."""

    giver: str
    number: int
    fate: CommandFate


@dataclass(frozen=True)
class Memory:
    """The state that survives a restart: the epoch, why it began, the records, and what became of
    the last command of each giver."""

    epoch: int
    previous_epoch: int = 0
    cause: Cause = Cause.RESTART
    reason: str = ''
    records: Tuple[Record, ...] = ()
    last_commands: Tuple[LastCommand, ...] = ()

    @property
    def ruling(self) -> Optional[Record]:
        """The record whose giver drives the robot."""
        return next((r for r in reversed(self.records) if not r.pending), None)

    @property
    def giver(self) -> Giver:
        """The program that drives or has stopped the robot; empty: none, or unknown."""
        ruling = self.ruling
        return NO_GIVER if ruling is None or ruling.fate is Fate.UNKNOWN else ruling.giver

    @property
    def drives(self) -> bool:
        """Whether a drive, not a stop, was the last that moved or stopped the robot."""
        return self.ruling is not None and self.ruling.kind in (Kind.DRIVE, Kind.FOREIGN_DRIVE)

    @property
    def goal(self) -> str:
        """The goal of the ruling drive."""
        return self.ruling.goal if self.ruling else ''

    @property
    def stop_owed(self) -> bool:
        """Whether the robot has not obeyed a stop yet."""
        return any(record.owed for record in self.records)

    @property
    def names(self) -> Tuple[str, ...]:
        """The names of the goals to which the robot may drive because of us."""
        return tuple(name for record in self.records for name in record.names)


class Motion(NamedTuple):
    """The published state."""

    memory: Memory
    state: MotionState


class _Change(NamedTuple):
    """The end of an epoch: its number, the giver that ended it, and whether by a drive."""

    before: int
    by: Optional[Giver]
    drives: bool


_STATES = {
    ActivityKind.UNKNOWN: MotionState.UNKNOWN, ActivityKind.STOPPING: MotionState.STOPPING,
    ActivityKind.DOCKING: MotionState.DOCKING, ActivityKind.DOCKED: MotionState.DOCKED,
    ActivityKind.UNDOCKING: MotionState.UNDOCKING, ActivityKind.TELEOPERATED: MotionState.MANUAL}
# A robot that is found like this has ended its drive by itself; otherwise, another client did.
_GAVE_UP = (ActivityKind.FAILED, ActivityKind.LOST, ActivityKind.MOTORS_DISABLED)
_DOCK = 'dock'
_UNSEEN = 'during an outage of the link another client may have driven or stopped the robot'
# Lines that say what the robot does from now on; the others are answers, or belong to a command.
_TELLING = (
    driving.GoingTo, driving.GoingToPoint, driving.ArrivedAt, driving.ArrivedAtPoint,
    driving.FailedGoingTo, driving.Stopping, driving.Stopped, driving.Patrolling,
    driving.FinishedPatrolling, driving.Parking, tasks.DoingTask, tasks.CompletedTask,
    tasks.ExecutingMacro, tasks.CompletedMacro, tasks.ExecutingList, tasks.FinishedList,
    safety.EStop)
_REFUSED = (Outcome.REJECTED, Outcome.NO_GOAL, Outcome.UNKNOWN_COMMAND, Outcome.NEVER_SENT,
            Outcome.OVERRULED)


_ENDINGS = {Outcome.SUCCEEDED: CommandFate.COMPLETED, Outcome.FAILED: CommandFate.FAILED}


def _names_of(command: Command) -> Tuple[str, ...]:
    return tuple(goal.casefold() for goal in command.goals) or (
        (_DOCK,) if command.spec.course is Course.INTO_THE_DOCK else ('',))


def draw_epoch() -> int:
    """A new random epoch, never 0."""
    return secrets.randbits(64) or 1


class Drives:
    """The records of one robot. The caller holds one lock over this object and over sending.

    stored -- the memory of the process before this one
    store -- saves the memory for a restart; called before a command that changes it is sent
    """

    def __init__(self, stored: Optional[Memory] = None,
                 store: Callable[[Memory], None] = lambda memory: None,
                 draw: Callable[[], int] = draw_epoch) -> None:
        self._store, self._draw = store, draw
        self._changes: Deque[_Change] = deque(maxlen=_KEPT_EPOCHS)
        self._memory = stored or Memory(0)
        self._number = max((r.number for r in self._memory.records), default=0)
        self._executions: Dict[int, Execution] = {}  # by the number of the record
        self._connected = False
        # Whether nothing shows yet what happened to the robot before this connection.
        self._unseen = stored is not None
        self._activity: Optional[Activity] = None  # of this connection
        self._shown: Optional[Activity] = None  # the same, only from statuses
        self._strange = False  # whether the last status showed a drive that is not ours
        self._emergency = False
        self._unheard_stops = 0  # stops that were sent and whose `Stopping` has not come
        # Whether they are ours, of the `Stopping`s that the next `Stopped` ends.
        self._stoppings: Set[bool] = set()
        self.stopped_by_us = False
        """Whether the last `Stopped` may end a stop of ours."""
        self._replacing = False  # the robot began to stop, perhaps for a newer drive
        self._stops_itself: Optional[SelfStop] = None  # why the robot may say `Stopping` next
        self._docking: Optional[driving.DockingState] = None
        self._look_until = self._retry_at = -math.inf
        self._records = tuple(r if r.fate is Fate.OVER else replace(r, fate=Fate.UNKNOWN)
                              for r in self._memory.records)
        self._begin_epoch(None, Cause.RESTART, 'the controller was started', False)

    # --- derived answers --------------------------------------------------------------------------

    @property
    def motion(self) -> Motion:
        """The state to publish now."""
        return Motion(self._memory, self._state())

    def knows(self, giver: Giver, epoch: int) -> bool:
        """Whether only `giver`, which knows `epoch`, has given commands since that epoch."""
        return epoch == self._memory.epoch or self._others_since(giver, epoch) == ()

    def stop_due(self, now: float) -> bool:
        """Whether the owed stop must be sent now; a later drive under way may make it needless."""
        for record in reversed(self._records):
            if record.owed:
                return (self._connected and record.number not in self._executions
                        and now >= max(self._look_until, self._retry_at))
            if record.may_move and record.number in self._executions:
                return False
        return False

    def check(self, giver: Giver, command: Command, known_epoch: int, number: int = 0) -> None:
        """Raises Overruled or Unclear if a command must not be sent.

        number -- of the command at its giver; a drive that a newer command has overtaken is late
        """
        if number and not command.spec.stops and any(
                last.giver == giver.name and number <= last.number
                for last in self._memory.last_commands):
            raise Overruled(f'it is not newer than the last one of {giver.name}')
        if not known_epoch:
            return
        if command.spec.stops:
            others = self._others_since(giver, known_epoch)
            if others is not None and any(change.drives for change in others):
                raise Overruled(self._memory.reason)
        elif command.spec.moves:
            if not self.knows(giver, known_epoch):
                raise Overruled(self._memory.reason)
            if self._unseen:  # the first status may begin a new epoch
                raise Unclear('Not sent, the robot has not said yet what it does.')
            other = next((r for r in self._records if r.pending and r.giver != giver), None)
            if other:
                raise Unclear(f'Not sent, the robot has not answered {other.words} yet.')
            if self._memory.drives and self._is_in_doubt():
                raise Unclear('Not sent, the robot may have been stopped by another client.')

    def may_send(self, execution: Execution) -> bool:
        """Whether a drive that was given may still be sent to the robot now."""
        return (not execution.known_epoch or not execution.command.spec.moves
                or self.knows(execution.giver, execution.epoch))

    # --- commands ---------------------------------------------------------------------------------

    def given(self, execution: Execution) -> None:
        """A giver gives a command that `check` has accepted; it is not sent yet."""
        command, giver = execution.command, execution.giver
        if self._unseen and (command.spec.drives or command.spec.stops):
            self._unseen = False
            self._begin_epoch(None, Cause.OTHER_CLIENT, _UNSEEN, False)
        if command.spec.drives:
            self._add(Kind.DRIVE, giver, f'"{command.text}" of {giver.name}', execution,
                      goal=command.goals[0] if command.goals else '', names=_names_of(command),
                      command=execution.number)
            self._keep(self._records[-1])
        elif command.spec.stops:
            self._owe(giver, Cause.STOP, f'"stop" of {giver.name}', execution, execution.number)
        execution.epoch = self._memory.epoch

    def cancelled(self, execution: Execution, canceller: Giver) -> None:
        """A giver cancels a drive; cancelling a drive that was replaced stops nothing."""
        newest = next((r for r in reversed(self._records) if r.kind is Kind.DRIVE), None)
        if newest and execution.sent and self._executions.get(newest.number) is execution:
            self._owe(canceller, Cause.CANCEL, f'a cancellation of {canceller.name}')

    def all_cancelled(self, canceller: Giver) -> None:
        """A giver cancels everything before, including drives that have not arrived here yet."""
        words = f'a cancellation of {canceller.name}'
        if any(record.may_move for record in self._records) or self._memory.stop_owed:
            self._owe(canceller, Cause.CANCEL, words)
        else:
            self._records = (self._record(Kind.STOP, canceller, words, fate=Fate.OVER),)
            self._begin_epoch(canceller, Cause.CANCEL, words, False)

    def own_stop_given(self, stop: Execution) -> None:
        """A stop is sent that is owed, or that follows a cancellation."""
        owed = next((r for r in reversed(self._records) if r.owed), None)
        if owed is None or owed.number in self._executions:
            self._owe(stop.giver, Cause.CANCEL, 'a cancellation', stop)
        else:
            self._executions[owed.number] = stop

    def stopped_without_link(self, giver: Giver, number: int = 0) -> None:
        """A stop is given while the robot cannot be reached: it is sent when it can be."""
        self._owe(giver, Cause.STOP, f'"stop" of {giver.name}', None, number)

    def sent(self, execution: Execution) -> None:
        """A command is sent to the robot."""
        if execution.command.spec.stops:
            self._unheard_stops += 1

    # --- progress of commands ---------------------------------------------------------------------

    def acknowledged(self, execution: Execution) -> None:
        """The robot obeys a command; called before older ones end because of it."""
        record = self._record_of(execution)
        if record and record.kind is Kind.DRIVE:
            self._obeyed(record)

    def ended(self, execution: Execution, outcome: Outcome, words: str, now: float) -> None:
        """A command has ended, or could not be sent."""
        record = self._record_of(execution)
        self._executions = {n: e for n, e in self._executions.items() if e is not execution}
        if record is None:  # what came later has ended it already
            return
        if record.kind is Kind.STOP:
            self._retry_at = now + RETRY
            if outcome in (Outcome.SUCCEEDED, Outcome.INTERRUPTED, Outcome.EMERGENCY_STOPPED):
                at = self._records.index(record)
                # this `Stopped` may be that of an older stop, so that drives may still follow
                may_follow = [r for r in self._records[:at] if self._unheard_stops and r.may_move]
                self._records = (*may_follow, replace(record, fate=Fate.OVER),
                                 *self._records[at + 1:])
                self._retry_at = -math.inf
                self._keep()
        elif outcome in _REFUSED or outcome is Outcome.FAILED and record.pending:
            self._drop(record)
        elif outcome is Outcome.EMERGENCY_STOPPED:
            on_its_way = record.pending and execution.sent and execution.rejected_at is None
            self._note_emergency(words)
            if record in self._records:
                self._change(record, Fate.UNKNOWN)
            if on_its_way:  # it may reach the robot when its motors are on again
                self._add(Kind.STOP, NO_GIVER, words)
                self._keep()
        elif outcome in (Outcome.LOST, Outcome.TIMED_OUT):
            self._fate_unknown(record)
            if outcome is Outcome.TIMED_OUT and execution.stop_on_timeout:
                self._owe(execution.giver, Cause.STOP, words)
        elif outcome is Outcome.INTERRUPTED and record is self._records[-1]:
            self._foreign(Cause.OTHER_CLIENT, False, words)
        elif record.pending and outcome is not Outcome.SUCCEEDED:
            if self._unheard_stops:
                self._change(record, Fate.UNKNOWN)
            else:
                self._drop(record)
        else:
            self._change(record, Fate.OVER, _ENDINGS.get(outcome, CommandFate.NOT_OBEYED))

    # --- lines of the robot -----------------------------------------------------------------------

    def linked(self, connected: bool, now: float) -> None:
        """The link to the robot came up, broke, or could not be made."""
        if self._connected and not connected:
            self._unseen, self._emergency = True, False
        self._connected = connected
        self._activity = self._shown = self._stops_itself = self._docking = None
        self._strange = self._replacing = False
        self._stoppings = set()
        self._unheard_stops = 0
        self._look_until = now + LOOK if connected and self._memory.stop_owed else -math.inf

    def said(self, reply: Reply) -> None:
        """The robot sends a line that is no status; called before the line ends commands."""
        if isinstance(reply, driving.Stopping):
            whose = self._whose_stopping()
            self._stoppings.add(whose in ('our stop', 'cleared fault'))
            if whose is None:
                self._foreign_stop('another client of the robot stopped it')
        elif isinstance(reply, driving.Stopped):
            if self._replacing:
                self._foreign_stop('another client of the robot stopped it')
            self._replacing = False
            if False in self._stoppings:  # else the robot's own pair is still to come
                self._stops_itself = None
            self.stopped_by_us = self._stoppings != {False}
            self._stoppings = set()
        elif isinstance(reply, safety.Motors) and reply.enabled:
            self._emergency, self._stops_itself = False, SelfStop.MOTORS_ENABLED
        elif isinstance(reply, safety.Fault) and reply.cleared:
            self._stops_itself = SelfStop.FAULT_CLEARED
        elif isinstance(reply, safety.EStop) and reply.pressed:
            self._note_emergency('emergency stop')
        elif isinstance(reply, driving.DockingStatus):
            self._docking_said(reply)
        if isinstance(reply, _TELLING):
            self._activity = activity_of(reply)
            if self._activity.kind in MOVING:
                self._stops_itself = None

    def _docking_said(self, reply: driving.DockingStatus) -> None:
        """A docking state is also an answer, so that only a change says what the robot does."""
        before, self._docking = self._docking, reply.docking
        if before is reply.docking:
            return
        if reply.docking is not driving.DockingState.UNDOCKED:
            self._activity = activity_of(reply)
        elif before is driving.DockingState.UNDOCKING:
            self._activity, self._stops_itself = activity_of(reply), SelfStop.UNDOCKED

    def set_out(self, reply: Reply, text: str) -> None:
        """The robot begins a motion that no command under way asked for."""
        activity = activity_of(reply)
        if self._may_be_ours(activity) and (activity.goal or not self._executions):
            self._late_acknowledgement(activity)
        else:
            self._foreign(Cause.ROBOT if activity.kind is ActivityKind.DOCKING
                          and not self._executions else Cause.OTHER_CLIENT, True, text)

    def showed(self, activity: Activity, text: str) -> None:
        """The robot sends a status."""
        before, self._shown = self._shown, activity
        self._activity = activity
        kind = activity.kind
        if kind is ActivityKind.EMERGENCY_STOP:
            self._note_emergency(text)
        elif kind not in (ActivityKind.UNKNOWN, ActivityKind.MOTORS_DISABLED):
            self._emergency = False
        if self._unseen:
            self._first_shown(activity, text)
        elif not self._executions:
            self._idle_shown(before, activity, text)
        self._look_until = -math.inf

    def _first_shown(self, activity: Activity, text: str) -> None:
        """The first status after an outage tells whether the robot still obeys our drive."""
        self._unseen = False
        record = self._shown_drive(activity)
        if record is not None:
            owed = self._memory.stop_owed and record.number < max(
                r.number for r in self._records if r.owed)
            if not owed:
                moves = activity.kind in MOVING
                self._records = (replace(record, fate=Fate.OBEYED if moves else Fate.OVER,
                                         ending=CommandFate.COMPLETED),)
                self._keep()
        elif not self._emergency:
            words = f'after an outage the robot shows "{text}"'
            if self._is_as_we_stopped_it(activity):
                self._begin_epoch(None, Cause.RESTART, words, False)
            else:
                self._foreign(Cause.ROBOT if activity.kind in _GAVE_UP else Cause.OTHER_CLIENT,
                              activity.kind in MOVING, words)

    def _is_as_we_stopped_it(self, activity: Activity) -> bool:
        """Whether our last command was a stop, and the robot shows nothing else."""
        last = self._records[-1] if self._records else None
        return (activity.kind is ActivityKind.STOPPED and last is not None
                and last.kind is Kind.STOP and last.fate is Fate.OVER)

    def _idle_shown(self, before: Optional[Activity], activity: Activity, text: str) -> None:
        """No command of ours is under way: another client caused the robot's motion."""
        memory = self._memory
        if (before is not None and before.kind is ActivityKind.ARRIVED_AT_GOAL
                and memory.drives and before.goal.casefold() in memory.names
                and activity.kind in (ActivityKind.STOPPED, ActivityKind.STOPPING)):
            self._foreign(Cause.OTHER_CLIENT, False, text)
        ruling = memory.ruling
        elsewhere = activity.kind in MOVING and not self._may_be_ours(activity) and not (
            ruling is not None and ruling.kind is Kind.FOREIGN_DRIVE)
        if ruling is not None and ruling.kind is Kind.DRIVE and ruling.fate is Fate.OBEYED:
            # its command ended as lost with the link before, so that only statuses show its end
            if activity.kind not in MOVING and self._shown_drive(activity) is ruling:
                self._change(ruling, Fate.OVER, CommandFate.COMPLETED)
            elsewhere = elsewhere or activity.kind in STANDING and not self._shown_drive(activity)
        if elsewhere and self._strange:  # one status may have crossed a line
            self._foreign(Cause.OTHER_CLIENT, activity.kind in MOVING, text)
        self._strange = elsewhere

    # --- whose `Stopping` is it? ------------------------------------------------------------------

    def _whose_stopping(self) -> Optional[str]:
        """The name of the first row of STOPPINGS that holds; None: of another client."""
        name = next((name for name, holds in STOPPINGS.items() if holds(self)), None)
        if name == 'our stop':
            self._unheard_stops = max(self._unheard_stops - 1, 0)
        elif name == 'cleared fault':
            self._stops_itself = None  # no `Stopped` of its own follows
        self._replacing = name == 'replacement'
        return name

    def _stops_for_us(self) -> bool:
        return self._unheard_stops > 0

    def _stops_to_replace(self) -> bool:
        moving = self._activity is not None and self._activity.kind not in STANDING
        return moving and any(r.pending and r.number in self._executions for r in self._records)

    def _stops_between_attempts(self) -> bool:
        return any(self._executions[n].command.spec.course in (
                       Course.INTO_THE_DOCK, Course.OUT_OF_THE_DOCK)
                   or self._executions[n].set_out and not self._executions[n].begun
                   for n in self._executions)

    def _foreign_stop(self, words: str) -> None:
        """Another client stopped the robot. A drive that the robot has not answered will reach it
        after that, so that a stop is owed."""
        crosses = any(r.pending and self._was_sent(r) for r in self._records)
        self._foreign(Cause.OTHER_CLIENT, False, words)
        if crosses:
            self._add(Kind.STOP, NO_GIVER, words)
            self._keep()

    def _was_sent(self, record: Record) -> bool:
        execution = self._executions.get(record.number)
        return execution is not None and execution.sent

    # --- records and epochs -----------------------------------------------------------------------

    def _record(self, kind: Kind, giver: Giver, words: str, fate: Fate = Fate.GIVEN,
                goal: str = '', names: Tuple[str, ...] = (), command: int = 0) -> Record:
        self._number += 1
        return Record(self._number, kind, fate, giver, goal, names, words, command)

    def _add(self, kind: Kind, giver: Giver, words: str, execution: Optional[Execution] = None,
             fate: Fate = Fate.GIVEN, goal: str = '', names: Tuple[str, ...] = (),
             command: int = 0) -> None:
        record = self._record(kind, giver, words, fate, goal, names, command)
        self._records = (*self._records, record)[-_KEPT_RECORDS:]
        if execution:
            self._executions[record.number] = execution

    def _record_of(self, execution: Execution) -> Optional[Record]:
        return next((r for r in self._records
                     if self._executions.get(r.number) is execution), None)

    def _change(self, record: Record, fate: Fate,
                ending: CommandFate = CommandFate.NOT_OBEYED) -> None:
        self._records = tuple(replace(r, fate=fate, ending=ending) if r is record else r
                              for r in self._records)
        self._keep()

    def _drop(self, record: Record) -> None:
        self._records = tuple(r for r in self._records if r is not record)
        self._keep()

    def _obeyed(self, record: Record) -> None:
        """The robot carries a drive out: what came before it is over, and its giver drives."""
        if record.fate is Fate.OBEYED:
            return
        ruling, at = self._memory.ruling, self._records.index(record)
        self._replacing = False
        # the robot answers in order: all stops sent before are answered, and none sent after
        self._unheard_stops = sum(r.kind is Kind.STOP and (
            r.fate is Fate.OVER or self._was_sent(r)) for r in self._records[at + 1:])
        self._records = (replace(record, fate=Fate.OBEYED), *(
            r for r in self._records[at + 1:] if r.kind in (Kind.DRIVE, Kind.STOP)))
        self._rules(record, ruling)

    def _rules(self, record: Record, ruling: Optional[Record]) -> None:
        """A drive becomes the ruling record. A new epoch begins, unless the same giver drives on,
        or something newer rules."""
        now_ruling = next(r for r in reversed(self._records) if not r.pending)
        if now_ruling.number != record.number or (
                ruling is not None and (ruling.kind, ruling.giver) == (Kind.DRIVE, record.giver)
                and self._memory.cause is Cause.OTHER_GIVER):
            self._keep()
        else:
            self._begin_epoch(record.giver, Cause.OTHER_GIVER, record.words, True)

    def _fate_unknown(self, record: Record) -> None:
        """It is unknown whether the robot carries a drive out: its giver may be the driver."""
        ruling = self._memory.ruling
        self._change(record, Fate.UNKNOWN)
        if record.pending:
            self._rules(record, ruling)

    def _late_acknowledgement(self, activity: Activity) -> None:
        """The robot sets out for a drive of ours whose command has ended for its giver."""
        record = next((r for r in reversed(self._records) if r.fate is Fate.UNKNOWN
                       and activity.goal.casefold() in r.names), None)
        if record and not self._memory.stop_owed:
            self._obeyed(record)

    def _owe(self, giver: Giver, cause: Cause, words: str,
             execution: Optional[Execution] = None, command: int = 0) -> None:
        """A stop is owed from now on. A stop that is owed already ends the same drives, unless a
        drive came after it."""
        last = next((r for r in reversed(self._records)
                     if r.kind in (Kind.DRIVE, Kind.STOP)), None)
        self._retry_at = -math.inf  # the stop is new, so it need not wait for a retry
        if last and last.owed and not (execution and last.number in self._executions):
            self._records = (*(r for r in self._records if r is not last),
                             replace(last, giver=giver, words=words, command=command))
            if execution:
                self._executions[last.number] = execution
        else:
            self._add(Kind.STOP, giver, words, execution, command=command)
        # it ends a drive that is on its way, of which its giver need not know
        ends_unknown = any(r.pending and r.giver != giver for r in self._records)
        self._begin_epoch(None if ends_unknown else giver, cause, words, False, self._records[-1])

    def _foreign(self, cause: Cause, drives: bool, words: str) -> None:
        """Others drive or stop the robot. Drives that the robot has not answered may still reach it
        after that, and so may the stops that end them."""
        given = any(r.pending for r in self._records)
        self._records = (
            *(r for r in self._records if r.pending or r.owed and (given or not drives)),
            self._record(Kind.FOREIGN_DRIVE if drives else Kind.FOREIGN_STOP, NO_GIVER, words,
                         Fate.OVER))
        self._begin_epoch(None, cause, words, drives)

    def _note_emergency(self, words: str) -> None:
        if not self._emergency:
            self._emergency = True
            self._foreign(Cause.EMERGENCY_STOP, False, words)

    def _begin_epoch(self, giver: Optional[Giver], cause: Cause, reason: str, drives: bool,
                     given: Optional[Record] = None) -> None:
        before = self._memory.epoch
        self._changes.append(_Change(before, giver, drives))
        self._memory = replace(self._memory, epoch=self._draw(), previous_epoch=before, cause=cause,
                               reason=reason)
        self._keep(given)

    def _keep(self, given: Optional[Record] = None) -> None:
        """Stores the memory. `given`: a command that was given just now."""
        last = self._memory.last_commands
        if given and given.command:
            last = (*(one for one in last if one.giver != given.giver.name),
                    LastCommand(given.giver.name, given.command, CommandFate.GIVEN))
        self._memory = replace(
            self._memory, records=self._records,
            last_commands=tuple(replace(one, fate=self._fate_of(one)) for one in last)[
                -_KEPT_GIVERS:])
        self._store(self._memory)

    def _fate_of(self, last: LastCommand) -> CommandFate:
        record = next((r for r in reversed(self._records)
                       if (r.giver.name, r.command) == (last.giver, last.number)), None)
        if record is not None:
            return record.command_fate
        return last.fate if last.fate in _ENDINGS.values() else CommandFate.NOT_OBEYED

    def _others_since(self, giver: Giver, epoch: int) -> Optional[Tuple[_Change, ...]]:
        """What other givers did since `epoch`; None if that epoch is not remembered any more."""
        if epoch == self._memory.epoch:
            return ()
        others = []
        for change in reversed(self._changes):
            if change.by != giver:
                others.append(change)
            if change.before == epoch:
                return tuple(others)
        return None

    # --- the robot's motion -----------------------------------------------------------------------

    def _state(self) -> MotionState:
        if not self._connected or self._activity is None:
            return MotionState.UNKNOWN
        kind = self._activity.kind
        commands = [execution.command.spec for execution in self._executions.values()]
        if any(spec.stops for spec in commands) and kind not in (
                ActivityKind.DOCKED, ActivityKind.UNDOCKING):
            return MotionState.STOPPING
        if kind in STANDING and kind is not ActivityKind.DOCKED:
            return MotionState.DRIVING if commands else MotionState.STANDING
        return _STATES.get(kind, MotionState.DRIVING)

    def _shown_drive(self, activity: Activity) -> Optional[Record]:
        """The drive that the robot visibly carries out, or has visibly completed."""
        if activity.kind in MOVING and not self._may_be_ours(activity):
            return None
        goal = activity.goal.casefold()
        name = {ActivityKind.ARRIVED_AT_GOAL: goal, ActivityKind.GOING_TO_GOAL: goal,
                ActivityKind.DOCKED: _DOCK, ActivityKind.ARRIVED_AT_POINT: '',
                ActivityKind.STOPPED: goal or None}.get(activity.kind)
        over = max((i for i, r in enumerate(self._records)
                    if r.kind is Kind.STOP and r.fate is Fate.OVER), default=-1)
        drives = [r for r in reversed(self._records[over + 1:]) if r.kind is Kind.DRIVE and (
            r.fate is not Fate.OVER or activity.kind not in MOVING)]
        named = [r for r in drives if name in r.names]
        return next(iter(named or (drives if activity.kind in MOVING else [])), None)

    def _may_be_ours(self, activity: Activity) -> bool:
        """Whether a command of ours may have caused this motion of the robot.

        Decides by the motion's goal. A motion without a name may be ours while a drive of ours is
        under way, or while the outcome of our last drive is unknown.
        """
        names = self._memory.names
        if activity.kind is ActivityKind.TELEOPERATED:
            return False
        if activity.kind is ActivityKind.DOCKING:
            return _DOCK in names
        is_named = activity.kind is ActivityKind.GOING_TO_GOAL
        if is_named and activity.goal.casefold() in names:
            return True
        return any(record.may_move and (not is_named or '' in record.names or _DOCK in record.names)
                   for record in self._records)

    def _is_in_doubt(self) -> bool:
        return any(execution.begun and execution.doubt is not None
                   and execution.doubt.outcome is Outcome.INTERRUPTED
                   for execution in list(self._executions.values())[-1:])


class SelfStop(Enum):
    """Why a robot may say `Stopping` by itself."""

    UNDOCKED = 'it has left its dock'
    MOTORS_ENABLED = 'its motors were enabled'
    FAULT_CLEARED = 'a fault was cleared'


# Whose is a `Stopping`? The first row that holds decides; without one, another client stopped the
# robot. The pages are those of OMRON's ARCL manual I617-E-01, or of I617-E-02 where it is named.
STOPPINGS: Dict[str, Callable[[Drives], bool]] = {
    # p. 242: `stop` is answered by `Stopping`, `Stopped`, once for each `stop`.
    'our stop': Drives._stops_for_us,
    # p. 245: a robot that has undocked says `Stopping`, `Stopped`, possibly after the result.
    'undocked': lambda drives: drives._stops_itself is SelfStop.UNDOCKED,
    # p. 190: the same pair follows `Motors enabled`.
    'motors enabled': lambda drives: drives._stops_itself is SelfStop.MOTORS_ENABLED,
    # p. 66: clearing a fault prints `Stopping` alone.
    'cleared fault': lambda drives: drives._stops_itself is SelfStop.FAULT_CLEARED,
    # I617-E-02 p. 71: a robot that misses its dock stops, and tries again.
    'attempt to dock': Drives._stops_between_attempts,
    # Some robots stop for an instant to replace a drive; a `Stopped` shows that it was no such.
    'replacement': Drives._stops_to_replace,
}
