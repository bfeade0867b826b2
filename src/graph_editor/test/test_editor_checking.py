"""Each kind of error in a graph is found at its place, and no other error is reported."""
from __future__ import annotations

import math
from dataclasses import replace

import pytest
from floor_plans import Plan, two_rooms
from hypothesis import given, settings
from hypothesis import strategies as st

from graph_editor.checking.checker import Checker, narrow_edges
from graph_editor.checking.findings import Finding, Severity
from graph_editor.checking.rules import CheckRules
from graph_editor.errors import SiteError
from graph_editor.making.maker import make_graph
from graph_editor.making.options import MakingOptions
from graph_editor.site import NamedPlace, PlaceKind
from trajectory_graph import CurveType, Edge, Graph, Vertex, editing
from trajectory_graph.editing import Draft

HALL = Plan(12.0, 8.0, ((5.0, 3.0, 7.0, 5.0),), (1.0, 1.0))
"""A hall with a block of 2 x 2 m in its middle."""
RING = {1: (2.0, 1.5), 2: (10.0, 1.5), 3: (10.0, 6.5), 4: (2.0, 6.5)}


def ring() -> Draft:
    """Returns four vertices around the block, joined by lines, without any error."""
    vertices = [Vertex(id, x, y, 0.0, label='pass') for id, (x, y) in RING.items()]
    edges = [Edge(id, id, id % 4 + 1, velocity_forward=1.0, velocity_backwards=0.5)
             for id in RING]
    return Draft.of(Graph(vertices, edges))


def found(draft: Draft, plan: Plan = HALL) -> list:
    return Checker(CheckRules(), plan.site()).all(draft)


def only(findings: list, words: str) -> Finding:
    """Returns the only finding, and checks that it has these words."""
    assert [finding for finding in findings if words not in finding.text] == []
    one, = findings
    return one


def changed(draft: Draft, edge: int, **fields) -> Draft:
    return editing.change_edge(draft, edge, **fields)


def test_nothing_is_found_where_nothing_is_wrong():
    assert found(ring()) == []


def test_an_edge_in_a_wall_is_told_at_its_tightest_place():
    draft, edge = editing.connect(ring(), 1, 3)
    finding = only(found(draft), 'in a wall')
    assert (finding.severity, finding.kind, finding.id) == (Severity.ERROR, 'edge', edge)
    assert 5.0 <= finding.place[0] <= 7.0


def test_an_edge_with_too_little_room_for_its_corridor_is_a_warning():
    draft = editing.move_vertex(editing.move_vertex(ring(), 1, 2.0, 0.4), 2, 10.0, 0.4)
    finding = next(finding for finding in found(draft) if finding.kind == 'edge')
    assert finding.severity is Severity.WARNING
    assert 'corridor of 0.9 m is in a wall: there is room for 0.8' in finding.text


def test_a_vertex_in_a_wall_is_an_error():
    draft, vertex = editing.add_vertex(ring(), 6.0, 4.0)
    findings = [finding for finding in found(draft) if finding.id == vertex]
    assert 'it is in a wall' in findings[0].text + findings[1].text


def test_a_part_that_nothing_leads_to_is_told_once_with_its_size():
    draft, first = editing.add_vertex(ring(), 4.0, 3.0)
    draft, second = editing.add_vertex(draft, 4.0, 5.0)
    draft, _ = editing.connect(draft, first, second)
    finding = only(found(draft), 'no edges lead from here and 1 more to vertex 1')
    assert (finding.severity, finding.id) == (Severity.WARNING, first)


def test_a_vertex_without_edges_is_an_error():
    draft, vertex = editing.add_vertex(ring(), 4.0, 3.0)
    finding = only(found(draft), 'no edges lead from here to vertex 1: connect it')
    assert (finding.severity, finding.id) == (Severity.ERROR, vertex)


@pytest.mark.parametrize('forward, backwards, words', [
    (1.0, 0.0, 'cannot leave this vertex'), (0.0, 1.0, 'cannot reach this vertex')])
