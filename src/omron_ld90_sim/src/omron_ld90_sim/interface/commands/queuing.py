"""The robot's part of queuing: queries of a fleet manager, or of a client in its place."""
from __future__ import annotations

from typing import Tuple

from omron_ld90_sim.behaviour.robot import Robot
from omron_ld90_sim.behaviour.states import DockingState, Motors
from omron_ld90_sim.interface.commands.table import Call, command


@command('queueShowRobotLocal', "Shows this robot's queuing status", '[echo_string]',
         shortcut='qsrl')
def queue_show_robot_local(call: Call) -> None:
    """Answers the robot's status in the terms of queuing."""
    status, detail = _status(call.robot)
    call.reply(f'QueueRobot: "{call.server.robot_name}" {status} {detail} {_echo(call, 0)}')
    call.reply('EndQueueShowRobot')


@command('queueQueryLocal', 'Queries the jobs of this robot', '<type> <string> [echo_string]', 2,
         'qql')
def queue_query_local(call: Call) -> None:
    """Lists the robot's matching jobs; without a fleet manager there are none."""
    call.reply('EndQueueQuery')


def _echo(call: Call, index: int) -> str:
    return call.arguments[index] if len(call.arguments) > index else '""'


def _status(robot: Robot) -> Tuple[str, str]:
    if robot.motors in (Motors.ESTOP, Motors.RELIEVED):
        return 'UnAvailable', 'EStopPressed'
    if robot.motors is Motors.DISABLED:
        return 'UnAvailable', 'MotorsDisabled'
    if robot.lost:
        return 'UnAvailable', 'Lost'
    if robot.blocked_by:
        kind, name = robot.blocked_by[0]
        return 'UnAvailable', name if kind == 'link' else 'FaultDriving'
    if robot.activity is not None:
        return 'InProgress', 'Driving'
    return 'Available', 'Docked' if robot.docking.state is DockingState.DOCKED else 'Available'
