"""The table of commands: syntax, quoting, categories, and how each command ends."""
from __future__ import annotations

import pytest

from omron_arcl import COMMANDS, Category, InvalidCommand, parse_command, printable, quote
from omron_arcl.command_line import LONGEST_COMMAND


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
    assert refused.value.command.isascii()
    assert refused.value.command.isprintable()


def test_the_longest_command_is_taken():
    assert parse_command('x' * LONGEST_COMMAND).text == 'x' * LONGEST_COMMAND


def test_a_shortcut_is_resolved_by_the_robots_help_list():
    command = parse_command('afq', {'afq': 'applicationFaultQuery'}.get)
    assert command.name == 'applicationFaultQuery'
    assert command.text == 'afq'


@pytest.mark.parametrize(('name', 'quoted'), [('12', '12'), ('goal space', '"goal space"')])
def test_names_with_blanks_are_quoted(name, quoted):
    assert quote(name) == quoted


@pytest.mark.parametrize('name', ['', 'a"b', 'a\nb', 'caf\xe9'])
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


@pytest.mark.parametrize(('name', 'category'), [
    ('goto', Category.MOTION), ('stop', Category.MOTION), ('localizeToPoint', Category.MOTION),
    ('status', Category.QUERY), ('getConfigSectionValues', Category.QUERY),
    ('say', Category.DEVICE), ('outputOn', Category.DEVICE),
    ('configParse', Category.CONFIGURATION), ('newConfigParam', Category.CONFIGURATION),
    ('extIOAdd', Category.CONFIGURATION), ('extIOInputUpdate', Category.DEVICE),
    ('extIODump', Category.QUERY), ('payloadSet', Category.DEVICE),
    ('payloadQueryLocal', Category.QUERY), ('tripReset', Category.DEVICE),
    ('queueModifyLocal', Category.MOTION), ('queueCancelLocal', Category.MOTION),
    ('shutdown', Category.DANGEROUS), ('quit', Category.DANGEROUS),
    ('extIORemove', Category.DANGEROUS), ('queuePickup', Category.UNKNOWN),
    ('abracadabra', Category.UNKNOWN),
])
def test_commands_have_a_category(name, category):
    text = ' '.join([name, *['1'] * (COMMANDS[name.lower()].required
                                     if name.lower() in COMMANDS else 0)])
    assert parse_command(text).spec.category is category


def test_whoever_drives_says_how_it_begins_and_ends():
    for spec in COMMANDS.values():
        if spec.drives:
            assert spec.begins, spec
            assert spec.ends, spec
            assert spec.belongs, spec


def test_only_what_is_known_is_in_the_table_twice_never():
    assert len(COMMANDS) == len({spec.name.lower() for spec in COMMANDS.values()})
    assert all(name == name.lower() for name in COMMANDS)


def test_text_for_people_holds_no_password_of_the_configuration():
    assert printable('configAdd Password secret') == 'configAdd Password ********'


def test_text_for_people_is_printable_and_short():
    assert printable('a\nb\xe9') == r'a\nb\xe9'
    assert len(printable('x' * 1000)) == 200
