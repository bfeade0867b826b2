"""The motion authority: which giver drives the robot, whether the robot obeys, and the owed stop.

Every command that moves or stops the robot passes `take`, in the order in which commands are given.
The robot's lines pass `on_reply`. Both determine the *epoch*, a random number. A new epoch begins
when
- another giver than the present one drives, stops or cancels,
- the robot acts on the command of another client,
- the robot, after a start or a new connection, is not visibly carrying out our last drive, and has
  not visibly completed it: a person may have stopped it meanwhile.
A drive names the epoch that its giver knows. So it cannot overtake a stop or a drive that its giver
does not know of. No timer decides on the order of two commands that were taken here.

docs/reference/omron_controller.md states the limits of what can be known.
"""
from __future__ import annotations

import math
import secrets
from collections import deque
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Callable, Deque, NamedTuple, Optional, Tuple

from omron_arcl.activity import MOVING, STANDING, Activity, ActivityKind, activity_of
from omron_arcl.commands import Command, Course
from omron_arcl.errors import ArclError
from omron_arcl.execution import NO_GIVER, Execution, Giver, Outcome
from omron_arcl.replies import Motors, Stopped, Stopping
from omron_arcl.replies.reply import Reply
from omron_arcl.replies.safety import EStop

AT_ONCE = 1.0  # s after sending in which a line or status may be older than the command
LATE = 0.5  # s after a stop or after enabling the motors in which the robot may say `Stopping`
LOOK = 2.0  # s of a new connection to wait for a status that may make an owed stop unnecessary
RETRY = 1.0  # s between two attempts to send an owed stop
_KEPT_EPOCHS = 100
_KEPT_GOALS = 20


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


class Overruled(ArclError):
    """The giver of a command does not know of an earlier command or motion of the robot."""

    def __init__(self, why: str) -> None:
        super().__init__(f'Not sent, another command came first: {why}.')


class Unclear(ArclError):
    """A drive was refused because it is unknown at this moment whether the robot obeys."""


@dataclass(frozen=True)
class Memory:
    """The state that survives a restart; all of it except `goals` is published.

    giver -- the program that drove or stopped the robot last; empty: another client, or the robot
    drives -- whether the last command that moved or stopped the robot was a drive
    goals -- the goals of our commands to which the robot may still drive
    newer_goals -- the goals of drives that came after the owed stop
    """

    epoch: int
    previous_epoch: int = 0
    giver: Giver = NO_GIVER
    cause: Cause = Cause.RESTART
    reason: str = ''
    goal: str = ''
    drives: bool = False
    stop_owed: bool = False
    goals: Tuple[str, ...] = ()
    newer_goals: Tuple[str, ...] = ()


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


_OF_THE_ROBOT = (Cause.OTHER_CLIENT, Cause.ROBOT)
# A robot that is found like this has ended its drive by itself; otherwise, another client did.
_GAVE_UP = (ActivityKind.FAILED, ActivityKind.LOST, ActivityKind.MOTORS_DISABLED)
_DOCK = 'dock'
_UNSEEN = 'during an outage of the link another client may have driven or stopped the robot'


def _goals_of(command: Command) -> Tuple[str, ...]:
    """The names by which the robot may confirm a drive; ('',) if it needs no name."""
    return tuple(goal.casefold() for goal in command.goals) or (
        (_DOCK,) if command.spec.course is Course.INTO_THE_DOCK else ('',))


def draw_epoch() -> int:
    """A new random epoch, never 0."""
    return secrets.randbits(64) or 1


