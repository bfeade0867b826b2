"""Second nodes at the place of the last node: a master adds actions for a robot that stands there.

VDA 5050 3.0.0, 6.1.2, figure 7: the update repeats the decision point, and adds a node with
sequenceId + 2 at the same place.
"""
from __future__ import annotations

from typing import Any, Dict, Optional, Sequence

import pytest
from vda_builders import STANDING, Lab, abilities, say, way
from vda_builders import lab as laboratory

from vda5050_bench.track import Track
from vda5050_protocol.codec_3 import CODECS
from vda5050_vehicle.drivers.order_graph import Matching
from vda5050_vehicle.drivers.pose_driver import PoseDriver
from vda5050_vehicle.drivers.robot_view import RobotPose

HALL = way(8, 10, 12)
VERSIONS = pytest.mark.parametrize('version', sorted(CODECS))


def second(vertex: int, name: Optional[str] = None) -> Track:
    """Returns a track of two nodes at the same place."""
    stop = way(vertex, 10 if vertex != 10 else 12).stops[0]
    other = stop if name is None else type(stop)(name, stop.x, stop.y)
    return Track((stop, other), ('here',), ('here',))


def with_actions(order: Dict[str, Any], node: int, *actions: Dict[str, Any]) -> Dict[str, Any]:
    """Gives the order these actions at one of its nodes; returns the order."""
    order['nodes'][node]['actions'] = list(actions)
    return order


@VERSIONS
@pytest.mark.parametrize('name', [None, 'another name'])
def test_actions_are_added_where_the_robot_stands_at_the_end_of_its_base(version, name):
    lab = Lab(codec=CODECS[version])
    lab.order(HALL.order('o', actions={'12': [say('before')]}))
    lab.drive(2)
    lab.end_action('before')
    routes = list(lab.robot.routes)
    lab.order(with_actions(with_actions(second(12, name).order('o', 1, first_sequence=4),
                                        0, say('before')), 1, say('now', 'HARD')))
    assert lab.errors == []
    lab.wait(0.1)
    assert lab.started == ['before', 'now'], 'what was done at the decision point is not repeated'
    assert (lab.nodes, lab.state['lastNodeId'], lab.state['lastNodeSequenceId']) == (
        [], name or '12', 6)
    lab.end_action('now')
    assert lab.status('now') == 'FINISHED'
    assert lab.robot.routes == routes, 'the robot has nothing to drive'


@VERSIONS
def test_the_robot_drives_on_after_the_action_at_the_second_node(version):
    lab = Lab(codec=CODECS[version])
    lab.order(HALL.order('o', base=2))
    lab.drive(1)
    lab.order(with_actions(second(10).order('o', 1, first_sequence=2), 1, say('now', 'HARD')))
    lab.wait(0.1)
    assert lab.started == ['now']
    lab.order(HALL.part(1).order('o', 2, first_sequence=4))
    assert lab.errors == []
    lab.wait(2.0)
    assert not lab.robot.drives, 'it waits for the action'
    lab.end_action('now')
    lab.wait(0.1)
    lab.drive(1)
    assert (lab.state['lastNodeId'], lab.state['lastNodeSequenceId'], lab.nodes) == ('12', 6, [])


def doubled(*vertices: int) -> Track:
    """Returns a track over the vertices. A repeated vertex is a second node at its place."""
    parts = [way(start, end) if start != end else second(start)
             for start, end in zip(vertices, vertices[1:])]
    return Track((parts[0].stops[0], *(part.stops[-1] for part in parts)),
                 tuple(edge for part in parts for edge in part.edges),
                 tuple(edge for part in parts for edge in part.edges_back))


@pytest.mark.parametrize('vertices', [(8, 8, 10), (8, 10, 10, 12), (8, 10, 10, 10, 12, 12)])
@pytest.mark.parametrize('blocking', ['NONE', 'HARD'])
def test_second_nodes_anywhere_in_an_order_are_passed_in_its_sequence(vertices, blocking):
    lab = Lab()
    track = doubled(*vertices)
    order = track.order('o')
    for number, node in enumerate(order['nodes']):
        node['actions'] = [say(f'a{number}', blocking)]
    lab.order(order)
    assert lab.errors == []
    for _ in range(200):
        if not lab.state['nodeStates'] and len(lab.started) == len(vertices):
            break
        for action_id in lab.started:
            lab.end_action(action_id)
        if lab.robot.drives and lab.view.velocity is not None:
            lab.drive(1)
        lab.wait(0.1)
    assert lab.started == [f'a{number}' for number in range(len(vertices))]
    assert lab.state['lastNodeSequenceId'] == 2 * (len(vertices) - 1)
    driven = [vertex for vertex, before in zip(vertices[1:], vertices) if vertex != before]
    assert lab.state['lastNodeId'] == str(driven[-1])


