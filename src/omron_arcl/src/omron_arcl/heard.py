"""What the robot said about its motion on the present connection.

This module states facts about the lines. `attribution` decides which command or client a line
belongs to, and `drives` records the consequences.
"""
from __future__ import annotations

from enum import Enum
from typing import List, Optional, Set, Union

from omron_arcl import replies
from omron_arcl.activity import MOVING, STANDING, Activity, ActivityKind, activity_of
from omron_arcl.replies import Reply

# Lines that say what the robot does from now on. Other lines are answers, or belong to a command.
_TELLING = (
    replies.GoingTo, replies.GoingToPoint, replies.ArrivedAt, replies.ArrivedAtPoint,
    replies.FailedGoingTo, replies.Stopping, replies.Stopped, replies.Patrolling,
    replies.FinishedPatrolling, replies.Parking, replies.DoingTask, replies.CompletedTask,
    replies.ExecutingMacro, replies.CompletedMacro, replies.ExecutingList, replies.FinishedList,
    replies.EStop)
# Lines that begin a motion. If no command of ours requested it, another client did.
_SETTING_OUT = (replies.GoingTo, replies.GoingToPoint, replies.Patrolling, replies.ExecutingMacro,
                replies.DoingTask)


class SelfStop(Enum):
    """Why a robot may say `Stopping` by itself."""

    UNDOCKED = 'it has left its dock'
    MOTORS_ENABLED = 'its motors were enabled'
    FAULT_CLEARED = 'a fault was cleared'


class StopOf(Enum):
    """The cause of a `Stopping`."""

    US = 'a stop of ours'
    ROBOT = 'the robot itself, which stands after it'
    CLEARED_FAULT = 'the robot itself, which says no more about it'
    REPLACEMENT = 'the robot itself, which replaces its drive'
    OTHERS = 'another client'


