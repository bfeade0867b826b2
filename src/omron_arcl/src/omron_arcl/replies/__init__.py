"""The lines of the robot: one frozen dataclass per kind of line, grouped by subject.

    from omron_arcl import parse_line, replies
    reply = parse_line('Going to 12')
    assert isinstance(reply, replies.GoingTo)
"""
from __future__ import annotations

from omron_arcl.replies.driving import (
    ArrivedAt,
    ArrivedAtPoint,
    DockingState,
    DockingStatus,
    FailedGoingTo,
    Failure,
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
from omron_arcl.replies.reply import Reply, UnknownLine
from omron_arcl.replies.safety import EStop, Fault, Motors
from omron_arcl.replies.site import (
    ConfigErrors,
    ConfigurationChanged,
    ConfigValue,
    DistanceBetween,
    DistanceFromHere,
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

__all__ = [
    'ArrivedAt', 'ArrivedAtPoint', 'BatteryVoltage', 'CommandError', 'CommandErrorDescription',
    'CompletedInstantTask', 'CompletedMacro', 'CompletedTask', 'ConfigErrors', 'ConfigValue',
    'ConfigurationChanged', 'DataStoreValue', 'DateTime', 'DistanceBetween', 'DistanceFromHere',
    'DockingState', 'DockingStatus', 'DoingTask', 'Done', 'EStop', 'Echo', 'EndOf',
    'ExecutingList', 'ExecutingMacro', 'ExtendedStatus', 'ExternalIO', 'ExternalIOUpdate',
    'FailedGoingTo', 'Failure', 'Fault', 'FinishedList', 'FinishedPatrolling', 'Goal', 'GoingTo',
    'GoingToPoint', 'HelpEntry', 'Input', 'Interrupted', 'Item', 'LapCompleted',
    'LocalizationScore', 'Localizing', 'Location', 'Macro', 'MapChanged', 'MapObjectCoord',
    'MapObjectName', 'Motors', 'Notice', 'Odometer', 'OneLineStatus', 'Parking', 'Patrolling',
    'PauseState', 'PayloadSlot', 'RangeDevice', 'RangeReading', 'Reply', 'RobotError', 'Route',
    'ServerClosing', 'SetUpError', 'StateOfCharge', 'StatusText', 'Stopped', 'Stopping',
    'Temperature', 'UnknownCommand', 'UnknownLine', 'Usage', 'WaitState', 'WillDoTask',
]
