"""The trajectory graph in force: the one of `~graph_file` until `/graph` brings another.

Subscribes
    /graph (itrci_nav_msgs/Graph, latched): the fleet's graph
"""
from __future__ import annotations

from typing import Callable, Optional

import rospy

from itrci_nav_msgs.msg import Graph as GraphMessage
from trajectory_graph import Graph, GraphError
from trajectory_graph.messages import graph_from_message

MAX_BYTES = 4 * 2**20  # of a message: some 60,000 vertices and edges
REFUSALS_TOLD = 10.0  # s between two words about them


class BoundedGraphMessage(GraphMessage):
    """A Graph message that is left empty, and says so, where it is too large to be a graph."""

    too_large = False

    def deserialize(self, str: bytes) -> GraphMessage:  # noqa: A002  genpy's name
        """Read the message, if it is of a reasonable size."""
        self.too_large = len(str) > MAX_BYTES
        return self if self.too_large else super().deserialize(str)


class FollowedGraph:
    """Calls `on_graph(graph)` whenever another graph is in force; a republished one is no news.

    `graph` is the one in force, None before there is any. A graph that is not valid is refused
    with a warning, and the one in force stays. `on_graph` runs in a thread of the subscriber.
    """

    def __init__(self, graph: Optional[Graph], on_graph: Callable[[Graph], None]) -> None:
        self.graph = graph
        self._on_graph = on_graph

    def subscribe(self) -> rospy.Subscriber:
        """Follow `/graph` from now on."""
        return rospy.Subscriber('/graph', BoundedGraphMessage, self.take, queue_size=1)

    def take(self, message: BoundedGraphMessage) -> None:
        """Put the graph of a message in force."""
        if message.too_large:
            _refuse(f'it has more than {MAX_BYTES} bytes')
            return
        try:
            graph = graph_from_message(message)
        except GraphError as error:
            _refuse(str(error))
            return
        if not graph.is_same(self.graph):
            self.graph = graph
            self._on_graph(graph)


def _refuse(problem: str) -> None:
    rospy.logwarn_throttle(REFUSALS_TOLD, 'A /graph is refused, the one in force stays: %s',
                           problem)
