"""Graphs of the laboratory's bare map and of real robots' maps cover the reachable floor."""
from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

from graph_editor.checking.checker import Checker
from graph_editor.checking.findings import Severity
from graph_editor.checking.rules import CheckRules
from graph_editor.making.coverage import Coverage
from graph_editor.making.keeping_ids import with_ids_of
from graph_editor.making.maker import make_graph
from graph_editor.making.options import MakingOptions
from graph_editor.site import PlaceKind, SiteOptions, load_site
from trajectory_graph import load_graph
from trajectory_graph.editing import Draft
from trajectory_graph.yaml_file import dump_graph

MAPS = Path(__file__).resolve().parents[3] / 'maps'
REAL = Path(os.environ.get('LD90_REAL_MAPS') or '/nowhere')
OPTIONS = MakingOptions()


@pytest.fixture(scope='module', params=['lab_base.map', 'omron-ld-site-a.map',
                                        'omron-ld-site-b.map'])
def made(request):
    """Returns a site and the graph that is made from it."""
    path = (MAPS if request.param.startswith('lab') else REAL) / request.param
    if not path.exists():
        pytest.skip(f'{request.param} does not exist: set LD90_REAL_MAPS')
    return made_of(path)


@lru_cache(maxsize=None)
def made_of(path: Path):
    """Returns a site and the graph made from it; each graph is made once for all tests."""
    site = load_site(str(path), SiteOptions())
    return site, make_graph(site, OPTIONS).graph


def test_nothing_is_wrong_with_it(made):
    site, graph = made
    findings = Checker(CheckRules(), site).all(Draft.of(graph))
    assert [str(each) for each in findings if each.severity is Severity.ERROR] == []
    assert [str(each) for each in findings if 'farther than' in each.text] == []


def test_robots_have_room_to_pass_every_edge_and_to_turn_where_it_bends(made):
    site, graph = made
    findings = Checker(CheckRules(), site).all(Draft.of(graph))
    assert [str(each) for each in findings if 'must turn' in each.text] == []
    least = min(site.floor.clearance_at(graph.curve(id).sample(0.02)).min() for id in graph.edges)
    assert least > OPTIONS.robot_width / 2.0 + 0.015, (
        "the clearance of the robot's own planner must be kept")


def test_every_goal_and_dock_is_a_vertex(made):
    site, graph = made
    for place in site.places:
        if place.kind is not PlaceKind.HOME:
            vertex, = (each for each in graph.vertices.values() if each.label == place.name
                       or (place.kind is PlaceKind.DOCK and each.dock))
            assert vertex.position == pytest.approx(place.position, abs=1e-3)


def test_the_floor_that_a_robot_reaches_is_within_two_metres_of_an_edge(made):
    site, graph = made
    starts = [vertex.position for vertex in graph.vertices.values()]
    flooded = site.floor.reachable(OPTIONS.robot_width / 2.0, starts)
    coverage = Coverage(site.floor, flooded, 2.0)
    edges = np.vstack([graph.curve(id).sample(0.05) for id in graph.edges])
    assert (coverage.distances(edges)[coverage.mask] <= 2.0).mean() >= 0.95


def test_made_again_it_is_the_same(made):
    site, graph = made
    again = make_graph(site, OPTIONS).graph
    assert dump_graph(again) == dump_graph(graph)
    assert dump_graph(with_ids_of(graph, again)) == dump_graph(graph)


def test_it_is_not_much_longer_than_what_a_person_drew():
    graphs = made_of(MAPS / 'lab_base.map')[1], load_graph(MAPS / 'lab_graph.yaml')
    made, drawn = (sum(graph.curve(id).length for id in graph.edges) for graph in graphs)
    assert made <= 1.3 * drawn
