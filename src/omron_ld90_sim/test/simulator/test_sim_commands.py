"""One transcript for each command: what is asked, and every line that comes back."""
from __future__ import annotations

import pytest
from sim_builders import Rig
from sim_transcripts import check
from test_sim_equipment import TRANSCRIPTS as EQUIPMENT

from omron_ld90_sim.commands import TABLE
from omron_ld90_sim.planner import Disc

UNDOCKED = 'DockingState: Undocked ForcedState: Unforced ChargeState: Not'

# command lines, then what comes at once; a line in slashes is a regular expression
IMMEDIATE = {
    'help': [['help'], ['Commands:', 'analogInputList          Lists the named analog inputs']],
    'echo': [['echo', 'echo on', 'echo', 'echo off', 'echo sometimes'],
             ['Echo is off.', 'Echo turned on.', 'echo', 'Echo is on.', 'echo off',
              'Echo turned off.', 'usage: echo <on/off>']],
    'quit': [['quit'], ['Closing connection']],
    'arclSendText': [['arclSendText "Status: fooled you"'], ['Status: fooled you']],
    'connectOutgoing': [['connectOutgoing 127.0.0.1 7179', 'connectOutgoing here there'],
                        ['Outgoing connected to 127.0.0.1 7179',
                         'CommandError: connectOutgoing here there',
                         "CommandErrorDescription: Bad port 'there'"]],
    'shutdown': [['shutdown'], ['Shutting down server']],
    'queryDockStatus': [['queryDockStatus'], [UNDOCKED]],
    'queryMotors': [['queryMotors'], ['Motors enabled']],
    'enableMotors': [['enableMotors'], ['Motors are enabled']],
    'status': [['status'], ['ExtendedStatusForHumans: Stopped', 'Status: Stopped',
                            'StateOfCharge: 100.0', 'Location: -3000 0 0',
                            r'/LocalizationScore: 0\.\d{6}/', 'Temperature: 36']],
    'oneLineStatus': [['onelinestatus'], ['Status: Stopped StateOfCharge: 100.0 '
                                          'Location: -3000 0 0 Temperature: 36']],
    'odometer': [['odometer'], ['Odometer: 0 mm 0 deg 0 sec']],
    'odometerReset': [['odometerReset'], ['Reset odometer']],
    'getGoals': [['getGoals'], ['Goal: West', 'Goal: East side', 'Goal: 12', 'End of goals']],
    'getDateTime': [['getDateTime'], [r'/DateTime: \d\d/\d\d/\d{4} \d\d:\d\d:\d\d/']],
    'createInfo': [['createInfo Shift 4 early'], ['Created info for Shift']],
    'getInfoList': [['createInfo a 9 b', 'getInfoList'],
                    ['Created info for a', 'InfoList: a', 'End of info list']],
    'getInfo': [['createInfo a 3 bcdef', 'getInfo a', 'getInfo b'],
                ['Created info for a', 'Info: a bcd', 'CommandError: getInfo b',
                 "CommandErrorDescription: No info 'b'"]],
    'updateInfo': [['createInfo a 9 b', 'updateInfo a c', 'getInfo a', 'updateInfo d e'],
                   ['Created info for a', 'Updated info for a', 'Info: a c',
                    'CommandError: updateInfo d e', "CommandErrorDescription: No info 'd'"]],
    'rangeDeviceGetCurrent': [['rangeDeviceGetCurrent laser_1', 'rangeDeviceGetCurrent Laser_7'],
                              [r'/RangeDeviceGetCurrent: Laser_1( -?\d+ -?\d+)+/',
                               'CommandError: rangeDeviceGetCurrent Laser_7',
                               "CommandErrorDescription: No range device 'Laser_7'"]],
    'rangeDeviceGetCumulative': [['rangeDeviceGetCumulative Laser_1'],
                                 [r'/RangeDeviceGetCumulative: Laser_1( -?\d+ -?\d+){1,200}/']],
    'rangeDeviceGetList': [['rangeDeviceGetList'], [
        'RangeDevice: Laser_1 LASER',
        'RangeDeviceCurrentDrawingData: Laser_1 polyDots 0x0000ff 0x000000 80 75 DefaultOn',
        'RangeDeviceCumulativeDrawingData: Laser_1 polyDots 0x0000ff 0x000000 80 75 DefaultOn',
        'EndOfRangeDeviceList']],
    'mapObjectTypeList': [['mapObjectTypeList'], [
        'MapObjectTypeList: DockLynx DockType', 'MapObjectTypeList: ForbiddenArea SectorType',
        'MapObjectTypeList: ForbiddenLine BoundaryType', 'MapObjectTypeList: Goal GoalType',
        'MapObjectTypeList: GoalWithHeading GoalType', 'MapObjectTypeList: RobotHome LocationType',
        'End of MapObjectTypeList']],
    'mapObjectTypeInfo': [['mapObjectTypeInfo Goal', 'mapObjectTypeInfo goal'], [
        'MapObjectTypeList: Goal GoalType "Goal" "A goal"', 'End of MapObjectTypeInfo',
        'CommandError: mapObjectTypeInfo goal',
        "CommandErrorDescription: No map object type 'goal'"]],
    'mapObjectList': [['mapObjectList Goal'], ['MapObjectList: "West" Goal',
                                               'MapObjectList: "12" Goal',
                                               'End of MapObjectList']],
    'mapObjectInfo': [['mapObjectInfo east side', 'mapObjectInfo moon'], [
        'MapObjectInfo: "East side" GoalWithHeading "the far end"',
        'MapObjectInfoCoord: "East side" 4500 1500 90.000', 'End of MapObjectInfo',
        'CommandError: mapObjectInfo moon', "CommandErrorDescription: No map object 'moon'"]],
    'getConfigSectionList': [['getConfigSectionList'], [
        'GetConfigSectionList: Files', 'GetConfigSectionList: ARCL server setup',
        'GetConfigSectionList: Outgoing ARCL connection setup',
        'GetConfigSectionList: Outgoing ARCL commands', 'GetConfigSectionList: Docking',
        'EndOfGetConfigSectionList']],
    'getConfigSectionValues': [['getConfigSectionValues Docking', 'getConfigSectionValues docking'],
                               ['GetConfigSectionValue: AutoDock false',
                                'GetConfigSectionValue: AutoDockCharge 25',
                                'GetConfigSectionValue: AutoDockIdleMins 15',
                                'EndOfGetConfigSectionValues',
                                'CommandError: getConfigSectionValues docking',
                                'CommandErrorDescription: No section of name docking']],
    'getConfigSectionInfo': [['getConfigSectionInfo Files'], [
        'GetConfigSectionInfo: "The files the robot uses" ""',
        'GetConfigSectionParamInfo: string Map Normal None None '
        '"The map the robot drives on" "" ""', 'EndOfGetConfigSectionInfo']],
    'configStart': [['configStart'], ['New config starting']],
    'configAdd': [['configAdd Section Files', 'configStart', 'configAdd Section Files'],
                  ['SetUpError: You need to start a config before you can add to it.',
                   'New config starting', "Added 'Section Files' to the config"]],
    'configParse': [['configStart', 'configAdd Section Docking', 'configAdd AutoDockCharge 30',
                     'configParse', 'configParse'],
                    ['New config starting', "Added 'Section Docking' to the config",
                     "Added 'AutoDockCharge 30' to the config", 'Will parse config',
                     'Configuration changed', 'Config parsed fine',
                     'SetUpError: You need to start a config before you can parse it.']],
    'newConfigParam': [['newConfigParam Mine depth "how deep" Normal int 3 0 9 none',
                        'getConfigSectionValues Mine'],
                       ["Will add new param 'depth' to section 'Mine'",
                        'GetConfigSectionValue: depth 3', 'EndOfGetConfigSectionValues']],
    'newConfigSectionComment': [['newConfigSectionComment Mine "all mine"'],
                                ["Will add config comment 'all mine' to section 'Mine'"]],
    'applicationFaultSet': [['applicationFaultSet jam "Jam" "Too sweet" 0 1', 'afs jam "Jam"'], [
        'ApplicationFaultSet set jam',
        'Fault: Fault_Critical_Application jam "Jam" "Too sweet" false true true',
        'usage: applicationFaultSet <name> "<shortDesc>" "<longDesc>" <isDriving> <isCritical>']],
    'applicationFaultClear': [['afs jam "Jam" "Too sweet" 1 1', 'afc jam', 'afc jam'], [
        'ApplicationFaultSet set jam',
        'Fault: Fault_Driving_Critical_Application jam "Jam" "Too sweet" true true true',
        'FaultCleared: Fault_Driving_Critical_Application jam "Jam" "Too sweet" true true true',
        'ApplicationFaultClear cleared jam', 'CommandError: afc jam',
        "CommandErrorDescription: No application fault 'jam'"]],
    'applicationFaultQuery': [['afs a b c 0 0', 'afq', 'afc a', 'afq'], [
        'ApplicationFaultSet set a', 'Fault: Fault_Application a "b" "c" false false true',
        'ApplicationFaultQuery: Fault_Application a "b" "c" false false true',
        'End of ApplicationFaultQuery',
        'FaultCleared: Fault_Application a "b" "c" false false true',
        'ApplicationFaultClear cleared a', 'End of ApplicationFaultQuery']],
    'faultsGet': [['faultsGet'], ['End of FaultList']],
    'applicationBlockDrivingSet': [['abds door "Door open" "It is"', 'goto 12'],
                                   ['CommandError: goto 12',
                                    'CommandErrorDescription: Driving blocked by door']],
    'applicationBlockDrivingClear': [['abds door a b', 'abdc door', 'abdc door'],
                                     ['CommandError: abdc door',
                                      "CommandErrorDescription: No block 'door'"]],
    'inputList': [['inputList'], ['InputList: Input_1', 'InputList: Input_2',
                                  'InputList: Input_3', 'InputList: Input_4',
                                  'End of InputList']],
    'inputQuery': [['inputQuery input_1', 'inputQuery x'],
                   ['Input: Input_1 off', 'CommandError: inputQuery x',
                    "CommandErrorDescription: No input 'x'"]],
    'outputList': [['outputList'], ['OutputList: Output_1', 'OutputList: Output_2',
                                    'OutputList: Output_3', 'OutputList: Output_4',
                                    'End of OutputList']],
    'outputOn': [['outputOn Output_2', 'outputQuery Output_2'],
                 ['Output: Output_2 on', 'Output: Output_2 on']],
    'outputOff': [['outputOn Output_2', 'outputOff Output_2'],
                  ['Output: Output_2 on', 'Output: Output_2 off']],
    'outputQuery': [['outputQuery Output_1'], ['Output: Output_1 off']],
    'analogInputList': [['analogInputList'], ['AnalogInputList: 0 10 4095 Analog_1',
                                              'End of AnalogInputList']],
    'analogInputQueryRaw': [['analogInputQueryRaw Analog_1'], ['AnalogInputRaw: Analog_1 1024']],
    'analogInputQueryVoltage': [['analogInputQueryVoltage Analog_1'],
                                ['AnalogInputVoltage: Analog_1 2.5']],
    'say': [['say "hello"'], ['Saying "hello"']],
    'play': [['play /sub/file.wav'], ['Playing /sub/file.wav']],
    'log': [['log well done', 'log "so so" Terse'],
            ["Logging 'well done' with level Normal", "Logging 'so so' with level Terse"]],
    'popupSimple': [['popupSimple "t" "m" "button" 5'], ['Creating simple popup']],
    'distanceBetween': [['distanceBetween West 12'], [r'/DistanceBetween: 9\d{3} "West" "12"/']],
    'getRoutes': [['getRoutes'], ['Routes', 'Route: Round', 'End of routes']],
    'getMacros': [['getMacros'], ['Macro: Greeting', 'End of macros']],
    'listStart': [['listStart'], ['List being cleared', 'Making new list']],
    'listAdd': [['listAdd wait 1', 'listStart', 'listAdd wait 1', 'listAdd dance'],
                ['SetUpError: You need to start a list before you can add to it.',
                 'List being cleared', 'Making new list', "Added task 'wait 1' to the list",
                 'CommandError: listAdd dance', "CommandErrorDescription: No task 'dance'"]],
    'waitTaskState': [['waitTaskState'], ['WaitState: Not waiting']],
    'pauseTaskState': [['pauseTaskState'], ['PauseTask: not pausing']],
    'doTaskInstant': [['doTaskInstant sayInstant "Enabling motors."', 'doTaskInstant move 1'], [
        'Saying "Enabling motors."', 'Completed doing instant task sayInstant "Enabling motors."',
        'CommandError: doTaskInstant move 1',
        "CommandErrorDescription: Task 'move' is not an instant task"]],
}

