"""A new graph is refused if it lacks edges on which robots drive."""
from __future__ import annotations

from dataclasses import replace

import pytest
from fleet_builders import corridor

from fleet_core.site.changes import ReportedRoute, what_breaks
from trajectory_graph import Graph

OLD = corridor(4)
ROUTES = {'idle': ReportedRoute(), 'agv_1': ReportedRoute(left=(2, 3), edge=1)}


def changed(edges=(), vertices=(), without=()):
    """The corridor with some elements replaced or removed."""
    new_edges = {**OLD.edges, **{edge.id: edge for edge in edges}}
    new_vertices = {**OLD.vertices, **{vertex.id: vertex for vertex in vertices}}
    return Graph([v for v in new_vertices.values() if v.id not in without],
                 [e for e in new_edges.values()
                  if e.id not in without and not {e.origin, e.destination} & set(without)])


def moved(vertex, **by):
    return replace(OLD.vertices[vertex], **by)


def edge(id, **by):
    return replace(OLD.edges[id], **by)


@pytest.mark.parametrize('new', [
    OLD,
    changed(edges=[edge(1, velocity_backwards=0.0, velocity_forward=0.2)]),
    changed(edges=[edge(3, velocity_backwards=0.0)]),
    changed(vertices=[moved(1, label='a new name', parking=True)]),
], ids=['the same', 'another speed', 'one way, the other one', 'another name'])
def test_what_routes_do_not_need_may_change(new):
    assert what_breaks(OLD, new, ROUTES) is None


@pytest.mark.parametrize('new, words', [
    (changed(without=[4]), 'Edge 3 is missing, but robot agv_1 is to drive it'),
    (changed(vertices=[moved(4, x=7.0)]), 'Edge 3 runs elsewhere'),
    (changed(edges=[edge(2, origin=3, destination=2)]),
     'Edge 2 joins vertex 3 and vertex 2 and no longer vertex 2'),
    (changed(edges=[edge(3, velocity_forward=0.0)]), 'Edge 3 may not be driven forwards any more'),
    (changed(vertices=[moved(4, dock=True)]), 'Edge 3 ends at vertex 4, which is a dock now'),
    (changed(vertices=[moved(1, x=-1.0)]), 'Edge 1 runs elsewhere, but robot agv_1 is on it'),
])
def test_what_a_route_needs_may_not(new, words):
    assert words in what_breaks(OLD, new, ROUTES)


def test_without_robots_everything_may_change():
    assert what_breaks(OLD, changed(without=[4]), {'gone': ReportedRoute()}) is None


def test_an_edge_that_nobody_knew_breaks_nothing():
    assert what_breaks(OLD, OLD, {'agv_1': ReportedRoute((99,), 98)}) is None
