"""The markers of a fleet for RViz."""
from __future__ import annotations

import math
from itertools import combinations
from pathlib import Path

import pytest
from fleet_builders import corridor
from visualization_msgs.msg import Marker

from fleet_core.supervision.fleet_stop import NOT_STOPPED, FleetStop, StopCause
from fleet_core.supervision.looks import ResourceLook
from fleet_core.supervision.waits import WaitCode
from graph_fleet_manager.nodes.rviz import stop_picture
from graph_fleet_manager.nodes.rviz.graph_picture import (
    graph_markers,
    place_texts,
    window_of,
)
from graph_fleet_manager.nodes.rviz.menus import BUTTON, BUTTON_ABOVE
from graph_fleet_manager.nodes.rviz.paints import LOAD, PAINTS
from graph_fleet_manager.nodes.rviz.picture import PictureChanges
from graph_fleet_manager.nodes.rviz.plan_picture import plan_markers
from graph_fleet_manager.nodes.rviz.robot_picture import (
    GREY,
    RED,
    WORDS_SATURATION,
    DrawnPose,
    label_of,
    place_on_graph,
    robot_markers,
    words_of,
)
from graph_fleet_manager.nodes.rviz.sentence_picture import LETTER, LINES, sentence_marker
from graph_fleet_manager.nodes.rviz.stop_picture import stop_markers
from itrci_nav_msgs.msg import (
    FleetPlan,
    FleetRobot,
    FleetState,
    PlannedDrives,
    RobotPlan,
    SymbolicPose,
)
from rviz_drawing import drawing
from rviz_drawing.label_places import Label, LabelPlaces
from trajectory_graph import load_graph
from trajectory_graph.placing import Covered, shared

GRAPH = corridor(4)  # 2 m apart, on the x axis
TEXTS = place_texts(GRAPH)
HERE = DrawnPose(1.0, 0.0, 0.0)


def named(markers, namespace):
    return [marker for marker in markers if marker.ns == namespace]


def robot(**fields):
    usual = {'name': 'agv_1', 'type': 'agv', 'pose': SymbolicPose(1, 50.0), 'battery': 0.5}
    return FleetRobot(**{**usual, **fields})


def drawn(one, side=0):
    return robot_markers(one, 3, HERE, label_of(one, HERE, 0.4, 0.0), side, False)


def laboratory():
    return load_graph(str(Path(__file__).resolve().parents[4] / 'maps' / 'lab_graph.yaml'))


def test_no_id_of_a_vertex_covers_an_edge_or_another_id():
    graph = laboratory()
    texts = place_texts(graph)
    assert len(texts.names) == len(graph.vertices)
    for one, other in combinations(texts.names.values(), 2):
        assert not shared(one, other)
    points = [point for edge in graph.edges for point in graph.curve(edge).sample(0.05)]
    for left, lower, right, upper in texts.names.values():
        assert not [1 for x, y in points if left < x < right and lower < y < upper]


@pytest.mark.parametrize('vertex', [1, 4, 12, 26, 40])
def test_a_robots_label_keeps_clear_of_the_edges_of_a_crossing(vertex):
    graph = laboratory()
    places, edges = LabelPlaces(), place_texts(graph).edges
    there = Label(*graph.vertices[vertex].position, 0.4, 'agv_1  100 %\nidle', 0.42)
    places.choose({'a': there}, window_of(graph), beneath=edges)
    assert edges.covered(there.boxes()[places.side('a')]) == Covered()


def test_closed_edges_have_the_colour_of_shut_doors_because_red_is_for_trouble():
    markers = graph_markers(GRAPH, TEXTS, {2}, [], [])
    grey, shut = named(markers, 'edges')[0], named(markers, 'closed')[0]
    assert shut.color == PAINTS[ResourceLook.SHUT]
    assert all(not 2.0 < point.x < 4.0 for point in grey.points)
    xs = [point.x for point in shut.points]
    assert (min(xs), max(xs)) == (2.0, 4.0)


