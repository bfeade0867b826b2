"""Shortest paths with the graph reduced to its crossings: the same as with the whole graph."""
from __future__ import annotations

from math import inf
from random import Random

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet_core.planning.shortest_paths import ShortestPaths


def _expected(vertices, roads, target):
    graph = nx.MultiDiGraph()
    graph.add_nodes_from(range(vertices))
    graph.add_weighted_edges_from((end, begin, seconds) for begin, end, seconds in roads)
    seconds = nx.single_source_dijkstra_path_length(graph, target)
    return [seconds.get(vertex, inf) for vertex in range(vertices)]


@given(st.integers(0, 2 ** 32 - 1))
def test_all_ways_to_all_vertices_are_the_shortest(seed):
    """Trees with links across, some of them one-way or double, and unconnected parts."""
    random = Random(seed)
    vertices = random.randint(1, 25)
    ends = [(random.randrange(max(k - 3, 0), k), k) for k in range(1, vertices)
            if random.random() < 0.95]
    ends += [(random.randrange(vertices), random.randrange(vertices))
             for _ in range(random.randint(0, 8))]
    roads = [(*ends_of_road, random.uniform(0.1, 5.0)) for end in ends
             for ends_of_road in (end, end[::-1]) if random.random() < 0.9]
    paths = ShortestPaths(vertices, roads)
    targets = random.sample(range(vertices), random.randint(1, vertices))
    for target, row in zip(targets, paths.to(targets)):
        assert row.tolist() == pytest.approx(_expected(vertices, roads, target)), target
    nearest = paths.to(targets).min(axis=0)
    assert paths.to_nearest(targets).tolist() == pytest.approx(nearest.tolist())


def test_a_lane_of_many_sections_is_one_link():
    """Two crossings of four lanes, joined by a long lane."""
    lane = [(k, k + 1, 2.0) for k in range(100)]
    around = [(a, b, 1.0) for first, hub in ((101, 0), (104, 100))
              for a, b in ((hub, first), (hub, first + 1), (hub, first + 2),
                           (first, first + 1), (first + 1, first + 2), (first + 2, first))]
    both = [road for a, b, s in lane + around for road in ((a, b, s), (b, a, s))]
    paths = ShortestPaths(107, both)
    assert paths.left <= 8, 'only vertices of the crossings may remain'
    assert paths.to([50])[0][:101].tolist() == [2.0 * abs(50 - k) for k in range(101)]
