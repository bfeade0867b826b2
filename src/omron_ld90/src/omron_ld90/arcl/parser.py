"""From a line of the robot to a reply, by one table.

A row is a phrase that the line begins with and the reader of what follows it. The first row whose
phrase fits, and whose reader does not raise ValueError, wins; words are compared without case. A
line that fits no row is an UnknownLine. Nothing here raises, whatever the line holds.
"""
from __future__ import annotations

import re
from functools import partial
from typing import Dict, List, Tuple

from omron_ld90.arcl import readers as read
from omron_ld90.arcl import replies as r
from omron_ld90.arcl.readers import Reader, Row
from omron_ld90.arcl.replies import Reply


def parse_line(text: str) -> Reply:
    """The reply that a line (without its end) is."""
    line = text.strip()
    head, _, rest = line.partition(' ')
    for tail, length, reader in _RULES.get(head.lower(), ()):
        if length:
            if rest[:length].lower() != tail or rest[length:length + 1] not in ('', ' '):
                continue
            payload = rest[length + 1:]
        else:
            payload = rest
        try:
            return reader(payload)
        except ValueError:
            continue
    help_entry = _HELP_ENTRY.match(text)
    if help_entry:
        return r.HelpEntry(*help_entry.groups())
    return r.UnknownLine(text)


# %15s%10s%s: a name, ten blanks, what it does
_HELP_ENTRY = re.compile(r'\s*(\S+) {10}(.*)$')


# --- the table ------------------------------------------------------------------------------------

