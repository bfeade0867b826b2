"""The table of commands (categories, shortcuts, the end of each command), and the help list."""
from __future__ import annotations

import pytest

from omron_arcl import COMMANDS, Category, HelpList, parse_command
from omron_arcl.help_list import read_entry


@pytest.mark.parametrize(('name', 'category'), [
    ('goto', Category.MOTION), ('stop', Category.MOTION), ('localizeToPoint', Category.MOTION),
    ('go', Category.MOTION), ('stay', Category.MOTION),
    ('status', Category.QUERY), ('getConfigSectionValues', Category.QUERY),
    ('distanceFromHere', Category.QUERY), ('queueQueryLocal', Category.QUERY),
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


def test_a_driving_command_tells_how_it_begins_and_ends():
    for spec in COMMANDS.values():
        if spec.drives:
            assert spec.acknowledged_by, spec
            assert spec.completed_by, spec
            assert spec.related, spec


def test_every_command_has_a_bound():
    assert all(0.0 < spec.timeout <= 3600.0 for spec in COMMANDS.values())


def test_only_stop_stops():
    assert [spec.name for spec in COMMANDS.values() if spec.stops] == ['stop']


def test_no_command_is_in_the_table_twice():
    assert len(COMMANDS) == len({spec.name.lower() for spec in COMMANDS.values()})
    assert all(name == name.lower() for name in COMMANDS)


@pytest.mark.parametrize(('shortcut', 'name'), [
    ('afq', 'applicationFaultQuery'), ('abdc', 'applicationBlockDrivingClear'),
    ('QSRL', 'queueShowRobotLocal'), ('qd', 'queueDropoff')])
def test_the_shortcuts_of_the_known_help_lists_need_no_help_list(shortcut, name):
    text = ' '.join([shortcut, *['1'] * COMMANDS[name.lower()].required])
    assert parse_command(text).name == name
    assert parse_command(text).line == text.encode()


def test_no_shortcut_is_a_command_or_stands_twice():
    shortcuts = [spec.shortcut for spec in COMMANDS.values() if spec.shortcut]
    assert len(set(shortcuts)) == len(shortcuts)
    assert not set(shortcuts) & set(COMMANDS)


# -- the robot's help list -------------------------------------------------------------------------

def test_it_knows_names_without_case_and_shortcuts():
    help_list = HelpList({'applicationFaultQuery': 'Gets the faults [afq]', 'goto': 'Goes'})
    assert help_list.full_name('GOTO') == 'goto'
    assert help_list.full_name('afq') == 'applicationFaultQuery'
    assert help_list.full_name('quit') is None


@pytest.mark.parametrize(('line', 'entry'), [
    ('           goto          Goes to a goal', ('goto', 'Goes to a goal')),
    ('applicationFaultQuery          Gets faults [afq]',
     ('applicationFaultQuery', 'Gets faults [afq]')),
    ('goto                        Goes to a goal', ('goto', 'Goes to a goal')),
    ('stop Stops the robot', ('stop', 'Stops the robot')),
    ('stop', ('stop', '')),
    ('12 34', None), ('', None), ('"goto" Goes', None),
])
def test_an_entry_is_read_in_any_layout(line, entry):
    assert read_entry(line) == entry
