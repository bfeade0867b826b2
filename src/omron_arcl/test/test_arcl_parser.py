"""Every line of the robot becomes the right reply, and no line makes the parser fail."""
from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import omron_arcl as arcl
from omron_arcl import COMMANDS, parse_line
from omron_arcl.replies import (
    ArrivedAt,
    ArrivedAtPoint,
    BatteryVoltage,
    CommandError,
    CommandErrorDescription,
    CompletedInstantTask,
    CompletedMacro,
    CompletedTask,
    ConfigurationChanged,
    ConfigValue,
    DockingState,
    DockingStatus,
    DoingTask,
    Done,
    Echo,
    EndOf,
    EStop,
    ExecutingList,
    ExecutingMacro,
    ExtendedStatus,
    ExternalIOUpdate,
    FailedGoingTo,
    Fault,
    FinishedList,
    FinishedPatrolling,
    Goal,
    GoingTo,
    GoingToPoint,
    HelpEntry,
    Input,
    Interrupted,
    Item,
    LapCompleted,
    LocalizationScore,
    Localizing,
    Location,
    Macro,
    MapChanged,
    MapObjectCoord,
    Motors,
    Notice,
    OneLineStatus,
    Parking,
    Patrolling,
    RangeReading,
    RobotError,
    Route,
    ServerClosing,
    SetUpError,
    StateOfCharge,
    StatusText,
    Stopped,
    Stopping,
    Temperature,
    UnknownCommand,
    UnknownLine,
    Usage,
    WaitState,
    WillDoTask,
)