# commands that take a while: what comes up to the last line
LASTING = {
    'goto': [['goto west'], ['Going to West', 'Arrived at West']],
    'gotoPoint': [['gotoPoint -2000 500 90'], ['Going to point', 'Arrived at point']],
    'gotoRouteGoal': [['gotoRouteGoal Round west'], ['Going to West', 'Arrived at West']],
    'stop': [['stop'], ['Stopping', 'Stopped']],
    'dock': [['dock'], [
        UNDOCKED, 'DockingState: Docking ForcedState: Unforced ChargeState: Not',
        'DockingState: Docking ForcedState: Unforced ChargeState: Bulk',
        'DockingState: Docked ForcedState: Unforced ChargeState: Bulk',
        'DockingState: Docked ForcedState: Unforced ChargeState: Overcharge']],
    'undock': [['undock'], [UNDOCKED, 'Stopping', 'Stopped']],
    'localizeToPoint': [['localizeToPoint -2900 0 5'],
                        ['Localizing at point', 'Localized to point']],
    'localizeAtGoal': [['localizeAtGoal West 3000 180'],
                       ['Localizing at goal West', 'Localized to goal West']],
    'patrolOnce': [['patrolOnce Round'], [
        'Patrolling route Round once', 'Going to West', 'Arrived at West',
        'Going to East side', 'Arrived at East side', 'Finished patrolling route Round']],
    'patrol': [['patrol Round'], ['Patrolling route Round', 'Going to West', 'Arrived at West',
                                  'Going to East side', 'Arrived at East side', 'Going to West']],
    'patrolResume': [['patrolResume Round'], ['Patrolling route Round once', 'Going to West']],
    'doTask': [['doTask deltaHeading 90'], [
        'Will do task deltaHeading 90', 'Doing task deltaHeading 90',
        'Completed doing task deltaHeading 90']],
    'executeMacro': [['executemacro greeting'], [
        'Executing macro Greeting', 'Saying hello',
        'WaitState: Waiting 2 seconds with status "Waiting"', 'WaitState: Waiting completed',
        'Completed macro Greeting']],
    'listExecute': [['listStart', 'listAdd move 200', 'listExecute'], [
        'List being cleared', 'Making new list', "Added task 'move 200' to the list",
        'Executing list', 'Successfully finished task list']],
    'waitTaskCancel': [['doTask wait 10', 'waitTaskCancel'], [
        'Will do task wait 10', 'Doing task wait 10',
        'WaitState: Waiting 10 seconds with status "Waiting"', 'WaitState: Waiting cancelled',
        'Completed doing task wait 10']],
    'pauseTaskCancel': [['doTask pause', 'pauseTaskState', 'pauseTaskCancel'], [
        'Will do task pause', 'Doing task pause', 'PauseTask: pausing', 'PauseTask: pausing',
        'PauseTask: cancelled', 'Completed doing task pause']],
}


