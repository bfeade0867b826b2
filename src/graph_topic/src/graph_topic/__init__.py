"""Follows the valid trajectory graph of the fleet on `/graph`.

Subscribes
    /graph (itrci_nav_msgs/Graph, latched): the fleet's graph
"""
from __future__ import annotations

from typing import Callable, Optional

import rospy

from itrci_nav_msgs.msg import Graph as GraphMessage
from node_lifecycle.bounded_messages import when_too_large
from trajectory_graph import Graph, GraphError
from trajectory_graph.messages import graph_from_message

REFUSALS_TOLD = 10.0  # s between two log lines about refused messages
OnGraph = Callable[[Graph, rospy.Time], None]


class FollowedGraph:
    """Keeps the graph in force: the graph of the last valid message or, before that, `graph`.

    A message without a valid graph is refused with a warning, and the graph in force stays.

    on_graph   -- called in a thread of ROS with each new graph and the stamp of its message
    graph      -- the graph in force before the first message
    each       -- whether `on_graph` is also called if a valid message has the same graph again
    on_refused -- called with the reason why a message is refused
    """

    def __init__(self, on_graph: OnGraph, graph: Optional[Graph] = None, *, each: bool = False,
                 on_refused: Optional[Callable[[str], None]] = None) -> None:
        self.graph = graph
        self._on_graph = on_graph
        self._each = each
        self._on_refused = on_refused

    def subscribe(self) -> rospy.Subscriber:
        """Follows `/graph` from now on."""
        subscriber = rospy.Subscriber('/graph', GraphMessage, self.receive, queue_size=1)
        when_too_large(subscriber.resolved_name, self._refuse)
        return subscriber

    def receive(self, message: GraphMessage) -> None:
        """Puts the graph of a message in force."""
        try:
            graph = graph_from_message(message)
        except GraphError as error:
            self._refuse(str(error))
            return
        if self.graph is None or not graph.is_same(self.graph):
            self.graph = graph
        elif not self._each:
            return
        self._on_graph(self.graph, message.header.stamp)

    def _refuse(self, problem: str) -> None:
        if self._on_refused is not None:
            self._on_refused(problem)
        rospy.logwarn_throttle(REFUSALS_TOLD, 'A /graph is refused, the one in force stays: %s',
                               problem)
