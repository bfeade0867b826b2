"""The commands' transcripts, and rules for all commands."""
from __future__ import annotations

import pytest
import transcripts_configuration
import transcripts_devices
import transcripts_driving
import transcripts_equipment
import transcripts_map
import transcripts_state
from sim_builders import Rig
from sim_transcripts import check

from omron_ld90_sim.interface.commands import TABLE

IMMEDIATE = {
    name: transcript
    for module in (transcripts_configuration, transcripts_devices, transcripts_driving,
                   transcripts_equipment, transcripts_map, transcripts_state)
    for name, transcript in module.IMMEDIATE.items()}
LASTING = transcripts_driving.LASTING
EVENTS = ('Fault: ', 'FaultCleared: ', 'Stopping', 'Stopped', 'Interrupted: ', 'Doing task ',
          'WaitState: Waiting 10 seconds ', 'Configuration changed', 'Shutting down server',
          'Status: fooled you', 'PayloadUpdate: ', 'extIOInputUpdate', 'extIOOutputUpdate')

# commands and their shortcuts in a real robot's help list (ARCL manual I617-E-02 p. 131-133, unless
# a robot's transcript says otherwise)
HELP = """\
analogInputList          Lists the named analog inputs
analogInputQueryRaw          Queries the state of an analog input by raw
analogInputQueryVoltage          Queries the state of an analog input by voltage
applicationBlockDrivingClear          Clears an application blockDriving [abdc]
applicationBlockDrivingSet          Sets an application blockDriving [abds]
applicationFaultClear          Clears an application fault [afc]
applicationFaultQuery          Gets the list of any application faults currently triggered [afq]
applicationFaultSet          Sets an application fault [afs]
   arclSendText          Sends the given message to all ARCL clients
      configAdd          Adds a config file line to the config values being imported.
    configParse          Parses the imported config values and terminates the configStart command.
    configStart          Starts importing config values. Use with configAdd and configParse.
connectOutgoing          (re)connects a socket to the given outside server
     createInfo          creates a piece of information
           dock          Sends the robot to the dock
         doTask          does a task
  doTaskInstant          does an instant task (doesn't interrupt modes)
           echo          with no args gets echo, with args sets echo
   enableMotors          Enables the motors so the robot can drive again
   executeMacro          executes a given macro
      faultsGet          Gets the list of any faults currently triggered [fg]
getConfigSectionInfo          Gets the info about a section of the config
getConfigSectionList          Gets the list of sections in the config
getConfigSectionValues          Gets the values in a section of the config
    getDateTime          gets the date and time
       getGoals          gets a list of goals in the map (for use with goto)
        getInfo          Gets a piece of information
           help          gives the listing of available commands
           quit          closes this connection to the server
""".splitlines()

# the syntax of commands that need arguments, as in the manual
SYNTAX = """\
analogInputQueryRaw <name>
analogInputQueryVoltage <name>
applicationFaultClear <name>
applicationFaultSet <name> "<short_description>" "<long_description>" <bool_driving> <bool_critical>
arclSendText <string>
configAdd <configuration> <value>
connectOutgoing <hostname> <port>
createInfo <infoName> <maxLen> <infoValue>
doTask <task> <argument>
doTaskInstant <task> <argument>
executeMacro <macro_name>
getConfigSectionInfo <section>
getConfigSectionValues <section>
getInfo <infoName>
inputQuery <name>
log <message> [level]
mapObjectInfo <name>
mapObjectList <type>
mapObjectTypeInfo <type>
newConfigParam <section> <name> <description> <priority_level> <type> <default_value> <min> <max> \
<DisplayHint>
newConfigSectionComment <section> <comment>
outputOff <name>
outputOn <name>
outputQuery <name>
patrol <route_name>
patrolOnce <route_name> [index]
patrolResume <route_name>
play <path_file>
popupSimple <"title"> <"message"> <"buttonLabel"> <timeout>
say <text_string>
updateInfo <infoName> <infoValue>
""".splitlines()


@pytest.mark.parametrize('name', IMMEDIATE)
def test_a_command_answers_as_the_robot_does(name: str) -> None:
    commands, wanted = IMMEDIATE[name]
    check(wanted, Rig().client().ask(*commands))


@pytest.mark.parametrize('name', LASTING)
def test_a_lasting_command_tells_its_course(name: str) -> None:
    commands, wanted = LASTING[name]
    client = Rig().client()
    client.send(*commands)
    check(wanted, client.until(wanted[-1], times=wanted.count(wanted[-1]))[:len(wanted)])


