"""Robots that are less exact than an LD-90: the switches of the fault `dialect`."""
from __future__ import annotations

from typing import List

import pytest
from sim_builders import ROOM, Rig

from omron_ld90_sim.interface.faults import Faults, NoSuchFault
from omron_map import MapDocument


def speaking(*switches: str, start: str = ROOM, coding: str = 'utf-8') -> Rig:
    """Returns a robot in a room. Its dialect is switched before a client connects."""
    rig = Rig(MapDocument.from_bytes(start.encode(coding), name='room.map'))
    for switch in switches:
        Faults(rig.server).inject(f'dialect {switch}')
    return rig


def login(rig: Rig) -> bytes:
    """Returns everything that a client receives before its first command."""
    session = rig.server.connect()
    session.receive(b'adept\n')
    return bytes(session.output)


def test_a_prompt_without_a_line_end() -> None:
    session = speaking('prompt Password:').server.connect()
    assert bytes(session.output) == b'Password:'
    session.receive(b'adept\n')
    assert session.output.startswith(b'Password:Welcome to the server.\r\n')


def test_another_welcome_or_none() -> None:
    assert b'\r\nHello.\r\nCommands:\r\n' in login(speaking('welcome Hello.'))
    assert login(speaking('welcome')).startswith(b'Enter password:\r\nCommands:\r\n')


@pytest.mark.parametrize('layout, line', [
    ('left', 'dock                        Sends the robot to the dock'),
    ('left', 'applicationBlockDrivingClearClears an application blockDriving [abdc]'),
    ('names', 'dock'), ('right', '           dock          Sends the robot to the dock')])
def test_the_help_list_in_another_layout(layout: str, line: str) -> None:
    lines = speaking(f'help {layout}').client().ask('help')
    assert (lines[0], lines[-1]) == ('Commands:', 'End of commands') and line in lines


def test_no_help_list_after_the_login() -> None:
    rig = speaking('help none')
    assert b'Commands' not in login(rig)
    assert rig.client().ask('help') == ['Commands:', 'End of commands']


def test_a_command_that_is_not_listed_works_and_one_that_is_missing_does_not() -> None:
    client = speaking('unlisted goto dock', 'missing status').client()
    names = [line.split()[0] for line in client.ask('help')[1:-1]]
    assert not {'goto', 'dock', 'status'} & set(names) and 'stop' in names
    assert client.ask('goto 12') == ['Going to 12']
    assert client.ask('status') == ['Unknown command status']


@pytest.mark.parametrize('words, wanted', [
    ('name', ['Interrupted: Going to 12']), ('coordinates', ['Interrupted: Going to 4500 -2000']),
    ('nothing', [])])
def test_a_drive_that_is_stopped_in_the_words_of_either_manual_or_in_none(
        words: str, wanted: List[str]) -> None:
    rig = speaking(f'interrupted {words}')
    client = rig.client()
    client.send('goto 12')
    rig.clock.advance(3.0)
    client.send('stop')
    assert client.until('Stopped') == ['Going to 12', *wanted, 'Stopping', 'Stopped']


def test_a_point_has_no_name_to_be_interrupted_by() -> None:
    rig = speaking()
    client = rig.client()
    client.send('gotoPoint -597 1765')
    rig.clock.advance(2.0)
    client.send('goto 12')
    assert client.until('Going to 12') == [
        'Going to point', 'Interrupted: Going to -597 1765', 'Going to 12']


def test_goal_names_in_quotes() -> None:
    client = speaking('goals quoted').client()
    assert client.ask('getGoals') == ['Goal: "West"', 'Goal: "East side"', 'Goal: "12"',
                                      'End of goals']


GERMAN = ROOM.replace('"West"', '"Küche"')


@pytest.mark.parametrize('coding, switches, name', [
    ('utf-8', (), 'Küche'.encode()), ('latin-1', (), b'K\xfcche'),
    ('utf-8', ('encoding latin-1',), b'K\xfcche')])
def test_a_name_that_is_not_ascii_is_listed_and_driven_to_byte_for_byte(
        coding: str, switches: List[str], name: bytes) -> None:
    rig = speaking(*switches, start=GERMAN, coding=coding)
    session = rig.client().session
    session.receive(b'getGoals\ngoto ' + name + b'\n')
    assert session.output.startswith(b'Goal: ' + name + b'\r\n')
    assert session.output.endswith(b'Going to ' + name + b'\r\n')


def test_a_robot_that_has_nothing_but_ascii() -> None:
    assert speaking('encoding ascii', start=GERMAN).client().ask('getGoals')[0] == 'Goal: K?che'


@pytest.mark.parametrize('words', ['accent swiss', 'help upside-down', 'encoding', 'goals maybe',
                                   'interrupted loudly', 'interrupted'])
def test_a_switch_that_is_none_is_refused(words: str) -> None:
    with pytest.raises(NoSuchFault, match='dialect WHAT VALUE'):
        speaking(words)


def test_a_robot_that_stops_for_an_instant_to_replace_a_drive() -> None:
    client = speaking('replacing stopping').client()
    client.ask('goto West')
    assert client.ask('goto "East side"') == [
        'Interrupted: Going to West', 'Stopping', 'Going to East side']


def test_a_refusal_without_the_name_of_the_command() -> None:
    assert speaking('unknown bare').client().ask('gooto 12') == ['Unknown command']


def test_the_status_of_an_older_robot() -> None:
    lines = speaking('battery volts', 'status older').client().ask('status')
    assert [line.split(':')[0] for line in lines] == [
        'Status', 'BatteryVoltage', 'Location', 'LocalizationScore', 'Temperature']
    assert lines[1] == 'BatteryVoltage: 28.0'
