"""The sections of an LD robot's configuration, and the parameters that the simulator has in them.

The maps of real robots contain their whole configuration. The table has the sections, in their
order, and the names, types, priorities and ranges that these maps have in common. If they differ
from I617-E-02, the table follows the maps. The table contains only parameters that change the
simulator's behaviour, or that clients query from every robot.
"""
from __future__ import annotations

from functools import partial
from typing import Dict, List

from omron_ld90_sim.interface.configuration import (
    FLAG,
    REAL,
    TEXT,
    WHOLE,
    ConfigParameter,
    ConfigSection,
    RobotConfiguration,
)
from omron_ld90_sim.motion.floor import PLANNING_PITCH
from omron_ld90_sim.motion.kinematics import LD90_LIMITS

FILES = 'Files'
SERVER = 'ARCL server setup'
OUTGOING = 'Outgoing ARCL connection setup'
OUTGOING_COMMANDS = 'Outgoing ARCL commands'
DOCKING = 'Docking'
FLEET = 'Enterprise Manager Connection'
LISTS = range(1, 6)
SECTIONS = (
    'Log Config', SERVER, 'A/V Config', 'Connection timeouts', 'Destination Drawing', 'Feedback',
    OUTGOING_COMMANDS, OUTGOING, 'Payload Present Messages and Behavior',
    'Robot joystick goal button', 'Language/Location', 'Local EtherNet/IP Device Setup', DOCKING,
    'Driving problem response', 'Map Features', FILES, 'Localization Modules',
    'Localization settings', 'Path Planning Settings', 'Patrol', 'Periodic Macros',
    'Queuing Manager', 'Robot config', 'Standby', 'Teleop Settings', 'Task Features',
    'Triangle Drive To', 'Robot Type', 'Absolute Movement Maximums', 'Payload',
    'MARC Configuration', 'Custom Enterprise Queuing Tasks', FLEET,
)
_normal = partial(ConfigParameter, priority='Normal')
_detailed = partial(ConfigParameter, priority='Detailed')


def default_configuration() -> RobotConfiguration:
    """Returns a robot's configuration before any change."""
    known = _known()
    return RobotConfiguration({name: known.get(name, ConfigSection('')) for name in SECTIONS})


def _known() -> Dict[str, ConfigSection]:
    return {
        'Log Config': ConfigSection('What the robot logs', [
            _detailed('MaxSingleFileSizeMegs', REAL, '50', 'MB of one log file, 0 is any', 0.0),
            _detailed('LogTotalMaxMegs', REAL, '300', 'MB of all log files', 0.0),
            _detailed('LogTotalNumFiles', WHOLE, '0', 'Log files kept, 0 is all', 0),
            _detailed('Level', TEXT, 'Normal', 'How much is logged',
                      hint='Choices:Terse;;Normal;;Verbose')]),
        SERVER: ConfigSection('The ARCL server', [
            ConfigParameter('ArclConfig', FLAG, 'true', 'Whether ARCL may read and change this',
                            priority='Expert'),
            ConfigParameter('SessionTimeoutMins', REAL, '-1',
                            'Minutes of silence after which a client is dropped, -1 is off')]),
        OUTGOING_COMMANDS: ConfigSection('Setup of commands that can be automatically sent on the '
                                         'Outgoing ARCL connection.', _command_lists()),
        OUTGOING: ConfigSection('The connection that the robot opens', [
            _detailed('OutgoingHostname', TEXT, '', 'Where to connect to, empty is off'),
            _detailed('OutgoingPort', WHOLE, '0', 'Port to connect to, 0 is off', 0, 65535),
            _detailed('OutgoingSocketTimeoutInMins', REAL, '-1',
                      'Minutes of silence after which the robot connects again, -1 is off', -1.0),
            _detailed('SendStatusInterval', WHOLE, '0',
                      'Milliseconds between two status lines, 0 is off', 0),
            _detailed('RequireConnectionToPathPlan', FLAG, 'false',
                      'Whether the robot drives only while connected')]),
        DOCKING: ConfigSection('When the robot docks by itself', [
            _normal('AutoDock', FLAG, 'false', 'Whether the robot docks by itself'),
            _normal('AutoDockStateOfCharge', REAL, '25', 'Percent below which it docks', 0, 100),
            _normal('AutoDockIdleTime', REAL, '15', 'Idle minutes after which it docks', 0)]),
        FILES: ConfigSection('The files the robot uses', [
            _normal('Map', TEXT, '', 'The map the robot drives on')]),
        'Path Planning Settings': ConfigSection('How the robot plans its way', [
            _detailed('MaxSpeed', REAL, f'{LD90_LIMITS.speed:g}', 'Speed on a path (mm/s)'),
            _detailed('MaxRotSpeed', REAL, f'{LD90_LIMITS.path_rotation:g}',
                      'Rotation on a path (deg/s)'),
            _detailed('PlanRes', REAL, f'{PLANNING_PITCH:g}',
                      'Cells of the grid that ways are planned on (mm)', 1.0)]),
        FLEET: ConfigSection('The fleet manager, which this robot has none of', [
            ConfigParameter('Identifier', TEXT, 'robot', 'What the robot is called',
                            priority='Calibration'),
            _detailed('ConnectToEnterpriseManager', FLAG, 'false', 'Always false')]),
    }


def _command_lists() -> List[ConfigParameter]:
    """Returns the parameters of the lists, with the texts and priorities of I617-E-02 p. 105."""
    advanced = partial(ConfigParameter, priority='Advanced')
    lists = [advanced('LogOutgoingCommands', FLAG, 'false',
                      'Log the commands sent on the Outgoing ARCL connection.')]
    for n in LISTS:
        lists += [
            advanced(f'OutgoingCommands{n}', TEXT, '',
                     'ARCL commands to send on the Outgoing ARCL connection. Multiple commands '
                     'may be separated by |. Spaces are permitted.'),
            advanced(f'OutgoingCommands{n}Seconds', REAL, '0',
                     f'Interval (in sec.) at which to send the OutgoingCommands{n}. Fractional '
                     'seconds are allowed. 0 to disable.', 0.0)]
    return lists
