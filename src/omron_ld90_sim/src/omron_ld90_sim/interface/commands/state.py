"""Queries of the robot's state, its location and its laser."""
from __future__ import annotations

from typing import Callable, Dict, List

from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.interface.commands.table import CommandCall, CommandFailed, command
from omron_ld90_sim.interface.dialect import Dialect

LASER = 'Laser_1'
TEMPERATURE = 36        # deg C
EMPTY, FULL = 22.0, 28.0    # V, of an empty and of a full battery

# A robot's own infos: those of I617-E-02 p. 124 and 126, and those that clients of real robots
# query and read as numbers. Infos that are not simulated have plausible constant values.
INFOS: Dict[str, Callable[[SimRobot], object]] = {
    'WirelessLink': lambda robot: 100,
    'WirelessQuality': lambda robot: 70,
    'Odometer(KM)': lambda robot: int(robot.base.driven / 1e6),
    'HourMeter': lambda robot: int(robot.clock.now / 3600.0),
    'Temperature(C)': lambda robot: TEMPERATURE,
    'LaserScore': lambda robot: round(robot.localization.score * 100.0),
    'LaserLock': lambda robot: int(not robot.localization.lost),
    'LaserNumSamples': lambda robot: 2000,
    'LaserNumPeaks': lambda robot: 1,
    'MPacs': lambda robot: 10,
    'Laser_1 Pacs': lambda robot: 15,
    'Flags': lambda robot: 400,
    'SBC Uptime': lambda robot: int(robot.clock.now),
    'ARAM Uptime': lambda robot: int(robot.clock.now),
    'Queue ID': lambda robot: '',
    'Queue Job ID': lambda robot: '',
    'DebugLogState': lambda robot: 'Not',
    'DebugLogSeconds': lambda robot: -1,
}


def location(robot: SimRobot) -> str:
    """Returns the Location line: x, y (mm) and heading (degrees) as whole numbers."""
    x, y, theta = (int(round(value)) for value in (robot.pose.x, robot.pose.y, robot.pose.theta))
    return f'Location: {x} {y} {theta}'


def _battery(robot: SimRobot, dialect: Dialect) -> str:
    """Returns the battery's field: percent, or volts as in ARCL manual I617-E-01 p. 240."""
    percent = robot.docking.percent
    return (f'BatteryVoltage: {EMPTY + percent * (FULL - EMPTY) / 100.0:.1f}' if dialect.volts
            else f'StateOfCharge: {percent:.1f}')


def status_lines(robot: SimRobot, dialect: Dialect) -> List[str]:
    """Returns the lines of `status`, in an LD robot's order; `Temperature:` is the last."""
    extended = [f'ExtendedStatusForHumans: {robot.extended}'] if dialect.extended else []
    return [*extended, f'Status: {robot.status}', _battery(robot, dialect), location(robot),
            f'LocalizationScore: {robot.localization.score:.6f}', f'Temperature: {TEMPERATURE}']


def one_line_status(robot: SimRobot, dialect: Dialect) -> str:
    """Returns the line of `oneLineStatus`."""
    return (f'Status: {robot.status} {_battery(robot, dialect)} {location(robot)} '
            f'Temperature: {TEMPERATURE}')


@command('status', "Gives the operational state of the robot")
def status(call: CommandCall) -> None:
    """Answers the six status lines."""
    for line in status_lines(call.robot, call.server.dialect):
        call.reply(line)


@command('oneLineStatus', 'Gives the operational state of the robot in one line')
def answer_one_line_status(call: CommandCall) -> None:
    """Answers the status in one line."""
    call.reply(one_line_status(call.robot, call.server.dialect))


@command('odometer', 'Shows the robot trip odometer')
def odometer(call: CommandCall) -> None:
    """Answers distance, rotation and time since the last reset."""
    driven, turned, seconds = call.robot.odometer.trip
    call.reply(f'Odometer: {driven:.0f} mm {turned:.0f} deg {seconds:.0f} sec')


@command('odometerReset', 'Resets the robot trip odometer')
def odometer_reset(call: CommandCall) -> None:
    """Starts the trip from zero."""
    call.robot.odometer.reset()
    call.reply('Reset odometer')


