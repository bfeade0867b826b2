"""The graph in force changes when another one comes, and only then."""
from __future__ import annotations

import io
from typing import List

import pytest
import rospy

from itrci_nav_msgs.msg import Edge, Vertex
from omron_ld90.nodes.support import followed_graph
from omron_ld90.nodes.support.followed_graph import BoundedGraphMessage, FollowedGraph
from trajectory_graph import Graph
from trajectory_graph.messages import graph_from_message


@pytest.fixture
def refusals(monkeypatch) -> list:
    said: List[str] = []
    monkeypatch.setattr(rospy, 'logwarn_throttle',
                        lambda period, text, *values: said.append(text % values))
    return said


def message(length: float = 4.0, edges: int = 1) -> BoundedGraphMessage:
    """Two vertices `length` m apart and so many edges between them."""
    return BoundedGraphMessage(
        vertices=[Vertex(id=1, frame_id='map/nn0'), Vertex(id=2, frame_id='map/nn0', x=length)],
        edges=[Edge(id=id, origin_id=1, destination_id=2, curve_type='line')
               for id in range(1, edges + 1)])


def received(sent: BoundedGraphMessage) -> BoundedGraphMessage:
    buffer = io.BytesIO()
    sent.serialize(buffer)
    return BoundedGraphMessage().deserialize(buffer.getvalue())


def test_the_first_graph_and_every_other_one_is_told():
    told: List[Graph] = []
    followed = FollowedGraph(None, told.append)
    for length in (4.0, 5.0):
        followed.take(received(message(length)))
        assert followed.graph is told[-1]
        assert told[-1].vertex(2).x == length
    assert len(told) == 2


def test_a_graph_that_is_in_force_already_is_no_news():
    told: List[Graph] = []
    from_file = graph_from_message(message())
    followed = FollowedGraph(from_file, told.append)
    for _ in range(3):
        followed.take(received(message()))
    assert told == []
    assert followed.graph is from_file, 'an equal graph must not be kept beside the first'


def test_a_graph_that_is_not_valid_is_refused_in_words(refusals):
    told: List[Graph] = []
    followed = FollowedGraph(graph_from_message(message()), told.append)
    followed.take(received(message(0.0)))
    assert told == [] and followed.graph.vertex(2).x == 4.0
    assert 'which are at the same place' in refusals[0]


def test_a_message_that_is_too_large_is_not_even_read(refusals, monkeypatch):
    monkeypatch.setattr(followed_graph, 'MAX_BYTES', 1000)
    huge = received(message(edges=100))
    assert (huge.edges, huge.vertices) == ([], [])
    FollowedGraph(None, pytest.fail).take(huge)
    assert 'more than 1000 bytes' in refusals[0]
