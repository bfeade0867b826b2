"""Turns a line of the robot into a reply, with one table.

A row has a phrase, which is the beginning of a line, and a reader for the rest of the line. If the
phrase does not match, or the reader raises ValueError, the next row is tried. Case is ignored.
A line that matches no row is an UnknownLine. `parse_line` raises no exception for any line.
"""
from __future__ import annotations

import re
from functools import partial
from typing import Dict, List, Tuple

from omron_arcl import equipment_readers as equipment
from omron_arcl import readers as read
from omron_arcl import replies
from omron_arcl.readers import Reader, Row
from omron_arcl.replies import Reply, UnknownLine


def parse_line(text: str) -> Reply:
    """Returns the reply for a line, which is given without its line end."""
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
        return replies.HelpEntry(*help_entry.groups())
    return UnknownLine(text)


# %15s%10s%s: a name, ten blanks, a description
_HELP_ENTRY = re.compile(r'\s*(\S+) {10}\s*(.*)$')


# --- the table ------------------------------------------------------------------------------------

_TABLE: Tuple[Row, ...] = (
    # status
    ('Location:', read.location),
    ('RangeDeviceGetCurrent:', partial(equipment.range_reading, cumulative=False)),
    ('RangeDeviceGetCumulative:', partial(equipment.range_reading, cumulative=True)),
    ('StateOfCharge:', read.state_of_charge),
    ('BatteryVoltage:', read.battery_voltage),
    ('LocalizationScore:', read.localization_score),
    ('Temperature:', read.temperature),
    *((f'{word}:', read.one_line_status(f'{word}:')) for word in (
        'Status', 'Location', 'StateOfCharge', 'BatteryVoltage', 'LocalizationScore',
        'Temperature')),
    ('Status:', replies.StatusText),
    ('ExtendedStatusForHumans:', replies.ExtendedStatus),
    ('DockingState:', read.docking),
    # driving
    ('Going to point', read.to_point(replies.GoingToPoint())),
    ('Going to', read.named(replies.GoingTo)),
    ('Arrived at point', read.to_point(replies.ArrivedAtPoint())),
    ('Arrived at', read.named(replies.ArrivedAt)),
    ('Failed going to', read.named(replies.FailedGoingTo)),
    *(read.said(phrase, replies.Failure) for phrase in (
        'Failed', 'Cannot', 'Can not', "Can't", 'Could not', 'Unable to', 'Stalled')),
    ('Stopping', read.exactly(replies.Stopping())),
    ('Stopped', read.exactly(replies.Stopped())),
    ('Parking', read.exactly(replies.Parking(parked=False))),
    ('Parked', read.exactly(replies.Parking(parked=True))),
    ('Patrolling route', read.patrolling),
    ('Finished patrolling route', read.named(replies.FinishedPatrolling)),
    ('Completed patrol,', lambda text: replies.LapCompleted()),
    ('Interrupted:', replies.Interrupted),
    ('Error:', replies.RobotError),
    ('Localizing', read.localizing(False, 'Localizing')),
    ('Localized', read.localizing(True, 'Localized')),
    # emergency stop, motors, faults
    *((phrase, read.estop) for phrase in ('EStop', 'E-Stop', 'Emergency stop')),
    *((f'Motors {word}', read.exactly(replies.Motors(state)))
      for word, state in (('enabled', True), ('are enabled', True), ('disabled', False),
                          ('are disabled', False))),
    ('Fault:', read.fault),
    ('FaultCleared:', partial(read.fault, cleared=True)),
    ('FaultList:', read.fault),
    ('ApplicationFaultQuery:', read.fault),
    # errors
    ('CommandError:', replies.CommandError),
    ('CommandErrorDescription:', replies.CommandErrorDescription),
    *(read.said(phrase, replies.CommandErrorDescription)
      for phrase in ('No goal', 'No such goal')),
    ('Unknown command', replies.UnknownCommand),
    ('Unknown command:', replies.UnknownCommand),
    ('SetUpError:', replies.SetUpError),
    ('usage:', read.named(replies.Usage)),
    # tasks, macros, lists
    ('Will do task', read.named(replies.WillDoTask)),
    ('Doing task', read.named(replies.DoingTask)),
    ('Completed doing task', read.named(replies.CompletedTask)),
    ('Completed doing instant task', read.instant_task),
    ('Completed doing instant task:', read.instant_task),
    ('Executing macro', read.named(replies.ExecutingMacro)),
    ('Completed macro', read.named(replies.CompletedMacro)),
    ('Executing list', read.exactly(replies.ExecutingList())),
    ('Successfully finished task list', read.exactly(replies.FinishedList())),
    read.said('List being cleared'), read.said('Making new list'), read.said('Added task'),
    ('WaitState:', replies.WaitState),
    ('WaitTask:', replies.WaitState),
    # queries
    ('Goal:', read.named(replies.Goal)),
    ('Route:', read.named(replies.Route)),
    ('Macro:', read.named(replies.Macro)),
    ('MapObjectInfoCoord:', read.map_object_coord),
    ('GetConfigSectionValue:', read.key_and_value(replies.ConfigValue)),
    ('Input:', partial(equipment.digital_input, output=False)),
    ('Output:', partial(equipment.digital_input, output=True)),
    *((f'extIO{side}Update{part}:', equipment.external_io_update)
      for side in ('Input', 'Output') for part in ('', 'Bit', 'Byte')),
    *(read.item(prefix) for prefix in (
        'Odometer', 'DateTime', 'PauseTask', 'DistanceBetween', 'DistanceFromHere', 'InfoList',
        'Info', 'MapObjectTypeList', 'MapObjectTypeInfoArgument', 'MapObjectList', 'MapObjectInfo',
        'MapObjectInfoParams', 'GetConfigSectionList', 'GetConfigSectionInfo',
        'GetConfigSectionParamInfo', 'InputList', 'OutputList', 'AnalogInputListHelper',
        'AnalogInputList', 'AnalogInputRaw', 'AnalogInputVoltage', 'RangeDevice',
        'RangeDeviceCurrentDrawingData', 'RangeDeviceCumulativeDrawingData',
        'GetDataStoreGroupList', 'GetDataStoreGroupInfo',
        'GetDataStoreGroupValues', 'GetDataStoreTripGroupList', 'GetDataStoreFieldList',
        'GetDataStoreFieldInfo', 'GetDataStoreFieldValues', 'tripReset', 'ExtIODump',
        'ExtIODumpLocal', 'PayloadQuery', 'PayloadQueryLocal', 'PayloadSlotCount', 'QueueShow',
        'QueueRobot', 'QueueQuery', 'QueueMulti', 'RobotFaultQuery')),
    ('Routes', read.exactly(replies.Item('Routes', ''))),
    ('Commands:', read.exactly(replies.Item('Commands', ''))),
    *(read.end(phrase) for phrase in (
        'End of goals', 'End of routes', 'End of macros', 'End of commands', 'End of info list',
        'End of MapObjectTypeList', 'End of MapObjectTypeInfo', 'End of MapObjectList',
        'End of MapObjectInfo', 'EndOfGetConfigSectionList', 'EndOfGetConfigSectionValues',
        'EndOfGetConfigSectionInfo', 'End of ApplicationFaultQuery', 'End of FaultList',
        'EndQueryFaults', 'End of InputList', 'End of OutputList', 'End of AnalogInputList',
        'EndOfRangeDeviceList', 'EndExtIODump', 'EndExtIODumpLocal', 'EndOfGetDataStoreGroupList',
        'EndOfGetDataStoreGroupValues', 'EndOfGetDataStoreGroupInfo',
        'EndOfGetDataStoreTripGroupList', 'EndOfGetDataStoreFieldList',
        'EndOfGetDataStoreFieldValues', 'EndOfGetDataStoreFieldInfo', 'EndOfTripReset',
        'EndPayloadQuery', 'EndPayloadQueryLocal', 'EndPayloadSlotCount',
        'EndPayloadSlotCountLocal', 'EndQueueShow', 'EndQueueShowCompleted', 'EndQueueShowRobot',
        'EndQueueShowRobotLocal', 'EndQueueQuery', 'EndQueueQueryLocal', 'EndQueueMulti')),
    # confirmations, and lines that are sent to all clients
    ('Map changed', read.exactly(replies.MapChanged())),
    ('Configuration changed', read.exactly(replies.ConfigurationChanged())),
    *(read.said(phrase) for phrase in (
        'Reset odometer', 'Created info for', 'Updated info for', 'New config starting', 'Added',
        'Will parse config', 'Config parsed fine', 'Config had errors parsing:',
        'Will add new param', 'Will add config comment', 'ApplicationFaultSet set',
        'ApplicationFaultClear cleared',
        'Saying', 'Playing', 'Logging', 'Creating simple popup', 'Outgoing connected to',
        'extIOAdd:', 'extIORemove:', 'payloadSet attempting', 'payloadSet on',
        'payloadRemove attempting', 'payloadRemove on', 'queueDropoff attempting',
        'queueDropoff goal', 'queuePickup goal', 'queuePickupDropoff goals',
        'queueCancel attempting', 'queueCancel cancelling', 'queueModify modifying',
        'queueModifyLocal modifying')),
    ('Echo is on.', read.exactly(replies.Echo(True))),
    ('Echo is off.', read.exactly(replies.Echo(False))),
    ('Echo turned on.', read.exactly(replies.Echo(True))),
    ('Echo turned off.', read.exactly(replies.Echo(False))),
    *((f'{kind}:', partial(replies.Notice, kind)) for kind in (
        'QueueUpdate', 'QueueCancel', 'PayloadUpdate', 'RobotFault', 'RobotFaultCleared')),
    ('QueueUpdate cancelling', partial(replies.Notice, 'QueueCancel')),
    ('TextRequestChargeVoltage', partial(replies.Notice, 'Charge')),
    ('Charge requested', partial(replies.Notice, 'Charge')),
    ('Teleop driving', partial(replies.Notice, 'Teleop')),
    ('Robot lost', read.exactly(replies.Notice('Lost', ''))),
    *((state, read.exactly(replies.Notice(state, '')))
      for state in ('Docked', 'Docking', 'Undocking', 'Undocked')),
    ('Driving into dock', partial(replies.Notice, 'Docking')),
    ('Driving', partial(replies.Notice, 'Driving')),
    ('Following', partial(replies.Notice, 'Following')),
    read.said('Shutting down', replies.ServerClosing),
    read.said('Closing connection', replies.ServerClosing),
)


def _index(table: Tuple[Row, ...]) -> Dict[str, List[Tuple[str, int, Reader]]]:
    """Returns the rows grouped by first word, so that a line is compared with few rows only."""
    rules: Dict[str, List[Tuple[str, int, Reader]]] = {}
    for phrase, reader in table:
        head, _, tail = phrase.lower().partition(' ')
        rules.setdefault(head, []).append((tail, len(tail), reader))
    return rules


_RULES = _index(_TABLE)
