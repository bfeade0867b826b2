"""How each command ends: one table, read by `commands` and `dispatcher`.

ARCL has no request ids, so the only link between a command and the robot's lines is what the lines
say. A row of the table therefore holds tests of replies: which one acknowledges the command, which
belong to it, which one ends it well. What ends it badly is the same for all and is in `dispatcher`.
Syntax and answers are those of OMRON's ARCL reference (I617-E-01), or of real robots where they
differ.
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Callable, Dict, Iterable, Optional, Tuple

from omron_ld90.arcl import replies as r
from omron_ld90.arcl.replies import DockingState, Reply

if TYPE_CHECKING:
    from omron_ld90.arcl.commands import Command


class Category(Enum):
    """What a command does to the robot; the controller allows or refuses by it."""

    QUERY = 'query'  # asks, changes nothing
    MOTION = 'motion'  # drives, stops, docks, localises, or enables driving
    DEVICE = 'device'  # speaks, plays, switches outputs, raises faults
    CONFIGURATION = 'configuration'  # changes the robot's settings or its map
    DANGEROUS = 'dangerous'  # powers the robot off, frees its wheels, or cuts the link
    UNKNOWN = 'unknown'  # not in this table


Test = Callable[['Command', Reply], bool]


@dataclass(frozen=True)
class CommandSpec:
    """A row of the table.

    `begins`: the reply that acknowledges the command, None where none is promised. `belongs`: the
    lines that are its own. `ends`: the last of them. `undone`: once begun, the reply that shows
    that it was broken off. `silence`: seconds without a line of its own until it counts as timed
    out, None for ever; before it began it is `PATIENCE` at most. `drives`: it takes over the
    wheels, and so replaces the one before it.
    """

    syntax: str
    category: Category
    ends: Optional[Test]
    begins: Optional[Test] = None
    belongs: Optional[Test] = None
    undone: Optional[Test] = None
    silence: Optional[float] = 5.0
    drives: bool = False
    goal_at: Optional[int] = None

    @property
    def name(self) -> str:
        """The command's name as the manual spells it."""
        return self.syntax.split(' ', 1)[0]

    @property
    def required(self) -> int:
        """How many arguments it needs."""
        return self.syntax.count('<')


PATIENCE = 60.0  # s until a driving command must have begun: leaving the dock comes first


def spec_of(name: str) -> CommandSpec:
    """The row for a command's name; an unknown one ends when the robot has been quiet."""
    return COMMANDS.get(name.lower()) or CommandSpec(name, Category.UNKNOWN, ends=None)


# --- tests of replies -----------------------------------------------------------------------------

def _is(*kinds: type) -> Test:
    return lambda command, reply: isinstance(reply, kinds)


def _names(kind: type, field: str = 'goal') -> Test:
    return lambda command, reply: (isinstance(reply, kind)
                                   and command.is_for(getattr(reply, field)))


def _docking(*states: DockingState) -> Test:
    return lambda command, reply: isinstance(reply, r.DockingStatus) and reply.docking in states


def _says(phrase: str) -> Test:
    return lambda command, reply: isinstance(reply, r.Done) and reply.text.startswith(phrase)


def _end_of(what: str) -> Test:
    return lambda command, reply: isinstance(reply, r.EndOf) and reply.what == what.lower()


def _items(*prefixes: str) -> Test:
    return lambda command, reply: isinstance(reply, r.Item) and reply.prefix in prefixes


def _any(*tests: Test) -> Test:
    return lambda command, reply: any(test(command, reply) for test in tests)


def _same_task(*kinds: type) -> Test:
    """The robot repeats a task's arguments as they were typed."""
    def test(command: Command, reply: Reply) -> bool:
        return isinstance(reply, kinds) and _plain(reply.task) == _plain(command.rest)
    return test


def _plain(text: str) -> str:
    return ' '.join(text.replace('"', ' ').split()).casefold()


# --- rows -----------------------------------------------------------------------------------------