@pytest.mark.parametrize('name', IMMEDIATE)
def test_a_command_answers_as_the_robot_does(name: str) -> None:
    commands, wanted = IMMEDIATE[name]
    lines = Rig().client().ask(*commands)
    if name == 'help':
        lines = lines[:2]
    check(wanted, lines)


@pytest.mark.parametrize('name', LASTING)
def test_a_lasting_command_tells_its_course(name: str) -> None:
    commands, wanted = LASTING[name]
    client = Rig().client()
    client.send(*commands)
    check(wanted, client.until(wanted[-1], times=wanted.count(wanted[-1]))[:len(wanted)])


def test_every_command_in_the_table_has_a_transcript() -> None:
    names = {row.name for row in TABLE.values()} - {'rangeDeviceList'}
    assert names == set(IMMEDIATE) | set(LASTING) | set(EQUIPMENT)


@pytest.mark.parametrize('name', [row.name for row in TABLE.values() if row.least])
def test_without_its_arguments_a_command_answers_its_usage(name: str) -> None:
    row = TABLE[name.lower()]
    assert Rig().client().ask(name) == [f'usage: {row.usage}']


@pytest.mark.parametrize('command', ['etaRequest', 'queueDropoff x', 'queryFaults', 'go', 'follow'])
def test_what_the_facts_do_not_know_is_unknown(command: str) -> None:
    assert Rig().client().ask(command) == [f'Unknown command {command.split()[0]}']


