"""The command `plan_fleet`: its files, its exit statuses, and its messages about wrong input."""
from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from fleet_builders import AGV, as_files, corridor, graph_of, ladder
from plan_checker import World, faults

from graph_fleet_manager.commands.plan_fleet import main
from trajectory_graph import Graph

KEYS = {'solved', 'reason', 'planning_time', 'geometry_time', 'sum_of_costs', 'lower_bound',
        'makespan', 'robots', 'precedence'}


class Files:
    """The three files for a call of the command, in a folder, and the result of the call."""

    def __init__(self, folder: Path, graph, robots, missions, types=(AGV,), clearance=0.1):
        self.folder = folder
        self.data = as_files(graph, types, robots, missions, clearance)
        for name, data in zip(('graph', 'fleet', 'missions'), self.data):
            self.path(name).write_text(yaml.safe_dump(data))

    def path(self, name: str) -> Path:
        return self.folder / f'{name}.yaml'

    @property
    def output(self) -> Path:
        return self.folder / 'plan.json'

    def arguments(self, *more: str):
        return ['--graph', str(self.path('graph')), '--fleet', str(self.path('fleet')),
                '--missions', str(self.path('missions')), '--output', str(self.output),
                '--time-limit', '0.5', *more]

    def plan(self):
        return json.loads(self.output.read_text())


@pytest.fixture
def swap(tmp_path):
    """Returns files in which two robots swap places in a corridor with a siding."""
    return Files(tmp_path, corridor(5, siding_at=3), {'a': ('agv', 1), 'b': ('agv', 5)},
                 {'a': [5], 'b': [1]})


def test_two_robots_swap_places_and_the_plan_is_written_in_full(swap, capsys):
    assert main(swap.arguments()) == 0
    plan = swap.plan()
    assert set(plan) == KEYS
    assert plan['solved'] is True
    assert plan['lower_bound'] == 16.0
    assert 0.0 < plan['geometry_time'] <= plan['planning_time'] <= 0.6
    assert faults(World(*swap.data), plan) == []
    assert 'sum of costs' in capsys.readouterr().out


def test_numbers_are_not_rounded(tmp_path):
    files = Files(tmp_path, graph_of({1: (0, 0), 2: (1, 3)}, {1: (1, 2)}), {'a': ('agv', 1)},
                  {'a': [2]})
    assert main(files.arguments()) == 0
    assert files.plan()['robots']['a'] == [{'edge': 1, 'start': 0.0, 'end': 10 ** 0.5}]


def test_planning_ends_early_at_the_lower_bound(tmp_path):
    files = Files(tmp_path, corridor(4), {'a': ('agv', 1)}, {'a': [4]})
    assert main([*files.arguments(), '--time-limit', '30']) == 0
    assert files.plan()['planning_time'] < 5.0


def test_a_fleet_without_missions_stays_where_it_is(tmp_path):
    files = Files(tmp_path, corridor(4), {'a': ('agv', 1), 'b': ('agv', 4)}, {})
    assert main(files.arguments()) == 0
    assert files.plan()['robots'] == {'a': [], 'b': []}
    assert files.plan()['makespan'] == 0.0


def test_a_destination_that_is_driven_through_is_visited(tmp_path):
    files = Files(tmp_path, corridor(4), {'a': ('agv', 1)}, {'a': [2, 4, 3]})
    assert main(files.arguments()) == 0
    assert [d['edge'] for d in files.plan()['robots']['a']] == [1, 2, 3, -3]


def test_what_has_no_solution_is_status_2_with_the_reason(tmp_path, capsys):
    files = Files(tmp_path, corridor(4), {'a': ('agv', 1), 'b': ('agv', 4)}, {'a': [4], 'b': [1]})
    assert main(files.arguments()) == 2
    plan = files.plan()
    assert set(plan) == KEYS
    assert plan['solved'] is False
    assert plan['robots'] == {'a': [], 'b': []}
    assert plan['reason'] == ('a: on the way to vertex 4 it is blocked by b, which stands at '
                              'vertex 4')
    assert capsys.readouterr().err == f'Not solved: {plan["reason"]}.\n'


