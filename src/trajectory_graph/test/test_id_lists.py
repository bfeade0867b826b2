"""A sentence names few ids, even if there are many."""
from __future__ import annotations

import re
from pathlib import Path

import pytest

from trajectory_graph.id_lists import MOST, listed

SOURCES = Path(__file__).resolve().parents[2]
JOINED = re.compile(r'''join\(map\(str|\{(list|tuple|sorted)\([^(]*\)\}''')
#: Parts of paths. These files may list all ids: they write what a person has requested, the
#: program's own files, or tests.
COMPLETE = ('/commands/', 'fleet_simulation/', 'omron_map/', 'omron_ld90_sim/', 'graph_editor/',
            'vda5050_bench/', '/journal.py', '/history.py', 'fleet_page/', 'fleet_bringup/')


@pytest.mark.every_python
@pytest.mark.parametrize('ids, text', [
    ((), ''), ((7,), '7'), ((3, -4), '3, -4'), (range(MOST), ', '.join(map(str, range(MOST)))),
    (range(MOST + 1), ', '.join(map(str, range(MOST))) + ' and 1 more')])
def test_the_first_ids_are_named_and_the_others_counted(ids, text):
    assert listed(ids) == text


@pytest.mark.every_python
def test_a_list_of_millions_is_not_walked_through():
    assert listed(range(2 ** 31)) == listed(range(MOST)) + f' and {2 ** 31 - MOST} more'


def test_logs_and_reasons_list_ids_so():
    own = [f'{file.relative_to(SOURCES)}: {line.strip()}' for file in SOURCES.glob('*/src/**/*.py')
           if not any(part in str(file) for part in COMPLETE)
           for line in file.read_text(encoding='utf-8').splitlines() if JOINED.search(line)]
    assert not own, 'use trajectory_graph.id_lists.listed'