@command('getGoals', 'gets a list of goals in the map (for use with goto)')
def get_goals(call: CommandCall) -> None:
    """Lists the goals in map order; docks are not goals."""
    for goal in call.robot.document.goals:
        name = f'"{goal.name}"' if call.server.dialect.quoted_goals else goal.name
        call.reply(f'Goal: {name}')
    call.reply('End of goals')


@command('rangeDeviceGetCurrent', 'Gets the current readings of a range device', '<name>', 1)
def range_device_get_current(call: CommandCall) -> None:
    """Answers one scan as integer x y pairs in the map frame."""
    if call.arguments[0].lower() != LASER.lower():
        raise CommandFailed(f"No range device '{call.arguments[0]}'")
    hits = call.robot.scan().round().astype(int).ravel().tolist()
    call.reply(' '.join([f'RangeDeviceGetCurrent: {LASER}', *map(str, hits)]))


@command('rangeDeviceGetCumulative', 'Gets the cumulative readings of a range device', '<name>', 1)
def range_device_get_cumulative(call: CommandCall) -> None:
    """Answers at most 200 points that were seen in the last 30 s, and are within 4 m."""
    if call.arguments[0].lower() != LASER.lower():
        raise CommandFailed(f"No range device '{call.arguments[0]}'")
    call.robot.scan()
    kept = call.robot.scanner.cumulative(call.robot.pose).round().astype(int).ravel().tolist()
    call.reply(' '.join([f'RangeDeviceGetCumulative: {LASER}', *map(str, kept)]))


@command('rangeDeviceGetList', 'Gets the list of range devices')
@command('rangeDeviceList', 'Gets the list of range devices')
def range_device_get_list(call: CommandCall) -> None:
    """Lists the laser and its drawing data."""
    call.reply(f'RangeDevice: {LASER} LASER')
    call.reply(f'RangeDeviceCurrentDrawingData: {LASER} polyDots 0x0000ff 0x000000 80 75 DefaultOn')
    call.reply(f'RangeDeviceCumulativeDrawingData: {LASER} polyDots 0x0000ff 0x000000 80 75 '
               f'DefaultOn')
    call.reply('EndOfRangeDeviceList')


@command('getDateTime', 'gets the date and time')
def get_date_time(call: CommandCall) -> None:
    """Answers the wall clock."""
    call.reply(f'DateTime: {call.server.date_time}')


@command('getInfoList', 'Gets the list of information')
def get_info_list(call: CommandCall) -> None:
    """Lists the robot's own infos and those that clients have created."""
    for name in (*INFOS, *call.robot.equipment.infos):
        call.reply(f'InfoList: {name}')
    call.reply('End of info list')


@command('getInfo', 'Gets a piece of information', '<infoName>', 1)
def get_info(call: CommandCall) -> None:
    """Answers one info; the robot's own infos may have blanks in their names, without quotes."""
    name, own = call.text, call.robot.equipment.infos
    if name in INFOS:
        value = INFOS[name](call.robot)
    elif call.arguments[0] in own:
        name = call.arguments[0]
        value = own[name][1]
    else:
        raise CommandFailed(f"No info '{name}'")
    call.reply(f'Info: {name} {value}'.rstrip())


@command('createInfo', 'creates a piece of information', '<infoName> <maxLen> <infoValue>', 3)
def create_info(call: CommandCall) -> None:
    """Creates an info. If the value has no quotes, only its first word counts. The value is cut to
    `<maxLen>` characters.
    """
    name, length = call.arguments[0], int(call.number(1))
    if name in INFOS:
        raise CommandFailed(f"Info '{name}' is the robot's own")
    call.robot.equipment.infos[name] = (length, call.arguments[2][:max(length, 0)])
    call.reply(f'Created info for {name}')


@command('updateInfo', 'updates a piece of information', '<infoName> <infoValue>', 2)
def update_info(call: CommandCall) -> None:
    """Changes an info that a client has created."""
    name = call.arguments[0]
    if name not in call.robot.equipment.infos:
        raise CommandFailed(f"No info '{name}'")
    length = call.robot.equipment.infos[name][0]
    call.robot.equipment.infos[name] = (length, call.arguments[1][:max(length, 0)])
    call.reply(f'Updated info for {name}')