_TABLE: Tuple[Row, ...] = (
    # status
    ('Location:', read.location),
    ('RangeDeviceGetCurrent:', partial(read.range_reading, cumulative=False)),
    ('RangeDeviceGetCumulative:', partial(read.range_reading, cumulative=True)),
    ('StateOfCharge:', read.measured(r.StateOfCharge)),
    ('BatteryVoltage:', read.measured(r.BatteryVoltage)),
    ('LocalizationScore:', read.measured(r.LocalizationScore)),
    ('Temperature:', read.temperature),
    *((f'{word}:', read.one_line_status(f'{word}:')) for word in (
        'Status', 'Location', 'StateOfCharge', 'BatteryVoltage', 'LocalizationScore',
        'Temperature')),
    ('Status:', r.StatusText),
    ('ExtendedStatusForHumans:', r.ExtendedStatus),
    ('DockingState:', read.docking),
    # driving
    ('Going to point', read.to_point(r.GoingToPoint())),
    ('Going to', read.named(r.GoingTo)),
    ('Arrived at point', read.to_point(r.ArrivedAtPoint())),
    ('Arrived at', read.named(r.ArrivedAt)),
    ('Failed going to', read.named(r.FailedGoingTo)),
    ('Stopping', read.exactly(r.Stopping())),
    ('Stopped', read.exactly(r.Stopped())),
    ('Parking', read.exactly(r.Parking(parked=False))),
    ('Parked', read.exactly(r.Parking(parked=True))),
    ('Patrolling route', read.patrolling),
    ('Finished patrolling route', read.named(r.FinishedPatrolling)),
    ('Completed patrol,', lambda text: r.LapCompleted()),
    ('Interrupted:', r.Interrupted),
    ('Error:', r.RobotError),
    ('Localizing', read.localizing(False, 'Localizing')),
    ('Localized', read.localizing(True, 'Localized')),
    # emergency stop, motors, faults
    ('EStop', read.estop),
    ('Motors enabled', read.exactly(r.Motors(True))),
    ('Motors are enabled', read.exactly(r.Motors(True))),
    ('Motors disabled', read.exactly(r.Motors(False))),
    ('Fault:', read.fault),
    ('FaultCleared:', partial(read.fault, cleared=True)),
    ('FaultList:', read.fault),
    ('ApplicationFaultQuery:', read.fault),
    ('RobotFaultQuery:', read.fault),
    ('RobotFault:', partial(r.Notice, 'RobotFault')),
    # errors
    ('CommandError:', r.CommandError),
    ('CommandErrorDescription:', r.CommandErrorDescription),
    ('Unknown command', r.UnknownCommand),
    ('SetUpError:', r.SetUpError),
    # tasks, macros, lists
    ('Will do task', read.named(r.WillDoTask)),
    ('Doing task', read.named(r.DoingTask)),
    ('Completed doing task', read.named(r.CompletedTask)),
    ('Completed doing instant task', read.instant_task),
    ('Completed doing instant task:', read.instant_task),
    ('Executing macro', read.named(r.ExecutingMacro)),
    ('Completed macro', read.named(r.CompletedMacro)),
    ('Executing list', read.exactly(r.ExecutingList())),
    ('Successfully finished task list', read.exactly(r.FinishedList())),
    read.said('List being cleared'), read.said('Making new list'), read.said('Added task'),
    ('WaitState:', r.WaitState),
    ('PauseTask:', r.PauseState),
    # queries
    ('Goal:', read.named(r.Goal)),
    ('Route:', read.named(r.Route)),
    ('Macro:', read.named(r.Macro)),
    ('Odometer:', read.odometer),
    ('DateTime:', r.DateTime),
    ('DistanceBetween:', read.distance_between),
    ('MapObjectList:', read.map_object),
    ('MapObjectInfoCoord:', read.map_object_coord),
    ('GetConfigSectionValue:', read.config_value),
    ('Input:', partial(read.digital_input, output=False)),
    ('Output:', partial(read.digital_input, output=True)),
    ('RangeDevice:', read.range_device),
    *(read.item(prefix) for prefix in (
        'InfoList', 'Info', 'MapObjectTypeList', 'MapObjectTypeInfoArgument', 'MapObjectInfo',
        'MapObjectInfoParams', 'GetConfigSectionList', 'GetConfigSectionInfo',
        'GetConfigSectionParamInfo', 'InputList', 'OutputList', 'AnalogInputList',
        'AnalogInputRaw', 'AnalogInputVoltage', 'RangeDeviceCurrentDrawingData',
        'RangeDeviceCumulativeDrawingData', 'GetDataStoreGroupList', 'GetDataStoreGroupValues',
        'GetDataStoreGroupInfo', 'GetDataStoreFieldList', 'GetDataStoreFieldValues',
        'GetDataStoreFieldInfo', 'tripReset', 'PayloadQuery', 'PayloadQueryLocal',
        'PayloadSlotCount', 'QueueShow', 'QueueRobot', 'QueueQuery', 'QueueMulti')),
    ('Routes', read.exactly(r.Item('Routes', ''))),
    ('Commands:', read.exactly(r.Item('Commands', ''))),
    *(read.end(phrase) for phrase in (
        'End of goals', 'End of routes', 'End of macros', 'End of commands', 'End of info list',
        'End of MapObjectTypeList', 'End of MapObjectTypeInfo', 'End of MapObjectList',
        'End of MapObjectInfo', 'EndOfGetConfigSectionList', 'EndOfGetConfigSectionValues',
        'EndOfGetConfigSectionInfo', 'End of ApplicationFaultQuery', 'End of FaultList',
        'EndQueryFaults', 'End of InputList', 'End of OutputList', 'End of AnalogInputList',
        'EndOfRangeDeviceList', 'EndExtIODump', 'EndOfGetDataStoreGroupList',
        'EndOfGetDataStoreGroupValues', 'EndOfGetDataStoreGroupInfo',
        'EndOfGetDataStoreFieldList', 'EndOfGetDataStoreFieldValues',
        'EndOfGetDataStoreFieldInfo', 'EndOfTripReset', 'EndPayloadQuery',
        'EndQueueShow', 'EndQueueQuery')),
    # said once it is done, or said to everybody
    ('Map changed', read.exactly(r.MapChanged())),
    ('Configuration changed', read.exactly(r.ConfigurationChanged())),
    ('Config had errors parsing:', r.ConfigErrors),
    *(read.said(phrase) for phrase in (
        'Reset odometer', 'Created info for', 'Updated info for', 'New config starting', 'Added',
        'Will parse config', 'Config parsed fine', 'Will add new param',
        'Will add config comment', 'ApplicationFaultSet set', 'ApplicationFaultClear cleared',
        'Saying', 'Playing', 'Logging', 'Creating simple popup', 'Outgoing connected to')),
    ('Echo is on.', read.exactly(r.Echo(True))),
    ('Echo is off.', read.exactly(r.Echo(False))),
    ('Echo turned on.', read.exactly(r.Echo(True))),
    ('Echo turned off.', read.exactly(r.Echo(False))),
    *((f'{kind}:', partial(r.Notice, kind)) for kind in (
        'QueueUpdate', 'PayloadUpdate', 'extIOInputUpdate', 'extIOOutputUpdate')),
    ('queuedropoff', partial(r.Notice, 'queueDropoff')),
    ('TextRequestChargeVoltage', partial(r.Notice, 'Charge')),
    ('Charge requested', partial(r.Notice, 'Charge')),
    ('Teleop driving', partial(r.Notice, 'Teleop')),
    ('Robot lost', read.exactly(r.Notice('Lost', ''))),
    ('Driving', partial(r.Notice, 'Driving')),
    ('Following', partial(r.Notice, 'Following')),
    read.said('Shutting down', r.ServerClosing),
    read.said('Closing connection', r.ServerClosing),
)


def _index(table: Tuple[Row, ...]) -> Dict[str, List[Tuple[str, int, Reader]]]:
    """The table by first word, so that a line meets only the few rows it can fit."""
    rules: Dict[str, List[Tuple[str, int, Reader]]] = {}
    for phrase, reader in table:
        head, _, tail = phrase.lower().partition(' ')
        rules.setdefault(head, []).append((tail, len(tail), reader))
    return rules


_RULES = _index(_TABLE)
