"""The graph in force changes only when another graph arrives."""
from __future__ import annotations

import io
import re
import struct
from pathlib import Path
from typing import List

import pytest
import rospy
from rospy.impl.tcpros_base import TCPROSTransportProtocol
from rospy.impl.tcpros_pubsub import TCPROSSub

from graph_topic import FollowedGraph
from itrci_nav_msgs.msg import Edge, Vertex
from itrci_nav_msgs.msg import Graph as GraphMessage
from node_lifecycle import bounded_messages
from node_lifecycle.bounded_messages import leaving_out
from node_lifecycle.message_limits import limit_of
from trajectory_graph import Graph
from trajectory_graph.messages import graph_from_message

SOURCES = Path(__file__).resolve().parents[3]


@pytest.fixture
def refusals(monkeypatch) -> list:
    said: List[str] = []
    monkeypatch.setattr(rospy, 'logwarn_throttle',
                        lambda period, text, *values: said.append(text % values))
    return said


def message(length: float = 4.0, edges: int = 1) -> GraphMessage:
    """Returns a graph: two vertices `length` m apart, and this number of edges between them."""
    return GraphMessage(
        vertices=[Vertex(id=1, frame_id='map/nn0'), Vertex(id=2, frame_id='map/nn0', x=length)],
        edges=[Edge(id=id, origin_id=1, destination_id=2, curve_type='line')
               for id in range(1, edges + 1)])


def received(sent: GraphMessage) -> GraphMessage:
    buffer = io.BytesIO()
    sent.serialize(buffer)
    return GraphMessage().deserialize(buffer.getvalue())


def test_the_first_graph_and_every_other_one_is_told():
    told: List[Graph] = []
    followed = FollowedGraph(lambda graph, stamp: told.append(graph))
    for length in (4.0, 5.0):
        followed.receive(received(message(length)))
        assert followed.graph is told[-1]
        assert told[-1].vertex(2).x == length
    assert len(told) == 2


def test_a_graph_that_is_in_force_already_is_no_news():
    told: List[Graph] = []
    from_file = graph_from_message(message())
    followed = FollowedGraph(lambda graph, stamp: told.append(graph), from_file)
    for _ in range(3):
        followed.receive(received(message()))
    assert told == []
    assert followed.graph is from_file, 'an equal graph must not be kept beside the first'


def test_a_graph_that_is_not_valid_is_refused_in_words(refusals):
    told: List[Graph] = []
    reasons: List[str] = []
    followed = FollowedGraph(lambda graph, stamp: told.append(graph),
                             graph_from_message(message()), on_refused=reasons.append)
    followed.receive(received(message(0.0)))
    assert told == [] and followed.graph.vertex(2).x == 4.0
    assert 'which are at the same place' in refusals[0]
    assert 'which are at the same place' in reasons[0]


def test_a_message_that_is_too_large_is_refused_in_words(refusals, monkeypatch):
    monkeypatch.setattr(rospy, 'Subscriber', TCPROSSub)
    monkeypatch.setattr(TCPROSSub, '__init__', lambda self, topic, kind, *_, **__: (
        TCPROSTransportProtocol.__init__(self, topic, kind)))
    monkeypatch.setattr(bounded_messages, '_told', {})
    reasons: List[str] = []
    subscriber = FollowedGraph(lambda graph, stamp: pytest.fail('the graph was accepted'),
                               on_refused=reasons.append).subscribe()
    stream = io.BytesIO()
    stream.write(struct.pack('<I', limit_of(GraphMessage._type) + 1))
    messages: List[GraphMessage] = []
    leaving_out(TCPROSTransportProtocol.read_messages)(subscriber, stream, messages, None)
    assert reasons == ['it has 4194305 bytes, and at most 4194304 are read'] and not messages
    assert reasons[0] in refusals[0]


def test_each_message_is_told_with_its_stamp_where_that_is_asked_for():
    told: List[tuple] = []
    followed = FollowedGraph(lambda graph, stamp: told.append((graph, stamp.secs)), each=True)
    for second in (1, 2):
        sent = message()
        sent.header.stamp.secs = second
        followed.receive(received(sent))
    assert told == [(followed.graph, 1), (followed.graph, 2)]
    assert told[0][0] is told[1][0]


def test_all_followers_of_the_topic_are_this_one():
    followers = {file.relative_to(SOURCES).parts[0]: text for file in SOURCES.glob('*/src/**/*.py')
                 for text in (file.read_text(),)
                 if re.search(r"(Subscriber|listen)\('/graph'|^ +\('/graph', ", text, re.M)}
    assert set(followers) == {'graph_topic'}