def test_a_long_unknown_name_comes_back_whole() -> None:
    assert Rig().client().ask('abcdefghijklmnopqrstuvw x') == [
        'Unknown command abcdefghijklmnopqrstuvw']


@pytest.mark.parametrize('command', ['gotoPoint 1 two', 'gotoPoint nan 0', 'gotoPoint 1e12 0',
                                     'doTask move far', 'patrolOnce Round 7', 'goto 12 north'])
def test_a_bad_argument_is_refused_in_two_lines(command: str) -> None:
    client = Rig().client()
    client.send(command)
    lines = client.lines()
    assert lines[0] == f'CommandError: {command}', lines
    assert lines[1].startswith('CommandErrorDescription: Bad'), lines


def test_from_the_dock_goto_backs_out_first() -> None:
    client = Rig(start=None).client()
    client.send('goto 12')
    assert client.until('Arrived') == [
        'DockingState: Undocking ForcedState: Unforced ChargeState: Float',
        'DockingState: Undocking ForcedState: Unforced ChargeState: Not',
        'DockingState: Undocking ForcedState: Unforced ChargeState: Overcharge',
        'DockingState: Undocking ForcedState: Unforced ChargeState: Bulk',
        UNDOCKED, 'Going to 12', 'Arrived at 12']


def test_stopped_half_way_out_of_the_dock_the_robot_finds_its_way_on() -> None:
    rig = Rig(start=None)
    client = rig.client()
    client.send('goto 12')
    rig.clock.advance(1.0)
    client.send('stop')
    assert client.until('Stopped')[-4:] == [UNDOCKED, 'Interrupted: Going to 12', 'Stopping',
                                            'Stopped']
    client.send('goto 12')
    assert client.until('Arrived') == ['Going to 12', 'Arrived at 12']


