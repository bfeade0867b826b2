"""Command lines: which lines are valid, names in lines, and the display of lines for people."""
from __future__ import annotations

import pytest

from omron_arcl import InvalidCommand, parse_command, printable, quote, same_name
from omron_arcl.command_line import LONGEST_COMMAND, is_stop


@pytest.mark.parametrize(('text', 'name', 'arguments'), [
    ('goto 12', 'goto', ('12',)),
    ('  GOTO 12 ', 'goto', ('12',)),
    ('goto "goal space" 90', 'goto', ('goal space', '90')),
    ('applicationFaultSet f "a b" "c d" 0 1', 'applicationFaultSet', ('f', 'a b', 'c d', '0', '1')),
    ('stop', 'stop', ()),
    ('newFangled thing', 'newFangled', ('thing',)),
])
def test_a_command_line_is_read(text, name, arguments):
    command = parse_command(text)
    assert (command.name, command.arguments) == (name, arguments)


@pytest.mark.parametrize(('text', 'reason'), [
    ('', 'empty'), ('   ', 'empty'), ('goto 1\nshutdown', 'line end'), ('goto 1\r', 'line end'),
    ('goto 1\x00', 'control'), ('goto caf\xe9', 'ASCII'), ('a\tb', 'control'),
    ('x' * (LONGEST_COMMAND + 1), '5001'), ('goto', 'goto <goal>'),
    ('gotoPoint 1', 'gotoPoint <x> <y>'),
])
def test_what_is_not_one_command_is_refused_with_a_reason(text, reason):
    with pytest.raises(InvalidCommand) as refused:
        parse_command(text)
    assert reason in str(refused.value)
    assert refused.value.command.isprintable()


@pytest.mark.parametrize(('text', 'stops'), [
    ('stop', True), (' STOP ', True), ('stop now', True), ('stopp', False), ('', False),
    ('goto stop', False)])
def test_a_stop_is_known_however_it_is_written(text, stops):
    assert is_stop(text) is stops


@pytest.mark.parametrize('text', ['stop\n', 'stop now', ' stop\r\n', 'stop\nshutdown', 'stop \xf6'])
def test_nothing_behind_it_keeps_a_stop_from_the_robot(text):
    assert parse_command(text).line == b'stop'


def test_the_longest_command_is_taken():
    assert parse_command('x' * LONGEST_COMMAND).text == 'x' * LONGEST_COMMAND


LISTED = {'K\xfcche': b'K\xfcche', 'Caf\xe9 2': 'Caf\xe9 2'.encode(), 'Stra\xdfe': b'Stra\xdfe'}


@pytest.mark.parametrize(('text', 'line'), [
    ('goto K\xfcche', b'goto K\xfcche'), ('goto k\xdcCHE 90', b'goto K\xfcche 90'),
    ('goto "Caf\xe9 2"', b'goto "Caf\xc3\xa9 2"'), ('goto Stra\xdfe', b'goto Stra\xdfe'),
    ('gotoRouteGoal K\xfcche "Caf\xe9 2"', b'gotoRouteGoal K\xfcche "Caf\xc3\xa9 2"'),
])
def test_a_name_is_sent_as_the_robot_listed_it(text, line):
    command = parse_command(text, names=LISTED)
    assert command.line == line
    assert command.text == text


def test_a_name_that_the_robot_has_not_listed_is_refused_in_words():
    with pytest.raises(InvalidCommand, match='"\xf6" is not ASCII.*has listed'):
        parse_command('goto B\xf6den', names=LISTED)


def test_a_command_of_the_table_means_itself_whatever_the_help_list_says():
    assert parse_command('stop', {'stop': 'shutdown'}.get).spec.stops


def test_a_shortcut_is_resolved_by_the_robots_help_list():
    command = parse_command('xyz', {'xyz': 'odometer'}.get)
    assert command.name == 'odometer'
    assert command.text == 'xyz'


@pytest.mark.parametrize(('name', 'quoted'), [('12', '12'), ('goal space', '"goal space"')])
def test_names_with_blanks_are_quoted(name, quoted):
    assert quote(name) == quoted


@pytest.mark.parametrize(('name', 'quoted'), [
    ('K\xfcche', 'K\xfcche'), ('K\udcfcche', 'K\xfcche'), ('Halle\xa0', None),
    ('B\xfcro 2', '"B\xfcro 2"'), ('K\udcc3\udcbcche', 'K\xfcche')])
def test_a_name_out_of_a_map_file_is_read_as_the_robots_own(name, quoted):
    if quoted:
        assert quote(name) == quoted
        assert same_name(name, quoted.strip('"').upper())
    else:
        with pytest.raises(InvalidCommand):
            quote(name)


@pytest.mark.parametrize('name', ['', 'a"b', 'a\nb', 'a\x1b[2Jb', 'a\u2028b', '\ud800'])
def test_names_that_arcl_cannot_express_are_refused(name):
    with pytest.raises(InvalidCommand):
        quote(name)


@pytest.mark.parametrize(('text', 'name'), [
    ('goto 12', '12'), ('goto x', 'X'), ('goto "goal space"', 'goal space'),
    ('goto goal space', 'Goal Space'), ('goto "goal space" 90', 'goal space'),
    ('goto 12 90', '12'), ('gotoRouteGoal r g', 'g'), ('executeMacro my macro', 'my macro'),
    ('patrolOnce my route 2', 'my route'),
])
def test_a_reply_names_the_goal_of_a_command_without_case(text, name):
    assert parse_command(text).is_for(name)


@pytest.mark.parametrize(('text', 'name'), [('goto 12', '1'), ('gotoRouteGoal r g', 'r'),
                                            ('stop', 'x')])
def test_a_reply_about_another_goal_is_none_of_its(text, name):
    assert not parse_command(text).is_for(name)


def test_text_for_people_holds_no_password_of_the_configuration():
    assert printable('configAdd Password secret') == 'configAdd Password ********'


def test_text_for_people_is_printable_and_short():
    assert printable('a\nb\x1b[2J') == r'a\nb\x1b[2J'
    assert printable('K\xfcche \ud55c\uae00') == 'K\xfcche \ud55c\uae00'
    assert printable('K\udcfcche\u202e') == r'K\udcfcche\u202e'
    assert len(printable('x' * 1000)) == 200
