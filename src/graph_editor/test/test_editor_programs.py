"""make_graph and check_graph: their output, their files and their exit statuses."""
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from floor_plans import Plan
from PIL import Image

from graph_editor import check_cli, graph_values, make_cli
from trajectory_graph import load_graph

PLAN = Plan(8.0, 6.0, ((3.9, 0.0, 4.0, 4.0),), (1.0, 1.0))
YAML = """\
image: hall.pgm
resolution: 0.05
origin: [-0.1, -0.1, 0.0]
occupied_thresh: 0.65
free_thresh: 0.196
"""


@pytest.fixture
def hall(tmp_path) -> str:
    """Returns the file of a ROS map of two rooms, with a wide gap between them."""
    occupied = PLAN.site().floor.occupied
    Image.fromarray(np.where(occupied, 0, 254).astype(np.uint8)[::-1]).save(tmp_path / 'hall.pgm')
    (tmp_path / 'hall.yaml').write_text(YAML)
    return str(tmp_path / 'hall.yaml')


def make(*arguments: object) -> int:
    return make_cli.main([str(argument) for argument in arguments])


def test_a_graph_is_made_checked_and_drawn(hall, tmp_path, capsys):
    graph, picture = tmp_path / 'graph.yaml', tmp_path / 'graph.png'
    assert make('--map', hall, '--output', graph, '--draw', picture) == 0
    assert f'{graph}: {len(load_graph(graph).vertices)} vertices' in capsys.readouterr().out
    with Image.open(picture) as image:
        assert len(image.convert('RGB').getcolors(10 ** 6)) > 10
    assert check_cli.main(['--graph', str(graph), '--map', hall, '--strict']) == 0
    printed = capsys.readouterr()
    assert printed.out == '' and '0 errors, 0 warnings' in printed.err


def test_goals_and_docks_of_the_command_line_become_vertices(hall, tmp_path):
    graph = tmp_path / 'graph.yaml'
    assert make('--map', hall, '--output', graph, '--dock=7.2,1.0,-90',
                '--goal=press 4,1.0,5.0,90', '--goal', 'store,2.0,2.0,') == 0
    labels = {vertex.label: vertex for vertex in load_graph(graph).vertices.values()}
    assert labels['dock'].dock and labels['dock'].position == pytest.approx((7.2, 1.0), abs=1e-3)
    assert {'press 4', 'store'} <= set(labels)
    assert labels['press 4'].position == pytest.approx((1.0, 5.0), abs=1e-3)


def test_a_graph_edited_by_hand_is_kept(hall, tmp_path, capsys):
    graph = tmp_path / 'graph.yaml'
    make('--map', hall, '--output', graph)
    assert graph_values.main(['unedited', str(graph)]) == 0
    graph.write_text(graph.read_text() + '# mine\n')
    assert graph_values.main(['unedited', str(graph)]) == 1
    assert make('--map', hall, '--output', graph) == 1
    assert 'not overwritten' in capsys.readouterr().err
    assert graph.read_text().endswith('# mine\n')
    assert make('--map', hall, '--output', graph, '--force') == 0


def test_ids_are_kept_when_asked_for(hall, tmp_path):
    old, new = tmp_path / 'old.yaml', tmp_path / 'new.yaml'
    make('--map', hall, '--output', old)
    text = old.read_text()
    old.write_text(text.replace('Id: 1,', 'Id: 701,').replace('_ID: 1,', '_ID: 701,'))
    assert make('--map', hall, '--output', new, '--keep-ids', old) == 0
    assert 701 in load_graph(new).vertices and 1 not in load_graph(new).vertices


def test_findings_are_one_line_each_and_errors_make_the_status(hall, tmp_path, capsys):
    graph = tmp_path / 'graph.yaml'
    make('--map', hall, '--output', graph)
    text = graph.read_text()
    wall = min(load_graph(graph).vertices.values(), key=lambda vertex: vertex.y)
    graph.write_text(text.replace(f'Y: {wall.y}', 'Y: -0.05'))
    capsys.readouterr()
    assert check_cli.main(['--graph', str(graph), '--map', hall]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith('error: edge ') and 'in a wall' in line for line in lines)
    assert all(line.startswith(('error: ', 'warning: ')) for line in lines)


def test_values_for_scripts(hall, tmp_path, capsys):
    graph = tmp_path / 'graph.yaml'
    make('--map', hall, '--output', graph, '--dock=7.2,1.0,-90')
    capsys.readouterr()
    assert graph_values.main(['dock', str(graph)]) == 0
    assert load_graph(graph).vertices[int(capsys.readouterr().out)].dock
    assert graph_values.main(['dock', str(tmp_path / 'no.yaml')]) == 1
    assert 'no.yaml' in capsys.readouterr().err


@pytest.mark.parametrize('arguments, words', [
    (['--area', '1,2,3'], '--area'), (['--area=20,20,30,30'], 'no floor'),
    (['--area=nan,0,1,1'], 'two corners'), (['--resolution', '0'], '--resolution'),
    (['--robot-width', '-1'], 'robot_width'), (['--robot-width', '9'], 'corridor'),
    (['--corridor', 'nan'], 'corridor'), (['--outline-gap', '-3'], '--outline-gap'),
    (['--dock', '1,2'], '--dock 1,2'), (['--goal', 'x'], 'a name, x and y'),
    (['--dock=nan,1,0'], 'in m'), (['--keep-ids', 'missing.yaml'], 'missing.yaml'),
    (['--draw', '/no/folder/x.png'], '/no/folder/x.png')])
def test_what_cannot_be_done_is_one_sentence(hall, tmp_path, capsys, arguments, words):
    status = make('--map', hall, '--output', tmp_path / 'graph.yaml', *arguments)
    told = capsys.readouterr().err.splitlines()
    assert status == 1
    assert len(told) == 1 and told[0].startswith('error: ') and words in told[0]


def test_a_goal_that_is_nowhere_is_told_and_is_no_vertex(hall, tmp_path, capsys):
    graph = tmp_path / 'graph.yaml'
    assert make('--map', hall, '--output', graph, '--goal', 'far,300,300,') == 0
    assert 'warning: far is at a position at which a robot' in capsys.readouterr().err
    assert 'far' not in {vertex.label for vertex in load_graph(graph).vertices.values()}


@pytest.mark.parametrize('content', [b'', b'\xff\xfe\x00 no map', b'2D-Map\n', b'{' * 99])
@pytest.mark.parametrize('name', ['wrong.map', 'wrong.yaml'])
def test_a_map_that_is_none_is_one_sentence(tmp_path, capsys, name, content):
    wrong = tmp_path / name
    wrong.write_bytes(content)
    assert make('--map', wrong, '--output', tmp_path / 'graph.yaml') == 1
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 1 and str(wrong) in told[0]
    assert not Path(tmp_path / 'graph.yaml').exists()
