"""Every command that is known, and how it ends: one table.

Syntax and answers are those of OMRON's ARCL references (I617-E-01, and the newer I617-E-02), or of
real robots where they differ. Commands that only a fleet manager has are not in it.
"""
from __future__ import annotations

from typing import Dict, Iterable, Optional, Tuple

from omron_ld90.arcl.command_spec import Category, CommandSpec, Test
from omron_ld90.arcl.replies.configuration import ConfigErrors, ConfigurationChanged, ConfigValue
from omron_ld90.arcl.replies.driving import (
    ArrivedAt,
    ArrivedAtPoint,
    DockingState,
    DockingStatus,
    FinishedPatrolling,
    GoingTo,
    GoingToPoint,
    Interrupted,
    LapCompleted,
    Localizing,
    Patrolling,
    Stopped,
    Stopping,
)
from omron_ld90.arcl.replies.equipment import (
    ExternalIO,
    ExternalIOUpdate,
    Input,
    PayloadSlot,
    RangeDevice,
    RangeReading,
)
from omron_ld90.arcl.replies.general import Echo, HelpEntry, Notice
from omron_ld90.arcl.replies.reply import UnknownLine
from omron_ld90.arcl.replies.safety import EStop, Fault, Motors
from omron_ld90.arcl.replies.site import (
    DistanceBetween,
    Goal,
    Macro,
    MapChanged,
    MapObjectCoord,
    MapObjectName,
    Route,
)
from omron_ld90.arcl.replies.status import (
    BatteryVoltage,
    DataStoreValue,
    DateTime,
    ExtendedStatus,
    LocalizationScore,
    Location,
    Odometer,
    OneLineStatus,
    StateOfCharge,
    StatusText,
    Temperature,
)
from omron_ld90.arcl.replies.tasks import (
    CompletedInstantTask,
    CompletedMacro,
    CompletedTask,
    DoingTask,
    ExecutingList,
    ExecutingMacro,
    FinishedList,
    PauseState,
    WaitState,
    WillDoTask,
)
from omron_ld90.arcl.reply_tests import (
    any_of,
    at_the_point,
    docking_is,
    end_of,
    is_one_of,
    items,
    names,
    same_task,
    says,
)


def spec_of(name: str) -> CommandSpec:
    """The row for a command's name; an unknown one ends when the robot has been quiet."""
    return COMMANDS.get(name.lower()) or CommandSpec(name, Category.UNKNOWN, ends=None)


def _drive(syntax: str, begins: Test, ends: Test, belongs: Optional[Test] = None,
           silence: Optional[float] = None, goal_at: Optional[int] = None,
           undone: Optional[Test] = None) -> CommandSpec:
    """It takes the wheels over."""
    belongs = belongs or is_one_of(DockingStatus)  # while it leaves the dock
    return CommandSpec(syntax, Category.MOTION, ends, begins, belongs, undone, silence,
                       drives=True, goal_at=goal_at)


def _answer(syntax: str, *kinds: type, category: Category = Category.QUERY) -> CommandSpec:
    """One reply of one of `kinds` is all."""
    return CommandSpec(syntax, category, is_one_of(*kinds))


def _listing(syntax: str, end: str, belongs: Test,
             category: Category = Category.QUERY) -> CommandSpec:
    """Items up to an end line."""
    return CommandSpec(syntax, category, end_of(end), belongs=belongs)


def _done(syntax: str, category: Category, phrase: str,
          belongs: Optional[Test] = None) -> CommandSpec:
    """A confirmation is all."""
    return CommandSpec(syntax, category, says(phrase), belongs=belongs)


def _quiet(syntaxes: Iterable[str], category: Category) -> Iterable[CommandSpec]:
    """Commands whose answer is undocumented: they end when the robot has been quiet."""
    return (CommandSpec(syntax, category, ends=None) for syntax in syntaxes)


_ON_THE_WAY = (GoingTo, GoingToPoint, ArrivedAt, ArrivedAtPoint, DockingStatus)
_OF_TASKS = (WillDoTask, DoingTask, CompletedTask, CompletedInstantTask, WaitState)