def test_a_vertex_behind_a_one_way_edge_is_told(forward, backwards, words):
    draft, vertex = editing.add_vertex(ring(), 2.0, 4.0)
    draft, _ = editing.connect(draft, 1, vertex, velocity_forward=forward,
                               velocity_backwards=backwards)
    finding = only(found(draft), words)
    assert (finding.severity, finding.id) == (Severity.ERROR, vertex)


def test_a_ring_of_one_way_edges_is_driven_round():
    draft = ring()
    for id in RING:
        draft = changed(draft, id, velocity_backwards=0.0)
    assert found(draft) == []


def test_an_edge_that_may_be_driven_in_no_direction_is_an_error():
    draft = changed(ring(), 2, velocity_forward=0.0, velocity_backwards=0.0)
    assert only(found(draft), 'no robot can drive on it').id == 2


def test_a_spline_too_sharp_for_a_robot_is_told_where_it_bends():
    draft = changed(editing.turn_vertex(ring(), 2, math.pi), 1, curve_type=CurveType.SPLINE,
                    param_f=0.5, param_b=0.2)
    finding = next(finding for finding in found(draft) if 'too sharp' in finding.text)
    assert (finding.severity, finding.id) == (Severity.ERROR, 1)
    assert math.dist(finding.place, RING[2]) < 1.0


def test_a_wide_spline_is_right():
    draft = editing.turn_vertex(editing.turn_vertex(ring(), 2, math.pi / 2.0), 3, math.pi / 2.0)
    assert found(changed(draft, 2, curve_type=CurveType.SPLINE, param_f=1.5, param_b=1.5)) == []


def test_an_edge_without_length_is_told():
    draft = editing.move_vertex(ring(), 1, *RING[2])
    assert any('at the same place' in finding.text and finding.id == 1
               for finding in found(draft))


def test_two_vertices_in_one_place_are_told():
    draft, vertex = editing.cut_edge(ring(), 1, 0.02)
    assert only(found(draft), 'vertex 1 is less than 0.3 m away').id == vertex


def test_edges_that_cross_without_a_vertex_are_told():
    draft, vertex = editing.add_vertex(ring(), 9.0, 7.3)
    draft, other = editing.add_vertex(draft, 9.0, 4.0)
    draft, edge = editing.connect(draft, vertex, other)
    draft, _ = editing.connect(draft, other, 2)
    finding = only([each for each in found(draft) if each.kind == 'edge'], 'crosses edge 3')
    assert finding.id == edge and finding.place == pytest.approx((9.0, 6.5))


def test_a_dock_with_two_edges_is_an_error():
    finding = only(found(editing.change_vertex(ring(), 1, dock=True)), '2 edges lead to this dock')
    assert finding.severity is Severity.ERROR


def bay(length: float, parking=True) -> Draft:
    draft, vertex = editing.add_vertex(ring(), 2.0 + length, 4.0, parking=parking)
    draft, middle = editing.cut_edge(draft, 4, 0.5)
    return editing.connect(draft, vertex, middle)[0]


def test_parking_beside_an_edge_blocks_it():
    finding = only(found(bay(0.7)), 'a robot that parks here blocks edge')
    assert (finding.kind, finding.severity) == ('vertex', Severity.WARNING)
    assert found(bay(1.5)) == []


def test_parking_where_all_must_pass_cuts_the_graph():
    draft = editing.delete_edge(editing.change_vertex(ring(), 2, parking=True), 4)
    assert any('cuts the graph in two' in finding.text and finding.id == 2
               for finding in found(draft))


def test_a_dead_end_where_robots_cannot_turn_is_told():
    draft, vertex = editing.add_vertex(ring(), 2.0, 7.65)
    draft, _ = editing.connect(draft, 4, vertex)
    assert any('must turn here' in finding.text and finding.id == vertex
               for finding in found(draft))


