"""Made graphs are valid, connected, drivable, deterministic, and cover the reachable floor."""
from __future__ import annotations

import math
import os
from typing import List

import numpy as np
import pytest
from floor_plans import Box, Plan, corner, corridor, floor_plans, two_rooms
from hypothesis import HealthCheck, given, settings
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.spatial import cKDTree

from graph_editor.checking.checker import Checker
from graph_editor.checking.rules import CheckRules
from graph_editor.floor import Floor
from graph_editor.making.coverage import PITCH, Coverage
from graph_editor.making.keeping_ids import with_ids_of
from graph_editor.making.maker import make_graph
from graph_editor.making.options import Halls, MakingOptions
from graph_editor.making.tidying import LEAST_FLOOR
from graph_editor.site import MappedSite, NamedPlace, PlaceKind
from trajectory_graph import Graph
from trajectory_graph.editing import Draft
from trajectory_graph.yaml_file import dump_graph

LONG = os.environ.get('LD90_LONG_TESTS') == '1'
OPTIONS = MakingOptions()


def floor_of_robot(site: MappedSite) -> np.ndarray:
    """Returns the floor on which a robot can turn and which it can reach from its start places.

    The margin here is larger than the smallest margin of make_graph, so the graph must reach all
    this floor.
    """
    floor, turning = site.floor, OPTIONS.turning
    parts, count = ndimage.label(floor.clearance >= turning, np.ones((3, 3)))
    rims = [floor.centres(*np.nonzero((parts == part) & (floor.clearance < turning + 0.1)))[::4]
            for part in range(1, count + 1)]
    trees = [cKDTree(rim) for rim in rims]
    reached = {floor.part_near(parts, place.position) for place in site.places} - {0}
    ahead = sorted(reached)
    while ahead:
        here = ahead.pop() - 1
        for other in range(count):
            if other + 1 not in reached and straight_between(
                    floor, rims[here], rims[other], trees[here].sparse_distance_matrix(
                        trees[other], 2.0, output_type='coo_matrix')):
                reached.add(other + 1)
                ahead.append(other + 1)
    return np.isin(parts, sorted(reached))


def straight_between(floor: Floor, starts: np.ndarray, ends: np.ndarray,
                     near: coo_matrix) -> bool:
    """Returns whether a robot has room on a straight line between two near points.

    near -- the pairs of a point in `starts` and a near point in `ends`
    """
    first, last = starts[near.row], ends[near.col]
    room = np.full(len(first), np.inf)
    for fraction in np.linspace(0.0, 1.0, 31):
        room = np.minimum(room, floor.clearance_at(first + fraction * (last - first)))
    return bool((room >= OPTIONS.tight + 0.02).any())


def share_served(site: MappedSite, graph: Graph, reach: float) -> float:
    """Returns the share of the robot's floor from which an edge is within `reach` m of driving."""
    return float(served_or_not(site, graph, reach).mean())


def floor_left(site: MappedSite, graph: Graph, reach: float) -> float:
    """Returns the area (m2) of the robot's floor that is farther than `reach` m from all edges."""
    return np.count_nonzero(~served_or_not(site, graph, reach)) * PITCH ** 2


def served_or_not(site: MappedSite, graph: Graph, reach: float) -> np.ndarray:
    """Returns for each cell of the robot's floor whether an edge or vertex is within `reach` m of
    driving. The paths may lead through places at which a robot cannot turn.
    """
    coverage = Coverage(site.floor, site.floor.clearance >= OPTIONS.tight, reach)
    its_floor = Coverage(site.floor, floor_of_robot(site), reach).mask
    served = np.zeros(coverage.mask.size, bool)
    for id in graph.edges:
        served[coverage.covered_by(graph.curve(id).sample(0.05))] = True
    for vertex in graph.vertices.values():
        served[coverage.covered_by(np.array([vertex.position]))] = True
    return served[its_floor.ravel()]


def least_clearance(site: MappedSite, graph: Graph) -> float:
    return min(float(site.floor.clearance_at(graph.curve(id).sample(0.02)).min())
               for id in graph.edges)


def turns_without_room(site: MappedSite, graph: Graph) -> List[str]:
    """Returns the findings of check_graph about places where robots must turn but cannot."""
    findings = Checker(CheckRules(), site).all(Draft.of(graph))
    return [str(finding) for finding in findings if 'must turn' in finding.text]


def crookedness(graph: Graph) -> float:
    """Returns the share of the graph's length that is neither horizontal nor vertical."""
    lengths = {True: 0.0, False: 0.0}
    for id in graph.edges:
        curve = graph.curve(id)
        for (x1, y1), (x2, y2) in zip(curve.sample(0.05), curve.sample(0.05)[1:]):
            lengths[min(abs(x2 - x1), abs(y2 - y1)) < 1e-3] += math.hypot(x2 - x1, y2 - y1)
    return lengths[False] / (lengths[True] + lengths[False])


