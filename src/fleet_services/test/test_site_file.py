"""The site file is read strictly: each error message names the line."""
from __future__ import annotations

from pathlib import Path

import pytest

from fleet_bringup.errors import CannotStart
from fleet_core.files.errors import FileError
from fleet_services.site_file import read_site

SITE = '''name: hall
user: fleet
address: 10.0.0.9
robots_per_unit: 5
arguments:
  fleet: fleet.yaml
  map_file: maps/site.map
  page_port: 8443
'''


def write(folder: Path, text: str) -> str:
    path = folder / 'site.yaml'
    path.write_text(text)
    return str(path)


def test_files_are_relative_to_the_site_file(tmp_path):
    site = read_site(write(tmp_path, SITE))
    assert (site.name, site.user, site.address, site.robots_per_unit) == (
        'hall', 'fleet', '10.0.0.9', 5)
    assert site.options.fleet == str(tmp_path / 'fleet.yaml')
    assert site.options.map_file == str(tmp_path / 'maps' / 'site.map')
    assert site.options.page_port == 8443
    assert not site.options.rviz


def test_a_number_of_robots_is_no_file(tmp_path):
    assert read_site(write(tmp_path, 'name: a\narguments: {fleet: 2}\n')).options.fleet == '2'


@pytest.mark.parametrize(('text', 'problem'), [
    ('arguments: {fleet: 2}\n', 'line 1: name is missing'),
    ('name: a\n', 'line 1: arguments is missing'),
    ('name: a\nhosts: 2\narguments: {fleet: 2}\n', "line 2: there is no key 'hosts'"),
    ('name: ../a\narguments: {fleet: 2}\n', 'line 1: name "../a" must begin with a small letter'),
    ('name: a\nuser: "a b"\narguments: {fleet: 2}\n', 'line 2: user "a b" must begin'),
    ('name: a\naddress: "1 2"\narguments: {fleet: 2}\n',
     'line 2: address "1 2" is not the address or name of a computer'),
    ('name: a\nmaster_port: 0\narguments: {fleet: 2}\n', 'line 2: master_port is 0'),
    ('name: a\nrobots_per_unit: 0\narguments: {fleet: 2}\n', 'line 2: robots_per_unit is 0'),
    ('name: a\narguments:\n  fleet: 2\n  rviz: true\n', 'line 4: rviz cannot be used in a service'),
    ('name: a\narguments:\n  fleet: [2]\n', 'line 3: fleet must be one value'),
])
def test_what_is_wrong_is_named_with_its_line(tmp_path, text, problem):
    with pytest.raises(FileError, match=problem.replace('.', r'\.')):
        read_site(write(tmp_path, text))


def test_wrong_arguments_are_those_of_the_fleet(tmp_path):
    with pytest.raises(CannotStart, match='did you mean longest_edge'):
        read_site(write(tmp_path, 'name: a\narguments: {fleet: 2, longest_edges: 1}\n'))


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(FileError, match='cannot be read'):
        read_site(str(tmp_path / 'nothing.yaml'))
