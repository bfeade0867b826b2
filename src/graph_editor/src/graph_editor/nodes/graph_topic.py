"""Publishes drafts as messages, for the subscribers of a graph."""
from __future__ import annotations

from typing import Any, Dict, Mapping, Tuple

import rospy

from itrci_nav_msgs.msg import Edge, Graph, Vertex
from rviz_drawing.drawing import FRAME
from trajectory_graph import GraphError
from trajectory_graph.editing import Draft
from trajectory_graph.messages import edge_message, vertex_message

Made = Dict[int, Tuple[Any, Any]]
"""The elements and their messages, by id."""


class GraphTopic:
    """Publishes drafts on a latched topic. An unchanged element keeps its message.

    During a drag, drafts are published four times a second. If each draft needed 1,500 new
    messages, the editor would react to the mouse with a delay.
    """

    def __init__(self, name: str) -> None:
        self._publisher = rospy.Publisher(name, Graph, queue_size=1, latch=True)
        self._vertices: Made = {}
        self._edges: Made = {}

    def publish(self, draft: Draft) -> None:
        """Publishes a valid draft. Ignores an invalid draft, so that subscribers keep the last
        valid one.
        """
        try:
            draft.graph()
        except GraphError:
            return
        self._vertices = _made(draft.vertices, self._vertices, vertex_message, Vertex)
        self._edges = _made(draft.edges, self._edges, edge_message, Edge)
        message = Graph(vertices=[one for _, one in self._vertices.values()],
                        edges=[one for _, one in self._edges.values()])
        message.header.frame_id = FRAME
        message.header.stamp = rospy.Time.now()
        self._publisher.publish(message)


def _made(elements: Mapping[int, Any], before: Made, make: Any, message_type: Any) -> Made:
    made: Made = {}
    for id, element in elements.items():
        old = before.get(id)
        made[id] = (old if old is not None and old[0] is element
                    else (element, make(element, message_type)))
    return made
