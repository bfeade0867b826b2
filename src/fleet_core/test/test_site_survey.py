"""The survey of a graph: its capacity and its weak points, in numbers and in text."""
from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from fleet_builders import AGV, corridor, graph_of, with_docks

from fleet_core.fleet import Fleet, Robot, RobotType
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.site.remarks import remarks
from fleet_core.site.survey import (
    Capacity,
    DeadEnd,
    Stranded,
    Survey,
    dead_ends,
    long_edges,
    near_edges,
    parking_for_all,
    survey,
)
from trajectory_graph import Graph, load_graph, split_edges

LAB = Path(__file__).resolve().parents[3] / 'maps' / 'lab_graph.yaml'
LD90 = RobotType('omron_ld90', 0.43, 1.35, 0.25, False, frozenset({16}))


def ring(*spurs, radius=6.0, one_way=()):
    """A square of vertices and edges 1 to 4, with a dead end 10 + k at each vertex k of `spurs`."""
    places = {1: (0.0, 0.0), 2: (radius, 0.0), 3: (radius, radius), 4: (0.0, radius)}
    ends = {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (4, 1)}
    for k in spurs:
        x, y = places[k]
        places[10 + k] = (x + (2.0 if x else -2.0), y)
        ends[10 + k] = (k, 10 + k)
    return graph_of(places, ends, one_way=one_way)


def told(graph, *types, robots=()):
    fleet = Fleet(types, tuple(robots), 0.1)
    return [remark.text for remark in remarks(graph, fleet, survey(RoadNetwork(graph), fleet))]


class TestParking:
    def test_spurs_hold_robots_and_so_does_the_ring_until_it_is_cut(self):
        graph = ring(1, 2, 3)
        found = survey(RoadNetwork(graph), Fleet((AGV,), (), 0.1))
        assert found.capacities == (Capacity('agv', 4, 0),)
        assert {11, 12, 13} <= found.parking

    def test_a_dock_counts_for_types_that_list_it_and_is_kept_free(self):
        docking = replace(AGV, name='docking', docks=frozenset({11}))
        found = survey(RoadNetwork(with_docks(ring(1, 2, 3), 11)), Fleet((AGV, docking), (), 0.1))
        assert found.capacities == (Capacity('agv', 3, 0), Capacity('docking', 3, 1))
        assert len(found.parking) == 4

    def test_robots_that_are_too_large_for_each_other_need_more_room(self):
        giant = RobotType('giant', 2.5, 1.0)
        found = survey(RoadNetwork(ring(1, 2, 3)), Fleet((AGV, giant), (), 0.1))
        small, large = found.capacities
        assert large.robots < small.robots
        assert len(found.parking) == large.robots, (
            'places for all types must be those of the largest type')

    def test_the_laboratory_holds_twelve_robots_and_one_at_the_dock(self):
        graph = load_graph(LAB)
        found = survey(RoadNetwork(graph), Fleet((LD90,), (), 0.1))
        assert found.capacities == (Capacity('omron_ld90', 12, 1),)
        assert 16 in found.parking
        assert not found.near_edges


    def test_while_a_ring_is_cut_nobody_is_parked_on_the_only_way_that_is_left(self):
        graph, fleet = ring(1, 2, 3), Fleet((AGV,), (), 0.1)
        assert parking_for_all(RoadNetwork(graph), fleet) > {11, 12, 13}
        assert parking_for_all(RoadNetwork(graph, closed=(2,)), fleet) == {11, 12, 13}

    def test_in_each_part_that_closed_edges_leave_somebody_can_park(self):
        graph, fleet = ring(1, 2, 3, 4), Fleet((AGV,), (), 0.1)
        parking = parking_for_all(RoadNetwork(graph, closed=(2, 4)), fleet)
        assert parking == {11, 12, 13, 14}


class TestDeadEnds:
    def test_are_spurs_and_longer_branches_by_the_vertex_they_hang_on(self):
        graph = graph_of({1: (0, 0), 2: (4, 0), 3: (0, 4), 4: (8, 0), 5: (12, 0), 6: (-3, 0)},
                         {1: (1, 2), 2: (2, 3), 3: (3, 1), 4: (2, 4), 5: (4, 5), 6: (1, 6)})
        assert dead_ends(RoadNetwork(graph)) == (
            DeadEnd(2, (4, 5), pytest.approx(8.0)), DeadEnd(1, (6,), pytest.approx(3.0)))

    def test_two_edges_between_the_same_vertices_are_a_way_round(self):
        graph = graph_of({1: (0, 0), 2: (4, 0)}, {1: (1, 2), 2: (2, 1)})
        assert dead_ends(RoadNetwork(graph)) == ()

    def test_a_tree_is_one_and_hangs_on_nothing(self):
        end, = dead_ends(RoadNetwork(corridor(5, siding_at=3)))
        assert (end.entry, len(end.vertices)) == (None, 6)