_ROWS: Tuple[CommandSpec, ...] = (
    # driving
    _drive('goto <goal> [heading]', names(GoingTo), names(ArrivedAt), goal_at=0),
    _drive('gotoPoint <x> <y> [heading]', any_of(is_one_of(GoingToPoint), at_the_point(GoingTo)),
           any_of(is_one_of(ArrivedAtPoint), at_the_point(ArrivedAt))),
    _drive('gotoRouteGoal <route> <goal>', names(GoingTo), names(ArrivedAt), goal_at=1),
    _drive('dock', docking_is(DockingState.DOCKING), docking_is(DockingState.DOCKED),
           belongs=is_one_of(DockingStatus, GoingTo, ArrivedAt), silence=180.0,
           undone=docking_is(DockingState.UNDOCKED)),
    _drive('undock', docking_is(DockingState.UNDOCKING), docking_is(DockingState.UNDOCKED),
           silence=60.0, undone=docking_is(DockingState.DOCKING, DockingState.DOCKED)),
    _drive('patrol <route>', names(Patrolling, 'route'), lambda command, reply: False,
           belongs=is_one_of(GoingTo, ArrivedAt, LapCompleted, DockingStatus), goal_at=0),
    *(_drive(syntax, names(Patrolling, 'route'), names(FinishedPatrolling, 'route'),
             belongs=is_one_of(GoingTo, ArrivedAt, DockingStatus), goal_at=0)
      for syntax in ('patrolOnce <route> [index]', 'patrolResume <route>')),
    _drive('doTask <task> [arguments]', same_task(WillDoTask, DoingTask),
           same_task(CompletedTask),
           belongs=any_of(same_task(WillDoTask, DoingTask), is_one_of(WaitState, *_ON_THE_WAY))),
    _drive('executeMacro <macro>', names(ExecutingMacro, 'macro'), names(CompletedMacro, 'macro'),
           belongs=is_one_of(*_OF_TASKS, *_ON_THE_WAY), goal_at=0),
    _drive('listExecute', is_one_of(ExecutingList), is_one_of(FinishedList),
           belongs=is_one_of(*_OF_TASKS)),
    _drive('queueDropoff <goal> [priority] [jobId]', names(GoingTo), names(ArrivedAt),
           belongs=any_of(says('queueDropoff'), is_one_of(Notice, DockingStatus)), goal_at=0),
    # what else moves the robot, or lets it be moved
    CommandSpec('stop', Category.MOTION, is_one_of(Stopped), begins=is_one_of(Stopping),
                belongs=is_one_of(Interrupted), silence=15.0),
    CommandSpec('enableMotors', Category.MOTION,
                lambda command, reply: isinstance(reply, Motors) and reply.enabled),
    *(CommandSpec(syntax, Category.MOTION,
                  lambda command, reply: isinstance(reply, Localizing) and reply.done,
                  belongs=is_one_of(Localizing), silence=30.0)
      for syntax in ('localizeToPoint <x> <y> <heading> [xySpread] [angleSpread]',
                     'localizeAtGoal <goal>')),
    _answer('doTaskInstant <task> [arguments]', CompletedInstantTask, category=Category.MOTION),
    _answer('waitTaskCancel', WaitState, category=Category.MOTION),
    _done('listStart [name]', Category.MOTION, 'Making new list',
          belongs=says('List being cleared')),
    _done('listAdd <task> [arguments]', Category.MOTION, 'Added task'),
    _done('queueCancelLocal <type> <value> [echo] [reason]', Category.MOTION,
          'queueCancel cancelling', belongs=says('queueCancel attempting')),
    CommandSpec('queueModifyLocal <id> <type> <value>', Category.MOTION,
                any_of(says('queueModify modifying'), says('queueModifyLocal modifying'))),
    *_quiet(('go', 'stay', 'follow', 'pauseTaskCancel', 'applicationBlockDrivingClear <name>',
             'applicationBlockDrivingSet <name> <short> <long>'), Category.MOTION),
    # status and state
    CommandSpec('status', Category.QUERY, is_one_of(Temperature),
                belongs=is_one_of(ExtendedStatus, StatusText, StateOfCharge, BatteryVoltage,
                                  Location, LocalizationScore)),
    _answer('oneLineStatus', OneLineStatus),
    _answer('queryDockStatus', DockingStatus),
    _answer('queryMotors', Motors, EStop),
    _answer('odometer', Odometer),
    _done('odometerReset', Category.DEVICE, 'Reset odometer'),
    _answer('getDateTime', DateTime),
    _answer('pauseTaskState', PauseState),
    _answer('waitTaskState', WaitState),
    _answer('distanceBetween <goal> <goal>', DistanceBetween),
    _listing('queueQueryLocal <type> <value> [echo]', 'QueueQuery', items('QueueQuery')),
    _listing('queueShowRobotLocal [echo]', 'QueueShowRobot', items('QueueRobot')),
    *_quiet(('goalDistanceRemaining', 'etaRequest', 'distanceFromHere', 'arclStat',
             'centralServer', 'trackSectors'), Category.QUERY),
    # what the robot counts and keeps
    _listing('getInfoList', 'info list', items('InfoList')),
    CommandSpec('getInfo <name>', Category.QUERY, items('Info')),
    _done('createInfo <name> <length> <value>', Category.DEVICE, 'Created info for'),
    _done('updateInfo <name> <value>', Category.DEVICE, 'Updated info for'),
    *(_listing(f'getDataStore{syntax}', f'GetDataStore{syntax.split()[0]}',
               any_of(items(f'GetDataStore{syntax.split()[0]}'), is_one_of(DataStoreValue)))
      for syntax in ('GroupList', 'GroupValues <group>', 'GroupInfo <group>', 'TripGroupList',
                     'FieldList', 'FieldValues <field>', 'FieldInfo <field>')),
    _listing('tripReset', 'TripReset', is_one_of(DataStoreValue), Category.DEVICE),
    # goals, routes, macros, map objects
    _listing('getGoals', 'goals', is_one_of(Goal)),
    _listing('getRoutes', 'routes', any_of(is_one_of(Route), items('Routes'))),
    _listing('getMacros', 'macros', is_one_of(Macro, UnknownLine)),
    _listing('mapObjectTypeList', 'MapObjectTypeList', items('MapObjectTypeList')),
    _listing('mapObjectTypeInfo <type>', 'MapObjectTypeInfo',
             items('MapObjectTypeList', 'MapObjectTypeInfoArgument')),
    _listing('mapObjectList <type>', 'MapObjectList', is_one_of(MapObjectName)),
    _listing('mapObjectInfo <name>', 'MapObjectInfo',
             any_of(items('MapObjectInfo', 'MapObjectInfoParams'), is_one_of(MapObjectCoord))),
    # range devices
    *(_listing(name, 'RangeDeviceList',
               any_of(is_one_of(RangeDevice), items('RangeDeviceCurrentDrawingData',
                                                    'RangeDeviceCumulativeDrawingData')))
      for name in ('rangeDeviceGetList', 'rangeDeviceList')),
    CommandSpec('rangeDeviceGetCurrent <device>', Category.QUERY,
                lambda command, reply: isinstance(reply, RangeReading) and not reply.cumulative),
    CommandSpec('rangeDeviceGetCumulative <device>', Category.QUERY,
                lambda command, reply: isinstance(reply, RangeReading) and reply.cumulative),
    # configuration: reading is a query
    _listing('getConfigSectionList', 'GetConfigSectionList', items('GetConfigSectionList')),
    _listing('getConfigSectionValues <section>', 'GetConfigSectionValues', is_one_of(ConfigValue)),
    _listing('getConfigSectionInfo <section>', 'GetConfigSectionInfo',
             items('GetConfigSectionInfo', 'GetConfigSectionParamInfo')),
    _done('configStart', Category.CONFIGURATION, 'New config starting'),
    _done('configAdd <line>', Category.CONFIGURATION, 'Added'),
    CommandSpec('configParse', Category.CONFIGURATION,
                any_of(says('Config parsed fine'), is_one_of(ConfigErrors)), silence=60.0,
                belongs=any_of(says('Will parse config'),
                               is_one_of(MapChanged, ConfigurationChanged))),
    _done('newConfigParam <section> <name> <description> <priority> <type> <default> '
          '<min> <max> <hint>', Category.CONFIGURATION, 'Will add new param'),
    _done('newConfigSectionComment <section> <text>', Category.CONFIGURATION,
          'Will add config comment'),
    # faults, inputs and outputs, payload, sound
    _done('applicationFaultSet <name> <short> <long> <driving> <critical>', Category.DEVICE,
          'ApplicationFaultSet set'),
    _done('applicationFaultClear <name>', Category.DEVICE, 'ApplicationFaultClear cleared'),
    _listing('applicationFaultQuery', 'ApplicationFaultQuery', is_one_of(Fault)),
    _listing('faultsGet', 'FaultList', is_one_of(Fault)),
    _listing('inputList', 'InputList', any_of(items('InputList'), is_one_of(Input))),
    _listing('outputList', 'OutputList', any_of(items('OutputList'), is_one_of(Input))),
    _listing('analogInputList', 'AnalogInputList',
             items('AnalogInputList', 'AnalogInputListHelper')),
    _answer('inputQuery <name>', Input),
    _answer('outputQuery <name>', Input),
    _answer('outputOn <name>', Input, category=Category.DEVICE),
    _answer('outputOff <name>', Input, category=Category.DEVICE),
    CommandSpec('analogInputQueryRaw <name>', Category.QUERY, items('AnalogInputRaw')),
    CommandSpec('analogInputQueryVoltage <name>', Category.QUERY, items('AnalogInputVoltage')),
    *(_listing(name, name, is_one_of(ExternalIO)) for name in ('extIODump', 'extIODumpLocal')),
    *(CommandSpec(f'extIO{side}{syntax}', Category.DEVICE, names(ExternalIOUpdate, 'name'),
                  goal_at=0)
      for side in ('Input', 'Output')
      for syntax in ('Update <name> <value>', 'UpdateBit <name> <bit> <0|1>',
                     'UpdateByte <name> <byte> <value>')),
    _done('extIOAdd <name> <inputs> <outputs>', Category.CONFIGURATION, 'extIOAdd:'),
    _listing('payloadQueryLocal [slot] [echo]', 'PayloadQuery', is_one_of(PayloadSlot)),
    _listing('payloadSlotCountLocal', 'PayloadSlotCount', items('PayloadSlotCount')),
    _done('payloadSet <slot> <content>', Category.DEVICE, 'payloadSet on',
          belongs=says('payloadSet attempting')),
    _done('payloadRemove <slot>', Category.DEVICE, 'payloadRemove on',
          belongs=says('payloadRemove attempting')),
    _done('say <text>', Category.DEVICE, 'Saying'),
    _done('play <file>', Category.DEVICE, 'Playing'),
    _done('log <message> [level]', Category.DEVICE, 'Logging'),
    _done('popupSimple <title> <message> <button> <seconds>', Category.DEVICE,
          'Creating simple popup'),
    *_quiet(('arclSendText <text>', 'modeLock', 'modeUnlock', 'clearAllObstacles'),
            Category.DEVICE),
    # the connection itself, and the robot's life
    _listing('help', 'commands', any_of(is_one_of(HelpEntry), items('Commands'))),
    _answer('echo [on|off]', Echo),
    _done('connectOutgoing <host> <port>', Category.DANGEROUS, 'Outgoing connected'),
    _done('extIORemove <name>', Category.DANGEROUS, 'extIORemove:'),  # restarts the robot's ARAM
    *_quiet(('quit', 'shutDown', 'shutDownServer', 'disableMotors', 'freeMotors'),
            Category.DANGEROUS),
)

COMMANDS: Dict[str, CommandSpec] = {spec.name.lower(): spec for spec in _ROWS}
