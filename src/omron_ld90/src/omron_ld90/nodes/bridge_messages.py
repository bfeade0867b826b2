"""What the robot's nodes say, as the events of the bridge."""
from __future__ import annotations

from typing import Dict, Optional

from omron_ld90.bridge.route_protocol import (
    CommandEnded,
    Docking,
    Ending,
    Link,
    LinkReported,
    Motion,
    RobotSeen,
)
from omron_ld90.nodes.support.command_client import NEVER_SENT
from omron_ld90.nodes.support.link_reports import words_of
from omron_ld90_msgs.msg import ExecuteCommandResult, LinkState, RobotStatus

_MOTIONS: Dict[int, Motion] = {
    RobotStatus.UNKNOWN: Motion.UNKNOWN,
    RobotStatus.STOPPED: Motion.STANDING,
    RobotStatus.STOPPING: Motion.UNKNOWN,
    RobotStatus.GOING_TO_GOAL: Motion.GOING,
    RobotStatus.ARRIVED_AT_GOAL: Motion.ARRIVED,
    RobotStatus.GOING_TO_POINT: Motion.GOING,
    RobotStatus.ARRIVED_AT_POINT: Motion.STANDING,
    RobotStatus.FAILED: Motion.FAILED,
    RobotStatus.INTERRUPTED: Motion.STANDING,
    RobotStatus.PATROLLING: Motion.GOING,
    RobotStatus.DOING_TASK: Motion.GOING,
    RobotStatus.DOCKING: Motion.DOCKING,
    RobotStatus.DOCKED: Motion.DOCKED,
    RobotStatus.UNDOCKING: Motion.UNDOCKING,
    RobotStatus.UNDOCKED: Motion.STANDING,
    RobotStatus.PARKING: Motion.GOING,
    RobotStatus.PARKED: Motion.STANDING,
    RobotStatus.TELEOPERATED: Motion.GOING,
    RobotStatus.EMERGENCY_STOP: Motion.STANDING,
    RobotStatus.MOTORS_DISABLED: Motion.STANDING,
    RobotStatus.LOST: Motion.UNKNOWN,
}
_NAMING_A_GOAL = (RobotStatus.GOING_TO_GOAL, RobotStatus.ARRIVED_AT_GOAL, RobotStatus.FAILED)
_ENDINGS: Dict[int, Ending] = {
    ExecuteCommandResult.SUCCEEDED: Ending.SUCCEEDED,
    ExecuteCommandResult.FAILED: Ending.FAILED,
    ExecuteCommandResult.INTERRUPTED: Ending.INTERRUPTED,
    ExecuteCommandResult.LOST: Ending.LOST,
    ExecuteCommandResult.TIMED_OUT: Ending.FAILED,
    ExecuteCommandResult.REFUSED: Ending.FAILED,
    ExecuteCommandResult.CANCELLED: Ending.INTERRUPTED,
    ExecuteCommandResult.EMERGENCY_STOPPED: Ending.EMERGENCY_STOPPED,
}
_DOCKING: Dict[str, Docking] = {state.value: state for state in Docking}
_LINKS: Dict[str, Link] = {link.value: link for link in Link}


def robot_seen(status: RobotStatus) -> RobotSeen:
    """What a status shows."""
    position = status.pose.position
    return RobotSeen(
        status.header.stamp.to_nsec(), _MOTIONS.get(status.activity, Motion.UNKNOWN),
        status.goal if status.activity in _NAMING_A_GOAL else '',
        _DOCKING.get(status.docking_state), status.emergency_stop,
        (position.x, position.y) if status.has_pose else None)


def command_ended(number: int, result: ExecuteCommandResult) -> CommandEnded:
    """How a command ended."""
    ending = _ENDINGS.get(result.outcome, Ending.FAILED)
    if ending is Ending.LOST and result.message.startswith(NEVER_SENT):
        ending = Ending.NEVER_SENT
    return CommandEnded(number, ending, result.message)


def link_reported(message: LinkState) -> Optional[LinkReported]:
    """How a link stands; None for what is no link of the robot."""
    link = _LINKS.get(message.link)
    if link is None:
        return None
    up = message.state == LinkState.CONNECTED
    return LinkReported(link, up, '' if up else message.reason or words_of(message.state))