class RobotWords:
    """The robot's words about its motion since the connection was made.

    Each attribute is one fact.

    emergency_before -- whether the emergency stop was pressed at the end of the last connection
    since -- number of the newest record of `drives` when the connection was made
    """

    def __init__(self, emergency_before: bool = False, since: int = 0) -> None:
        self._emergency_before, self.since = emergency_before, since
        self.activity: Optional[Activity] = None
        """The last activity, of a line or a status."""
        self.shown: Optional[Activity] = None
        """The last activity of a status."""
        self.strange = False
        """Whether the last status, which may be older than a line, showed a motion of others."""
        self.emergency = False
        """Whether the emergency stop is pressed, or the motors are still off after it."""
        self.moved = False
        """Whether the robot moved, or may have moved, before its last line."""
        self.broke_off = False
        """Whether the robot broke off a motion, and has not said yet what it does instead."""
        self.sets_out = False
        """Whether the last line begins a motion."""
        self.repeats = False
        """Whether the last line shows a docking state that the robot has shown before."""
        self.powered: Optional[bool] = None
        """Whether the motors are on; None: the robot has not said whether they are."""
        self.unheard_stops = 0
        """Number of stops that were sent and for which no `Stopping` has come."""
        self._stops: List[int] = []  # numbers of the stops whose `Stopping` may still come
        self._answered = 0  # number of the query that the robot answered last
        self.stopped_by_us = False
        """Whether the last `Stopped` may end a stop of ours."""
        self.will_not_stand = False
        """Whether the robot said `Stopping`, and has no reason to say `Stopped` after it."""
        self.stops_itself: Optional[SelfStop] = None
        """Why the robot may say `Stopping` next."""
        self._docking: Optional[replies.DockingState] = None
        self._released = False  # whether the emergency stop was released while the motors are off
        self._halts: Set[StopOf] = set()  # the causes of each `Stopping` since the last `Stopped`

    @property
    def emergency_told(self) -> bool:
        """Whether the emergency stop is pressed according to the robot's words.

        Until the robot speaks on this connection, its words on the last connection count.
        """
        return self.emergency or self._emergency_before and self.activity is None

    @property
    def moves(self) -> bool:
        """Whether the robot moves, or may move."""
        return self.activity is not None and self.activity.kind not in STANDING

    def said(self, reply: Reply) -> None:
        """Notes that the robot sent a line that is not a status."""
        self.moved, self.sets_out = self.moves, isinstance(reply, _SETTING_OUT)
        self.repeats = False
        if isinstance(reply, replies.DockingStatus):
            self._docking_said(reply)
        elif isinstance(reply, replies.Stopped):
            self._stands()
        elif isinstance(reply, replies.Motors):
            self._motors_said(reply.enabled)
        elif isinstance(reply, (replies.EStop, replies.RobotError)):
            self._emergency_stop_said(reply)
        elif isinstance(reply, replies.Fault) and reply.cleared and reply.driving:
            self.stops_itself = SelfStop.FAULT_CLEARED
        if isinstance(reply, replies.Interrupted):
            self.broke_off = True
        if isinstance(reply, _TELLING):
            self.broke_off = False
            self.activity = activity_of(reply)
            if self.activity.kind in MOVING:
                self.stops_itself, self.will_not_stand = None, False

    def showed(self, activity: Activity) -> None:
        """Notes that the robot sent a status."""
        self.activity = self.shown = activity
        self.moved = self.broke_off = False
        if activity.kind in (ActivityKind.EMERGENCY_STOP, ActivityKind.MOTORS_DISABLED):
            self.powered = False
        elif activity.kind is not ActivityKind.UNKNOWN:
            self.powered, self.emergency = True, False

    def _motors_said(self, enabled: bool) -> None:
        """Notes the state of the motors.

        Only a change is an event: the robot also sends the state as an answer to a query.
        """
        if enabled and not self.powered:
            self.stops_itself = SelfStop.MOTORS_ENABLED
        self.powered, self.emergency = enabled, self.emergency and not enabled

    def _emergency_stop_said(self, reply: Union[replies.EStop, replies.RobotError]) -> None:
        if reply.pressed:
            self.emergency = self.emergency and not self._released  # pressed again after a release
            self.powered, self._released = False, False
        elif isinstance(reply, replies.EStop):
            self.powered, self._released = False, True

    def begins_to_stop(self, whose: StopOf) -> None:
        """Notes that the robot says `Stopping`."""
        self._halts.add(whose)
        self.will_not_stand = whose is StopOf.REPLACEMENT or self._halts == {StopOf.CLEARED_FAULT}
        if whose is StopOf.US:
            self.unheard_stops -= 1
        elif whose is StopOf.CLEARED_FAULT:
            self.stops_itself = None

    def stop_sent(self, order: int) -> None:
        """Notes that a stop is sent. `order` is its number in the order of sending."""
        self._stops.append(order)
        self.unheard_stops += 1

    def drive_answered(self, order: int) -> None:
        """Notes that the robot answers the drive with this number in the order of sending.

        The robot answers in this order: the stops before the drive are answered, and the stops
        after the drive are not.
        """
        self.unheard_stops = sum(stop > order for stop in self._stops)

    def answered(self, order: int) -> None:
        """Notes that the robot answers a query with a status.

        The robot answers in the order of sending, but it may obey a stop a moment after its answer
        to the next query. After its answer to the second query after the stop, no `Stopping` is
        expected any more. It may be missing: some robots say it once for several stops.
        """
        self._stops = [stop for stop in self._stops if stop > self._answered]
        self.unheard_stops, self._answered = min(self.unheard_stops, len(self._stops)), order

    def forget_stop(self, order: int) -> None:
        """Notes that the robot will not answer the stop with this number in the order of sending.
        """
        self._stops = [stop for stop in self._stops if stop != order]
        self.unheard_stops = max(self.unheard_stops - 1, 0)

    def _stands(self) -> None:
        ours = self._halts & {StopOf.US, StopOf.CLEARED_FAULT}
        if ours != self._halts:  # if equal: the robot's own `Stopping` and `Stopped` will follow
            self.stops_itself = None
        self.stopped_by_us, self._halts = bool(ours) or not self._halts, set()
        self.will_not_stand = False

    def _docking_said(self, reply: replies.DockingStatus) -> None:
        """Notes the docking state.

        Only a change is an event: the robot also sends the state as an answer to a query.
        """
        before, self._docking = self._docking, reply.docking
        kind = activity_of(reply).kind
        self.repeats = self.activity is not None and self.activity.kind is kind
        if before is reply.docking:
            return
        self.sets_out = reply.docking is replies.DockingState.DOCKING and before is not None
        if reply.docking is not replies.DockingState.UNDOCKED:
            self.activity = activity_of(reply)
        elif before is replies.DockingState.UNDOCKING:
            self.activity, self.stops_itself = activity_of(reply), SelfStop.UNDOCKED
