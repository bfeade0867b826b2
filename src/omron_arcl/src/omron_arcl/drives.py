"""The records of drives and stops: which giver drives the robot, and which stop is owed.

Read this module first.

The module keeps one `DriveRecord` for each drive and each stop, in the order of sending. It keeps
one more record for the newest motion or stop that others caused. From the records and from the
robot's lines (`heard`), the module derives the giver, the epoch, the motion, the owed stop, and the
fate of each program's last command. It has no I/O and no clock. `attribution` decides with one
table which command a line of the robot is about, and reports the events to this module.

A newer drive, stop or event replaces older records. A replaced record is dropped: nothing is
derived from it any more. But if its command is still under way for its giver, the record is kept
aside until the command ends. A command *ends for its giver* when the giver gets its result; the
robot may still obey the command, or still have to answer it. An open record is never dropped to
save room. Instead, while the robot has MOST_OPEN drives to carry out or to answer, a further drive
is refused. If several stops are owed between two drives, the newest may replace the others; its
record then has their common fate.

A drive has a fate. An event (`Event`) changes it as follows:

    event                        GIVEN        OBEYED       UNKNOWN      remark
    ACKNOWLEDGED by the robot    OBEYED       OBEYED       OBEYED       older records are dropped
    COMPLETED by the robot       OVER         OVER         OVER         ACKNOWLEDGED comes first
    REFUSED, or never sent       dropped      dropped      dropped      the giver stays the same
    FAILED: the robot gave up    dropped      OVER         OVER
    WITHDRAWN by its giver, or   dropped      OVER         OVER
    broken off by the robot
    CALLED_BACK                  UNKNOWN      OVER         OVER         WITHDRAWN while some stop is
                                                                        unanswered: the robot may
                                                                        still obey the drive
    LOST: link, silence, restart UNKNOWN      UNKNOWN      UNKNOWN
    EMERGENCY_STOP               UNKNOWN      UNKNOWN      UNKNOWN      from GIVEN: a stop is owed
    DOUBTED: an activity of the  GIVEN        OBEYED       UNKNOWN      the doubt begins, or the
    robot contradicts it                                                activity is counted
    CONFIRMED by an activity     GIVEN        OBEYED       UNKNOWN      the doubt is over
    another client stops         GIVEN        dropped      dropped      if GIVEN: a stop is owed
    another client drives        GIVEN        dropped      dropped      if no drive is GIVEN, owed
                                                                        stops are dropped as well

In the last two rows, an UNKNOWN drive that the robot has still to answer is kept like a GIVEN one.

A stop is GIVEN until the robot stands after it. Then the stop is OVER, and the records before it
are dropped. A stop that failed or was lost is sent again.

The record of a command under way may have a *doubt*, which says since when and why the robot seems
not to obey the command. `judgements` decides what an activity of the robot means for a command. A
doubt begins anew if the robot first seems to have completed the command and then seems to have
ended it in another way, or the reverse. A doubt ends the command after SETTLE s if at least two
activities contradict the command; if only one does, SETTLE_ONCE s later. There is one exception:
`Stopped` ends the command at once after an *unclear interruption*. This is an `Interrupted` that
names no goal, or that comes before the robot has acknowledged the drive.

Derived values and rules:
- The *ruling* record is the newest record that is not a GIVEN drive. Its giver drives the robot.
  While the fate of the ruling record is UNKNOWN, the published giver is empty.
- An *epoch* is a period in which one giver drives the robot; a random number names it. A new epoch
  begins when the ruling record becomes a stop, or becomes a record of another giver, of another
  client or of the robot itself.
- A motion of the robot belongs to a drive if both have the same name. A motion without the name of
  a goal belongs to a drive without the name of a goal, also after an outage.
- A drive that the robot has acknowledged does not set out again after the robot has obeyed a stop,
  or has broken off the drive. After such a stop, older drives do not set out either. A later motion
  to the same goal is that of another client.
- If the robot breaks off a drive (`Interrupted`), a new epoch begins at once. The reason may be an
  emergency stop or another client, so the robot's next line or status about its motion begins
  another epoch. Until that line or status, drives that name an epoch are refused. They are also
  refused after the robot has broken off a drive of another client, until the robot says more.
- A stop is owed while its record is not OVER.
- A stop is also owed if three events happened: a giver gave a newer drive and cancelled the older
  one (`is_cancelled`); the newer drive was lost; the robot carries out the older one.
- While a drive that has begun is doubted because another client may have stopped the robot, no
  drive that names an epoch is sent.
- The *last command* of each giver that numbers its commands is kept with its fate. So a program
  can read, after a restart or a broken connection, whether the robot obeys its last command.
- The *foreign epoch* of each such giver is the newest epoch that this giver did not begin. A giver
  begins an epoch by a drive (even if the drive is lost), a stop or a cancellation. But if the stop
  or cancellation ends a drive of another giver that is still on its way, the epoch is foreign to
  all givers. Two kinds of epoch are foreign to no giver, because no giver acted. The first kind
  begins when the controller starts with its memory. The second kind begins after an outage if the
  robot stands as we stopped it. A program that missed some epochs can tell from this one value
  whether one of them was foreign.

Invariants:
- No drive that names an epoch is sent after a stop or drive that its giver does not know of.
- A drive that the robot obeys or has still to answer is never forgotten, nor is an owed stop. A
  stop is never refused because there are too many commands.
- A command that the robot refuses does not change the giver. Each drive has a giver that can stop
  it.
- Each event that interrupts, cancels or overrules the last drive of a giver begins a new epoch, at
  the latest when the robot has answered all drives.
- The order of the robot's lines decides their meaning; the time between two lines never does. The
  robot answers in the order of sending. This includes commands that ended for their givers before
  the robot read them.
- An activity that contradicts a command ends it only after a doubt of SETTLE s. The exceptions are
  lines about the command itself, and `Stopped` after an unclear interruption.

docs/reference/omron_controller.md states the limits of what can be known.
"""
from __future__ import annotations

import math
import secrets
from collections import deque
from dataclasses import replace
from enum import Enum
from typing import (
    Any,
    Callable,
    Deque,
    Dict,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Tuple,
    TypeVar,
)

from omron_arcl import replies
from omron_arcl.activity import HALTED, MOVING, STANDING, Activity, ActivityKind
from omron_arcl.command_table import spec_of
from omron_arcl.commands import Command, DriveCourse
from omron_arcl.errors import ArclError, Busy
from omron_arcl.execution import NO_GIVER, Execution, Giver, Outcome
from omron_arcl.heard import RobotWords, StopOf
from omron_arcl.judgements import DriveSign, Observation, is_settled, judge, next_doubt
from omron_arcl.records import (
    CommandFate,
    Doubt,
    DriveMemory,
    DriveRecord,
    Fate,
    LastCommand,
    MotionCause,
    MotionState,
    RecordKind,
    RobotMotion,
)
from omron_arcl.replies import Reply

LOOK = 2.0  # s after connecting in which a status may still make an owed stop unnecessary
RETRY = 1.0  # s between two attempts to send an owed stop
_KEPT_EPOCHS = 100
MOST_OPEN = 20  # maximum number of drives that the robot carries out or has to answer
_KEPT_RECORDS = _KEPT_GIVERS = 20  # beyond these numbers, only open records are kept


