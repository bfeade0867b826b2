import pytest
from converter_builders import graph_of

from omron_map_converter.goals import dock_pose, goal, places_of
from trajectory_graph import UnknownVertex

# 1 --> 2 --> 3, and 4 --> 2: 1 and 4 are origins, 3 is a destination
BRANCH = graph_of([(1, 0.0, 0.0, 10.0), (2, 4.0, 0.0, 20.0), (3, 8.0, 0.0, 30.0),
                   (4, 4.0, -3.0, 90.0)], [(1, 2), (2, 3), (4, 2)])


def test_a_robot_waits_at_an_origin_along_theta():
    place = goal(BRANCH, BRANCH.vertex(1))
    assert (place.kind, place.theta) == ('GoalWithHeading', pytest.approx(10.0))


def test_a_robot_waits_at_a_destination_against_theta():
    place = goal(BRANCH, BRANCH.vertex(3))
    assert (place.kind, place.theta) == ('GoalWithHeading', pytest.approx(-150.0))


def test_a_vertex_of_several_edges_has_no_heading():
    assert goal(BRANCH, BRANCH.vertex(2)).kind == 'Goal'


def test_a_dock_at_a_destination_faces_along_theta():
    assert dock_pose(BRANCH, 3) == (8000, 0, pytest.approx(30.0 + 360.0))


def test_a_dock_at_an_origin_faces_against_theta():
    assert dock_pose(BRANCH, 4) == (4000, -3000, pytest.approx(90.0 + 180.0))


def test_a_given_heading_overrides_the_rule_for_docks():
    assert dock_pose(BRANCH, 3, heading=-45.0).heading == -45.0
    assert dock_pose(BRANCH, 2, heading=-45.0).heading == -45.0


def test_a_dock_between_edges_needs_a_heading():
    with pytest.raises(ValueError, match='vertex 2 has several edges.*dock_heading'):
        dock_pose(BRANCH, 2)


def test_a_dock_must_be_in_the_graph():
    with pytest.raises(UnknownVertex):
        dock_pose(BRANCH, 9)


def test_every_vertex_becomes_one_place_called_by_its_id():
    made = places_of(BRANCH, dock_vertex=3)
    assert [(place.name, place.kind) for place in made] == [
        ('1', 'GoalWithHeading'), ('2', 'Goal'), ('3', 'DockLynx'), ('4', 'GoalWithHeading')]
    assert [(place.x, place.y) for place in made] == [(0, 0), (4000, 0), (8000, 0), (4000, -3000)]


def test_positions_are_rounded_to_whole_millimetres():
    graph = graph_of([(1, 0.0006, -1.2344), (2, 4.0, 0.0)], [(1, 2)])
    assert (goal(graph, graph.vertex(1)).x, goal(graph, graph.vertex(1)).y) == (1, -1234)