CASES = [
    # status
    ('ExtendedStatusForHumans: Going to dock at D|slow', ExtendedStatus('Going to dock at D|slow')),
    ('Status: Going to 12', StatusText('Going to 12')),
    ('Status: ', StatusText('')),
    ('Status: Error: Robot lost', StatusText('Error: Robot lost')),
    ('StateOfCharge: 79.4', StateOfCharge(79.4)),
    ('BatteryVoltage: 26.1', BatteryVoltage(26.1)),
    ('Location: 79031 -81597 20', Location(79031, -81597, 20)),
    ('LocalizationScore: 0.170543', LocalizationScore(0.170543)),
    ('Temperature: 36', Temperature(36)),
    ('Temperature: -127', Temperature(None)),
    ('Temperature: -128', Temperature(None)),
    ('DockingState: Docked ForcedState: Unforced ChargeState: Float',
     DockingStatus(DockingState.DOCKED, False, 'Float')),
    ('DockingState: Undocking ForcedState: Forced ChargeState: Unknowable',
     DockingStatus(DockingState.UNDOCKING, True, 'Unknowable')),
    # driving
    ('Going to 12', GoingTo('12')),
    ('Going to goal space', GoingTo('goal space')),
    ('Going to point', GoingToPoint()),
    ('Going to point 100 -200 30', GoingToPoint()),
    ('Going to point 7', GoingTo('point 7')),
    ('Going to points', GoingTo('points')),
    ('Arrived at X', ArrivedAt('X')),
    ('Arrived at point', ArrivedAtPoint()),
    ('Failed going to X', FailedGoingTo('X')),
    ('Stopping', Stopping()),
    ('Stopped', Stopped()),
    ('Parking', Parking(False)),
    ('Parked', Parking(True)),
    ('Interrupted: Going to g_25', Interrupted('Going to g_25')),
    ('Error: Failed going to goal', RobotError('Failed going to goal')),
    ('Patrolling route r 1', Patrolling('r 1', False)),
    ('Patrolling route r 1 once', Patrolling('r 1', True)),
    ('Finished patrolling route r 1', FinishedPatrolling('r 1')),
    ('Completed patrol, patroling again', LapCompleted()),
    ('Localizing at point', Localizing(False, 'Localizing at point')),
    ('Localized to point', Localizing(True, 'Localized to point')),
    # emergency stop and motors, in all spellings
    ('EStop pressed', EStop(True, 'EStop pressed')),
    ('Estop pressed', EStop(True, 'EStop pressed')),
    ('Estop relieved', EStop(False, 'EStop relieved')),
    ('EStop relieved but motors still disabled',
     EStop(False, 'EStop relieved but motors still disabled')),
    ('Estop pressed, cannot enable motors', EStop(True, 'EStop pressed, cannot enable motors')),
    ('Estop pressed cannot enable motors', EStop(True, 'EStop pressed cannot enable motors')),
    ('Motors enabled', Motors(True)),
    ('Motors are enabled', Motors(True)),
    ('Motors disabled', Motors(False)),
    # errors
    ('CommandError: goto 99', CommandError('goto 99')),
    ("CommandErrorDescription: No goal '99'", CommandErrorDescription("No goal '99'")),
    ('Unknown command gooto', UnknownCommand('gooto')),
    ('Unknown command', UnknownCommand('')),
    ('SetUpError: The file given did not exist', SetUpError('The file given did not exist')),
    ('SetupError: You need a list', SetUpError('You need a list')),
    ('usage: echo <on/off>', Usage('echo <on/off>')),
    # tasks, macros, lists
    ('Will do task move 100', WillDoTask('move 100')),
    ('Doing task move 100', DoingTask('move 100')),
    ('Completed doing task move 100', CompletedTask('move 100')),
    ('Completed doing instant task say x', CompletedInstantTask('say x')),
    ('Completed doing instant task: say x', CompletedInstantTask('say x')),
    ('Executing macro my macro', ExecutingMacro('my macro')),
    ('Completed macro my macro', CompletedMacro('my macro')),
    ('Executing list', ExecutingList()),
    ('Successfully finished task list', FinishedList()),
    ('List being cleared', Done('List being cleared')),
    ("Added task 'move 100' to the list", Done("Added task 'move 100' to the list")),
    ('WaitState: Waiting completed', WaitState('Waiting completed')),
    ('PauseTask: cancelled', Item('PauseTask', 'cancelled')),
    # queries
    ('Goal: goal space', Goal('goal space')),
    ('Route: r', Route('r')),
    ('Routes', Item('Routes', '')),
    ('Macro: m', Macro('m')),
    ('Odometer: 8281 mm 210 deg 469 sec', Item('Odometer', '8281 mm 210 deg 469 sec')),
    ('DateTime: 05/03/2012 04:48:55', Item('DateTime', '05/03/2012 04:48:55')),
    ('DistanceBetween: 1200 "a b" "c"', Item('DistanceBetween', '1200 "a b" "c"')),
    ('MapObjectList: "a b" Goal', Item('MapObjectList', '"a b" Goal')),
    ('MapObjectInfo: "a" Goal "d"', Item('MapObjectInfo', '"a" Goal "d"')),
    ('MapObjectInfoCoord: "a b" -3914 1929 -90.000', MapObjectCoord('a b', -3914, 1929, -90)),
    ('GetConfigSectionValue: Map my lab.map', ConfigValue('Map', 'my lab.map')),
    ('GetConfigSectionList: ARCL server setup', Item('GetConfigSectionList', 'ARCL server setup')),
    ('Config had errors parsing: x', Done('Config had errors parsing: x')),
    ('Config parsed fine', Done('Config parsed fine')),
    ('Input: i1 on', Input('i1', 'on')),
    ('Input: digin 1', Input('digin 1', '')),
    ('Output: o 1 broken', Input('o 1', 'broken', output=True)),
    ('RangeDevice: Laser_1 LASER', Item('RangeDevice', 'Laser_1 LASER')),
    ('Info: name value', Item('Info', 'name value')),
    # faults
    ('Fault: Fault_Driving_Critical_Application f "s h" "l o" true true true',
     Fault('Fault_Driving_Critical_Application', 'f', 's h', 'l o', True, True, True)),
    ('FaultList: Fault_Driving_Application f "s" "..." true false true',
     Fault('Fault_Driving_Application', 'f', 's', '...', True, False, True)),
    ('FaultCleared: Fault_Application f "" "" false false true',
     Fault('Fault_Application', 'f', '', '', False, False, True, cleared=True)),
    ('Saying "hello"', Done('Saying "hello"')),
    ('ApplicationFaultSet set f', Done('ApplicationFaultSet set f')),
    # examples of the newer manual, I617-E-02, for the data store (p. 110-119, 244)
    ('GetDataStoreGroupValues: RobotsAvail 3', Item('GetDataStoreGroupValues', 'RobotsAvail 3')),
    ('GetDataStoreFieldValues: ParkingTime 773.984',
     Item('GetDataStoreFieldValues', 'ParkingTime 773.984')),
    ('tripReset: TripAggDockedTime 0.000', Item('tripReset', 'TripAggDockedTime 0.000')),
    ('getDataStoreGroupInfo: "Fleet Robot statistics" "Queuing Statistics"',
     Item('GetDataStoreGroupInfo', '"Fleet Robot statistics" "Queuing Statistics"')),
    ('GetDataStoreTripGroupList: TripJobCounts',
     Item('GetDataStoreTripGroupList', 'TripJobCounts')),
    # external inputs and outputs (p. 82-101)
    ('ExtIODump: example with 69 input(s)', Item('ExtIODump', 'example with 69 input(s)')),
    ('ExtIODumpLocal: my set with 1 input(s)', Item('ExtIODumpLocal', 'my set with 1 input(s)')),
    ('extIOInputUpdate: input example2 updated with 0x00000000000000020 from 32',
     ExternalIOUpdate('example2')),
    ('extIOInputUpdateBit: input example updated with 1 at bit 32 to 0x00000000080000000',
     ExternalIOUpdate('example')),
    ('extIOOutputUpdateByte: output my set updated with 0xff at byte 5 to 0x1f00000000',
     ExternalIOUpdate('my set')),
    ('extIOOutputUpdateBit: output example updated with 1 at 35 to 0x400000000',
     ExternalIOUpdate('example')),
    ('extIOAdd: example added with 69 input(s) and 37 output(s)',
     Done('extIOAdd: example added with 69 input(s) and 37 output(s)')),
    ('extIORemove: example removed', Done('extIORemove: example removed')),
    ('AnalogInputListHelper: List format is: <minV> <maxV> <maxRaw> <name>',
     Item('AnalogInputListHelper', 'List format is: <minV> <maxV> <maxRaw> <name>')),
    # payload (p. 167-178)
    ('PayloadQuery: "21" 2 "Glasses"', Item('PayloadQuery', '"21" 2 "Glasses"')),
    ('PayloadQueryLocal: 3 "Empty" None None ""',
     Item('PayloadQueryLocal', '3 "Empty" None None ""')),
    ('PayloadSlotCount: "21" 4 ""', Item('PayloadSlotCount', '"21" 4 ""')),
    ('PayloadUpdate: "31" 4 "Empty" None None',
     Notice('PayloadUpdate', '"31" 4 "Empty" None None')),
    # messages of a vendor's fleet manager about its robots; they are never about this robot
    # (p. 184-187, 190-237)
    ('RobotFaultQuery: "robot1" Fault_Critical_Application fault1 "s" "l" false true true false '
     'false ""', Item('RobotFaultQuery', '"robot1" Fault_Critical_Application fault1 "s" "l" '
                                         'false true true false false ""')),
    ('RobotFault: "Sim2" Fault_Application f1 "s" "l" false false true false true',
     Notice('RobotFault', '"Sim2" Fault_Application f1 "s" "l" false false true false true')),
    ('RobotFaultCleared: "Sim2" Fault_Application f1 "s" "l" false false true false true',
     Notice('RobotFaultCleared',
            '"Sim2" Fault_Application f1 "s" "l" false false true false true')),
    ('QueueRobot: "21" InProgress Driving ""', Item('QueueRobot', '"21" InProgress Driving ""')),
    ('QueueCancel: DROPOFF18 JOB18 20 Cancelling None',
     Notice('QueueCancel', 'DROPOFF18 JOB18 20 Cancelling None')),
    ('queuepickup goal "z" with priority 11', Done('queuePickup goal "z" with priority 11')),
    ('WaitTask: Wait cancelled', WaitState('Wait cancelled')),
    # at any time
    ('Map changed', MapChanged()),
    ('Configuration changed', ConfigurationChanged()),
    ('QueueUpdate: DROPOFF18 y4rt 22 Pending', Notice('QueueUpdate', 'DROPOFF18 y4rt 22 Pending')),
    ('Shutting down server', ServerClosing('Shutting down server')),
    ('Closing connection', ServerClosing('Closing connection')),
    ('Echo turned off.', Echo(False)),
    ('Echo is on.', Echo(True)),
    ('Robot lost', Notice('Lost', '')),
    ('           quit          closes this connection to the server',
     HelpEntry('quit', 'closes this connection to the server')),
    ('applicationFaultQuery          Gets [afq]', HelpEntry('applicationFaultQuery', 'Gets [afq]')),
]