def test_conflict_sets_that_take_too_long_are_status_2(swap):
    assert main([*swap.arguments(), '--time-limit', '1e-9']) == 2
    assert swap.plan()['reason'] == 'the conflict sets were not known within 1e-09 s'


def test_the_same_seed_gives_the_same_plan_in_another_process(tmp_path):
    files = Files(tmp_path, ladder(6), {f'r{k}': ('agv', k) for k in range(1, 7)},
                  {f'r{k}': [7 - k] for k in range(1, 7)})
    plans = []
    for hash_seed in ('1', '2'):
        subprocess.run(
            [sys.executable, '-c', 'import sys; from graph_fleet_manager.commands.plan_fleet '
             'import main; sys.exit(main(sys.argv[1:]))', *files.arguments(
                 '--rounds', '30', '--seed', '7'), '--time-limit', '60'],
            check=True, stdout=subprocess.DEVNULL,
            env={**os.environ, 'PYTHONHASHSEED': hash_seed,
                 'PYTHONPATH': os.pathsep.join(p for p in sys.path if p)})
        plan = files.plan()
        del plan['planning_time'], plan['geometry_time']
        plans.append(plan)
    assert plans[0] == plans[1]


@pytest.mark.parametrize('search', ['safe_intervals', 'layers'])
def test_either_search_solves_it(swap, search):
    assert main(swap.arguments('--search', search, '--layer-length', '0.5')) == 0
    assert faults(World(*swap.data), swap.plan()) == []


def _refused(files: Files, capsys) -> str:
    assert main(files.arguments()) == 1
    assert not files.output.exists()
    message = capsys.readouterr().err
    assert message.count('\n') == 1, message
    assert message.endswith('.\n')
    return message


@pytest.mark.parametrize('robots, missions, sentence', [
    ({'a': 9}, {}, 'robot a stands on vertex 9, which the graph does not have'),
    ({'a': 1}, {'a': [9]}, 'robot a is to visit vertex 9, which the graph does not have'),
    ({'a': 1}, {'b': [2]}, 'there is no robot b'),
    ({'a': 1, 'b': 1}, {}, 'Robots a and b cannot both stand on vertex 1'),
    ({'a': 1, 'b': 2}, {'a': [4], 'b': [4]}, 'Robots a and b cannot both end on vertex 4'),
], ids=lambda value: None)
def test_robots_and_missions_that_make_no_sense(tmp_path, capsys, robots, missions, sentence):
    files = Files(tmp_path, corridor(4), {name: ('agv', v) for name, v in robots.items()}, missions)
    assert sentence in _refused(files, capsys)


def test_starts_that_overlap_are_refused(tmp_path, capsys):
    files = Files(tmp_path, corridor(4, spacing=0.5), {'a': ('agv', 1), 'b': ('agv', 2)}, {})
    assert ('Robots a and b cannot both stand on vertices 1 and 2, too near each other'
            in _refused(files, capsys))


def test_a_destination_behind_a_one_way_edge_is_refused(tmp_path, capsys):
    graph = graph_of({1: (0, 0), 2: (3, 0), 3: (6, 0)}, {1: (2, 1), 2: (2, 3)}, one_way=(1,))
    files = Files(tmp_path, graph, {'a': ('agv', 1)}, {'a': [3]})
    assert ('Robot a: vertex 3 cannot be reached from vertex 1; no edges lead there that it may '
            'drive') in _refused(files, capsys)


def test_a_destination_behind_a_dock_is_refused_with_the_true_reason(tmp_path, capsys):
    """Edges lead to the destination, but only through a dock, and no route leads through a dock."""
    plain = corridor(4)
    graph = Graph([replace(vertex, dock=vertex.id in (3, 4))
                   for vertex in plain.vertices.values()], plain.edges.values())
    files = Files(tmp_path, graph, {'a': ('agv', 1)}, {'a': [4]})
    refused = _refused(files, capsys)
    assert ('Robot a: vertex 4 cannot be reached from vertex 1: each way leads through a dock, '
            'such as dock 3, and no route leads through a dock.') in refused
    assert 'let edges lead' not in refused


