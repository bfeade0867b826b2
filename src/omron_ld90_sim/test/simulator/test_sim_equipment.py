"""External I/O, payload and data store: the examples of ARCL manual I617-E-02, and their edges."""
from __future__ import annotations

from typing import Dict, List

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sim_builders import Rig
from sim_transcripts import check

from omron_ld90_sim.devices.external_io import Bank
from omron_ld90_sim.interface.commands import TABLE

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

# command lines, then what comes; a line in slashes is a regular expression
TRANSCRIPTS: Dict[str, List[List[str]]] = {
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
        ADDED, 'extIORemove: example removed']],
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


@pytest.mark.parametrize('name', TRANSCRIPTS)
def test_the_equipment_answers_as_in_the_manual(name: str) -> None:
    commands, wanted = TRANSCRIPTS[name]
    client = Rig().client()
    check(wanted, [line for line in client.ask(*commands) if line != 'Shutting down server'])


@pytest.mark.parametrize('name', ['payloadQuery', 'payloadSlotCount'])
def test_what_only_a_fleet_manager_answers_is_unknown(name: str) -> None:
    assert name.lower() not in TABLE
    assert Rig().client().ask(name) == [f'Unknown command {name}']


@given(count=st.integers(1, 200), value=st.integers(0, 2**220), data=st.data())
def test_a_bank_never_holds_more_than_its_bits(count: int, value: int, data) -> None:
    bank = Bank(count)
    bank.update(value)
    assert bank.value == value % 2**count
    position, on = data.draw(st.integers(1, count)), data.draw(st.booleans())
    bank.set_bit(position, on)
    assert bank.value >> (position - 1) & 1 == on
    bank.set_byte((count + 7) // 8, 0xff)
    assert bank.value < 2**count and int(bank.text, 16) == bank.value


def test_an_update_of_external_io_and_payload_reaches_every_client() -> None:
    rig = Rig()
    first, second = rig.client(), rig.client()
    first.send(ADD, 'edou example 1', 'ps 1 Books')
    assert second.lines() == [
        'extIOOutputUpdate: output example updated with 0x000000001 from 1',
        'PayloadUpdate: "robot" 1 "Books"']


def test_removing_external_io_restarts_the_robots_software() -> None:
    rig = Rig()
    first, second = rig.client(), rig.client()
    first.send(ADD, 'goto 12', 'edr example')
    assert first.lines()[-2:] == ['extIORemove: example removed', 'Shutting down server']
    assert first.session.closed and second.session.closed and not rig.server.online
    rig.clock.advance(rig.clock.now + 10.0)
    assert rig.server.online and rig.robot.base.still
    assert rig.client().ask('queryMotors', 'edd') == ['Motors enabled', 'EndExtIODump']


def values(lines: List[str]) -> Dict[str, float]:
    """The numbers of `...: <field> <value>` lines."""
    rows = (line.split(' ') for line in lines if ': ' in line)
    return {row[1]: float(row[2]) for row in rows}


def test_the_data_store_follows_the_robot_on_its_way() -> None:
    rig = Rig()
    client = rig.client()
    client.send('goto 12')
    rig.clock.advance(4.0)
    client.lines()
    driving = values(client.ask('dsfv TransVel', 'dsfv Distance_to_goal', 'dsfv RobotX'))
    assert driving['TransVel'] > 500.0 and driving['Distance_to_goal'] > 5000.0, driving
    assert driving['RobotX'] == pytest.approx(rig.robot.pose.x, abs=0.5)
    client.until('Arrived')
    assert values(client.ask('dsgv Path_Planning', 'dsgv Velocities')) == {
        'Distance_to_goal': 0.0, 'TransVel': 0.0}


def test_the_wheels_count_from_where_the_robot_was_switched_on() -> None:
    rig = Rig(start=(-2500.0, 1000.0, 90.0))
    client = rig.client()
    for task in ('move 500', 'deltaHeading 90'):
        client.send(f'doTask {task}')
        client.until(f'Completed doing task {task}')
    assert values(client.ask('dsgv EncoderPose')) == {
        'EncoderX': 500.0, 'EncoderY': 0.0, 'EncoderTh': 90.0}


def test_the_data_store_counts_the_hours_of_each_state_and_the_trip_anew() -> None:
    rig = Rig(start=None)       # in its dock
    client = rig.client()
    rig.clock.advance(3600.0)
    rig.robot.press_estop()
    rig.clock.advance(3600.0 * 3)
    docked = values(client.ask('dsgv StateInformation'))
    assert (docked['DockedTime'], docked['InEstopTime']) == (1.0, 2.0)
    client.ask('tripReset')
    rig.robot.release_estop()
    client.send('enableMotors')
    rig.clock.advance(3600.0 * 5)
    trip = values(client.ask('dsgv TripStateInformation'))
    assert (trip['TripDockedTime'], trip['TripInEstopTime']) == (2.0, 0.0), trip
    whole = values(client.ask('dsgv StateInformation'))
    assert (whole['DockedTime'], whole['InEstopTime']) == (3.0, 2.0), whole
    assert values(client.ask('dsfv SecsSinceLastTripReset')) == {'SecsSinceLastTripReset': 7200.0}


def test_the_way_to_the_dock_and_a_driving_fault_are_counted() -> None:
    rig = Rig()
    client = rig.client()
    client.send('dock')
    client.until('DockingState: Docked')
    state = values(client.ask('dsgv StateInformation'))
    assert 0.0 < state['DockingTime'] < 0.1
    assert state['DockingDistance'] == pytest.approx(rig.robot.base.driven / 1000.0, abs=0.5)
    client.ask('afs jam "Jam" "Too sweet" 1 0')
    rig.clock.advance(rig.clock.now + 1800.0)
    assert values(client.ask('dsfv InFaultTime'))['InFaultTime'] == 0.5
