"""The robot's part of queuing: the commands that a fleet manager, or a client like it, sends."""
from __future__ import annotations

from dataclasses import replace
from typing import Tuple

from omron_ld90_sim.behaviour import activities
from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.behaviour.states import DockingPhase, MotorState, Script
from omron_ld90_sim.interface.commands.driving import check_drivable, find_goal
from omron_ld90_sim.interface.commands.table import CommandCall, command


@command('queueShowRobotLocal', "Shows this robot's queuing status", '[echo_string]',
         shortcut='qsrl')
def queue_show_robot_local(call: CommandCall) -> None:
    """Answers the robot's status in the terms of queuing."""
    status, detail = _status(call.robot)
    call.reply(f'QueueRobot: "{call.server.robot_name}" {status} {detail} {_echo(call, 0)}')
    call.reply('EndQueueShowRobot')


@command('queueQueryLocal', 'Queries the jobs of this robot', '<type> <string> [echo_string]', 2,
         'qql')
def queue_query_local(call: CommandCall) -> None:
    """Lists the robot's matching jobs; without a fleet manager there are none."""
    call.reply('EndQueueQuery')


@command('queueDropoff', 'Queues a drop-off', '<goalName> [priority] [jobId]', 1, 'qd')
def queue_dropoff(call: CommandCall) -> None:
    """Drives to a goal as a job of the robot's own queue (ARCL manual I617-E-01 p. 198)."""
    goal = find_goal(call, call.arguments[0])
    priority, server = int(call.number(1, 20.0)), call.server
    check_drivable(call)
    number = server.next_job()
    job = call.arguments[2] if len(call.arguments) > 2 else f'JOB{number}'
    task = f'DROPOFF{number}'
    queued = server.date_time

    def update(status: str, detail: str) -> None:
        finished = server.date_time if status == 'Completed' else 'None None'
        server.broadcast(f'QueueUpdate: {task} {job} {priority} {status} {detail} Goal '
                         f'"{goal.name}" "{server.robot_name}" {queued} {finished} 0')

    drive = activities.go_to_goal(call.robot, goal)

    def script() -> Script:
        update('InProgress', 'Driving')
        yield from drive.script
        update('Completed', 'None')

    call.reply(f'queuedropoff attempting to queue goal "{goal.name}" with priority {priority}')
    call.reply(f'queuedropoff goal "{goal.name}" with priority {priority}, id {task} and job_id '
               f'{job} successfully queued')
    update('Pending', 'None')
    call.robot.start(replace(drive, script=script()))


def _echo(call: CommandCall, index: int) -> str:
    return call.arguments[index] if len(call.arguments) > index else '""'


def _status(robot: SimRobot) -> Tuple[str, str]:
    if robot.permission.motors in (MotorState.ESTOP, MotorState.RELIEVED):
        return 'UnAvailable', 'EStopPressed'
    if robot.permission.motors is MotorState.DISABLED:
        return 'UnAvailable', 'MotorsDisabled'
    if robot.localization.lost:
        return 'UnAvailable', 'Lost'
    if robot.permission.blocked_by:
        kind, name = robot.permission.blocked_by[0]
        return 'UnAvailable', name if kind == 'link' else 'FaultDriving'
    if robot.activity is not None:
        return 'InProgress', 'Driving'
    return 'Available', 'Docked' if robot.docking.state is DockingPhase.DOCKED else 'Available'
