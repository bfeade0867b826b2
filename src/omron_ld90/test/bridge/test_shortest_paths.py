"""The check of whether the robot's own path is the route."""
from __future__ import annotations

import itertools
import math

import pytest
from bridge_builders import dissertation_graph, graph_of, yard
from hypothesis import given
from hypothesis import strategies as st

from omron_ld90.bridge.shortest_paths import corner_cut, follows_on, has_detour
from trajectory_graph import CurveType, Edge, Graph, Vertex

MARGIN = 0.9


def is_the_free_way(graph, edges, arc, corridor_width, tolerance):
    """Returns whether the robot's own path follows all edges."""
    return all(follows_on(graph, edges[:count], arc, corridor_width, tolerance)
               for count in range(1, len(edges) + 1))


def is_the_only_short_way(graph, edges, arc, margin=MARGIN):
    """Returns whether the edges are the robot's only short path; corners are ignored."""
    return is_the_free_way(graph, edges, arc, margin, tolerance=math.inf)


def test_the_only_way_is_the_only_short_way():
    assert is_the_only_short_way(dissertation_graph(), (1, 4, 5), 0.0)


def test_two_ways_of_one_length_leave_it_open():
    assert not is_the_only_short_way(yard(), (1, 2), 0.0, MARGIN)  # a path via 4 is as short


def test_having_begun_on_one_of_them_decides():
    assert not is_the_only_short_way(yard(), (1, 2), 0.4)
    assert is_the_only_short_way(yard(), (1, 2), 0.5)


def test_a_way_round_is_not_the_free_way():
    assert not is_the_only_short_way(yard(), (1, 2, 3), 0.0)


def test_no_free_way_comes_back():
    assert not is_the_only_short_way(yard(), (1, -1), 3.9)


def test_two_edges_between_the_same_vertices_leave_it_open():
    graph = graph_of({1: (0, 0), 2: (4, 0), 3: (2, 0.5)}, {1: (1, 2), 2: (1, 3), 3: (3, 2)})
    assert not is_the_only_short_way(graph, (1,), 0.0)
    assert is_the_only_short_way(graph, (1,), 2.0)


def test_a_right_angle_is_cut_by_the_diagonal_of_the_slack():
    assert corner_cut(yard(), 1, 2, 0.25) == pytest.approx(0.25 * math.sqrt(2.0), abs=0.03)
    assert not is_the_free_way(yard(), (1, 2), 3.0, 0.9, 0.3)
    assert is_the_free_way(yard(), (1, 2), 3.0, 0.9, 0.4)


def test_going_straight_on_passes_the_vertex():
    assert corner_cut(yard(), 1, 5, 0.2) == pytest.approx(0.2)


def test_at_a_cusp_the_free_way_leaves_the_vertex_out():
    """Two splines leave vertex 1 side by side and separate slowly."""
    graph = Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 4.0, 1.0, 0.5), Vertex(3, 4.0, -1.0, -0.5)],
                  [Edge(1, 1, 2, CurveType.SPLINE, 1.5, 1.5),
                   Edge(2, 1, 3, CurveType.SPLINE, 1.5, 1.5)])
    assert corner_cut(graph, -1, 2, 0.2) > 1.0
    assert not has_detour(graph, (-1, 2), 0.0, 0.9)
    assert not is_the_free_way(graph, (-1, 2), 0.0, 0.9, 0.3)


@st.composite
def grids(draw):
    """Returns a grid of 3 x 3 vertices with unequal columns and rows, and a simple route on it."""
    xs = list(itertools.accumulate(draw(st.lists(st.floats(1.0, 6.0), min_size=3, max_size=3))))
    ys = list(itertools.accumulate(draw(st.lists(st.floats(1.0, 6.0), min_size=3, max_size=3))))
    places = {3 * row + column + 1: (xs[column], ys[row])
              for row in range(3) for column in range(3)}
    pairs = [(v, v + 1) for v in places if v % 3] + [(v, v + 3) for v in places if v <= 6]
    graph = graph_of(places, dict(enumerate(pairs, 1)))
    at, route, seen = 1, [], {1}
    for _ in range(draw(st.integers(1, 5))):
        ahead = [edge for edge in graph.edges_from(at) if graph.end_vertex(edge).id not in seen]
        if not ahead:
            break
        route.append(draw(st.sampled_from(ahead)))
        at = graph.end_vertex(route[-1]).id
        seen.add(at)
    return graph, tuple(route)


def simple_ways(graph: Graph, start: int, end: int) -> dict:
    """Returns {edges of a simple path: its length}, for all paths. The search is slow but exact."""
    ways, stack = {}, [(start, (), 0.0, {start})]
    while stack:
        at, edges, length, seen = stack.pop()
        if at == end:
            ways[edges] = length
            continue
        for edge in graph.edges_from(at):
            other = graph.end_vertex(edge).id
            if other not in seen:
                stack.append((other, (*edges, edge), length + graph.curve(edge).length,
                              seen | {other}))
    return ways


@given(grids())
def test_what_is_called_the_free_way_is_shorter_than_every_other_by_the_margin(case):
    graph, route = case
    ways = simple_ways(graph, 1, graph.end_vertex(route[-1]).id)
    own = ways.pop(route)
    others = min(ways.values(), default=float('inf'))
    if is_the_only_short_way(graph, route, 0.0):
        assert own + MARGIN < others + 1e-9
    elif len(route) == 1:
        assert others <= own + MARGIN + 1e-9
