"""The table of all known commands, with the replies that end each of them.

Syntax and answers follow OMRON's ARCL references (I617-E-01, and the newer I617-E-02), or real
robots if these differ. Commands that only a fleet manager has are not in the table.
"""
from __future__ import annotations

from typing import Dict, Iterable, Optional, Tuple

from omron_arcl.commands import Category, CommandSpec, Course, Predicate
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
from omron_arcl.replies import driving, equipment, general, safety, site, status, tasks
from omron_arcl.replies.driving import DockingState
from omron_arcl.replies.reply import UnknownLine

# s without a line or status about a drive that has begun, after which it has timed out
_DRIVE_TIMEOUT = 600.0
_TASKS_TIMEOUT = 3600.0  # a task may wait, and its status may show any text


def spec_of(name: str) -> CommandSpec:
    """The row for a command's name or shortcut; an unknown command ends when the robot is quiet."""
    return (COMMANDS.get(name.lower()) or _SHORTCUTS.get(name.lower())
            or CommandSpec(name, Category.UNKNOWN, completed_by=None))


def _drive(syntax: str, acknowledged_by: Predicate, completed_by: Predicate,
           related: Optional[Predicate] = None, timeout: float = _DRIVE_TIMEOUT,
           goal_at: Optional[int] = None, aborted_by: Optional[Predicate] = None,
           course: Course = Course.TO_A_PLACE, shortcut: str = '',
           adds_job: bool = False) -> CommandSpec:
    """A row for a command that takes over the wheels."""
    return CommandSpec(syntax, Category.MOTION, completed_by, acknowledged_by,
                       related or _LEAVING_THE_DOCK, aborted_by, timeout, course, goal_at,
                       shortcut, adds_job=adds_job)


def _tasks(syntax: str, acknowledged_by: Predicate, completed_by: Predicate, related: Predicate,
           goal_at: Optional[int] = None) -> CommandSpec:
    """A row for a command that takes over the wheels for several drives and other tasks."""
    return _drive(syntax, acknowledged_by, completed_by, related, _TASKS_TIMEOUT, goal_at,
                  course=Course.OF_TASKS)


def _answer(syntax: str, *kinds: type, category: Category = Category.QUERY,
            shortcut: str = '') -> CommandSpec:
    """A row for a command whose answer is one reply of one of `kinds`."""
    return CommandSpec(syntax, category, is_one_of(*kinds), shortcut=shortcut)


def _listing(syntax: str, end: str, related: Predicate,
             category: Category = Category.QUERY, shortcut: str = '') -> CommandSpec:
    """A row for a command whose answer is a list of items up to an end line."""
    return CommandSpec(syntax, category, end_of(end), related=related, shortcut=shortcut)


def _done(syntax: str, category: Category, phrase: str, related: Optional[Predicate] = None,
          shortcut: str = '') -> CommandSpec:
    """A row for a command whose answer is a confirmation that begins with `phrase`."""
    return CommandSpec(syntax, category, says(phrase), related=related, shortcut=shortcut)


def _quiet(category: Category, *syntaxes: str, **shortcuts: str) -> Iterable[CommandSpec]:
    """Rows for commands with undocumented answers: they end when the robot has been quiet."""
    return (CommandSpec(syntax, category, completed_by=None,
                        shortcut=shortcuts.get(syntax.split()[0], '')) for syntax in syntaxes)


_LEAVING_THE_DOCK = docking_is(DockingState.DOCKED, DockingState.UNDOCKING, DockingState.UNDOCKED)
_TO_A_GOAL = (driving.GoingTo, driving.ArrivedAt, driving.DockingStatus)
_ON_THE_WAY = (*_TO_A_GOAL, driving.GoingToPoint, driving.ArrivedAtPoint)
_OF_TASKS = (tasks.WillDoTask, tasks.DoingTask, tasks.CompletedTask, tasks.CompletedInstantTask,
             tasks.WaitState)