class Event(Enum):
    """What happens to a drive of ours; see the table above."""

    ACKNOWLEDGED = 'acknowledged'
    COMPLETED = 'completed'
    REFUSED = 'refused'
    FAILED = 'failed'
    WITHDRAWN = 'withdrawn'
    CALLED_BACK = 'called back'
    LOST = 'lost'
    EMERGENCY_STOP = 'emergency stop'
    DOUBTED = 'doubted'
    CONFIRMED = 'confirmed'


_T = TypeVar('_T')
_Next = Optional[Fate]  # None: the record is dropped
TRANSITIONS: Mapping[Event, Tuple[_Next, _Next, _Next]] = {
    #                      from GIVEN    from OBEYED   from UNKNOWN
    Event.ACKNOWLEDGED:   (Fate.OBEYED,  Fate.OBEYED,  Fate.OBEYED),
    Event.COMPLETED:      (Fate.OVER,    Fate.OVER,    Fate.OVER),
    Event.REFUSED:        (None,         None,         None),
    Event.FAILED:         (None,         Fate.OVER,    Fate.OVER),
    Event.WITHDRAWN:      (None,         Fate.OVER,    Fate.OVER),
    Event.CALLED_BACK:    (Fate.UNKNOWN, Fate.OVER,    Fate.OVER),
    Event.LOST:           (Fate.UNKNOWN, Fate.UNKNOWN, Fate.UNKNOWN),
    Event.EMERGENCY_STOP: (Fate.UNKNOWN, Fate.UNKNOWN, Fate.UNKNOWN),
    Event.DOUBTED:        (Fate.GIVEN,   Fate.OBEYED,  Fate.UNKNOWN),
    Event.CONFIRMED:      (Fate.GIVEN,   Fate.OBEYED,  Fate.UNKNOWN),
}
_FROM = (Fate.GIVEN, Fate.OBEYED, Fate.UNKNOWN)
REFUSED = (Outcome.REJECTED, Outcome.NO_GOAL, Outcome.UNKNOWN_COMMAND)
"""The outcomes of a command that the robot refuses."""
_EVENTS: Mapping[Outcome, Event] = {
    Outcome.SUCCEEDED: Event.COMPLETED, Outcome.FAILED: Event.FAILED,
    **dict.fromkeys((*REFUSED, Outcome.NEVER_SENT, Outcome.OVERRULED), Event.REFUSED),
    Outcome.INTERRUPTED: Event.WITHDRAWN, Outcome.CANCELLED: Event.WITHDRAWN,
    Outcome.LOST: Event.LOST, Outcome.TIMED_OUT: Event.LOST,
    Outcome.EMERGENCY_STOPPED: Event.EMERGENCY_STOP}
_ENDINGS = {Event.COMPLETED: CommandFate.COMPLETED, Event.FAILED: CommandFate.FAILED}
_DECIDED = (*_ENDINGS.values(), CommandFate.NOT_OBEYED)
UNHEEDED = (Outcome.TIMED_OUT, Outcome.REJECTED, Outcome.UNKNOWN_COMMAND)
"""The outcomes of a stop that the robot does not obey."""
# After one of these outcomes of a stop, the robot need not obey the stop any more.
_OBEYED_STOP = (Outcome.SUCCEEDED, Outcome.INTERRUPTED, Outcome.EMERGENCY_STOPPED)

_STATES = {
    ActivityKind.UNKNOWN: MotionState.UNKNOWN, ActivityKind.STOPPING: MotionState.STOPPING,
    ActivityKind.DOCKING: MotionState.DOCKING, ActivityKind.DOCKED: MotionState.DOCKED,
    ActivityKind.UNDOCKING: MotionState.UNDOCKING, ActivityKind.TELEOPERATED: MotionState.MANUAL}
# These activities show that the robot ended its drive by itself. If a drive of ours has ended with
# another activity, another client ended it.
_GAVE_UP = (ActivityKind.FAILED, ActivityKind.LOST, ActivityKind.MOTORS_DISABLED)
_NEVER_OURS = (ActivityKind.TELEOPERATED, ActivityKind.PARKING)
# These motions name no goal, so any drive may be the cause; see `_is_to_be_stopped`.
_WITHOUT_A_GOAL = MOVING - {
    ActivityKind.GOING_TO_GOAL, ActivityKind.DOCKING, ActivityKind.TELEOPERATED}
_DOCK = 'dock'
_UNSEEN = 'during an outage of the link another client may have driven or stopped the robot'
_STOPPED_BY_OTHERS = 'another client of the robot stopped it'
_NOTHING = DriveRecord(0, RecordKind.FOREIGN_STOP, Fate.OVER)


class Overruled(ArclError):
    """A command was refused: its giver does not know of an earlier command or motion."""

    def __init__(self, why: str) -> None:
        super().__init__(f'Not sent, another command came first: {why}.')


class Unclear(ArclError):
    """A drive was refused because it is unknown at present which giver the robot obeys."""


class _Change(NamedTuple):
    """The end of an epoch.

    before -- the epoch that ended
    by -- the giver that ended it; None: no giver did, or all givers must learn of it
    drives -- whether a drive ended it
    """

    before: int
    by: Optional[Giver]
    drives: bool


def names_of(command: Command) -> Tuple[str, ...]:
    """Returns the names by which the robot may confirm a drive; see `DriveRecord`."""
    return tuple(goal.casefold() for goal in command.goals) or (
        (_DOCK,) if command.spec.course is DriveCourse.INTO_THE_DOCK else ('',))


def _shortened(values: Tuple[_T, ...], most: int, needless: Sequence[_T]) -> Tuple[_T, ...]:
    """Returns the values. If there are more than `most`, the oldest of `needless` are left out."""
    dropped = needless[:max(len(values) - most, 0)]
    return tuple(value for value in values if value not in dropped)


def _shown(activity: Activity) -> str:
    return f'{activity.kind.name} {activity.goal.casefold()}'


def _name_of(activity: Activity) -> Optional[str]:
    """Returns the name that the robot shows for the drive that it carries out or has completed.

    None: the activity shows no drive.
    """
    goal = activity.goal.casefold()
    return goal if activity.kind in MOVING else {
        ActivityKind.ARRIVED_AT_GOAL: goal, ActivityKind.DOCKED: _DOCK,
        ActivityKind.ARRIVED_AT_POINT: '', ActivityKind.STOPPED: goal or None,
    }.get(activity.kind)


def _is_shown_of_others(record: DriveRecord, activity: Activity) -> bool:
    return record.kind is RecordKind.FOREIGN_DRIVE and record.shown == _shown(activity)


