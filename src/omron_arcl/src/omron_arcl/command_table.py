"""The table of all known commands, with the replies that end each of them.

Syntax and answers are those of OMRON's ARCL references (I617-E-01, and the newer I617-E-02). Where
real robots differ from these, the table follows the robots. Commands that only a fleet manager has
are not in the table.
"""
from __future__ import annotations

from typing import Dict, Iterable, Optional, Tuple

from omron_arcl import replies
from omron_arcl.commands import Category, CommandSpec, DriveCourse, Predicate
from omron_arcl.predicates import (
    any_of,
    at_the_point,
    docking_is,
    end_of,
    is_one_of,
    is_scan,
    items,
    names,
    never,
    notices,
    same_task,
    says,
)
from omron_arcl.replies import DockingState, UnknownLine

# s; without a line or status for so long, a drive that has begun times out
_DRIVE_TIMEOUT = 600.0
_TASKS_TIMEOUT = 3600.0  # a task may wait, and its status may show any text


def spec_of(name: str) -> CommandSpec:
    """Returns the row for a command's name or shortcut.

    For an unknown command, returns a row without a documented answer.
    """
    return (COMMANDS.get(name.lower()) or _SHORTCUTS.get(name.lower())
            or CommandSpec(name, Category.UNKNOWN, completed_by=None))


def _drive(syntax: str, acknowledged_by: Predicate, completed_by: Predicate,
           related: Optional[Predicate] = None, timeout: float = _DRIVE_TIMEOUT,
           goal_at: Optional[int] = None, aborted_by: Optional[Predicate] = None,
           course: DriveCourse = DriveCourse.TO_A_PLACE, shortcut: str = '',
           adds_job: bool = False) -> CommandSpec:
    """Returns a row for a command that drives the robot."""
    return CommandSpec(syntax, Category.MOTION, completed_by, acknowledged_by,
                       related or _LEAVING_THE_DOCK, aborted_by, timeout, course, goal_at,
                       shortcut, adds_job=adds_job)


def _tasks(syntax: str, acknowledged_by: Predicate, completed_by: Predicate, related: Predicate,
           goal_at: Optional[int] = None) -> CommandSpec:
    """Returns a row for a command that makes the robot do several drives and other tasks."""
    return _drive(syntax, acknowledged_by, completed_by, related, _TASKS_TIMEOUT, goal_at,
                  course=DriveCourse.OF_TASKS)


def _answer(syntax: str, *kinds: type, category: Category = Category.QUERY,
            shortcut: str = '') -> CommandSpec:
    """Returns a row for a command whose answer is one reply of one of `kinds`."""
    return CommandSpec(syntax, category, is_one_of(*kinds), shortcut=shortcut)


def _listing(syntax: str, end: str, related: Predicate,
             category: Category = Category.QUERY, shortcut: str = '') -> CommandSpec:
    """Returns a row for a command whose answer is a list of items up to an end line."""
    return CommandSpec(syntax, category, end_of(end), related=related, shortcut=shortcut)


def _done(syntax: str, category: Category, phrase: str, related: Optional[Predicate] = None,
          shortcut: str = '') -> CommandSpec:
    """Returns a row for a command whose answer is a confirmation that begins with `phrase`."""
    return CommandSpec(syntax, category, says(phrase), related=related, shortcut=shortcut)


def _quiet(category: Category, *syntaxes: str, **shortcuts: str) -> Iterable[CommandSpec]:
    """Returns rows for commands with undocumented answers.

    Such a command ends when the robot has been quiet for some time.
    """
    return (CommandSpec(syntax, category, completed_by=None,
                        shortcut=shortcuts.get(syntax.split()[0], '')) for syntax in syntaxes)


_LEAVING_THE_DOCK = docking_is(DockingState.DOCKED, DockingState.UNDOCKING, DockingState.UNDOCKED)
_TO_A_GOAL = (replies.GoingTo, replies.ArrivedAt, replies.DockingStatus)
_ON_THE_WAY = (*_TO_A_GOAL, replies.GoingToPoint, replies.ArrivedAtPoint)
_OF_TASKS = (replies.WillDoTask, replies.DoingTask, replies.CompletedTask,
             replies.CompletedInstantTask, replies.WaitState)