def test_more_robots_than_can_park_are_refused(tmp_path, capsys):
    """c must end between the places of a and b, where only one place is left."""
    graph = graph_of({1: (0, 0), 2: (0.5, 0), 3: (1, 0), 4: (3, 0)}, {k: (k, k + 1)
                                                                     for k in (1, 2, 3)})
    files = Files(tmp_path, graph, {'a': ('agv', 1), 'b': ('agv', 3), 'c': ('agv', 4)}, {'c': [2]})
    assert 'more robots than can park' in _refused(files, capsys)


@pytest.mark.parametrize('name, text, sentence', [
    ('graph', '[unclosed', 'graph.yaml'),
    ('graph', 'Vertices: [{Id: 1, X: .nan, Y: 0.0, Theta: 0.0, ThetaHolomonic: 0.0, Label: a, '
     'FrameId: map}]\nEdges: []', 'nan'),
    ('fleet', 'clearance: [', 'fleet.yaml, line'),
    ('fleet', 'clearance: .nan\nrobot_types: []\nrobots: []', 'clearance'),
    ('fleet', 'clearance: -1\nrobot_types: []\nrobots: []', 'clearance is -1'),
    ('fleet', 'clearance: 0\nrobot_types: []\nrobots: []', 'robot_types is empty'),
    ('fleet', 'clearance: 0\nrobot_types: [{name: t, radius: 0, speed: 1}]\nrobots: []',
     'radius is 0, but must be more'),
    ('fleet', 'clearance: 0\nrobot_types: [{name: t, radius: .inf, speed: 1}]\nrobots: []',
     'radius is inf'),
    ('fleet', 'clearance: 0\nrobot_types: [{name: t, radius: 1}]\nrobots: []', 'speed'),
    ('fleet', 'clearance: 0\nrobot_types: [{name: t, radius: 1, speed: 1}]\n'
     'robots: [{name: a, type: u, vertex: 1}]', "no robot type 'u'"),
    ('fleet', 'clearance: 0\nrobot_types: [{name: t, radius: 1, speed: 1}]\n'
     'robots: [{name: a, type: t, vertex: 1}, {name: a, type: t, vertex: 2}]', 'twice'),
    ('missions', 'missions: 5', 'missions'),
    ('missions', 'missions: [{robot: a, vertices: [1.5]}]', 'vertices'),
    ('missions', 'missions: [{robot: a, vertices: [2]}, {robot: a, vertices: [3]}]',
     'two missions'),
    ('missions', '', 'missions.yaml'),
])
def test_a_file_that_cannot_be_used_is_named_in_one_sentence(swap, capsys, name, text, sentence):
    swap.path(name).write_text(text)
    message = _refused(swap, capsys)
    assert sentence in message
    assert f'{name}.yaml' in message


@pytest.mark.parametrize('name', ['graph', 'fleet', 'missions'])
def test_a_file_that_is_missing_is_named(swap, capsys, name):
    swap.path(name).unlink()
    assert f'{name}.yaml' in _refused(swap, capsys)


@pytest.mark.parametrize('more, word', [
    (['--time-limit', 'nan'], 'nan'), (['--time-limit', '-1'], '-1'), (['--seed', 'x'], 'x'),
    (['--search', 'luck'], 'luck'), (['--unknown'], 'unknown')])
def test_wrong_options_are_status_1_and_one_sentence(swap, capsys, more, word):
    with pytest.raises(SystemExit) as ended:
        main(swap.arguments(*more))
    assert ended.value.code == 1
    message = capsys.readouterr().err
    assert message.count('\n') == 1
    assert word in message


def test_an_output_that_cannot_be_written_is_named(swap, capsys):
    assert main([*swap.arguments(), '--output', str(swap.folder / 'no' / 'plan.json')]) == 1
    message = capsys.readouterr().err
    assert message.startswith(str(swap.folder / 'no' / 'plan.json'))
    assert message.count('\n') == 1


def test_an_older_plan_stays_where_the_input_is_wrong(swap):
    swap.output.write_text('older')
    swap.path('missions').write_text('[')
    assert main(swap.arguments()) == 1
    assert swap.output.read_text() == 'older'
