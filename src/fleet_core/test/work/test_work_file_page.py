"""docs/reference/work_file.md describes the file that is read: its keys, and an example."""
from __future__ import annotations

import re
from pathlib import Path
from textwrap import dedent

import pytest

from fleet_core.files import work_file
from fleet_core.files.work_file import load_work
from fleet_core.work.timetables import Timetable
from trajectory_graph import load_graph

ROOT = Path(__file__).resolve().parents[4]
PAGE = (ROOT / 'docs/reference/work_file.md').read_text()


def test_the_example_is_read_with_the_graph_of_the_laboratory(tmp_path):
    example = PAGE.split('## The smallest example\n')[1].split('\nWith it')[0]
    (tmp_path / 'work.yaml').write_text(dedent(example))
    work = load_work(tmp_path / 'work.yaml', load_graph(ROOT / 'maps/lab_graph.yaml'))
    assert work.stations['press'].places == (18,)
    assert work.timetables['pallet'] == Timetable(
        'pallet', 'pallet', 30, (('to', '39'),), 360, 1080, frozenset(range(5)))


@pytest.mark.parametrize('part, keys', [
    ('stations', work_file._STATION), ('devices', work_file._DEVICE),
    ('zones', work_file._ZONE), ('loads', work_file._LOAD), ('chargers', work_file._CHARGER),
    ('templates', work_file._TEMPLATE), ('timetables', work_file._TIMETABLE),
    ('job_steps', work_file._JOB_STEPS)])
def test_the_page_has_exactly_the_keys_that_are_read(part, keys):
    table = PAGE.split(f'### `{part}`\n')[1].split('\n#')[0]
    cells = [line.split('|')[1] for line in table.splitlines() if line.startswith('| `')]
    assert sorted(key for cell in cells for key in re.findall(r'`(\w+)`', cell)) == sorted(keys)


def test_the_page_has_all_lists_of_the_file():
    assert set(re.findall(r'^### `(\w+)`', PAGE, re.MULTILINE)) == set(work_file._FILE)