class TestEdges:
    def test_that_are_long_are_told_those_first_that_many_ways_lead_over(self):
        graph = graph_of({1: (0, 0), 2: (20, 0), 3: (22, 0), 4: (42, 0), 5: (44, 0), 6: (44, 2)},
                         {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (4, 5), 5: (5, 6)})
        first, second = long_edges(RoadNetwork(graph), AGV, 0.9)
        assert (first.id, first.length, second.id) == (3, pytest.approx(20.0), 1)
        # There are 30 ordered pairs of vertices. In each direction, edge 3 joins 3 x 3 pairs, and
        # edge 1 joins 1 x 5 pairs.
        assert (first.share, second.share) == (pytest.approx(18 / 30), pytest.approx(10 / 30))

    def test_that_run_near_each_other_without_meeting_are_told(self):
        graph = graph_of({1: (0, 0), 2: (6, 0), 3: (6, 0.7), 4: (0, 0.7), 5: (12, 0), 6: (-6, 0)},
                         {1: (1, 2), 2: (3, 4), 3: (2, 5), 4: (5, 3), 5: (1, 6), 6: (6, 4)})
        assert near_edges(RoadNetwork(graph), 0.9) == ((1, 2),)
        assert near_edges(RoadNetwork(graph), 0.6) == ()

    def test_that_cross_are_told(self):
        graph = graph_of({1: (0, 0), 2: (6, 6), 3: (6, 0), 4: (0, 6), 5: (12, 0), 6: (12, 6)},
                         {1: (1, 2), 2: (3, 4), 3: (3, 5), 4: (5, 6), 5: (6, 2)})
        assert (1, 2) in near_edges(RoadNetwork(graph), 0.9)


class TestRemarks:
    def test_a_fleet_that_does_not_fit_is_a_warning(self):
        graph = ring(1)
        robots = [Robot(f'r{k}', AGV, 1) for k in range(5)]
        fleet = Fleet((AGV,), tuple(robots), 0.1)
        warned = [remark.text for remark in remarks(graph, fleet, survey(RoadNetwork(graph), fleet))
                  if remark.warning]
        assert len(warned) == 1
        assert 'holds 3 robots of type agv' in warned[0]
        assert 'the fleet has 5: they will block each other for good' in warned[0]

    def test_vertices_without_a_way_back_are_named(self):
        found = Survey(0.9, frozenset((1,)), (), (), (Stranded('agv', (12,)),), (), ())
        graph = ring(2, one_way=[12])
        assert survey(RoadNetwork(graph), Fleet((AGV,), (), 0.1)).stranded == found.stranded
        assert 'cannot return from, vertex 12' in ' '.join(
            remark.text for remark in remarks(graph, Fleet((AGV,), (), 0.1), found))

    def test_what_lies_behind_a_dock_is_named_with_the_true_reason(self):
        """Vertex 20 lies behind dock 12 on the same lane, and may be a dock itself."""
        graph = ring(2)
        lane = Graph([*graph.vertices.values(), replace(graph.vertices[12], id=20, x=12.0)],
                     [*graph.edges.values(), replace(graph.edges[12], id=20, origin=12,
                                                     destination=20)])
        for docks in ((12,), (12, 20)):
            text = ' '.join(told(with_docks(lane, *docks), AGV))
            assert ('cannot return from, vertex 20: each way leads through a dock, and no route '
                    'leads through a dock') in text
            assert 'let edges lead there' not in text
        assert 'leads through a dock' not in ' '.join(told(with_docks(lane, 20), AGV))

    def test_what_fleet_file_and_graph_do_not_agree_on_is_named(self):
        docking = replace(AGV, name='docking', docks=frozenset({2}))
        text = ' '.join(told(with_docks(ring(1, 2), 11), docking,
                             robots=[Robot('r1', docking, 99)]))
        assert 'Robot r1 of the fleet file begins on vertex 99' in text
        assert 'Robot type docking lists dock 2, but the graph has no dock there' in text
        assert 'No robot type lists dock 11' in text

    def test_long_edges_come_with_the_command_that_cuts_them(self):
        text = ' '.join(told(ring(1, radius=30.0), AGV))
        assert 'edge 1 (30.0 m, ' in text
        assert 'split_edges --longest 1.8' in text

    def test_a_long_dead_end_is_told(self):
        graph = graph_of({1: (0, 0), 2: (4, 0), 3: (0, 4), 4: (8, 0), 5: (12, 0)},
                         {1: (1, 2), 2: (2, 3), 3: (3, 1), 4: (2, 4), 5: (4, 5)})
        assert 'Behind vertex 2 lies a dead end of 8.0 m with vertices 4, 5' in ' '.join(
            told(graph, AGV))

    @pytest.mark.parametrize('drawn', [
        load_graph(LAB), ring(1, 3, radius=30.0), ring(2, one_way=[12]),
        graph_of({1: (0, 0), 2: (8, 0), 3: (0, 4), 4: (8, 0.5), 5: (16, 0), 6: (0, 0.5)},
                 {1: (1, 2), 2: (2, 3), 3: (3, 1), 4: (3, 4), 5: (2, 5), 6: (3, 6)})])
    @pytest.mark.parametrize('longest', [0.9, 2.0])
    def test_of_a_graph_with_cut_edges_only_drawn_edges_and_vertices_are_named(self, drawn,
                                                                               longest):
        text = ' '.join(told(split_edges(drawn, longest), AGV))
        assert 'Parking: ' in text
        for kind, ids in re.findall(r'(edge|vert)(?:s|ex|ices)? ((?:\d+(?:, | and )?)+)', text,
                                    re.IGNORECASE):
            known = drawn.edges if kind.lower() == 'edge' else drawn.vertices
            assert set(map(int, re.findall(r'\d+', ids))) <= set(known), text