def test_a_corridor_gets_one_straight_lane_in_its_middle():
    graph = make_graph(corridor(12.0, 2.4).site(), OPTIONS).graph
    heights = [vertex.y for vertex in graph.vertices.values()]
    assert heights == pytest.approx([1.2] * len(heights), abs=0.04)
    assert max(heights) - min(heights) < 1e-6
    assert max(vertex.x for vertex in graph.vertices.values()) > 10.5
    assert min(vertex.x for vertex in graph.vertices.values()) < 1.5
    assert sum(graph.is_end_vertex(id) for id in graph.vertices) == 2


def test_no_edge_is_longer_than_wanted():
    graph = make_graph(corridor(12.0).site(), MakingOptions(longest_edge=2.0)).graph
    assert max(graph.curve(id).length for id in graph.edges) <= 2.0
    assert len(graph.edges) >= 5


def test_a_door_is_driven_through_in_its_middle():
    graph = make_graph(two_rooms().site(), OPTIONS).graph
    through = [id for id in graph.edges if graph.curve(id).points[:, 1].min() < 5.0
               < graph.curve(id).points[:, 1].max()]
    assert len(through) == 1
    assert graph.curve(through[0]).points[:, 0] == pytest.approx(3.0, abs=0.06)


def test_a_bend_is_a_spline_between_two_lines_at_right_angles():
    graph = make_graph(corner().site(), OPTIONS).graph
    splines = [id for id, edge in graph.edges.items() if edge.curve_type.value == 'spline']
    assert len(splines) == 1
    curve = graph.curve(splines[0])
    turn = abs(curve.heading_at(curve.length) - curve.heading_at(0.0))
    assert turn == pytest.approx(math.pi / 2.0, abs=0.1)
    assert least_clearance(corner().site(), graph) > OPTIONS.corridor / 2.0


def test_the_floor_that_only_a_narrow_door_leads_to_is_reached():
    site = two_rooms(door=0.7).site()
    graph = make_graph(site, OPTIONS).graph
    assert share_served(site, graph, 3.0) > 0.95
    assert least_clearance(site, graph) >= OPTIONS.robot_width / 2.0


@pytest.mark.parametrize('things', [
    ((1.6, 4.3), (2.3, 3.7), (3.4, 4.0)), ((2.5, 3.7), (3.8, 4.0), (2.2, 4.0)),
    ((2.2, 4.7), (1.9, 4.2), (2.5, 3.5)), ((2.9, 4.1), (3.2, 3.8), (1.8, 3.3))])
def test_among_things_lanes_bend_only_where_robots_have_room_to_turn(things):
    site = Plan(5.6, 8.0, ((0.0, 4.0, 1.6, 4.1), (4.0, 4.0, 5.6, 4.1),
                           *((x, y, x + 0.2, y + 0.2) for x, y in things)), (2.8, 1.2)).site()
    graph = make_graph(site, OPTIONS).graph
    assert turns_without_room(site, graph) == []
    assert least_clearance(site, graph) > OPTIONS.robot_width / 2.0 + 0.015, (
        'the clearance must be that of the robot planner')
    assert share_served(site, graph, 3.0) > 0.95, 'the upper room must be reached'


def room_behind_a_corner(width: float) -> Plan:
    """Returns two rooms, connected by a passage with a right-angled corner."""
    return Plan(9.0, 7.0 + width, (
        (0.0, 3.0, 5.0, 4.0), (5.0 + width, 3.0, 9.0, 4.0 + width),
        (3.0, 4.0 + width, 9.0, 7.0 + width)), (2.0, 1.5))


def test_a_room_behind_a_corner_that_robots_cannot_turn_at_is_left_out_and_told():
    tight = make_graph(room_behind_a_corner(0.7).site(), OPTIONS)
    assert max(vertex.y for vertex in tight.graph.vertices.values()) < 3.0
    note, = tight.notes
    assert note.startswith('At 5.3') and 'm of lanes behind it' in note
    wide = make_graph(room_behind_a_corner(1.0).site(), OPTIONS)
    assert max(vertex.y for vertex in wide.graph.vertices.values()) > 5.0
    assert wide.notes == ()


def test_of_two_parts_the_one_stays_in_which_robots_start_not_one_behind_the_wall():
    tight_corner = (0.58, 4.32, 0.98, 4.72)
    plan = Plan(9.6, 9.2, ((0.0, 5.05, 2.18, 5.15), (2.88, 5.05, 9.6, 5.15),
                           (5.95, 0.0, 6.05, 5.1), (0.0, 6.35, 9.6, 6.45), tight_corner),
                start=(0.9, 5.75))
    graph = make_graph(plan.site(), OPTIONS).graph
    assert sum(graph.curve(id).length for id in graph.edges) > 10.0


def two_doors(*boxes: Box) -> Plan:
    """Returns two rooms, joined by two doors of 0.6 m. The upper room has a goal on each side."""
    return Plan(6.4, 5.1, (
        (0.0, 2.35, 1.75, 2.45), (2.35, 2.35, 4.9, 2.45), (5.5, 2.35, 6.4, 2.45), *boxes),
        (3.2, 0.7), (NamedPlace(PlaceKind.GOAL, 'right', 3.9, 3.6),
                     NamedPlace(PlaceKind.GOAL, 'left', 1.0, 3.6)))


