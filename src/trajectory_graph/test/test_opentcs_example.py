"""The example that converts plant models of openTCS."""
from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from trajectory_graph import load_graph

ROOT = Path(__file__).parents[3]
MODEL = ROOT / 'examples/plant_model.xml'


def convert(model: Path, into: Path) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, str(ROOT / 'examples/graph_from_opentcs.py'),
                           str(model), '--into', str(into)], text=True, capture_output=True,
                          env={**os.environ}, timeout=60, check=False)


@pytest.fixture(scope='module', name='site')
def fixture_site(tmp_path_factory):
    into = tmp_path_factory.mktemp('opentcs') / 'site'
    done = convert(MODEL, into)
    assert done.returncode == 0, done.stderr
    return into, done.stdout


def test_points_become_vertices_at_the_same_place_in_metres(site):
    graph = load_graph(site[0] / 'graph.yaml')
    vertices = {vertex.label: vertex for vertex in graph.vertices.values()}
    assert vertices['Goods-out'].position == (18.0, -3.0)
    assert [name for name, vertex in vertices.items() if vertex.parking] == ['Park-1', 'Park-2']
    assert [name for name, vertex in vertices.items() if vertex.dock] == ['Charge']


def test_a_path_and_its_opposite_become_one_edge_also_along_a_curve(site):
    edges = list(load_graph(site[0] / 'graph.yaml').edges.values())
    assert len(edges) == 5 + 4
    assert {(edge.velocity_forward, edge.velocity_backwards) for edge in edges} == {(1.0, 1.0)}


def test_locations_become_stations_docks_and_devices(site):
    work = yaml.safe_load((site[0] / 'work.yaml').read_text())
    assert work['stations'] == [{'name': 'Incoming', 'places': [1]},
                                {'name': 'Outgoing', 'places': [4]}]
    assert [(device['name'], device['edges']) for device in work['devices']] == [('fire_door', [2])]


def test_vehicles_become_robots_at_park_positions(site):
    fleet = yaml.safe_load((site[0] / 'fleet.yaml').read_text())
    assert [(robot['name'], robot['vertex']) for robot in fleet['robots']] == [
        ('vehicle_01', 5), ('vehicle_02', 6)]
    assert fleet['robot_types'] == [{'name': 'agv_1', 'radius': 0.43, 'speed': 1.0, 'docks': [7]}]


def test_what_a_person_must_do_is_printed(site):
    assert 'to do: block Crossing block' in site[1]
    assert 'to do: device fire_door is simulated' in site[1]


def test_a_one_way_path_stays_one_way_and_a_charger_on_a_lane_is_told(tmp_path):
    text = MODEL.read_text()
    start = text.index('    <path name="Charge --- Goods-in"')
    end = text.index('</path>', start) + len('</path>\n')
    (tmp_path / 'model.xml').write_text(
        (text[:start] + text[end:]).replace('<link point="Charge"/>', '<link point="Crossing"/>'))
    done = convert(tmp_path / 'model.xml', tmp_path / 'site')
    edge = list(load_graph(tmp_path / 'site/graph.yaml').edges.values())[-1]
    assert (edge.velocity_forward, edge.velocity_backwards) == (1.0, 0.0)
    assert 'location Charger charges at vertex 2, but routes lead through it' in done.stdout


@pytest.mark.parametrize('text', ['no XML', '<model version="4.0.0"/>', '<other/>'])
def test_another_file_is_refused_in_a_sentence_and_nothing_is_written(tmp_path, text):
    (tmp_path / 'model.xml').write_text(text)
    done = convert(tmp_path / 'model.xml', tmp_path / 'site')
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1
    assert not (tmp_path / 'site').exists()


def test_a_folder_that_exists_is_left_alone(tmp_path):
    done = convert(MODEL, tmp_path)
    assert done.returncode == 1
    assert list(tmp_path.iterdir()) == []