def _drive(syntax: str, begins: Optional[Test], ends: Optional[Test],
           belongs: Optional[Test] = None, silence: Optional[float] = None,
           goal_at: Optional[int] = None, undone: Optional[Test] = None) -> CommandSpec:
    belongs = belongs or _is(r.DockingStatus)  # while it leaves the dock
    return CommandSpec(syntax, Category.MOTION, ends, begins, belongs, undone, silence,
                       drives=True, goal_at=goal_at)


def _answer(syntax: str, *kinds: type, category: Category = Category.QUERY) -> CommandSpec:
    """One reply of one of `kinds` is all."""
    return CommandSpec(syntax, category, _is(*kinds))


def _listing(syntax: str, end: str, belongs: Test) -> CommandSpec:
    """Items up to an end line."""
    return CommandSpec(syntax, Category.QUERY, _end_of(end), belongs=belongs)


def _done(syntax: str, category: Category, *phrases: str,
          belongs: Optional[Test] = None) -> CommandSpec:
    """A phrase is all."""
    return CommandSpec(syntax, category, _any(*map(_says, phrases)), belongs=belongs)


def _quiet(syntaxes: Iterable[str], category: Category) -> Iterable[CommandSpec]:
    """Commands whose answer is undocumented: they end when the robot has been quiet."""
    return (CommandSpec(syntax, category, ends=None) for syntax in syntaxes)


_EVERY_STATUS = _is(r.ExtendedStatus, r.StatusText, r.StateOfCharge, r.BatteryVoltage, r.Location,
                    r.LocalizationScore, r.Temperature)
_TASK = _any(_same_task(r.WillDoTask, r.DoingTask),
             _is(r.WaitState, r.GoingTo, r.GoingToPoint, r.ArrivedAt, r.ArrivedAtPoint,
                 r.DockingStatus))

