"""The messages that subscribers of the edited graph receive during editing."""
from __future__ import annotations

import pytest

from graph_editor.nodes import graph_topic
from graph_editor.nodes.graph_topic import GraphTopic
from trajectory_graph import Edge, Graph, Vertex, editing
from trajectory_graph.editing import Draft
from trajectory_graph.messages import graph_from_message


@pytest.fixture
def sent(monkeypatch) -> list:
    messages = []

    class Publisher:
        def __init__(self, *_, **__) -> None:
            self.publish = messages.append
    monkeypatch.setattr(graph_topic.rospy, 'Publisher', Publisher)
    monkeypatch.setattr(graph_topic.rospy.Time, 'now', lambda: graph_topic.rospy.Time(1))
    return messages


@pytest.fixture
def draft() -> Draft:
    vertices = [Vertex(id, 2.0 * id, 0.0, 0.0, label=f'place {id}') for id in (1, 2, 3)]
    return Draft.of(Graph(vertices, [Edge(1, 1, 2, velocity_forward=1.0),
                                     Edge(2, 2, 3, velocity_backwards=0.5)]))


def test_each_draft_is_told_whole(sent, draft):
    topic = GraphTopic('graph_editor/graph')
    for step in (draft, editing.move_vertex(draft, 3, 5.0, 1.0), editing.delete_edge(draft, 2)):
        topic.publish(step)
    assert len(sent) == 2, 'a draft with an isolated vertex is not valid'
    for message, step in zip(sent, (draft, editing.move_vertex(draft, 3, 5.0, 1.0))):
        told = graph_from_message(message)
        assert dict(told.vertices) == dict(step.vertices)
        assert dict(told.edges) == dict(step.edges)


def test_elements_that_are_gone_are_not_told_any_more(sent, draft):
    topic = GraphTopic('graph_editor/graph')
    topic.publish(draft)
    topic.publish(editing.delete_vertex(draft, 3))
    assert [vertex.id for vertex in sent[-1].vertices] == [1, 2]
    assert [edge.id for edge in sent[-1].edges] == [1]


def test_what_stays_the_same_keeps_its_message(sent, draft):
    topic = GraphTopic('graph_editor/graph')
    topic.publish(draft)
    topic.publish(editing.move_vertex(draft, 3, 5.0, 1.0))
    kept = [one is other for one, other in zip(sent[0].vertices, sent[1].vertices)]
    assert kept == [True, True, False]
    assert sent[0].vertices[2].x == 6.0, 'an earlier message must not change'
