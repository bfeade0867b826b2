"""Instant tasks: they end at once, during any activity (`doTaskInstant`, routes, macros).

The maps of real robots (`TaskInfo:`) show which tasks are instant, and their arguments.
"""
from __future__ import annotations

from functools import partial
from typing import Callable, Dict

from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.behaviour.states import ActivityFailure, DockingPhase
from omron_ld90_sim.behaviour.task import RobotTask, find_goal
from omron_ld90_sim.devices.equipment import ApplicationFault, find_name
from omron_ld90_sim.devices.localization import FOUND_WITHIN
from omron_ld90_sim.motion.kinematics import SimPose

InstantTask = Callable[[SimRobot, RobotTask], None]


# -- shared with the commands of the same names ----------------------------------------------

def set_fault(robot: SimRobot, fault: ApplicationFault) -> None:
    """Raises a fault of an application.

    A driving fault stops the robot and keeps it from driving.
    """
    robot.equipment.faults[fault.name] = fault
    robot.announce(f'Fault: {fault}')
    if fault.driving:
        robot.permission.block('fault', fault.name)


def clear_fault(robot: SimRobot, name: str) -> bool:
    """Clears a fault of an application. Returns False if no fault has that name.

    A robot that may drive again sends a single `Stopping` (ARCL manual I617-E-02 p. 57).
    """
    fault = robot.equipment.faults.pop(name, None)
    if fault is None:
        return False
    freed = robot.permission.unblock('fault', name) and robot.can_drive
    robot.announce(f'FaultCleared: {fault}')
    if freed and robot.docking.state is DockingPhase.UNDOCKED:
        robot.announce('Stopping')
    return True


def localize(robot: SimRobot, pose: SimPose, xy_spread: float, angle_spread: float) -> None:
    """Searches for the robot around `pose`, within the spreads (mm, degrees; -1: the default)."""
    found_xy, found_angle = FOUND_WITHIN
    robot.localize(pose, (xy_spread if xy_spread > 0 else found_xy,
                          angle_spread if angle_spread > 0 else found_angle))


# -- the tasks -------------------------------------------------------------------------------

def _without_a_word(robot: SimRobot, task: RobotTask) -> None:
    """Carries out a task that only a person at the robot notices (I617-E-02 p. 32, 74)."""


def _send_text(robot: SimRobot, task: RobotTask) -> None:
    robot.announce(task.words[0])


def _set_fault(robot: SimRobot, task: RobotTask) -> None:
    name, short, long, *flags = task.words
    driving, critical = [*(flag.lower() in ('true', '1') for flag in flags), False, False][:2]
    set_fault(robot, ApplicationFault(name, short, long, driving, critical))


def _clear_fault(robot: SimRobot, task: RobotTask) -> None:
    clear_fault(robot, task.words[0])


def _block(robot: SimRobot, task: RobotTask) -> None:
    robot.permission.block('application', task.words[0])


def _unblock(robot: SimRobot, task: RobotTask) -> None:
    robot.permission.unblock('application', task.words[0])


def _output(robot: SimRobot, task: RobotTask, on: bool) -> None:
    name = find_name(robot.equipment.outputs, task.words[0])
    if name is None:
        raise ActivityFailure(f"No output '{task.words[0]}'", f'Failed {task}')
    robot.equipment.outputs[name] = on


def _localize_at_goal(robot: SimRobot, task: RobotTask) -> None:
    goal = find_goal(robot.document, task.words[0])
    if goal is None:
        raise ActivityFailure(f"No goal '{task.words[0]}'", f'Failed {task}')
    heading = goal.theta if goal.has_heading else robot.true_pose.theta
    localize(robot, SimPose(goal.x, goal.y, heading), task.number(1, -1.0), task.number(2, -1.0))


def _limit_speed(robot: SimRobot, task: RobotTask, lasting: bool) -> None:
    """Limits the speed for the arguments `<importance> <forward mm/s>...`; 0 mm/s: no limit.

    lasting -- whether the limit also holds for later activities
    """
    speed = task.number(1)
    robot.navigation.speed_limit = speed if speed > 0 else None
    if lasting:
        robot.quirks.speed_limit = robot.navigation.speed_limit


def _enable_motors(robot: SimRobot, task: RobotTask) -> None:
    robot.permission.enable_motors()


def _cancel_wait(robot: SimRobot, task: RobotTask) -> None:
    robot.tasks.waiting = ''


INSTANT: Dict[str, InstantTask] = {
    'sayinstant': _without_a_word, 'playinstant': _without_a_word, 'popupsimple': _without_a_word,
    'pathplanningsettingstemp': _without_a_word,
    'movementparameterstemp': partial(_limit_speed, lasting=False),
    'movementparameters': partial(_limit_speed, lasting=True),
    'arclsendtext': _send_text,
    'applicationfaultset': _set_fault, 'applicationfaultclear': _clear_fault,
    'applicationblockdrivingset': _block, 'applicationblockdrivingclear': _unblock,
    'customoutputon': partial(_output, on=True), 'customoutputoff': partial(_output, on=False),
    'localizeatgoal': _localize_at_goal,
    'enablemotorsinstant': _enable_motors,
    'waitcancel': _cancel_wait,
}
