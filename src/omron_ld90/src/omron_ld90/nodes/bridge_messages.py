"""Converts the messages of the robot's nodes into the events of the bridge."""
from __future__ import annotations

from typing import Dict, Optional

from node_lifecycle.headings import yaw_from_quaternion
from omron_arcl import ActivityKind, Outcome
from omron_arcl.records import CommandFate, MotionState
from omron_arcl.replies import DockingState
from omron_ld90.bridge.events import CommandEnded, LinkReported, MotionTold, RobotLink, RobotSeen
from omron_ld90.nodes.support.link_reports import words_of
from omron_ld90_msgs.msg import (
    ExecuteCommandResult,
    LastCommand,
    LinkState,
    Motion,
    RobotStatus,
)
from route_protocol.values import EpochCause

_KINDS: Dict[int, ActivityKind] = {getattr(RobotStatus, kind.name): kind for kind in ActivityKind}
_ENDINGS: Dict[int, Outcome] = {
    ExecuteCommandResult.NONE: Outcome.NEVER_SENT,
    ExecuteCommandResult.SUCCEEDED: Outcome.SUCCEEDED,
    ExecuteCommandResult.FAILED: Outcome.FAILED,
    ExecuteCommandResult.INTERRUPTED: Outcome.INTERRUPTED,
    ExecuteCommandResult.LOST: Outcome.LOST,
    ExecuteCommandResult.TIMED_OUT: Outcome.FAILED,
    ExecuteCommandResult.REFUSED: Outcome.FAILED,
    ExecuteCommandResult.CANCELLED: Outcome.CANCELLED,
    ExecuteCommandResult.EMERGENCY_STOPPED: Outcome.EMERGENCY_STOPPED,
    ExecuteCommandResult.NEVER_SENT: Outcome.NEVER_SENT,
    ExecuteCommandResult.OVERRULED: Outcome.OVERRULED,
}
_STATES: Dict[int, MotionState] = {int(state): state for state in MotionState}
_FATES: Dict[int, CommandFate] = {int(fate): fate for fate in CommandFate}
_DOCKING: Dict[str, DockingState] = {state.value: state for state in DockingState}
_CAUSES: Dict[int, EpochCause] = {getattr(Motion, cause.name): cause for cause in EpochCause
                                  if hasattr(Motion, cause.name)}
# In a report, STOP means a stop that came as an order, but not from the fleet manager. Such a stop
# stops the whole fleet; a stop in `motion` concerns only this robot.
_CAUSES[Motion.STOP] = EpochCause.OTHER_GIVER
_LINKS: Dict[str, RobotLink] = {link.value: link for link in RobotLink}


def robot_seen(status: RobotStatus) -> RobotSeen:
    """Returns the event for a status."""
    position = status.pose.position
    return RobotSeen(
        status.header.stamp.to_nsec(), _KINDS.get(status.activity, ActivityKind.UNKNOWN),
        _DOCKING.get(status.docking_state),
        (position.x, position.y) if status.has_pose else None,
        yaw_from_quaternion(status.pose.orientation) if status.has_pose else None)


def command_ended(number: int, result: ExecuteCommandResult) -> CommandEnded:
    """Returns the event for the result of a command."""
    return CommandEnded(number, _ENDINGS.get(result.outcome, Outcome.FAILED), result.message)


def motion_told(message: Motion, own_name: str) -> MotionTold:
    """Returns the event for a Motion message; `own_name` is the name of this node."""
    is_ours = message.giver == own_name or message.cause == Motion.EMERGENCY_STOP
    last = next((one for one in message.last_commands if one.giver == own_name),
                LastCommand(fate=LastCommand.NOT_OBEYED, foreign_epoch=message.foreign_epoch))
    return MotionTold(message.epoch, last.foreign_epoch, is_ours,
                      message.stop_owed, message.reason,
                      _CAUSES.get(message.cause, EpochCause.OTHER_GIVER),
                      _STATES.get(message.state, MotionState.UNKNOWN), message.emergency_stop,
                      message.giver == own_name and message.cause == Motion.OTHER_GIVER,
                      last.number, _FATES.get(last.fate, CommandFate.UNKNOWN),
                      message.cause == Motion.INTERRUPTED, message.giver, message.previous_epoch)


def link_reported(message: LinkState) -> Optional[LinkReported]:
    """Returns the event for the state of a link; None if it is not a link of the robot."""
    link = _LINKS.get(message.link)
    if link is None:
        return None
    up = message.state == LinkState.CONNECTED
    return LinkReported(link, up, '' if up else message.reason or words_of(message.state))
