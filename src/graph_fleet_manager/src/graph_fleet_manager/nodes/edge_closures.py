"""The topics of graph_server about closed edges."""
from __future__ import annotations

import threading
from dataclasses import replace
from typing import Callable, Container, FrozenSet, Iterable, List, Optional

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from fleet_core.site.closures import Closures, EdgeAction, OutOfDate, Repeated
from graph_fleet_manager.messages.graphs import WrongCommand, closed_edges_message, edge_operation
from itrci_nav_msgs.msg import ClosedEdges, EdgeCommand
from trajectory_graph import Graph
from trajectory_graph.drawn_names import drawn_ids
from trajectory_graph.id_lists import listed

_COMMANDS_KEPT = 1000  # commands queued for one connection, because none may be lost
_NAME = 100            # characters of the name of a person or program, in the log


class EdgeClosures:
    """Takes commands, stores the closed edges, and publishes them.

    lock    -- lock of the graph in force, so that commands and new graphs come one after the other
    graph   -- returns the graph in force; None: there is none
    changed -- called after each command that was carried out
    """

    def __init__(self, closures: Closures, lock: threading.RLock,
                 graph: Callable[[], Optional[Graph]], changed: Callable[[], None]) -> None:
        self._closures, self._lock, self._graph, self._changed = closures, lock, graph, changed
        self._subscribers: List[rospy.Subscriber] = []
        self._in_force = rospy.Publisher('/closed_edges_in_force', ClosedEdges, queue_size=1,
                                         latch=True)

    @property
    def edges(self) -> FrozenSet[int]:
        """Ids of the closed edges."""
        return self._closures.edges

    def listen(self) -> None:
        """Subscribes to the commands."""
        self._subscribers = [
            rospy.Subscriber('/edge_command', EdgeCommand, self._on_command,
                             queue_size=_COMMANDS_KEPT),
            rospy.Subscriber('/closed_edges', ClosedEdges, self._on_list, queue_size=10)]

    def use_graph(self, graph: Graph) -> None:
        """Removes closed edges that the new graph does not have."""
        try:
            gone = self._closures.forget_all_but(graph.edges)
        except OSError as error:
            rospy.logerr('The closed edges cannot be written to the disk, so closed edges that the '
                         'graph does not have will come back: %s', error)
            return
        if gone:
            rospy.logwarn('Closed edges %s are not in the graph and are forgotten.',
                          listed(sorted(gone)))

    def publish(self) -> None:
        """Publishes the closed edges."""
        self._in_force.publish(closed_edges_message(self._closures))

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Fills in the status for /diagnostics: the closed edges."""
        status.summary(DiagnosticStatus.OK, self._names(self.edges))

    def _on_command(self, message: EdgeCommand) -> None:
        sender = str(message._connection_header['callerid'])
        by = message.requested_by[:_NAME] or sender
        try:
            operation = edge_operation(message, sender)
        except WrongCommand as error:
            rospy.logwarn('%s It came from %r.', error, by)
            return
        closes = operation.action is EdgeAction.CLOSE
        try:
            with self._lock:
                operation = replace(operation, edges=self._whole(operation.edges))
                unknown = self._closures.apply(operation, rospy.Time.now().to_nsec(),
                                               self._known)
                self.publish()
        except Repeated:
            rospy.loginfo('A message of %r came again; it was carried out before.', by)
            return
        except OSError as error:
            _log_full(error)
            return
        rospy.loginfo('%r %s edges: %s.', by, 'closes' if closes else 'opens',
                      self._names(operation.edges - unknown))
        self._conclude(unknown, 'closed' if closes else 'opened')

    def _on_list(self, message: ClosedEdges) -> None:
        stamp = message.header.stamp
        try:
            with self._lock:
                unknown = self._closures.replace(self._whole(message.edges), stamp.to_nsec(),
                                                 rospy.Time.now().to_nsec(), self._known)
                self.publish()
        except OutOfDate as late:  # also if a publisher reconnects and repeats a latched list
            rospy.logwarn('A list of closed edges with stamp %.3f s is not used: it is not newer '
                          'than the last change, at %.3f s. Use /edge_command, which ignores the '
                          'stamp.',
                          stamp.to_sec(), late.stamp / 1e9)
            return
        except OSError as error:
            _log_full(error)
            return
        self._conclude(unknown, 'closed')

    def _conclude(self, unknown: FrozenSet[int], what: str) -> None:
        rospy.loginfo('Closed edges: %s.', self._names(self.edges))
        if unknown:
            rospy.logwarn('Edges %s are to be %s, but the graph does not have them.',
                          listed(sorted(unknown)), what)
        self._changed()

    @property
    def _known(self) -> Optional[Container[int]]:
        graph = self._graph()
        return None if graph is None else graph.edges

    def _whole(self, edges: Iterable[int]) -> FrozenSet[int]:
        graph = self._graph()
        return frozenset(map(abs, edges)) if graph is None else graph.whole_edges(edges)

    def _names(self, edges: FrozenSet[int]) -> str:
        """Returns the closed edges as a person has drawn them."""
        graph = self._graph()
        return listed(sorted(edges if graph is None else drawn_ids(graph, edges))) or 'none'


def _log_full(error: OSError) -> None:
    rospy.logerr('The closed edges cannot be written to the disk, so nothing is changed: %s', error)
