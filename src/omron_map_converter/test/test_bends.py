"""Bends: turns that add up along a path within a short stretch of it."""
import gc
import math
import weakref

import numpy as np
import pytest
from converter_builders import graph_of
from fence_builders import grid, quarter_turn
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

from omron_map_converter.bends import bends_of
from omron_map_converter.corridors import CorridorRules, corridors_of
from trajectory_graph import CurveType, Edge, Graph, Vertex

STRETCH = 0.43
LENGTH, WIDTH = 699.0, 500.0  # of the robot, mm


def arc(radius, degrees):
    """Describes a Bezier curve: an arc to the left from 0, 0. Returns x and y of its end, its end
    heading, and its control length.
    """
    turn = math.radians(degrees)
    return (radius * math.sin(turn), radius * (1.0 - math.cos(turn)), turn,
            radius * 4.0 / 3.0 * math.tan(turn / 4.0))


def corner_and_arc(corner, radius, degrees):
    """Returns a graph. Its straight edge 1 and its edge 2, an arc, meet in a corner at 0, 0. Edge 3
    follows edge 2.
    """
    x, y, turn, reach = arc(radius, degrees)
    back = math.radians(180.0 - corner)
    ahead = (x + 3.0 * math.cos(turn), y + 3.0 * math.sin(turn))
    return Graph([Vertex(1, 3.0 * math.cos(back), 3.0 * math.sin(back), 0.0),
                  Vertex(2, 0.0, 0.0, 0.0), Vertex(3, x, y, turn), Vertex(4, *ahead, turn)],
                 [Edge(1, 1, 2), Edge(2, 2, 3, CurveType.SPLINE, reach, reach), Edge(3, 3, 4)])


@pytest.mark.parametrize('corner, radius, bends', [
    (0, 1.0, False), (15, 1.0, False), (30, 1.0, True), (30, 3.0, False), (43, 20.0, False),
])
def test_a_corner_and_the_curve_that_follows_add_up(corner, radius, bends):
    found = bends_of(corner_and_arc(corner, radius, 60), STRETCH)
    assert bool(found) == bends
    assert all(math.hypot(x, y) <= STRETCH for x, y in found)


def test_a_curve_in_two_edges_bends_as_it_does_in_one():
    x, y, turn, reach = arc(0.45, 45)
    whole = quarter_turn(0.45)
    halves = Graph(
        [Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 0.45, 0.45, math.pi / 2), Vertex(5, x, y, turn),
         Vertex(3, -4.0, 0.0, 0.0), Vertex(4, 0.45, 4.45, math.pi / 2)],
        [Edge(1, 1, 5, CurveType.SPLINE, reach, reach),
         Edge(4, 5, 2, CurveType.SPLINE, reach, reach), Edge(2, 3, 1), Edge(3, 2, 4)])
    expected, found = np.array(bends_of(whole, STRETCH)), np.array(bends_of(halves, STRETCH))
    assert len(expected) > 5
    for places, others in ((expected, found), (found, expected)):
        nearest = np.linalg.norm(places[:, None] - others, axis=2).min(axis=1)
        assert nearest.max() < 0.03


@pytest.mark.parametrize('between, bends', [(0.3, True), (0.5, False)])
@pytest.mark.parametrize('second', [60.0, 0.0])
def test_two_corners_add_up_to_either_side_when_they_are_near(between, bends, second):
    first, last = math.radians(30.0), math.radians(second)
    x, y = between * math.cos(first), between * math.sin(first)
    graph = graph_of([(1, -3.0, 0.0), (2, 0.0, 0.0), (3, x, y),
                      (4, x + 3.0 * math.cos(last), y + 3.0 * math.sin(last))],
                     [(1, 2), (2, 3), (3, 4)])
    assert bool(bends_of(graph, STRETCH)) == bends


def test_a_corner_that_is_a_bend_by_itself_is_one_place():
    graph = grid(3, 3)
    assert sorted(bends_of(graph, STRETCH)) == sorted(
        vertex.position for vertex in graph.vertices.values())


def test_a_thicket_of_tiny_edges_is_looked_at_in_time():
    """This graph has too many paths to search them one by one."""
    rungs = 40
    vertices = [(2 * i + j + 1, 0.003 * i, 0.001 * j) for i in range(rungs) for j in range(2)]
    ends = [(2 * i + a + 1, 2 * i + b + 3) for i in range(rungs - 1)
            for a in range(2) for b in range(2)]
    assert bends_of(graph_of(vertices, ends), STRETCH)


@settings(max_examples=settings.default.max_examples * 3 // 5)
@given(st.floats(30.0, 44.0), st.floats(0.3, 0.8), st.floats(20.0, 90.0))
def test_a_robot_that_turns_on_a_corner_and_a_curve_keeps_its_body_on_the_floor(
        corner, radius, degrees):
    graph = corner_and_arc(corner, radius, degrees)
    narrow = corridors_of(graph, CorridorRules(width=800.0, turning_radius=430.0)).floor
    for x, y, heading in poses(graph, (1, 2, 3)):
        assert narrow.buffer(1.0).contains(body(x, y, heading)), (x, y, math.degrees(heading))


def poses(graph, route):
    """Yields x, y (mm) and heading (rad) of a robot that drives a route and turns on its vertices.
    """
    before = None
    for edge in route:
        curve = graph.curve(edge)
        start = curve.heading_at(0.0)
        if before is not None:
            turn = math.remainder(start - before, 2.0 * math.pi)
            for part in np.linspace(0.0, 1.0, 10):
                yield (*np.multiply(curve.point_at(0.0), 1000.0), before + part * turn)
        for s in np.arange(0.0, curve.length, 0.03):
            yield (*np.multiply(curve.point_at(s), 1000.0), curve.heading_at(s))
        before = curve.heading_at(curve.length)


def body(x, y, heading):
    """Returns the robot's outline."""
    c, s = math.cos(heading), math.sin(heading)
    return Polygon([(x + c * u - s * v, y + s * u + c * v) for u, v in (
        (LENGTH / 2, WIDTH / 2), (-LENGTH / 2, WIDTH / 2), (-LENGTH / 2, -WIDTH / 2),
        (LENGTH / 2, -WIDTH / 2))])


def test_a_graph_is_not_kept_when_its_bends_are_known():
    graph = corner_and_arc(30, 1.0, 60)
    bends_of(graph, STRETCH)
    gone = weakref.ref(graph)
    del graph
    gc.collect()
    assert gone() is None
