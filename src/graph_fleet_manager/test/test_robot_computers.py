"""A fleet manager joins the ROS masters on the computers of the robots in its fleet file."""
from __future__ import annotations

from pathlib import Path

import pytest

from fleet_core.files.errors import FileError
from fleet_core.files.robot_computers import is_address, load_computers
from graph_fleet_manager.commands.peers import main, peers

FLEET = '''clearance: 0.1
robot_types:
- {name: agv, radius: 0.4, speed: 1.0}
robots:
- {name: a, type: agv, vertex: 6, computer: 10.0.0.21}
- {name: b, type: agv, vertex: 8}
- {name: c, type: agv, vertex: 10, computer: robot-c.local}
'''


@pytest.fixture
def fleet(tmp_path: Path) -> Path:
    path = tmp_path / 'fleet.yaml'
    path.write_text(FLEET)
    return path


def test_robots_without_a_computer_are_under_the_fleets_own_master(fleet):
    assert load_computers(fleet) == {'a': '10.0.0.21', 'c': 'robot-c.local'}


def test_what_is_no_address_is_named_with_its_line(fleet):
    fleet.write_text(FLEET.replace('10.0.0.21', '10.0.0.2100'))
    with pytest.raises(FileError, match='the IPv4 address or the name') as caught:
        load_computers(fleet)
    assert caught.value.line == 5


@pytest.mark.parametrize('text, valid', [
    ('10.0.0.5', True), ('robot-5', True), ('robot.site.example', True), ('localhost', True),
    ('10.0.0', False), ('10.0.0.256', False), ('', False), ('a b', False), ("a'b", False),
    ('-robot', False), ('http://10.0.0.5', False)])
def test_addresses(text, valid):
    assert is_address(text) == valid


def test_peers_are_those_given_and_those_of_the_fleet_each_once(fleet):
    assert peers('10.0.0.9, 10.0.0.21', str(fleet)) == ['10.0.0.9', '10.0.0.21', 'robot-c.local']
    assert peers('10.0.0.9', '') == ['10.0.0.9']


def test_the_command_prints_a_list_for_the_launch_file(fleet, capsys):
    assert main(['', str(fleet)]) == 0
    assert capsys.readouterr().out == '[10.0.0.21, robot-c.local]\n'


@pytest.mark.parametrize('words, problem', [
    (['', ''], 'set peer:=ADDRESS'), (['10.0.0.5:11311', ''], 'neither an IPv4 address nor'),
    (['', '/nowhere/fleet.yaml'], '/nowhere/fleet.yaml')])
def test_the_command_says_what_to_do_where_there_is_nobody_to_join(words, problem, capsys):
    assert main(words) == 1
    assert problem in capsys.readouterr().err
