import math

import pytest
from converter_builders import graph_of
from fence_builders import quarter_turn
from shapely.geometry import Point

from omron_map_converter.corridors import CorridorRules, corridors_of
from omron_map_converter.goals import MapPose
from trajectory_graph import CurveType, Edge, Graph, Vertex

RULES = CorridorRules()
STRAIGHT = graph_of([(1, 0.0, 0.0), (2, 4.0, 0.0)], [(1, 2)])


def is_free(corridors, x, y):
    return corridors.floor.contains(Point(x, y))


def test_half_a_corridor_is_free_on_either_side_of_an_edge():
    corridors = corridors_of(STRAIGHT, RULES)
    assert is_free(corridors, 2000, 450)
    assert is_free(corridors, 2000, -450)
    assert not is_free(corridors, 2000, 456)


def test_an_edge_may_have_a_width_of_its_own():
    wide = corridors_of(STRAIGHT, CorridorRules(edge_widths={1: 1400.0}))
    assert is_free(wide, 2000, 699)
    assert not is_free(wide, 2000, 706)


def test_the_robot_can_turn_at_an_end_vertex():
    corridors = corridors_of(STRAIGHT, RULES)
    for degrees in range(0, 360, 5):
        turn = math.radians(degrees)
        assert is_free(corridors, 479 * math.cos(turn), 479 * math.sin(turn)), degrees


@pytest.mark.parametrize('degrees, turns', [(30, False), (44, False), (46, True), (90, True)])
def test_the_robot_can_turn_where_edges_bend_by_more_than_45_degrees(degrees, turns):
    bend = math.radians(degrees)
    graph = graph_of([(1, -4.0, 0.0), (2, 0.0, 0.0), (3, 4 * math.cos(bend), 4 * math.sin(bend))],
                     [(1, 2), (2, 3)])
    behind = math.radians(degrees / 2 - 90)  # the outer side of the bend
    assert is_free(corridors_of(graph, RULES), 475 * math.cos(behind),
                   475 * math.sin(behind)) == turns


@pytest.mark.parametrize('degrees, turns', [(0, False), (4, False), (12, True), (44, True)])
def test_the_robot_can_turn_where_a_corridor_too_narrow_for_that_bends_at_all(degrees, turns):
    bend = math.radians(degrees)
    graph = graph_of([(1, -4.0, 0.0), (2, 0.0, 0.0), (3, 4 * math.cos(bend), 4 * math.sin(bend))],
                     [(1, 2), (2, 3)])
    behind = math.radians(degrees / 2 - 90)
    narrow = corridors_of(graph, CorridorRules(edge_widths={2: 700.0}, width=800.0))
    assert is_free(narrow, 475 * math.cos(behind), 475 * math.sin(behind)) == turns


@pytest.mark.parametrize('radius, turns', [(0.3, True), (0.5, True), (0.6, False), (1.5, False)])
def test_the_robot_can_turn_where_a_curve_bends_by_45_degrees_within_its_half_diagonal(
        radius, turns):
    graph = quarter_turn(radius)
    narrow = corridors_of(graph, CorridorRules(width=700.0))
    x, y = (1000 * value for value in graph.curve(1).point_at(graph.curve(1).length / 2))
    outwards = 475 * math.sqrt(0.5)
    assert is_free(narrow, x + outwards, y - outwards) == turns
    assert not is_free(narrow, -1500, -360)


def test_a_strip_as_wide_as_a_corridor_leads_to_the_station():
    corridors = corridors_of(STRAIGHT, RULES, dock=MapPose(0, 0, 180.0))
    assert is_free(corridors, -1499, 0)
    assert is_free(corridors, -1499, 449)
    assert not is_free(corridors, -1501, 0)
    assert not is_free(corridors, -1000, 456)


def test_junctions_are_open():
    cross = graph_of([(1, 0.0, 0.0), (2, 4.0, 0.0), (3, 0.0, 4.0), (4, -4.0, 0.0), (5, 0.0, -4.0)],
                     [(1, 2), (1, 3), (4, 1), (5, 1)])
    floor = corridors_of(cross, RULES).floor
    assert floor.geom_type == 'Polygon'
    assert list(floor.interiors) == []


def test_the_corridor_of_a_spline_follows_its_curve():
    graph = Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 3.0, 3.0, math.pi / 2)],
                  [Edge(1, 1, 2, CurveType.SPLINE, 1.6, 1.6)])
    floor = corridors_of(graph, RULES).floor
    curve = graph.curve(1)
    for s in (0.5, 2.0, 3.5):
        x, y = (1000 * value for value in curve.point_at(s))
        left = curve.heading_at(s) + math.pi / 2
        for side in (-449, 449):
            assert floor.contains(Point(x + side * math.cos(left), y + side * math.sin(left)))
        assert not floor.contains(Point(x + 460 * math.cos(left), y + 460 * math.sin(left)))