@pytest.mark.parametrize('name', IMMEDIATE)
def test_answers_go_to_the_asker_and_events_to_everybody(name: str) -> None:
    rig = Rig()
    asker, other = rig.client(), rig.client()
    lines = asker.ask(*IMMEDIATE[name][0])
    assert other.lines() == [line for line in lines if line.startswith(EVENTS)]


def test_every_command_in_the_table_has_a_transcript() -> None:
    names = {row.name for row in TABLE.values()} - {'rangeDeviceList', 'help'}
    assert names == set(IMMEDIATE) | set(LASTING)


@pytest.mark.parametrize('line', HELP)
def test_the_help_list_says_of_a_command_what_a_robots_does(line: str) -> None:
    lines = Rig().client().ask('help')
    assert (lines[0], lines[-1]) == ('Commands:', 'End of commands')
    assert line in lines


@pytest.mark.parametrize('syntax', SYNTAX)
def test_a_missing_argument_is_answered_with_the_manuals_syntax(syntax: str) -> None:
    assert Rig().client().ask(syntax.split()[0]) == [f'usage: {syntax}']


@pytest.mark.parametrize('name', [row.name for row in TABLE.values() if row.required])
def test_without_its_arguments_a_command_answers_its_usage(name: str) -> None:
    row = TABLE[name.lower()]
    assert Rig().client().ask(name) == [f'usage: {row.usage}']


@pytest.mark.parametrize('shortcut', [key for key, row in TABLE.items() if key == row.shortcut])
def test_a_shortcut_is_its_command(shortcut: str) -> None:
    assert Rig().client().ask(shortcut) == Rig().client().ask(TABLE[shortcut].name)


@pytest.mark.parametrize('extra', ['inputQuery Input_1 now', 'outputQuery Output_1 "please"',
                                   'analogInputQueryVoltage Analog_1 2 3', 'queryMotors all',
                                   'mapObjectTypeInfo Goal West', 'odometer mm'])
def test_an_argument_too_many_is_ignored(extra: str) -> None:
    plain = ' '.join(extra.split()[:2 if TABLE[extra.split()[0].lower()].required else 1])
    assert Rig().client().ask(extra) == Rig().client().ask(plain)
    assert not Rig().client().ask(extra)[0].startswith('CommandError')


@pytest.mark.parametrize('command', ['queryFaults', 'payloadQuery', 'payloadSlotCount'])
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


def test_variables_are_filled_in() -> None:
    client = Rig(start=(-2500.0, 250.0, 90.0)).client()
    assert client.ask('say at $X $Y $T') == ['Saying at -2500 250 90']
    assert client.ask('say at $x $t') == ['Saying at -2500 90']


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


@pytest.mark.parametrize('value', ['lots', 'nan', '1e400'])
def test_a_wrong_value_leaves_the_configuration_as_it_was(value: str) -> None:
    rig = Rig()
    lines = rig.client().ask('configStart', 'configAdd Section Docking', 'configAdd AutoDock true',
                             f'configAdd AutoDockStateOfCharge {value}', 'configParse')
    assert lines[-1] == ('Config had errors parsing: AutoDockStateOfCharge must be a number, '
                         f"not '{value}'")
    assert not rig.server.configuration.flag('Docking', 'AutoDock')


def test_a_map_that_is_not_there_leaves_the_configuration_as_it_was() -> None:
    rig = Rig()
    lines = rig.client().ask('configStart', 'configAdd Section Docking', 'configAdd AutoDock true',
                             'configAdd Section Files', 'configAdd Map moon.map', 'configParse')
    assert lines[-1].startswith('Config had errors parsing: ') and 'moon.map' in lines[-1]
    assert not rig.server.configuration.flag('Docking', 'AutoDock')


def test_a_change_of_the_configuration_waits_until_the_robot_is_idle() -> None:
    rig = Rig()
    client = rig.client()
    client.send('goto 12', 'configStart', 'configAdd Section Docking', 'configAdd AutoDock true',
                'configParse')
    assert client.until('Arrived')[-2:] == ['Will parse config', 'Arrived at 12']
    assert not rig.server.configuration.flag('Docking', 'AutoDock')
    assert client.until('Config parsed') == ['Configuration changed', 'Config parsed fine']
    assert rig.server.configuration.flag('Docking', 'AutoDock')
