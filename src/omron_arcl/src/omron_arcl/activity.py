"""The robot's activity, read from its status text with one table for all programs.

A status text has the form of another line of the robot (`Going to 12`,
`DockingState: Docked ...`). The robot also sends many of these lines without a status, at the
moment when the activity begins.
"""
from __future__ import annotations

from enum import Enum
from functools import lru_cache
from typing import Any, Callable, Dict, NamedTuple, Tuple, Type

from omron_arcl import replies
from omron_arcl.parser import parse_line
from omron_arcl.replies import Reply, coordinates


class ActivityKind(Enum):
    """The activity of the robot; the same names as in omron_ld90_msgs/RobotStatus."""

    UNKNOWN = 'unknown'
    STOPPED = 'stopped'
    STOPPING = 'stopping'
    GOING_TO_GOAL = 'going to a goal'
    ARRIVED_AT_GOAL = 'arrived at a goal'
    GOING_TO_POINT = 'going to a point'
    ARRIVED_AT_POINT = 'arrived at a point'
    FAILED = 'failed'
    INTERRUPTED = 'interrupted'
    PATROLLING = 'patrolling'
    DOING_TASK = 'doing a task'
    DOCKING = 'docking'
    DOCKED = 'docked'
    UNDOCKING = 'undocking'
    UNDOCKED = 'undocked'
    PARKING = 'parking'
    PARKED = 'parked'
    TELEOPERATED = 'driven by hand'
    EMERGENCY_STOP = 'emergency stop'
    MOTORS_DISABLED = 'motors disabled'
    LOST = 'lost'


# In these activities the robot drives, regardless of the client whose command it obeys.
MOVING = frozenset((
    ActivityKind.GOING_TO_GOAL, ActivityKind.GOING_TO_POINT, ActivityKind.PATROLLING,
    ActivityKind.DOING_TASK, ActivityKind.DOCKING, ActivityKind.UNDOCKING, ActivityKind.PARKING,
    ActivityKind.TELEOPERATED))
# In these activities the robot is about to stand, or it is unknown whether it stands.
_NEITHER = (ActivityKind.STOPPING, ActivityKind.UNKNOWN)
STANDING = frozenset(ActivityKind) - MOVING - frozenset(_NEITHER)
HALTED = (ActivityKind.STOPPING, ActivityKind.STOPPED)
"""The activities of a robot that was stopped, or that stops."""


class Activity(NamedTuple):
    """The robot's activity.

    goal -- the name of a route or task, or of the goal to which the robot drives, at which it
        stands, or which it failed to reach
    reply -- the line from which the activity was read
    """

    kind: ActivityKind
    goal: str
    reply: Reply


@lru_cache(maxsize=256)
def read_activity(text: str) -> Activity:
    """Returns the activity that the status text `text` describes. Recent results are cached."""
    return activity_of(parse_line(text))


def activity_of(reply: Reply) -> Activity:
    """Returns the activity that a line describes; UNKNOWN if the line describes none."""
    read = _TABLE.get(type(reply))
    if read is None:
        return Activity(ActivityKind.UNKNOWN, '', reply)
    return Activity(*read(reply), reply)


def _toward(goal: ActivityKind, point: ActivityKind) -> Callable[[Any], Tuple[ActivityKind, str]]:
    """Returns a reader of lines about a goal; `point`: the kind if coordinates name the goal."""
    def read(reply: Any) -> Tuple[ActivityKind, str]:
        if reply.goal.lower().startswith('dock at '):
            return ActivityKind.DOCKING, reply.goal[len('dock at '):]
        return (point, '') if coordinates(reply.goal) else (goal, reply.goal)
    return read


def _always(kind: ActivityKind, field: str = '') -> Callable[[Any], Tuple[ActivityKind, str]]:
    """Returns a reader that returns `kind` for each line.

    field -- the field of the reply that has the name of the goal, route or task; '': no field
    """
    return lambda reply: (kind, getattr(reply, field) if field else '')


def _interrupted(reply: replies.Interrupted) -> Tuple[ActivityKind, str]:
    ran = parse_line(reply.text)
    if isinstance(ran, replies.Interrupted):
        return ActivityKind.INTERRUPTED, ''
    return ActivityKind.INTERRUPTED, activity_of(ran).goal


_OF_NOTICES = {'Teleop': ActivityKind.TELEOPERATED, 'Lost': ActivityKind.LOST,
               'Docked': ActivityKind.DOCKED, 'Undocked': ActivityKind.UNDOCKED,
               'Docking': ActivityKind.DOCKING, 'Undocking': ActivityKind.UNDOCKING}

_TABLE: Dict[Type[Reply], Callable[[Any], Tuple[ActivityKind, str]]] = {
    replies.GoingTo: _toward(ActivityKind.GOING_TO_GOAL, ActivityKind.GOING_TO_POINT),
    replies.GoingToPoint: _always(ActivityKind.GOING_TO_POINT),
    replies.ArrivedAt: _toward(ActivityKind.ARRIVED_AT_GOAL, ActivityKind.ARRIVED_AT_POINT),
    replies.ArrivedAtPoint: _always(ActivityKind.ARRIVED_AT_POINT),
    replies.FailedGoingTo: _always(ActivityKind.FAILED, 'goal'),
    replies.RobotError: _always(ActivityKind.FAILED),
    replies.Failure: _always(ActivityKind.FAILED),
    replies.Stopping: _always(ActivityKind.STOPPING),
    replies.Stopped: _always(ActivityKind.STOPPED),
    replies.Interrupted: _interrupted,
    replies.Patrolling: _always(ActivityKind.PATROLLING, 'route'),
    replies.LapCompleted: _always(ActivityKind.PATROLLING),
    replies.FinishedPatrolling: _always(ActivityKind.STOPPED, 'route'),
    replies.Parking: lambda reply: (
        ActivityKind.PARKED if reply.parked else ActivityKind.PARKING, ''),
    replies.DockingStatus: lambda reply: (ActivityKind[reply.docking.name], ''),
    replies.WillDoTask: _always(ActivityKind.DOING_TASK, 'task'),
    replies.DoingTask: _always(ActivityKind.DOING_TASK, 'task'),
    replies.ExecutingMacro: _always(ActivityKind.DOING_TASK, 'macro'),
    replies.ExecutingList: _always(ActivityKind.DOING_TASK),
    replies.WaitState: _always(ActivityKind.DOING_TASK),
    replies.CompletedTask: _always(ActivityKind.STOPPED, 'task'),
    replies.CompletedMacro: _always(ActivityKind.STOPPED, 'macro'),
    replies.FinishedList: _always(ActivityKind.STOPPED),
    replies.EStop: _always(ActivityKind.EMERGENCY_STOP),
    replies.Motors: lambda reply: (
        ActivityKind.UNKNOWN if reply.enabled else ActivityKind.MOTORS_DISABLED, ''),
    replies.Notice: lambda reply: (
        _OF_NOTICES.get(reply.kind, ActivityKind.UNKNOWN), ''),
}
