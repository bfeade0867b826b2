"""What the robot does, read from its status text: one table for all programs.

A status text is another line in itself (`Going to 12`, `DockingState: Docked ...`), and many of
those lines are also sent on their own when they become true.
"""
from __future__ import annotations

from enum import Enum
from functools import lru_cache
from typing import Any, Callable, Dict, NamedTuple, Tuple, Type

from omron_arcl.parser import parse_line
from omron_arcl.replies import driving, general, safety, tasks
from omron_arcl.replies.reply import Reply, coordinates


class ActivityKind(Enum):
    """What the robot does; the same names as in omron_ld90_msgs/RobotStatus."""

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


# Going somewhere, by whomever it was told.
MOVING = frozenset((
    ActivityKind.GOING_TO_GOAL, ActivityKind.GOING_TO_POINT, ActivityKind.PATROLLING,
    ActivityKind.DOING_TASK, ActivityKind.DOCKING, ActivityKind.UNDOCKING, ActivityKind.PARKING,
    ActivityKind.TELEOPERATED))
# On its way to a stand, or not known to stand.
_NEITHER = (ActivityKind.STOPPING, ActivityKind.UNKNOWN)
STANDING = frozenset(ActivityKind) - MOVING - frozenset(_NEITHER)


class Activity(NamedTuple):
    """What the robot does, and `goal`: where it goes to, stands, or failed to go; or a route's or
    task's name. `reply` is the line that says so."""

    kind: ActivityKind
    goal: str
    reply: Reply


@lru_cache(maxsize=256)
def read_activity(text: str) -> Activity:
    """What the status text `text` says that the robot does; remembers what was read lately."""
    return activity_of(parse_line(text))


def activity_of(reply: Reply) -> Activity:
    """What a line says that the robot does; UNKNOWN where it says nothing about that."""
    read = _TABLE.get(type(reply))
    if read is None:
        return Activity(ActivityKind.UNKNOWN, '', reply)
    return Activity(*read(reply), reply)


def _toward(goal: ActivityKind, point: ActivityKind) -> Callable[[Any], Tuple[ActivityKind, str]]:
    """About a goal by name; some robots name a point by its coordinates, as if it were one."""
    def read(reply: Any) -> Tuple[ActivityKind, str]:
        if reply.goal.lower().startswith('dock at '):
            return ActivityKind.DOCKING, reply.goal[len('dock at '):]
        return (point, '') if coordinates(reply.goal) else (goal, reply.goal)
    return read


def _always(kind: ActivityKind, field: str = '') -> Callable[[Any], Tuple[ActivityKind, str]]:
    """One kind; the goal's, route's or task's name is in `field`."""
    return lambda reply: (kind, getattr(reply, field) if field else '')


def _interrupted(reply: driving.Interrupted) -> Tuple[ActivityKind, str]:
    ran = parse_line(reply.text)
    if isinstance(ran, driving.Interrupted):
        return ActivityKind.INTERRUPTED, ''
    return ActivityKind.INTERRUPTED, activity_of(ran).goal


_OF_NOTICES = {'Teleop': ActivityKind.TELEOPERATED, 'Lost': ActivityKind.LOST,
               'Docked': ActivityKind.DOCKED, 'Undocked': ActivityKind.UNDOCKED,
               'Docking': ActivityKind.DOCKING, 'Undocking': ActivityKind.UNDOCKING}

_TABLE: Dict[Type[Reply], Callable[[Any], Tuple[ActivityKind, str]]] = {
    driving.GoingTo: _toward(ActivityKind.GOING_TO_GOAL, ActivityKind.GOING_TO_POINT),
    driving.GoingToPoint: _always(ActivityKind.GOING_TO_POINT),
    driving.ArrivedAt: _toward(ActivityKind.ARRIVED_AT_GOAL, ActivityKind.ARRIVED_AT_POINT),
    driving.ArrivedAtPoint: _always(ActivityKind.ARRIVED_AT_POINT),
    driving.FailedGoingTo: _always(ActivityKind.FAILED, 'goal'),
    driving.RobotError: _always(ActivityKind.FAILED),
    driving.Failure: _always(ActivityKind.FAILED),
    driving.Stopping: _always(ActivityKind.STOPPING),
    driving.Stopped: _always(ActivityKind.STOPPED),
    driving.Interrupted: _interrupted,
    driving.Patrolling: _always(ActivityKind.PATROLLING, 'route'),
    driving.LapCompleted: _always(ActivityKind.PATROLLING),
    driving.FinishedPatrolling: _always(ActivityKind.STOPPED, 'route'),
    driving.Parking: lambda reply: (
        ActivityKind.PARKED if reply.parked else ActivityKind.PARKING, ''),
    driving.DockingStatus: lambda reply: (ActivityKind[reply.docking.name], ''),
    tasks.WillDoTask: _always(ActivityKind.DOING_TASK, 'task'),
    tasks.DoingTask: _always(ActivityKind.DOING_TASK, 'task'),
    tasks.ExecutingMacro: _always(ActivityKind.DOING_TASK, 'macro'),
    tasks.ExecutingList: _always(ActivityKind.DOING_TASK),
    tasks.WaitState: _always(ActivityKind.DOING_TASK),
    tasks.CompletedTask: _always(ActivityKind.STOPPED, 'task'),
    tasks.CompletedMacro: _always(ActivityKind.STOPPED, 'macro'),
    tasks.FinishedList: _always(ActivityKind.STOPPED),
    safety.EStop: _always(ActivityKind.EMERGENCY_STOP),
    safety.Motors: lambda reply: (
        ActivityKind.UNKNOWN if reply.enabled else ActivityKind.MOTORS_DISABLED, ''),
    general.Notice: lambda reply: (
        _OF_NOTICES.get(reply.kind, ActivityKind.UNKNOWN), ''),
}