_ROWS: Tuple[CommandSpec, ...] = (
    # driving
    _drive('goto <goal> [heading]', names(replies.GoingTo), names(replies.ArrivedAt), goal_at=0),
    _drive('gotoPoint <x> <y> [heading]',
           any_of(is_one_of(replies.GoingToPoint), at_the_point(replies.GoingTo)),
           any_of(is_one_of(replies.ArrivedAtPoint), at_the_point(replies.ArrivedAt))),
    _drive('gotoRouteGoal <route> <goal>', names(replies.GoingTo), names(replies.ArrivedAt),
           goal_at=1),
    # A robot that misses its dock undocks and tries again (ARCL manual I617-E-02 p. 71).
    _drive('dock', docking_is(DockingState.DOCKING), docking_is(DockingState.DOCKED),
           related=is_one_of(*_TO_A_GOAL), timeout=180.0, course=DriveCourse.INTO_THE_DOCK),
    _drive('undock', docking_is(DockingState.UNDOCKING), docking_is(DockingState.UNDOCKED),
           timeout=60.0, aborted_by=docking_is(DockingState.DOCKING, DockingState.DOCKED),
           course=DriveCourse.OUT_OF_THE_DOCK),
    _tasks('patrol <route>', names(replies.Patrolling, 'route'), never,
           is_one_of(*_TO_A_GOAL, replies.LapCompleted, *_OF_TASKS), goal_at=0),
    *(_tasks(syntax, names(replies.Patrolling, 'route'),
             names(replies.FinishedPatrolling, 'route'),
             is_one_of(*_TO_A_GOAL, *_OF_TASKS), goal_at=0)
      for syntax in ('patrolOnce <route> [index]', 'patrolResume <route>')),
    _tasks('doTask <task> [arguments]', same_task(replies.DoingTask),
           same_task(replies.CompletedTask),
           any_of(same_task(replies.WillDoTask, replies.DoingTask),
                  is_one_of(replies.WaitState, *_ON_THE_WAY), items('PauseTask'))),
    _tasks('executeMacro <macro>', names(replies.ExecutingMacro, 'macro'),
           names(replies.CompletedMacro, 'macro'),
           is_one_of(*_OF_TASKS, *_ON_THE_WAY), goal_at=0),
    _tasks('listExecute', is_one_of(replies.ExecutingList), is_one_of(replies.FinishedList),
           is_one_of(*_OF_TASKS, *_ON_THE_WAY)),
    _drive('queueDropoff <goal> [priority] [jobId]',
           names(replies.GoingTo), names(replies.ArrivedAt), goal_at=0,
           related=any_of(says('queueDropoff'), notices('QueueUpdate'), _LEAVING_THE_DOCK),
           shortcut='qd', adds_job=True),
    # other commands that move the robot, or let it be moved
    CommandSpec('stop', Category.MOTION, is_one_of(replies.Stopped),
                related=is_one_of(replies.Interrupted), timeout=15.0),
    CommandSpec('enableMotors', Category.MOTION,
                lambda command, reply: isinstance(reply, replies.Motors) and reply.enabled),
    *(CommandSpec(syntax, Category.MOTION,
                  lambda command, reply: isinstance(reply, replies.Localizing) and reply.done,
                  related=is_one_of(replies.Localizing), timeout=30.0, needs_standing=True)
      for syntax in ('localizeToPoint <x> <y> <heading> [xySpread] [angleSpread]',
                     'localizeAtGoal <goal>')),
    _answer('doTaskInstant <task> [arguments]', replies.CompletedInstantTask,
            category=Category.MOTION),
    _answer('waitTaskCancel', replies.WaitState, category=Category.MOTION),
    _done('listStart [name]', Category.MOTION, 'Making new list',
          related=says('List being cleared')),
    _done('listAdd <task> [arguments]', Category.MOTION, 'Added task'),
    _done('queueCancelLocal <type> <value> [echo] [reason]', Category.MOTION,
          'queueCancel cancelling', related=says('queueCancel attempting'), shortcut='qcl'),
    CommandSpec('queueModifyLocal <id> <type> <value>', Category.MOTION,
                any_of(says('queueModify modifying'), says('queueModifyLocal modifying')),
                shortcut='qmodl'),
    *_quiet(Category.MOTION, 'go', 'stay', 'follow', 'pauseTaskCancel',
            'applicationBlockDrivingClear <name>',
            'applicationBlockDrivingSet <name> <short> <long>',
            applicationBlockDrivingClear='abdc', applicationBlockDrivingSet='abds'),
    # status and state
    CommandSpec('status', Category.QUERY, is_one_of(replies.Temperature),
                related=is_one_of(
                    replies.ExtendedStatus, replies.StatusText, replies.StateOfCharge,
                    replies.BatteryVoltage, replies.Location, replies.LocalizationScore)),
    _answer('oneLineStatus', replies.OneLineStatus),
    _answer('queryDockStatus', replies.DockingStatus),
    _answer('queryMotors', replies.Motors, replies.EStop),
    *(CommandSpec(syntax, Category.QUERY, items(answer)) for syntax, answer in (
        ('odometer', 'Odometer'), ('getDateTime', 'DateTime'), ('pauseTaskState', 'PauseTask'),
        ('distanceBetween <goal> <goal>', 'DistanceBetween'),
        ('distanceFromHere <goal>', 'DistanceFromHere'), ('getInfo <name>', 'Info'),
        ('analogInputQueryRaw <name>', 'AnalogInputRaw'),
        ('analogInputQueryVoltage <name>', 'AnalogInputVoltage'))),
    _done('odometerReset', Category.DEVICE, 'Reset odometer'),
    _answer('waitTaskState', replies.WaitState),
    _listing('queueQueryLocal <type> <value> [echo]', 'QueueQuery', items('QueueQuery')),
    _listing('queueShowRobotLocal [echo]', 'QueueShowRobot', items('QueueRobot'),
             shortcut='qsrl'),
    *_quiet(Category.QUERY, 'goalDistanceRemaining', 'etaRequest', 'arclStat', 'centralServer',
            'trackSectors', arclStat='ast'),
    # statistics and stored values of the robot
    _listing('getInfoList', 'info list', items('InfoList')),
    _done('createInfo <name> <length> <value>', Category.DEVICE, 'Created info for'),
    _done('updateInfo <name> <value>', Category.DEVICE, 'Updated info for'),
    *(_listing(f'getDataStore{syntax}', f'GetDataStore{syntax.split()[0]}',
               items(f'GetDataStore{syntax.split()[0]}'))
      for syntax in ('GroupList', 'GroupValues <group>', 'GroupInfo <group>', 'TripGroupList',
                     'FieldList', 'FieldValues <field>', 'FieldInfo <field>')),
    _listing('tripReset', 'TripReset', items('tripReset'), Category.DEVICE),
    # goals, routes, macros, map objects
    _listing('getGoals', 'goals', is_one_of(replies.Goal)),
    _listing('getRoutes', 'routes', any_of(is_one_of(replies.Route), items('Routes'))),
    _listing('getMacros', 'macros', is_one_of(replies.Macro, UnknownLine)),
    _listing('mapObjectTypeList', 'MapObjectTypeList', items('MapObjectTypeList')),
    _listing('mapObjectTypeInfo <type>', 'MapObjectTypeInfo',
             items('MapObjectTypeList', 'MapObjectTypeInfoArgument')),
    _listing('mapObjectList <type>', 'MapObjectList', items('MapObjectList')),
    _listing('mapObjectInfo <name>', 'MapObjectInfo',
             any_of(items('MapObjectInfo', 'MapObjectInfoParams'),
                    is_one_of(replies.MapObjectCoord))),
    # range devices
    *(_listing(name, 'RangeDeviceList',
               items('RangeDevice', 'RangeDeviceCurrentDrawingData',
                     'RangeDeviceCumulativeDrawingData'))
      for name in ('rangeDeviceGetList', 'rangeDeviceList')),
    CommandSpec('rangeDeviceGetCurrent <device>', Category.QUERY, is_scan(cumulative=False)),
    CommandSpec('rangeDeviceGetCumulative <device>', Category.QUERY, is_scan(cumulative=True)),
    # configuration: reading is a query
    _listing('getConfigSectionList', 'GetConfigSectionList', items('GetConfigSectionList')),
    _listing('getConfigSectionValues <section>', 'GetConfigSectionValues',
             is_one_of(replies.ConfigValue)),
    _listing('getConfigSectionInfo <section>', 'GetConfigSectionInfo',
             items('GetConfigSectionInfo', 'GetConfigSectionParamInfo')),
    *_quiet(Category.CONFIGURATION, 'scanStart', 'scanStop', 'scanAddGoal'),
    _done('configStart', Category.CONFIGURATION, 'New config starting'),
    _done('configAdd <line>', Category.CONFIGURATION, 'Added'),
    CommandSpec('configParse', Category.CONFIGURATION,
                any_of(says('Config parsed fine'), says('Config had errors')),
                timeout=60.0,
                related=any_of(says('Will parse config'),
                               is_one_of(replies.MapChanged, replies.ConfigurationChanged))),
    _done('newConfigParam <section> <name> <description> <priority> <type> <default> '
          '<min> <max> <hint>', Category.CONFIGURATION, 'Will add new param'),
    _done('newConfigSectionComment <section> <text>', Category.CONFIGURATION,
          'Will add config comment'),
    # faults, inputs and outputs, payload, sound
    _done('applicationFaultSet <name> <short> <long> <driving> <critical>', Category.DEVICE,
          'ApplicationFaultSet set', shortcut='afs'),
    _done('applicationFaultClear <name>', Category.DEVICE, 'ApplicationFaultClear cleared',
          shortcut='afc'),
    _listing('applicationFaultQuery', 'ApplicationFaultQuery', is_one_of(replies.Fault),
             shortcut='afq'),
    _listing('faultsGet', 'FaultList', is_one_of(replies.Fault)),
    _listing('inputList', 'InputList', any_of(items('InputList'), is_one_of(replies.Input))),
    _listing('outputList', 'OutputList', any_of(items('OutputList'), is_one_of(replies.Input))),
    _listing('analogInputList', 'AnalogInputList',
             items('AnalogInputList', 'AnalogInputListHelper')),
    _answer('inputQuery <name>', replies.Input),
    _answer('outputQuery <name>', replies.Input),
    _answer('outputOn <name>', replies.Input, category=Category.DEVICE),
    _answer('outputOff <name>', replies.Input, category=Category.DEVICE),
    *(_listing(name, name, items(f'E{name[1:]}')) for name in ('extIODump', 'extIODumpLocal')),
    *(CommandSpec(f'extIO{side}{syntax}', Category.DEVICE,
                  names(replies.ExternalIOUpdate, 'name'), goal_at=0)
      for side in ('Input', 'Output')
      for syntax in ('Update <name> <value>', 'UpdateBit <name> <bit> <0|1>',
                     'UpdateByte <name> <byte> <value>')),
    _done('extIOAdd <name> <inputs> <outputs>', Category.CONFIGURATION, 'extIOAdd:'),
    _listing('payloadQueryLocal [slot] [echo]', 'PayloadQuery',
             items('PayloadQuery', 'PayloadQueryLocal')),
    _listing('payloadSlotCountLocal', 'PayloadSlotCount', items('PayloadSlotCount')),
    _done('payloadSet <slot> <content>', Category.DEVICE, 'payloadSet on',
          related=says('payloadSet attempting')),
    _done('payloadRemove <slot>', Category.DEVICE, 'payloadRemove on',
          related=says('payloadRemove attempting')),
    _done('say <text>', Category.DEVICE, 'Saying'),
    _done('play <file>', Category.DEVICE, 'Playing'),
    _done('log <message> [level]', Category.DEVICE, 'Logging'),
    _done('popupSimple <title> <message> <button> <seconds>', Category.DEVICE,
          'Creating simple popup'),
    *_quiet(Category.DEVICE, 'arclSendText <text>', 'modeLock', 'modeUnlock',
            'clearAllObstacles'),
    # the connection, and power of the robot
    _listing('help', 'commands',
             any_of(is_one_of(replies.HelpEntry, UnknownLine), items('Commands'))),
    _answer('echo [on|off]', replies.Echo),
    _done('connectOutgoing <host> <port>', Category.DANGEROUS, 'Outgoing connected'),
    _done('extIORemove <name>', Category.DANGEROUS, 'extIORemove:'),  # restarts the robot's ARAM
    *_quiet(Category.DANGEROUS, 'quit', 'shutDown', 'shutDownServer', 'disableMotors',
            'freeMotors'),
)

COMMANDS: Dict[str, CommandSpec] = {spec.name.lower(): spec for spec in _ROWS}
_SHORTCUTS: Dict[str, CommandSpec] = {spec.shortcut: spec for spec in _ROWS if spec.shortcut}
