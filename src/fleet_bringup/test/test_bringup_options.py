"""The arguments of `scripts/run.sh fleet:=...`."""
from __future__ import annotations

import os

import pytest

from fleet_bringup.errors import CannotStart
from fleet_bringup.options import help_text, parse


def test_arguments_are_read():
    options = parse(['fleet:=4', 'longest_edge:=1.5', 'demo:=true', 'sim_speed:=5', 'rviz:=0'])
    assert (options.fleet, options.longest_edge, options.demo, options.sim_speed,
            options.rviz) == ('4', 1.5, True, 5.0, False)


def test_files_are_made_absolute():
    assert parse(['fleet:=2', 'graph_file:=g.yaml']).graph_file == os.path.abspath('g.yaml')


@pytest.mark.parametrize('words, problem', [
    (['4'], "'4' is not of the form name:=value"),
    (['fleet:=2', 'longest:=1'], "no argument 'longest' with fleet:=; did you mean longest_edge"),
    (['demo:=true'], 'fleet:= is missing'),
    (['fleet:=2', 'demo:=maybe'], 'demo:=maybe must be true or false'),
    (['fleet:=2', 'arcl_port:=70000'], 'must be a TCP port from 1 to 65535'),
    (['fleet:=2', 'sim_speed:=nan'], 'sim_speed:=nan must lie in 0.1 to 20'),
    (['fleet:=2', 'longest_edge:=0.2'], 'longest_edge:=0.2 must be 0.5 m or more'),
    (['fleet:=2', 'base_map:=a.map', 'map_file:=b.map'], 'only one'),
])
def test_what_is_wrong_is_one_sentence(words, problem):
    with pytest.raises(CannotStart, match=problem):
        parse(words)


def test_the_help_names_every_argument():
    assert '  longest_edge:=  m; longer edges are divided into sections' in help_text()
