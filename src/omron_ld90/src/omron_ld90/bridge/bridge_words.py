"""What the robot says and shows, as the events that the bridge's route follower understands."""
from __future__ import annotations

from typing import TYPE_CHECKING, Callable, Dict, List, Optional, Tuple, Type

import omron_arcl as arcl
from omron_ld90.bridge import route_protocol as p

if TYPE_CHECKING:
    from omron_ld90_msgs.msg import RobotStatus

DESCRIPTION_PATIENCE = 0.5  # s between the two lines of an error

# Lines that say what they mean by themselves.
_EVENTS: Dict[Type[arcl.Reply], Callable[..., p.RobotEvent]] = {
    arcl.replies.GoingTo: lambda line: p.GoalStarted(line.goal),
    arcl.replies.GoingToPoint: lambda line: p.GoalStarted(''),
    arcl.replies.Patrolling: lambda line: p.GoalStarted(''),
    arcl.replies.ArrivedAt: lambda line: p.GoalReached(line.goal),
    arcl.replies.FailedGoingTo: lambda line: p.RobotFailed(f'Failed going to {line.goal}'),
    arcl.replies.Interrupted: lambda line: p.MotionInterrupted(line.text),
    arcl.replies.RobotError: lambda line: p.RobotFailed(line.text),
    arcl.replies.EStop: lambda line: p.EmergencyStop(True),
    arcl.replies.Motors: lambda line: (p.EmergencyStop(False) if line.enabled
                               else p.RobotFailed('Motors disabled')),
    arcl.replies.DockingStatus: lambda line: p.Docking(line.docking.value),
    arcl.replies.UnknownCommand: lambda line: p.CommandRejected(
        line.name, f'Unknown command {line.name}'),
}

# What the status text says the robot is going to.
_SHOWN: Dict[Type[arcl.Reply], Callable[..., str]] = {
    arcl.replies.GoingTo: lambda line: line.goal,
    arcl.replies.GoingToPoint: lambda line: '',
    arcl.replies.Patrolling: lambda line: '',
}


class RobotWords:
    """Lines in, events out; keeps a refused command until the robot has said why."""

    def __init__(self) -> None:
        self._rejected: Optional[Tuple[str, float]] = None

    def line(self, text: str, now: float) -> List[p.RobotEvent]:
        """The events in a line of the ARCL server, received at `now` (s, monotonic)."""
        reply = arcl.parse_line(text)
        if isinstance(reply, arcl.replies.CommandError):
            events = self.overdue(float('inf'))
            self._rejected = (reply.command, now)
            return events
        if isinstance(reply, arcl.replies.CommandErrorDescription) and self._rejected:
            command, self._rejected = self._rejected[0], None
            return [p.CommandRejected(command, reply.text)]
        build = _EVENTS.get(type(reply))
        return [build(reply)] if build else []

    def overdue(self, now: float) -> List[p.RobotEvent]:
        """The rejection whose reason has not come in time."""
        if self._rejected is None or now - self._rejected[1] < DESCRIPTION_PATIENCE:
            return []
        command, self._rejected = self._rejected[0], None
        return [p.CommandRejected(command, f'the robot refused {command!r}')]


def status_events(status: RobotStatus) -> List[p.RobotEvent]:
    """The events in a status; the location comes last, to be judged by all the rest."""
    events: List[p.RobotEvent] = [p.EmergencyStop(status.emergency_stop)]
    if status.docking_state in {state.value for state in p.Docking}:
        events.append(p.Docking(status.docking_state))
    events += shown_events(status.status)
    if status.has_pose:
        position = status.pose.position
        events.append(p.Located(status.header.stamp.to_nsec(), position.x, position.y))
    return events


def shown_events(text: str) -> List[p.RobotEvent]:
    """The goal that a status text names, where it does."""
    doing = arcl.parse_line(text)
    shown = _SHOWN.get(type(doing))
    return [p.GoalShown(shown(doing))] if shown else []


def is_motion(command: str) -> bool:
    """Does an ARCL command make the robot drive, or stop?"""
    try:
        spec = arcl.parse_command(command).spec
    except arcl.InvalidCommand:
        return False
    return spec.drives or spec.name == 'stop'
