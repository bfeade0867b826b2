import math
import os
import random

import numpy as np
import pytest
from converter_builders import LAB, REAL_MAPS, graph_of
from fence_builders import NO_WALLS, fenced, grid, quarter_turn, real_site_graph, wall
from hypothesis import given, settings
from hypothesis import strategies as st

from omron_map import MapDocument
from omron_map_converter.converter import ConversionOptions, convert
from omron_map_converter.corridors import CorridorRules
from omron_map_converter.fence_check import check_fences
from omron_map_converter.fences import Fences
from trajectory_graph import CurveType, Edge, Graph, Vertex, load_graph

AISLE = graph_of([(1, 0.0, 0.0), (2, 6.0, 0.0)], [(1, 2)])
BOTH_KINDS = pytest.mark.parametrize('kind', [Fences.AREAS, Fences.LINES])


def assert_good(graph, corridors, fences, walls=NO_WALLS):
    check = check_fences(graph, corridors, fences, walls)
    assert check.leaks == ()
    assert check.lost_area == 0.0


def total_length(fences):
    return sum(max(fence.rectangle.width, fence.rectangle.height) for fence in fences)


@BOTH_KINDS
def test_a_lone_corridor_is_closed_all_around(kind):
    corridors, fences = fenced(AISLE, kind=kind)
    assert_good(AISLE, corridors, fences)
    assert len(fences) <= 6


def test_a_block_between_corridors_is_one_rectangle():
    graph = grid(2, 2, pitch=3.0)
    corridors, fences = fenced(graph)
    inside = [fence.rectangle for fence in fences
              if 0 < fence.rectangle.centre_x < 3000 and 0 < fence.rectangle.centre_y < 3000]
    assert_good(graph, corridors, fences)
    assert len(inside) == 1
    assert inside[0].width == pytest.approx(3000 - 900, abs=60)
    assert inside[0].height == pytest.approx(3000 - 900, abs=60)


def test_a_block_that_is_turned_is_one_rectangle_as_well():
    graph = grid(2, 2, pitch=3.0, degrees=33.0)
    corridors, fences = fenced(graph)
    blocks = [fence.rectangle for fence in fences if min(fence.rectangle.width,
                                                         fence.rectangle.height) > 2000]
    assert_good(graph, corridors, fences)
    assert [round(block.yaw, 3) for block in blocks] == [33.0]


@pytest.mark.parametrize('degrees', [0.0, 17.0])
@BOTH_KINDS
def test_a_grid_of_100_edges(degrees, kind):
    graph = grid(8, 7, degrees=degrees)
    corridors, fences = fenced(graph, kind=kind)
    assert_good(graph, corridors, fences)
    assert len(fences) <= len(graph.edges) * (1.0 if kind is Fences.AREAS else 3.0)


def test_a_corridor_between_walls_needs_fences_at_its_ends_only():
    walls = np.concatenate((wall(-3000, 540, 9000, 540), wall(-3000, -540, 9000, -540)))
    corridors, fences = fenced(AISLE, walls)
    assert_good(AISLE, corridors, fences, walls)
    assert len(fences) == 2
    assert all(abs(fence.rectangle.centre_x - 3000) > 3400 for fence in fences)


def test_a_gap_in_a_wall_is_fenced_where_a_robot_fits_through():
    def aisle_with_gap(width):
        return np.concatenate([wall(-3000, 500, 3000 - width / 2, 500),
                               wall(3000 + width / 2, 500, 9000, 500),
                               wall(-3000, -500, 9000, -500),
                               wall(-600, -600, -600, 600), wall(6600, -600, 6600, 600)])
    corridors, narrow = fenced(AISLE, aisle_with_gap(400))
    assert narrow == []
    assert_good(AISLE, corridors, narrow, aisle_with_gap(400))
    corridors, wide = fenced(AISLE, aisle_with_gap(1400))
    assert len(wide) == 1
    assert_good(AISLE, corridors, wide, aisle_with_gap(1400))


@BOTH_KINDS
@pytest.mark.parametrize('degrees', [10, 25, 45, 90, 150])
def test_the_wedge_between_two_edges_is_closed(degrees, kind):
    turn = math.radians(degrees)
    graph = graph_of([(1, 0.0, 0.0), (2, 8.0, 0.0), (3, 8 * math.cos(turn), 8 * math.sin(turn))],
                     [(1, 2), (1, 3)])
    corridors, fences = fenced(graph, kind=kind)
    assert_good(graph, corridors, fences)