def test_a_paused_robot_does_not_pass_the_second_node():
    lab = Lab()
    lab.order(HALL.part(0, 0).order('o'))
    lab.act('startPause')
    lab.settle()
    lab.order(with_actions(second(8).order('o', 1), 1, say('now')))
    lab.wait(2.0)
    assert (lab.nodes, lab.started) == (['8'], [])
    lab.act('stopPause')
    assert (lab.nodes, lab.started) == ([], ['now'])


def test_the_actions_of_the_edge_between_them_are_done():
    lab = Lab()
    order = second(8).order('o')
    order['edges'][0]['actions'] = [say('edge')]
    lab.order(order)
    assert (lab.nodes, lab.started) == (['8'], ['edge'])
    lab.end_action('edge')
    assert (lab.nodes, lab.status('edge')) == ([], 'FINISHED')


def test_a_restarted_adapter_goes_on_at_the_second_node():
    lab = Lab()
    lab.order(doubled(8, 10, 10, 12).order('o'))
    lab.drive(1)
    lab = lab.restarted()
    lab.wait(0.5)
    lab.drive(1)
    assert (lab.state['lastNodeId'], lab.nodes) == ('12', [])


def test_a_second_node_of_the_horizon_is_not_passed():
    lab = Lab()
    lab.order(second(8).order('o', base=1))
    lab.wait(1.0)
    assert lab.nodes == ['8']


def test_a_robot_with_move_base_passes_a_second_node_without_a_goal():
    lab = Lab(at=None, driver=lambda memory: PoseDriver(memory, abilities(), Matching()))
    x, y = laboratory().vertex(8).position
    lab.see(pose=RobotPose(x, y, 0.0), velocity=STANDING)
    lab.robot.arrive = goals(lab)
    lab.order(with_actions(second(8).order('o'), 1, say('now', 'HARD')))
    assert (lab.nodes, lab.started, lab.goals) == ([], ['now'], [])


def goals(lab: Any) -> Any:
    """Collects the goals of a pose driver."""
    lab.goals = []
    return lab.goals.append


# --- the longest order ----------------------------------------------------------------------------

def back_and_forth(edges: int) -> Sequence[int]:
    """Returns the vertices of a track with this number of edges between two vertices."""
    return [(8, 10)[number % 2] for number in range(edges + 1)]


def long_way(edges: int) -> Track:
    """Returns a track with this number of edges."""
    there, back = way(8, 10), way(10, 8)
    vertices = back_and_forth(edges)
    return Track(tuple(there.stops[(8, 10).index(vertex)] for vertex in vertices),
                 tuple((there if vertex == 8 else back).edges[0] for vertex in vertices[:-1]),
                 tuple((back if vertex == 8 else there).edges[0] for vertex in vertices[:-1]))


def test_the_longest_base_is_driven_and_a_longer_one_is_refused_before_the_robot_moves():
    lab = Lab()
    lab.order(long_way(lab.driver.longest + 1).order('o'))
    assert lab.errors == ['orderError']
    assert f'at most {lab.driver.longest}' in lab.state['errors'][0]['errorDescription']
    assert not lab.robot.routes
    lab.order(long_way(lab.driver.longest).order('p'))
    assert (lab.errors, len(lab.robot.route)) == ([], lab.driver.longest)


def test_a_long_horizon_does_not_count():
    lab = Lab()
    lab.order(long_way(lab.driver.longest + 1).order('o', base=3))
    assert (lab.errors, len(lab.robot.route)) == ([], 2)


def test_an_order_that_grows_by_updates_is_refused_in_time_and_never_fails_under_way():
    """The route of an order has all edges since its start, and a robot takes at most 1,000 edges.

    Here the limit is 20 edges, so that the test is short.
    """
    lab = Lab()
    lab.driver.longest, first, rest, more = 20, 12, 8, 2
    lab.order(long_way(first).order('o'))
    lab.drive(first)
    lab.order(long_way(rest).order('o', 1, first_sequence=2 * first))
    assert lab.errors == []
    lab.drive(rest)
    last = lab.state['lastNodeSequenceId']
    lab.order(long_way(more).order('o', 2, first_sequence=last))
    assert lab.errors == ['orderUpdateError']
    assert f'at most {first + rest} in' in lab.state['errors'][0]['errorDescription']
    lab.order(way(8, 10).order('next'))
    assert lab.errors == []
    lab.drive(1)
    assert (lab.nodes, lab.errors) == ([], [])