@pytest.mark.parametrize('aside, told', [(0.0, False), (0.3, True)])
def test_a_slight_bend_is_told_where_robots_cannot_turn(aside, told):
    passage = Plan(8.0, 4.0, ((2.0, 0.0, 6.0, 1.65), (2.0, 2.35, 6.0, 4.0)), (1.0, 2.0))
    graph = Graph([Vertex(1, 1.0, 2.0 - aside, 0.0), Vertex(2, 4.0, 2.0, 0.0),
                   Vertex(3, 7.0, 2.0 - aside, 0.0)], [Edge(1, 1, 2), Edge(2, 2, 3)])
    turning = [finding for finding in found(Draft.of(graph), passage)
               if 'must turn' in finding.text]
    assert [finding.id for finding in turning] == ([2] if told else [])


def test_an_edge_that_bends_where_robots_cannot_turn_is_told():
    passage = Plan(8.0, 4.0, ((2.0, 0.0, 6.0, 1.6), (2.0, 2.4, 6.0, 4.0)), (1.0, 2.0))
    graph = Graph([Vertex(1, 1.0, 1.7, 0.2), Vertex(2, 7.0, 1.7, -0.2)],
                  [Edge(1, 1, 2, CurveType.SPLINE, 2.0, 2.0)])
    finding, = (finding for finding in found(Draft.of(graph), passage)
                if 'must turn' in finding.text)
    assert (finding.severity, finding.kind) == (Severity.WARNING, 'edge')
    assert 1.9 < finding.place[0] < 6.1


def test_a_goal_of_the_map_that_is_no_vertex_is_told():
    plan = replace(HALL, places=(NamedPlace(PlaceKind.GOAL, 'press 4', 4.0, 4.0),
                                 NamedPlace(PlaceKind.GOAL, 'store', 2.1, 1.5)))
    finding = only(found(ring(), plan), "goal 'press 4' of the map has no vertex")
    assert finding.place == (4.0, 4.0)


def test_floor_far_from_all_edges_is_told_with_its_size():
    draft = editing.delete_edge(editing.delete_vertex(ring(), 3), 1)
    draft, _ = editing.connect(draft, 1, 2)
    finding = only(found(draft), 'farther than 2 m from all edges')
    assert finding.place[0] > 6.0 and finding.place[1] > 4.0


def test_without_a_map_only_the_graph_itself_is_checked():
    draft, _ = editing.connect(ring(), 1, 3)
    assert [finding.text for finding in Checker(CheckRules()).all(draft)] == []


@pytest.mark.parametrize('name', ['robot_width', 'robot_length', 'corridor'])
@pytest.mark.parametrize('value', [0.0, -1.0, math.nan, math.inf])
def test_a_robot_that_cannot_be_is_refused(name, value):
    with pytest.raises(SiteError, match=name):
        CheckRules(**{name: value})


def test_errors_come_first_and_each_is_one_line():
    draft, _ = editing.connect(bay(0.7), 1, 3)
    findings = found(draft)
    severities = [finding.severity for finding in findings]
    assert severities == sorted(severities, key=lambda severity: severity is Severity.WARNING)
    assert len(set(severities)) == 2
    assert all('\n' not in str(finding) for finding in findings)
    assert str(findings[0]).startswith('error: edge ')


def test_corridors_of_narrow_edges_are_measured():
    site = two_rooms(door=0.8).site()
    graph = make_graph(site, MakingOptions()).graph
    widths = narrow_edges(graph, site.floor, 0.9, 0.5)
    assert len(widths) >= 1
    assert list(widths.values()) == pytest.approx([0.8] * len(widths), abs=0.06)


@settings(max_examples=15, deadline=None)
@given(st.lists(st.tuples(st.sampled_from((1, 2, 3, 4)), st.integers(5, 115),
                          st.integers(5, 75)), max_size=6),
       st.sampled_from((1, 2, 3, 4)))
def test_what_a_checker_remembers_is_what_another_finds_anew(moves, deleted):
    checker, draft = Checker(CheckRules(), HALL.site()), ring()
    checker.all(draft)
    draft = editing.delete_edge(draft, deleted)
    for id, decimetres_x, decimetres_y in moves:
        draft = editing.move_vertex(draft, id, decimetres_x / 10.0, decimetres_y / 10.0)
        checker.all(draft)
    assert checker.all(draft) == found(draft)