class MotionAuthority:
    """Knows the giver that drives the robot, and the owed stop. No I/O and no clock.

    The caller holds one lock over this object and over sending.
    stored -- the memory of the process before this one
    store -- saves the memory for a restart; called before a command that changes it is sent
    """

    def __init__(self, stored: Optional[Memory] = None,
                 store: Callable[[Memory], None] = lambda memory: None,
                 draw: Callable[[], int] = draw_epoch) -> None:
        self._store, self._draw = store, draw
        self._changes: Deque[_Change] = deque(maxlen=_KEPT_EPOCHS)
        self._memory = stored or Memory(0)
        self._drive: Optional[Execution] = None  # the newest drive
        self._stop: Optional[Execution] = None  # the newest stop, until it is over
        self._stop_passed = False  # a drive that reaches the robot after `_stop` was taken
        self._stop_too_old = False  # a further stop is needed for that drive
        self._connected = False
        # Whether nothing shows yet what happened to the robot before this connection.
        self._unseen = stored is not None
        self._activity: Optional[Activity] = None  # from the last status of this connection
        self._emergency = False
        self._stopped_at = self._powered_at = self._strange_since = -math.inf
        self._replaces_since = -math.inf  # when the robot began to stop, perhaps for a new drive
        self._look_until = self._retry_at = -math.inf
        self._begin_epoch(None, Cause.RESTART, 'the controller was started', self._memory.drives)

    # --- the present state ------------------------------------------------------------------------

    @property
    def motion(self) -> Motion:
        """The state to publish now."""
        return Motion(self._memory, self._state())

    def knows(self, giver: Giver, epoch: int) -> bool:
        """Whether only `giver`, which knows `epoch`, has given commands since that epoch."""
        return epoch == self._memory.epoch or self._others_since(giver, epoch) == ()

    def stop_due(self, now: float) -> bool:
        """Whether the owed stop must be sent now; a later drive under way may make it needless."""
        return (self._memory.stop_owed and self._connected and self._stop is None
                and now >= max(self._look_until, self._retry_at)
                and not (self._drive and self._drive.result is None and self._memory.drives))

    # --- commands ---------------------------------------------------------------------------------

    def check(self, giver: Giver, command: Command, known_epoch: int) -> None:
        """Raises Overruled or Unclear if a command must not be sent."""
        if not known_epoch:
            return
        if command.spec.drives:
            if not self.knows(giver, known_epoch):
                raise Overruled(self._memory.reason)
            if self._unseen:  # the first status may begin a new epoch
                raise Unclear('Not sent, the robot has not said yet what it does.')
            if self._memory.drives and self._is_in_doubt(self._drive):
                raise Unclear('Not sent, the robot may have been stopped by another client.')
        elif command.spec.stops:
            others = self._others_since(giver, known_epoch)
            if others is not None and any(change.drives for change in others):
                raise Overruled(self._memory.reason)

    def take(self, execution: Execution) -> None:
        """Takes a command that `check` has accepted, before it is sent."""
        command, giver = execution.command, execution.giver
        if self._unseen and (command.spec.drives or command.spec.stops):
            self._unseen = False
            self._begin_epoch(None, Cause.OTHER_CLIENT, _UNSEEN, False)
        if command.spec.drives:
            memory, goals = self._memory, _goals_of(command)
            self._memory = replace(
                memory, goal=command.goals[0] if command.goals else '',
                goals=(*memory.goals, *goals)[-_KEPT_GOALS:],
                newer_goals=(*memory.newer_goals, *goals)[-_KEPT_GOALS:])
            self._drive = execution
            self._stop_passed = self._stop is not None
            self._given(giver, Cause.OTHER_GIVER, True, f'"{command.text}" of {giver.name}')
        elif command.spec.stops:
            self._begin_stop(execution)
            self._owe_stop(giver, Cause.STOP, f'"stop" of {giver.name}')
        execution.epoch = self._memory.epoch

    def take_cancellation(self, execution: Execution, canceller: Giver) -> None:
        """A giver cancels a drive; cancelling a drive that was replaced stops nothing."""
        if execution is self._drive and execution.sent:
            self._owe_stop(canceller, Cause.CANCEL, f'a cancellation of {canceller.name}')

    def take_word(self, canceller: Giver, now: float) -> None:
        """A giver cancels everything before, including drives that have not arrived here yet.

        The robot must also stop if a drive is under way, if its outcome is unknown, or if it may
        still reach the robot.
        """
        if self._memory.drives and self._may_go_on() or self._crosses(now):
            self._owe_stop(canceller, Cause.CANCEL, f'a cancellation of {canceller.name}')
        else:
            self._given(canceller, Cause.CANCEL, False, f'a cancellation of {canceller.name}')

    def take_own_stop(self, stop: Execution) -> None:
        """Takes a stop that is owed or that follows a cancellation; no giver gave it just now."""
        self._begin_stop(stop)
        if not self._memory.stop_owed:
            self._owe_stop(stop.giver, Cause.CANCEL, 'a cancellation')

    def owe_stop_without_link(self, giver: Giver) -> None:
        """A stop is given while the robot cannot be reached: it is sent when it can be."""
        self._owe_stop(giver, Cause.STOP, f'"stop" of {giver.name}')

    def may_send(self, execution: Execution) -> bool:
        """Whether a drive that was taken may still be sent to the robot now."""
        return (not execution.known_epoch or not execution.command.spec.drives
                or self.knows(execution.giver, execution.epoch))

    # --- progress of commands ---------------------------------------------------------------------

    def on_begun(self, execution: Execution) -> None:
        """The robot obeys a command."""
        if execution.command.spec.drives and execution is self._drive and self._memory.drives:
            self._replaces_since = -math.inf
            self._keep(replace(self._memory, stop_owed=False,
                               goals=_goals_of(execution.command)))

    def on_over(self, execution: Execution, outcome: Outcome, words: str, now: float) -> None:
        """A command has ended, or could not be sent."""
        if execution is self._stop:
            self._stop = None
            self._stopped_at = now
            self._retry_at = now if self._stop_too_old else now + RETRY
            if not self._stop_too_old and outcome in (
                    Outcome.SUCCEEDED, Outcome.INTERRUPTED, Outcome.EMERGENCY_STOPPED):
                self._keep(replace(self._memory, stop_owed=False))
        elif execution is self._drive and execution.command.spec.drives:
            execution.over_at = now
            if outcome is Outcome.EMERGENCY_STOPPED:
                self._see_emergency(words)
            elif self._memory.drives and self._memory.cause is Cause.OTHER_GIVER:
                if outcome is Outcome.INTERRUPTED:
                    self._foreign(Cause.OTHER_CLIENT, False, words)
                elif outcome is Outcome.TIMED_OUT and execution.stop_on_timeout:
                    self._owe_stop(execution.giver, Cause.STOP, words)

    # --- lines of the robot -----------------------------------------------------------------------

    def on_link(self, connected: bool, now: float) -> None:
        """The link to the robot came up, or broke."""
        self._connected = connected
        if not connected:
            self._unseen, self._emergency = True, False
        self._activity = None
        self._strange_since = self._replaces_since = -math.inf
        self._look_until = now + LOOK if connected and self._memory.stop_owed else -math.inf

    def on_reply(self, reply: Reply, now: float) -> None:
        """Processes a line that is no status; called before the line ends commands."""
        if isinstance(reply, Stopping):
            self._on_stopping(now)
        elif isinstance(reply, Stopped):
            if self._replaces_since > -math.inf and self._stop is None:
                self._foreign_stop('the robot stopped', now)
            self._replaces_since = -math.inf
        elif isinstance(reply, Motors) and reply.enabled:
            self._powered_at = now
            self._emergency = False
        elif isinstance(reply, EStop) and reply.pressed:
            self._see_emergency('emergency stop')

    def on_set_out(self, reply: Reply, text: str, now: float) -> None:
        """The robot begins a motion that no command of ours asked for.

        If a cancelled drive of ours may still reach the robot after that, the owed stop stays: it
        ends both motions.
        """
        activity = activity_of(reply)
        if not self._may_be_ours(activity) or not (activity.goal or self._stands_by()):
            cause = (Cause.ROBOT if activity.kind is ActivityKind.DOCKING and self._stands_by()
                     else Cause.OTHER_CLIENT)
            memory = self._memory
            if memory.stop_owed and not memory.drives and self._crosses(now):
                self._begin_epoch(None, cause, text, False)
            else:
                self._foreign(cause, True, text)

    def on_status(self, activity: Activity, text: str, now: float) -> None:
        """Processes a status of the robot."""
        before, self._activity = self._activity, activity
        kind = activity.kind
        if kind is ActivityKind.EMERGENCY_STOP:
            self._see_emergency(text)
        elif kind not in (ActivityKind.UNKNOWN, ActivityKind.MOTORS_DISABLED):
            self._emergency = False
        elsewhere = kind in MOVING and not self._may_be_ours(activity)
        if self._unseen:
            self._unseen = False
            if not self._shows_our_drive(activity) and not self._emergency:
                self._foreign(Cause.ROBOT if kind in _GAVE_UP else Cause.OTHER_CLIENT,
                              kind in MOVING, f'after an outage the robot shows "{text}"')
        if (before is None and self._memory.stop_owed and self._memory.drives and not elsewhere
                and activity.goal.casefold() in self._memory.newer_goals):
            self._keep(replace(self._memory, stop_owed=False))
        self._look_until = -math.inf
        if self._stands_by():
            self._look_at_idle(before, activity, elsewhere, text, now)

    def _look_at_idle(self, before: Optional[Activity], activity: Activity, elsewhere: bool,
                      text: str, now: float) -> None:
        """No command of ours is under way: another client caused the robot's motion."""
        if (before is not None and before.kind is ActivityKind.ARRIVED_AT_GOAL
                and self._memory.drives and before.goal.casefold() in self._memory.goals
                and activity.kind in (ActivityKind.STOPPED, ActivityKind.STOPPING)):
            self._foreign(Cause.OTHER_CLIENT, False, text)
        memory = self._memory
        if not elsewhere or memory.drives and memory.cause in _OF_THE_ROBOT:
            self._strange_since = -math.inf
        elif self._strange_since == -math.inf:
            self._strange_since = now
        elif now >= self._strange_since + AT_ONCE:
            self._foreign(Cause.OTHER_CLIENT, True, text)

    def _on_stopping(self, now: float) -> None:
        """The robot stops: because of another client, unless a command of ours explains it."""
        drive = self._drive
        if (self._stop is not None or now < max(self._stopped_at, self._powered_at) + LATE
                or drive and self._stops_about_the_dock(drive, now)):
            return
        if (drive and drive.result is None and not drive.begun and drive.replaces
                and now < drive.sent_at + AT_ONCE):
            self._replaces_since = now  # some robots stop for an instant when a drive is replaced
        else:
            self._foreign_stop('another client of the robot stopped it', now)

    @staticmethod
    def _stops_about_the_dock(drive: Execution, now: float) -> bool:
        """Whether the robot may stop by itself: between two attempts to dock, or after it has
        undocked (ARCL manual I617-E-01 p. 245)."""
        course = drive.command.spec.course
        if drive.result is not None:
            return course is Course.OUT_OF_THE_DOCK and now < drive.over_at + AT_ONCE
        return course in (Course.INTO_THE_DOCK, Course.OUT_OF_THE_DOCK) or (
            drive.set_out and not drive.begun)

    def _foreign_stop(self, words: str, now: float) -> None:
        """Another client stopped the robot; a drive sent just before may reach it after that."""
        crosses = self._crosses(now)
        self._foreign(Cause.OTHER_CLIENT, False, words)
        if crosses:
            self._keep(replace(self._memory, stop_owed=True, newer_goals=()))

    def _crosses(self, now: float) -> bool:
        """Whether the robot may have sent its last line before our drive reached it."""
        drive = self._drive
        return (drive is not None and drive.sent and not drive.begun
                and now < drive.sent_at + AT_ONCE
                and (drive.result is None or drive.result.outcome is Outcome.EMERGENCY_STOPPED))

    # --- epochs -----------------------------------------------------------------------------------

    def _given(self, giver: Giver, cause: Cause, drives: bool, reason: str) -> None:
        """A giver drives, stops or cancels. A new epoch begins, unless the same giver drives on."""
        memory = self._memory
        if drives and (giver, cause, drives) == (memory.giver, memory.cause, memory.drives):
            self._keep(memory)
        else:
            self._begin_epoch(giver, cause, reason, drives)

    def _begin_stop(self, stop: Execution) -> None:
        self._stop = stop
        self._stop_passed = self._stop_too_old = False

    def _owe_stop(self, giver: Giver, cause: Cause, reason: str) -> None:
        self._stop_too_old = self._stop_too_old or self._stop_passed
        self._retry_at = -math.inf  # the stop is new, so it need not wait for a retry
        self._memory = replace(self._memory, stop_owed=True, newer_goals=())
        self._given(giver, cause, False, reason)

    def _foreign(self, cause: Cause, drives: bool, words: str) -> None:
        """The robot acts on another client's command. If that is a drive, no stop is owed now."""
        if drives:
            self._memory = replace(self._memory, stop_owed=False, goal='', goals=())
        self._begin_epoch(None, cause, words, drives)

    def _see_emergency(self, words: str) -> None:
        if not self._emergency:
            self._emergency = True
            self._begin_epoch(None, Cause.EMERGENCY_STOP, words, False)

    def _begin_epoch(self, giver: Optional[Giver], cause: Cause, reason: str,
                     drives: bool) -> None:
        before = self._memory.epoch
        self._changes.append(_Change(before, giver, drives and cause is not Cause.RESTART))
        self._keep(replace(self._memory, epoch=self._draw(), previous_epoch=before, cause=cause,
                           giver=giver or NO_GIVER, drives=drives, reason=reason))

    def _keep(self, memory: Memory) -> None:
        self._memory = memory
        self._store(memory)

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
        under_way = self._drive is not None and self._drive.result is None
        if self._stop is not None and kind not in (ActivityKind.DOCKED, ActivityKind.UNDOCKING):
            return MotionState.STOPPING
        if kind in STANDING and kind is not ActivityKind.DOCKED:
            return MotionState.DRIVING if under_way else MotionState.STANDING
        return _STATES.get(kind, MotionState.DRIVING)

    def _stands_by(self) -> bool:
        """Whether no command of ours is under way."""
        return self._stop is None and (self._drive is None or self._drive.result is not None)

    def _may_be_ours(self, activity: Activity) -> bool:
        """Whether a command of ours may have caused this motion of the robot.

        Decides by the motion's goal. A motion without a name may be ours while a drive of ours is
        under way, or while the outcome of our last drive is unknown.
        """
        if activity.kind is ActivityKind.TELEOPERATED:
            return False
        if activity.kind is ActivityKind.DOCKING:
            return _DOCK in self._memory.goals
        goals, is_named = self._memory.goals, activity.kind is ActivityKind.GOING_TO_GOAL
        if is_named and activity.goal.casefold() in goals:
            return True
        return self._may_go_on() and (not is_named or '' in goals or _DOCK in goals)

    def _shows_our_drive(self, activity: Activity) -> bool:
        """Whether the robot visibly carries out our last drive, or has visibly completed it."""
        goals, goal = self._memory.goals, activity.goal.casefold()
        if activity.kind in MOVING:
            return ((self._memory.drives or self._memory.stop_owed)
                    and self._may_be_ours(activity))
        return self._memory.drives and {
            ActivityKind.ARRIVED_AT_GOAL: goal in goals, ActivityKind.ARRIVED_AT_POINT: '' in goals,
            ActivityKind.DOCKED: _DOCK in goals,
            ActivityKind.STOPPED: bool(goal) and goal in goals,  # the end of a route or macro
        }.get(activity.kind, False)

    def _may_go_on(self) -> bool:
        """Whether the last drive is under way, or its outcome is unknown."""
        if self._drive is None:
            return self._memory.drives or self._memory.stop_owed
        result = self._drive.result
        return result is None or result.outcome is Outcome.LOST

    @staticmethod
    def _is_in_doubt(drive: Optional[Execution]) -> bool:
        return (drive is not None and drive.result is None and drive.begun
                and drive.doubt is not None and drive.doubt.outcome is Outcome.INTERRUPTED)
