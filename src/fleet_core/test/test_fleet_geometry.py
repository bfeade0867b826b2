"""Conflict sets have every pair of places that are too near to each other, and no other pair."""
from __future__ import annotations

import math
from random import Random
from typing import NamedTuple

import numpy as np
import pytest
from fleet_builders import AGV, as_files, graph_of, random_graph
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from plan_checker import World
from shapely.geometry import Point

from fleet_core.geometry.capsules import time_within
from fleet_core.geometry.exclusions import Conflicts, OutOfTime
from fleet_core.geometry.pieces import TOLERANCE, edge_lengths, pieces_of, splines_of
from fleet_core.planning.road_network import RoadNetwork
from trajectory_graph import CurveType, Edge, Graph, GraphError, Vertex

number = st.floats(-3.0, 3.0)
point = st.tuples(number, number)


@given(point, point, point, point, st.floats(0.1, 2.0))
def test_a_point_is_in_a_capsule_exactly_between_entry_and_exit(start, end, first, last, distance):
    columns = [np.array(p, dtype=float).reshape(2, 1) for p in (start, end, first, last)]
    entry, exit = (float(t[0]) for t in time_within(*columns, np.array([distance])))
    t = np.linspace(0.0, 1.0, 101)
    record = np.array(start) + t[:, None] * (np.array(end) - start)
    axis = np.array(last) - first
    share = np.clip((record - first) @ axis / max(float(axis @ axis), 1e-300), 0.0, 1.0)
    gap = np.hypot(*(record - first - share[:, None] * axis).T)
    inside = (t >= entry) & (t <= exit)
    assert not (~inside & (gap < distance - 1e-7)).any()
    assert not (inside & (gap > distance + 1e-7)).any()


class Measured(NamedTuple):
    """A random graph with its conflict sets, and the checker's own shapes."""

    graph: Graph
    distance: float
    network: RoadNetwork
    conflicts: Conflicts
    world: World
    shapes: list  # shapes of the vertices, then of the edges


def _measured(seed) -> Measured:
    """Measures a random graph; skips the few random drawings that are no valid graph."""
    random = Random(seed)
    try:
        graph = random_graph(random, random.randint(3, 10), random.randint(0, 8), 2.0)
    except GraphError:
        reject()
    distance = random.uniform(0.2, 1.2)
    world, network = World(*as_files(graph, [], {}, {}, 0.0)), RoadNetwork(graph)
    return Measured(graph, distance, network, network.exclusions.at(distance), world,
                    [world.at(v) for v in graph.vertices] + [world.line(e) for e in graph.edges])