def _may_cause(drive: DriveRecord, activity: Activity) -> bool:
    """Returns whether a drive may be the cause of this motion of the robot.

    The name of the motion's goal, route or task decides. But a drive of tasks, or a drive to the
    dock, may cause motions with other names while it is under way or its fate is unknown.
    """
    kind, goal, names = activity.kind, activity.goal.casefold(), drive.names
    if kind is ActivityKind.DOCKING or kind in _NEVER_OURS:
        return kind is ActivityKind.DOCKING and _DOCK in names
    if goal and goal in names:
        return True
    if kind is ActivityKind.UNDOCKING:
        may_be = '' in names or _DOCK in names or not drive.acknowledged_by
    elif '' in names:
        course = spec_of(drive.verb).course
        may_be = course is DriveCourse.OF_TASKS or (
            course is DriveCourse.TO_A_PLACE and kind is ActivityKind.GOING_TO_POINT)
    else:
        may_be = kind is ActivityKind.GOING_TO_GOAL and _DOCK in names
    return drive.may_move and may_be


def _cancellation_of(canceller: Giver) -> str:
    return f'a cancellation of {canceller.name}'


def _cause_of(activity: Activity) -> MotionCause:
    """Returns why a drive of ours has ended if the robot shows this activity."""
    return MotionCause.ROBOT if activity.kind in _GAVE_UP else MotionCause.OTHER_CLIENT


def draw_epoch() -> int:
    """Returns a new random epoch, never 0."""
    return secrets.randbits(64) or 1