def test_parking_and_docks_are_squares_on_their_vertices():
    markers = graph_markers(GRAPH, TEXTS, (), [1, 99], [4])
    assert [one.pose.position.x for one in named(markers, 'parking')] == [0.0]
    assert [one.pose.position.x for one in named(markers, 'docks')] == [6.0]


def test_a_robot_is_where_its_symbolic_pose_is():
    assert place_on_graph(robot(), GRAPH) == DrawnPose(1.0, 0.0, 0.0)
    back = place_on_graph(robot(pose=SymbolicPose(-1, 25.0)), GRAPH)
    assert (back.x, abs(back.heading)) == (pytest.approx(1.5), pytest.approx(math.pi))


@pytest.mark.parametrize('pose', [SymbolicPose(0, 0.0), SymbolicPose(99, 0.0),
                                  SymbolicPose(1, math.nan)])
def test_off_the_graph_it_is_nowhere(pose):
    assert place_on_graph(robot(pose=pose), GRAPH) is None


@pytest.mark.parametrize('fields, words', [
    ({'state': FleetRobot.IDLE}, 'agv_1  50 %\nidle'),
    ({'state': FleetRobot.BUSY, 'destination': 18}, 'agv_1  50 %\nto 18'),
    ({'state': FleetRobot.BUSY, 'destination': 18, 'waits_for_code': WaitCode.STEP,
      'waits_for': 'step 1'}, 'agv_1  50 %\nworking at 18\n(step 1)'),
    ({'state': FleetRobot.BUSY, 'destination': 18, 'waits_for': 'agv_2', 'battery': math.nan},
     'agv_1\nto 18\n(agv_2)'),
    ({'state': FleetRobot.OUT_OF_SERVICE, 'waits_for': 'it was taken out of service'},
     'agv_1  50 %\nout of service'),
    ({'state': FleetRobot.FAILED, 'waits_for': 'a broken belt'},
     'agv_1  50 %\nfailed\n(a broken belt)')])
def test_its_words_tell_what_it_does_and_waits_for(fields, words):
    assert words_of(robot(**fields), 0.0) == words


def test_a_robot_that_waits_for_a_person_is_in_the_colour_of_trouble_and_says_what_for():
    asks = robot(state=FleetRobot.BUSY, destination=18, waits_for_code=WaitCode.PERSON,
                 waits_for='step 1 (engage) of stop 1 needs an answer: no pallet under the fork')
    assert 'answer: no pallet under' in ' '.join(words_of(asks, 0.0).split())
    assert named(drawn(asks), 'names')[0].color == RED


def test_what_it_waits_for_takes_no_more_than_two_lines():
    assert len(words_of(robot(waits_for='somebody ' * 30), 0.0).splitlines()) <= 4


def test_an_offline_robot_stays_visible_in_grey():
    markers = drawn(robot(state=FleetRobot.OFFLINE))
    assert [one.color for one in named(markers, 'bodies') + named(markers, 'names')] == [GREY] * 2


def test_a_failed_robot_has_a_red_ring_and_every_marker_ends_with_the_node():
    markers = drawn(robot(state=FleetRobot.FAILED))
    assert named(markers, 'outlines')[0].color == RED
    assert all(marker.lifetime.to_sec() > 0.0 for marker in markers)


@pytest.mark.parametrize('load, serial, words, paint', [
    (FleetRobot.LOAD_LOADED, 42, 'load of M42 (pallet)', LOAD),
    (FleetRobot.LOAD_UNKNOWN, 0, 'load unknown', PAINTS[ResourceLook.TROUBLE])])
def test_a_load_is_a_box_on_the_robot_with_its_mission_in_the_label(load, serial, words, paint):
    laden = robot(state=FleetRobot.IDLE, load=load, load_serial=serial,
                  load_types=['pallet'] if serial else [''])
    box, = named(drawn(laden), 'loads')
    assert box.color == paint
    assert words_of(laden, 0.0) == f'agv_1  50 %\nidle\n{words}'
    assert [one.color for one in named(drawn(laden), 'outlines') if one.points] == (
        [RED] if load == FleetRobot.LOAD_UNKNOWN else [])
    assert named(drawn(robot()), 'loads') == []


