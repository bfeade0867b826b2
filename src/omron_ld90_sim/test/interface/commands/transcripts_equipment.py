"""Transcripts: external I/O, payload and data store (form as in `transcripts_state`)."""
from __future__ import annotations

from typing import Dict, List

DATE = r'[A-Z][a-z]{2} [A-Z][a-z]{2} \d\d \d\d:\d\d:\d\d \d{4}'
TRIP_STATES = ['DropOffDrivingTime', 'DropOffDrivingDistance', 'PickupDrivingTime',
               'PickupDrivingDistance', 'ParkingTime', 'ParkingDistance', 'DockingTime',
               'DockingDistance', 'ForceDockingTime', 'ForceDockingDistance', 'DockedTime',
               'ForceDockedTime', 'InFaultTime', 'InEstopTime', 'AfterTime', 'ParkedTime',
               'BufferedTime']
TRIP_COUNTS = ['CompletedJobs', 'CompletedJobSegments', 'CancelledJobs', 'CancelledJobSegments',
               'ModifiedJobSegments', 'CancelledInProgressJobSegments', 'FailedJobSegments',
               'InterruptedJobSegments']
LONG_INPUT = '0xffcdffabffefabffefabffefaffdefabcdefabcdefabcdefabcdefabcdef'
ADD = 'extioadd example 69 37'
ADDED = 'extIOAdd: example added with 69 input(s) and 37 output(s)'
# command lines, then the answer; a line in slashes is a regular expression
IMMEDIATE: Dict[str, List[List[str]]] = {
    'extIOAdd': [[ADD, 'eda EXAMPLE 1 1', 'eda more 5000 0'], [
        ADDED, 'CommandError: eda EXAMPLE 1 1',
        "CommandErrorDescription: There is an external I/O set 'EXAMPLE' already",
        'CommandError: eda more 5000 0', "CommandErrorDescription: Bad number '5000'"]],
    'extIODump': [['extIODump', ADD, 'edi8 example 4 255', 'edo8 example 5 0xff', 'edd'], [
        'EndExtIODump', ADDED,
        'extIOInputUpdateByte: input example updated with 0xff at byte 4 to 0x000000000ff000000',
        'extIOOutputUpdateByte: output example updated with 0xff at byte 5 to 0x1f00000000',
        'ExtIODump: example with 69 input(s), value = 0x000000000ff000000 and 37 output(s), '
        'value = 0x1f00000000', 'EndExtIODump']],
    'extIODumpLocal': [[ADD, 'extiodumplocal'], [
        ADDED, 'ExtIODumpLocal: example with 69 input(s), value = 0x00000000000000000 and '
        '37 output(s), value = 0x000000000', 'EndExtIODumpLocal']],
    'extIOInputUpdate': [[ADD, f'extioinputupdate example {LONG_INPUT}', 'ediu example 32',
                          'ediu example 4294967297', 'ediu moon 1', 'ediu example 0xyz'], [
        ADDED,
        f'extIOInputUpdate: input example updated with 0xbcdefabcdefabcdef from {LONG_INPUT}',
        'extIOInputUpdate: input example updated with 0x00000000000000020 from 32',
        'extIOInputUpdate: input example updated with 0x00000000000000001 from 4294967297',
        'CommandError: ediu moon 1', "CommandErrorDescription: No external I/O set 'moon'",
        'CommandError: ediu example 0xyz', "CommandErrorDescription: Bad number '0xyz'"]],
    'extIOInputUpdateBit': [[ADD, 'extioinputupdatebit example 32 1', 'edib example 70 1'], [
        ADDED, 'extIOInputUpdateBit: input example updated with 1 at bit 32 to 0x00000000080000000',
        'CommandError: edib example 70 1', "CommandErrorDescription: Bad bit position '70'"]],
    'extIOInputUpdateByte': [[ADD, 'extioInputUpdateByte example 4 0xff', 'edi8 example 10 1',
                              'edi8 example 0 1'], [
        ADDED,
        'extIOInputUpdateByte: input example updated with 0xff at byte 4 to 0x000000000ff000000',
        'CommandError: edi8 example 10 1', "CommandErrorDescription: Bad byte position '10'",
        'CommandError: edi8 example 0 1', "CommandErrorDescription: Bad byte position '0'"]],
    'extIOOutputUpdate': [[ADD, 'extioOutputUpdate example 0xabcdefabcdefabcdefabcdefabcdef',
                           'edou example 32'], [
        ADDED, 'extIOOutputUpdate: output example updated with 0xdefabcdef from '
        '0xabcdefabcdefabcdefabcdefabcdef',
        'extIOOutputUpdate: output example updated with 0x000000020 from 32']],
    'extIOOutputUpdateBit': [[ADD, 'extiooutputupdatebit example 35 1', 'edob example 35 2'], [
        ADDED, 'extIOOutputUpdateBit: output example updated with 1 at bit 35 to 0x400000000',
        'CommandError: edob example 35 2', "CommandErrorDescription: Bad bit '2'"]],
    'extIOOutputUpdateByte': [[ADD, 'extiooutputupdatebyte example 5 0xff', 'edo8 example 5 256'], [
        ADDED, 'extIOOutputUpdateByte: output example updated with 0xff at byte 5 to 0x1f00000000',
        'CommandError: edo8 example 5 256', "CommandErrorDescription: Bad number '256'"]],
    'extIORemove': [['edr example', ADD, 'extIORemove example'], [
        'CommandError: edr example', "CommandErrorDescription: No external I/O set 'example'",
        ADDED, 'extIORemove: example removed', 'Shutting down server']],
    'payloadSet': [['payloadSet 1 Books', 'ps 5 Books', 'ps one Books'], [
        'payloadset attempting to set payload 1 "Books"',
        'payloadset on "robot" of slot number 1 with string "Books" successfully set',
        'PayloadUpdate: "robot" 1 "Books"',
        'CommandError: ps 5 Books', "CommandErrorDescription: No payload slot '5'",
        'CommandError: ps one Books', "CommandErrorDescription: No payload slot 'one'"]],
    'payloadRemove': [['payloadRemove 4'], [
        'payloadremove attempting to remove slot 4',
        'payloadremove on robot of slot number 4 successfully',
        'PayloadUpdate: "robot" 4 "Empty" None None']],
    'payloadQueryLocal': [['ps 2 "two books"', 'payloadquerylocal default hello', 'pql 3'], [
        'payloadset attempting to set payload 2 "two books"',
        'payloadset on "robot" of slot number 2 with string "two books" successfully set',
        'PayloadUpdate: "robot" 2 "two books"',
        'PayloadQuery: 1 "Empty" None None hello',
        r'/PayloadQuery: 2 "two books" \d\d/\d\d/\d{4} \d\d:\d\d:\d\d hello/',
        'PayloadQuery: 3 "Empty" None None hello', 'PayloadQuery: 4 "Empty" None None hello',
        'EndPayloadQuery', 'PayloadQuery: 3 "Empty" None None ""', 'EndPayloadQuery']],
    'payloadSlotCountLocal': [['payloadslotcountlocal'],
                              ['PayloadSlotCount: "robot" 4', 'EndPayloadSlotCount']],
    'getDataStoreGroupList': [['dsgl'], [*(f'GetDataStoreGroupList: {name}' for name in (
        'BatteryStateOfCharge', 'ChargingInfo', 'DateAndTime', 'EncoderPose',
        'EncoderPoseInterpolated', 'JobCounts', 'LaserLocalization', 'LastTripReset', 'ModeInfo',
        'Path_Planning', 'RobotPose', 'RobotPoseInterpolated', 'SecondsSinceEpoch',
        'SecondsSinceEpochMonotonic', 'StateInformation', 'TripJobCounts',
        'TripStateInformation', 'Velocities', 'Versions')), 'EndOfGetDataStoreGroupList']],
    'getDataStoreGroupInfo': [['dsgi chargingInfo', 'dsgi Nothing'], [
        'GetDataStoreGroupInfo: "State of the charger" "Robot"',
        'GetDataStoreGroupInfo: String RobotChargeState Intermediate None None "Phase of charging" '
        '"" ""',
        'GetDataStoreGroupInfo: Long long RobotChargeStateNumber Intermediate 0 '
        '9223372036854775807 "Phase of charging as a number" "" ""',
        'EndOfGetDataStoreGroupInfo', 'CommandError: dsgi Nothing',
        "CommandErrorDescription: No group 'Nothing'"]],
    'getDataStoreGroupValues': [['getDataStoreGroupValues RobotPose', 'dsgv datEandtime'], [
        'GetDataStoreGroupValues: RobotX -3000', 'GetDataStoreGroupValues: RobotY 0',
        'GetDataStoreGroupValues: RobotTh 0.000', 'EndOfGetDataStoreGroupValues',
        rf'/GetDataStoreGroupValues: DateAndTime {DATE}/', 'EndOfGetDataStoreGroupValues']],
    'getDataStoreFieldInfo': [['dsfi TransVel', 'dsfi RobotZ'], [
        'GetDataStoreFieldInfo: Long long TransVel Intermediate -2147483648 2147483647 '
        '"Speed, forwards positive (mm/s)" "" ""', 'EndOfGetDataStoreFieldInfo',
        'CommandError: dsfi RobotZ', "CommandErrorDescription: No field 'RobotZ'"]],
    'getDataStoreFieldValues': [['dsfv parkingtime', 'dsfv modestatus',
                                 'dsfv LaserLocalizationScore'], [
        'GetDataStoreFieldValues: ParkingTime 0.000', 'EndOfGetDataStoreFieldValues',
        'GetDataStoreFieldValues: ModeStatus Stopped', 'EndOfGetDataStoreFieldValues',
        r'/GetDataStoreFieldValues: LaserLocalizationScore \d\d/', 'EndOfGetDataStoreFieldValues'
    ]],
    'getDataStoreTripGroupList': [['dstgl'], [
        'GetDataStoreTripGroupList: LastTripReset', 'GetDataStoreTripGroupList: TripJobCounts',
        'GetDataStoreTripGroupList: TripStateInformation', 'EndOfGetDataStoreTripGroupList']],
    'tripReset': [['tr'], [*(f'tripReset: Trip{name} 0' for name in TRIP_COUNTS),
                           *(f'tripReset: Trip{name} 0.000' for name in TRIP_STATES),
                           'EndOfTripReset']],
    'getDataStoreFieldList': [['dsfl'], [*(f'GetDataStoreFieldList: {name}' for name in (
        'BatteryStateOfCharge', 'RobotChargeState', 'RobotChargeStateNumber', 'DateAndTime',
        'EncoderX', 'EncoderY', 'EncoderTh', 'EncoderPoseInterpolated_X',
        'EncoderPoseInterpolated_Y', 'EncoderPoseInterpolated_Th', *TRIP_COUNTS[:5],
        'LaserLocalizationScore', 'SecsSinceLastTripReset', 'DateAndTimeOfLastTripReset',
        'ModeStatus', 'Distance_to_goal', 'RobotX', 'RobotY', 'RobotTh',
        'RobotPoseInterpolated_X', 'RobotPoseInterpolated_Y', 'RobotPoseInterpolated_Th',
        'SecondsSinceEpoch', 'SecondsSinceEpochMonotonic', *TRIP_COUNTS[5:], *TRIP_STATES,
        *(f'Trip{name}' for name in TRIP_COUNTS), *(f'Trip{name}' for name in TRIP_STATES),
        'TransVel', 'SNG', 'ARAM', 'MARC')), 'EndOfGetDataStoreFieldList']],
}
