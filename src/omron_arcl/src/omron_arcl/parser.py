"""Turns a line of the robot into a reply, with one table.

A row is a phrase at the beginning of a line, and the reader of the text after it. The first row
whose phrase matches and whose reader does not raise ValueError wins. Case is ignored. A line that
matches no row is an UnknownLine. Nothing here raises an exception, for any line.
"""
from __future__ import annotations

import re
from functools import partial
from typing import Dict, List, Tuple

from omron_arcl import equipment_readers as equipment
from omron_arcl import readers as read
from omron_arcl.readers import Reader, Row
from omron_arcl.replies import driving, general, refusals, safety, site, status, tasks
from omron_arcl.replies.reply import Reply, UnknownLine


def parse_line(text: str) -> Reply:
    """The reply that a line (without its end) represents."""
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
        return general.HelpEntry(*help_entry.groups())
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
    ('Status:', status.StatusText),
    ('ExtendedStatusForHumans:', status.ExtendedStatus),
    ('DockingState:', read.docking),
    # driving
    ('Going to point', read.to_point(driving.GoingToPoint())),
    ('Going to', read.named(driving.GoingTo)),
    ('Arrived at point', read.to_point(driving.ArrivedAtPoint())),
    ('Arrived at', read.named(driving.ArrivedAt)),
    ('Failed going to', read.named(driving.FailedGoingTo)),
    *(read.said(phrase, driving.Failure) for phrase in (
        'Failed', 'Cannot', 'Can not', "Can't", 'Could not', 'Unable to', 'Stalled')),
    ('Stopping', read.exactly(driving.Stopping())),
    ('Stopped', read.exactly(driving.Stopped())),
    ('Parking', read.exactly(driving.Parking(parked=False))),
    ('Parked', read.exactly(driving.Parking(parked=True))),
    ('Patrolling route', read.patrolling),
    ('Finished patrolling route', read.named(driving.FinishedPatrolling)),
    ('Completed patrol,', lambda text: driving.LapCompleted()),
    ('Interrupted:', driving.Interrupted),
    ('Error:', driving.RobotError),
    ('Localizing', read.localizing(False, 'Localizing')),
    ('Localized', read.localizing(True, 'Localized')),
    # emergency stop, motors, faults
    *((phrase, read.estop) for phrase in ('EStop', 'E-Stop', 'Emergency stop')),
    *((f'Motors {word}', read.exactly(safety.Motors(state)))
      for word, state in (('enabled', True), ('are enabled', True), ('disabled', False),
                          ('are disabled', False))),
    ('Fault:', read.fault),
    ('FaultCleared:', partial(read.fault, cleared=True)),
    ('FaultList:', read.fault),
    ('ApplicationFaultQuery:', read.fault),
    # errors
    ('CommandError:', refusals.CommandError),
    ('CommandErrorDescription:', refusals.CommandErrorDescription),
    *(read.said(phrase, refusals.CommandErrorDescription)
      for phrase in ('No goal', 'No such goal')),
    ('Unknown command', refusals.UnknownCommand),
    ('Unknown command:', refusals.UnknownCommand),
    ('SetUpError:', refusals.SetUpError),
    ('usage:', read.named(refusals.Usage)),
    # tasks, macros, lists
    ('Will do task', read.named(tasks.WillDoTask)),
    ('Doing task', read.named(tasks.DoingTask)),
    ('Completed doing task', read.named(tasks.CompletedTask)),
    ('Completed doing instant task', read.instant_task),
    ('Completed doing instant task:', read.instant_task),
    ('Executing macro', read.named(tasks.ExecutingMacro)),
    ('Completed macro', read.named(tasks.CompletedMacro)),
    ('Executing list', read.exactly(tasks.ExecutingList())),
    ('Successfully finished task list', read.exactly(tasks.FinishedList())),
    read.said('List being cleared'), read.said('Making new list'), read.said('Added task'),
    ('WaitState:', tasks.WaitState),
    ('WaitTask:', tasks.WaitState),
    ('PauseTask:', tasks.PauseState),
    # queries
    ('Goal:', read.named(site.Goal)),
    ('Route:', read.named(site.Route)),
    ('Macro:', read.named(site.Macro)),
    ('Odometer:', read.odometer),
    ('DateTime:', status.DateTime),
    ('DistanceBetween:', read.distance_between),
    ('DistanceFromHere:', read.distance_from_here),
    ('MapObjectList:', read.map_object),
    ('MapObjectInfoCoord:', read.map_object_coord),
    ('GetConfigSectionValue:', read.key_and_value(site.ConfigValue)),
    ('Input:', partial(equipment.digital_input, output=False)),
    ('Output:', partial(equipment.digital_input, output=True)),
    ('RangeDevice:', equipment.range_device),
    ('ExtIODump:', equipment.external_io),
    ('ExtIODumpLocal:', equipment.external_io),
    *((f'extIO{side}Update{part}:', equipment.external_io_update)
      for side in ('Input', 'Output') for part in ('', 'Bit', 'Byte')),
    ('PayloadQuery:', equipment.payload_slot),
    ('PayloadQueryLocal:', equipment.payload_slot),
    *((f'{prefix}:', read.key_and_value(status.DataStoreValue)) for prefix in (
        'GetDataStoreFieldValues', 'GetDataStoreGroupValues', 'tripReset')),
    *(read.item(prefix) for prefix in (
        'InfoList', 'Info', 'MapObjectTypeList', 'MapObjectTypeInfoArgument', 'MapObjectInfo',
        'MapObjectInfoParams', 'GetConfigSectionList', 'GetConfigSectionInfo',
        'GetConfigSectionParamInfo', 'InputList', 'OutputList', 'AnalogInputListHelper',
        'AnalogInputList', 'AnalogInputRaw', 'AnalogInputVoltage', 'RangeDeviceCurrentDrawingData',
        'RangeDeviceCumulativeDrawingData', 'GetDataStoreGroupList', 'GetDataStoreGroupInfo',
        'GetDataStoreTripGroupList', 'GetDataStoreFieldList', 'GetDataStoreFieldInfo',
        'PayloadSlotCount', 'QueueShow', 'QueueRobot', 'QueueQuery', 'QueueMulti',
        'RobotFaultQuery')),
    ('Routes', read.exactly(general.Item('Routes', ''))),
    ('Commands:', read.exactly(general.Item('Commands', ''))),
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
    ('Map changed', read.exactly(site.MapChanged())),
    ('Configuration changed', read.exactly(site.ConfigurationChanged())),
    ('Config had errors parsing:', site.ConfigErrors),
    *(read.said(phrase) for phrase in (
        'Reset odometer', 'Created info for', 'Updated info for', 'New config starting', 'Added',
        'Will parse config', 'Config parsed fine', 'Will add new param',
        'Will add config comment', 'ApplicationFaultSet set', 'ApplicationFaultClear cleared',
        'Saying', 'Playing', 'Logging', 'Creating simple popup', 'Outgoing connected to',
        'extIOAdd:', 'extIORemove:', 'payloadSet attempting', 'payloadSet on',
        'payloadRemove attempting', 'payloadRemove on', 'queueDropoff attempting',
        'queueDropoff goal', 'queuePickup goal', 'queuePickupDropoff goals',
        'queueCancel attempting', 'queueCancel cancelling', 'queueModify modifying',
        'queueModifyLocal modifying')),
    ('Echo is on.', read.exactly(general.Echo(True))),
    ('Echo is off.', read.exactly(general.Echo(False))),
    ('Echo turned on.', read.exactly(general.Echo(True))),
    ('Echo turned off.', read.exactly(general.Echo(False))),
    *((f'{kind}:', partial(general.Notice, kind)) for kind in (
        'QueueUpdate', 'QueueCancel', 'PayloadUpdate', 'RobotFault', 'RobotFaultCleared')),
    ('QueueUpdate cancelling', partial(general.Notice, 'QueueCancel')),
    ('TextRequestChargeVoltage', partial(general.Notice, 'Charge')),
    ('Charge requested', partial(general.Notice, 'Charge')),
    ('Teleop driving', partial(general.Notice, 'Teleop')),
    ('Robot lost', read.exactly(general.Notice('Lost', ''))),
    *((state, read.exactly(general.Notice(state, '')))
      for state in ('Docked', 'Docking', 'Undocking', 'Undocked')),
    ('Driving into dock', partial(general.Notice, 'Docking')),
    ('Driving', partial(general.Notice, 'Driving')),
    ('Following', partial(general.Notice, 'Following')),
    read.said('Shutting down', general.ServerClosing),
    read.said('Closing connection', general.ServerClosing),
)


def _index(table: Tuple[Row, ...]) -> Dict[str, List[Tuple[str, int, Reader]]]:
    """The table by first word, so that a line is compared with few rows only."""
    rules: Dict[str, List[Tuple[str, int, Reader]]] = {}
    for phrase, reader in table:
        head, _, tail = phrase.lower().partition(' ')
        rules.setdefault(head, []).append((tail, len(tail), reader))
    return rules


_RULES = _index(_TABLE)