ENDS = [
    ('End of goals', 'goals'), ('End of routes', 'routes'), ('End of macros', 'macros'),
    ('End of info list', 'info list'), ('End of MapObjectList', 'mapobjectlist'),
    ('EndOfGetConfigSectionValues', 'getconfigsectionvalues'),
    ('EndOfRangeDeviceList', 'rangedevicelist'), ('EndQueryFaults', 'queryfaults'),
    ('End of ApplicationFaultQuery', 'applicationfaultquery'), ('EndExtIODump', 'extiodump'),
    ('End of commands', 'commands'), ('EndOfTripReset', 'tripreset'),
    ('EndExtIODumpLocal', 'extiodumplocal'), ('EndPayloadQuery', 'payloadquery'),
    ('EndPayloadSlotCount', 'payloadslotcount'), ('EndQueueShowRobot', 'queueshowrobot'),
    ('EndQueueShowCompleted', 'queueshowcompleted'), ('EndQueueMulti', 'queuemulti'),
    ('EndOfGetDataStoreTripGroupList', 'getdatastoretripgrouplist'),
]


@pytest.mark.parametrize(('line', 'reply'), CASES, ids=[line for line, _ in CASES])
def test_a_line_is_read_as_what_it_is(line, reply):
    assert parse_line(line) == reply