@given(st.integers(0, 2 ** 32 - 1))
@settings(max_examples=settings.default.max_examples * 2 // 5)
def test_pieces_follow_their_curves_as_nearly_as_they_say(seed):
    graph, _, _, _, world, _ = _measured(seed)
    splines = splines_of(graph)
    pieces = pieces_of(graph, splines)
    lengths = edge_lengths(graph, splines)
    for k, edge in enumerate(graph.edges):
        assert lengths[k] == pytest.approx(world.line(edge).length, rel=1e-4)
        own = pieces.place == len(graph.vertices) + k
        assert (pieces.margin[own] <= TOLERANCE * 1.01).all()
        for start, end, begins, ends, margin in zip(
                pieces.start.T[own], pieces.end.T[own], pieces.begins[own], pieces.ends[own],
                pieces.margin[own]):
            share = np.linspace(0.0, 1.0, 9)
            record = world.along(edge, begins + share * (ends - begins))
            off = np.hypot(*(record - start - share[:, None] * (end - start)).T)
            assert off.max() <= margin + 1e-3 * (1.0 + lengths[k]) * (ends - begins) + 1e-4


@given(st.integers(0, 2 ** 32 - 1))
@settings(max_examples=settings.default.max_examples // 4)
def test_places_exclude_each_other_exactly_where_they_are_too_near(seed):
    _, distance, _, conflicts, _, shapes = _measured(seed)
    for one, shape in enumerate(shapes):
        row = conflicts.row(one)
        assert one in row
        for other, other_shape in enumerate(shapes):
            gap = shape.distance(other_shape)
            if other in row:
                assert one in conflicts.row(other)
                assert one == other or gap < distance + 4.0 * TOLERANCE + 1e-3
            else:
                assert gap > distance - 1e-3


@given(st.integers(0, 2 ** 32 - 1))
@settings(max_examples=8)
def test_behind_the_clear_fraction_a_drive_is_out_of_the_way(seed):
    graph, distance, network, conflicts, world, shapes = _measured(seed)
    for k, edge in enumerate(graph.edges):
        place = network.vertices + k
        for n in range(conflicts.starts[place], conflicts.starts[place + 1]):
            for direction, clear in ((1, conflicts.forward[n]), (-1, conflicts.backward[n])):
                rest = world.along(direction * edge, np.linspace(clear, 1.0, 9)[1:])
                if clear < 1.0 - 1e-6:
                    other = shapes[conflicts.other[n]]
                    assert min(Point(*at).distance(other) for at in rest) > distance - 2e-3


def test_edges_that_cross_without_a_vertex_exclude_each_other():
    graph = graph_of({1: (0, 0), 2: (10, 0), 3: (5, -5), 4: (5, 5)},
                     {1: (1, 2), 2: (3, 4), 3: (2, 4)})
    conflicts = RoadNetwork(graph).exclusions.at(1.0)
    assert conflicts.row(4) == [0, 1, 4, 5, 6]
    at = conflicts.starts[4] + 3
    assert conflicts.forward[at] == pytest.approx(0.6)
    assert conflicts.backward[at] == pytest.approx(0.6)


@pytest.mark.parametrize('apart, excluded', [(0.99, True), (1.0, False), (1.01, False)])
def test_parallel_edges_exclude_each_other_only_if_they_are_nearer_than_asked(apart, excluded):
    graph = graph_of({1: (0, 0), 2: (5, 0), 3: (0, apart), 4: (5, apart)},
                     {1: (1, 2), 2: (3, 4), 3: (2, 4)})
    assert (5 in RoadNetwork(graph).exclusions.at(1.0).row(4)) is excluded


def test_a_dock_and_its_approach_are_for_one_robot_alone():
    graph = Graph([Vertex(1, 0.0, 0.0, 0.0, dock=True), Vertex(2, 1.5, 0.0, 0.0),
                   Vertex(3, 1.5, 4.0, 0.0), Vertex(4, 6.0, 0.0, 0.0)],
                  [Edge(1, 1, 2, CurveType.LINE), Edge(2, 2, 3, CurveType.LINE),
                   Edge(3, 2, 4, CurveType.LINE)])
    network = RoadNetwork(graph, dock_approach=2.0)
    conflicts = network.exclusions.at(0.1)
    approach, aside = network.vertices, network.vertices + 1
    assert aside in conflicts.row(approach)
    at = conflicts.starts[aside] + conflicts.row(aside).index(approach)
    assert conflicts.forward[at] == pytest.approx(0.5 / 4.0), 'the approach ends 0.5 m behind 2'
    assert 2 not in conflicts.row(0), 'a docked robot is in no other robot\'s way elsewhere'


@pytest.mark.parametrize('way', [(1, 9), (9, 1), (1, 2, 9), (9, 2, 1)])
def test_no_path_leads_over_a_vertex_that_the_graph_does_not_have_any_more(way):
    network = RoadNetwork(graph_of({1: (0, 0), 2: (5, 0)}, {1: (1, 2)}))
    assert network.seconds_over(AGV, (1, 2)) < math.inf
    assert network.seconds_over(AGV, way) == math.inf


def test_what_is_asked_twice_is_computed_once():
    exclusions = RoadNetwork(graph_of({1: (0, 0), 2: (5, 0)}, {1: (1, 2)})).exclusions
    assert exclusions.at(1.0) is exclusions.at(1.0)


def test_the_time_for_conflict_sets_is_limited():
    exclusions = RoadNetwork(graph_of({1: (0, 0), 2: (5, 0)}, {1: (1, 2)})).exclusions
    exclusions.deadline = -math.inf
    with pytest.raises(OutOfTime):
        exclusions.at(1.0)