@pytest.mark.parametrize('task', ['move 300', 'setHeading 90'])
def test_a_moving_task_leaves_the_dock_first(task: str) -> None:
    client = Rig(start=None).client()
    client.send(f'doTask {task}')
    lines = client.until('Completed')
    assert lines[-2:] == [UNDOCKED, f'Completed doing task {task}']


def test_a_dock_that_cannot_be_reached_leaves_the_robot_undocked() -> None:
    rig = Rig()
    rig.robot.navigation.blocks['crate'] = Disc(-2500.0, -2000.0, 300.0)
    client = rig.client()
    client.send('dock')
    assert client.until('Error')[-2:] == [UNDOCKED, 'Error: Failed going to goal']


def test_a_second_goto_replaces_the_first() -> None:
    rig = Rig()
    client = rig.client()
    client.send('goto "East side"')
    rig.clock.advance(3.0)
    client.send('goto 12')
    assert client.until('Arrived') == ['Going to East side', 'Interrupted: Going to East side',
                                       'Going to 12', 'Arrived at 12']


def test_stop_on_the_way_tells_what_it_ended() -> None:
    rig = Rig()
    client = rig.client()
    client.send('goto 12')
    rig.clock.advance(4.0)
    moving = rig.robot.base.speed
    client.send('stop')
    assert client.until('Stopped') == ['Going to 12', 'Interrupted: Going to 12', 'Stopping',
                                       'Stopped']
    assert moving > 0.0 and rig.robot.base.speed == 0.0


def test_a_stopped_patrol_is_resumed_at_the_goal_it_was_going_to() -> None:
    client = Rig().client()
    client.send('patrolOnce Round')
    client.until('Going to East side')
    client.send('stop')
    client.until('Stopped')
    client.send('patrolResume Round')
    assert client.until('Finished') == ['Patrolling route Round once', 'Going to East side',
                                        'Arrived at East side', 'Finished patrolling route Round']


def test_variables_are_filled_in() -> None:
    client = Rig(start=(-2500.0, 250.0, 90.0)).client()
    assert client.ask('say at $X $Y $T') == ['Saying at -2500 250 90']


def test_a_block_and_a_fault_of_one_name_are_two_things() -> None:
    client = Rig().client()
    lines = client.ask('afs door "Door" "open" 1 0', 'abds door a b', 'afc door', 'goto 12')
    assert lines[-1] == 'CommandErrorDescription: Driving blocked by door'
    client.send('abdc door', 'goto 12')
    assert client.until('Arrived') == ['Going to 12', 'Arrived at 12']


def test_configuration_is_closed_without_arclconfig() -> None:
    rig = Rig()
    rig.server.configuration.set('ARCL server setup', 'ArclConfig', 'false')
    assert rig.client().ask('getConfigSectionList') == [
        'CommandError: getConfigSectionList', 'CommandErrorDescription: ArclConfig is off']


def test_a_wrong_value_leaves_the_configuration_as_it_was() -> None:
    rig = Rig()
    lines = rig.client().ask('configStart', 'configAdd Section Docking', 'configAdd AutoDock true',
                             'configAdd AutoDockCharge lots', 'configParse')
    assert lines[-1] == ("Config had errors parsing: AutoDockCharge must be a number, not 'lots'")
    assert not rig.server.configuration.flag('Docking', 'AutoDock')