def test_a_robot_whose_step_asks_needs_a_person_and_says_the_whole_command():
    asks = robot(state=FleetRobot.BUSY, destination=27, waits_for_code=WaitCode.PERSON, waits_for=(
        'step 1 (handshake) of stop 1 needs an answer: it has not ended within 5 s. Say `mission '
        'answer 2079814056 retry|skip|fail|done`'))
    assert named(drawn(asks), 'outlines')[0].color == RED
    assert words_of(asks, 0.0).splitlines()[1] == 'needs a person'
    assert words_of(asks, 0.0).endswith('2079814056\nretry|skip|fail|done`)')


def test_a_load_that_a_step_takes_or_gives_needs_no_person():
    fetching = robot(state=FleetRobot.BUSY, load=FleetRobot.LOAD_UNKNOWN, load_types=['pallet'],
                     waits_for='step 1 (engage) of stop 1', waits_for_code=WaitCode.STEP)
    box, = named(drawn(fetching), 'loads')
    assert (box.color.r, box.color.g, box.color.b) == (LOAD.r, LOAD.g, LOAD.b)
    assert box.color.a < LOAD.a
    assert words_of(fetching, 0.0).splitlines()[2] == 'load is being moved (pallet)'
    assert [one.points for one in named(drawn(fetching), 'outlines')] == [[]]


def test_its_label_stands_beside_it_in_its_hue():
    above, below = (named(drawn(robot(), side), 'names')[0] for side in (0, 1))
    assert above.pose.position.y > HERE.y + 0.4 > HERE.y - 0.4 > below.pose.position.y
    assert above.color == below.color == drawing.own_colour(3, WORDS_SATURATION)


def test_the_frame_of_a_stop_says_what_all_robots_wait_for():
    stopped = robot(state=FleetRobot.IDLE, waits_for='the fleet is stopped',
                    waits_for_code=WaitCode.RESUME_FLEET)
    assert words_of(stopped, 0.0) == 'agv_1  50 %\nidle'


def test_a_stop_is_a_red_frame_and_words_that_stay_above_the_buttons():
    stop = FleetStop(StopCause.PERSON, 'anna (page)', 1e9)
    frame, words = stop_markers(GRAPH, stop, 1e9 + 60.0)
    assert frame.color == words.color == RED
    assert min(point.x for point in frame.points) < 0.0 < 6.0 < max(p.x for p in frame.points)
    assert 'The fleet is stopped since' in ' '.join(words.text.split())
    assert 'by anna (page).' in ' '.join(words.text.split())
    lines = len(words.text.splitlines())
    assert words.pose.position.y - stop_picture.TEXT_HEIGHT * lines / 2.0 > (
        max(vertex.y for vertex in GRAPH.vertices.values()) + BUTTON_ABOVE + BUTTON[1] / 2.0)
    assert stop_markers(GRAPH, NOT_STOPPED, 1e9) == []


@pytest.mark.parametrize('graph', [GRAPH, laboratory()])
def test_a_sentence_above_the_graph_is_whole_and_beside_the_buttons(graph):
    sentence = ('Mission 2079814056 needs a person: step 1 (handshake) of stop 1 needs an answer: '
                'it has not ended within 120 s. Say `mission answer 2079814056 '
                'retry|skip|fail|done`')
    marker = sentence_marker(graph, sentence)
    lines = marker.text.splitlines()
    assert ' '.join(lines) == sentence and len(lines) <= LINES
    half = max(map(len, lines)) * marker.scale.z * LETTER / 2.0
    buttons = min(vertex.x for vertex in graph.vertices.values()) + 2.0 * BUTTON[0] + 0.3
    assert marker.pose.position.x - half > buttons


def plan(*drives):
    """Returns a plan of agv_1. Each drive is an edge and whether it is released.

    Released edges come first.
    """
    return FleetPlan(plans=[RobotPlan('agv_1', PlannedDrives(edges=[edge for edge, _ in drives]),
                                      sum(released for _, released in drives))])