BEHIND_LEFT_DOOR = 1.6, 3.05, 2.0, 3.45  # a box that robots cannot pass


def test_a_goal_is_a_vertex_even_if_the_first_lanes_to_it_are_too_narrow():
    site = two_doors(BEHIND_LEFT_DOOR).site()
    made = make_graph(site, OPTIONS)
    graph, (note,) = made.graph, made.notes
    labels = {vertex.label: vertex for vertex in graph.vertices.values()}
    assert labels['left'].position == pytest.approx((1.0, 3.6), abs=1e-3)
    assert labels['right'].position == pytest.approx((3.9, 3.6), abs=1e-3)
    assert note.startswith('At 2.0') and note.endswith('no lane leads through.'), (
        'the note must name the place without a lane')
    assert turns_without_room(site, graph) == []
    assert least_clearance(site, graph) > OPTIONS.robot_width / 2.0 + 0.015


def test_a_goal_that_no_lane_reaches_in_the_end_is_no_vertex_and_told():
    wall_above = 2.45, 2.4, 2.55, 5.1
    site = two_doors(BEHIND_LEFT_DOOR, wall_above).site()
    made = make_graph(site, OPTIONS)
    graph, (note,) = made.graph, made.notes
    labels = {vertex.label for vertex in graph.vertices.values()}
    assert 'right' in labels and 'left' not in labels
    assert note.endswith(', with left.')


def test_a_room_without_corners_to_go_to_is_one_vertex_or_a_few():
    graph = make_graph(Plan(2.5, 2.5, (), (1.2, 1.2)).site(), OPTIONS).graph
    assert 1 <= len(graph.vertices) <= 3


def test_the_only_lane_ends_where_robots_can_turn_however_short_it_gets():
    site = Plan(5.3, 1.2, ((1.9, 0.33, 2.3, 0.73),), (0.9, 0.6)).site()
    graph = make_graph(site, OPTIONS).graph
    assert graph.vertices
    assert turns_without_room(site, graph) == []


def test_a_dead_end_is_not_taken_off_bit_by_bit_with_the_floor_that_it_leads_to():
    stone = (1.91, 3.55, 1.96, 3.6)
    site = Plan(5.3, 9.6, ((0.0, 2.75, 0.3, 2.85), (1.0, 2.75, 5.3, 2.85), (2.55, 0.0, 2.65, 2.8),
                           (0.0, 4.55, 5.3, 4.65), stone), (0.9, 3.7)).site()
    graph = make_graph(site, OPTIONS).graph
    assert floor_left(site, graph, 3.5) < LEAST_FLOOR
    assert max(vertex.x for vertex in graph.vertices.values()) > 3.0


def test_of_two_rooms_with_a_gap_that_no_turn_leads_to_robots_stay_in_the_one_they_start_in():
    block = (1.9, 0.6, 2.3, 1.0)
    site = Plan(5.3, 1.2, (block,), (0.9, 0.6)).site()
    graph = make_graph(site, OPTIONS).graph
    assert turns_without_room(site, graph) == []
    assert 0.0 < max(vertex.x for vertex in graph.vertices.values()) < 1.9


def test_past_a_thing_in_a_corridor_a_lane_takes_the_wider_side():
    stone = (1.91, 0.55, 1.96, 0.6)
    site = Plan(5.3, 1.7, (stone,), (0.9, 0.9)).site()
    graph = make_graph(site, OPTIONS).graph
    assert share_served(site, graph, 3.5) > 0.9
    assert least_clearance(site, graph) > OPTIONS.corridor / 2.0


def test_a_hall_is_a_lattice_if_wanted():
    site = Plan(16.0, 12.0, (), (3.0, 3.0)).site()
    graph = make_graph(site, MakingOptions(halls=Halls.LATTICE, lattice_pitch=3.0)).graph
    crossings = [id for id in graph.vertices if len(graph.edges_at(id)) == 4]
    assert len(crossings) >= 6
    assert crookedness(graph) < 0.1, "only the rounded corners may be oblique"
    assert share_served(site, graph, 2.0) > 0.98


@settings(max_examples=200 if LONG else 8, suppress_health_check=list(HealthCheck))
@given(floor_plans())
def test_any_floor_plan_gets_a_graph_that_robots_can_drive(plan):
    site = plan.site()
    graph = make_graph(site, OPTIONS).graph  # a Graph is always valid and connected
    assert turns_without_room(site, graph) == []
    if graph.edges:
        assert least_clearance(site, graph) > OPTIONS.robot_width / 2.0 + 0.015
        assert min(graph.curve(id).length for id in graph.edges) > 0.05
        assert all(edge.velocity_forward > 0.0 and edge.velocity_backwards > 0.0
                   for edge in graph.edges.values())
    # in a small plan, a tenth of the floor may be too little for another lane
    assert share_served(site, graph, 3.5) > 0.9 or floor_left(site, graph, 3.5) < LEAST_FLOOR
    again = make_graph(plan.site(), OPTIONS).graph
    assert dump_graph(again) == dump_graph(graph), 'a second graph must be the same'
    assert dump_graph(with_ids_of(graph, again)) == dump_graph(graph), (
        'it must also be the same with kept ids')