_ROWS: Tuple[CommandSpec, ...] = (
    # driving
    _drive('goto <goal> [heading]', _names(r.GoingTo), _names(r.ArrivedAt), goal_at=0),
    _drive('gotoPoint <x> <y> [heading]', _is(r.GoingToPoint), _is(r.ArrivedAtPoint)),
    _drive('gotoRouteGoal <route> <goal>', _names(r.GoingTo), _names(r.ArrivedAt), goal_at=1),
    _drive('dock', _docking(DockingState.DOCKING), _docking(DockingState.DOCKED), silence=180.0,
           belongs=_is(r.DockingStatus, r.GoingTo, r.ArrivedAt),
           undone=_docking(DockingState.UNDOCKED)),
    _drive('undock', _docking(DockingState.UNDOCKING), _docking(DockingState.UNDOCKED),
           silence=60.0, undone=_docking(DockingState.DOCKING, DockingState.DOCKED)),
    _drive('patrol <route>', _names(r.Patrolling, 'route'), lambda command, reply: False,
           belongs=_is(r.GoingTo, r.ArrivedAt, r.LapCompleted, r.DockingStatus), goal_at=0),
    *(_drive(syntax, _names(r.Patrolling, 'route'), _names(r.FinishedPatrolling, 'route'),
             belongs=_is(r.GoingTo, r.ArrivedAt, r.DockingStatus), goal_at=0)
      for syntax in ('patrolOnce <route> [index]', 'patrolResume <route>')),
    _drive('doTask <task> [arguments]', _same_task(r.WillDoTask, r.DoingTask),
           _same_task(r.CompletedTask), belongs=_TASK),
    _drive('executeMacro <macro>', _names(r.ExecutingMacro, 'macro'),
           _names(r.CompletedMacro, 'macro'), goal_at=0,
           belongs=_is(r.WillDoTask, r.DoingTask, r.CompletedTask, r.CompletedInstantTask,
                       r.WaitState, r.GoingTo, r.GoingToPoint, r.ArrivedAt, r.ArrivedAtPoint,
                       r.DockingStatus)),
    _drive('listExecute', _is(r.ExecutingList), _is(r.FinishedList),
           belongs=_is(r.WillDoTask, r.DoingTask, r.CompletedTask, r.CompletedInstantTask,
                       r.WaitState)),
    _drive('queueDropoff <goal> [priority] [jobId]', _names(r.GoingTo), _names(r.ArrivedAt),
           belongs=_is(r.Notice, r.DockingStatus), goal_at=0),
    *_quiet(('go', 'stay', 'follow', 'pauseTaskCancel', 'waitTaskCancel',
             'applicationBlockDrivingClear <name>',
             'applicationBlockDrivingSet <name> <short> <long>'), Category.MOTION),
    CommandSpec('stop', Category.MOTION, _is(r.Stopped), belongs=_is(r.Interrupted, r.Stopping),
                silence=15.0),
    CommandSpec('enableMotors', Category.MOTION,
                lambda command, reply: isinstance(reply, r.Motors) and reply.enabled),
    *(CommandSpec(syntax, Category.MOTION,
                  lambda command, reply: isinstance(reply, r.Localizing) and reply.done,
                  belongs=_is(r.Localizing), silence=30.0)
      for syntax in ('localizeToPoint <x> <y> <heading> [xySpread] [angleSpread]',
                     'localizeAtGoal <goal>')),
    _answer('doTaskInstant <task> [arguments]', r.CompletedInstantTask, category=Category.MOTION),
    _done('listStart [name]', Category.MOTION, 'Making new list',
          belongs=_says('List being cleared')),
    _done('listAdd <task> [arguments]', Category.MOTION, 'Added task'),
    # status and state
    CommandSpec('status', Category.QUERY, _is(r.Temperature), belongs=_EVERY_STATUS),
    _answer('oneLineStatus', r.OneLineStatus),
    _answer('queryDockStatus', r.DockingStatus),
    _answer('queryMotors', r.Motors, r.EStop),
    _answer('odometer', r.Odometer),
    _done('odometerReset', Category.DEVICE, 'Reset odometer'),
    _answer('getDateTime', r.DateTime),
    _answer('pauseTaskState', r.PauseState),
    _answer('waitTaskState', r.WaitState),
    _answer('distanceBetween <goal> <goal>', r.DistanceBetween),
    _listing('getInfoList', 'info list', _items('InfoList')),
    CommandSpec('getInfo <name>', Category.QUERY, _items('Info')),
    _done('createInfo <name> <length> <value>', Category.DEVICE, 'Created info for'),
    _done('updateInfo <name> <value>', Category.DEVICE, 'Updated info for'),
    *(_listing(f'getDataStore{name}', f'GetDataStore{name.split()[0]}',
               _items(f'GetDataStore{name.split()[0]}'))
      for name in ('GroupList', 'GroupValues <group>', 'GroupInfo <group>', 'FieldList',
                   'FieldValues <field>', 'FieldInfo <field>')),
    *_quiet(('goalDistanceRemaining', 'etaRequest', 'distanceFromHere', 'arclStat',
             'centralServer', 'queueQueryLocal', 'queueShowRobotLocal', 'trackSectors'),
            Category.QUERY),
    # goals, routes, macros, map objects
    _listing('getGoals', 'goals', _is(r.Goal)),
    _listing('getRoutes', 'routes', _any(_is(r.Route), _items('Routes'))),
    _listing('getMacros', 'macros', _is(r.Macro, r.UnknownLine)),
    _listing('mapObjectTypeList', 'MapObjectTypeList', _items('MapObjectTypeList')),
    _listing('mapObjectTypeInfo <type>', 'MapObjectTypeInfo',
             _items('MapObjectTypeList', 'MapObjectTypeInfoArgument')),
    _listing('mapObjectList <type>', 'MapObjectList', _is(r.MapObjectName)),
    _listing('mapObjectInfo <name>', 'MapObjectInfo',
             _any(_items('MapObjectInfo', 'MapObjectInfoParams'), _is(r.MapObjectCoord))),
    # range devices
    *(_listing(name, 'RangeDeviceList',
               _any(_is(r.RangeDevice), _items('RangeDeviceCurrentDrawingData',
                                               'RangeDeviceCumulativeDrawingData')))
      for name in ('rangeDeviceGetList', 'rangeDeviceList')),
    CommandSpec('rangeDeviceGetCurrent <device>', Category.QUERY,
                lambda command, reply: isinstance(reply, r.RangeReading) and not reply.cumulative),
    CommandSpec('rangeDeviceGetCumulative <device>', Category.QUERY,
                lambda command, reply: isinstance(reply, r.RangeReading) and reply.cumulative),
    # configuration: reading is a query
    _listing('getConfigSectionList', 'GetConfigSectionList', _items('GetConfigSectionList')),
    _listing('getConfigSectionValues <section>', 'GetConfigSectionValues', _is(r.ConfigValue)),
    _listing('getConfigSectionInfo <section>', 'GetConfigSectionInfo',
             _items('GetConfigSectionInfo', 'GetConfigSectionParamInfo')),
    _done('configStart', Category.CONFIGURATION, 'New config starting'),
    _done('configAdd <line>', Category.CONFIGURATION, 'Added'),
    CommandSpec('configParse', Category.CONFIGURATION,
                _any(_says('Config parsed fine'), _is(r.ConfigErrors)), silence=60.0,
                belongs=_any(_says('Will parse config'),
                             _is(r.MapChanged, r.ConfigurationChanged))),
    _done('newConfigParam <section> <name> <description> <priority> <type> <default> '
          '<min> <max> <hint>', Category.CONFIGURATION, 'Will add new param'),
    _done('newConfigSectionComment <section> <text>', Category.CONFIGURATION,
          'Will add config comment'),
    # faults, inputs and outputs, sound
    _done('applicationFaultSet <name> <short> <long> <driving> <critical>', Category.DEVICE,
          'ApplicationFaultSet set'),
    _done('applicationFaultClear <name>', Category.DEVICE, 'ApplicationFaultClear cleared'),
    _listing('applicationFaultQuery', 'ApplicationFaultQuery', _is(r.Fault)),
    _listing('faultsGet', 'FaultList', _is(r.Fault)),
    _listing('queryFaults', 'QueryFaults', _is(r.Fault)),
    _listing('inputList', 'InputList', _any(_items('InputList'), _is(r.Input))),
    _listing('outputList', 'OutputList', _any(_items('OutputList'), _is(r.Input))),
    _listing('analogInputList', 'AnalogInputList', _items('AnalogInputList')),
    _answer('inputQuery <name>', r.Input),
    _answer('outputQuery <name>', r.Input),
    _answer('outputOn <name>', r.Input, category=Category.DEVICE),
    _answer('outputOff <name>', r.Input, category=Category.DEVICE),
    CommandSpec('analogInputQueryRaw <name>', Category.QUERY, _items('AnalogInputRaw')),
    CommandSpec('analogInputQueryVoltage <name>', Category.QUERY, _items('AnalogInputVoltage')),
    _done('say <text>', Category.DEVICE, 'Saying'),
    _done('play <file>', Category.DEVICE, 'Playing'),
    _done('log <message> [level]', Category.DEVICE, 'Logging'),
    _done('popupSimple <title> <message> <button> <seconds>', Category.DEVICE,
          'Creating simple popup'),
    *_quiet(('arclSendText <text>', 'modeLock', 'modeUnlock', 'clearAllObstacles',
             'queueCancelLocal', 'queueModifyLocal', 'tripReset'), Category.DEVICE),
    # the connection itself
    _listing('help', 'commands', _any(_is(r.HelpEntry), _items('Commands'))),
    _answer('echo [on|off]', r.Echo),
    CommandSpec('connectOutgoing <host> <port>', Category.DANGEROUS, _says('Outgoing connected')),
    *_quiet(('quit', 'shutdown', 'shutDownServer', 'disableMotors', 'freeMotors'),
            Category.DANGEROUS),
)

COMMANDS: Dict[str, CommandSpec] = {spec.name.lower(): spec for spec in _ROWS}