def test_plan_and_released_part_are_told_apart_in_the_robots_colour():
    state = FleetState(robots=[robot(state=FleetRobot.BUSY, has_mission=True, destination=4)])
    driven = plan((1, True), (2, False), (3, False))
    markers = plan_markers(GRAPH, driven, state, {'agv_1': 5})
    thick, thin = named(markers, 'released')[0], named(markers, 'plans')[0]
    assert thick.scale.x > thin.scale.x
    assert thick.color == thin.color == drawing.own_colour(5)
    assert max(point.x for point in thick.points) == 2.0
    assert named(markers, 'destinations')


def test_what_a_robot_that_obeys_nobody_holds_is_blocked():
    state = FleetState(robots=[robot(state=FleetRobot.OFFLINE)])
    markers = plan_markers(GRAPH, plan((1, True), (2, True), (3, False)), state, {})
    xs = [point.x for point in named(markers, 'blocked')[0].points]
    assert (min(xs), max(xs)) == (0.0, 4.0)
    assert not named(markers, 'released')


def test_colours_of_the_first_eight_robots_differ_clearly():
    paints = [drawing.own_colour(number) for number in range(8)]
    nearest = min(math.dist((a.r, a.g, a.b), (b.r, b.g, b.b))
                  for i, a in enumerate(paints) for b in paints[:i])
    assert nearest > 0.2


def test_letters_that_rviz_lacks_do_not_hide_a_text():
    assert drawing.text('n', 0, 'K\u00fcche \u4e2d', (0.0, 0.0), 0.3, RED).text == 'K\u00fcche ?'


def deleted(markers):
    return {(one.ns, one.id) for one in markers if one.action == Marker.DELETE}


def test_what_stays_is_changed_in_place():
    changes = PictureChanges()
    first = changes.to(graph_markers(GRAPH, TEXTS, {2}, [1], [4]))
    assert [one.action for one in first].count(Marker.DELETEALL) == 1
    assert first[0].action == Marker.DELETEALL  # deletes the markers of an earlier node
    second = changes.to(graph_markers(GRAPH, TEXTS, {2}, [1], [4]))
    assert {one.action for one in second} == {Marker.ADD}
    assert second == first[1:]


def test_nothing_is_left_behind_when_an_edge_opens():
    changes = PictureChanges()
    changes.to(graph_markers(GRAPH, TEXTS, {2}, [], []))
    opened = changes.to(graph_markers(GRAPH, TEXTS, (), [], []))
    assert deleted(opened) == {('closed', 0), ('closed_names', 2)}
    assert not {(one.ns, one.id) for one in opened if one.action == Marker.ADD} & deleted(opened)
    shut = changes.to(graph_markers(GRAPH, TEXTS, {2}, [], []))
    assert not deleted(shut)


def test_nothing_is_left_behind_when_a_robot_leaves():
    changes = PictureChanges()
    there = changes.to(drawn(robot(state=FleetRobot.FAILED)))
    names = {(one.ns, one.id) for one in there if one.action == Marker.ADD}
    assert names == {(part, 3) for part in ('bodies', 'noses', 'names', 'outlines')}
    assert deleted(changes.to([])) == names


def test_a_plan_that_is_driven_goes_and_those_of_others_stay():
    changes = PictureChanges()
    state = FleetState(robots=[robot(state=FleetRobot.BUSY)])
    changes.to(plan_markers(GRAPH, plan((1, True), (2, False)), state, {'agv_1': 5}))
    after = changes.to(plan_markers(GRAPH, plan((1, True)), state, {'agv_1': 5}))
    assert deleted(after) == {('plans', 5)}
    assert named(after, 'released')[-1].action == Marker.ADD


def test_who_looks_first_sees_nothing_of_before():
    changes = PictureChanges()
    changes.to(drawn(robot()))
    assert changes.to(drawn(robot()), afresh=True)[0].action == Marker.DELETEALL
