"""ARCL, the text protocol of OMRON mobile robots, without ROS: every public name, in one place."""
from __future__ import annotations

from omron_arcl.client import Client
from omron_arcl.command_line import parse_command, printable, quote
from omron_arcl.command_table import COMMANDS
from omron_arcl.commands import Category, Command, CommandSpec
from omron_arcl.errors import (
    ArclError,
    Busy,
    ConnectionFailed,
    ConnectionLost,
    InvalidCommand,
    LineTooLong,
    LinkError,
    NotConnected,
    PeerSilent,
    WrongPassword,
)
from omron_arcl.execution import Execution, Outcome, Result
from omron_arcl.link import Backoff, Link, LinkPhase
from omron_arcl.listener import Listener
from omron_arcl.parser import parse_line
from omron_arcl.replies.configuration import ConfigErrors, ConfigurationChanged, ConfigValue
from omron_arcl.replies.driving import (
    ArrivedAt,
    ArrivedAtPoint,
    DockingState,
    DockingStatus,
    FailedGoingTo,
    FinishedPatrolling,
    GoingTo,
    GoingToPoint,
    Interrupted,
    LapCompleted,
    Localizing,
    Parking,
    Patrolling,
    RobotError,
    Stopped,
    Stopping,
)
from omron_arcl.replies.equipment import (
    ExternalIO,
    ExternalIOUpdate,
    Input,
    PayloadSlot,
    RangeDevice,
    RangeReading,
)
from omron_arcl.replies.general import (
    Done,
    Echo,
    EndOf,
    HelpEntry,
    Item,
    Notice,
    ServerClosing,
)
from omron_arcl.replies.refusals import (
    CommandError,
    CommandErrorDescription,
    SetUpError,
    UnknownCommand,
    Usage,
)
from omron_arcl.replies.reply import Reply, UnknownLine, same_name
from omron_arcl.replies.safety import EStop, Fault, Motors
from omron_arcl.replies.site import (
    DistanceBetween,
    Goal,
    Macro,
    MapChanged,
    MapObjectCoord,
    MapObjectName,
    Route,
)
from omron_arcl.replies.status import (
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
from omron_arcl.replies.tasks import (
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
from omron_arcl.session import Closed, Event, HelpList, LoggedIn, Received, Session, State
from omron_arcl.session_log import SessionLog
from omron_arcl.status import StatusAssembler

__all__ = [
    'ArclError', 'ArrivedAt', 'ArrivedAtPoint', 'Backoff', 'BatteryVoltage', 'Busy', 'COMMANDS',
    'Category', 'Client', 'Closed', 'Command', 'CommandError', 'CommandErrorDescription',
    'CommandSpec', 'CompletedInstantTask', 'CompletedMacro', 'CompletedTask', 'ConfigErrors',
    'ConfigValue', 'ConfigurationChanged', 'ConnectionFailed', 'ConnectionLost',
    'DataStoreValue', 'DateTime', 'DistanceBetween', 'DockingState', 'DockingStatus',
    'DoingTask', 'Done', 'EStop', 'Echo', 'EndOf', 'Event', 'ExecutingList', 'ExecutingMacro',
    'Execution', 'ExtendedStatus', 'ExternalIO', 'ExternalIOUpdate', 'FailedGoingTo', 'Fault',
    'FinishedList', 'FinishedPatrolling', 'Goal', 'GoingTo', 'GoingToPoint', 'HelpEntry',
    'HelpList', 'Input', 'Interrupted', 'InvalidCommand', 'Item', 'LapCompleted', 'LineTooLong',
    'Link', 'LinkError', 'LinkPhase', 'Listener', 'LocalizationScore', 'Localizing', 'Location',
    'LoggedIn', 'Macro', 'MapChanged', 'MapObjectCoord', 'MapObjectName', 'Motors',
    'NotConnected', 'Notice', 'Odometer', 'OneLineStatus', 'Outcome', 'Parking', 'Patrolling',
    'PauseState', 'PayloadSlot', 'PeerSilent', 'RangeDevice', 'RangeReading', 'Received',
    'Reply', 'Result', 'RobotError', 'Route', 'ServerClosing', 'Session', 'SessionLog',
    'SetUpError', 'State', 'StateOfCharge', 'StatusAssembler', 'StatusText', 'Stopped',
    'Stopping', 'Temperature', 'UnknownCommand', 'UnknownLine', 'Usage', 'WaitState',
    'WillDoTask', 'WrongPassword', 'parse_command', 'parse_line', 'printable', 'quote',
    'same_name',
]