@pytest.mark.parametrize(('line', 'reply'), CASES, ids=[line for line, _ in CASES])
def test_trailing_blanks_change_nothing(line, reply):
    if not isinstance(reply, HelpEntry):
        assert parse_line(line + ' ') == reply


@pytest.mark.parametrize('name', [spec.name for spec in COMMANDS.values()])
def test_no_command_in_the_help_list_is_taken_for_an_answer_of_it(name):
    assert parse_line(f'{name:>15}          does it [x]') == HelpEntry(name, 'does it [x]')


@pytest.mark.parametrize(('line', 'what'), ENDS)
def test_the_irregular_ends_of_lists_all_are_ends(line, what):
    assert parse_line(line) == EndOf(what)


@pytest.mark.parametrize('line', [
    '', ' ', 'hello', 'Going to', 'Going', 'Arrived', 'Location: 1 2', 'Location: 1 2 x',
    'Location: nan 0 0', 'Location: 1_0 2 3', 'StateOfCharge: full', 'StateOfCharge: inf',
    'Temperature:', 'DockingState:', 'DockingState: Lost ForcedState: Unforced ChargeState: Not',
    'Stopped now', 'EStop', 'EStop what', 'Fault: f', 'Goal:', 'Motors',
    'RangeDeviceGetCurrent:', 'Locations: 1 2 3', 'Echo is on',
    'extIOInputUpdate: input e', 'extIOInputUpdate: side e updated with 1 from 1',
    'extIOInputUpdateBit: input  updated with 1 at bit 2 to 0x4', 'Input:',
])
def test_a_line_of_no_known_kind_is_an_unknown_line(line):
    assert parse_line(line) == UnknownLine(line)


@pytest.mark.parametrize(('line', 'status'), [
    ('Status: Arrived at g_24 BatteryVoltage: 13.0 Location: 7038 -8342 0 Temperature: -127',
     OneLineStatus('Arrived at g_24', battery_voltage=BatteryVoltage(13.0),
                   location=Location(7038, -8342, 0), temperature=Temperature(None))),
    ('Status: DockingState: Docked ForcedState: Unforced ChargeState: Float StateOfCharge: 79.4 '
     'Location: 1 2 3 Temperature: 30',
     OneLineStatus('DockingState: Docked ForcedState: Unforced ChargeState: Float',
                   state_of_charge=StateOfCharge(79.4), location=Location(1, 2, 3),
                   temperature=Temperature(30))),
    ('Location: 1 2 3 Temperature: 30 Status: Stopped LocalizationScore: 0.5',
     OneLineStatus('Stopped', location=Location(1, 2, 3), temperature=Temperature(30),
                   localization_score=LocalizationScore(0.5))),
])
def test_a_status_on_one_line_is_read_by_its_keywords_in_any_order(line, status):
    assert parse_line(line) == status


def test_a_scan_is_pairs_of_millimetres_in_the_map():
    reading = parse_line('RangeDeviceGetCurrent: Laser_1 3378 -617 3446 -6175')
    assert reading == RangeReading('Laser_1', np.array([[3378, -617], [3446, -6175]]))
    assert not reading.points.flags.writeable


def test_a_cumulative_reading_is_told_apart():
    reading = parse_line('RangeDeviceGetCumulative: Laser_2 1 2')
    assert reading == RangeReading('Laser_2', np.array([[1, 2]]), cumulative=True)


@pytest.mark.parametrize('blank', ['', ' '])
def test_an_empty_scan_has_no_points(blank):
    assert parse_line(f'RangeDeviceGetCurrent: Laser_1{blank}').points.shape == (0, 2)


def test_a_dangling_last_number_of_a_scan_is_dropped():
    assert parse_line('RangeDeviceGetCurrent: L 1 2 3').points.tolist() == [[1, 2]]


@pytest.mark.parametrize('numbers', [
    '1 2 x 4', '1 2.5', '1 - 2', '1-2 3', '--1 2', '1 2-', '1 99999999999', '1 ' + '9' * 400,
    '1 -' + '9' * 400, '1 2\t3 4', '٣ 4', '1e3 4',
])
def test_a_scan_with_a_word_that_is_no_coordinate_is_unknown(numbers):
    line = f'RangeDeviceGetCurrent: Laser_1 {numbers}'
    assert parse_line(line) == UnknownLine(line)


def test_replies_are_values():
    with pytest.raises(dataclasses.FrozenInstanceError):
        parse_line('Going to 12').goal = '13'


def test_every_reply_is_a_public_name():
    assert all(getattr(arcl.replies, kind.__name__) is kind
               for kind in arcl.Reply.__subclasses__())