_ROWS: Tuple[CommandSpec, ...] = (
    # driving
    _drive('goto <goal> [heading]', names(driving.GoingTo), names(driving.ArrivedAt), goal_at=0),
    _drive('gotoPoint <x> <y> [heading]',
           any_of(is_one_of(driving.GoingToPoint), at_the_point(driving.GoingTo)),
           any_of(is_one_of(driving.ArrivedAtPoint), at_the_point(driving.ArrivedAt))),
    _drive('gotoRouteGoal <route> <goal>', names(driving.GoingTo), names(driving.ArrivedAt),
           goal_at=1),
    # A robot that misses its dock undocks and tries again (ARCL manual I617-E-02 p. 71).
    _drive('dock', docking_is(DockingState.DOCKING), docking_is(DockingState.DOCKED),
           related=is_one_of(*_TO_A_GOAL), timeout=180.0, course=Course.INTO_THE_DOCK),
    _drive('undock', docking_is(DockingState.UNDOCKING), docking_is(DockingState.UNDOCKED),
           timeout=60.0, aborted_by=docking_is(DockingState.DOCKING, DockingState.DOCKED),
           course=Course.OUT_OF_THE_DOCK),
    _tasks('patrol <route>', names(driving.Patrolling, 'route'), never,
           is_one_of(*_TO_A_GOAL, driving.LapCompleted, *_OF_TASKS), goal_at=0),
    *(_tasks(syntax, names(driving.Patrolling, 'route'),
             names(driving.FinishedPatrolling, 'route'),
             is_one_of(*_TO_A_GOAL, *_OF_TASKS), goal_at=0)
      for syntax in ('patrolOnce <route> [index]', 'patrolResume <route>')),
    _tasks('doTask <task> [arguments]', same_task(tasks.WillDoTask, tasks.DoingTask),
           same_task(tasks.CompletedTask),
           any_of(same_task(tasks.WillDoTask, tasks.DoingTask),
                  is_one_of(tasks.WaitState, tasks.PauseState, *_ON_THE_WAY))),
    _tasks('executeMacro <macro>', names(tasks.ExecutingMacro, 'macro'),
           names(tasks.CompletedMacro, 'macro'),
           is_one_of(*_OF_TASKS, *_ON_THE_WAY), goal_at=0),
    _tasks('listExecute', is_one_of(tasks.ExecutingList), is_one_of(tasks.FinishedList),
           is_one_of(*_OF_TASKS, *_ON_THE_WAY)),
    _drive('queueDropoff <goal> [priority] [jobId]',
           names(driving.GoingTo), names(driving.ArrivedAt), goal_at=0,
           related=any_of(says('queueDropoff'), notices('QueueUpdate'), _LEAVING_THE_DOCK),
           shortcut='qd', adds_job=True),
    # other commands that move the robot, or let it be moved
    CommandSpec('stop', Category.MOTION, is_one_of(driving.Stopped),
                acknowledged_by=is_one_of(driving.Stopping),
                related=is_one_of(driving.Interrupted), timeout=15.0),
    CommandSpec('enableMotors', Category.MOTION,
                lambda command, reply: isinstance(reply, safety.Motors) and reply.enabled),
    *(CommandSpec(syntax, Category.MOTION,
                  lambda command, reply: isinstance(reply, driving.Localizing) and reply.done,
                  related=is_one_of(driving.Localizing), timeout=30.0, needs_standing=True)
      for syntax in ('localizeToPoint <x> <y> <heading> [xySpread] [angleSpread]',
                     'localizeAtGoal <goal>')),
    _answer('doTaskInstant <task> [arguments]', tasks.CompletedInstantTask,
            category=Category.MOTION),
    _answer('waitTaskCancel', tasks.WaitState, category=Category.MOTION),
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
    CommandSpec('status', Category.QUERY, is_one_of(status.Temperature),
                related=is_one_of(
                    status.ExtendedStatus, status.StatusText, status.StateOfCharge,
                    status.BatteryVoltage, status.Location, status.LocalizationScore)),
    _answer('oneLineStatus', status.OneLineStatus),
    _answer('queryDockStatus', driving.DockingStatus),
    _answer('queryMotors', safety.Motors, safety.EStop),
    _answer('odometer', status.Odometer),
    _done('odometerReset', Category.DEVICE, 'Reset odometer'),
    _answer('getDateTime', status.DateTime),
    _answer('pauseTaskState', tasks.PauseState),
    _answer('waitTaskState', tasks.WaitState),
    _answer('distanceBetween <goal> <goal>', site.DistanceBetween),
    _listing('queueQueryLocal <type> <value> [echo]', 'QueueQuery', items('QueueQuery')),
    _listing('queueShowRobotLocal [echo]', 'QueueShowRobot', items('QueueRobot'),
             shortcut='qsrl'),
    _answer('distanceFromHere <goal>', site.DistanceFromHere),
    *_quiet(Category.QUERY, 'goalDistanceRemaining', 'etaRequest', 'arclStat', 'centralServer',
            'trackSectors', arclStat='ast'),
    # statistics and stored values of the robot
    _listing('getInfoList', 'info list', items('InfoList')),
    CommandSpec('getInfo <name>', Category.QUERY, items('Info')),
    _done('createInfo <name> <length> <value>', Category.DEVICE, 'Created info for'),
    _done('updateInfo <name> <value>', Category.DEVICE, 'Updated info for'),
    *(_listing(f'getDataStore{syntax}', f'GetDataStore{syntax.split()[0]}',
               any_of(items(f'GetDataStore{syntax.split()[0]}'), is_one_of(status.DataStoreValue)))
      for syntax in ('GroupList', 'GroupValues <group>', 'GroupInfo <group>', 'TripGroupList',
                     'FieldList', 'FieldValues <field>', 'FieldInfo <field>')),
    _listing('tripReset', 'TripReset', is_one_of(status.DataStoreValue), Category.DEVICE),
    # goals, routes, macros, map objects
    _listing('getGoals', 'goals', is_one_of(site.Goal)),
    _listing('getRoutes', 'routes', any_of(is_one_of(site.Route), items('Routes'))),
    _listing('getMacros', 'macros', is_one_of(site.Macro, UnknownLine)),
    _listing('mapObjectTypeList', 'MapObjectTypeList', items('MapObjectTypeList')),
    _listing('mapObjectTypeInfo <type>', 'MapObjectTypeInfo',
             items('MapObjectTypeList', 'MapObjectTypeInfoArgument')),
    _listing('mapObjectList <type>', 'MapObjectList', is_one_of(site.MapObjectName)),
    _listing('mapObjectInfo <name>', 'MapObjectInfo',
             any_of(items('MapObjectInfo', 'MapObjectInfoParams'), is_one_of(site.MapObjectCoord))),
    # range devices
    *(_listing(name, 'RangeDeviceList',
               any_of(is_one_of(equipment.RangeDevice), items('RangeDeviceCurrentDrawingData',
                                                    'RangeDeviceCumulativeDrawingData')))
      for name in ('rangeDeviceGetList', 'rangeDeviceList')),
    CommandSpec('rangeDeviceGetCurrent <device>', Category.QUERY, is_scan(cumulative=False)),
    CommandSpec('rangeDeviceGetCumulative <device>', Category.QUERY, is_scan(cumulative=True)),
    # configuration: reading is a query
    _listing('getConfigSectionList', 'GetConfigSectionList', items('GetConfigSectionList')),
    _listing('getConfigSectionValues <section>', 'GetConfigSectionValues',
             is_one_of(site.ConfigValue)),
    _listing('getConfigSectionInfo <section>', 'GetConfigSectionInfo',
             items('GetConfigSectionInfo', 'GetConfigSectionParamInfo')),
    *_quiet(Category.CONFIGURATION, 'scanStart', 'scanStop', 'scanAddGoal'),
    _done('configStart', Category.CONFIGURATION, 'New config starting'),
    _done('configAdd <line>', Category.CONFIGURATION, 'Added'),
    CommandSpec('configParse', Category.CONFIGURATION,
                any_of(says('Config parsed fine'), is_one_of(site.ConfigErrors)),
                timeout=60.0,
                related=any_of(says('Will parse config'),
                               is_one_of(site.MapChanged, site.ConfigurationChanged))),
    _done('newConfigParam <section> <name> <description> <priority> <type> <default> '
          '<min> <max> <hint>', Category.CONFIGURATION, 'Will add new param'),
    _done('newConfigSectionComment <section> <text>', Category.CONFIGURATION,
          'Will add config comment'),
    # faults, inputs and outputs, payload, sound
    _done('applicationFaultSet <name> <short> <long> <driving> <critical>', Category.DEVICE,
          'ApplicationFaultSet set', shortcut='afs'),
    _done('applicationFaultClear <name>', Category.DEVICE, 'ApplicationFaultClear cleared',
          shortcut='afc'),
    _listing('applicationFaultQuery', 'ApplicationFaultQuery', is_one_of(safety.Fault),
             shortcut='afq'),
    _listing('faultsGet', 'FaultList', is_one_of(safety.Fault)),
    _listing('inputList', 'InputList', any_of(items('InputList'), is_one_of(equipment.Input))),
    _listing('outputList', 'OutputList', any_of(items('OutputList'), is_one_of(equipment.Input))),
    _listing('analogInputList', 'AnalogInputList',
             items('AnalogInputList', 'AnalogInputListHelper')),
    _answer('inputQuery <name>', equipment.Input),
    _answer('outputQuery <name>', equipment.Input),
    _answer('outputOn <name>', equipment.Input, category=Category.DEVICE),
    _answer('outputOff <name>', equipment.Input, category=Category.DEVICE),
    CommandSpec('analogInputQueryRaw <name>', Category.QUERY, items('AnalogInputRaw')),
    CommandSpec('analogInputQueryVoltage <name>', Category.QUERY, items('AnalogInputVoltage')),
    *(_listing(name, name, is_one_of(equipment.ExternalIO))
      for name in ('extIODump', 'extIODumpLocal')),
    *(CommandSpec(f'extIO{side}{syntax}', Category.DEVICE,
                  names(equipment.ExternalIOUpdate, 'name'), goal_at=0)
      for side in ('Input', 'Output')
      for syntax in ('Update <name> <value>', 'UpdateBit <name> <bit> <0|1>',
                     'UpdateByte <name> <byte> <value>')),
    _done('extIOAdd <name> <inputs> <outputs>', Category.CONFIGURATION, 'extIOAdd:'),
    _listing('payloadQueryLocal [slot] [echo]', 'PayloadQuery', is_one_of(equipment.PayloadSlot)),
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
             any_of(is_one_of(general.HelpEntry, UnknownLine), items('Commands'))),
    _answer('echo [on|off]', general.Echo),
    _done('connectOutgoing <host> <port>', Category.DANGEROUS, 'Outgoing connected'),
    _done('extIORemove <name>', Category.DANGEROUS, 'extIORemove:'),  # restarts the robot's ARAM
    *_quiet(Category.DANGEROUS, 'quit', 'shutDown', 'shutDownServer', 'disableMotors',
            'freeMotors'),
)

COMMANDS: Dict[str, CommandSpec] = {spec.name.lower(): spec for spec in _ROWS}
_SHORTCUTS: Dict[str, CommandSpec] = {spec.shortcut: spec for spec in _ROWS if spec.shortcut}