@BOTH_KINDS
@pytest.mark.parametrize('reach', [0.4, 1.0, 2.0, 4.0])
def test_splines_are_closed(reach, kind):
    graph = Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 4.0, 4.0, math.pi / 2)],
                  [Edge(1, 1, 2, CurveType.SPLINE, reach, reach)])
    corridors, fences = fenced(graph, kind=kind)
    assert_good(graph, corridors, fences)
    assert len(fences) <= 14


@BOTH_KINDS
@pytest.mark.parametrize('width', [600.0, 900.0])
def test_a_bend_in_a_curve_is_closed_around_its_disc(width, kind):
    graph = quarter_turn(0.3)
    corridors, fences = fenced(graph, kind=kind, rules=CorridorRules(width=width))
    assert_good(graph, corridors, fences)


def tangle(seed: int) -> Graph:
    """Returns a random graph: edges cross, run side by side, and turn sharply."""
    dice = random.Random(seed)
    places = {(dice.randrange(120), dice.randrange(120)) for _ in range(dice.randint(3, 9))}
    vertices = [Vertex(id, x / 10, y / 10, math.radians(dice.randrange(0, 360, 15)))
                for id, (x, y) in enumerate(sorted(places), 1)]
    return Graph(vertices, [
        Edge(vertex.id, dice.randint(1, vertex.id), vertex.id + 1, dice.choice(list(CurveType)),
             dice.uniform(0.2, 3.0), dice.uniform(0.2, 3.0)) for vertex in vertices[:-1]])


@BOTH_KINDS
@settings(max_examples=500 if os.environ.get('LD90_LONG_TESTS')
          else settings.default.max_examples * 3 // 20)
@given(seed=st.integers(0, 10 ** 6))
def test_whatever_the_graph_nothing_leaks_and_no_corridor_is_touched(kind, seed):
    graph = tangle(seed)
    corridors, fences = fenced(graph, kind=kind)
    assert_good(graph, corridors, fences)


def test_a_fence_is_not_overlooked_where_geos_leaves_a_part_out_of_a_buffer():
    graph = tangle(967825)
    corridors, fences = fenced(graph, kind=Fences.AREAS)
    assert_good(graph, corridors, fences)


def test_the_laboratory_has_few_fences_and_they_are_good():
    graph = load_graph(str(LAB / 'lab_graph.yaml'))
    conversion = convert(graph, MapDocument.load(str(LAB / 'lab_base.map')),
                         ConversionOptions(dock_vertex=16))
    assert conversion.notes == ()
    assert len(conversion.fences) <= 2.5 * len(graph.edges)


@pytest.mark.skipif(not (REAL_MAPS / 'omron-ld-site-a.map').exists(),
                    reason=f'no real maps in {REAL_MAPS}')
def test_on_a_real_map_most_walls_are_fence_enough():
    graph = real_site_graph()
    document = MapDocument.load(str(REAL_MAPS / 'omron-ld-site-a.map'))
    conversion = convert(graph, document, ConversionOptions())
    assert len(conversion.fences) <= 2.0 * len(graph.edges)
    assert conversion.notes == (
        "GoalWithHeading 'Goal1' is outside the corridors: the robot cannot drive to it any more.",)
    _, in_the_open = fenced(graph)
    assert total_length(conversion.fences) < 0.7 * total_length(in_the_open)


@BOTH_KINDS
def test_a_long_corridor_with_many_branches(kind):
    """The only outer region has a long outline, so only near points are examined."""
    spine = [(id, 3.0 * id, 0.0) for id in range(1, 21)]
    branches = [(20 + id, 3.0 * id, 2.5 if id % 2 else -2.5) for id in range(1, 21)]
    graph = graph_of(spine + branches, [(id, id + 1) for id in range(1, 20)]
                     + [(id, 20 + id) for id in range(1, 21)])
    corridors, fences = fenced(graph, kind=kind)
    assert_good(graph, corridors, fences)
    assert len(fences) <= 3.0 * len(graph.edges)
