"""The robot's help list: names, shortcuts, layouts."""
from __future__ import annotations

import pytest

from omron_arcl import HelpList
from omron_arcl.help_list import read_entry


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
