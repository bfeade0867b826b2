"""Commands that ask what the robot is doing, where, and what its laser sees."""
from __future__ import annotations

from typing import List

from omron_ld90_sim.commands.table import Call, CommandFailed, command
from omron_ld90_sim.robot import TEMPERATURE, Robot

LASER = 'Laser_1'


def location(robot: Robot) -> str:
    """The Location line: whole mm, mm, degrees."""
    pose = robot.pose
    return f'Location: {round(pose.x)} {round(pose.y)} {round(pose.theta)}'


def status_lines(robot: Robot) -> List[str]:
    """The lines of `status`, in an LD robot's order; `Temperature:` is the last."""
    charge = robot.state_of_charge
    return [f'ExtendedStatusForHumans: {robot.extended}', f'Status: {robot.status}',
            f'StateOfCharge: {charge:.1f}', location(robot),
            f'LocalizationScore: {robot.localization_score:.6f}', f'Temperature: {TEMPERATURE}']


def one_line_status(robot: Robot) -> str:
    """The line of `oneLineStatus`."""
    charge = robot.state_of_charge
    return (f'Status: {robot.status} StateOfCharge: {charge:.1f} {location(robot)} '
            f'Temperature: {TEMPERATURE}')


@command('status', "Gives the operational state of the robot")
def status(call: Call) -> None:
    """Answers the six status lines."""
    for line in status_lines(call.robot):
        call.reply(line)


@command('oneLineStatus', 'Gives the operational state of the robot in one line')
def answer_one_line_status(call: Call) -> None:
    """Answers the status in one line."""
    call.reply(one_line_status(call.robot))


@command('odometer', 'Shows the robot trip odometer')
def odometer(call: Call) -> None:
    """Answers distance, rotation and time since the last reset."""
    driven, turned, seconds = call.robot.odometer
    call.reply(f'Odometer: {driven:.0f} mm {turned:.0f} deg {seconds:.0f} sec')


@command('odometerReset', 'Resets the robot trip odometer')
def odometer_reset(call: Call) -> None:
    """Starts the trip from zero."""
    call.robot.reset_odometer()
    call.reply('Reset odometer')


@command('getGoals', 'gets a list of goals in the map')
def get_goals(call: Call) -> None:
    """Lists the goals in map order; docks are not goals."""
    for goal in call.robot.document.goals:
        call.reply(f'Goal: {goal.name}')
    call.reply('End of goals')


@command('rangeDeviceGetCurrent', 'Gets the current readings of a range device', '<name>', 1)
def range_device_get_current(call: Call) -> None:
    """Answers one scan as integer x y pairs in the map frame."""
    if call.arguments[0].lower() != LASER.lower():
        raise CommandFailed(f"No range device '{call.arguments[0]}'")
    hits = call.robot.scan().round().astype(int).ravel().tolist()
    call.reply(' '.join([f'RangeDeviceGetCurrent: {LASER}', *map(str, hits)]))