class Drives:
    """The records of one robot. The caller holds one lock while it uses this object or sends.

    stored -- the memory that an earlier process stored
    store -- saves the memory for a restart; if a command changes it, it is saved before the command
        is sent

    The class has many methods: there is one for each event, and all of them change the same
    records.
    """

    def __init__(self, stored: Optional[DriveMemory] = None,
                 store: Callable[[DriveMemory], None] = lambda memory: None,
                 draw: Callable[[], int] = draw_epoch) -> None:
        self._store, self._draw = store, draw
        self.heard = RobotWords()
        self._changes: Deque[_Change] = deque(maxlen=_KEPT_EPOCHS)
        self._memory = stored or DriveMemory(0)
        self._number = max((r.number for r in self._records), default=0)
        self._executions: Dict[int, Execution] = {}  # commands under way, by number of the record
        self._aside: Tuple[DriveRecord, ...] = ()  # dropped records of commands under way
        self._connected = False
        # True until the first status after a restart or an outage shows what happened meanwhile.
        self._unseen = stored is not None
        self._look_until = self._retry_at = -math.inf
        self._records = tuple(r if r.fate is Fate.OVER else replace(r, fate=Fate.UNKNOWN)
                              for r in self._records)
        self._begin_epoch(None, MotionCause.RESTART, 'the controller was started', False)

    @property
    def _records(self) -> Tuple[DriveRecord, ...]:
        return self._memory.records

    @_records.setter
    def _records(self, records: Tuple[DriveRecord, ...]) -> None:
        kept = {record.number for record in records}
        self._aside = tuple(r for r in (*self._aside, *self._records)
                            if r.number in self._executions and r.number not in kept)
        self._memory = replace(self._memory, records=records)

    # --- derived answers --------------------------------------------------------------------------

    @property
    def motion(self) -> RobotMotion:
        """The state to publish now."""
        return RobotMotion(self._memory, self._state(), self.heard.emergency_told)

    @property
    def is_unexplained(self) -> bool:
        """Whether the robot broke off a drive (of ours or of others) and has not shown why yet."""
        newest = self._records[-1] if self._records else _NOTHING
        return self._memory.cause is MotionCause.INTERRUPTED or (
            self.heard.broke_off and newest.kind is RecordKind.FOREIGN_DRIVE)

    def knows(self, giver: Giver, epoch: int) -> bool:
        """Returns whether no other giver has acted since `epoch`, the epoch that `giver` knows."""
        return epoch == self._memory.epoch or self._others_since(giver, epoch) == ()

    def stop_due(self, now: float) -> bool:
        """Returns whether the owed stop must be sent now.

        While a later drive is under way, the stop is not sent: that drive may make it needless.
        """
        for record in reversed(self._records):
            if record.owed:
                return (self._connected and record.number not in self._executions
                        and now >= max(self._look_until, self._retry_at))
            if record.may_move and record.number in self._executions:
                return False
        return False

    def check(self, giver: Giver, command: Command, known_epoch: int, number: int = 0) -> None:
        """Raises Overruled, Unclear or Busy if a command must not be sent.

        number -- the giver's number of the command; a drive is refused as late unless this number
            is greater than the number of the giver's last command
        """
        spec = command.spec
        if number and not spec.stops and number <= self._last_number(giver):
            raise Overruled(f'it is not newer than the last one of {giver.name}')
        if known_epoch and spec.stops:
            others = self._others_since(giver, known_epoch)
            if others is not None and any(change.drives for change in others):
                raise Overruled(self._memory.reason)
        elif known_epoch and spec.moves:
            if not self.knows(giver, known_epoch):
                raise Overruled(self._memory.reason)
            unclear = self._why_unclear(giver)
            if unclear:
                raise Unclear(f'Not sent, {unclear}.')
        if spec.drives and sum(map(self._is_open, self._records)) >= MOST_OPEN:
            raise Busy(MOST_OPEN, 'drives')

    def _why_unclear(self, giver: Giver) -> str:
        """Returns why `giver` must not drive although it knows the present epoch; empty: it may."""
        if self._unseen:  # the first status may begin a new epoch
            return 'the robot has not said yet what it does'
        if self.is_unexplained:
            return 'the robot has not said yet why it broke off its drive'
        other = next((r for r in self._records if r.pending and r.giver != giver), None)
        if other:
            return f'the robot has not answered {other.words} yet'
        newest = next(reversed(list(self._executions.values())), None)
        doubt = self._doubt_of(newest) if newest and self.has_begun(newest) else None
        if self._memory.drives and doubt and doubt.outcome is Outcome.INTERRUPTED:
            return 'the robot may have been stopped by another client'
        return ''

    def may_send(self, execution: Execution) -> bool:
        """Returns whether a command that waits may still be sent to the robot now."""
        return (not execution.known_epoch or not execution.command.spec.moves
                or self.knows(execution.giver, execution.progress.epoch))

    def has_begun(self, execution: Execution) -> bool:
        """Returns whether the robot obeys a command, or has begun to answer it.

        The robot answers stops in the order of sending: while n answers are missing, the newest n
        stops are not answered.
        """
        if execution.command.spec.drives:
            record = self.record_of(execution)
            return record is not None and bool(record.acknowledged_by)
        if execution.command.spec.stops:
            stops = [e for e in self._executions.values() if e.command.spec.stops and e.sent]
            return execution in stops[:max(len(stops) - self.heard.unheard_stops, 0)]
        return execution.is_answered

    def is_replaced(self, execution: Execution) -> bool:
        """Returns whether something newer has replaced a drive or stop under way."""
        return self.record_of(execution) in self._aside

    # --- commands ---------------------------------------------------------------------------------

    def given(self, execution: Execution) -> None:
        """Notes that a giver gives a command that `check` has accepted; it is not sent yet."""
        command, giver = execution.command, execution.giver
        if self._unseen and (command.spec.drives or command.spec.stops):
            self._unseen = False
            self._begin_epoch(None, MotionCause.OTHER_CLIENT, _UNSEEN, False)
        if command.spec.drives:
            self._add(RecordKind.DRIVE, giver, f'"{command.text}" of {giver.name}', execution,
                      goal=command.goals[0] if command.goals else '', names=names_of(command),
                      verb=command.name, command=execution.number)
            self._keep(self._records[-1])
        elif command.spec.stops:
            self._owe(giver, MotionCause.STOP, f'"stop" of {giver.name}', execution,
                      execution.number)
        execution.progress.epoch = self._memory.epoch

    def overruled(self, giver: Giver, number: int) -> None:
        """Notes that a command was refused because its giver does not know of another command.

        A late command does not become the last command of its giver.
        """
        if number > self._last_number(giver):
            self._keep(replace(_NOTHING, giver=giver, command=number))

    def cancelled(self, execution: Execution, canceller: Giver) -> None:
        """Notes that a giver cancels a drive.

        No stop is owed if the giver cancels its own drive, and this drive was not sent yet or is
        replaced by a newer one. If the newer one is lost, a stop may be owed later; see
        `_stop_if_cancelled`.
        """
        if not execution.command.spec.drives:
            return
        newest = next((r for r in reversed(self._records) if r.kind is RecordKind.DRIVE), None)
        if canceller != execution.giver or (
                newest and execution.sent and self._executions.get(newest.number) is execution):
            self._owe(canceller, MotionCause.CANCEL, _cancellation_of(canceller))
            return
        record = self._record_of(execution)
        if record is not None:  # the newer drive may be lost
            self._mark(record.number, is_cancelled=True)
            self._keep()

    def all_cancelled(self, canceller: Giver) -> None:
        """Notes that a giver cancels all earlier commands, including drives that have not arrived
        here yet.
        """
        words = _cancellation_of(canceller)
        if any(record.may_move for record in self._records) or self._memory.stop_owed:
            self._owe(canceller, MotionCause.CANCEL, words)
        else:
            if not self.drives_for_others:
                self._records = (self._record(RecordKind.STOP, canceller, words, fate=Fate.OVER),)
            self._begin_epoch(canceller, MotionCause.CANCEL, words, False)

    def own_stop_given(self, stop: Execution) -> None:
        """Notes that this package gives a stop itself: an owed one, or one for a cancellation."""
        owed = next((r for r in reversed(self._records) if r.owed), None)
        if owed is None or owed.number in self._executions:
            self._owe(stop.giver, MotionCause.CANCEL, 'a cancellation', stop)
        else:
            self._executions[owed.number] = stop

    def stopped_without_link(self, giver: Giver, number: int = 0) -> None:
        """Notes that a stop is given while there is no link. It is sent when the link comes up."""
        self._owe(giver, MotionCause.STOP, f'"stop" of {giver.name}', None, number)

    def sent(self, execution: Execution) -> None:
        """Notes that a command is sent to the robot."""
        if execution.command.spec.stops:
            self.heard.stop_sent(execution.order)
        record = self.record_of(execution)
        if record is not None:
            self._mark(record.number, order=execution.order)

    # --- progress of commands ---------------------------------------------------------------------

    def acknowledged(self, execution: Execution, line: str) -> None:
        """Notes that the robot obeys a drive. Called before the older motions are ended."""
        record = self.record_of(execution)
        if record is not None:
            self._obeyed(record.number, line)

    def ended(self, execution: Execution, outcome: Outcome, words: str, now: float) -> None:
        """Notes that a command has ended, or could not be sent."""
        self._end_doubt(execution, outcome, now)
        record = self._record_of(execution)
        aside = self.record_of(execution) if record is None else None
        if aside is not None and outcome is Outcome.SUCCEEDED:
            self._happens(Event.COMPLETED, aside)
        self._executions = {n: e for n, e in self._executions.items() if e is not execution}
        if record is None:  # a later command or event has replaced it already
            self._keep()
            return
        if record.kind is RecordKind.STOP:
            self._stop_ended(record, outcome, now)
        elif outcome is Outcome.INTERRUPTED and record is self._records[-1]:
            self._records = self._records[:-1]
            self._foreign(MotionCause.INTERRUPTED if self.heard.broke_off
                          else MotionCause.OTHER_CLIENT, False, words)
        else:
            self._drive_ended(record, execution, outcome, words)

    def _end_doubt(self, execution: Execution, outcome: Outcome, now: float) -> None:
        """Removes the doubt about a command that has ended.

        If the command is an unanswered stop, no answer to it is expected any more.
        """
        under_way = self.record_of(execution)
        if execution.command.spec.stops and not self.has_begun(execution) and (
                outcome in UNHEEDED or under_way and under_way.doubt
                and is_settled(under_way.doubt, None, now)):  # its doubt has ended it
            self.heard.forget_stop(execution.order)
        if under_way is not None:
            self._mark(under_way.number, doubt=None)

    def _stop_ended(self, record: DriveRecord, outcome: Outcome, now: float) -> None:
        if outcome not in _OBEYED_STOP:
            self._retry_at = now + RETRY
            return
        at = self._records.index(record)
        # `Stopped` may belong to an older stop, so earlier drives and stops may still take effect
        may_follow = [r for r in self._records[:at] if self.heard.unheard_stops and (
            r.may_move or r.kind is RecordKind.STOP and r.fate is Fate.OVER)]
        also = self._told_by(*(r for r in self._records[:at] if r.owed))
        self._records = (*may_follow, replace(
            record, fate=Fate.OVER, stands_for=(*record.stands_for, *also)[:_KEPT_GIVERS]),
            *self._records[at + 1:])
        self._retry_at = -math.inf
        self._keep()

    def _drive_ended(self, record: DriveRecord, execution: Execution, outcome: Outcome,
                     words: str) -> None:
        event, before = self._event_of(execution, outcome), self._memory.ruling
        if outcome is Outcome.EMERGENCY_STOPPED:
            self.note_emergency(words)
        self._happens(event, record)
        ruling = self._memory.ruling
        if ruling and ruling is self._records[-1] and ruling.was_broken_off:
            # the robot refused the drive that seemed to have replaced the ruling one
            self._foreign(MotionCause.OTHER_CLIENT, False, f'{ruling.words} was interrupted')
        if event is Event.LOST and record.pending:
            self._rules(record, before)  # the robot may carry it out
        newer = any(r.kind is RecordKind.DRIVE and r.number > record.number for r in self._records)
        if outcome is Outcome.TIMED_OUT and execution.stop_on_timeout and not newer:
            self._owe(execution.giver, MotionCause.STOP, words)
        elif event is Event.EMERGENCY_STOP and record.pending and execution.sent:
            self._owe_for_what_comes(words)

    def _event_of(self, execution: Execution, outcome: Outcome) -> Event:
        event = _EVENTS[outcome]
        if event is Event.WITHDRAWN and self.heard.unheard_stops and execution.sent:
            return Event.CALLED_BACK
        if event is Event.EMERGENCY_STOP and execution.progress.rejected_at is not None:
            return Event.REFUSED
        return event

    def _owe_for_what_comes(self, words: str) -> None:
        """Notes that a stop is owed for drives that are still on their way to the robot.

        They reach the robot after it was stopped, or when its motors are on again. One stop ends
        all of them.
        """
        last = self._records[-1]
        if not last.owed or last.number in self._executions:
            self._add(RecordKind.STOP, NO_GIVER, words)
            self._keep()

    # --- doubts -----------------------------------------------------------------------------------

    def record_of(self, execution: Execution) -> Optional[DriveRecord]:
        """Returns the record of a drive or stop under way, even if the record is kept aside."""
        return next((r for r in (*self._records, *self._aside)
                     if self._executions.get(r.number) is execution), None)

    @property
    def in_doubt(self) -> bool:
        """Whether a drive or stop is doubted, or an interruption is unexplained.

        The next status may decide this.
        """
        return self.is_unexplained or any(map(self._doubt_of, self._executions.values()))

    def observed(self, seen: Observation, now: float) -> List[Execution]:
        """Notes an activity that the robot shows.

        Returns the drives that the activity confirms, the oldest first.
        """
        sent = self._sent
        drives = [e for e in sent if e.command.spec.drives]
        return [e for e in sent if self._is_confirmed(e, drives, seen, now) and e in drives]

    def _is_confirmed(self, execution: Execution, drives: Sequence[Execution], seen: Observation,
                      now: float) -> bool:
        record, begun = self.record_of(execution), self.has_begun(execution)
        verdict = judge(execution, seen, begun, drives)
        if record is None:
            return False
        if record.doubt and record.doubt.broken_off and seen.is_line_of(ActivityKind.STOPPED):
            self._happens(Event.DOUBTED, record, replace(record.doubt, is_certain=True))
        elif isinstance(verdict, Outcome):
            self._happens(Event.DOUBTED, record,
                          next_doubt(record.doubt, verdict, seen, now, begun))
        elif verdict is DriveSign.CONFIRMED:
            self._happens(Event.CONFIRMED, record)
        return verdict is DriveSign.CONFIRMED

    def settled(self, now: float) -> List[Tuple[Execution, Doubt]]:
        """Returns the commands that end now because of their doubts, the oldest first."""
        doubted = [(execution, self._doubt_of(execution)) for execution in self._sent]
        return [(execution, doubt) for execution, doubt in doubted
                if doubt and is_settled(doubt, execution.command.spec.course, now)]

    @property
    def _sent(self) -> List[Execution]:
        """The drives and stops under way that were sent, in the order of sending."""
        return sorted((e for e in self._executions.values() if e.sent), key=lambda e: e.order)

    def _doubt_of(self, execution: Execution) -> Optional[Doubt]:
        record = self.record_of(execution)
        return record.doubt if record else None

    def _mark(self, number: int, **changes: Any) -> None:
        """Changes fields of the record of a drive or stop, but not its fate."""
        def marked(records: Tuple[DriveRecord, ...]) -> Tuple[DriveRecord, ...]:
            return tuple(replace(r, **changes) if r.number == number else r for r in records)
        self._records, self._aside = marked(self._records), marked(self._aside)

    # --- lines of the robot -----------------------------------------------------------------------

    def linked(self, connected: bool, now: float) -> None:
        """Notes that the link to the robot came up, broke, or could not be made."""
        self._unseen = self._unseen or self._connected and not connected
        self._connected = connected
        self.heard = RobotWords(self.heard.emergency_told, self._number)
        self._records = tuple(replace(record, order=0) for record in self._records)
        self._look_until = now + LOOK if connected and self._memory.stop_owed else -math.inf

    def said(self, reply: Reply) -> None:
        """Notes that the robot sent a line that is not a status. Called before the line ends
        commands.
        """
        self.heard.said(reply)
        if isinstance(reply, (replies.EStop, replies.RobotError)) and reply.pressed:
            self.note_emergency('emergency stop')

    def begins_to_stop(self, whose: StopOf) -> None:
        """Notes that the robot said `Stopping`, or that it said `Stopped` unexpectedly; see
        `RobotWords.will_not_stand`.
        """
        self.heard.begins_to_stop(whose)
        if whose is not StopOf.OTHERS:
            return
        # a drive may be on its way, and may reach the robot after the other client's stop
        crosses = any(r.pending and self._is_unread(r) for r in self._records)
        self._foreign(MotionCause.OTHER_CLIENT, False, _STOPPED_BY_OTHERS)
        if crosses:
            self._owe_for_what_comes(_STOPPED_BY_OTHERS)

    @property
    def is_idle(self) -> bool:
        """Whether no drive or stop of ours is under way."""
        return not self._executions

    @property
    def replaces_a_drive(self) -> bool:
        """Whether the robot moves, and a drive that it has still to answer is on its way."""
        return self.heard.moves and any(map(self._is_to_come, self._records))

    def replaces_a_drive_before(self, stop: Execution) -> bool:
        """Returns whether the robot moves, and has said nothing about a drive that was sent before
        this stop.
        """
        return self.heard.moves and any(map(self._is_unread, self._before(stop)))

    @property
    def drives_for_others(self) -> bool:
        """Whether the robot carries out, and has not broken off, a drive that is not ours.

        The robot carries it out until it has read our later drives and stops.
        """
        newest = next((r for r in reversed(self._records) if not (r.pending or r.owed)), _NOTHING)
        heard, others = self.heard, RecordKind.FOREIGN_DRIVE
        return newest.kind is others and (heard.moves or heard.moved) and not heard.broke_off

    @property
    def is_about_the_dock(self) -> bool:
        """Whether the robot docks or leaves its dock for a command of ours."""
        into, out = DriveCourse.INTO_THE_DOCK, DriveCourse.OUT_OF_THE_DOCK
        return any(e.command.spec.course in (into, out) if self.has_begun(e)
                   else e.progress.set_out and e.command.spec.course is not into
                   for e in self._executions.values())

    def waits_for_a_drive(self, stop: Execution) -> bool:
        """Returns whether the robot may still have to answer a drive that was sent before this
        stop.
        """
        return any(self._is_to_come(record)
                   or record.kind is RecordKind.DRIVE and record.fate is Fate.UNKNOWN
                   for record in self._before(stop))

    def _is_to_come(self, record: DriveRecord) -> bool:
        """Returns whether the record is a drive that was sent and that the robot has not answered.
        """
        return record.pending and self._was_sent(record) or self._has_to_answer(record)

    def _is_unread(self, record: DriveRecord) -> bool:
        """Returns whether a drive was sent, and the robot has sent no answer or line about it."""
        execution = self._executions.get(record.number)
        return self._is_to_come(record) and not (execution and execution.has_lines)

    def _is_open(self, record: DriveRecord) -> bool:
        """Returns whether the robot carries out a drive of this connection, or may carry it out."""
        return record.may_move and (
            record.fate is not Fate.UNKNOWN or record.number > self.heard.since)

    def _is_gone(self, record: DriveRecord) -> bool:
        """Returns whether a drive was lost with an earlier link.

        If the robot then obeys an older drive, it will never carry out the lost drive.
        """
        return record.fate is Fate.UNKNOWN and record.number <= self.heard.since

    def _has_to_answer(self, record: DriveRecord) -> bool:
        """Returns whether a drive has ended for its giver, but the robot has still to answer it."""
        return (record.kind is RecordKind.DRIVE and record.fate is Fate.UNKNOWN
                and record.number > self.heard.since and not record.acknowledged_by)

    def answers_a_drive_before(self, stop: Execution) -> bool:
        """Returns whether the robot has still to answer a drive that was sent before this stop and
        has ended for its giver.
        """
        return any(map(self._has_to_answer, self._before(stop)))

    def comes_earlier(self, drive: Execution) -> bool:
        """Returns whether a line that names the goal of `drive` may be about an earlier drive.

        This is an earlier drive to the same goal that has ended for its giver. The robot has not
        answered it, or has not answered a stop that was sent between the two drives.
        """
        before, names = self._before(drive), set(names_of(drive.command))
        stop = next((r for r in reversed(before) if r.owed and self._was_sent(r)
                     and not self.has_begun(self._executions[r.number])), None)
        return any(names.intersection(r.names) and (self._has_to_answer(r) or (
            stop is not None and r.fate is Fate.UNKNOWN and r.number < stop.number))
            for r in before)

    def ended_drive(self, names: Sequence[str], verb: str = '') -> Optional[DriveRecord]:
        """Returns the drive that the robot has to answer next, of those with one of these names.

        None: there is none, or the drive has not ended for its giver.

        verb -- the name of the command; '': any command
        """
        record = next((r for r in self._records if set(names).intersection(r.names)
                       and verb in ('', r.verb) and self._is_to_come(r)), None)
        return None if record is None or record.pending else record

    def may_begin_late(self, activity: Activity) -> bool:
        """Returns whether this motion may be for a drive of ours that has ended for its giver."""
        return bool(self._late_drives(activity))

    def _late_drives(self, activity: Activity) -> List[DriveRecord]:
        """Returns the drives that have ended for their givers and may be the cause of this motion.

        If the robot has acknowledged a drive and was stopped after it, neither this drive nor an
        older one is returned.
        """
        over = max((r.number for r in self._records
                    if r.acknowledged_by and self._is_stopped_since(r)), default=0)
        return [r for r in self._records if r.may_move and r.number > over
                and r.number not in self._executions and _may_cause(r, activity)]

    def _is_stopped_since(self, drive: DriveRecord) -> bool:
        """Returns whether the robot has said `Stopping` for a stop that was sent after a drive."""
        return any(r.owed and r.number > drive.number and self._was_sent(r)
                   and self.has_begun(self._executions[r.number]) for r in self._records)

    def lost_drives(self, activity: Activity) -> List[DriveRecord]:
        """Returns the drives without a command that may be the cause of this motion: their fate is
        unknown, or a status after an outage has shown that the robot obeys them.

        A drive of tasks is not returned for a motion without a name: the same task may cause
        further motions.
        """
        goal = activity.goal.casefold()
        return [r for r in self._records if r.fate in (Fate.UNKNOWN, Fate.OBEYED)
                and r.kind is RecordKind.DRIVE and _may_cause(r, activity)
                and r.number not in self._executions and not self._has_to_answer(r)
                and (goal in r.names or activity.kind is ActivityKind.DOCKING)
                and (goal or spec_of(r.verb).course is not DriveCourse.OF_TASKS)]

    def ended_late(self, drives: Sequence[DriveRecord], outcome: Outcome, line: str) -> None:
        """Notes that the robot refused or broke off drives that have ended for their givers."""
        is_newest = bool(drives) and self._records[-1] is drives[-1]
        for drive in drives:
            self._happens(_EVENTS[outcome], drive)
        if is_newest and outcome is Outcome.INTERRUPTED:
            self._foreign(MotionCause.INTERRUPTED, False, line)

    def begins_late(self, activity: Activity, line: str) -> None:
        """Notes that the robot sets out for a drive of ours that has ended for its giver.

        Of several drives, it is the one that the robot has to answer next. If there is none to
        answer, it is the newest.
        """
        drives = [r for r in self._late_drives(activity)
                  if r.fate is Fate.UNKNOWN and activity.goal.casefold() in r.names]
        record = next(iter((*filter(self._has_to_answer, drives), *reversed(drives))), None)
        if record and self._memory.stop_owed:
            self._mark(record.number, acknowledged_by=line)
            self.heard.drive_answered(record.order)
        elif record:
            self._obeyed(record.number, line)
            self._stop_if_cancelled(record)

    def driven_by_others(self, cause: MotionCause, activity: Activity, text: str) -> None:
        """Notes that the robot begins a motion that no command of ours requested."""
        self._foreign(cause, True, text, activity)

    def showed(self, activity: Activity, text: str, asked: Optional[int] = None) -> None:
        """Notes that the robot sends a status; `asked`: see `Observation`."""
        before = self.heard.shown
        if asked is not None:
            self.heard.answered(asked)
        self.heard.showed(activity)
        if activity.kind is ActivityKind.EMERGENCY_STOP:
            self.note_emergency(text)
        if self.is_unexplained:  # no emergency stop is shown, so another client broke off the drive
            self._begin_epoch(None, MotionCause.OTHER_CLIENT, self._memory.reason, False)
        if self._unseen:
            self._first_shown(activity, text)
        elif self.is_idle:
            self._idle_shown(before, activity, text)
        self._look_until = -math.inf

    def _first_shown(self, activity: Activity, text: str) -> None:
        """Decides from the first status after an outage whether the robot still obeys our drive."""
        self._unseen = False
        record = self._shown_drive(activity)
        if record is None:
            self._other_shown(activity, f'after an outage the robot shows "{text}"')
        elif not self._may_be_several(activity):  # if several: a later line names the goal
            self._drive_shown(record, activity, text)

    def _drive_shown(self, record: DriveRecord, activity: Activity, text: str) -> None:
        """Notes that the robot obeys this drive after an outage, unless a later stop is owed."""
        if self._memory.stop_owed and record.number < max(
                r.number for r in self._records if r.owed):
            return
        moves, leaves = activity.kind in MOVING, activity.kind is ActivityKind.UNDOCKING
        ruling = self._memory.ruling
        self._records = (replace(
            record, fate=Fate.OBEYED if moves else Fate.OVER, ending=CommandFate.COMPLETED,
            acknowledged_by=record.acknowledged_by if leaves else text),)
        if ruling and ruling.giver != record.giver:  # the drive of the ruling giver was lost
            self._begin_epoch(record.giver, MotionCause.OTHER_GIVER, record.words, moves)
        self._keep()
        if moves:
            self._stop_if_cancelled(record)

    def _other_shown(self, activity: Activity, words: str) -> None:
        """Notes that the robot obeys none of our drives after an outage."""
        if self.heard.emergency:
            return
        if self._stands_as_we_stopped_it(activity):
            self._begin_epoch(None, MotionCause.RESTART, words, False)
        elif self._is_to_be_stopped(activity):
            self._begin_epoch(None, MotionCause.OTHER_CLIENT, words, False)
        else:
            self._foreign(_cause_of(activity), activity.kind in MOVING, words, activity)

    def _may_be_several(self, activity: Activity) -> bool:
        """Returns whether the robot leaves its dock, and several drives may be the reason."""
        causes = [r for r in self._records if r.may_move and _may_cause(r, activity)]
        return (activity.kind is ActivityKind.UNDOCKING and not self._memory.stop_owed
                and len(causes) > 1)

    def _stop_if_cancelled(self, drive: DriveRecord) -> None:
        """Owes a stop if the robot carries out a drive that its giver has cancelled.

        The newer drive that was about to replace the cancelled one is lost.
        """
        if drive.is_cancelled:
            self._owe(drive.giver, MotionCause.CANCEL, _cancellation_of(drive.giver))

    def _is_to_be_stopped(self, activity: Activity) -> bool:
        """Returns whether a stop is owed for the motion that the robot shows.

        This is so if the cause may be a drive of ours that was given before the stop. It is also so
        if another client had begun this same motion before the stop.
        """
        newest = max((r.number for r in self._records if r.owed), default=0)
        return any(r.number < newest and (
            _is_shown_of_others(r, activity) or r.may_move and activity.kind in _WITHOUT_A_GOAL)
            for r in self._records)

    def _stands_as_we_stopped_it(self, activity: Activity) -> bool:
        """Returns whether our last command was a stop, and the robot shows no activity after it."""
        last = self._records[-1] if self._records else None
        return last is not None and last.kind is RecordKind.STOP and last.fate is Fate.OVER and (
            activity.kind is ActivityKind.STOPPED or last.shown == _shown(activity))

    def _idle_shown(self, before: Optional[Activity], activity: Activity, text: str) -> None:
        """Handles a status while no command of ours is under way: others may cause the motion."""
        if before is not None and self._is_stopped(before, activity):
            self._foreign(MotionCause.OTHER_CLIENT, False, text)
        ruling, moves = self._memory.ruling or _NOTHING, activity.kind in MOVING
        if moves:
            strange = self._moves_strangely(ruling, activity, text)
        else:
            strange = self._ends_unlike(ruling, activity)
        self._note_dock(ruling, activity)
        if strange and self.heard.strange:  # a single status may be older than a line
            self._foreign(_cause_of(activity), moves, text, activity)
        self.heard.strange = strange

    def _moves_strangely(self, ruling: DriveRecord, activity: Activity, text: str) -> bool:
        """Returns whether no known drive causes a motion.

        If the cause is a drive of ours with unknown fate, notes that the robot obeys that drive.
        """
        shown = self._shown_drive(activity)
        if shown and shown.fate is Fate.UNKNOWN and not self._memory.stop_owed and (
                activity.goal and activity.goal.casefold() in shown.names):
            self._obeyed(shown.number, text)
            self._stop_if_cancelled(shown)
            return False
        return ruling.kind is not RecordKind.FOREIGN_DRIVE and not any(
            _may_cause(record, activity) for record in self._records)

    def _note_dock(self, ruling: DriveRecord, activity: Activity) -> None:
        """Notes that the robot is in its dock after it obeyed our stop; see `DriveRecord.shown`."""
        if ruling.kind is RecordKind.STOP and ruling.fate is Fate.OVER and (
                activity.kind is ActivityKind.DOCKED and ruling.shown != _shown(activity)):
            self._mark(ruling.number, shown=_shown(activity))
            self._keep()

    def _is_stopped(self, before: Activity, activity: Activity) -> bool:
        """Returns whether the robot now shows a stop that it would not make by itself.

        Before this stop, the robot was at our goal, or drove to a place for another client.
        """
        ruling, goal = self._memory.ruling, before.goal.casefold()
        at_our_goal = (before.kind is ActivityKind.ARRIVED_AT_GOAL and self._memory.drives
                       and goal in self._memory.names)
        for_others = (before.kind in (ActivityKind.GOING_TO_GOAL, ActivityKind.GOING_TO_POINT)
                      and ruling is not None and ruling.kind is RecordKind.FOREIGN_DRIVE)
        return (at_our_goal or for_others) and activity.kind in HALTED

    def _ends_unlike(self, ruling: DriveRecord, activity: Activity) -> bool:
        """Returns whether the robot stands, but not at the goal of the ruling drive.

        The command of this drive was lost with an earlier link, so only statuses show its end.
        """
        if ruling.kind is not RecordKind.DRIVE or ruling.fate is not Fate.OBEYED:
            return False
        shown = self._shown_drive(activity)
        if shown is ruling:
            self._happens(Event.COMPLETED, ruling)
        return shown is None and activity.kind in STANDING

    def _before(self, execution: Execution) -> Tuple[DriveRecord, ...]:
        """Returns the records that are older than the record of a command."""
        record = self._record_of(execution)
        return self._records[:self._records.index(record)] if record else ()

    def _was_sent(self, record: DriveRecord) -> bool:
        execution = self._executions.get(record.number)
        return execution is not None and execution.sent

    # --- records and epochs -----------------------------------------------------------------------

    def _record(self, kind: RecordKind, giver: Giver, words: str, fate: Fate = Fate.GIVEN,
                **fields: Any) -> DriveRecord:
        self._number += 1
        return DriveRecord(self._number, kind, fate, giver, words=words, **fields)

    def _add(self, kind: RecordKind, giver: Giver, words: str,
             execution: Optional[Execution] = None, **fields: Any) -> None:
        record = self._record(kind, giver, words, **fields)
        records = (*self._records, record)
        self._records = _shortened(records, _KEPT_RECORDS, [
            one for one, after in zip(records, records[1:])
            if not (self._is_open(one) or one.owed and not after.owed)])
        if execution:
            self._executions[record.number] = execution

    def _record_of(self, execution: Execution) -> Optional[DriveRecord]:
        return next((r for r in self._records
                     if self._executions.get(r.number) is execution), None)

    def _happens(self, event: Event, record: DriveRecord, doubt: Optional[Doubt] = None) -> None:
        """Gives a drive its next fate and doubt. Does nothing if the drive is OVER."""
        if record.fate is Fate.OVER:
            return
        fate = TRANSITIONS[event][_FROM.index(record.fate)]
        following = () if fate is None else (replace(
            record, fate=fate, doubt=doubt,
            ending=_ENDINGS.get(event, CommandFate.NOT_OBEYED)),)
        self._aside, self._records = (
            tuple(one for r in records for one in (following if r is record else (r,)))
            for records in (self._aside, self._records))
        if fate is not record.fate:
            self._keep()

    def _obeyed(self, number: int, line: str) -> None:
        """Notes that the robot carries out a drive; `line` is the line or status that shows this.

        The older records are dropped. From now on the giver of this drive drives the robot.
        """
        self._mark(number, acknowledged_by=line, doubt=None)
        record = next((r for r in self._records if r.number == number), None)
        if record is None or record.fate is Fate.OBEYED:
            return
        ruling, at = self._memory.ruling, self._records.index(record)
        self.heard.drive_answered(record.order)
        self._records = (record, *(
            r for r in self._records[at + 1:] if r.kind is RecordKind.STOP
            or r.kind is RecordKind.DRIVE and not self._is_gone(r)))
        self._happens(Event.ACKNOWLEDGED, record)
        self._rules(record, ruling)

    def _rules(self, record: DriveRecord, ruling: Optional[DriveRecord]) -> None:
        """Begins an epoch because a drive has become the ruling record.

        No epoch begins if the same giver drove before, or if a newer record rules.
        """
        now_ruling = next(r for r in reversed(self._records) if not r.pending)
        if now_ruling.number != record.number or (
                ruling is not None
                and (ruling.kind, ruling.giver) == (RecordKind.DRIVE, record.giver)
                and self._memory.cause is MotionCause.OTHER_GIVER):
            self._keep()
        else:
            self._begin_epoch(record.giver, MotionCause.OTHER_GIVER, record.words, True)

    def _owe(self, giver: Giver, cause: MotionCause, words: str,
             execution: Optional[Execution] = None, command: int = 0) -> None:
        """Notes that a stop is owed from now on.

        If a stop is owed already and no drive came after it, the new stop replaces its record.
        """
        last = next((r for r in reversed(self._records)
                     if r.kind in (RecordKind.DRIVE, RecordKind.STOP)), None)
        self._retry_at = -math.inf  # the stop is new, so it need not wait for a retry
        if last and last.owed and not (execution and last.number in self._executions):
            self._records = (*(r for r in self._records if r is not last),
                             replace(last, giver=giver, words=words, command=command,
                                     stands_for=self._told_by(last)))
            if execution:
                self._executions[last.number] = execution
        else:
            self._add(RecordKind.STOP, giver, words, execution, command=command)
        # a drive of another giver may be on its way: the stop may end it without `giver` knowing it
        ends_unknown = any(r.pending and r.giver != giver for r in self._records)
        self._begin_epoch(None if ends_unknown else giver, cause, words, False, self._records[-1])

    def _foreign(self, cause: MotionCause, drives: bool, words: str,
                 activity: Optional[Activity] = None) -> None:
        """Notes that others drive or stop the robot.

        Unanswered drives, and the stops for these drives, may still reach the robot afterwards.
        Therefore their records are kept.
        """
        to_come = [r for r in self._records if r.pending or self._has_to_answer(r)]
        self._records = (
            *(r for r in self._records if r in to_come or r.owed and (to_come or not drives)),
            self._record(RecordKind.FOREIGN_DRIVE if drives else RecordKind.FOREIGN_STOP, NO_GIVER,
                         words, Fate.OVER, shown=_shown(activity) if activity and drives else ''))
        self._begin_epoch(None, cause, words, drives)

    def note_emergency(self, words: str) -> None:
        """Notes that the emergency stop is pressed."""
        if not self.heard.emergency:
            self.heard.emergency = True
            self._foreign(MotionCause.EMERGENCY_STOP, False, words)

    def _begin_epoch(self, giver: Optional[Giver], cause: MotionCause, reason: str, drives: bool,
                     given: Optional[DriveRecord] = None) -> None:
        self._note_last(given)  # noted first, so that the new epoch is not foreign to this giver
        before, epoch = self._memory.epoch, self._draw()
        self._changes.append(_Change(before, giver, drives))
        by_no_giver = cause is MotionCause.RESTART and before != 0
        self._memory = replace(
            self._memory, epoch=epoch, previous_epoch=before, cause=cause, reason=reason,
            foreign_epoch=self._memory.foreign_epoch if by_no_giver else epoch, last_commands=tuple(
                one if by_no_giver or giver is not None and giver.name == one.giver
                else replace(one, foreign_epoch=epoch) for one in self._memory.last_commands))
        self._keep()

    def _note_last(self, given: Optional[DriveRecord]) -> None:
        """Notes the last command of a giver. All epochs before its first command are foreign."""
        if given is None or given.command <= self._last_number(given.giver):  # a stop may come late
            return
        last, name = self._memory.last_commands, given.giver.name
        foreign = next((one.foreign_epoch for one in last if one.giver == name),
                       self._memory.foreign_epoch)
        self._memory = replace(self._memory, last_commands=(
            *(one for one in last if one.giver != name),
            LastCommand(name, given.command, CommandFate.GIVEN, foreign)))

    def _keep(self, given: Optional[DriveRecord] = None) -> None:
        """Stores the memory. `given` is a command that was given or overruled just now."""
        self._note_last(given)
        told = tuple(replace(one, fate=self._fate_of(one)) for one in self._memory.last_commands)
        self._memory = replace(self._memory, last_commands=_shortened(
            told, _KEPT_GIVERS, [one for one in told if one.fate in _DECIDED]))
        self._store(replace(self._memory, records=tuple(
            replace(record, order=0, doubt=None) for record in self._records)))

    def _fate_of(self, last: LastCommand) -> CommandFate:
        stops = [r for r in self._aside  # the robot may still obey them
                 if r.kind is RecordKind.STOP and r.number in self._executions]
        record = next((r for r in (*reversed(self._records), *stops)
                       if (last.giver, last.number) in r.commands), None)
        if record is not None:
            return record.command_fate
        return last.fate if last.fate in _ENDINGS.values() else CommandFate.NOT_OBEYED

    def _told_by(self, *stops: DriveRecord) -> Tuple[Tuple[str, int], ...]:
        """Returns those commands of these stops that are the last commands of their givers."""
        told = {(last.giver, last.number) for last in self._memory.last_commands}
        return tuple(command for stop in stops for command in stop.commands
                     if command in told)[:_KEPT_GIVERS]

    def _last_number(self, giver: Giver) -> int:
        return max((last.number for last in self._memory.last_commands
                    if last.giver == giver.name), default=0)

    def _others_since(self, giver: Giver, epoch: int) -> Optional[Tuple[_Change, ...]]:
        """Returns those changes of the epoch since `epoch` that `giver` did not cause.

        None: `epoch` is not remembered any more.
        """
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
        if not self._connected or self.heard.activity is None:
            return MotionState.UNKNOWN
        kind = self.heard.activity.kind
        commands = [execution.command.spec for execution in self._executions.values()]
        if any(spec.stops for spec in commands) and kind not in (
                ActivityKind.DOCKED, ActivityKind.UNDOCKING):
            return MotionState.STOPPING
        if kind in STANDING and kind is not ActivityKind.DOCKED:
            return MotionState.DRIVING if commands else MotionState.STANDING
        return _STATES.get(kind, MotionState.DRIVING)

    def _shown_drive(self, activity: Activity) -> Optional[DriveRecord]:
        """Returns the drive that the robot carries out or has completed, as the activity shows."""
        moves, name = activity.kind in MOVING, _name_of(activity)
        over = max((i for i, r in enumerate(self._records)
                    if r.kind is RecordKind.STOP and r.fate is Fate.OVER), default=-1)
        drives = [r for r in reversed(self._records[over + 1:]) if r.kind is RecordKind.DRIVE and (
            r.may_move and _may_cause(r, activity) if moves else name in r.names)]
        named = [r for r in drives if name in r.names]
        if any(_is_shown_of_others(r, activity) for r in self._records):
            return next(iter(named), None)
        return next(iter(named or drives), None)
